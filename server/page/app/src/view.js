// The 3-D view. Everything drawn is relative to the middle of the scene, in the float64 of JavaScript, so that a
// scene far from the origin stands still.

import {
  BufferAttribute, BufferGeometry, Color, DirectionalLight, DoubleSide, HemisphereLight, InstancedMesh, Matrix4, Mesh,
  MeshLambertMaterial, PerspectiveCamera, Plane, Points, PointsMaterial, Scene, Spherical, Vector3, WebGLRenderer,
} from "three";
import {OrbitControls} from "three/examples/jsm/controls/OrbitControls.js";

const FEW = 300;  // placements that are drawn one by one, with float64 matrices

export class View {
  constructor(canvas, onDraw) {
    this.canvas = canvas;
    this.onDraw = onDraw;
    this.renderer = new WebGLRenderer({canvas, antialias: !drawnBySoftware()});
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(45, 1, 0.1, 1000);
    const head = new DirectionalLight(0xffffff, 1.6);
    head.position.set(0.4, 0.7, 1);
    this.camera.add(head);
    this.scene.add(this.camera, new HemisphereLight(0xffffff, 0x8a8478, 1.5));
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.draw());
    this.controls.addEventListener("start", () => this.begun());
    this.controls.addEventListener("end", () => this.ended());
    this.material = new MeshLambertMaterial({vertexColors: true, flatShading: true, side: DoubleSide});
    this.middle = [0, 0, 0];
    this.radius = 1;
    this.triangles = 0;
    this.warm();
    this.share = 1;  // of the pixels' rows and columns that are drawn
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  /** Draws both kinds of meshes before the first scene is there: GL then makes its programs while the server answers. */
  warm() {
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(new Float32Array(9), 3));
    geometry.setAttribute("color", new BufferAttribute(new Uint8Array(9), 3, true));
    geometry.setIndex(new BufferAttribute(new Uint16Array([0, 1, 2]), 1));
    for (const mesh of [new Mesh(geometry, this.material), new InstancedMesh(geometry, this.material, 1)]) {
      mesh.frustumCulled = false;
      this.scene.add(mesh);
    }
  }

  // While the camera is dragged, slow machines draw fewer pixels.
  begun() {
    this.last = 0;
    this.dragged = true;
  }
  ended() {
    this.dragged = false;
    if (this.share === 1) return;
    this.share = 1;
    this.resize();
  }
  measure(now) {
    const SLOW = 70, COARSEST = 0.35;  // milliseconds of a frame; share of the pixels' rows
    if (this.dragged && this.last && now - this.last > SLOW && this.share > COARSEST) {
      this.share = Math.max(COARSEST, this.share * 0.7);
      this.resize();
    }
    this.last = now;
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas.parentElement;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2) * this.share);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  /** Draws once with the next frame. */
  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => {
      this.waiting = false;
      this.measure(now);
      const distance = this.camera.position.length();
      this.camera.near = Math.max(distance - this.radius, this.radius * 1e-4);
      this.camera.far = distance + this.radius * 1.01;
      this.camera.updateProjectionMatrix();
      this.renderer.render(this.scene, this.camera);
      this.onDraw();
    });
  }

  /** Once all that was asked to be drawn is on the screen, not only sent there. */
  async drawn() {
    const gl = this.renderer.getContext();
    while (this.waiting) await new Promise((resolve) => requestAnimationFrame(resolve));
    const done = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    while (gl.clientWaitSync(done, 0, 0) === gl.TIMEOUT_EXPIRED) await new Promise((resolve) => setTimeout(resolve, 4));
    gl.deleteSync(done);
  }

  setBackground(colour) {
    this.scene.background = new Color(colour);
    this.draw();
  }

  /** Takes everything out; bounds are those of the new scene, or null. */
  begin(bounds) {
    for (const each of this.scene.children.filter((child) => child.isMesh)) {
      this.scene.remove(each);
      each.geometry.dispose();
      if (each.isInstancedMesh) each.dispose();
    }
    this.showPoints(null);
    this.triangles = 0;
    const {min, max} = bounds || {min: [-1, -1, -1], max: [1, 1, 1]};
    this.middle = min.map((low, k) => low / 2 + max[k] / 2);
    this.radius = Math.hypot(...min.map((low, k) => max[k] / 2 - low / 2)) || 1;
    this.controls.minDistance = this.radius * 1e-4;
    this.controls.maxDistance = this.radius * 20;
  }

  home() {
    const target = [0, 0, 0];
    const distance = this.radius / Math.sin(Math.PI / 8) / Math.min(1, this.camera.aspect) * 0.62;
    const direction = new Vector3(0.62, 0.48, 0.9).normalize().multiplyScalar(distance);
    this.place(direction.toArray(), target);
  }

  place(position, target) {
    this.camera.position.fromArray(position);
    this.controls.target.fromArray(target);
    this.controls.update();
    this.draw();
  }

  // For the keyboard.
  turn(x, y) {
    const from = this.camera.position.clone().sub(this.controls.target);
    const sphere = new Spherical().setFromVector3(from);
    sphere.theta -= 0.1 * x;
    sphere.phi = Math.min(Math.PI - 0.01, Math.max(0.01, sphere.phi - 0.1 * y));
    this.camera.position.copy(this.controls.target).add(from.setFromSpherical(sphere));
    this.controls.update();
    this.draw();
  }
  pan(x, y) {
    const {right, up} = this.axes();
    const step = 0.08 * this.camera.position.distanceTo(this.controls.target);
    const by = right.multiplyScalar(x * step).addScaledVector(up, -y * step);
    this.camera.position.add(by);
    this.controls.target.add(by);
    this.controls.update();
    this.draw();
  }
  zoom(factor) {
    const from = this.camera.position.clone().sub(this.controls.target);
    this.camera.position.copy(this.controls.target).add(from.multiplyScalar(factor));
    this.controls.update();
    this.draw();
  }

  /** Where the camera stands and what it turns around, in the world. */
  get pose() {
    // The numbers of a link as they are, until the camera moves.
    const {position} = this.camera, {target} = this.controls;
    if (this.given && this.given.position.equals(position) && this.given.target.equals(target)) return this.given.numbers;
    const world = (v) => v.toArray().map((x, k) => x + this.middle[k]);
    return [...world(this.camera.position), ...world(this.controls.target)];
  }

  set pose(numbers) {
    const local = (at) => this.middle.map((x, k) => numbers[at + k] - x);
    this.place(local(0), local(3));
    this.given = {numbers, position: this.camera.position.clone(), target: this.controls.target.clone()};
  }

  // ---- Triangles

  /** The next draw() shows them. */
  add(columns) {
    const {mesh_id: meshes, placed_mesh: placed} = columns;
    const placements = Array.from(meshes, () => []);
    placed.forEach((mesh, i) => placements[mesh].push(i));
    const parts = Array.from(meshes, () => []);
    columns.part_mesh.forEach((mesh, part) => parts[mesh].push(part));
    meshes.forEach((_, row) => this.addMesh(columns, row, parts[row], placements[row], placed.length > FEW));
  }

  addMesh(columns, row, parts, placements, many) {
    const [from, to] = [0, 1].map((k) => Number(columns.first_position[row + k]));
    const [begin, end] = [0, 1].map((k) => Number(columns.first_triangle[row + k]));
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new BufferAttribute(columns.positions.slice(3 * from, 3 * to), 3));
    geometry.setAttribute("color", new BufferAttribute(coloursOf(columns, row, parts, begin, to - from), 3, true));
    const wide = columns.indices.subarray(3 * begin, 3 * end);
    geometry.setIndex(new BufferAttribute(to - from > 65536 ? wide.slice() : new Uint16Array(wide), 1));
    this.triangles += (end - begin) * placements.length;
    const add = (mesh) => {
      // The sphere of three.js would have to be computed, and NaN positions would break it.
      mesh.frustumCulled = false;
      mesh.matrixAutoUpdate = false;
      this.scene.add(mesh);
      return mesh;
    };
    if (many && placements.length > 1) {
      const mesh = add(new InstancedMesh(geometry, this.material, placements.length));
      placements.forEach((each, i) => mesh.setMatrixAt(i, this.matrixOf(columns, each)));
    } else {
      for (const each of placements) {
        const mesh = add(new Mesh(geometry, this.material));
        mesh.matrix.copy(this.matrixOf(columns, each));
        mesh.matrixWorldNeedsUpdate = true;
      }
    }
  }

  /** From positions relative to the mesh's origin to positions relative to the middle of the scene. */
  matrixOf({linear, at}, placement) {
    const count = linear.length / 9, m = Array.from({length: 9}, (_, k) => linear[k * count + placement]);
    const [x, y, z] = this.middle.map((middle, k) => at[3 * placement + k] - middle);
    return new Matrix4().set(m[0], m[1], m[2], x, m[3], m[4], m[5], y, m[6], m[7], m[8], z, 0, 0, 0, 1);
  }

  /** Draws only what has n . x <= d for [nx, ny, nz, d]; null draws all. */
  cut(plane) {
    // A wall in the plane itself is drawn as a whole, not where rounding lets it.
    const THICK = 1e-5 * this.radius;
    const local = plane && plane[3] + THICK - [0, 1, 2].reduce((sum, k) => sum + plane[k] * this.middle[k], 0);
    this.renderer.clippingPlanes = plane ? [new Plane(new Vector3(-plane[0], -plane[1], -plane[2]), local)] : [];
    this.draw();
  }

  /** Points of the world with hues; null takes them away. */
  showPoints(positions, colours) {
    if (this.points) {
      this.scene.remove(this.points);
      this.points.geometry.dispose();
      this.points.material.dispose();
      this.points = null;
    }
    if (positions) {
      const geometry = new BufferGeometry();
      const local = positions.flatMap((p) => p.map((x, k) => x - this.middle[k]));
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(local), 3));
      geometry.setAttribute("color", new BufferAttribute(new Float32Array(colours.flatMap((hsl) => new Color().setHSL(...hsl).toArray())), 3));
      this.points = new Points(geometry, new PointsMaterial({size: 4, sizeAttenuation: false, vertexColors: true}));
      this.points.frustumCulled = false;
      this.scene.add(this.points);
    }
    this.draw();
  }

  // ---- Between pixels and the world

  axes() {
    this.camera.updateMatrixWorld();
    const [right, up, back] = [new Vector3(), new Vector3(), new Vector3()];
    this.camera.matrixWorld.extractBasis(right, up, back);
    return {right, up, forward: back.negate()};
  }

  /** x and y of a pixel of the canvas, -1 to 1. */
  normalized(x, y) {
    const {clientWidth, clientHeight} = this.canvas;
    return [2 * x / clientWidth - 1, 1 - 2 * y / clientHeight];
  }

  /** The ray through a pixel, in the world. Its part along the view is 1, so t is the depth. */
  ray(x, y) {
    const [nx, ny] = this.normalized(x, y);
    const {right, up, forward} = this.axes();
    const tan = Math.tan(this.camera.fov / 2 * Math.PI / 180);
    const direction = forward.addScaledVector(right, nx * tan * this.camera.aspect).addScaledVector(up, ny * tan);
    return {origin: this.pose.slice(0, 3), direction: direction.toArray()};
  }

  /** World points -> [x, y, depth] in pixels of the canvas; depth is at most 0 behind the camera. */
  pixel(world) {
    const p = this.toCamera(world);
    return [...this.flat(p), p.z];
  }

  /** z along the view. */
  toCamera(world) {
    const v = new Vector3(...world.map((x, k) => x - this.middle[k]));
    v.applyMatrix4(this.camera.matrixWorldInverse);
    return {x: v.x, y: v.y, z: -v.z};
  }

  flat({x, y, z}) {
    const tan = Math.tan(this.camera.fov / 2 * Math.PI / 180);
    const {clientWidth, clientHeight} = this.canvas;
    return [(x / (z * tan * this.camera.aspect) + 1) / 2 * clientWidth, (1 - y / (z * tan)) / 2 * clientHeight];
  }

  /** The pixels of a line's part in front of the camera; null without any. */
  segment(a, b) {
    let [p, q] = [this.toCamera(a), this.toCamera(b)];
    const near = this.camera.near / 2;
    if (p.z < near && q.z < near) return null;
    const cut = (from, to) => {
      const s = (near - from.z) / (to.z - from.z);
      return {x: from.x + s * (to.x - from.x), y: from.y + s * (to.y - from.y), z: near};
    };
    if (p.z < near) p = cut(p, q);
    if (q.z < near) q = cut(q, p);
    return [this.flat(p), this.flat(q)];
  }

  /** The planes of a rectangle of pixels seen from the camera, each [nx, ny, nz, d] with n . x <= d. */
  pyramid(x0, y0, x1, y1) {
    const corner = (x, y) => new Vector3(...this.ray(x, y).direction);
    const corners = [corner(x0, y0), corner(x1, y0), corner(x1, y1), corner(x0, y1)];
    const inside = corners.reduce((sum, each) => sum.add(each), new Vector3());
    const apex = this.pose.slice(0, 3);
    const plane = (n) => {
      const normal = n.normalize().toArray();
      return [...normal, normal.reduce((sum, each, k) => sum + each * apex[k], 0)];
    };
    const sides = corners.map((each, i) => {
      const normal = each.clone().cross(corners[(i + 1) % 4]);
      return plane(normal.dot(inside) > 0 ? normal.negate() : normal);
    });
    const far = plane(this.axes().forward);
    far[3] += this.camera.far;
    return [...sides, far];
  }
}

/** Software GL takes four times as long with antialiasing. */
function drawnBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl?.getExtension("WEBGL_debug_renderer_info");
  return Boolean(gl) && /SwiftShader|llvmpipe|softpipe|Basic Render/.test(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}

/** One colour for each vertex, linear, as the parts of the mesh say. */
function coloursOf(columns, row, parts, begin, vertices) {
  const colours = new Uint8Array(3 * vertices);
  for (const part of parts) {
    const colour = partColour(columns, row, part).map((x) => Math.round(255 * Math.min(1, Math.max(0, x))));
    const first = 3 * (begin + columns.part_first[part]);
    for (let i = first; i < first + 3 * columns.part_triangles[part]; ++i) colours.set(colour, 3 * columns.indices[i]);
  }
  return colours;
}

/** What the file says. What it leaves white is told apart by soft colours of materials, or else of meshes. */
function partColour(columns, row, part) {
  const material = columns.material_id[part];
  const given = Array.from(columns.colour.subarray(4 * part, 4 * part + 3));
  if (material !== 0xffffffff && given.some((x) => x !== 1)) return given;
  const GOLDEN = 0.618033988749895;
  const [number, strength] = material === 0xffffffff ? [columns.mesh_id[row], 0.16] : [material, 0.32];
  return new Color().setHSL((0.09 + number * GOLDEN) % 1, strength, 0.62).toArray();
}
