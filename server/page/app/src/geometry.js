// Triangles of a scene, in pieces of some megabytes, the nearest and largest meshes first (docs/reference/binary.md, "Geometry").

import {ask, scenePath} from "./api.js";

const TYPES = {1: Float64Array, 2: Uint32Array, 3: Uint8Array, 4: BigUint64Array, 5: BigInt64Array, 6: Float32Array};

/** Name -> typed array. */
export function readColumns(buffer) {
  const view = new DataView(buffer);
  if (view.getUint32(0) !== 0x534c4131) throw new Error("the answer does not begin with SLA1");
  const columns = {};
  for (let i = 0; i < view.getUint32(4, true); ++i) {
    const at = 16 + 40 * i;
    const name = String.fromCharCode(...new Uint8Array(buffer, at, 16)).replace(/\0+$/, "");
    const width = view.getUint32(at + 20, true), rows = Number(view.getBigUint64(at + 32, true));
    columns[name] = new TYPES[view.getUint32(at + 16, true)](buffer, Number(view.getBigUint64(at + 24, true)), rows * width);
  }
  return columns;
}

/** The numbers of "linear", whose bytes come apart: nine rows of one number for each placement. */
function joinedBytes(bytes) {
  const whole = new Uint8Array(bytes.length), count = bytes.length / 4;
  for (let plane = 0; plane < 4; ++plane) {
    for (let i = 0; i < count; ++i) whole[4 * i + plane] = bytes[plane * count + i];
  }
  return new Float32Array(whole.buffer);
}

async function page({scene, eye}, first, maxBytes, signal) {
  const answer = await ask(scenePath(scene, `/geometry?first=${first}&max_bytes=${maxBytes}&eye=${eye.join()}`), {signal});
  const revision = Number(answer.headers.get("X-Scene-Revision"));
  const columns = readColumns(await answer.arrayBuffer());
  columns.linear = joinedBytes(columns.linear);
  return {columns, revision, bytes: Number(columns.all_bytes[0])};
}

/** `of` is {scene, eye}. {columns, revision, bytes}; bytes are those of all pieces. */
export const firstPiece = (of, signal) => page(of, 0, 2 << 20, signal);

/** Calls take(columns) for each piece, the first of which is there. False when the scene was replaced meanwhile. */
export async function loadGeometry(of, first, signal, take) {
  for (let piece = first; ;) {
    const {next} = piece.columns;
    // The server works while the page does.
    const coming = next.length ? page(of, Number(next[0]), 8 << 20, signal) : null;
    coming?.catch(() => {});  // awaited below
    take(piece.columns);
    if (!coming) return true;
    piece = await coming;
    if (piece.revision !== first.revision) return false;
  }
}
