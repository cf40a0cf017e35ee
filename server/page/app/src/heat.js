// The picture of how many boxes the ray of each pixel visits.

import {readFloatMap} from "./traced.js";

/** Red, green and blue of a share of the most: from blue by green to red. */
export function shadeOf(share) {
  return [3, 2, 1].map((top) => Math.round(255 * Math.min(1, Math.max(0, 1.5 - Math.abs(4 * share - top)))));
}

/** Draws it, and says how many there are. */
export function drawHeat(canvas, picture) {
  const [width, height, visits] = readFloatMap(picture);
  const [least, most] = [visits.reduce((a, b) => Math.min(a, b)), visits.reduce((a, b) => Math.max(a, b))];
  const image = new ImageData(width, height);
  for (let row = 0; row < height; ++row) {
    for (let column = 0; column < width; ++column) {
      const count = visits[(height - 1 - row) * width + column];
      image.data.set([...shadeOf(count / most), 255], 4 * (row * width + column));
    }
  }
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(image, 0, 0);
  const mean = visits.reduce((a, b) => a + b, 0) / visits.length;
  return `Each ray visits ${least} to ${most} boxes, ${mean.toFixed(1)} on average.`;
}
