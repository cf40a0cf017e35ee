// Requests to this server. A key stays in the memory of the page.

export const BASE = new URL(".", location.href).href.replace(/\/$/, "");

let key = "";
export const hasKey = () => key !== "";
export function useKey(text) { key = text; }

/** Thrown for an answer that is no success. */
export class Problem extends Error {
  constructor(status, document) {
    super(document.detail || document.title || `status ${status}`);
    this.status = status;
    this.code = document.code || "";
    this.pointer = document.errors?.[0]?.pointer || "";
  }
}

export const scenePath = (scene, rest = "") => `/v1/scenes/${encodeURIComponent(scene)}${rest}`;

const authorization = () => key ? {Authorization: `Bearer ${key}`} : {};

async function send(path, options) {
  try {
    return await fetch(BASE + path, {...options, headers: {...options.headers, ...authorization()}, credentials: "omit", cache: "no-store"});
  } catch (fault) {
    throw fault.name === "AbortError" ? fault : new Error("The server does not answer.");
  }
}

export async function ask(path, options = {}) {
  const answer = await send(path, options);
  if (!answer.ok) throw await problemOf(answer.status, await answer.text());
  return answer;
}

function problemOf(status, text) {
  try {
    return new Problem(status, JSON.parse(text));
  } catch {
    return new Problem(status, {});
  }
}

export const askJson = async (path) => (await ask(path)).json();

/** Posts a text (null: GET) and returns the answer as it was sent, its revision, and how long it took. `picture` has the bytes of one. */
export async function post(path, body, accept = "*/*") {
  const begin = performance.now();
  const answer = await send(path, {method: body === null ? "GET" : "POST", body,
    headers: {...(body === null ? {} : {"Content-Type": "application/json"}), Accept: accept}});
  const bytes = await answer.arrayBuffer();
  const type = answer.headers.get("Content-Type") || "";
  const picture = type.startsWith("image/") ? bytes : null;
  return {status: answer.status, picture, text: picture ? `${type}, ${bytes.byteLength} bytes` : new TextDecoder().decode(bytes),
    bytes: bytes.byteLength, revision: Number(answer.headers.get("X-Scene-Revision")) || null, milliseconds: performance.now() - begin};
}

/** Puts a file; fetch cannot tell how far an upload is. */
export function put(path, file, type, onProgress) {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open("PUT", BASE + path);
    request.setRequestHeader("Content-Type", type);
    if (key) request.setRequestHeader("Authorization", `Bearer ${key}`);
    request.upload.onprogress = (event) => onProgress(event.loaded, event.total);
    request.onload = () => request.status < 300 ? resolve() : reject(problemOf(request.status, request.responseText));
    request.onerror = () => reject(new Error("the connection broke off"));
    request.send(file);
  });
}
