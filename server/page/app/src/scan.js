// A LiDAR sweep: where the sensor stands, the colours of its points, and the points as a PLY file.

/** A request for a sweep around a place. */
export function sweepAt(position) {
  const RINGS = 33, STEP = 2;
  const elevations = Array.from({length: RINGS}, (_, i) => STEP * i - (RINGS - 1));
  return {generator: {kind: "lidar", position, elevations, azimuths: 360, range: [0, null]}, fields: ["distance", "position", "node_id"]};
}

/** The hits of an answer in columns: {positions, distances, nodes}, or null where it is none of a sweep. */
export function pointsOf(query, {position, distance, node_id: node}) {
  if (query.generator?.kind !== "lidar" || !position || !distance || !node) return null;
  const found = distance.flatMap((d, i) => d === null ? [] : [i]);
  return {positions: found.map((i) => position.slice(3 * i, 3 * i + 3)), distances: found.map((i) => distance[i]), nodes: found.map((i) => node[i])};
}

/** Hue, saturation and lightness of each point. */
export function coloursOf({distances, nodes}, by) {
  const GOLDEN = 0.618033988749895;
  if (by === "node") return nodes.map((node) => [(node * GOLDEN) % 1, 0.65, 0.5]);
  // Near is red, far is blue; the far half of a sweep has few points.
  const most = distances.reduce((a, b) => Math.max(a, b), 0) || 1;
  return distances.map((d) => [0.66 * Math.sqrt(d / most), 0.85, 0.48]);
}

export function plyOf({positions, distances, nodes}) {
  const head = `ply
format ascii 1.0
element vertex ${positions.length}
property double x
property double y
property double z
property double distance
property int node_id
end_header
`;
  return head + positions.map((p, i) => `${p.join(" ")} ${distances[i]} ${nodes[i]}\n`).join("");
}
