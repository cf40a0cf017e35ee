// The list of scenes: states, uploads, deletion, and the nodes of the chosen one.

import {ask, askJson, put, scenePath} from "./api.js";
import {byId, bytesText, countText, make} from "./dom.js";

export class Scenes {
  /** choose(id) is called when somebody takes a scene, showNode(node) for a node, changed() after each list. */
  constructor({choose, changed, fail, showNode}) {
    Object.assign(this, {choose, changed, fail, showNode, all: [], current: ""});
    byId("file").addEventListener("change", (event) => {
      this.upload([...event.target.files]);
      event.target.value = "";
    });
    for (const name of ["dragover", "drop"]) {
      addEventListener(name, (event) => {
        if (!event.dataTransfer?.types.includes("Files")) return;
        event.preventDefault();
        byId("drop").classList.toggle("over", name === "dragover");
        if (name === "drop") this.upload([...event.dataTransfer.files]);
      });
    }
    addEventListener("dragleave", (event) => { if (!event.relatedTarget) byId("drop").classList.remove("over"); });
    byId("nodes-part").addEventListener("toggle", () => this.showNodes());
    byId("node-search").addEventListener("input", () => this.listNodes());
  }

  find(id) { return this.all.find((scene) => scene.id === id); }

  /** Asks again and again, also after a failure: the server may be back. */
  async refresh() {
    clearTimeout(this.timer);
    const later = (milliseconds) => {
      this.timer = setTimeout(() => this.refresh().then(() => {
        if (this.lost) this.fail(null);
        this.lost = false;
      }, (fault) => {
        this.lost = true;
        this.fail(fault);
      }), milliseconds);
    };
    later(5000);
    const {scenes} = await askJson("/v1/scenes");
    this.all = scenes;
    this.draw();
    await this.changed();
    const busy = scenes.some((scene) => scene.update || !["ready", "failed", "stored"].includes(scene.state));
    clearTimeout(this.timer);
    later(busy ? 500 : 10000);
  }

  draw() {
    const rows = this.all.map((scene) => {
      const current = scene.id === this.current;
      const take = make("button", {type: "button", class: "take", "aria-current": String(current), "data-scene": scene.id},
        make("span", {class: "name"}, scene.id), make("span", {class: "about"}, aboutScene(scene)));
      take.disabled = scene.state !== "ready";
      take.addEventListener("click", () => this.choose(scene.id));
      const remove = make("button", {type: "button", class: "quiet", "aria-label": `Delete ${scene.id}`, title: "Delete"}, "\u00d7");
      remove.addEventListener("click", () => this.remove(remove, scene.id));
      return make("li", {class: current ? "current" : ""}, take, remove);
    });
    // Whoever is about to press a button still finds it there.
    const text = JSON.stringify([this.all, this.current]);
    if (text === this.shown) return;
    this.shown = text;
    byId("list").replaceChildren(...rows);
    if (!rows.length) byId("list").append(make("li", {class: "empty"}, "No scenes yet."));
  }

  /** Asks once more in the same place before it deletes. */
  async remove(button, id) {
    if (button.textContent !== "Delete?") {
      button.textContent = "Delete?";
      setTimeout(() => { button.textContent = "\u00d7"; }, 4000);
      return;
    }
    try {
      await ask(scenePath(id), {method: "DELETE"});
      await this.refresh();
    } catch (fault) {
      this.fail(fault);
    }
  }

  /** The file's name as a scene may be called; "scene-1" and so on where nothing of it is left. */
  idOf(file) {
    const id = file.replace(/\.(glb|gltf)$/i, "").replace(/[^A-Za-z0-9._-]+/g, "-").replace(/^[.-]+|-+$/g, "").slice(0, 128);
    if (id) return id;
    for (let number = 1; ; ++number) {
      if (!this.find(`scene-${number}`)) return `scene-${number}`;
    }
  }

  async upload(files) {
    for (const file of files) {
      const id = this.idOf(file.name);
      const type = /\.gltf$/i.test(file.name) ? "model/gltf+json" : "model/gltf-binary";
      const say = (text) => { byId("upload").textContent = text; };
      try {
        say(`${file.name}: 0%`);
        await put(scenePath(id, "?wait=0"), file, type,
          (sent, all) => say(`${file.name}: ${Math.floor(100 * sent / (all || 1))}% of ${bytesText(all)}`));
        say(`${file.name} was sent.`);
        await this.refresh();
        this.chooseWhenReady(id);
      } catch (fault) {
        say(`${file.name}: ${fault.message}`);
      }
    }
  }

  async chooseWhenReady(id) {
    try {
      const scene = await askJson(scenePath(id, "?wait=600"));
      await this.refresh();
      if (scene.state === "ready" && !scene.update) this.choose(id);
      else if (scene.reason) byId("upload").textContent = `${id}: ${scene.reason.detail}`;
    } catch (fault) {
      this.fail(fault);
    }
  }

  // ---- Nodes

  /** The nodes of the chosen scene, with their depth in the tree. */
  async loadNodes() {
    const of = `${this.current} ${this.find(this.current)?.revision}`;
    if (this.nodesOf === of) return this.nodes;
    const {nodes} = await askJson(scenePath(this.current, "/nodes?limit=20000"));
    const depth = new Map();
    this.nodes = nodes.map((node) => {
      depth.set(node.node_id, node.parent === null ? 0 : (depth.get(node.parent) ?? 0) + 1);
      return {...node, depth: depth.get(node.node_id)};
    });
    this.nodesOf = of;
    return this.nodes;
  }

  async showNodes() {
    if (!byId("nodes-part").open || !this.current) return;
    await this.loadNodes();
    this.listNodes();
  }

  listNodes() {
    const MOST = 300;
    const wanted = byId("node-search").value.toLowerCase();
    const found = (this.nodes || []).filter(({name}) => name.toLowerCase().includes(wanted));
    byId("nodes").replaceChildren(...found.slice(0, MOST).map((node) => {
      const button = make("button", {type: "button", class: `take depth${Math.min(node.depth, 6)}`},
        make("span", {class: "name"}, node.name || `#${node.node_id}`),
        make("span", {class: "about"}, node.triangles ? `${countText(node.triangles)} triangles` : ""));
      button.addEventListener("click", () => this.showNode(node));
      return make("li", {}, button);
    }));
    if (found.length > MOST) byId("nodes").append(make("li", {class: "empty"}, `${countText(found.length - MOST)} more: search for a name.`));
    if (!found.length) byId("nodes").append(make("li", {class: "empty"}, "No node has such a name."));
  }
}

function aboutScene(scene) {
  const update = scene.update ? `, ${scene.update.stage || scene.update.state} ${scene.update.progress ?? ""}`.trimEnd() : "";
  if (scene.state === "ready") return `${countText(scene.triangles)} triangles, ${bytesText(scene.bytes)}${update}`;
  if (scene.state === "failed") return `failed: ${scene.reason?.detail || ""}`;
  return `${scene.stage || scene.state}${scene.progress === null || scene.progress === undefined ? "" : ` ${scene.progress}%`}`;
}
