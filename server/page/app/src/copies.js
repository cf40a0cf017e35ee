// A request as a line for other programs.

import {BASE, hasKey} from "./api.js";

const shell = (text) => `'${text.replaceAll("'", "'\\''")}'`;

/** The body in one line where it is JSON, else as it is. */
function compact(body) {
  try {
    return JSON.stringify(JSON.parse(body));
  } catch {
    return body;
  }
}

/** A request as Python writes it. */
const python = (text) => text.replace(/"(?:[^"\\]|\\.)*"|\b(?:true|false|null)\b/g,
  (word) => ({true: "True", false: "False", null: "None"})[word] || word);

export function asCurl(path, body) {
  const key = hasKey() ? ' -H "Authorization: Bearer $SIGHTLINE_KEY"' : "";
  if (body === null) return `curl -s ${shell(BASE + path)}${key}`;
  return `curl -s ${shell(BASE + path)}${key} -H 'Content-Type: application/json' -d ${shell(compact(body))}`;
}

export function asPython(path, body) {
  const key = hasKey() ? ', "Authorization": "Bearer " + os.environ["SIGHTLINE_KEY"]' : "";
  if (body === null) {
    return `import json, ${hasKey() ? "os, " : ""}urllib.request
request = urllib.request.Request(${JSON.stringify(BASE + path)}, headers={${key.replace(", ", "")}})
print(json.load(urllib.request.urlopen(request)))
`;
  }
  return `import json, ${hasKey() ? "os, " : ""}urllib.request
request = urllib.request.Request(${JSON.stringify(BASE + path)}, json.dumps(${python(compact(body))}).encode(),
                                 {"Content-Type": "application/json"${key}})
print(json.load(urllib.request.urlopen(request)))
`;
}

export function asJavaScript(path, body) {
  const key = hasKey() ? ', Authorization: `Bearer ${process.env.SIGHTLINE_KEY}`' : "";
  if (body === null) return `const answer = await fetch(${JSON.stringify(BASE + path)}, {headers: {${key.replace(", ", "")}}});
console.log(await answer.json());
`;
  return `const answer = await fetch(${JSON.stringify(BASE + path)}, {
  method: "POST", headers: {"Content-Type": "application/json"${key}},
  body: JSON.stringify(${compact(body)})});
console.log(await answer.json());
`;
}
