// What is drawn over the view: points, lines and outlines in the world, with labels. Positions are projected in float64.

const HALO = 3;

export class Marks {
  constructor(canvas, view) {
    this.canvas = canvas;
    this.view = view;
    this.shapes = [];
    this.rectangle = null;  // of pixels, while it is dragged
    this.rubber = null;  // two pixels, while a distance is dragged
    this.cross = null;  // the pixel that the keyboard uses
  }

  /** shapes: {kind: "point" | "line" | "loop", points: [[x, y, z], ...], colour: name of a CSS variable, label, thin} */
  show(shapes) {
    this.shapes = shapes;
    // For tests: what is drawn.
    this.canvas.dataset.shapes = JSON.stringify(shapes.slice(0, 2000));
    this.draw();
  }

  draw() {
    const {canvas, view} = this;
    const {clientWidth: width, clientHeight: height} = canvas.parentElement;
    const scale = Math.min(devicePixelRatio, 2);
    // With software GL, Chromium shows the last picture on where a canvas is cleared and nothing is drawn after it.
    canvas.dataset.cross = this.cross?.join() || "";
    canvas.hidden = !this.shapes.length && !this.rectangle && !this.rubber && !this.cross;
    if (canvas.hidden) return;
    // This clears it.
    canvas.width = width * scale;
    canvas.height = height * scale;
    const context = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(`--${name}`).trim();
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.font = "13px system-ui, sans-serif";
    context.lineJoin = context.lineCap = "round";
    const stroke = (path, shade, thickness, halo = HALO) => {
      context.strokeStyle = colour("halo");
      context.lineWidth = thickness + halo;
      context.stroke(path);
      context.strokeStyle = shade;
      context.lineWidth = thickness;
      context.stroke(path);
    };
    for (const shape of this.shapes) {
      const shade = colour(shape.colour || "hit");
      if (shape.kind === "point") this.point(context, shape, shade, stroke);
      else if (shape.thin) this.lines(shape, (path) => stroke(path, shade, 1, 1));
      else this.lines(shape, (path) => stroke(path, shade, 2));
    }
    const taken = [], room = roomOf(canvas.parentElement);
    // Those that were added last, above all the hit itself, are placed first.
    for (const shape of this.shapes.filter(({label}) => label).reverse()) this.label(context, shape, colour, width, room, taken);
    if (this.rectangle) {
      const [x0, y0, x1, y1] = this.rectangle;
      const path = new Path2D();
      path.rect(Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0));
      context.fillStyle = colour("veil");
      context.fill(path);
      stroke(path, colour("hit"), 1);
    }
    if (this.rubber) {
      const path = new Path2D();
      path.moveTo(...this.rubber[0]);
      path.lineTo(...this.rubber[1]);
      stroke(path, colour("hit"), 2);
    }
    if (this.cross) {
      const [x, y] = this.cross, ARM = 12, GAP = 3;
      const path = new Path2D();
      for (const [dx, dy] of [[1, 0], [-1, 0], [0, 1], [0, -1]]) {
        path.moveTo(x + GAP * dx, y + GAP * dy);
        path.lineTo(x + ARM * dx, y + ARM * dy);
      }
      stroke(path, colour("text"), 1);
    }
  }

  point(context, {points: [at]}, shade, stroke) {
    const [x, y, depth] = this.view.pixel(at);
    if (depth <= 0) return;
    const path = new Path2D();
    path.arc(x, y, 4.5, 0, 2 * Math.PI);
    stroke(path, shade, 2);
  }

  lines({kind, points}, stroke) {
    const path = new Path2D();
    const count = kind === "loop" ? points.length : points.length - 1;
    for (let i = 0; i < count; ++i) {
      const seen = this.view.segment(points[i], points[(i + 1) % points.length]);
      if (!seen) continue;
      path.moveTo(...seen[0]);
      path.lineTo(...seen[1]);
    }
    stroke(path);
  }

  /** Beside its point, or as near as no other label is; `taken` are the places of those; `room` is [top, bottom]. */
  label(context, {points, label}, colour, width, [ceiling, floor], taken) {
    const middle = points[0].map((_, k) => points.reduce((sum, p) => sum + p[k] / points.length, 0));
    const [x, y, depth] = this.view.pixel(middle);
    if (depth <= 0) return;
    label = cutTo(context, label, width - 20);
    const wide = context.measureText(label).width + 12;
    const left = Math.min(Math.max(x + 10, 4), Math.max(4, width - wide - 4));
    const free = (top) => taken.every((other) =>
      left + wide < other.left || other.left + other.wide < left || Math.abs(top - other.top) > 24);
    const tops = [-30, 8, -56, 34, -82].map((dy) => Math.max(Math.min(y + dy, floor - 26), ceiling));
    const top = tops.find(free) ?? tops[0];
    taken.push({left, top, wide});
    context.fillStyle = colour("back");
    context.strokeStyle = colour("line");
    context.lineWidth = 1;
    context.beginPath();
    context.roundRect(left, top, wide, 22, 4);
    context.fill();
    context.stroke();
    context.fillStyle = colour("text");
    context.fillText(label, left + 6, top + 15);
  }
}

/** Between the buttons over the view and the words below. */
function roomOf(stage) {
  const [tools, below] = ["#tools", "#below"].map((id) => stage.querySelector(id));
  return [tools.offsetTop + tools.offsetHeight + 4, below.offsetTop - 4];
}

/** The text, or as much of its begin as fits into so many pixels. */
function cutTo(context, text, most) {
  if (context.measureText(text).width <= most) return text;
  const letters = Array.from(text);
  while (letters.length && context.measureText(`${letters.join("")}...`).width > most) letters.length = Math.floor(letters.length * 0.9);
  return `${letters.join("")}...`;
}
