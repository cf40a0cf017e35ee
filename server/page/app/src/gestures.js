// Clicks and drags on the view, as requests.

import {FIELDS, length} from "./questions.js";
import {sweepAt} from "./scan.js";

const STILL = 5;  // pixels that a click may move
const LIFT = 3e-3;  // of the scene's radius: an eye or a sensor above a surface, 1.7 m in the demo town

export const HINTS = {
  ray: "Click: cast a ray. Drag: turn. Right drag or two fingers: move. Wheel or pinch: zoom.",
  measure: "Drag from one point to another: their distance. It snaps to corners and edges.",
  box: "Drag a rectangle: the nodes that lie in it.",
  sight: "Click two points: whether eyes just above them see each other.",
  why: "Click: the boxes that a ray visits, and why each is entered or left out. Then turn the view.",
  clearance: "Click two nodes: the distance between them, and their nearest points.",
  viewshed: "Click: what of this view an eye just above the point sees (green), and what not (red).",
  section: "Click: a plane through the point cuts the scene. The next answer ends it.",
  cuboid: "Drag from the middle of a box to its corner: the nodes that it touches. It is at least a quarter as thick as long.",
  sphere: "Drag from the middle of a sphere outwards: the nodes that it touches.",
  heat: "Click: how many boxes each pixel's ray visits, blue few, red many. Moving the view ends it.",
  levels: "Click: the boxes of the next level of the tree; leaves are green.",
  scan: "Click: a LiDAR sensor stands there and sweeps around itself.",
};

/** Tools that take a drag; a click uses all others. */
const DRAGS = new Set(["measure", "box", "cuboid", "sphere"]);

export class Gestures {
  /** ask(route, query) fills the console and runs it; pick(rays) returns their hits; ready() says whether there is a scene to ask. */
  constructor(canvas, view, marks, {ask, pick, say, ready, fail}) {
    Object.assign(this, {canvas, view, marks, ask, pick, say, ready, fail, mode: "ray", first: null, begin: null, cursor: null});
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    canvas.addEventListener("pointerup", (event) => this.up(event));
    canvas.addEventListener("pointercancel", () => this.cancel());
  }

  use(mode) {
    this.mode = mode;
    this.cancel();
    this.first = null;
    this.level = -1;
    this.view.controls.enableRotate = !DRAGS.has(mode);
    this.say(HINTS[mode]);
  }

  cancel() {
    this.begin = null;
    this.pull(null, null);
  }

  /** Shows what a drag from one pixel to another would ask; null for nothing. */
  pull(from, to) {
    this.marks.rectangle = from && this.mode === "box" ? [...from, ...to] : null;
    this.marks.rubber = from && this.mode !== "box" ? [from, to] : null;
    this.marks.draw();
  }

  place(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }

  down(event) {
    // The second finger of a pinch is no click.
    this.cursor = this.marks.cross = null;
    if (!event.isPrimary) return this.cancel();
    if (event.button === 0) this.begin = this.place(event);
  }

  move(event) {
    if (!this.begin || !event.isPrimary || !DRAGS.has(this.mode)) return;
    this.pull(this.begin, this.place(event));
  }

  up(event) {
    const begin = this.begin, end = this.place(event);
    if (!begin || !event.isPrimary) return;
    this.cancel();
    const still = Math.hypot(end[0] - begin[0], end[1] - begin[1]) < STILL;
    if (DRAGS.has(this.mode) && !still) this.start(begin, end);
    if (!DRAGS.has(this.mode) && still) this.start(...end);
  }

  async start(...places) {
    if (!this.ready()) return this.say("There is no scene to ask.");
    try {
      await this[this.mode](...places);
    } catch (fault) {
      this.fail(fault);
    }
  }

  // ---- For the keyboard: a cross, at first in the middle

  /** The pixel of the cross. */
  get crossed() {
    const [x, y] = this.cursor || [0.5, 0.5];
    return [x * this.canvas.clientWidth, y * this.canvas.clientHeight];
  }

  /** Moves the cross by shares of the view. */
  moveCross(x, y) {
    const RIM = 0.02;
    const [a, b] = this.cursor || [0.5, 0.5];
    this.cursor = [a + x, b + y].map((share) => Math.min(1 - RIM, Math.max(RIM, share)));
    this.marks.cross = this.crossed;
    this.pull(DRAGS.has(this.mode) ? this.first : null, this.marks.cross);
  }

  /** Uses the tool at the cross; a tool that takes a drag needs a begin and an end. */
  useCross() {
    const at = this.crossed;
    if (!DRAGS.has(this.mode)) return this.start(...at);
    const from = this.first;
    this.first = from ? null : at;
    if (!from) return this.say("The drag begins here. Move the cross with W, A, S and D, then press Enter again.");
    this.pull(null, null);
    this.say(HINTS[this.mode]);
    return this.start(from, at);
  }

  ray(x, y) { return this.ask("rays:closest", {rays: [this.view.ray(x, y)], fields: FIELDS}); }

  why(x, y) {
    return this.ask("rays:closest", {rays: [this.view.ray(x, y)], explain: true,
      fields: ["t", "position", "instance", "primitive", "triangle", "node"]});
  }

  measure(from, to) {
    const rays = [this.view.ray(...from), this.view.ray(...to)];
    return this.ask("rays:closest", {rays, fields: ["t", "position", "normal", "instance", "primitive", "triangle", "on_edge", "node"]});
  }

  box([x0, y0], [x1, y1]) {
    const sides = [Math.min(x0, x1), Math.min(y0, y1), Math.max(x0, x1), Math.max(y0, y1)];
    return this.ask("boxes:list", {boxes: [{planes: this.view.pyramid(...sides)}], of: "nodes", limit: 100});
  }

  /** The nodes that touch a shape between the points of the scene under two pixels. */
  async touching(from, to, shape) {
    const hits = await this.pick([this.view.ray(...from), this.view.ray(...to)]);
    if (!hits.every(Boolean)) return this.say("Nothing is there. Begin and end the drag on the scene.");
    const [middle, end] = hits.map(({position}) => position);
    return this.ask("boxes:list", {boxes: [shape(middle, end)], of: "nodes", limit: 100});
  }

  cuboid(from, to) {
    return this.touching(from, to, (middle, corner) => {
      const reach = corner.map((x, k) => Math.abs(x - middle[k]));
      // Points of a floor would make a box without a height.
      const half = reach.map((x) => Math.max(x, Math.max(...reach) / 4));
      return {min: middle.map((x, k) => x - half[k]), max: middle.map((x, k) => x + half[k])};
    });
  }

  sphere(from, to) { return this.touching(from, to, (center, end) => ({center, radius: length(center, end)})); }

  /** The point of a hit, lifted off its surface towards the camera. */
  lifted(hit) {
    const eye = this.view.pose.slice(0, 3);
    const side = Math.sign(hit.normal.reduce((sum, n, k) => sum + n * (eye[k] - hit.position[k]), 0)) || 1;
    return hit.position.map((p, k) => p + side * hit.normal[k] * this.view.radius * LIFT);
  }

  async pointAt(x, y) {
    const [hit] = await this.pick([this.view.ray(x, y)]);
    return hit ? this.lifted(hit) : null;
  }

  async clearance(x, y) {
    const [hit] = await this.pick([this.view.ray(x, y)]);
    if (!hit) return this.say("Nothing is there. Click on the scene.");
    if (!this.first) {
      this.first = hit;
      this.marks.show([{kind: "point", points: [hit.position], label: hit.node || `node ${hit.node_id}`}]);
      return this.say("Click the second node.");
    }
    const from = this.first;
    this.first = null;
    this.say(HINTS.clearance);
    return this.ask("clearance", {a: {nodes: [from.node_id]}, b: {nodes: [hit.node_id]}});
  }

  /** To points of the scene that lie on a grid of pixels. */
  async viewshed(x, y) {
    const COLUMNS = 32, ROWS = 18;
    const eye = await this.pointAt(x, y);
    if (!eye) return this.say("Nothing is there. Click on the scene.");
    const {clientWidth, clientHeight} = this.canvas;
    const rays = Array.from({length: COLUMNS * ROWS}, (_, i) =>
      this.view.ray((i % COLUMNS + 0.5) * clientWidth / COLUMNS, (Math.floor(i / COLUMNS) + 0.5) * clientHeight / ROWS));
    const to = (await this.pick(rays)).filter(Boolean).map((hit) => this.lifted(hit));
    return this.ask("visibility", {from: [eye], to});
  }

  /** Across the axis that the view runs along most. */
  async section(x, y) {
    const [hit] = await this.pick([this.view.ray(x, y)]);
    if (!hit) return this.say("Nothing is there. Click on the scene.");
    const along = this.view.axes().forward.toArray();
    const axis = along.reduce((best, each, k) => Math.abs(each) > Math.abs(along[best]) ? k : best, 0);
    // It points to the camera: the near side is cut away.
    const normal = [0, 1, 2].map((k) => k === axis ? -Math.sign(along[k]) : 0);
    const plane = [...normal, normal[axis] * hit.position[axis]];
    return this.ask("boxes:list", {boxes: [{planes: [plane, plane.map((n) => 0 - n)]}], of: "triangles", limit: 1000});
  }

  heat() {
    const ROWS = 180;
    const {right, up, forward} = this.view.axes();
    return this.ask("rays:closest", {image: "visits", generator: {kind: "pinhole", position: this.view.pose.slice(0, 3), forward: forward.toArray(),
      up: up.toArray(), fov_y: this.view.camera.fov, width: Math.round(ROWS * this.view.camera.aspect), height: ROWS}});
  }

  levels() {
    ++this.level;
    return this.ask("bvh", {level: this.level});
  }

  async scan(x, y) {
    const point = await this.pointAt(x, y);
    return point ? this.ask("rays:closest", sweepAt(point)) : this.say("Nothing is there. Click on the scene.");
  }

  async sight(x, y) {
    const point = await this.pointAt(x, y);
    if (!point) return this.say("Nothing is there. Click on the scene.");
    if (!this.first) {
      this.first = point;
      this.marks.show([{kind: "point", points: [point], label: "from here"}]);
      return this.say("Click the second point.");
    }
    const from = this.first;
    this.first = null;
    this.say(HINTS.sight);
    return this.ask("visibility", {from: [from], to: [point], pairing: "each", first_blocker: true,
      fields: ["t", "distance", "position", "node", "material"]});
  }
}

const PIXELS = 12;  // within which a point snaps

/** The corner, or the point of an edge, that lies near a hit on the screen: {point, kind}. */
export function snap(view, hit, corners) {
  const [x, y] = view.pixel(hit.position);
  const away = (p) => Math.hypot(view.pixel(p)[0] - x, view.pixel(p)[1] - y);
  const nearest = (points) => points.reduce((best, p) => away(p) < away(best) ? p : best);
  const corner = nearest(corners);
  if (away(corner) <= PIXELS) return {point: corner, kind: "corner"};
  const feet = corners.map((a, i) => {
    const b = corners[(i + 1) % 3];
    const along = a.reduce((sum, from, k) => sum + (hit.position[k] - from) * (b[k] - from), 0) / (length(a, b) ** 2 || 1);
    const s = Math.min(1, Math.max(0, along));
    return a.map((from, k) => from + s * (b[k] - from));
  });
  const foot = nearest(feet);
  return away(foot) <= PIXELS * 0.7 ? {point: foot, kind: "edge"} : {point: hit.position, kind: "surface"};
}
