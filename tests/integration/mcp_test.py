"""sightline mcp: an agent's side of the Model Context Protocol, against a real server."""

import base64
import json
import random
import shutil
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from liar import HOSTILE_ANSWERS, Liar
from sightline_server import BINARY, JSON_TYPE, PATIENCE, SOURCE, Server, demo_glb

DOCUMENT = json.loads((SOURCE / "proto/openapi.json").read_text(encoding="utf-8"))
MODULES = Path(BINARY).resolve().parent / "page/node_modules"
NODE = shutil.which("node")
LONGEST, LONGEST_LIST = 32 << 10, 24 << 10
CAMERA = {"kind": "pinhole", "position": [90, 60, 120], "look_at": [0, 10, 0], "width": 640, "height": 400}
RAY = {"origin": [-10, 1, 0], "direction": [1, 0, 0]}


class Agent:
    """Speaks line by line."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([BINARY, "mcp", *map(str, arguments)], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.next = 0

    def say(self, line):
        self.process.stdin.write(line if isinstance(line, bytes) else line.encode())
        self.process.stdin.write(b"\n")
        self.process.stdin.flush()

    def hear(self):
        return json.loads(self.process.stdout.readline())

    def ask(self, method, **params):
        self.next += 1
        self.say(json.dumps({"jsonrpc": "2.0", "id": self.next, "method": method, "params": params}))
        answer = self.hear()
        assert (answer["jsonrpc"], answer["id"]) == ("2.0", self.next), answer
        return answer

    def call(self, name, /, **arguments):
        return self.ask("tools/call", name=name, arguments=arguments)["result"]

    def end(self):
        self.process.stdin.close()
        code = self.process.wait(timeout=PATIENCE)
        self.process.stdout.close()
        return code


class Mcp(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server("--preload", "six=demo:six", "--preload", "town=demo:town")
        cls.addClassCleanup(cls.server.end)

    def setUp(self):
        self.agent = self.start()

    def start(self, *arguments):
        agent = Agent("--url", self.server.url, *arguments)
        self.addCleanup(agent.process.stdout.close)
        self.addCleanup(agent.process.wait, PATIENCE)
        self.addCleanup(agent.process.stdin.close)
        return agent

    def test_it_introduces_itself(self):
        told = self.agent.ask("initialize", protocolVersion="2025-03-26", capabilities={}, clientInfo={"name": "t", "version": "1"})["result"]
        self.assertEqual((told["protocolVersion"], told["serverInfo"]["name"], told["capabilities"]), ("2025-03-26", "sightline", {"tools": {}}))
        self.agent.say('{"jsonrpc":"2.0","method":"notifications/initialized"}')
        self.assertEqual(self.agent.ask("ping")["result"], {})
        self.assertEqual(self.agent.ask("initialize", protocolVersion="1999-01-01")["result"]["protocolVersion"], "2025-06-18")
        self.assertEqual(self.agent.end(), 0)

    def test_its_tools_are_the_operations_of_the_document(self):
        tools = {tool["name"]: tool for tool in self.agent.ask("tools/list")["result"]["tools"]}
        operations = {operation["operationId"]: operation for item in DOCUMENT["paths"].values()
                      for method, operation in item.items() if method != "parameters"}
        self.assertEqual(set(operations) - set(tools), {
            # Streams, bytes to draw, and pages for people.
            "sceneEvents", "sceneGeometry", "metrics", "docs", "docsScript", "docsStyle", "page", "pageScript", "pageStyle", "bootScript",
            "learn", "learnScript", "statusPage", "statusScript", "documents", "document", "guideScript"})
        self.assertEqual(set(tools) - set(operations), {"describeTool", "readAnswer"})
        for name in set(tools) & set(operations):
            operation = operations[name]
            self.assertEqual(tools[name]["description"], f"{operation['summary']}. {operation['description']}")
            self.assertRegex(tools[name]["description"], r"\bUse (it|describeTool)\b")
            described = self.agent.call("describeTool", name=name)["structuredContent"]
            schema = json.dumps(described)
            self.assertNotIn("#/components/", schema)
            for reference in {part.split('"')[0] for part in schema.split("#/$defs/")[1:]}:
                self.assertIn(reference, described["$defs"])
            brief = tools[name]["inputSchema"]
            self.assertEqual((brief["properties"].keys(), brief.get("required", [])), (described["properties"].keys(), described["required"]))
        closest = self.agent.call("describeTool", name="raysClosest")["structuredContent"]
        self.assertEqual((closest["required"], closest["properties"]["body"]), (["id", "body"], {"$ref": "#/$defs/ClosestQuery"}))
        self.assertEqual(closest["$defs"]["ClosestQuery"]["properties"].keys(), DOCUMENT["components"]["schemas"]["ClosestQuery"]["properties"].keys())
        hints = {name: tool["annotations"]["readOnlyHint"] for name, tool in tools.items()}
        self.assertEqual({name for name, reads in hints.items() if not reads}, {"loadScene", "putScene", "deleteScene", "patchNode", "deleteNode", "patchNodes"})
        brief = tools["raysClosest"]["inputSchema"]["properties"]["body"]
        self.assertEqual(brief["description"], "keys: " + ", ".join(closest["$defs"]["ClosestQuery"]["properties"]))
        self.assertFalse(self.agent.call("raysClosest", id="six", body=brief["examples"][0])["isError"])
        destroys = {name for name, tool in tools.items() if tool["annotations"].get("destructiveHint")}
        self.assertEqual(destroys, {"putScene", "deleteScene", "patchNode", "deleteNode", "patchNodes"})

    def test_questions_of_every_kind(self):
        tower = {"names": ["clock tower", "spire"]}
        for name, arguments, expected in [
                ("raysClosest", {"id": "six", "body": {"rays": [RAY], "fields": ["t", "node"]}}, {"hits": [{"t": 4.5, "node": "left"}]}),
                ("raysAny", {"id": "six", "body": {"rays": [RAY]}}, {"hits": [True]}),
                ("raysCount", {"id": "six", "body": {"rays": [RAY]}}, {"counts": [6]}),
                ("visibility", {"id": "six", "body": {"from": [[-10, 1, 0]], "to": [[-6, 1, 0], [0, 1, 0]]}}, {"visible": ["10"]}),
                ("boxesCount", {"id": "six", "body": {"boxes": [{"min": [-9, 0, -9], "max": [0, 9, 9]}]}}, {"counts": [3]}),
                ("pointsInside", {"id": "town", "body": {"points": [[0, 10, 0.5]], "include": tower}}, {"inside": [True]}),
                ("pointsDistance", {"id": "town", "body": {"points": [[-7, 9, 0]], "include": tower}}, {"distance": [4]}),
                ("raysBoxes", {"body": {"rays": [RAY], "boxes": [{"min": [-2, -3, -4], "max": [4, 3, 2]}]}}, {"results": [{"t": 8}]}),
                ("sceneNodes", {"id": "six", "first": 1, "limit": 1}, {"nodes": [{"name": "left"}]}),
                ("listScenes", {}, {}), ("health", {}, {"status": "ok"})]:
            with self.subTest(name=name):
                told = self.agent.call(name, **arguments)
                self.assertFalse(told["isError"], told)
                self.assertEqual(json.loads(told["content"][0]["text"]), told["structuredContent"])
                self.assert_holds(told["structuredContent"], expected)

    def assert_holds(self, found, expected):
        """All that was expected, whatever else there may be."""
        if isinstance(expected, dict):
            for name, value in expected.items():
                self.assert_holds(found[name], value)
        elif isinstance(expected, list):
            self.assertEqual(len(found), len(expected))
            for one, other in zip(found, expected):
                self.assert_holds(one, other)
        else:
            self.assertEqual(found, expected)

    def test_a_picture_is_a_picture(self):
        body = {"image": "normal", "generator": {"kind": "pinhole", "position": [90, 60, 120], "look_at": [0, 10, 0], "width": 64, "height": 40}}
        for body["image"] in ("depth", "node", "normal"):
            told = self.agent.call("raysClosest", id="town", body=body)
            (picture,) = told["content"]
            self.assertEqual((told["isError"], picture["type"], picture["mimeType"]), (False, "image", "image/png"))
            self.assertNotIn("structuredContent", told)
            answer = self.server.query("town", "closest", body)
            self.assertEqual(answer.headers["content-type"], "image/png")
            self.assertEqual(base64.b64decode(picture["data"], validate=True), answer.body)
        body["image"] = "nothing"
        told = self.agent.call("raysClosest", id="town", body=body)
        self.assertEqual((told["isError"], told["structuredContent"]["code"]), (True, "VALUE_UNKNOWN"))

    def test_the_list_of_tools_is_short(self):
        self.agent.say('{"jsonrpc":"2.0","id":1,"method":"tools/list"}')
        self.assertLess(len(self.agent.process.stdout.readline()), LONGEST_LIST)

    def test_a_long_answer_is_a_summary_and_pages_that_make_it_up(self):
        rays = [{"origin": [x, 200, z], "direction": [0.25, -1, 0.125]} for x in range(-120, 120, 3) for z in range(-120, 120, 3)]
        body = {"rays": rays, "fields": ["t", "position", "node"]}
        whole = self.server.query("town", "closest", body).json()["hits"]
        hits = [each for each in whole if each]
        rows, first, lines = [], 0, 0
        told = self.agent.call("raysClosest", id="town", body=body)
        while True:
            self.assertLessEqual(len(json.dumps(told, separators=(",", ":"), ensure_ascii=False).encode()), LONGEST)
            page = told["structuredContent"]
            self.assertEqual((told["isError"], json.loads(told["content"][0]["text"]), page["first"]), (False, page, first))
            if first == 0:
                summary = page["summary"]["hits"]
                self.assertEqual((summary["count"], summary.get("null", 0)), (len(whole), len(whole) - len(hits)))
                near = summary["fields"]["t"]
                self.assertEqual((near["count"], near["min"], near["max"]), (len(hits), min(x["t"] for x in hits), max(x["t"] for x in hits)))
                frequent = summary["fields"]["node"]["frequent"][0]
                self.assertEqual(frequent["count"], sum(each["node"] == frequent["text"] for each in hits))
            rows += page["page"]["hits"]
            lines += 1
            first = page["next"]
            if first is None:
                break
            told = self.agent.call("readAnswer", answer=page["answer"], first=first)
        self.assertEqual(rows, whole)
        self.assertLess(lines, 200)
        told = self.agent.call("readAnswer", pointer="/hits/7")["structuredContent"]
        self.assertEqual((told["page"], told["next"]), (whole[7], None))

    def test_columns_lists_and_texts_have_pages_too(self):
        flat = {"origins": [3, 200, 5] * 3000, "directions": [0, -1, 0] * 3000, "fields": ["t", "node"]}
        whole = self.server.query("town", "closest", flat).json()
        page = self.agent.call("raysClosest", id="town", body=flat)["structuredContent"]
        self.assertEqual(page["summary"]["t"], {"count": 3000, "min": 199.75, "max": 199.75})
        self.assertEqual(page["page"]["t"], whole["t"][:page["count"]])
        last = self.agent.call("readAnswer", first=2999)["structuredContent"]
        self.assertEqual((last["page"]["node"], last["next"]), (whole["node"][2999:], None))
        down = {"origin": [3, 200, 5], "direction": [0, -1, 0]}
        body = {"rays": [down] * 900, "fields": ["t", "node", "position", "normal"]}
        whole = self.server.query("town", "all", body).json()
        page = self.agent.call("raysAll", id="town", body=body)["structuredContent"]
        self.assertEqual(page["page"]["results"], whole["results"][:page["count"]])
        later = self.agent.call("readAnswer", first=800)["structuredContent"]
        self.assertEqual(later["page"]["results"], whole["results"][800:800 + later["count"]])
        points = [[x, 2.0, z] for x in range(-60, 60, 6) for z in range(-60, 60, 6)]
        seen = self.server.ask("/v1/scenes/town/visibility", "-H", JSON_TYPE, body=json.dumps({"from": points, "to": points})).json()["visible"]
        page = self.agent.call("visibility", id="town", body={"from": points, "to": points})["structuredContent"]
        self.assertTrue(all(row.startswith(cut) for row, cut in zip(seen, page["page"]["visible"])))
        if page["shortened"]:
            part = self.agent.call("readAnswer", pointer=page["shortened"][0], first=300)["structuredContent"]
            self.assertEqual(part["page"], seen[int(page["shortened"][0].split("/")[-1])][300:300 + part["count"]])

    def test_pages_that_are_not_there(self):
        self.assertEqual(self.agent.call("readAnswer")["content"][0]["text"].split(":")[0], "ANSWER_GONE")
        body = {"rays": [RAY] * 2000, "fields": ["t", "node"]}
        numbers = [self.agent.call("raysClosest", id="six", body=body)["structuredContent"]["answer"] for _ in range(9)]
        self.assertTrue(self.agent.call("readAnswer", answer=numbers[0])["isError"])
        self.assertFalse(self.agent.call("readAnswer", answer=numbers[1])["isError"])
        for pointer in ("/nothing", "/hits/99999", "hits", "/hits/-", "/hits/x"):
            self.assertIn("POINTER_UNKNOWN", self.agent.call("readAnswer", pointer=pointer)["content"][0]["text"], pointer)
        past = self.agent.call("readAnswer", first=10**9)["structuredContent"]
        self.assertEqual((past["page"]["hits"], past["next"]), ([], None))
        for wrong in ({"first": -1}, {"first": "x"}, {"answer": 1.5}, {"pointer": 7}, {"other": 1}):
            self.assertEqual(self.agent.ask("tools/call", name="readAnswer", arguments=wrong)["error"]["code"], -32602, wrong)
        self.assertEqual(self.agent.ask("tools/call", name="describeTool", arguments={"name": "nothing"})["error"]["code"], -32602)

    def test_a_large_picture_is_refused_with_its_size(self):
        told = self.agent.call("raysClosest", id="town", body={"image": "normal", "generator": CAMERA})
        self.assertTrue(told["isError"])
        self.assertRegex(told["content"][0]["text"], "^ANSWER_TOO_LONG: the picture is a line of [0-9]+ bytes")
        more = self.start("--max-answer-bytes", 1 << 24)
        self.assertEqual(more.call("raysClosest", id="town", body={"image": "normal", "generator": CAMERA})["content"][0]["type"], "image")
        less = self.start("--max-answer-bytes", 4096)
        self.assertLessEqual(len(json.dumps(less.call("openapi"), separators=(",", ":"))), 4096)

    @unittest.skipIf(NODE is None or not (MODULES / "@modelcontextprotocol/sdk").is_dir(), "the MCP SDK of npm is not installed")
    def test_the_official_sdk_completes_a_session_of_twenty_calls(self):
        done = subprocess.run([NODE, SOURCE / "tests/integration/mcp_session.mjs", MODULES, BINARY, self.server.url],
                              capture_output=True, text=True, timeout=PATIENCE * 4, check=False)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        told = json.loads(done.stdout)
        self.assertGreaterEqual(len(told["calls"]), 20)
        for call in told["calls"]:
            self.assertLessEqual(call["length"], LONGEST, call)
        self.assertEqual([call["name"] for call in told["calls"] if call["isError"]], ["raysClosest"])
        self.assertLess(told["listed"], LONGEST_LIST)
        self.assertEqual(told["total"], 640 * 400)
        self.assertGreater(told["shown"], 0)

    def test_what_the_server_refuses_is_an_answer(self):
        told = self.agent.call("raysClosest", id="six", body={"rays": [{"origin": [0, 0, 0], "direction": [0, 0, 0]}]})
        self.assertTrue(told["isError"])
        self.assertEqual((told["structuredContent"]["code"], told["structuredContent"]["errors"][0]["pointer"]),
                         ("RAY_DIRECTION_ZERO", "/rays/0/direction"))
        told = self.agent.call("getScene", id="../../healthz")
        self.assertTrue(told["isError"])
        agent = Agent("--url", "http://127.0.0.1:1")
        told = agent.call("health")
        self.assertTrue(told["isError"])
        self.assertIn("SERVER_UNREACHABLE", told["content"][0]["text"])
        self.assertEqual(agent.end(), 0)

    def test_scenes_come_as_text_or_from_the_one_folder(self):
        box = "box { <4, 3, 2>, <-2, -3, -4> pigment { color rgb <1, 0, 0> } }\n"
        self.assertEqual(self.agent.call("putScene", id="pov", text=box)["structuredContent"]["state"], "ready")
        self.assert_holds(self.agent.call("raysClosest", id="pov", body={"rays": [RAY], "fields": ["t"]})["structuredContent"], {"hits": [{"t": 8}]})
        self.assertEqual(self.agent.ask("tools/call", name="putScene", arguments={"id": "x", "file": "a"})["error"]["code"], -32602)
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "inside").mkdir()
            Path(folder, "inside/six.glb").write_bytes(demo_glb("six"))
            Path(folder, "secret").write_bytes(b"x")
            agent = self.start("--files", Path(folder, "inside"))
            self.assert_holds(agent.call("putScene", id="mine", file="six.glb")["structuredContent"], {"counts": {"triangles": 6}})
            for name in ("../secret", str(Path(folder, "secret")), "nobody", ""):
                told = agent.call("putScene", id="mine", file=name)
                self.assertTrue(told["isError"], name)
                self.assertNotIn(folder, json.dumps(told))
        self.assertFalse(self.agent.call("deleteScene", id="mine")["isError"])
        self.assertFalse(self.agent.call("deleteScene", id="pov")["isError"])

    def test_a_condition_is_told_to_the_server(self):
        self.assertFalse(self.agent.call("putScene", id="moved", text="box { <4, 3, 2>, <-2, -3, -4> }\n")["isError"])
        tag = self.server.ask("/v1/scenes/moved").headers["etag"]
        refused = self.agent.call("patchNode", **{"id": "moved", "node": 0, "If-Match": '"another"', "body": {"hidden": True}})
        self.assertEqual((refused["isError"], refused["structuredContent"]["code"]), (True, "PRECONDITION_FAILED"))
        for value in ("", "a\r\nX-Other: 1", "\u00e4", 7):
            answer = self.agent.ask("tools/call", name="patchNode", arguments={"id": "moved", "node": 0, "If-Match": value, "body": {"hidden": True}})
            self.assertEqual(answer["error"]["code"], -32602, value)
        self.assertEqual(self.server.ask("/v1/scenes/moved").headers["etag"], tag)
        self.assertFalse(self.agent.call("patchNode", **{"id": "moved", "node": 0, "If-Match": tag, "body": {"hidden": True}})["isError"])
        self.assertFalse(self.agent.call("deleteScene", id="moved")["isError"])

    def test_what_another_server_says_does_not_end_it(self):
        for told in HOSTILE_ANSWERS:
            with self.subTest(told=told[1][:60]), Liar(*told) as liar:
                agent = Agent("--url", liar.url)
                answer = agent.call("raysAny", id="six", body={"rays": [RAY]})
                text, whole = answer["content"][0]["text"], told[1].decode("utf-8", "replace")
                if len(told[1]) > LONGEST // 4:
                    page = answer["structuredContent"]
                    self.assertEqual((page["bytes"], page["page"]), (len(told[1]), whole[:page["count"]]))
                else:
                    self.assertEqual(text, whole)
                self.assertEqual(agent.ask("ping")["result"], {})
                self.assertEqual(agent.end(), 0)

    def test_hostile_lines_are_errors_of_json_rpc(self):
        deep = "[" * 100_000
        for line, code in [("", None), ("{", -32700), ("nonsense", -32700), (deep, -32700), (b"\xff\xfe\x00", -32700), ('"' + "\\" * 999, -32700),
                           ("[]", -32600), ("7", -32600), ("{}", -32600), ('{"jsonrpc":"1.0","id":1,"method":"ping"}', -32600),
                           ('{"jsonrpc":"2.0","id":{},"method":"ping"}', -32600), ('{"jsonrpc":"2.0","id":1,"method":7}', -32600),
                           ('{"jsonrpc":"2.0","id":1,"method":"no/such"}', -32601), ('{"jsonrpc":"2.0","id":1,"method":"tools/list","params":[]}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call"}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"metrics"}}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"raysAny","arguments":7}}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"raysAny","arguments":{"id":"six"}}}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"raysAny","arguments":{"body":{}}}}', -32602),
                           ('{"jsonrpc":"2.0","id":1,"method":"tools/call","params":{"name":"health","arguments":{"path":"/x"}}}', -32602),
                           ('{"jsonrpc":"2.0","method":"tools/call","params":7}', None)]:
            with self.subTest(line=line[:80]):
                self.agent.say(line)
                if code is not None:
                    self.assertEqual(self.agent.hear()["error"]["code"], code)
        self.assertEqual(self.agent.ask("ping")["result"], {})

    def test_damaged_requests_never_end_it(self):
        source = random.Random(12)
        good = json.dumps({"jsonrpc": "2.0", "id": 5, "method": "tools/call",
                           "params": {"name": "raysClosest", "arguments": {"id": "six", "body": {"rays": [RAY]}}}}).encode()
        for _ in range(300):
            line = bytearray(good)
            for _ in range(source.randint(1, 4)):
                line[source.randrange(len(line))] = source.choice(b'{}[]",:0 a\\\x80')
            self.agent.say(bytes(line))
            self.agent.say('{"jsonrpc":"2.0","id":"end","method":"ping"}')
            while self.agent.hear()["id"] != "end":
                pass
        self.assertEqual(self.agent.end(), 0)


if __name__ == "__main__":
    case_report.main()
