// Packs the documents of the repository for /docs: node documents.mjs ROOT OUTPUT PATH...
// OUTPUT is [{path, text}, ..] as gzip. guide_below.html beside it is guide.html for an address one folder deeper.

import {readFileSync, writeFileSync} from "node:fs";
import {dirname, join} from "node:path";
import {gzipSync} from "node:zlib";

const [root, output, ...paths] = process.argv.slice(2);
const documents = paths.map((path) => ({path, text: readFileSync(join(root, path), "utf8")}));
writeFileSync(output, gzipSync(JSON.stringify(documents), {level: 9}));
// Node.js 18 of Debian 12 has no import.meta.dirname.
const shell = readFileSync(new URL("guide.html", import.meta.url), "utf8");
writeFileSync(join(dirname(output), "guide_below.html"), shell.replaceAll('"../', '"../../'));
