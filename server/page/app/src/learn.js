// The page at /learn: a ray and a box to drag, answered by POST /v1/rays-boxes.

import {post} from "./api.js";
import {byId, make} from "./dom.js";
import {askForKey} from "./key.js";
import {CASES, FORMULAS} from "./slabs.js";
import {startTree, visitTree} from "./tree.js";

const AXES = ["x", "y", "z"];
let half = 12;        // scene units from the middle of a panel to its rim

let state = null;     // {origin, direction, min, max}
let asked = 0;

function draw(name, attributes, ...children) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [attribute, value] of Object.entries(attributes)) element.setAttribute(attribute, value);
  element.append(...children);
  return element;
}

/** JSON keeps -0, which JSON.stringify loses. */
const numberText = (x) => x === null ? "null" : Object.is(x, -0) ? "-0" : String(x);
const listText = (list) => `[${list.map(numberText).join(",")}]`;
const bodyText = () => `{"rays":[{"origin":${listText(state.origin)},"direction":${listText(state.direction)}}],` +
  `"boxes":[{"min":${listText(state.min)},"max":${listText(state.max)}}],"planes":true}`;

const isFlat = () => state.min[2] === null && state.max[2] === null;
const shown = (t) => t === null ? "none" : Number.isInteger(t) ? String(t) : String(Number(t.toPrecision(6)));

// ---- Panels

class Panel {
  /** a and b are the axes to the right and up. */
  constructor(svg, a, b) {
    Object.assign(this, {svg, a, b});
    svg.addEventListener("pointerdown", (event) => this.down(event));
    svg.addEventListener("pointermove", (event) => this.move(event));
    for (const name of ["pointerup", "pointercancel"]) svg.addEventListener(name, () => { this.held = null; });
  }

  pixel(p, q) { return [120 + p * 120 / half, 120 - q * 120 / half]; }
  at(point) { return this.pixel(point[this.a], point[this.b]); }

  /** Scene units of a pointer. */
  place(event) {
    const box = this.svg.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width * 2 * half - half, half - (event.clientY - box.top) / box.height * 2 * half];
  }

  tip() {
    const {origin, direction} = state;
    const scale = half / 3 / (Math.hypot(direction[this.a], direction[this.b]) || 1);
    return [this.a, this.b].map((k) => origin[k] + scale * direction[k]);
  }

  handles() {
    const {origin, min, max} = state;
    const low = (k) => min[k] ?? -half, high = (k) => max[k] ?? half;
    return {origin: [origin[this.a], origin[this.b]], tip: this.tip(), min: [low(this.a), low(this.b)], max: [high(this.a), high(this.b)]};
  }

  down(event) {
    const [p, q] = this.place(event);
    const near = Object.entries(this.handles()).map(([name, [a, b]]) => [Math.hypot(a - p, b - q), name]).sort((a, b) => a[0] - b[0])[0];
    if (near[0] > half / 7) return;
    event.preventDefault();
    this.held = near[1];
    this.svg.setPointerCapture(event.pointerId);
  }

  move(event) {
    if (!this.held) return;
    const snap = half > 8 ? 0.5 : 0.125;
    const [p, q] = this.place(event).map((x) => Math.min(half, Math.max(-half, Math.round(x / snap) * snap)));
    const set = (list, k, value) => { if (list[k] !== null) list[k] = value; };
    if (this.held === "tip") {
      const [dx, dy] = [p - state.origin[this.a], q - state.origin[this.b]];
      if (dx === 0 && dy === 0) return;
      state.direction[this.a] = dx;
      state.direction[this.b] = dy;
    } else if (this.held === "origin") {
      state.origin[this.a] = p;
      state.origin[this.b] = q;
    } else {
      [[this.a, p], [this.b, q]].forEach(([k, value]) => {
        const other = state[this.held === "min" ? "max" : "min"][k];
        set(state[this.held], k, other === null ? value : this.held === "min" ? Math.min(value, other) : Math.max(value, other));
      });
    }
    byId("preset").value = "";
    update();
  }

  show(answer) {
    const {origin, direction, min, max} = state;
    const corner = (list, k, open) => list[k] ?? open;
    const [x0, y1] = this.pixel(corner(min, this.a, -half), corner(min, this.b, -half));
    const [x1, y0] = this.pixel(corner(max, this.a, half), corner(max, this.b, half));
    const grid = [-10, -5, -2, -1, 0, 1, 2, 5, 10].filter((x) => half > 8 ? x % 5 === 0 : Math.abs(x) < 5).flatMap((x) => [
      draw("line", {class: x ? "grid" : "axis", x1: this.pixel(x, 0)[0], x2: this.pixel(x, 0)[0], y1: 0, y2: 240}),
      draw("line", {class: x ? "grid" : "axis", y1: this.pixel(0, x)[1], y2: this.pixel(0, x)[1], x1: 0, x2: 240})]);
    const slabs = [draw("rect", {class: "slab", x: x0, y: 0, width: x1 - x0, height: 240}),
      draw("rect", {class: "slab", x: 0, y: y0, width: 240, height: y1 - y0})];
    const along = (t) => this.at(origin.map((x, k) => x + t * direction[k]));
    const far = 3 * half / (Math.hypot(direction[this.a], direction[this.b]) || 1);
    const line = (from, to, kind) => {
      const [a, b] = [along(from), along(to)];
      return draw("line", {class: kind, x1: a[0], y1: a[1], x2: b[0], y2: b[1]});
    };
    const ray = [line(0, far, answer?.hit ? "ray hit" : "ray")];
    if (answer?.hit && typeof answer.t_exit === "number") ray.push(line(Math.max(0, answer.t_enter ?? 0), Math.min(far, answer.t_exit), "inside"));
    const dots = [];
    if (answer?.hit && answer.t !== null) {
      const [cx, cy] = along(answer.t);
      dots.push(draw("circle", {class: "met", cx, cy, r: 5}));
    }
    for (const [name, [p, q]] of Object.entries(this.handles())) {
      const [cx, cy] = this.pixel(p, q);
      dots.push(draw("circle", {class: `handle ${name}`, cx, cy, r: 4.5}));
    }
    const [ox, oy] = this.pixel(...this.handles().origin);
    const label = draw("text", {class: "small", x: Math.min(ox + 8, 200), y: Math.min(oy + 14, 236)}, "origin");
    this.svg.replaceChildren(...grid, ...slabs, draw("rect", {class: "box", x: x0, y: y0, width: x1 - x0, height: y1 - y0}), ...ray, ...dots, label);
  }
}

const panels = [new Panel(byId("xy"), 0, 1), new Panel(byId("xz"), 0, 2)];

// ---- What the answer says

/** For each axis [entry, exit], or null where a parallel ray runs beside the slab. */
function slabsOf({planes}) {
  return AXES.map((_, k) => {
    const [a, b] = [planes[2 * k], planes[2 * k + 1]];
    if (state.min[k] === null && state.max[k] === null) return [-Infinity, Infinity];
    if (state.direction[k] === 0) {
      const beside = state.origin[k] < (state.min[k] ?? -Infinity) || state.origin[k] > (state.max[k] ?? Infinity);
      return beside ? null : [-Infinity, Infinity];
    }
    return [Math.min(a ?? -Infinity, b ?? -Infinity), Math.max(a ?? Infinity, b ?? Infinity)];
  });
}

function verdictOf(answer) {
  if (answer.hit) {
    const where = answer.on_surface ? "The origin lies on the box" : answer.inside ? "The origin lies in the box" : "Hit";
    const face = answer.faces?.length ? ` on face ${answer.faces.join(" and ")}` : "";
    return `${where}: t = ${shown(answer.t)}${face}. Entry ${shown(answer.t_enter)}, exit ${shown(answer.t_exit)}.`;
  }
  if (answer.miss === "behind") return `Miss: the box lies behind the origin, its exit is at t = ${shown(answer.t_exit)}.`;
  if (!Array.isArray(answer.miss)) return `Miss: ${answer.miss}.`;
  if (answer.miss.length === 1) return `Miss: the ray runs beside slab ${answer.miss[0]}.`;
  const spans = slabsOf(answer), [first, second] = answer.miss;
  const [a, b] = [spans[AXES.indexOf(first)], spans[AXES.indexOf(second)]];
  const [left, entered] = a && b && a[1] < b[0] ? [first, second] : [second, first];
  return `Miss: the ray leaves slab ${left} before it enters slab ${entered}.`;
}

function showBars(answer) {
  const spans = slabsOf(answer).slice(0, isFlat() ? 2 : 3);
  const finite = [0, ...spans.flat().filter((t) => t !== null && Number.isFinite(t))];
  const low = Math.min(...finite), high = Math.max(...finite), room = (high - low) * 0.08 || 1;
  const [from, to] = [low - room, high + room];
  const WIDTH = byId("bars").clientWidth || 480, LEFT = 52;
  const x = (t) => LEFT + (Math.min(to, Math.max(from, t)) - from) / (to - from) * (WIDTH - LEFT - 8);
  const rows = [...spans.map((span, k) => [`slab ${AXES[k]}`, span, "bar"])];
  const enter = Math.max(...spans.map((span) => span ? span[0] : Infinity)), exit = Math.min(...spans.map((span) => span ? span[1] : -Infinity));
  rows.push(["all", enter <= exit ? [enter, exit] : null, "all"]);
  const height = 26 * rows.length + 20;
  const svg = byId("bars");
  svg.setAttribute("viewBox", `0 0 ${WIDTH} ${height}`);
  svg.replaceChildren(...rows.flatMap(([name, span, kind], i) => [
    draw("text", {x: 0, y: 26 * i + 17}, name),
    ...span ? [draw("rect", {class: kind, x: x(span[0]), y: 26 * i + 5, width: Math.max(2, x(span[1]) - x(span[0])), height: 16}),
      ...span.filter(Number.isFinite).map((t, side) => draw("text", {class: "small", x: Math.min(WIDTH - 40, x(t) + (side ? -4 : 4)),
        y: 26 * i + 17, "text-anchor": side ? "end" : "start"}, shown(t)))]
      : [draw("text", {class: "small", x: LEFT + 4, y: 26 * i + 17}, "no t")]]),
  draw("line", {class: "axis", x1: x(0), x2: x(0), y1: 0, y2: height - 16}),
  draw("text", {class: "small", x: x(0), y: height - 4, "text-anchor": "middle"}, "t = 0"));
}

function showPlanes(answer) {
  const text = (t) => t === null ? "none" : Number.isFinite(t) ? shown(t) : "no limit";
  byId("planes").tBodies[0].replaceChildren(...slabsOf(answer).slice(0, isFlat() ? 2 : 3).map((span, k) => make("tr", {},
    make("th", {scope: "row"}, AXES[k]), make("td", {}, text(answer.planes[2 * k])), make("td", {}, text(answer.planes[2 * k + 1])),
    make("td", {}, span ? text(span[0]) : "never"), make("td", {}, span ? text(span[1]) : "never"))));
}

function showFormulas(answer) {
  const open = (list, none) => list.map((x) => x ?? none);
  const given = {...state, min: open(state.min, -Infinity), max: open(state.max, Infinity)};
  const exact = answer.hit ? answer.t : null;
  byId("formulas").tBodies[0].replaceChildren(...FORMULAS.map(([name, about, test, fails], i) => {
    const t = test(given), right = t === exact;
    const button = make("button", {type: "button", "data-formula": i}, "case");
    button.addEventListener("click", () => use(fails, ""));
    return make("tr", {class: right ? "" : "wrong"}, make("th", {scope: "row"}, name, make("span", {class: "about"}, ` ${about}`)),
      make("td", {}, `${t === null ? "miss" : `t = ${shown(t)}`}${right ? "" : " (wrong)"}`), make("td", {}, button));
  }));
}

function showNumbers() {
  const rows = ["origin", "direction", "min", "max"];
  byId("numbers").tBodies[0].replaceChildren(...rows.map((row) => make("tr", {}, make("th", {scope: "row"}, row), AXES.map((axis, k) => {
    const input = make("input", {type: "text", inputmode: "decimal", "aria-label": `${row} ${axis}`, value: numberText(state[row][k]), size: "6"});
    input.addEventListener("change", () => setNumber(row, k, input));
    return make("td", {}, input);
  }))));
}

function setNumber(row, k, input) {
  const text = input.value.trim();
  const value = text === "null" && (row === "min" || row === "max") ? null : Number(text);
  if (text === "" || (value !== null && !Number.isFinite(value))) {
    input.value = numberText(state[row][k]);
    return;
  }
  state[row][k] = value;
  byId("preset").value = "";
  update();
}

// ---- Asking

function use(given, name) {
  const room = 1.25 * Math.max(...[given.origin, given.min, given.max].flat().map((x) => Math.abs(x ?? 0)));
  half = Math.max(4, room);
  state = {origin: [...given.origin], direction: [...given.direction], min: [...given.min], max: [...given.max]};
  byId("preset").value = name;
  update();
}

async function update() {
  const number = ++asked, body = bodyText();
  delete byId("figure").dataset.answered;
  byId("xz-part").hidden = isFlat();
  showNumbers();
  for (const panel of panels) panel.show(null);
  try {
    const {status, text} = await post("/v1/rays-boxes", body);
    if (number !== asked) return;
    byId("request").textContent = body;
    byId("answer").textContent = text;
    const document_ = JSON.parse(text);
    byId("notice").hidden = status === 200 || status === 401;
    byId("notice").textContent = document_.detail || "";
    if (status === 401) return askForKey(() => Promise.all([update(), visitTree("both")]));
    if (status !== 200) return;
    const [answer] = document_.results;
    byId("verdict").textContent = verdictOf(answer);
    byId("verdict").className = answer.hit ? "hit" : "miss";
    for (const panel of panels) panel.show(answer);
    showBars(answer);
    showPlanes(answer);
    showFormulas(answer);
    byId("figure").dataset.answered = String(number);
  } catch (fault) {
    byId("notice").textContent = fault.message;
    byId("notice").hidden = false;
  }
}

byId("preset").append(make("option", {value: ""}, "your own"), ...CASES.map(([name]) => make("option", {value: name}, name)));
byId("preset").addEventListener("change", (event) => {
  const found = CASES.find(([name]) => name === event.target.value);
  if (found) use(found[1], found[0]);
});
use(CASES[1][1], CASES[1][0]);
startTree();
