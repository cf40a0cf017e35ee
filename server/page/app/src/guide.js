// The pages at /docs/...: documents of the repository, made from Markdown here. Elements are made one by one: the policy
// of the page forbids markup from texts.

import {marked} from "marked";
import {byId, make} from "./dom.js";

const ROOT = new URL(".", document.currentScript.src);

// Headings may have words that are ids of this page's own elements.
const idOf = (slug) => `at-${slug}`;
const slugOf = (text) => text.toLowerCase().replace(/[^\p{L}\p{N}\s_-]/gu, "").replace(/\s/g, "-");
const routeOf = (path) => path.replace(/^docs\//, "");
const titleOf = ({text, path}) => (text.match(/^# (.+)$/m)?.[1] || path).replaceAll("`", "");
const addressOf = (path) => new URL(`docs/${routeOf(path)}`, ROOT).href;

let documents = [];
let shown = null;

// ---- Markdown

/** Where a link of the shown document leads; null for a file that this server does not have. */
function targetOf(href) {
  if (/^(https?:|#)/.test(href)) return href;
  const {pathname, hash} = new URL(href, `http://x/${shown.path}`);
  const path = decodeURIComponent(pathname.slice(1));
  if (path === "proto/openapi.json") return new URL("openapi.json", ROOT).href;
  return documents.some((each) => each.path === path) ? addressOf(path) + hash : null;
}

function link(token) {
  const target = targetOf(token.href);
  return target ? make("a", {href: target, rel: "noreferrer"}, inline(token.tokens)) : make("span", {}, inline(token.tokens));
}

const INLINE = {
  text: (token) => token.tokens ? inline(token.tokens) : token.text,
  escape: ({text}) => text,
  codespan: ({text}) => make("code", {}, text),
  strong: ({tokens}) => make("strong", {}, inline(tokens)),
  em: ({tokens}) => make("em", {}, inline(tokens)),
  del: ({tokens}) => make("del", {}, inline(tokens)),
  br: () => make("br"),
  image: ({text}) => make("span", {class: "about"}, `[Picture: ${text}]`),
  link,
};
const inline = (tokens) => tokens.map((token) => (INLINE[token.type] || (({raw}) => raw))(token));

const BLOCKS = {
  heading: ({depth, text, tokens}) => make(`h${depth}`, {id: idOf(slugOf(text.replaceAll("`", "")))}, inline(tokens)),
  paragraph: ({tokens}) => make("p", {}, inline(tokens)),
  text: ({tokens, text}) => make("span", {}, tokens ? inline(tokens) : text),
  code: ({text}) => make("pre", {tabindex: "0"}, make("code", {}, text)),
  blockquote: ({tokens}) => make("blockquote", {}, blocks(tokens)),
  hr: () => make("hr"),
  list: ({ordered, start, items}) => make(ordered ? "ol" : "ul", ordered ? {start: start || 1} : {}, items.map(({tokens}) => make("li", {}, blocks(tokens)))),
  table: ({header, rows}) => make("div", {class: "wide", tabindex: "0", role: "region", "aria-label": "Table"}, make("table", {},
    make("thead", {}, make("tr", {}, header.map(({tokens, text}) => text ? make("th", {scope: "col"}, inline(tokens)) : make("td")))),
    make("tbody", {}, rows.map((row) => make("tr", {}, row.map(({tokens}) => make("td", {}, inline(tokens)))))))),
};
const blocks = (tokens) => tokens.map((token) => BLOCKS[token.type]?.(token));

// ---- Search

/** Sections of all documents: {path, title, heading, text}. */
function* sections() {
  for (const each of documents) {
    let heading = "";
    for (const part of each.text.split(/^(?=#{1,4} )/m)) {
      heading = part.match(/^#+ (.+)/)?.[1].replaceAll("`", "") || heading;
      yield {path: each.path, title: titleOf(each), heading, text: part};
    }
  }
}

function search() {
  const MOST = 20;
  const words = byId("search").value.toLowerCase().split(/\s+/).filter(Boolean);
  byId("contents").hidden = words.length > 0;
  if (!words.length) return byId("found").replaceChildren();
  const found = [...sections()].filter(({text}) => words.every((word) => text.toLowerCase().includes(word)));
  // Where the heading has the words is more wanted than where the text has.
  const rank = ({heading}) => words.filter((word) => heading.toLowerCase().includes(word)).length;
  found.sort((a, b) => rank(b) - rank(a));
  byId("found").replaceChildren(...found.slice(0, MOST).map(({path, title, heading, text}) => {
    const plain = text.replace(/^#.*\n/, "").replace(/[`*|#\[\]]|\([^)\s]*\)/g, "").replace(/\s+/g, " ");
    const first = Math.max(0, plain.toLowerCase().indexOf(words[0]) - 40), at = first && plain.indexOf(" ", first) + 1;
    return make("li", {}, make("a", {href: `${addressOf(path)}#${slugOf(heading)}`}, heading || title),
      make("span", {class: "about"}, `${title}: ${plain.slice(at, plain.indexOf(" ", at + 100) + 1 || undefined)}`));
  }));
  if (!found.length) byId("found").append(make("li", {class: "empty"}, "No document has these words."));
}

// ---- The page

function list() {
  const folders = new Map();
  for (const each of documents) {
    const folder = each.path.match(/^docs\/(\w+)\//)?.[1] || "start";
    folders.set(folder, [...folders.get(folder) || [], each]);
  }
  const order = ["start", "guides", "reference", "explanation", "benchmarks", "decisions"];
  byId("documents").append(...order.filter((folder) => folders.has(folder)).flatMap((folder) => [make("h2", {}, folder),
    make("ul", {}, folders.get(folder).map((each) => make("li", {}, make("a", {href: addressOf(each.path),
      ...each === shown ? {"aria-current": "page"} : {}}, titleOf(each)))))]));
}

async function begin() {
  // A phone shows the text first.
  byId("contents").open = innerWidth > 960;
  const answer = await fetch(new URL("docs/documents.json.gz", ROOT));
  documents = await new Response(answer.body.pipeThrough(new DecompressionStream("gzip"))).json();
  const route = decodeURIComponent(location.pathname.slice(new URL("docs/", ROOT).pathname.length));
  shown = documents.find(({path}) => routeOf(path) === route);
  document.title = `${titleOf(shown)} - Sightline`;
  byId("document").append(...blocks(marked.lexer(shown.text)).filter(Boolean));
  list();
  byId("search").addEventListener("input", search);
  const jump = () => byId(idOf(decodeURIComponent(location.hash.slice(1))))?.scrollIntoView();
  addEventListener("hashchange", jump);
  jump();
  document.body.dataset.complete = route;
}

begin().catch((fault) => {
  byId("notice").textContent = fault.message;
  byId("notice").hidden = false;
});
