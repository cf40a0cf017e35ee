// Packs the documents of the repository for /docs: node documents.mjs ROOT OUTPUT PATH...
// OUTPUT is [{path, text}, ..] as gzip.

import {readFileSync, writeFileSync} from "node:fs";
import {join} from "node:path";
import {gzipSync} from "node:zlib";

const [root, output, ...paths] = process.argv.slice(2);
const documents = paths.map((path) => ({path, text: readFileSync(join(root, path), "utf8")}));
writeFileSync(output, gzipSync(JSON.stringify(documents), {level: 9}));
