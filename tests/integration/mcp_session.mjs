// A session of the official MCP SDK, for mcp_test.py: node mcp_session.mjs NODE_MODULES BINARY URL
//
// Prints the tools and the lengths of the answers as JSON. The SDK checks every message against the schema of the protocol.
import { createRequire } from "node:module";
import { join } from "node:path";

const [modules, binary, url] = process.argv.slice(2);
const require = createRequire(join(modules, "session.mjs"));
const { Client } = require("@modelcontextprotocol/sdk/client/index.js");
const { StdioClientTransport } = require("@modelcontextprotocol/sdk/client/stdio.js");

const client = new Client({ name: "session", version: "1" });
await client.connect(new StdioClientTransport({ command: binary, args: ["mcp", "--url", url] }));
const { tools } = await client.listTools();
const calls = [];
const call = async (name, args) => {
  const answer = await client.callTool({ name, arguments: args });
  calls.push({ name, length: JSON.stringify(answer).length, isError: answer.isError });
  return answer.structuredContent;
};

const camera = { kind: "pinhole", position: [90, 60, 120], look_at: [0, 10, 0], width: 640, height: 400 };
const fields = ["t", "position", "normal", "node"];
const ray = { origin: [3, 200, 5], direction: [0, -1, 0] };
await call("listScenes", {});
await call("getScene", { id: "town" });
await call("sceneNodes", { id: "town" });
await call("describeTool", { name: "raysClosest" });
let page = await call("raysClosest", { id: "town", body: { generator: camera, fields } });
const total = page.summary.t.count;
for (let i = 0; i < 5; ++i) page = await call("readAnswer", { first: page.next });
await call("raysClosest", { id: "town", body: { rays: [ray], fields } });
await call("raysClosest", { id: "town", body: { generator: { ...camera, width: 64, height: 40 }, image: "depth" } });
await call("raysAny", { id: "town", body: { rays: [ray] } });
await call("raysCount", { id: "town", body: { rays: [ray] } });
await call("raysAll", { id: "town", body: { rays: [ray], fields } });
await call("visibility", { id: "town", body: { from: [[0, 90, 0]], to: [[50, 2, 0], [0, 2, 50]] } });
await call("pointsDistance", { id: "town", body: { points: [[0, 30, 0]], include: { names: ["spire", "clock tower"] } } });
await call("boxesList", { id: "town", body: { boxes: [{ min: [-9, 0, -9], max: [9, 99, 9] }], of: "nodes" } });
await call("clearance", { id: "town", body: { a: { names: ["spire"] }, b: { names: ["market square"] } } });
await call("raysClosest", { id: "nowhere", body: { rays: [ray] } });
await client.close();
console.log(JSON.stringify({ tools: tools.map(tool => tool.name), listed: JSON.stringify(tools).length, calls, total, shown: page.first }));
