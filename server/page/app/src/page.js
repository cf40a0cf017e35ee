// The page at /: scenes, the view, and the console that shows each gesture as a request.

import {Problem, ask, askJson, post, scenePath} from "./api.js";
import {asCurl, asJavaScript, asPython} from "./copies.js";
import {byId, bytesText, copyText, countText, make} from "./dom.js";
import {firstPiece, loadGeometry} from "./geometry.js";
import {Gestures, snap} from "./gestures.js";
import {drawHeat} from "./heat.js";
import {askForKey} from "./key.js";
import {changeOf, readLink, writeLink} from "./link.js";
import {Marks} from "./marks.js";
import {QUESTIONS, cutOf, isViewshed, length, outcomeOf, planeOf, pretty, shapesOf, short, visitRows} from "./questions.js";
import {coloursOf, plyOf, pointsOf} from "./scan.js";
import {Scenes} from "./scenes.js";
import {Traced} from "./traced.js";
import {View} from "./view.js";

// What a browser is sent; of larger scenes the server traces pictures.
const MOST_BYTES = 256 << 20, MOST_TRIANGLES = 8e6;

let view, marks, gestures, scenes, traced;
let shown = null;     // the scene as GET /v1/scenes/{id} tells it
let loading = null;   // AbortController of its geometry
let opening = 0;      // links that are being opened
let lost = false;     // the scene that was shown or that a link names is not there: the user takes another
let visit = null;     // {query, answer, outline} of the last answer, if it has the boxes that a ray visited
let sweep = null;     // points of the last answer, if it is one of a LiDAR sweep
let asked = null;     // {route, body}: what the link repeats
let tracing = false;  // somebody wants pictures that the server traces, or the scene is too large
let runs = 0;

const say = (id, text) => { byId(id).textContent = text; };

/** Nothing takes a notice away. */
function fail(fault) {
  if (!fault) return notice("");
  if (fault.name === "AbortError") return;
  if (fault instanceof Problem && (fault.status === 401 || fault.status === 403)) {
    notice(fault.status === 403 ? fault.message : "");
    return askForKey(() => {
      notice("");
      begin().catch(fail);
    });
  }
  notice(fault.message);
}

function notice(text) {
  say("notice", text);
  byId("notice").hidden = !text;
}

// ---- Scenes

/** Shows a scene and loads its triangles; calls then() between the two. */
async function choose(id, link = null, then = null) {
  loading?.abort();
  loading = new AbortController();
  const {signal} = loading;
  byId("stage").removeAttribute("data-complete");
  try {
    const scene = await askJson(scenePath(id));
    if (signal.aborted) return;
    const before = shown;
    lost = false;
    shown = scene;
    scenes.current = id;
    scenes.draw();
    scenes.showNodes().catch(fail);
    showPath();
    notice(link ? changeOf(link, scene) : "");
    view.begin(scene.bounds);
    marks.show([]);
    if (link?.camera) view.pose = link.camera;
    else if (!before || before.id !== id) view.home();
    traced.use("");
    setTraced(link?.traced === "1", true);
    gestures.use(gestures.mode);
    if (!link) restart();
    then?.();
    await load(id, signal);
    saveLink();
  } catch (fault) {
    if (signal.aborted) return;
    lost = !shown;
    say("progress", "");
    fail(fault);
  }
}

async function load(id, signal) {
  say("progress", "Loading triangles");
  const of = {scene: id, eye: view.pose.slice(0, 3)};
  const first = shown.counts.triangles > MOST_TRIANGLES ? null : await firstPiece(of, signal);
  if (!first || first.bytes > MOST_BYTES) {
    say("progress", "This scene is too large to send: the server traces pictures of it.");
    byId("stage").dataset.complete = `${id} ${shown.revision}`;
    return setTraced(true);
  }
  let got = 0;
  const whole = await loadGeometry(of, first, signal, (columns) => {
    view.add(columns);
    got += columns.positions.byteLength + columns.indices.byteLength;
    say("progress", `Loading triangles: ${Math.min(99, Math.floor(100 * got / first.bytes))}%`);
  });
  if (signal.aborted) return;
  if (!whole) return choose(id);
  // Software GL shows nothing else until it has drawn them.
  const LONGEST = 500;
  await Promise.race([traced.first, new Promise((resolve) => setTimeout(resolve, LONGEST))]);
  if (signal.aborted) return;
  traced.hold();
  view.draw();
  await view.drawn();
  if (signal.aborted) return;
  showTraced();
  say("progress", "");
  byId("stage").dataset.complete = `${id} ${first.revision}`;
  byId("stage").dataset.triangles = view.triangles;
}

/** After each list of scenes: the chosen one may have gone or have another content. */
async function changed() {
  if (opening) return;
  if (!shown) {
    say("progress", scenes.all.length ? "" : "No scene yet: drop a .glb or .gltf file here.");
    if (lost) return;
    const ready = scenes.all.filter((scene) => scene.state === "ready");
    if (ready.length) await choose(ready.reduce((a, b) => b.triangles > a.triangles ? b : a).id);
    return;
  }
  const now = scenes.find(shown.id);
  if (!now) {
    loading.abort();
    notice(`The scene "${shown.id}" has been deleted.`);
    lost = true;
    shown = null;
    setTraced(false);
    scenes.current = "";
    scenes.draw();
    say("progress", "");
    clear();
    restart();
    showPath();
    view.begin(null);
    marks.show([]);
    view.draw();
    saveLink();
  } else if (now.state === "ready" && now.revision !== shown.revision) {
    await choose(now.id);
  }
}

// ---- The console

const route = () => byId("route").value;
/** Path and body of the request in the console; bvh is a GET whose body is its query. */
function request() {
  const path = scenePath(shown?.id || "SCENE", `/${route()}`), body = byId("body").value;
  if (route() !== "bvh") return [path, body];
  return [`${path}?${new URLSearchParams(JSON.parse(body))}`, null];
}

function showPath() {
  say("method", route() === "bvh" ? "GET" : "POST");
  byId("path").textContent = shown ? `/v1/scenes/${shown.id}/` : "/v1/scenes/";
}

/** Nothing asked yet of this scene. */
function restart() {
  asked = null;
  say("outcome", "Click into the scene.");
  byId("fields").replaceChildren();
  say("raw", "");
  say("timing", "");
  sweep = null;
  showSweep();
}

function fill(name, query) {
  byId("route").value = name;
  byId("body").value = pretty(query);
  showPath();
}

async function run() {
  if (!shown) return say("outcome", "There is no scene to ask.");
  const number = ++runs, name = route(), body = byId("body").value;
  byId("run").disabled = true;
  try {
    const [path, text] = request();
    const answer = await post(path, text, body.includes('"image"') ? "image/x-portable-floatmap" : "*/*");
    if (number !== runs) return;
    asked = {route: name, body};
    await show(name, body, answer);
    saveLink();
  } catch (fault) {
    fail(fault);
  } finally {
    byId("run").disabled = false;
    if (number === runs) byId("stage").dataset.answered = String(number);
  }
}

function showSweep() {
  byId("sweep").hidden = !sweep;
  const colours = sweep && coloursOf(sweep, byId("sweep-colour").value);
  view.showPoints(sweep?.positions || null, colours);
  byId("stage").dataset.points = sweep ? String(sweep.positions.length) : "0";
  byId("stage").dataset.hues = JSON.stringify(colours ? colours.map(([hue]) => hue) : []);
}

function savePly() {
  const address = URL.createObjectURL(new Blob([plyOf(sweep)], {type: "application/octet-stream"}));
  make("a", {href: address, download: `${shown.id}-sweep.ply`}).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}

/** Draws the first boxes of the visit, as many as the slider says; the last of them stands out. */
function showVisit() {
  byId("visit").hidden = !visit;
  if (!visit) return;
  const {query, answer, outline} = visit, {boxes} = answer.explain, count = Number(byId("visit-step").value);
  const explain = {...answer.explain, boxes: boxes.slice(0, count), now: count < boxes.length ? count : 0};
  marks.show([...shapesOf("rays:closest", query, {...answer, explain}, view.radius), ...outline]);
  say("visit-count", `${count} of ${boxes.length}`);
  const list = byId("fields");
  for (const [i, row] of [...list.querySelectorAll("tr")].entries()) {
    row.className = i + 1 === explain.now ? "now" : "";
    // Within the list: a phone's page stays where it is.
    if (row.className) list.scrollTop = Math.min(row.offsetTop, Math.max(list.scrollTop, row.offsetTop + row.offsetHeight - list.clientHeight));
  }
}

/** What the last answer drew beside marks. */
function clear() {
  sweep = visit = null;
  showVisit();
  view.cut(null);
  byId("heat").hidden = true;
  byId("stage").removeAttribute("data-seen");
  byId("cost-part").open = false;
  byId("cost").replaceChildren();
}

async function show(name, body, {status, text, picture, bytes, revision, milliseconds}) {
  const MOST = 200000;
  clear();
  say("raw", text.length > MOST ? `${text.slice(0, MOST)} ... and ${countText(text.length - MOST)} characters more` : text);
  say("timing", `${status}, ${milliseconds.toFixed(1)} ms, ${bytesText(bytes)}, revision ${revision ?? "unknown"}`);
  byId("fields").replaceChildren();
  if (picture) {
    marks.show([]);
    showSweep();
    return say("outcome", JSON.parse(body).image === "visits" ? showHeat(picture) : text);
  }
  const answer = JSON.parse(text);
  if (status !== 200) {
    marks.show([]);
    showSweep();
    return say("outcome", `${answer.code}: ${answer.detail}${answer.errors?.[0]?.pointer ? ` (${answer.errors[0].pointer})` : ""}`);
  }
  const query = JSON.parse(body);
  sweep = pointsOf(query, answer);
  showSweep();
  if (sweep) {
    say("outcome", `${countText(sweep.positions.length)} of ${countText(answer.distance.length)} rays hit.`);
    return marks.show([{kind: "point", points: [query.generator.position], colour: "ray", label: "sensor"}]);
  }
  say("outcome", outcomeOf(name, query, answer));
  byId("fields").append(...tables(name, answer));
  const shapes = shapesOf(name, query, answer, view.radius);
  marks.show(shapes);
  const plane = planeOf(name, query);
  if (plane) return showSection(plane, answer.results[0].triangles);
  if (isViewshed(name, query)) showSeen(query.to, answer.visible[0]);
  if (name === "bvh" && !answer.level?.boxes.length) gestures.level = -1;
  if (name === "boxes:list" && answer.results?.some(({nodes}) => nodes?.length)) {
    const asked = shapes.map((shape) => ({...shape, colour: "ray", thin: false}));
    return marks.show([...asked, ...await nodeBoxes(answer.results.flatMap(({nodes}) => nodes))]);
  }
  if (name !== "rays:closest" || !Array.isArray(answer.hits)) return;
  const around = answer.hits.length === 1 && answer.hits[0] ? await outline(answer.hits[0]) : [];
  if (around.length) marks.show([...shapes, ...around]);
  if (answer.explain) {
    visit = {query, answer, outline: around};
    byId("visit-step").value = byId("visit-step").max = answer.explain.boxes.length;
    showVisit();
  }
  if (gestures.mode === "measure" && answer.hits.length === 2 && answer.hits.every(Boolean)) await measure(answer.hits);
}

let heatPose = "";  // of the camera when it was drawn

function showHeat(picture) {
  heatPose = view.pose.join();
  byId("heat").hidden = false;
  return drawHeat(byId("heat"), picture);
}

/** Points that are seen are green, others red. */
function showSeen(points, visible) {
  const colours = points.map((_, i) => visible[i] === "1" ? [0.37, 0.85, 0.36] : [0, 0.85, 0.5]);
  view.showPoints(points, colours);
  byId("stage").dataset.seen = colours.map(([hue]) => hue > 0 ? "1" : "0").join("");
}

/** Cuts the view, and draws where the plane cuts the triangles. */
async function showSection(plane, triangles) {
  view.cut(plane);
  const AT_ONCE = 300;
  const ids = triangles.map(({instance, primitive, triangle}) => `${instance}.${primitive}.${triangle}`);
  const shapes = [];
  for (let first = 0; first < ids.length; first += AT_ONCE) {
    const {triangles: found} = await askJson(scenePath(shown.id, `/triangles?ids=${ids.slice(first, first + AT_ONCE).join(",")}`));
    shapes.push(...found.map(({corners}) => cutOf(corners, plane)).filter(Boolean).map((points) => ({kind: "line", points, thin: true, colour: "hit"})));
  }
  marks.show(shapes);
}

/** Asks the last question again with its work; what the scene's file has and was skipped stands beside it. */
async function showCost() {
  if (!byId("cost-part").open || !asked || asked.route === "bvh") return;
  const query = {...JSON.parse(asked.body), work: true};
  if (query.image) delete query.image;
  const [{text}, stats] = await Promise.all([post(scenePath(shown.id, `/${asked.route}`), JSON.stringify(query)), askJson(scenePath(shown.id, "/stats"))]);
  const {work} = JSON.parse(text);
  const skipped = Object.entries(stats.skipped).filter(([, count]) => count).map(([what, count]) => `${count} ${what}`);
  const rows = work ? Object.entries(work).filter(([key]) => key !== "microseconds").map(([key, count]) => [key.replace("_", " "), count]) : [["work", "not told"]];
  byId("cost").replaceChildren(table([...rows, ["trees built before", `${stats.trees.meshes_built} of ${stats.trees.meshes_total} meshes`],
    ["skipped in the file", skipped.join(", ") || "nothing"]]));
}

/** Boxes of nodes that are smaller than half of the scene: larger ones would hide the others. */
async function nodeBoxes(found) {
  const ids = new Set(found.map(({node_id: id}) => id));
  const nodes = await scenes.loadNodes();
  return shapesOf("boxes:list", {boxes: nodes.filter(({node_id: id, bounds}) =>
    ids.has(id) && bounds && length(bounds.min, bounds.max) < view.radius).map(({bounds}) => bounds)}, {}, view.radius);
}

/** The exact corners of hits, where their triangles are named. */
async function cornersOf(hits) {
  if (!hits.every((hit) => Number.isInteger(hit.instance) && Number.isInteger(hit.triangle))) return null;
  const ids = hits.map((hit) => `${hit.instance}.${hit.primitive}.${hit.triangle}`);
  const {triangles} = await askJson(scenePath(shown.id, `/triangles?ids=${ids.join(",")}`));
  return triangles.map(({corners}) => corners);
}

async function outline(hit) {
  const corners = await cornersOf([hit]);
  return corners ? [{kind: "loop", points: corners[0], colour: "hit"}] : [];
}

async function measure(hits) {
  const corners = await cornersOf(hits);
  const ends = hits.map((hit, i) => corners ? snap(view, hit, corners[i]) : {point: hit.position, kind: "surface"});
  const distance = length(ends[0].point, ends[1].point);
  const parts = ends[0].point.map((x, k) => Math.abs(ends[1].point[k] - x));
  say("outcome", `Distance ${distance} from ${ends[0].kind} to ${ends[1].kind}.`);
  byId("fields").replaceChildren(table([["distance", distance], ["along x, y, z", parts],
    [`from (${ends[0].kind})`, ends[0].point], [`to (${ends[1].kind})`, ends[1].point],
    ["nodes", hits.map(({node}) => node)]]));
  marks.show([{kind: "line", points: [ends[0].point, ends[1].point], label: short(distance)},
    ...ends.map(({point}) => ({kind: "point", points: [point]}))]);
}

const cell = (value) => typeof value === "string" ? value : Array.isArray(value)
  ? value.map(cell).join(", ") : value === null ? "null" : String(value);

const table = (rows) => make("table", {}, make("tbody", {}, rows.map(([name, value]) =>
  make("tr", {}, make("th", {scope: "row"}, name), make("td", {}, cell(value))))));

/** One hit as a table of its fields, lists as rows. */
function tables(name, answer) {
  const one = answer.hits?.length === 1 ? answer.hits[0] : null;
  if (answer.explain) return [table(visitRows(answer.explain))];
  if (one && typeof one === "object") return [table(Object.entries(one))];
  const list = answer.results?.length === 1 ? answer.results[0].nodes || answer.results[0].hits : null;
  if (list) {
    return [table(list.slice(0, 100).map((each) => [each.node_id ?? each.t ?? each.distance ?? "", each.node ?? JSON.stringify(each)]))];
  }
  if (answer.blockers?.[0]) return [table(Object.entries(answer.blockers[0]))];
  return [];
}

// ---- Links

let saving = 0;
function saveLink() {
  clearTimeout(saving);
  byId("stage").dataset.saving = "";
  saving = setTimeout(() => {
    delete byId("stage").dataset.saving;
    if (!shown) return history.replaceState(null, "", location.pathname);
    history.replaceState(null, "", writeLink({scene: shown.id, rev: shown.revision, sha: shown.sha256.slice(0, 16), camera: view.pose,
      mode: gestures.mode, traced: tracing ? "1" : "", ...(asked || {})}));
  }, 200);
}

async function open(link) {
  ++opening;
  try {
    await repeat(link);
  } finally {
    --opening;
  }
}

async function repeat(link) {
  setMode(link.mode || "ray");
  let ready;
  const there = await new Promise((resolve) => {
    ready = choose(link.scene, link, () => resolve(true));
    ready.then(() => resolve(false));
  });
  // The answer needs the scene, not its picture.
  if (there && link.route in QUESTIONS && link.body) {
    byId("route").value = link.route;
    byId("body").value = link.body;
    showPath();
    await run();
  }
  await ready;
}

// ---- Tools, keys and themes

function setMode(mode) {
  const buttons = [...document.querySelectorAll("#modes button")];
  if (!buttons.some((button) => button.dataset.mode === mode)) return;
  for (const button of buttons) {
    const on = button.dataset.mode === mode;
    button.setAttribute("aria-checked", String(on));
    button.tabIndex = on ? 0 : -1;
  }
  gestures.use(mode);
}

function onKey(event) {
  if (event.ctrlKey && event.key === "Enter") {
    event.preventDefault();
    return run();
  }
  if (event.target.closest("input, textarea, select") || event.ctrlKey || event.metaKey || event.altKey) return;
  const modes = [...document.querySelectorAll("#modes button")];
  if (event.key >= "1" && event.key <= "9" && modes[event.key - 1]) return setMode(modes[event.key - 1].dataset.mode);
  if (event.key === "h" || event.key === "H") return view.home();
  if (event.key === "t" || event.key === "T") return setTraced(!tracing);
  if (event.target.closest("#modes") && ["ArrowLeft", "ArrowRight"].includes(event.key)) {
    const at = modes.findIndex((button) => button.dataset.mode === gestures.mode);
    const next = modes[(at + (event.key === "ArrowRight" ? 1 : modes.length - 1)) % modes.length];
    setMode(next.dataset.mode);
    return next.focus();
  }
  if (event.target === byId("view")) onViewKey(event);
}

function onViewKey(event) {
  const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
  if (step) {
    event.preventDefault();
    if (event.shiftKey) view.pan(...step);
    else view.turn(...step);
  } else if (event.key === "+" || event.key === "=") {
    view.zoom(0.85);
  } else if (event.key === "-") {
    view.zoom(1 / 0.85);
  } else if (event.key === "Enter") {
    gestures.useCross();
  } else {
    const way = {w: [0, -1], a: [-1, 0], s: [0, 1], d: [1, 0]}[event.key.toLowerCase()], STEP = event.shiftKey ? 0.005 : 0.04;
    if (way) gestures.moveCross(STEP * way[0], STEP * way[1]);
  }
}

function setTraced(on, coming = false) {
  tracing = on;
  showTraced(coming);
  byId("traced-button").setAttribute("aria-pressed", String(on));
  if (shown) saveLink();
}

/** Pictures that the server traces stand in for triangles that are still coming. */
function showTraced(coming = false) {
  const STAND_IN = 360;  // rows of the finest
  if (tracing && shown) traced.use(shown.id);
  else traced.use(coming ? shown.id : "", STAND_IN);
}

const THEMES = ["system", "light", "dark"];
function setTheme(theme) {
  if (theme === "system") document.documentElement.removeAttribute("data-theme");
  else document.documentElement.dataset.theme = theme;
  byId("theme").textContent = `Theme: ${theme}`;
  byId("theme").dataset.value = theme;
  paint();
}

function paint() {
  view?.setBackground(getComputedStyle(document.documentElement).getPropertyValue("--sky").trim());
}

async function copy(text, label, place = "copied", before = "") {
  const done = await copyText(text);
  say(place, done ? `${label} copied` : "No copying here");
  if (!done) {
    byId("raw-part").open = true;
    say("raw", text);
    getSelection().selectAllChildren(byId("raw"));
  }
  setTimeout(() => say(place, before), 3000);
}

function wire() {
  byId("route").append(...Object.keys(QUESTIONS).map((name) => make("option", {value: name}, name)));
  byId("route").addEventListener("change", () => {
    byId("body").value = pretty(QUESTIONS[route()]);
    showPath();
  });
  byId("cost-part").addEventListener("toggle", () => showCost().catch(fail));
  byId("body").value = pretty(QUESTIONS[route()]);
  byId("run").addEventListener("click", run);
  const kinds = {curl: [asCurl, "curl"], python: [asPython, "Python"], javascript: [asJavaScript, "JavaScript"]};
  for (const button of document.querySelectorAll("[data-copy]")) {
    const [as, label] = kinds[button.dataset.copy];
    button.addEventListener("click", () => copy(as(...request()), label));
  }
  byId("sweep-colour").addEventListener("change", showSweep);
  byId("visit-step").addEventListener("input", showVisit);
  byId("save-ply").addEventListener("click", savePly);
  byId("copy-link").addEventListener("click", () => copy(location.href, "Link", "copy-link", "Copy link"));
  byId("traced-button").addEventListener("click", () => setTraced(!tracing));
  byId("home").addEventListener("click", () => view.home());
  for (const button of document.querySelectorAll("#modes button")) {
    button.addEventListener("click", () => setMode(button.dataset.mode));
  }
  byId("theme").addEventListener("click", () => setTheme(THEMES[(THEMES.indexOf(byId("theme").dataset.value || "system") + 1) % 3]));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
  addEventListener("keydown", onKey);
  addEventListener("hashchange", (event) => {
    // saveLink may have written the address since.
    const link = readLink(new URL(event.newURL).hash);
    if (link) open(link).catch(fail);
  });
}

async function begin() {
  const link = readLink(location.hash);
  const version = async () => say("server", (await askJson("/version")).version);
  await Promise.all([link && open(link), scenes.refresh(), version()]);
}

function start() {
  scenes = new Scenes({choose, changed, fail, showNode});
  try {
    view = new View(byId("view"), () => {
      marks.draw();
      traced.moved();
      if (view.pose.join() !== heatPose) byId("heat").hidden = true;
      if (shown) saveLink();
    });
  } catch {
    return notice("This browser has no WebGL, so nothing can be drawn. The API answers all the same.");
  }
  traced = new Traced(byId("traced"), view, fail);
  marks = new Marks(byId("marks"), view);
  gestures = new Gestures(byId("view"), view, marks, {
    say: (text) => say("hint", text),
    ask: (name, query) => {
      fill(name, query);
      return run();
    },
    pick: async (rays) => {
      const answer = await ask(scenePath(shown.id, "/rays:closest"), {method: "POST", headers: {"Content-Type": "application/json"},
        body: JSON.stringify({rays, fields: ["position", "normal", "node", "node_id"]})});
      return (await answer.json()).hits;
    },
    ready: () => Boolean(shown),
    fail,
  });
  wire();
  setTheme("system");
  setMode("ray");
  begin().catch(fail);
}

/** Turns around a node of the list, and outlines its box. */
function showNode(node) {
  if (!node.bounds) return;
  const {min, max} = node.bounds;
  const middle = min.map((low, k) => low / 2 + max[k] / 2);
  const size = length(min, max) / 2 || view.radius / 50;
  const pose = view.pose;
  const from = [0, 1, 2].map((k) => pose[k] - pose[k + 3]);
  const scale = 3 * size / (Math.hypot(...from) || 1);
  view.pose = [...middle.map((x, k) => x + scale * from[k]), ...middle];
  marks.show([...shapesOf("boxes:list", {boxes: [{min, max}]}, {}, size),
    {kind: "point", points: [middle], label: `${node.name || `#${node.node_id}`}: ${countText(node.triangles)} triangles`}]);
}

start();
