// The part of /learn about a tree: the visit of a ray to the demo scene `six`, one box after the other.

import {askJson, post, scenePath} from "./api.js";
import {byId, make} from "./dom.js";

const SCENE = "six";

/** name -> a ray; the four ways in which a root over two subtrees can be visited. */
const RAYS = {
  both: {origin: [-10, 3.5, 0.9], direction: [1, 0, 0]},
  left: {origin: [-5, 10, 0], direction: [0, -1, 0]},
  right: {origin: [3, 10, 0], direction: [0, -1, 0]},
  none: {origin: [1, 10, 0], direction: [0, -1, 0]},
};

let visit = null;  // {ray, boxes, hit, corners}
let step = 0;      // how many boxes are shown

function draw(name, attributes) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [attribute, value] of Object.entries(attributes)) element.setAttribute(attribute, value);
  return element;
}

// x from -11 to 9 and y from -1 to 11, in pixels of the figure.
const pixel = ([x, y]) => [(x + 11) * 20, (11 - y) * 20];

function nameOf(box) {
  if (box.parent === null) return "The root";
  return box.max[0] <= 0 ? "The left subtree" : box.min[0] >= 2 ? "The right subtree" : "A box";
}

function reasonOf(box) {
  if (box.verdict === "missed") {
    return box.miss.length === 1 ? `missed: the ray runs beside slab ${box.miss[0]}` : `missed: the slabs ${box.miss.join(" and ")} share no t`;
  }
  if (box.verdict === "behind") return "missed: it lies behind the origin";
  if (box.verdict === "farther") return `left out: a hit is nearer than its entry at t = ${box.t_enter}`;
  const tested = box.triangles || [];
  const hits = tested.filter(({verdict}) => verdict === "hit").length;
  return `entered from t = ${box.t_enter} to ${box.t_exit}${tested.length ? `; ${tested.length} triangles tested, ${hits} hit` : ""}`;
}

function show() {
  const {ray, boxes, hit, corners} = visit;
  const shapes = boxes.slice(0, step).map((box, i) => {
    const [x, y] = pixel([box.min[0], box.max[1]]), [right, bottom] = pixel([box.max[0], box.min[1]]);
    return draw("rect", {class: `visit ${box.verdict === "entered" ? "in" : "out"}${i === step - 1 ? " now" : ""}`, x, y, width: right - x, height: bottom - y});
  });
  const tested = new Map(boxes.slice(0, step).flatMap((box) => box.triangles || []).map((each) => [`${each.instance}.${each.triangle}`, each.verdict]));
  for (const {instance, triangle, points} of corners) {
    shapes.push(draw("polygon", {class: `triangle ${tested.get(`${instance}.${triangle}`) || ""}`, points: points.map((p) => pixel(p).join(",")).join(" ")}));
  }
  const done = step === boxes.length;
  const far = ray.origin.map((x, k) => x + (done && hit ? hit.t : 20) * ray.direction[k]);
  const [[x1, y1], [x2, y2]] = [pixel(ray.origin), pixel(far)];
  shapes.push(draw("line", {class: done && hit ? "ray hit" : "ray", x1, y1, x2, y2}), draw("circle", {class: "handle origin", cx: x1, cy: y1, r: 4.5}));
  if (done && hit) shapes.push(draw("circle", {class: "met", cx: x2, cy: y2, r: 5}));
  byId("tree").replaceChildren(...shapes);
  byId("visits").replaceChildren(...boxes.slice(0, step).map((box, i) => make("li", i === step - 1 ? {class: "now"} : {}, `${nameOf(box)} is ${reasonOf(box)}.`)));
  byId("visit-end").textContent = !done ? "" : hit ? `The hit is on ${hit.node}, at t = ${hit.t}.` : "No triangle is hit.";
  byId("step-back").disabled = step <= 1;
  byId("step-on").disabled = done;
  byId("tree-part").dataset.step = `${step} of ${boxes.length}`;
}

async function take(name) {
  for (const button of document.querySelectorAll("[data-visit]")) button.setAttribute("aria-pressed", String(button.dataset.visit === name));
  const body = JSON.stringify({rays: [RAYS[name]], explain: true, fields: ["t", "node", "triangle"]});
  const {status, text} = await post(scenePath(SCENE, "/rays:closest"), body);
  if (status !== 200) throw new Error();
  const {hits: [hit], explain} = JSON.parse(text);
  const ids = [0, 1].flatMap((instance) => [0, 1, 2].map((triangle) => `${instance}.0.${triangle}`));
  const {triangles} = await askJson(scenePath(SCENE, `/triangles?ids=${ids.join(",")}`));
  visit = {ray: RAYS[name], boxes: explain.boxes, hit, corners: triangles.map(({corners}, i) => ({instance: Math.floor(i / 3), triangle: i % 3, points: corners}))};
  step = 1;
  byId("tree-request").textContent = body;
  byId("tree-answer").textContent = text;
  show();
}

/** Shows the first box of the visit, or says that the scene is missing. */
export async function visitTree(name) {
  const there = await take(name).then(() => true, () => false);
  byId("tree-part").hidden = !there;
  byId("tree-missing").hidden = there;
}

export function startTree() {
  for (const button of document.querySelectorAll("[data-visit]")) button.addEventListener("click", () => visitTree(button.dataset.visit));
  byId("step-on").addEventListener("click", () => {
    ++step;
    show();
  });
  byId("step-back").addEventListener("click", () => {
    --step;
    show();
  });
  return visitTree("both");
}
