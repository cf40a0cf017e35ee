// The page at /status: /metrics every two seconds, as numbers, lines and tables.

import {Problem, ask, askJson} from "./api.js";
import {byId, bytesText, countText, make} from "./dom.js";
import {askForKey} from "./key.js";
import {buckets, quantile, readMetrics, sum} from "./prometheus.js";

const SECONDS = 2, KEPT = 90;  // between two looks; looks that a line shows

const timeText = (seconds) => seconds === null ? "none" : seconds === Infinity ? "more" : seconds < 1e-3 ? `${+(seconds * 1e6).toFixed(1)} \u00b5s`
  : seconds < 1 ? `${+(seconds * 1e3).toFixed(2)} ms` : `${+seconds.toFixed(2)} s`;
const rateText = (rate) => `${rate < 10 ? rate.toFixed(1) : countText(Math.round(rate))} /s`;

const TIMES = "sightline_request_seconds";
const gauge = (name) => ({now}) => sum(now, name);
const rate = (name) => ({now, before, seconds}) => before ? Math.max(0, sum(now, name) - sum(before, name)) / seconds : 0;
// Of the requests since the last look. Its own questions are among them.
const time = (share) => ({now, before}) => quantile(buckets(now, TIMES, {}, before), share);

/** Title, number, text of the number. */
const CHARTS = [
  ["Requests", rate("sightline_requests_total"), rateText],
  ["Rays", rate("sightline_rays_total"), rateText],
  ["Median time", time(0.5), timeText],
  ["99% of times", time(0.99), timeText],
  ["Connections", gauge("sightline_connections"), countText],
  ["Waiting requests", gauge("sightline_queued_requests"), countText],
  ["Memory of requests", gauge("sightline_traffic_bytes"), bytesText],
  ["Memory of triangles", gauge("sightline_geometry_bytes"), bytesText],
  ["Memory of trees", gauge("sightline_tree_bytes"), bytesText],
  ["Temporary files", gauge("sightline_spool_bytes"), bytesText],
];

const lines = CHARTS.map(() => []);
let last = null;  // {metrics, at}
let looks = 0;

function line(values) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", `0 0 ${KEPT - 1} 30`);
  svg.setAttribute("preserveAspectRatio", "none");
  svg.setAttribute("aria-hidden", "true");
  const finite = values.map((value) => Number.isFinite(value) ? value : 0);
  const most = Math.max(...finite) || 1;
  const path = document.createElementNS("http://www.w3.org/2000/svg", "polyline");
  path.setAttribute("points", finite.map((value, i) => `${KEPT - finite.length + i},${29 - 27 * value / most}`).join(" "));
  svg.append(path);
  return svg;
}

function showCharts(now) {
  const at = performance.now() / 1000;
  const look = {now, before: last?.metrics || null, seconds: at - (last?.at || at)};
  last = {metrics: now, at};
  byId("charts").replaceChildren(...CHARTS.map(([title, numberOf, textOf], i) => {
    const number = numberOf(look);
    lines[i] = [...lines[i], number].slice(-KEPT);
    return make("div", {class: "chart"}, make("span", {class: "about"}, title), make("strong", {}, textOf(number)), line(lines[i]));
  }));
}

function showRoutes(now) {
  const routes = new Map();
  for (const {labels, value} of now.get("sightline_requests_total") || []) {
    const row = routes.get(labels.route) || {all: 0, errors: 0};
    row.all += value;
    if (Number(labels.status) >= 400) row.errors += value;
    routes.set(labels.route, row);
  }
  byId("routes").tBodies[0].replaceChildren(...[...routes].filter(([, {all}]) => all).sort((a, b) => b[1].all - a[1].all).map(([route, {all, errors}]) => {
    const times = buckets(now, TIMES, {route});
    return make("tr", {}, make("th", {scope: "row"}, route), [countText(all), countText(errors), timeText(quantile(times, 0.5)),
      timeText(quantile(times, 0.99))].map((text) => make("td", {}, text)));
  }));
}

function showScenes(scenes) {
  byId("scene-table").tBodies[0].replaceChildren(...scenes.map((scene) => make("tr", {}, make("th", {scope: "row"}, scene.id),
    make("td", {}, scene.state), make("td", {}, scene.triangles === undefined ? "" : countText(scene.triangles)),
    make("td", {}, scene.bytes === undefined ? "" : bytesText(scene.bytes)), make("td", {}, String(scene.revision ?? "")))));
}

function tell(text) {
  byId("notice").textContent = text;
  byId("notice").hidden = !text;
}

async function look() {
  try {
    const [text, {scenes}] = await Promise.all([ask("/metrics").then((answer) => answer.text()), askJson("/v1/scenes")]);
    const now = readMetrics(text);
    const [{labels}] = now.get("sightline_build_info");
    const up = Date.now() / 1000 - sum(now, "process_start_time_seconds");
    byId("server").textContent = `${labels.version}, kernel ${labels.kernel}, up ${up < 120 ? `${Math.round(up)} s` : up < 7200
      ? `${Math.round(up / 60)} min` : `${Math.round(up / 3600)} h`}`;
    showCharts(now);
    showRoutes(now);
    showScenes(scenes);
    tell("");
    document.body.dataset.looks = String(++looks);
  } catch (fault) {
    if (fault instanceof Problem && fault.status === 401) return askForKey(look);
    tell(fault.message);
  }
  setTimeout(look, SECONDS * 1000);
}

look();
