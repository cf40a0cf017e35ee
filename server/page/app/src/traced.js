// The view as pictures that the server traces: until triangles are drawn, for scenes that are too large to send, and to see
// what rays see.

import {ask, scenePath} from "./api.js";

const ROWS = [90, 180, 360, 720];  // of the pictures, one after the other while the camera rests

/** The numbers of a PFM picture, one or three for each pixel, rows from the bottom: [width, height, floats]. */
export function readFloatMap(buffer) {
  const head = new TextDecoder("ascii").decode(new Uint8Array(buffer, 0, Math.min(64, buffer.byteLength)));
  const [all, width, height] = head.match(/^P[Ff]\n(\d+) (\d+)\n-1(?:\.0+)?\n/) || [];
  if (!all) throw new Error("the picture is no little-endian PFM");
  return [Number(width), Number(height), new Float32Array(buffer.slice(all.length))];
}

export class Traced {
  constructor(canvas, view, fail) {
    Object.assign(this, {canvas, view, fail, scene: "", level: 0, wanted: 0});
  }

  /** An empty name ends it; no picture has more rows than `most`. `first` comes when one is drawn. */
  use(scene, most = ROWS.at(-1)) {
    if (scene === this.scene && most === this.most) return;
    Object.assign(this, {scene, most, place: ""});
    this.first = new Promise((resolve) => { this.standing = resolve; });
    this.canvas.hidden = !scene;
    this.moved();
  }

  /** Nothing finer comes; the picture stays. */
  hold() { this.most = 0; }

  /** The camera has moved, or the size has changed: coarse again. */
  moved() {
    const place = JSON.stringify([this.scene, this.view.pose, this.view.camera.aspect]);
    if (place === this.place) return;
    this.place = place;
    this.level = 0;
    delete this.canvas.dataset.rows;
    delete this.canvas.dataset.finest;
    if (this.scene && !this.busy) this.trace();
  }

  async trace() {
    this.busy = true;
    try {
      while (this.scene && this.level < ROWS.length) {
        const {place} = this, rows = ROWS[this.level];
        if (rows > this.most || this.level > 0 && rows > this.canvas.parentElement.clientHeight * 1.2) break;
        const picture = await this.picture(rows);
        // While the camera moves, the last picture is better than none.
        if (this.scene) this.draw(...picture);
        this.standing();
        if (place === this.place) {
          ++this.level;
          this.canvas.dataset.rows = String(rows);
        }
      }
      if (this.scene) this.canvas.dataset.finest = this.canvas.dataset.rows;
    } catch (fault) {
      this.fail(fault);
    } finally {
      this.busy = false;
    }
  }

  async picture(rows) {
    const {right, up, forward} = this.view.axes();
    this.axes = {right, up, forward};
    const generator = {kind: "pinhole", position: this.view.pose.slice(0, 3), forward: forward.toArray(), up: up.toArray(),
      fov_y: this.view.camera.fov, width: Math.max(1, Math.round(rows * this.view.camera.aspect)), height: rows};
    const answer = await ask(scenePath(this.scene, "/rays:closest"), {method: "POST", body: JSON.stringify({image: "normal", generator}),
      headers: {"Content-Type": "application/json", Accept: "image/x-portable-floatmap"}});
    return readFloatMap(await answer.arrayBuffer());
  }

  /** Each normal with a light at the camera and one from above; misses stay clear. */
  draw(width, height, normals) {
    const image = new ImageData(width, height);
    const {right, up, forward} = this.axes;
    const side = [0, 1, 2].map((k) => 0.3 * right.getComponent(k) + 0.5 * up.getComponent(k) - 0.8 * forward.getComponent(k));
    for (let row = 0; row < height; ++row) {
      for (let column = 0; column < width; ++column) {
        const from = 3 * ((height - 1 - row) * width + column), to = 4 * (row * width + column);
        const [x, y, z] = [normals[from], normals[from + 1], normals[from + 2]];
        if (x === 0 && y === 0 && z === 0) continue;
        const light = 60 + 130 * Math.abs(x * side[0] + y * side[1] + z * side[2]) + 35 * y;
        image.data.set([light, light * 0.97, light * 0.91, 255], to);
      }
    }
    this.canvas.width = width;
    this.canvas.height = height;
    this.canvas.getContext("2d").putImageData(image, 0, 0);
  }
}
