// Writes the pages whose texts their scripts fill: node shells.mjs FOLDER
// Each is head.html and NAME.html; guide_below.html is guide.html for an address one folder deeper.

import {readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";

const [folder] = process.argv.slice(2);
const read = (name) => readFileSync(new URL(name, import.meta.url), "utf8");

/** File, name of its body and script, title, way to the root. */
const PAGES = [
  ["learn.html", "learn", "Rays and boxes", "."],
  ["status.html", "status", "Status", "."],
  ["guide.html", "guide", "Guide", ".."],
  ["guide_below.html", "guide", "Guide", "../.."],
];

for (const [file, name, title, root] of PAGES) {
  const words = {NAME: name, TITLE: title, ROOT: root};
  const head = read("head.html").replace(/NAME|TITLE|ROOT/g, (word) => words[word])
    .replace(new RegExp(`>${name}</a>`, "i"), ' aria-current="page"$&');
  writeFileSync(join(folder, file), `${head}${read(`${name}.html`)}</body>\n</html>\n`);
}
