// Drives the page in a headless browser and prints what it saw as JSON; page_test.py judges.
//
//   node page_browser.mjs MODULES BROWSER URL FOLDER PLAN [WORD...]
//
// MODULES has playwright-core; pictures go to FOLDER.

import {readFileSync} from "node:fs";
import {createRequire} from "node:module";

const [modules, browserPath, url, folder, plan, ...words] = process.argv.slice(2);
const {chromium} = createRequire(`${modules}/x.js`)("playwright-core");

const SIZES = [[1280, 720], [390, 844]];
const THEMES = ["light", "dark"];
const PATIENCE = 240000;  // milliseconds that a slow machine may take for one step

/** Pairs of a size and a theme: all of them, and those of long plans. SIGHTLINE_VIEWS "every": long plans use all. "one": each plan uses one. */
const VIEWS = process.env.SIGHTLINE_VIEWS;
const PAIRS = SIZES.flatMap((size) => THEMES.map((theme) => [size, theme])).slice(0, VIEWS === "one" ? 1 : 4);
const FEW = VIEWS ? PAIRS : [PAIRS[0], PAIRS[3]];

const browser = await chromium.launch({executablePath: browserPath, args: [
  "--headless", "--no-sandbox", "--disable-dev-shm-usage", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]});

/** A page that notes what should not be: complaints in the console and requests to elsewhere. */
async function watch(size, theme) {
  const context = await browser.newContext({viewport: {width: size[0], height: size[1]}, colorScheme: theme, hasTouch: size[0] < 500,
    permissions: ["clipboard-read", "clipboard-write"]});
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const seen = {size: size.join("x"), theme, complaints: [], foreign: []};
  page.on("console", (message) => {
    // Software GL tells how slow it is.
    if (["error", "warning"].includes(message.type()) && !/GPU stall|Automatic fallback to software/.test(message.text())) {
      seen.complaints.push(message.text());
    }
  });
  page.on("pageerror", (fault) => seen.complaints.push(fault.stack));
  page.on("request", (request) => { if (!request.url().startsWith(url) && !/^(data|blob):/.test(request.url())) seen.foreign.push(request.url()); });
  return {page, seen, close: () => context.close()};
}

/** A page that shows a whole scene. */
async function open(size, theme, address = url) {
  const {page, seen, close} = await watch(size, theme);
  const begin = Date.now();
  await page.goto(address);
  // The server's picture stands in for triangles that are coming.
  await page.waitForSelector("#traced[data-rows], #stage[data-complete]");
  seen.first = Date.now() - begin;
  await page.waitForSelector("#stage[data-complete]");
  seen.drawn = Date.now() - begin;
  seen.paint = await page.evaluate(() => Math.round(performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? -1));
  seen.triangles = await page.locator("#stage").getAttribute("data-triangles");
  return {page, seen, close};
}

/** Waits until the link tells of the view and all is drawn. */
async function rest(page) {
  const frames = () => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));
  // What has moved is drawn first, and the link is written some time after that.
  await frames();
  await page.waitForSelector("#stage:not([data-saving])", {state: "attached"});
  await frames();
}

/** Does something and waits for the answer to it. */
async function answered(page, act) {
  const before = await page.evaluate(() => document.querySelector("#stage").dataset.answered || "0");
  await act();
  await page.waitForFunction((old) => (document.querySelector("#stage").dataset.answered || "0") !== old, before);
  await page.waitForFunction(() => !document.querySelector("#run").disabled);
  await rest(page);
}

/** The console and the answer as the page shows them. */
async function told(page) {
  const outside = await page.evaluate(() => [...document.querySelectorAll("body *")].filter((element) => {
    // What is wider than its place, or lies outside the window.
    const box = element.getBoundingClientRect();
    return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1) && !element.closest(".hidden, svg");
  }).map((element) => `${element.tagName} ${element.id} ${element.className}`));
  if (!await page.locator("#stage").count()) return {overflow: outside};
  const shown = await page.evaluate(() => ({
    path: document.querySelector("#path").textContent + document.querySelector("#route").value,
    body: document.querySelector("#body").value,
    raw: document.querySelector("#raw").textContent,
    outcome: document.querySelector("#outcome").textContent,
    rows: [...document.querySelectorAll("#fields tr")].map((row) => row.textContent),
    link: location.href,
    notice: document.querySelector("#notice").textContent,
    hint: document.querySelector("#hint").textContent,
    mode: document.querySelector("#modes [aria-checked=true]").dataset.mode,
    shapes: JSON.parse(document.querySelector("#marks").dataset.shapes || "[]"),
    scenes: [...document.querySelectorAll("#list .take")].map((each) => each.dataset.scene),
  }));
  return {...shown, overflow: outside};
}

/** A pixel of the view, from shares of its width and height. */
async function at(page, x, y) {
  const box = await page.locator("#view").boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

/** Serious faults that axe finds. */
async function barriers(page) {
  await page.evaluate(readFileSync(`${modules}/axe-core/axe.min.js`, "utf8"));
  const {violations} = await page.evaluate(() => axe.run());
  return violations.filter(({impact}) => ["serious", "critical"].includes(impact))
    .map(({id, nodes}) => `${id}: ${nodes.map(({target, failureSummary}) => `${target} ${failureSummary}`).join("; ")}`);
}

/** Puts fingers on pixels of the window, moves or lifts them. */
async function fingers(page) {
  const session = await page.context().newCDPSession(page);
  return (type, ...places) => session.send("Input.dispatchTouchEvent", {type, touchPoints: places.map(([x, y], id) => ({x, y, id}))});
}

/** click(page, pixel) and drag(page, from, to) with a mouse, or with fingers as on a phone. */
const MOUSE = {
  click: (page, place) => page.mouse.click(...place),
  async drag(page, from, to) {
    await page.mouse.move(...from);
    await page.mouse.down();
    await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2, {steps: 4});
    await page.mouse.move(...to, {steps: 4});
    await page.mouse.up();
  },
};
const TOUCH = {
  click: (page, place) => page.touchscreen.tap(...place),
  async drag(page, from, to) {
    const touch = await fingers(page);
    await touch("touchStart", from);
    for (const share of [0.25, 0.5, 0.75, 1]) await touch("touchMove", from.map((x, k) => x + share * (to[k] - x)));
    await touch("touchEnd");
  },
};
const hand = ([width]) => width < 500 ? TOUCH : MOUSE;

const clickAt = (page, x, y) => answered(page, async () => page.mouse.click(...await at(page, x, y)));
const choose = (page, mode) => page.click(`#modes [data-mode=${mode}]`);

const PLANS = {
  async click() {
    const runs = [];
    for (const [size, theme] of PAIRS) {
      const {page, seen, close} = await open(size, theme);
      await clickAt(page, 0.5, 0.55);
      runs.push({...seen, ...await told(page), barriers: await barriers(page)});
      await page.screenshot({path: `${folder}/click-${seen.size}-${theme}.png`});
      await close();
    }
    return runs;
  },

  /** Every gesture, near the houses of the town, on a phone with a finger. */
  async gestures() {
    const runs = [];
    for (const [size, theme] of FEW) {
      const {page, seen, close} = await open(size, theme, `${url}/#scene=town&camera=60,45,80,0,8,0`);
      const step = async (name, act) => {
        await answered(page, act);
        runs.push({name, ...seen, ...await told(page)});
        await page.evaluate(() => scrollTo(0, 0));
        await page.screenshot({path: `${folder}/${name}-${seen.size}-${theme}.png`});
      };
      const click = async (x, y) => hand(size).click(page, await at(page, x, y));
      const drag = async (from, to) => hand(size).drag(page, await at(page, ...from), await at(page, ...to));
      const two = async (one, other) => {
        await click(...one);
        await page.waitForFunction(() => document.querySelector("#hint").textContent.includes("second"));
        await click(...other);
      };
      await choose(page, "measure");
      await step("measure", () => drag([0.35, 0.6], [0.62, 0.7]));
      await choose(page, "box");
      await step("select", () => drag([0.3, 0.3], [0.6, 0.6]));
      await choose(page, "cuboid");
      await step("cuboid", () => drag([0.4, 0.6], [0.52, 0.66]));
      await choose(page, "sphere");
      await step("sphere", () => drag([0.4, 0.6], [0.5, 0.66]));
      await choose(page, "sight");
      await step("sight", () => two([0.3, 0.62], [0.72, 0.45]));
      // The tower stands between these two.
      await step("blocked", () => two([0.42, 0.63], [0.62, 0.5]));
      await choose(page, "why");
      await step("why", async () => {
        await click(0.45, 0.7);
        await page.waitForFunction(() => document.querySelector("#outcome").textContent.includes("visited"));
        // From the side the ray can be seen.
        await page.focus("#view");
        for (let i = 0; i < 5; ++i) await page.keyboard.press("ArrowLeft");
        await rest(page);
      });
      // The slider shows the first boxes of the visit, one more with each press of a key.
      const boxes = async () => ({now: await page.locator("#visit-count").textContent(), row: await page.locator("#fields .now").allTextContents(),
        shapes: JSON.parse(await page.locator("#marks").getAttribute("data-shapes"))});
      const visit = runs.at(-1).visit = [];
      await page.focus("#visit-step");
      await page.keyboard.press("Home");
      visit.push(await boxes());
      for (let i = 0; i < 8; ++i) {
        await page.keyboard.press("ArrowRight");
        visit.push(await boxes());
      }
      await page.screenshot({path: `${folder}/visit-${seen.size}-${theme}.png`});
      await choose(page, "scan");
      await step("scan", async () => {
        await click(0.55, 0.8);
        await page.waitForFunction(() => Number(document.querySelector("#stage").dataset.points));
      });
      const [file] = await Promise.all([page.waitForEvent("download"), page.click("#save-ply")]);
      const last = runs.at(-1);
      last.ply = readFileSync(await file.path(), "utf8");
      last.points = await page.locator("#stage").getAttribute("data-points");
      const hues = async () => JSON.parse(await page.locator("#stage").getAttribute("data-hues"));
      last.byDistance = await hues();
      await page.selectOption("#sweep-colour", "node");
      last.byNode = await hues();
      await rest(page);
      await page.screenshot({path: `${folder}/scan-node-${seen.size}-${theme}.png`});
      await choose(page, "clearance");
      await step("clearance", () => two([0.57, 0.84], [0.5, 0.5]));
      await choose(page, "viewshed");
      await step("viewshed", async () => {
        await click(0.5, 0.75);
        await page.waitForSelector("#stage[data-seen]");
      });
      runs.at(-1).seen = await page.locator("#stage").getAttribute("data-seen");
      await choose(page, "section");
      await step("section", async () => {
        await click(0.5, 0.55);
        await page.waitForFunction(() => document.querySelector("#outcome").textContent.includes("cuts"));
        await page.waitForFunction(() => JSON.parse(document.querySelector("#marks").dataset.shapes).length > 2);
      });
      await choose(page, "levels");
      await step("levels", async () => {
        for (let level = 0; level < 3; ++level) {
          await click(0.5, 0.55);
          await page.waitForFunction((text) => document.querySelector("#outcome").textContent.startsWith(text), `Level ${level}:`);
        }
      });
      await choose(page, "heat");
      await step("heat", async () => {
        await click(0.5, 0.55);
        await page.waitForSelector("#heat:not([hidden])");
      });
      runs.at(-1).heat = await page.evaluate(() => {
        const canvas = document.querySelector("#heat");
        const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        return {width: canvas.width, height: canvas.height, colours: Array.from({length: data.length / 4}, (_, i) => [...data.subarray(4 * i, 4 * i + 3)])};
      });
      await choose(page, "ray");
      await step("ray", () => click(0.5, 0.7));
      await page.click("#cost-part summary");
      await page.waitForSelector("#cost tr");
      runs.at(-1).cost = await page.locator("#cost tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map(({textContent}) => textContent)));
      await page.screenshot({path: `${folder}/cost-${seen.size}-${theme}.png`});
      await page.click("#nodes-part summary");
      await page.waitForSelector("#nodes .take");
      await page.fill("#node-search", "house 3");
      await page.locator("#nodes li:last-child").scrollIntoViewIfNeeded();
      await page.screenshot({path: `${folder}/nodes-${seen.size}-${theme}.png`});
      await close();
    }
    return runs;
  },

  /** Fingers on a phone: a tap, a drag and a pinch. */
  async touch() {
    const {page, seen, close} = await open(SIZES[1], "light", `${url}/#scene=town&camera=60,45,80,0,8,0`);
    const {clientWidth, clientHeight} = await page.evaluate(() => document.querySelector("#view"));
    const touch = await fingers(page);
    const touchAt = async (type, ...places) => touch(type, ...await Promise.all(places.map((place) => at(page, ...place))));
    const camera = () => page.evaluate(() => new URLSearchParams(location.hash.slice(1)).get("camera").split(",").map(Number));
    const moved = async (act) => {
      const before = await page.evaluate(() => location.hash);
      await act();
      await page.waitForFunction((old) => location.hash !== old, before);
      // A slow machine writes the link between two movements of one gesture.
      await rest(page);
      return camera();
    };
    await answered(page, async () => page.touchscreen.tap(...await at(page, 0.5, 0.6)));
    const tapped = await told(page), cameras = [await camera()];
    cameras.push(await moved(async () => {
      await touchAt("touchStart", [0.5, 0.5]);
      for (const x of [0.55, 0.6, 0.65]) await touchAt("touchMove", [x, 0.5]);
      await touchAt("touchEnd");
    }));
    cameras.push(await moved(async () => {
      await touchAt("touchStart", [0.45, 0.5], [0.55, 0.5]);
      for (const by of [0.05, 0.1, 0.15]) await touchAt("touchMove", [0.45 - by, 0.5], [0.55 + by, 0.5]);
      await touchAt("touchEnd");
    }));
    // Neither of these asks.
    const after = await told(page);
    await close();
    return {...seen, ...tapped, cameras, after, view: [clientWidth, clientHeight]};
  },

  async keyboard() {
    const {page, seen, close} = await open(SIZES[0], "light");
    await page.focus("#view");
    // The link follows the camera.
    const links = [];
    const changed = async () => {
      await page.waitForFunction((old) => location.hash && location.href !== old, links.at(-1) || "");
      links.push(await page.evaluate(() => location.href));
    };
    await changed();
    for (const key of ["ArrowLeft", "ArrowUp", "Shift+ArrowRight", "+"]) {
      await page.keyboard.press(key);
      await changed();
    }
    await answered(page, () => page.keyboard.press("Enter"));
    const ray = await told(page);
    await page.keyboard.press("3");
    const {mode} = await told(page);
    await page.selectOption("#route", "rays:count");
    await page.fill("#body", '{"rays":[{"origin":[0,100,0],"direction":[0,-1,0]}]}');
    await answered(page, () => page.press("#body", "Control+Enter"));
    const typed = await told(page);
    const copies = {};
    for (const kind of ["curl", "python", "javascript"]) {
      await page.click(`[data-copy=${kind}]`);
      copies[kind] = await page.evaluate(() => navigator.clipboard.readText());
    }
    await page.fill("#body", '{"rays":[{"origin":[0,100],"direction":[0,-1,0]}]}');
    await answered(page, () => page.click("#run"));
    const fault = await told(page);
    await page.click("#copy-link");
    const copied = [await page.evaluate(() => navigator.clipboard.readText()), await page.evaluate(() => location.href)];
    const themes = [];
    for (let i = 0; i < 3; ++i) {
      await page.focus("#theme");
      await page.keyboard.press("Enter");
      themes.push(await page.evaluate(() => [document.querySelector("#theme").textContent, getComputedStyle(document.body).backgroundColor]));
    }
    await close();
    return {...seen, links, ray, mode, typed, copies, fault, copied, themes};
  },

  /** Every tool without a mouse: chosen and used with keys. */
  async keys() {
    const {page, seen, close} = await open(SIZES[0], "dark", `${url}/#scene=town&camera=60,45,80,0,8,0`);
    const runs = [];
    const count = await page.locator("#modes button").count();
    const move = async (keys) => {
      for (const key of keys) await page.keyboard.press(key);
    };
    for (let i = 0; i < count; ++i) {
      // Digits choose the first nine, arrow keys in the row of tools any other.
      if (i < 9) {
        await page.keyboard.press(String(i + 1));
      } else {
        await page.focus("#modes [aria-checked=true]");
        await page.keyboard.press("ArrowRight");
      }
      await page.focus("#view");
      const {mode} = await told(page);
      const cross = () => page.evaluate(() => document.querySelector("#marks").dataset.cross);
      await answered(page, async () => {
        // The cross goes from where the last tool left it to the square before the tower.
        await move(["a", "a", "a", "a", "s", "s", "s"]);
        await page.keyboard.press("Enter");
        if (["measure", "box", "cuboid", "sphere", "sight", "clearance"].includes(mode)) {
          await page.waitForFunction(() => /second|begins here/.test(document.querySelector("#hint").textContent));
          await move(["d", "d", "d", "d", "w", "w", "w", "Shift+W"]);
          await page.keyboard.press("Enter");
        } else {
          await move(["d", "d", "d", "d", "w", "w", "w"]);
        }
      });
      await page.waitForFunction(() => document.querySelector("#outcome").textContent !== "Click into the scene.");
      runs.push({...seen, ...await told(page), mode, cross: await cross()});
    }
    await close();
    return runs;
  },

  /** WORD: a link to a view that the server traces. Which pixels have a hit, on a grid. */
  async traced() {
    const runs = [];
    for (const [size, theme] of FEW) {
      const {page, seen, close} = await open(size, theme, words[0]);
      const begin = Date.now();
      await page.waitForSelector("#traced[data-rows]");
      seen.first = Date.now() - begin;
      await page.waitForSelector("#traced[data-finest]");
      const grid = await page.evaluate(() => {
        const canvas = document.querySelector("#traced");
        const {data} = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
        const points = [];
        for (let i = 1; i < 12; ++i) {
          for (let j = 1; j < 12; ++j) points.push([Math.floor(canvas.width * i / 12), Math.floor(canvas.height * j / 12)]);
        }
        return {width: canvas.width, height: canvas.height,
          points: points.map(([x, y]) => [x, y, data[4 * (y * canvas.width + x) + 3]])};
      });
      await clickAt(page, 0.5, 0.55);
      runs.push({...seen, ...await told(page), grid});
      await page.screenshot({path: `${folder}/traced-${seen.size}-${theme}.png`});
      await close();
    }
    return runs;
  },

  /** WORDs: links. How fast the view turns: frames per second, of those that are drawn and not only asked for. */
  async frames() {
    const runs = [];
    for (const link of words) {
      const {page, seen, close} = await open(SIZES[0], "light", link);
      seen.frames = await page.evaluate(async () => {
        const ENOUGH = 3000;  // milliseconds
        const view = document.querySelector("#view"), gl = view.getContext("webgl2");
        const done = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        done();
        const begin = performance.now();
        let frames = 0;
        while (performance.now() - begin < ENOUGH) {
          view.dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowLeft", bubbles: true}));
          await new Promise((resolve) => requestAnimationFrame(resolve));
          done();
          ++frames;
        }
        return 1000 * frames / (performance.now() - begin);
      });
      runs.push(seen);
      await close();
    }
    return runs;
  },

  /** Triangles that do not come until a click was answered. */
  async coming() {
    const {page, seen, close} = await watch(SIZES[1], "dark");
    let release;
    const held = new Promise((resolve) => { release = resolve; });
    await page.route("**/geometry?*", (route) => held.then(() => route.continue()));
    await page.goto(`${url}/#scene=town&camera=60,45,80,0,8,0`);
    await page.waitForSelector("#traced[data-finest]");
    await clickAt(page, 0.5, 0.6);
    const result = {...seen, ...await told(page), finest: await page.locator("#traced").getAttribute("data-finest"),
      progress: await page.locator("#progress").textContent()};
    release();
    await page.waitForSelector("#stage[data-complete]");
    result.still = await page.locator("#traced:visible").count();
    await close();
    return result;
  },

  /** WORDs: links. Pictures of the view alone, base64, without what lies over it. */
  async pictures() {
    const runs = [];
    for (const link of words) {
      const {page, seen, close} = await open(SIZES[0], "light", link);
      const begin = Date.now();
      if ((await page.locator("#progress").textContent()).includes("too large")) await page.waitForSelector("#traced[data-finest]");
      seen.traced = Date.now() - begin;
      await page.evaluate(() => {
        for (const id of ["tools", "hint", "progress"]) document.getElementById(id).hidden = true;
      });
      await rest(page);
      seen.picture = (await page.locator("#stage").screenshot()).toString("base64");
      await clickAt(page, 0.5, 0.5);
      runs.push({...seen, ...await told(page)});
      await close();
    }
    return runs;
  },

  /** WORD: a link to open. */
  async link() {
    const {page, seen, close} = await open(SIZES[0], "light", words[0]);
    await page.waitForFunction(() => document.querySelector("#raw").textContent);
    await rest(page);
    const result = {...seen, ...await told(page)};
    await close();
    return result;
  },

  /** WORD: a file with a list of links as JSON. The answer that the page shows for each, and what it notes. */
  async links() {
    const links = JSON.parse(readFileSync(words[0], "utf8"));
    // Without a link: the answer of a first link would arrive beside that of the next.
    const {page, seen, close} = await open(SIZES[0], "light", `${url}/`);
    seen.answers = [];
    for (const link of links) {
      seen.answers.push(await page.evaluate(async (fragment) => {
        const stage = document.querySelector("#stage"), before = stage.dataset.answered;
        location.hash = "";
        document.querySelector("#raw").textContent = "";
        location.hash = fragment;
        while (!document.querySelector("#raw").textContent || stage.dataset.answered === before) await new Promise((resolve) => setTimeout(resolve, 5));
        return [document.querySelector("#raw").textContent, document.querySelector("#notice").textContent];
      }, link));
    }
    await close();
    return seen;
  },

  /** WORDs: a link, and words to search nodes for: the nodes that are found. */
  async nodes() {
    const {page, seen, close} = await open(SIZES[0], "light", words[0]);
    await page.click("#nodes-part summary");
    await page.waitForSelector("#nodes .take");
    const found = async () => page.locator("#nodes li").allInnerTexts();
    seen.found = [await found()];
    for (const word of words.slice(1)) {
      const before = await page.locator("#nodes").innerText();
      await page.fill("#node-search", word);
      await page.waitForFunction((old) => document.querySelector("#nodes").innerText !== old, before);
      seen.found.push(await found());
    }
    await close();
    return seen;
  },

  /** WORDs: a file to choose, and one to drop on the page. */
  async scenes() {
    const {page, seen, close} = await open(SIZES[0], "dark");
    await page.setInputFiles("#file", words[0]);
    await page.waitForSelector("#stage[data-complete^='my-house ']");
    await page.waitForFunction(() => [...document.querySelectorAll("#list .about")].every(({textContent}) => textContent.includes("memory")));
    const put = {...await told(page), about: await page.locator("#list .about").allTextContents()};
    const said = await page.evaluateHandle(() => {
      const texts = [];
      new MutationObserver(() => texts.push(document.querySelector("#upload").textContent)).observe(document.querySelector("#upload"), {childList: true, characterData: true, subtree: true});
      return texts;
    });
    // As the system does it: a file, not an object that a script has made.
    const session = await page.context().newCDPSession(page), [x, y] = await at(page, 0.5, 0.5);
    const data = {items: [], files: [words[1]], dragOperationsMask: 1};
    await session.send("Input.dispatchDragEvent", {type: "dragEnter", x, y, data});
    await session.send("Input.dispatchDragEvent", {type: "dragOver", x, y, data});
    const over = await page.waitForSelector("#drop.over").then(() => true);
    await session.send("Input.dispatchDragEvent", {type: "drop", x, y, data});
    await page.waitForSelector("#stage[data-complete^='dropped ']");
    const dropped = {...await told(page), over, said: await said.jsonValue(), still: await page.locator("#drop.over").count()};
    await page.click("[data-scene=my-house]");
    await page.waitForSelector("#stage[data-complete^='my-house ']");
    await page.click("#nodes-part summary");
    await page.waitForSelector("#nodes .take");
    await page.fill("#node-search", "RIGHT");
    const nodes = await page.locator("#nodes .take").allTextContents();
    await page.click("#nodes .take");
    const node = await told(page);
    await page.screenshot({path: `${folder}/scenes-${seen.size}-dark.png`});
    const remove = page.getByLabel("Delete my-house");
    await remove.click();
    await remove.click();
    await page.waitForFunction(() => !document.querySelector("[data-scene=my-house]"));
    const gone = await told(page);
    await close();
    return {...seen, put, dropped, nodes, node, gone};
  },

  /** A server without scenes. WORDs: a file to choose, its scene, and a node of it. What the page says in each trouble. */
  async troubles() {
    const {page, seen, close} = await watch([320, 640], "light");
    const said = (id, text) => page.waitForFunction(([where, what]) => document.getElementById(where).textContent.includes(what), [id, text]);
    const click = async () => {
      await page.locator("#view").scrollIntoViewIfNeeded();
      await page.mouse.click(...await at(page, 0.5, 0.6));
    };
    await page.goto(url);
    await said("progress", "No scene yet");
    await click();
    await said("hint", "no scene");
    await page.click("#run");
    await said("outcome", "no scene");
    const none = await told(page);
    await page.screenshot({path: `${folder}/trouble-none.png`});
    await page.setInputFiles("#file", words[0]);
    await page.waitForSelector(`#stage[data-complete^='${words[1]} ']`);
    await answered(page, click);
    await page.click("#nodes-part summary");
    await page.fill("#node-search", words[2].toUpperCase());
    await page.click("#nodes .take");
    await rest(page);
    const put = {...await told(page), nodes: await page.locator("#nodes .name").allTextContents(), progress: await page.locator("#progress").textContent()};
    await page.evaluate(() => scrollTo(0, 0));
    await page.screenshot({path: `${folder}/trouble-names.png`});
    // Somebody else deletes the scene.
    await page.evaluate((id) => fetch(`/v1/scenes/${id}`, {method: "DELETE"}), words[1]);
    await said("notice", "deleted");
    await said("progress", "No scene yet");
    await click();
    await said("hint", "no scene");
    const gone = await told(page);
    await page.evaluate(() => { location.hash = "#scene=missing&mode=ray"; });
    await said("notice", "missing");
    await page.context().setOffline(true);
    await said("notice", "does not answer");
    await page.screenshot({path: `${folder}/trouble-offline.png`});
    await page.context().setOffline(false);
    await page.waitForSelector("#notice[hidden]", {state: "attached"});
    await close();
    return {...seen, none, put, gone};
  },

  /** /learn: every case, every formula with its failing case, and a drag. */
  async learn() {
    const runs = [];
    for (const [size, theme] of PAIRS) {
      const {page, seen, close} = await watch(size, theme);
      await page.goto(`${url}/learn`);
      const settled = () => page.waitForFunction(() => document.querySelector("#figure").dataset.answered);
      await settled();
      const step = async (act) => {
        await page.evaluate(() => delete document.querySelector("#figure").dataset.answered);
        await act();
        await settled();
        return page.evaluate(() => ({
          body: document.querySelector("#request").textContent, raw: document.querySelector("#answer").textContent,
          verdict: document.querySelector("#verdict").textContent,
          formulas: [...document.querySelectorAll("#formulas tbody tr")].map((row) => [row.cells[0].firstChild.textContent,
            row.cells[1].textContent, row.classList.contains("wrong")]),
        }));
      };
      await page.waitForSelector("#tree-part[data-step]");
      seen.barriers = await barriers(page);
      seen.overflow = (await told(page)).overflow;
      seen.visits = {};
      for (const name of ["both", "left", "right", "none"]) {
        await page.evaluate(() => delete document.querySelector("#tree-part").dataset.step);
        await page.click(`[data-visit=${name}]`);
        await page.waitForSelector("#tree-part[data-step]");
        const steps = [];
        for (let more = true; more;) {
          steps.push(await page.evaluate(() => ({boxes: [...document.querySelectorAll("#tree rect")].map((box) => box.getAttribute("class")),
            words: [...document.querySelectorAll("#visits li")].map(({textContent}) => textContent), end: document.querySelector("#visit-end").textContent})));
          more = await page.isEnabled("#step-on");
          if (more) await page.click("#step-on");
        }
        seen.visits[name] = {steps, body: await page.locator("#tree-request").textContent(), raw: await page.locator("#tree-answer").textContent()};
        await page.locator("#tree-part").scrollIntoViewIfNeeded();
        if (name === "left") await page.screenshot({path: `${folder}/learn-tree-${seen.size}-${theme}.png`});
      }
      seen.cases = {};
      seen.fails = [];
      const names = await page.locator("#preset option").evaluateAll((options) => options.map(({value}) => value).filter(Boolean));
      for (const name of names) {
        seen.cases[name] = await step(async () => {
          await page.selectOption("#preset", "");
          await page.selectOption("#preset", name);
        });
      }
      for (let i = 0; i < await page.locator("#formulas button").count(); ++i) {
        seen.fails.push(await step(() => page.locator("#formulas button").nth(i).click()));
      }
      await step(() => page.selectOption("#preset", "origin inside, negative diagonal"));
      await page.screenshot({path: `${folder}/learn-3d-${seen.size}-${theme}.png`});
      await step(() => page.selectOption("#preset", "Figure 2: hits"));
      await page.evaluate(() => {
        scrollTo(0, 0);
        document.querySelector("#text").scrollTo(0, 0);
      });
      await page.screenshot({path: `${folder}/learn-${seen.size}-${theme}.png`});
      const dragged = async (handle, dx, dy) => {
        await page.locator(handle).scrollIntoViewIfNeeded();
        const box = await page.locator(handle).boundingBox();
        const place = [box.x + box.width / 2, box.y + box.height / 2];
        return step(() => hand(size).drag(page, place, [place[0] + dx, place[1] + dy]));
      };
      seen.dragged = {flat: await dragged("#xy .origin", -20, -40)};
      await step(() => page.selectOption("#preset", "from the front, oblique"));
      for (const handle of ["#xy .min", "#xz .max", "#xz .tip", "#xz .origin"]) seen.dragged[handle] = await dragged(handle, -18, -24);
      seen.dragged.typed = await step(async () => {
        await page.fill("[aria-label='origin y']", "2.5");
        await page.press("[aria-label='origin y']", "Enter");
      });
      runs.push(seen);
      await close();
    }
    return runs;
  },

  /** /status after three looks, while a client asks. WORD: the path of a question, and its body. */
  async status() {
    const runs = [];
    for (const [size, theme] of PAIRS) {
      const {page, seen, close} = await watch(size, theme);
      await page.goto(`${url}/status`);
      await page.waitForFunction(() => Number(document.body.dataset.looks) >= 1);
      for (let i = 0; i < 20; ++i) await page.evaluate(([path, body]) => fetch(path, {method: "POST", body, headers: {"Content-Type": "application/json"}}), words);
      await page.waitForFunction(() => Number(document.body.dataset.looks) >= 3);
      const table = (id) => page.locator(`${id} tbody tr`).evaluateAll((rows) => rows.map((row) => [...row.cells].map(({textContent}) => textContent)));
      seen.charts = await page.locator(".chart").evaluateAll((charts) => charts.map((chart) => [chart.children[0].textContent, chart.children[1].textContent]));
      [seen.scenes, seen.routes] = [await table("#scene-table"), await table("#routes")];
      runs.push({...seen, ...await told(page), barriers: await barriers(page)});
      await page.screenshot({path: `${folder}/status-${seen.size}-${theme}.png`});
      await close();
    }
    return runs;
  },

  /** Documents at /docs/...: each WORD is a path. Then a search, and the API at /docs. */
  async guide() {
    const runs = [];
    for (const [size, theme] of PAIRS) {
      const {page, seen, close} = await watch(size, theme);
      seen.pages = {};
      for (const path of words) {
        await page.goto(`${url}/docs/${path}`);
        await page.waitForSelector("body[data-complete]");
        seen.pages[path] = await page.evaluate(() => ({title: document.title, text: document.querySelector("#document").innerText,
          links: [...document.querySelectorAll("#document a")].map(({href}) => href)}));
      }
      seen.overflow = (await told(page)).overflow;
      seen.barriers = await barriers(page);
      await page.screenshot({path: `${folder}/guide-${seen.size}-${theme}.png`});
      await page.fill("#search", "snap corners");
      seen.found = await page.locator("#found a").evaluateAll((links) => links.map(({href}) => href));
      await page.screenshot({path: `${folder}/search-${seen.size}-${theme}.png`});
      await page.click("#found a");
      await page.waitForSelector("body[data-complete]");
      seen.arrived = page.url();
      await page.goto(`${url}/docs`);
      await page.waitForSelector("#contents:not([hidden])", {state: "attached"});
      seen.api = {title: await page.title(), wider: await page.evaluate(() => document.documentElement.scrollWidth - innerWidth), barriers: await barriers(page)};
      await page.screenshot({path: `${folder}/api-${seen.size}-${theme}.png`});
      runs.push(seen);
      await close();
    }
    return runs;
  },

  /** WORDs: pictures. All of them small in one picture, FOLDER/sheet.png, with their names. */
  async sheet() {
    const WIDTH = 320;
    const page = await browser.newPage({viewport: {width: 5 * (WIDTH + 12) + 12, height: 100}});
    const shown = words.map((file) => [file.replace(/^.*\/|-\d+x\d+-\w+\.png$/g, ""), readFileSync(file, "base64")]);
    await page.setContent(`<style>body { margin: 0; padding: 12px; display: flex; flex-wrap: wrap; gap: 12px; font: 13px sans-serif; background: #ccc }
      figure { margin: 0 } img { display: block; max-width: ${WIDTH}px }</style>${shown.map(([name, bytes]) =>
      `<figure><img src="data:image/png;base64,${bytes}">${name}</figure>`).join("")}`);
    await page.waitForFunction(() => [...document.images].every(({complete}) => complete));
    await page.screenshot({path: `${folder}/sheet.png`, fullPage: true});
    return {};
  },

  /** WORD: the key. */
  async key() {
    const context = await browser.newContext();
    context.setDefaultTimeout(PATIENCE);
    const page = await context.newPage();
    const give = async (path) => {
      await page.goto(url + path);
      await page.waitForSelector("#key-form:not([hidden])");
      await page.fill("#key", words[0]);
      await page.click("#key-form button");
    };
    await give("/learn");
    await page.waitForSelector("#tree-part[data-step]");
    await page.waitForSelector("#figure[data-answered]");
    await give("/");
    await page.waitForSelector("#stage[data-complete]");
    await clickAt(page, 0.5, 0.5);
    await page.click("[data-copy=curl]").catch(() => {});
    const result = {...await told(page), html: await page.content()};
    await context.close();
    return result;
  },
};

try {
  console.log(JSON.stringify(await PLANS[plan]()));
} finally {
  await browser.close();
}
