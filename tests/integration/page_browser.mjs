// Drives the page in a headless browser and prints what it saw as JSON; page_test.py judges.
//
//   node page_browser.mjs MODULES BROWSER URL FOLDER PLAN
//
// MODULES has playwright-core; pictures go to FOLDER.

import {createRequire} from "node:module";

const [modules, browserPath, url, folder, plan] = process.argv.slice(2);
const {chromium} = createRequire(`${modules}/x.js`)("playwright-core");

const SIZES = [[1280, 720], [390, 844]];
const THEMES = ["light", "dark"];

const browser = await chromium.launch({executablePath: browserPath, args: [
  "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]});

/** A page that notes what should not be: complaints in the console and requests to elsewhere. */
async function open(size, theme, address = url) {
  const context = await browser.newContext({viewport: {width: size[0], height: size[1]}, colorScheme: theme, hasTouch: size[0] < 500});
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
  const begin = Date.now();
  await page.goto(address);
  await page.waitForSelector("#stage[data-complete]", {timeout: 60000});
  seen.drawn = Date.now() - begin;
  seen.paint = await page.evaluate(() => Math.round(performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? -1));
  seen.triangles = await page.locator("#stage").getAttribute("data-triangles");
  return {page, seen, close: () => context.close()};
}

/** Does something and waits for the answer to it. */
async function answered(page, act) {
  const before = await page.evaluate(() => document.querySelector("#stage").dataset.answered || "0");
  await act();
  await page.waitForFunction((old) => (document.querySelector("#stage").dataset.answered || "0") !== old, before, {timeout: 30000});
  await page.waitForFunction(() => !document.querySelector("#run").disabled);
  await page.waitForTimeout(300);
}

/** The console and the answer as the page shows them. */
async function told(page) {
  return page.evaluate(() => ({
    path: document.querySelector("#path").textContent + document.querySelector("#route").value,
    body: document.querySelector("#body").value,
    raw: document.querySelector("#raw").textContent,
    outcome: document.querySelector("#outcome").textContent,
    rows: [...document.querySelectorAll("#fields tr")].map((row) => row.textContent),
    link: location.href,
    notice: document.querySelector("#notice").textContent,
    // What is wider than its place, or lies outside the window.
    overflow: [...document.querySelectorAll("body *")].filter((element) => {
      const box = element.getBoundingClientRect();
      return box.width > 0 && (box.right > innerWidth + 1 || box.left < -1) && !element.closest(".hidden");
    }).map((element) => `${element.tagName} ${element.id} ${element.className}`),
  }));
}

/** A pixel of the view, from shares of its width and height. */
async function at(page, x, y) {
  const box = await page.locator("#view").boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

const PLANS = {
  async click() {
    const runs = [];
    for (const size of SIZES) {
      for (const theme of THEMES) {
        const {page, seen, close} = await open(size, theme);
        await answered(page, async () => page.mouse.click(...await at(page, 0.5, 0.55)));
        runs.push({...seen, ...await told(page)});
        await page.screenshot({path: `${folder}/click-${seen.size}-${theme}.png`});
        await close();
      }
    }
    return runs;
  },
};

try {
  console.log(JSON.stringify(await PLANS[plan]()));
} finally {
  await browser.close();
}
