"""Scenes put, listed, read, replaced and removed by curl."""

import hashlib
import tempfile
import threading
import unittest
from pathlib import Path

import case_report
from kills import grid_glb
from sightline_server import SOURCE, Server, demo_glb, read_answer, with_document

SCENES = SOURCE / "tests/data/scenes"


class Scenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.six = demo_glb("six")
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def test_a_new_scene_is_201_and_a_replaced_one_200(self):
        first = self.server.put("first", self.six)
        self.assertEqual(first.status, 201, first.body)
        self.assertEqual(first.headers["location"], "/v1/scenes/first")
        self.assertEqual(first.headers["content-type"], "application/json")
        self.assertEqual(first.headers["etag"], f'"{hashlib.sha256(self.six).hexdigest()}"')
        scene = first.json()
        self.assertEqual((scene["id"], scene["state"]), ("first", "ready"))
        self.assertEqual(scene["counts"]["triangles"], 6)
        self.assertEqual(scene["bounds"], {"min": [-6, 0, -2], "max": [8, 4, 2]})
        self.assertEqual(scene["warnings"], [])

        second = self.server.put("first", demo_glb("town"))
        self.assertEqual(second.status, 200)
        self.assertGreater(second.json()["revision"], scene["revision"])
        self.assertEqual(second.json()["counts"]["triangles"], 362254)
        self.assertNotEqual(second.headers["etag"], first.headers["etag"])

    def test_get_head_and_list_agree(self):
        put = self.server.put("agree", self.six)
        got, head = self.server.ask("/v1/scenes/agree"), self.server.ask("/v1/scenes/agree", "-I")
        self.assertEqual(got.body, put.body)
        self.assertEqual(head.status, 200)
        for name in ("etag", "content-length", "content-type"):
            self.assertEqual(head.headers[name], got.headers[name])
        listed = [scene for scene in self.server.ask("/v1/scenes").json()["scenes"] if scene["id"] == "agree"]
        self.assertEqual([(scene["state"], scene["triangles"], scene["sha256"]) for scene in listed],
                         [("ready", 6, hashlib.sha256(self.six).hexdigest())])

    def test_a_removed_scene_is_gone(self):
        self.server.put("gone", self.six)
        removed = self.server.ask("/v1/scenes/gone", "-X", "DELETE")
        self.assertEqual((removed.status, removed.body), (204, b""))
        self.assertEqual(self.server.ask("/v1/scenes/gone").status, 404)
        self.assertEqual(self.server.ask("/v1/scenes/gone", "-X", "DELETE").status, 404)
        self.assertEqual(self.server.put("gone", self.six).status, 201)

    def test_only_the_content_that_is_named_is_replaced_or_removed(self):
        town, first = demo_glb("town"), self.server.put("named", self.six)
        tag = first.headers["etag"]
        for field in ('If-Match: "another"', "If-Match: W/" + tag, "If-Match: nonsense", "If-None-Match: *", "If-None-Match: W/" + tag,
                      'If-None-Match: "another", ' + tag):
            for answer in (self.server.put("named", town, "-H", field), self.server.ask("/v1/scenes/named", "-X", "DELETE", "-H", field)):
                self.assertEqual((answer.status, answer.json()["code"]), (412, "PRECONDITION_FAILED"), field)
                self.assertIn(tag, answer.json()["detail"])
        self.assertEqual(self.server.ask("/v1/scenes/named").body, first.body)
        self.assertEqual(self.server.put("none", town, "-H", "If-Match: *").status, 412)
        self.assertEqual(self.server.ask("/v1/scenes/none").status, 404)
        self.assertEqual(self.server.ask("/v1/scenes/none", "-X", "DELETE", "-H", "If-Match: *").status, 404)
        replaced = self.server.put("named", town, "-H", 'If-Match: "another", ' + tag, "-H", 'If-None-Match: "another"')
        self.assertEqual(replaced.status, 200)
        self.assertEqual(self.server.put("named", self.six, "-H", "If-Match: *").status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/named", "-X", "DELETE", "-H", "If-Match: " + tag).status, 204)
        self.assertEqual(self.server.put("named", town, "-H", "If-None-Match: *").status, 201)
        self.server.ask("/v1/scenes/named", "-X", "DELETE")

    def test_of_two_with_the_same_precondition_one_is_too_late(self):
        tag = self.server.put("raced", self.six).headers["etag"]
        for field in ("If-Match: " + tag, "If-None-Match: *"):
            # Another content each: who comes second finds what the first has put.
            bodies = [grid_glb(4, bend) for bend in range(1, 5)]
            answers = []
            threads = [threading.Thread(target=lambda body=body: answers.append(self.server.put("raced", body, "-H", field))) for body in bodies]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            self.assertEqual(sorted(answer.status for answer in answers)[1:], [412] * 3)
            won = next(answer for answer in answers if answer.status < 300)
            self.assertEqual(self.server.ask("/v1/scenes/raced").headers["etag"], won.headers["etag"])
            self.assertEqual(self.server.ask("/v1/scenes/raced", "-X", "DELETE").status, 204)

    def test_a_body_is_not_sent_for_nothing(self):
        self.server.put("early", self.six)
        with self.server.connect() as connection, connection.makefile("rb") as stream:
            connection.sendall(b"PUT /v1/scenes/early HTTP/1.1\r\nHost: x\r\nExpect: 100-continue\r\nIf-None-Match: *\r\n"
                               b"Content-Length: 1000000\r\n\r\n")
            self.assertEqual(read_answer(stream).status, 412)

    def test_no_two_contents_have_the_same_revision(self):
        revisions = [self.server.put(name, self.six).json()["revision"] for name in ("one", "two", "one")]
        self.server.ask("/v1/scenes/one", "-X", "DELETE")
        revisions.append(self.server.put("one", self.six).json()["revision"])
        self.assertEqual(revisions, sorted(set(revisions)))
        answer = self.server.query("one", "any", {"rays": []})
        self.assertEqual(answer.headers["x-scene-revision"], str(revisions[-1]))

    def test_a_preload_whose_neighbour_changed_has_another_tag(self):
        # The hash of the file that was named does not say so.
        with tempfile.TemporaryDirectory() as folder:
            for name in ("features_external.gltf", "features data.bin"):
                Path(folder, name).write_bytes((SCENES / name).read_bytes())
            tags = []
            # The lowest bit of a coordinate, and of a normal that hits may be asked for.
            for place, change in ((0, 0), (0, 0), (0, 1), (4224, 1)):
                buffer = bytearray((SCENES / "features data.bin").read_bytes())
                buffer[place] ^= change
                Path(folder, "features data.bin").write_bytes(buffer)
                with Server("--preload", f"b={folder}/features_external.gltf") as server:
                    tags.append(server.ask("/v1/scenes/b").headers["etag"])
            self.assertEqual(tags[0], tags[1])
            self.assertEqual(len(set(tags[1:])), 3)

    def test_names_may_use_the_whole_alphabet(self):
        for name in ("A-Z_a.z-09", "x" * 128, "%41bc", "0"):
            with self.subTest(name=name):
                put = self.server.put(name, self.six)
                self.assertEqual(put.status, 201, put.body)
                self.assertEqual(self.server.ask("/v1/scenes/" + name).status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/Abc").status, 200)

    def test_a_gltf_with_data_uris_is_taken_and_one_with_neighbours_refused(self):
        file = SCENES / "features_datauri.gltf"
        put = self.server.ask("/v1/scenes/text", "-X", "PUT", "-H", "Content-Type: model/gltf+json", body=file.read_bytes())
        self.assertEqual(put.status, 201, put.body)
        glb = self.server.put("binary", (SCENES / "features.glb").read_bytes())
        self.assertEqual(put.json()["counts"]["triangles"], glb.json()["counts"]["triangles"])
        self.assertEqual(put.json()["bounds"], glb.json()["bounds"])
        external = (SCENES / "features_external.gltf").read_bytes()
        refused = self.server.ask("/v1/scenes/external", "-X", "PUT", "-H", "Content-Type: model/gltf+json", body=external)
        self.assertEqual(refused.status, 422, refused.body)
        self.assertEqual(self.server.ask("/v1/scenes/external").status, 404)

    def test_the_scene_of_a_file_can_be_chosen(self):
        glb = (SCENES / "features.glb").read_bytes()
        answers = {}
        for number in ("0", "1"):
            answers[number] = self.server.put(f"chosen?scene={number}", glb)
        self.assertEqual(answers["0"].status, 201, answers["0"].body)
        self.assertEqual([answers[number].json()["scene"] for number in ("0", "1")], [0, 1])
        # The same file, but not the same triangles.
        tags = {answer.headers["etag"] for answer in [self.server.put("file", glb), *answers.values()]}
        self.assertEqual(len(tags), 3, tags)
        self.assertEqual(self.server.ask("/v1/scenes/chosen").headers["etag"], answers["1"].headers["etag"])
        self.assertEqual(self.server.put("chosen?scene=999", glb).status, 422)

    def test_upload_by_curl_T_and_chunked(self):
        for name, arguments in (("untyped", ("-H", "Content-Type:")), ("chunked", ("-H", "Transfer-Encoding: chunked"))):
            with self.subTest(how=name):
                put = self.server.put(name, self.six, *arguments)
                self.assertEqual(put.status, 201, put.body)
                self.assertEqual(put.json()["bytes"], len(self.six))

    def test_what_curl_says_by_itself_is_taken_for_what_it_is(self):
        text = (SCENES / "features_datauri.gltf").read_bytes()
        for given in ("Content-Type:", "Content-Type: application/octet-stream", "Content-Type: application/x-www-form-urlencoded"):
            with self.subTest(type=given):
                path = "/v1/scenes/plain", "-X", "PUT", "-H", given
                for body in (self.six, text):
                    put = self.server.ask(*path, body=body)
                    self.assertIn(put.status, (200, 201), put.body)
                    self.assertEqual(put.json()["bytes"], len(body))
                refused = self.server.ask(*path, body=b"\x89PNG\r\n\x1a\n")
                self.assertEqual((refused.status, refused.json()["code"]), (400, "GLTF_CONTAINER_INVALID"))
        # Nothing at all said about the body: the commonest line of all.
        put = self.server.ask("/v1/scenes/plain", "-X", "PUT", body=self.six)
        self.assertEqual(put.status, 200, put.body)

    def test_preloads_are_there_and_a_bad_one_is_refused_at_the_start(self):
        with Server("--preload", "a=demo:six", "--preload", f"b={SCENES / 'features_external.gltf'}") as server:
            states = {scene["id"]: scene["state"] for scene in server.ask("/v1/scenes").json()["scenes"]}
            self.assertEqual(states, {"a": "ready", "b": "ready"})
        for bad in ("x=demo:none", "x=/no/such/file.glb", "no_equals", "../x=demo:six"):
            with self.subTest(preload=bad), self.assertRaises(AssertionError):
                Server("--preload", bad)

    def test_a_preload_that_is_no_scene_fails_alone(self):
        with Server("--preload", f"bad={SOURCE / 'README.md'}", "--preload", "good=demo:six") as server:
            ready = server.ask("/readyz").json()
            self.assertEqual((ready["status"], ready["failed"]), ("ready", ["bad"]))
            bad = server.ask("/v1/scenes/bad").json()
            self.assertEqual(bad["state"], "failed")
            self.assertTrue(bad["reason"]["code"])
            self.assertNotIn(str(SOURCE), bad["reason"]["detail"])
            refused = server.query("bad", "closest", {"rays": []})
            self.assertEqual((refused.status, refused.json()["code"]), (409, "SCENE_FAILED"))
            self.assertEqual(server.query("good", "closest", {"rays": []}).status, 200)
            self.assertEqual(server.put("bad", self.six).status, 201)

    def test_health_and_version(self):
        self.assertEqual(self.server.ask("/healthz").json(), {"status": "ok"})
        version = self.server.ask("/version").json()
        self.assertEqual(version["name"], "sightline")
        self.assertIn(version["kernel"], version["kernels"])
        self.assertGreater(version["limits"]["rays"], 0)
        self.assertEqual(self.server.ask("/healthz", "-I").status, 200)
        for path in ("/healthz?x=1", "/version?x=1", "/v1/scenes?x=1", "/v1/scenes/six/stats?x=1", "/docs?x=1"):
            self.assertEqual(self.server.ask(path).json()["code"], "QUERY_INVALID", path)
        asked = self.server.ask("/v1/scenes/six/rays:any?fields=t", "-H", "Content-Type: application/json", body='{"rays":[]}')
        self.assertEqual((asked.status, asked.json()["code"]), (422, "QUERY_INVALID"))


class LongNames(unittest.TestCase):
    def test_a_scene_whose_name_is_too_long_to_say_is_put_and_asked(self):
        glb = with_document(demo_glb("six"), lambda document: document["scenes"][0].update(name="n" * (2 << 20)))
        with Server("--max-request-memory", 8 << 20) as server:
            put = server.put("long", glb)
            self.assertEqual((put.status, put.json()["state"], "name" in put.json()), (201, "ready", False))
            told = server.ask("/v1/scenes/long")
            self.assertEqual((told.status, told.json()["code"]), (413, "REQUEST_TOO_LARGE"))
            self.assertEqual(server.query("long", "any", {"rays": [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}]}).json(), {"hits": [True]})
        with Server() as server:
            self.assertEqual(len(server.put("long", glb).json()["name"]), 2 << 20)


if __name__ == "__main__":
    case_report.main()
