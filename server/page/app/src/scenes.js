// The list of scenes: states, uploads, deletion, and the nodes of the chosen one.

import {ask, askJson, put, scenePath} from "./api.js";
import {byId, bytesText, countText, make} from "./dom.js";

export class Scenes {
  /** choose(id) is called when somebody takes a scene, showNode(node) for a node, changed() after each list. */
  constructor({choose, changed, fail, showNode}) {
    Object.assign(this, {choose, changed, fail, showNode, all: [], current: "", doomed: "", memory: new Map()});
    addEventListener("pointerdown", ({target}) => {
      if (!this.doomed || target.dataset?.remove === this.doomed) return;
      this.doomed = "";
      this.draw();
    });
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
    byId("node-search").addEventListener("input", () => this.listNodes().catch(this.fail));
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
    this.weigh().catch(() => {});
    await this.changed();
    const busy = scenes.some((scene) => scene.update || !["ready", "failed", "stored"].includes(scene.state));
    clearTimeout(this.timer);
    later(busy ? 500 : 10000);
  }

  /** Asks for the memory of each scene, and again of the current one: its trees are built when they are needed. */
  async weigh() {
    const MOST = 50;
    await Promise.all(this.all.filter(({state}) => state === "ready").slice(0, MOST).map(async ({id, revision}) => {
      if (this.memory.get(id)?.revision === revision && id !== this.current) return;
      const {trees} = await askJson(scenePath(id, "/stats"));
      this.memory.set(id, {revision, bytes: trees.tree_bytes + trees.geometry_bytes});
    }));
    this.draw();
  }

  draw() {
    const rows = this.all.map((scene) => {
      const current = scene.id === this.current;
      const take = make("button", {type: "button", class: "take", "aria-current": String(current), "data-scene": scene.id},
        make("span", {class: "name"}, scene.id), make("span", {class: "about"}, aboutScene(scene, this.memory.get(scene.id))));
      take.disabled = scene.state !== "ready";
      take.addEventListener("click", () => this.choose(scene.id));
      const sure = scene.id === this.doomed;
      const remove = make("button", {type: "button", class: "quiet", "aria-label": `${sure ? "Really delete" : "Delete"} ${scene.id}`, title: "Delete",
        "data-remove": scene.id}, sure ? "Delete?" : "\u00d7");
      remove.addEventListener("click", () => this.remove(scene.id));
      return make("li", {class: current ? "current" : ""}, take, remove);
    });
    // Whoever is about to press a button still finds it there.
    const text = JSON.stringify([this.all, this.current, this.doomed, ...this.memory]);
    if (text === this.shown) return;
    this.shown = text;
    const {scene, remove} = byId("list").contains(document.activeElement) ? document.activeElement.dataset : {};
    byId("list").replaceChildren(...rows);
    [...byId("list").querySelectorAll("button")].find(({dataset}) => scene && dataset.scene === scene || remove && dataset.remove === remove)?.focus();
    if (!rows.length) byId("list").append(make("li", {class: "empty"}, "No scenes yet."));
  }

  /** Asks once more in the same place before it deletes. */
  async remove(id) {
    const sure = this.doomed === id;
    this.doomed = sure ? "" : id;
    if (!sure) return this.draw();
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
    const {nodes, total} = await askJson(scenePath(this.current, "/nodes?limit=20000"));
    const depth = new Map();
    this.nodes = nodes.map((node) => {
      depth.set(node.node_id, node.parent === null ? 0 : (depth.get(node.parent) ?? 0) + 1);
      return {...node, depth: depth.get(node.node_id)};
    });
    this.nodesOf = of;
    this.nodesInAll = total;
    return this.nodes;
  }

  async showNodes() {
    if (!byId("nodes-part").open || !this.current) return;
    await this.loadNodes();
    await this.listNodes();
  }

  /** Nodes whose name has the word. Of more nodes than the page has, the server finds them. */
  async search(word, most) {
    const nodes = this.nodes || [];
    if (word && this.nodesInAll > nodes.length) {
      const found = await askJson(scenePath(this.current, `/nodes?${new URLSearchParams({name: `*${word}*`, limit: most})}`));
      return {found: found.nodes, total: found.total};
    }
    const found = nodes.filter(({name}) => name.toLowerCase().includes(word.toLowerCase()));
    return {found, total: word ? found.length : this.nodesInAll ?? 0};
  }

  async listNodes() {
    const MOST = 300;
    const word = byId("node-search").value;
    const {found, total} = await this.search(word, MOST);
    if (word !== byId("node-search").value) return;
    byId("nodes").replaceChildren(...found.slice(0, MOST).map((node) => {
      const button = make("button", {type: "button", class: `take depth${Math.min(node.depth ?? 0, 6)}`},
        make("span", {class: "name"}, node.name || `#${node.node_id}`),
        make("span", {class: "about"}, node.triangles ? `${countText(node.triangles)} triangle${node.triangles === 1 ? "" : "s"}` : ""));
      button.addEventListener("click", () => this.showNode(node));
      return make("li", {}, button);
    }));
    if (total > MOST) byId("nodes").append(make("li", {class: "empty"}, `${countText(total - MOST)} more: search for a name.`));
    if (!found.length) byId("nodes").append(make("li", {class: "empty"}, "No node has such a name."));
  }
}

function aboutScene(scene, memory) {
  const update = scene.update ? `, ${scene.update.stage || scene.update.state} ${scene.update.progress ?? ""}`.trimEnd() : "";
  if (scene.state === "ready") return `${countText(scene.triangles)} triangles,\nfile ${bytesText(scene.bytes)}${memory ? `, memory ${bytesText(memory.bytes)}` : ""}${update}`;
  if (scene.state === "failed") return `failed: ${scene.reason?.detail || ""}`;
  return `${scene.stage || scene.state}${scene.progress === null || scene.progress === undefined ? "" : ` ${scene.progress}%`}`;
}
