"use strict";
// Shows openapi.json to people. Texts become text nodes, never markup.

const METHODS = ["get", "put", "post", "patch", "delete"];
const BASE = new URL(".", location.href).href.replace(/\/$/, "");
let api;  // the document
let key = "";

function make(name, attributes, ...children) {
  const element = document.createElement(name);
  for (const [attribute, value] of Object.entries(attributes || {})) element.setAttribute(attribute, value);
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== ""));
  return element;
}

const byId = (id) => document.getElementById(id);
const code = (text) => make("code", {}, text);
/** A media type, which a narrow column may break where people would. */
const media = (type) => code(type.split("/").flatMap((part, i) => i ? ["/", make("wbr"), part] : [part]));
const follow = (thing) => thing.$ref ? thing.$ref.slice(2).split("/").reduce((at, name) => at[name], api) : thing;
const nameOf = (schema) => schema.$ref.split("/").pop();
const between = (items, glue) => items.flatMap((item, i) => i ? [glue, item] : [item]);

// ---- Schemas

/** "3", "1 to 3", "at least 1"; nothing where there is no limit. */
function span(least, most) {
  if (least !== undefined && least === most) return `${least}`;
  if (least !== undefined && most !== undefined) return `${least} to ${most}`;
  if (least !== undefined) return `at least ${least}`;
  return most !== undefined ? `at most ${most}` : "";
}

/** The type of a schema in a line, as nodes; other schemas as links. */
function typeLine(schema) {
  if (schema.$ref) return [make("a", {href: `#schema-${nameOf(schema)}`}, nameOf(schema))];
  const either = schema.anyOf || schema.oneOf;
  if (either) return between(either.map(typeLine), " or ").flat();
  if (schema.enum) return between(schema.enum.map((word) => code(JSON.stringify(word))), " ");
  if ("const" in schema) return [code(JSON.stringify(schema.const))];
  const types = [schema.type || []].flat();
  if (types.includes("array")) {
    const count = span(schema.minItems, schema.maxItems);
    const some = schema.items && typeof schema.items === "object" ? typeLine(schema.items) : [];
    const each = schema.prefixItems ? between(schema.prefixItems.map(typeLine), ", ").flat() : some;
    const rest = types.filter((type) => type !== "array").map((type) => ` or ${type}`);
    return ["list", count && ` (${count})`, each.length ? " of " : "", ...each, ...rest];
  }
  const range = [span(schema.minimum, schema.maximum)];
  if (schema.exclusiveMinimum !== undefined) range.push(`above ${schema.exclusiveMinimum}`);
  if (schema.exclusiveMaximum !== undefined) range.push(`below ${schema.exclusiveMaximum}`);
  if (schema.maxLength !== undefined) range.push(`at most ${schema.maxLength} characters`);
  const limits = range.filter(Boolean).join(", ");
  return [types.join(" or "), limits && ` (${limits})`];
}

/** Rows of name, type and meaning. */
function table(heads, rows) {
  return make("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": heads.join(", ")},
    make("table", {},
      make("thead", {}, make("tr", {}, heads.map((head) => make("th", {scope: "col"}, head)))),
      make("tbody", {}, rows.map((cells) => make("tr", {}, cells.map((cell) => make("td", {}, cell)))))));
}

function memberRow(name, schema, needed) {
  const about = [schema.description || (schema.$ref ? follow(schema).description : "")];
  if (schema.default !== undefined) about.push(about[0] ? "; " : "", "default ", code(JSON.stringify(schema.default)));
  return [[code(name), needed ? make("span", {class: "needed"}, " required") : ""], typeLine(schema), about];
}

/** A schema as blocks: its description, and its members or its type. */
function schemaBlocks(schema) {
  const blocks = [];
  if (schema.description) blocks.push(make("p", {}, schema.description));
  if (schema.properties) {
    const required = schema.required || [];
    blocks.push(table(["Member", "Type", "Meaning"], Object.entries(schema.properties).map(
      ([name, member]) => memberRow(name, member, required.includes(name)))));
  } else {
    const line = typeLine(schema).filter(Boolean);
    if (line.length) blocks.push(make("p", {}, line));
  }
  return blocks;
}

// ---- Routes

const quoted = (text) => `'${text.replaceAll("'", "'\\''")}'`;

function curlLine(method, path, parameters, operation) {
  let target = path, query = "";
  // What changes a scene names none: a line may be pasted before it is read.
  const reads = method === "get" || method === "post";
  for (const {name, example, in: place} of parameters) {
    const text = encodeURIComponent(example ?? "").replaceAll("%2C", ",");
    if (place === "path") target = target.replace(`{${name}}`, reads && text ? text : name.toUpperCase());
    else if (text) query += `${query ? "&" : "?"}${name}=${text}`;
  }
  const line = ["curl -s"];
  const answers = Object.values(operation.responses).flatMap((answer) => Object.keys(follow(answer).content || {}));
  if (answers.includes("text/event-stream")) line[0] += "N";
  const content = operation.requestBody ? follow(operation.requestBody).content : {};
  if (method !== "get" && !(method === "post" && content["application/json"])) line.push(`-X ${method.toUpperCase()}`);
  line.push(quoted(BASE + target + query));
  const security = operation.security || api.security || [];
  if (key && security.length) line.push('-H "Authorization: Bearer $SIGHTLINE_KEY"');
  const [type] = content["application/json"] ? ["application/json"] : Object.keys(content);
  if (type) {
    line.push(`-H ${quoted(`Content-Type: ${type}`)}`);
    const example = content[type].example;
    line.push(example === undefined ? "--data-binary @FILE" : `-d ${quoted(JSON.stringify(example))}`);
  }
  return line.join(" ");
}

function copyBlock(text, label) {
  const said = make("span", {class: "said", role: "status"});
  const button = make("button", {type: "button", "aria-label": `Copy ${label}`}, "Copy");
  const shown = make("pre", {tabindex: "0", "aria-label": label}, code(text));
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(text);
      said.textContent = "copied";
    } catch {
      // No clipboard without TLS or this machine: what is selected can be copied by hand.
      getSelection().selectAllChildren(shown);
      said.textContent = "selected";
    }
    setTimeout(() => { said.textContent = ""; }, 2000);
  });
  return make("div", {class: "copy"}, shown, make("div", {class: "tools"}, said, button));
}

/** An example with its short lists in one line. */
function pretty(value) {
  return JSON.stringify(value, null, 2).replace(/\[\s*([^[\]{}]+?)\s*\]/g,
    (_, inside) => `[${inside.split(/,\n\s*/).join(", ")}]`);
}

function bodyBlocks(body) {
  const blocks = [];
  for (const [type, content] of Object.entries(body.content)) {
    const schema = content.schema || {};
    blocks.push(make("p", {class: "media"}, code(type), schema.$ref ? [" ", ...typeLine(schema)] : ""));
    if (content.example !== undefined) {
      blocks.push(make("pre", {tabindex: "0", "aria-label": "example"}, code(pretty(content.example))));
    }
    const shown = schemaBlocks(follow(schema));
    if (!shown.length) continue;
    blocks.push(schema.$ref ? make("details", {}, make("summary", {}, "Members"), shown) : shown);
  }
  return blocks;
}

/** The codes of an answer, or of a tag's routes. */
function codesBlock(owner, id, title) {
  if (!owner["x-codes"]) return "";
  return make("details", {id}, make("summary", {}, title),
    table(["Status", "Codes"], Object.entries(owner["x-codes"]).map(
      ([status, names]) => [code(status), between(names.map(code), " ")])));
}

function answerRows(responses, tag) {
  const rows = [], seen = new Map();
  for (const [status, given] of Object.entries(responses).sort(([a], [b]) => a < b ? -1 : 1)) {
    // Statuses that share an answer share a row.
    if (given.$ref && seen.has(given.$ref)) {
      seen.get(given.$ref).push(" ", code(status));
      continue;
    }
    const answer = follow(given), statuses = [code(status)];
    if (given.$ref) seen.set(given.$ref, statuses);
    const kinds = Object.entries(answer.content || {}).map(([type, content]) => {
      const schema = content.schema || {};
      const line = typeLine(schema).filter(Boolean);
      return make("div", {}, media(type), " ", line.length ? line : schema.description || "");
    });
    const about = [answer.description];
    if (answer["x-codes"]) {
      about.push(" Codes: ", tag["x-codes"] ? [make("a", {href: `#codes-${tag.name}`}, tag.name), ", "] : "",
        make("a", {href: `#codes-${nameOf(given)}`}, "any route"), ".");
    }
    rows.push([statuses, about.flat(), kinds]);
  }
  return rows;
}

function roleOf(operation) {
  const [first] = operation.security || api.security || [];
  return first ? `${Object.values(first)[0].join(", ")} key, where the server has keys` : "no key needed";
}

function routeBlock({method, path, shared, operation}, tag) {
  const parameters = [...shared, ...(operation.parameters || [])].map(follow);
  const id = operation.operationId;
  const block = make("article", {id, "aria-labelledby": `${id}-name`},
    make("h3", {id: `${id}-name`},
      make("a", {class: "route", href: `#${id}`},
        make("span", {class: `method ${method}`}, method.toUpperCase()), " ", code(path))),
    make("p", {class: "lead"}, operation.summary, make("span", {class: "role"}, ` (${roleOf(operation)})`)));
  if (operation.description) block.append(make("p", {}, operation.description));
  if (parameters.length) {
    block.append(make("h4", {}, "Parameters"), table(["Name", "In", "Type", "Meaning"], parameters.map((each) => {
      const [name, type, about] = memberRow(each.name, {...each.schema, description: each.description}, each.required);
      return [name, each.in, type, about];
    })));
  }
  if (operation.requestBody) block.append(make("h4", {}, "Body"), ...bodyBlocks(follow(operation.requestBody)).flat());
  block.append(make("h4", {}, "Answers"), table(["Status", "Meaning", "Body"], answerRows(operation.responses, tag)));
  block.append(make("h4", {}, "Try it"), copyBlock(curlLine(method, path, parameters, operation), `curl line of ${id}`));
  return block;
}

// ---- The page

function routesByTag() {
  const groups = new Map((api.tags || []).map((tag) => [tag.name, {...tag, routes: []}]));
  for (const [path, item] of Object.entries(api.paths)) {
    for (const method of METHODS.filter((name) => name in item)) {
      const operation = item[method];
      const tag = (operation.tags || ["other"])[0];
      if (!groups.has(tag)) groups.set(tag, {name: tag, routes: []});
      groups.get(tag).routes.push({method, path, shared: item.parameters || [], operation});
    }
  }
  return [...groups.values()].filter((group) => group.routes.length);
}

function contents(groups) {
  const entry = ({method, path, operation}) => make("li", {}, make("a", {href: `#${operation.operationId}`},
    make("span", {class: `method ${method}`}, method.toUpperCase()), " ",
    make("span", {class: "path"}, path.replace("/v1/scenes/{id}/", ".../"))));
  return make("details", {open: ""}, make("summary", {}, "Contents"),
    groups.map((group) => [make("a", {class: "group", href: `#tag-${group.name}`}, group.name),
      make("ul", {}, group.routes.map(entry))]),
    make("a", {class: "group", href: "#schemas"}, "schemas"));
}

function limitsBlock(version) {
  const rows = Object.entries(version.limits).map(
    ([name, value]) => [code(name), typeof value === "number" ? value.toLocaleString("en") : String(value)]);
  return make("details", {id: "limits"}, make("summary", {}, "Limits of this server"), table(["Limit", "Value"], rows));
}

function show(version) {
  const groups = routesByTag();
  document.title = `${api.info.title} API`;
  byId("title").replaceChildren(`${api.info.title} API `, make("small", {}, api.info.version));
  byId("summary").replaceChildren(`${api.info.summary || ""}. `, api.info.description || "", " ",
    make("a", {href: "openapi.json"}, "openapi.json"));
  byId("state").textContent = "";
  byId("key-form").hidden = true;
  byId("contents").replaceChildren(contents(groups));
  byId("contents").hidden = false;
  const schemas = Object.entries(api.components.schemas).map(([name, schema]) => make("article",
    {id: `schema-${name}`}, make("h3", {}, make("a", {class: "route", href: `#schema-${name}`}, name)), schemaBlocks(schema)));
  byId("content").replaceChildren(...(version ? [limitsBlock(version)] : []),
    ...groups.map((group) => make("section", {}, make("h2", {id: `tag-${group.name}`}, group.name),
      group.description ? make("p", {}, group.description) : "",
      codesBlock(group, `codes-${group.name}`, `Error codes of ${group.name}`),
      group.routes.map((route) => routeBlock(route, group)))),
    make("section", {}, make("h2", {}, "Error codes"),
      Object.entries(api.components.responses || {}).map(
        ([name, answer]) => codesBlock(answer, `codes-${name}`, "Error codes of any route, and of its body"))),
    make("section", {}, make("h2", {id: "schemas"}, "schemas"), schemas));
  if (matchMedia("(max-width: 52rem)").matches) byId("contents").querySelector("details").open = false;
  // Whoever gave a key goes on from here.
  if (key) byId("content").focus({preventScroll: true});
  goTo();
}

/** To what the address names: it was not there when the page was, or is closed. */
function goTo() {
  const target = location.hash && byId(location.hash.slice(1));
  if (!target) return;
  if (target.localName === "details") target.open = true;
  target.scrollIntoView();
}

const get = (name) => fetch(name, {headers: key ? {Authorization: `Bearer ${key}`} : {}, credentials: "omit"});

async function load() {
  try {
    const answer = await get("openapi.json");
    if (answer.status === 401 || answer.status === 403) {
      byId("state").textContent = key ? "The server does not take this key." : "";
      byId("key-form").hidden = false;
      if (key) byId("key").focus();
      return;
    }
    if (!answer.ok) throw new Error(`the server answered ${answer.status}`);
    api = await answer.json();
    const version = await get("version");
    show(version.ok ? await version.json() : null);
  } catch (fault) {
    byId("state").textContent = `openapi.json cannot be shown: ${fault.message}`;
  }
}

byId("key-form").addEventListener("submit", (event) => {
  event.preventDefault();
  key = byId("key").value.trim();
  byId("key").value = "";
  load();
});
addEventListener("hashchange", goTo);
load();
