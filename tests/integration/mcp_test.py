"""sightline mcp: an agent's side of the Model Context Protocol, against a real server."""

import base64
import json
import random
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from liar import HOSTILE_ANSWERS, Liar
from sightline_server import BINARY, PATIENCE, SOURCE, Server, demo_glb

DOCUMENT = json.loads((SOURCE / "proto/openapi.json").read_text(encoding="utf-8"))
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

    def call(self, name, **arguments):
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
        self.assertLessEqual(set(tools), set(operations))
        for name, tool in tools.items():
            self.assertEqual(tool["description"], operations[name]["summary"])
            schema = json.dumps(tool["inputSchema"])
            self.assertNotIn("#/components/", schema)
            for reference in {part.split('"')[0] for part in schema.split("#/$defs/")[1:]}:
                self.assertIn(reference, tool["inputSchema"]["$defs"])
        closest = tools["raysClosest"]["inputSchema"]
        self.assertEqual((closest["required"], closest["properties"]["body"]), (["id", "body"], {"$ref": "#/$defs/ClosestQuery"}))
        self.assertEqual(closest["$defs"]["ClosestQuery"]["properties"].keys(), DOCUMENT["components"]["schemas"]["ClosestQuery"]["properties"].keys())
        hints = {name: tool["annotations"]["readOnlyHint"] for name, tool in tools.items()}
        self.assertEqual({name for name, reads in hints.items() if not reads}, {"loadScene", "putScene", "deleteScene", "patchNode"})
        destroys = {name for name, tool in tools.items() if tool["annotations"]["destructiveHint"]}
        self.assertEqual(destroys, {"putScene", "deleteScene", "patchNode"})

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
                self.assertEqual(answer["content"][0]["text"], told[1].decode("utf-8", "replace"))
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
