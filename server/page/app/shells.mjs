// Writes the pages: node shells.mjs FOLDER
// Each is head.html and NAME.html; guide_below.html is guide.html for an address one folder deeper.

import {readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";

const [folder] = process.argv.slice(2);
const read = (name) => readFileSync(new URL(name, import.meta.url), "utf8");

/** File, name of its body, script, its own link in the head, heading, way to the root. */
const PAGES = [
  ["index.html", "index", "boot", "Scenes", "Sightline", "."],
  ["learn.html", "learn", "learn", "Learn", "Rays and boxes", "."],
  ["status.html", "status", "status", "Status", "Status", "."],
  ["guide.html", "guide", "guide", "Guide", "Guide", ".."],
  ["guide_below.html", "guide", "guide", "Guide", "Guide", "../.."],
];

for (const [file, name, script, link, heading, root] of PAGES) {
  const words = {NAME: name, SCRIPT: script, HEADING: heading, TITLE: file === "index.html" ? heading : `${heading} - Sightline`, ROOT: root};
  const head = read("head.html").replace(/NAME|SCRIPT|HEADING|TITLE|ROOT/g, (word) => words[word]).replace(`>${link}</a>`, ' aria-current="page"$&');
  writeFileSync(join(folder, file), `${head}${read(`${name}.html`)}</body>\n</html>\n`);
}
