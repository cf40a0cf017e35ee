// What the fragment of the address holds: scene and revision, camera, tool, question and request.

/** {scene, rev, sha, camera, mode, traced, route, body} of a fragment; nothing where there is none. */
export function readLink(fragment) {
  const words = new URLSearchParams(fragment.replace(/^#/, ""));
  const link = Object.fromEntries(words);
  if (!link.scene) return null;
  const camera = (link.camera || "").split(",").map(Number);
  link.camera = camera.length === 6 && camera.every(Number.isFinite) ? camera : null;
  link.rev = Number(link.rev) || null;
  return link;
}

export function writeLink({scene, rev, sha, camera, mode, traced, route, body}) {
  const words = new URLSearchParams({scene, rev, sha, camera: camera.join(","), mode});
  if (traced) words.set("traced", traced);
  if (route) {
    words.set("route", route);
    words.set("body", body);
  }
  return `#${words}`;
}

/** A sentence where the scene is another than when the link was made; else nothing. */
export function changeOf(link, scene) {
  if (!link.rev || !scene) return "";
  if (link.sha && !scene.sha256.startsWith(link.sha)) {
    return `The scene "${scene.id}" has another content than when this link was made (revision ${link.rev}, now ${scene.revision}).`;
  }
  if (link.rev !== scene.revision) {
    return `The scene "${scene.id}" has revision ${scene.revision}; this link was made with revision ${link.rev} of the same file. Nodes may have moved.`;
  }
  return "";
}
