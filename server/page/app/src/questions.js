// The questions that the console can send, and what of their answers is drawn in the scene.

export const FIELDS = ["t", "distance", "instance", "primitive", "triangle", "position", "normal", "shading_normal",
  "barycentrics", "uv", "uv1", "tangent", "colour", "front", "on_edge", "node", "node_id",
  "node_path", "mesh", "mesh_id", "material", "material_id", "node_instance"];

const DOWN = [0, -1, 0];

/** Route -> a request to begin with. */
export const QUESTIONS = {
  "rays:closest": {rays: [{origin: [0, 100, 0], direction: DOWN}], fields: FIELDS},
  "rays:any": {rays: [{origin: [0, 100, 0], direction: DOWN}]},
  "rays:all": {rays: [{origin: [0, 100, 0], direction: DOWN}], max_hits: 20, fields: ["t", "position", "node"]},
  "rays:count": {rays: [{origin: [0, 100, 0], direction: DOWN}]},
  "visibility": {from: [[0, 50, 0]], to: [[10, 1, 10]], pairing: "each", first_blocker: true, fields: ["t", "position", "node"]},
  "points:closest": {points: [[0, 40, 0]], fields: ["distance", "position", "node", "on_edge"]},
  "points:nearest": {points: [[0, 40, 0]], count: 3, fields: ["distance", "position", "node", "triangle"]},
  "points:inside": {points: [[0, 10, 0]]},
  "points:distance": {points: [[0, 10, 0]]},
  "boxes:list": {boxes: [{min: [-5, 0, -5], max: [5, 20, 5]}], of: "nodes", limit: 50},
  "boxes:count": {boxes: [{min: [-5, 0, -5], max: [5, 20, 5]}]},
  "boxes:any": {boxes: [{min: [-5, 0, -5], max: [5, 20, 5]}]},
  "sweeps:closest": {sweeps: [{origin: [0, 100, 0], direction: DOWN, radius: 1}], fields: ["t", "position", "node"]},
  "bvh": {level: 1},
  "clearance": {a: {names: ["*"]}, b: {names: ["*"]}, max_distance: 1},
};

/** A request with its short lists in one line. */
export const pretty = (value) => JSON.stringify(value, null, 2).replace(/\[\s*([^[\]{}]+?)\s*\]/g,
  (_, inside) => `[${inside.split(/,\n\s*/).join(", ")}]`);

const MOST_DRAWN = 200;

export const length = (a, b) => Math.hypot(...a.map((x, k) => b[k] - x));

/** 12.345678 -> "12.35", 0.00012345 -> "0.0001235". */
export const short = (x) => x === null ? "none" : Number(x.toPrecision(4)).toString();

const isPoint = (p) => Array.isArray(p) && p.length === 3 && p.every(Number.isFinite);

/** Points that a query asks about: rows of them. */
function raysOf(query, name = "rays") {
  if (Array.isArray(query[name])) return query[name].slice(0, MOST_DRAWN);
  if (!Array.isArray(query.origins)) return [];
  const row = (list, i) => list.slice(3 * i, 3 * i + 3);
  const count = Math.min(MOST_DRAWN, query.origins.length / 3);
  return Array.from({length: count}, (_, i) => ({origin: row(query.origins, i), direction: row(query.directions, i)}));
}

function rayShapes(query, answer, size) {
  const hits = answer.hits || [];
  return raysOf(query).flatMap(({origin, direction}, i) => {
    if (!isPoint(origin) || !isPoint(direction)) return [];
    const scale = size / (Math.hypot(...direction) || 1);
    const t = typeof hits[i]?.t === "number" ? hits[i].t : scale;
    const end = hits[i]?.position || origin.map((x, k) => x + t * direction[k]);
    const is = hits[i] && typeof hits[i] === "object";
    return [{kind: "line", points: [origin, end], colour: is ? "ray" : "dim"}, ...(is ? hitShapes(hits[i], origin) : [])];
  });
}

function hitShapes(hit, origin) {
  if (!isPoint(hit.position)) return [];
  const shapes = [{kind: "point", points: [hit.position], label: hit.node || undefined}];
  if (isPoint(hit.normal)) {
    // About as long on the screen wherever it is.
    const tip = hit.position.map((x, k) => x + 0.06 * length(origin, hit.position) * hit.normal[k]);
    shapes.unshift({kind: "line", points: [hit.position, tip], colour: "normal"});
  }
  return shapes;
}

function sightShapes(query, answer) {
  const each = query.pairing === "each";
  return (query.from || []).slice(0, MOST_DRAWN).flatMap((from, i) =>
    (each ? [query.to[i]] : query.to.slice(0, MOST_DRAWN)).flatMap((to, j) => {
      if (!isPoint(from) || !isPoint(to)) return [];
      const seen = (each ? answer.visible[i] : answer.visible[i][j]) === "1";
      const blocker = (each ? answer.blockers?.[i] : answer.blockers?.[i]?.[j]) || null;
      const line = {kind: "line", points: [from, to], colour: seen ? "good" : "bad"};
      const ends = [from, to].map((p) => ({kind: "point", points: [p], colour: seen ? "good" : "bad"}));
      return [line, ...ends, ...(blocker && isPoint(blocker.position)
        ? [{kind: "point", points: [blocker.position], label: `blocked by ${blocker.node || "a triangle"}`}] : [])];
    }));
}

/** The three great circles of a sphere along the axes. */
function sphereShapes({center, radius}) {
  const POINTS = 48;
  return [0, 1, 2].map((axis) => ({kind: "loop", points: Array.from({length: POINTS}, (_, i) => {
    const angle = 2 * Math.PI * i / POINTS, point = [...center];
    point[(axis + 1) % 3] += radius * Math.cos(angle);
    point[(axis + 2) % 3] += radius * Math.sin(angle);
    return point;
  })}));
}

/** The lower and upper face of a box in the space of a mesh, from a corner and its neighbours along x, y and z. */
function facesFrom([corner, x, y, z]) {
  const far = x.map((value, k) => value + (z[k] - corner[k])), up = y.map((value, k) => value - corner[k]);
  const low = [corner, x, far, z];
  return [low, low.map((point) => point.map((value, k) => value + up[k]))];
}

function boxShapes({boxes = []}) {
  return boxes.slice(0, MOST_DRAWN).flatMap((box) => {
    if (Number.isFinite(box.radius) && isPoint(box.center)) return sphereShapes(box);
    const {min, max, corners} = box;
    if (!isPoint(min) || !isPoint(max)) return [];
    const face = (y) => [[min[0], y, min[2]], [max[0], y, min[2]], [max[0], y, max[2]], [min[0], y, max[2]]];
    const [low, high] = corners ? facesFrom(corners) : [face(min[1]), face(max[1])];
    return [{kind: "loop", points: low, thin: true}, {kind: "loop", points: high, thin: true},
      ...low.map((corner, i) => ({kind: "line", points: [corner, high[i]], thin: true}))];
  });
}

const VERDICTS = {entered: "good", missed: "dim", behind: "ray", beyond: "ray", farther: "normal"};

/**
 * The boxes that a ray came to, those that it entered on top. Entered leaves and box `now` have their number in the
 * order of the visit and their t.
 */
function visitShapes({boxes, now}) {
  const shown = boxes.map((box, i) => ({...box, number: i + 1}));
  const entered = shown.filter(({verdict}) => verdict === "entered");
  return [...shown.filter((box) => !entered.includes(box)), ...entered].flatMap((box) => {
    const shapes = boxShapes({boxes: [box]}).map((shape) => ({...shape, colour: VERDICTS[box.verdict], thin: box.verdict !== "entered" && box.number !== now}));
    if ((box.verdict === "entered" && box.leaf || box.number === now) && shapes.length) {
      shapes[1].label = box.t_enter === undefined ? `${box.number}` : `${box.number}: t ${short(box.t_enter)} to ${short(box.t_exit)}`;
    }
    return shapes;
  });
}

/** Rows of what a ray came to: number, verdict and reason. */
export function visitRows({boxes, truncated}) {
  const range = ({t_enter: from, t_exit: to}) => from === undefined ? "" : `, t ${short(from)} to ${short(to)}`;
  const tests = ({triangles: list = []}) => list.length
    ? `; ${list.length} triangles: ${list.filter(({verdict}) => verdict === "hit").length} hit` : "";
  const rows = boxes.map((box, i) => [String(i + 1), `${box.leaf ? "leaf" : "box"} ${box.verdict}${box.miss
    ? `: slabs ${box.miss.join(", ")}` : ""}${range(box)}${box.space === "mesh" ? ", in the space of a mesh" : ""}${tests(box)}`]);
  return truncated ? [...rows, ["...", "more boxes were visited"]] : rows;
}

function pointShapes({points = []}, answer) {
  return points.slice(0, MOST_DRAWN).flatMap((point, i) => {
    if (!isPoint(point)) return [];
    const found = answer.hits ? [answer.hits[i]] : answer.results?.[i]?.hits || [];
    const near = found.filter((each) => isPoint(each?.position));
    return [{kind: "point", points: [point], colour: "ray"},
      ...near.flatMap((each) => [{kind: "line", points: [point, each.position], label: short(each.distance)},
        {kind: "point", points: [each.position]}])];
  });
}

function clearanceShapes(answer) {
  return [answer.pair, ...(answer.pairs || [])].filter((pair) => isPoint(pair?.a?.position) && isPoint(pair?.b?.position))
    .slice(0, MOST_DRAWN).flatMap(({a, b, distance}) => [
      {kind: "line", points: [a.position, b.position], label: short(distance)},
      {kind: "point", points: [a.position]}, {kind: "point", points: [b.position]}]);
}

/** The boxes of a level: leaves green, others blue. */
function levelShapes({level}) {
  const MOST = 300;
  return (level?.boxes || []).slice(0, MOST).flatMap((box) =>
    boxShapes({boxes: [box]}).map((shape) => ({...shape, colour: box.leaf ? "good" : "normal"})));
}

/** One point that looks at many: its answer is drawn as points. */
export const isViewshed = (route, query) => route === "visibility" && query.from?.length === 1 && query.to?.length > 8;

/** The plane [nx, ny, nz, d] of a request for what lies in it; null for any other. */
export function planeOf(route, query) {
  const [one, other] = query.boxes?.[0]?.planes || [];
  const is = route === "boxes:list" && query.of === "triangles" && other?.length === 4 && one.every((x, k) => x === -other[k]);
  return is ? one : null;
}

/** Where the plane cuts a triangle: two points, or null where it only touches a corner. */
export function cutOf(corners, [nx, ny, nz, d]) {
  const away = corners.map(([x, y, z]) => nx * x + ny * y + nz * z - d);
  const points = [0, 1, 2].flatMap((i) => {
    const j = (i + 1) % 3;
    if (away[i] === 0) return [corners[i]];
    if (away[i] * away[j] >= 0) return [];
    const s = away[i] / (away[i] - away[j]);
    return [corners[i].map((x, k) => x + s * (corners[j][k] - x))];
  });
  return points.length === 2 ? points : null;
}

/** Shapes for Marks; `size` is the radius of the scene. */
export function shapesOf(route, query, answer, size) {
  if (route === "rays:all") {
    const hits = (answer.results || []).slice(0, MOST_DRAWN).flatMap(({hits: list}) => list);
    const last = raysOf(query).map(({origin, direction}, i) => {
      const t = answer.results?.[i]?.hits.at(-1)?.t ?? size / (Math.hypot(...direction) || 1);
      return {kind: "line", points: [origin, origin.map((x, k) => x + t * direction[k])], colour: "ray"};
    });
    return [...last, ...hits.filter((hit) => isPoint(hit.position)).map((hit) => ({kind: "point", points: [hit.position]}))];
  }
  if (route.startsWith("rays:")) return [...answer.explain ? visitShapes(answer.explain) : [], ...rayShapes(query, answer, size)];
  if (route === "bvh") return levelShapes(answer);
  if (isViewshed(route, query)) return [{kind: "point", points: [query.from[0]], label: "from here"}];
  if (route === "visibility") return sightShapes(query, answer);
  if (route.startsWith("boxes:")) return boxShapes(query);
  if (route.startsWith("points:")) return pointShapes(query, answer);
  if (route === "clearance") return clearanceShapes(answer);
  if (route.startsWith("sweeps:")) return rayShapes({rays: raysOf(query, "sweeps")}, answer, size);
  return [];
}

/** One line that says what came out. */
export function outcomeOf(route, query, answer) {
  const one = answer.hits?.length === 1 ? answer.hits[0] : undefined;
  if (answer.warnings?.length) return answer.warnings[0].message;
  if (route === "rays:closest" || route.startsWith("sweeps:")) {
    const visited = answer.explain ? ` ${answer.explain.boxes.length} boxes visited.` : "";
    if (one === null || one === false) return `No hit.${visited}`;
    if (one && one.node !== undefined) return `Hit: ${one.node || "a node without a name"}, t = ${short(one.t)}.${visited}`;
    if (answer.hits) return `${answer.hits.filter(Boolean).length} of ${answer.hits.length} rays hit.`;
  }
  if (route === "visibility" && typeof answer.visible === "string" && answer.visible.length === 1) {
    if (answer.visible === "1") return "The two points see each other.";
    return `Blocked by ${answer.blockers?.[0]?.node || "a triangle"}.`;
  }
  if (route === "bvh" && answer.level) {
    const {boxes} = answer.level;
    return `Level ${query.level}: ${boxes.length}${answer.level.truncated ? " and more" : ""} box${boxes.length === 1 ? "" : "es"}, ${
      boxes.filter(({leaf}) => leaf).length} of them leaves.`;
  }
  if (isViewshed(route, query) && typeof answer.visible?.[0] === "string") {
    return `${answer.visible[0].replaceAll("0", "").length} of ${query.to.length} points are seen.`;
  }
  if (route === "clearance") {
    return answer.pair ? `Clearance ${answer.pair.distance} between ${answer.pair.a.node || "a node"} and ${answer.pair.b.node || "a node"}.`
      : answer.pairs ? `${answer.total} pairs.` : "No pair is so near.";
  }
  if (planeOf(route, query) && answer.results?.length === 1) return `The plane cuts ${answer.results[0].total} triangles.`;
  if (route === "boxes:list" && answer.results?.length === 1) {
    const [{total}] = answer.results;
    const what = query.of === "nodes" ? "node" : "triangle";
    return `${total} ${what}${total === 1 ? "" : "s"} selected.`;
  }
  if (answer.counts?.length === 1) return `Count: ${answer.counts[0]}.`;
  return "Answered.";
}
