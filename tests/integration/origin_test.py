"""Servers that share their scenes through an origin: a folder, and an object store that speaks S3."""

import json
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import case_report
from kills import grid_glb
from object_store import BUCKET, ObjectStore
from sightline_server import PATIENCE, Server, curl, demo_glb

RAYS = {"rays": [{"origin": [x / 3, 50, z / 3], "direction": [0.1, -1, 0.05]} for x in range(12) for z in range(12)],
        "fields": ["t", "position", "normal", "node"]}


def until(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("it takes too long")
        time.sleep(0.01)


class Shared(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.origin = ["--origin", self.folder / "origin"]

    def server(self, name, refresh=3600):
        server = Server("--data", self.folder / name, *self.origin, "--origin-seconds", refresh)
        self.addCleanup(server.end)
        return server

    def least(self, revision):
        return "-H", f"X-Scene-Min-Revision: {revision}"


class Folder(Shared):
    def test_each_server_answers_what_one_has_stored(self):
        a, b = self.server("a"), self.server("b")
        put = a.put("town", demo_glb("town"))
        self.assertEqual((put.status, put.json()["revision"]), (201, 1))
        first, second = a.query("town", "closest", RAYS), b.query("town", "closest", RAYS)
        self.assertEqual((first.status, second.status), (200, 200))
        self.assertEqual(first.body, second.body)
        self.assertEqual(second.headers["x-scene-revision"], "1")
        patched = b.ask("/v1/scenes/town/nodes/1", "-X", "PATCH", "-H", "Content-Type: application/json", body='{"translation":[0,9,0]}')
        self.assertEqual((patched.status, patched.json()["revision"]), (200, 2))
        moved = b.query("town", "closest", RAYS)
        self.assertNotEqual(first.body, moved.body)
        self.assertEqual(a.query("town", "closest", RAYS).body, first.body)  # it may be old
        newest = a.query("town", "closest", RAYS, *self.least(2))
        self.assertEqual((newest.body, newest.headers["x-scene-revision"]), (moved.body, "2"))
        unknown = a.query("town", "closest", RAYS, *self.least(3))
        self.assertEqual((unknown.status, unknown.json()["code"]), (409, "REVISION_UNKNOWN"))
        wrong = a.query("town", "closest", RAYS, *self.least("x"))
        self.assertEqual((wrong.status, wrong.json()["code"]), (400, "REVISION_INVALID"))
        removed = a.ask("/v1/scenes/town", "-X", "DELETE")
        self.assertEqual((removed.status, removed.headers["x-scene-revision"]), (204, "3"))
        gone = b.query("town", "closest", RAYS, *self.least(3))
        self.assertEqual((gone.status, gone.json()["code"]), (404, "SCENE_NOT_FOUND"))

    def test_what_other_servers_have_stored_is_listed_and_asked_for(self):
        a, b = self.server("a"), self.server("b", refresh=0.1)
        a.put("six", demo_glb("six"))

        def listed():
            return [(scene["id"], scene["state"]) for scene in b.ask("/v1/scenes").json()["scenes"]]

        until(lambda: listed() == [("six", "stored")])
        about = b.ask("/v1/scenes/six?wait=60").json()
        self.assertEqual((about["state"], about["revision"]), ("ready", 1))
        self.assertEqual(listed(), [("six", "ready")])
        a.ask("/v1/scenes/six", "-X", "DELETE")
        until(lambda: not listed())

    def test_a_removed_scene_leaves_the_list_of_its_server_at_once(self):
        a, b = self.server("a"), self.server("b")
        for server in (a, b):
            server.put("six", demo_glb("six"))
            self.assertEqual(server.ask("/v1/scenes/six", "-X", "DELETE").status, 204)
            self.assertEqual(server.ask("/v1/scenes").json()["scenes"], [])

    def test_a_server_without_room_for_a_scene_says_so_and_answers_others(self):
        (self.folder / "b").mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", self.folder / "b"], capture_output=True, text=True, check=False)
        if mounted.returncode != 0:
            self.skipTest("no small disk: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", self.folder / "b"], check=True)
        a, b = self.server("a"), self.server("b")
        a.put("six", demo_glb("six"))
        self.assertEqual(a.put("large", grid_glb(200, 5)).status, 201)
        for _ in range(2):
            full = b.query("large", "closest", RAYS)
            self.assertEqual((full.status, full.json()["code"], full.headers["retry-after"]), (503, "CACHE_FULL", "1"), full.body)
        self.assertEqual([each["code"] for each in b.ask("/readyz").json()["reasons"]], ["STORE_FULL"])
        self.assertEqual(b.query("six", "closest", RAYS).body, a.query("six", "closest", RAYS).body)

    def test_trees_are_built_once(self):
        a = self.server("a")
        a.put("town", demo_glb("town"))
        trees = self.folder / "origin" / "trees"
        until(lambda: trees.is_dir() and len(list(trees.iterdir())) == 1)
        b = self.server("b")
        self.assertEqual(a.query("town", "closest", RAYS).body, b.query("town", "closest", RAYS).body)
        # The answer did not wait for the trees.
        until(lambda: b.ask("/v1/scenes/town/stats").json()["trees"]["complete"])
        trees = b.ask("/v1/scenes/town/stats").json()["trees"]
        self.assertEqual((trees["cache_hits"], trees["full_builds"]), (1, 0))
        self.assertEqual(a.query("town", "closest", RAYS).body, b.query("town", "closest", RAYS).body)

    def test_scenes_outlive_servers_and_their_folders(self):
        a = self.server("a")
        a.put("town", demo_glb("town"))
        answer = a.query("town", "closest", RAYS).body
        a.kill()
        self.assertEqual(self.server("b").query("town", "closest", RAYS).body, answer)
        self.assertEqual(self.server("a").query("town", "closest", RAYS).body, answer)

    def test_an_origin_needs_a_folder_of_its_own(self):
        with self.assertRaisesRegex(AssertionError, "--data"):
            Server(*self.origin)
        own = Server("--data", self.folder / "own")
        own.put("six", demo_glb("six"))
        own.stop()
        own.end()
        with self.assertRaisesRegex(AssertionError, "STORE_IS_CACHE"):
            self.server("own")
        self.server("cache").stop()
        with self.assertRaisesRegex(AssertionError, "STORE_IS_CACHE"):
            Server("--data", self.folder / "cache")

    def test_preconditions_hold_over_all_servers(self):
        a, b = self.server("a"), self.server("b")
        six = demo_glb("six")
        self.assertEqual(a.put("six", six, "-H", "If-None-Match: *").status, 201)
        self.assertEqual(b.put("six", six, "-H", "If-None-Match: *").status, 412)
        tag = a.ask("/v1/scenes/six").headers["etag"]
        self.assertEqual(b.put("six", demo_glb("town"), "-H", f"If-Match: {tag}").status, 200)
        self.assertEqual(a.put("six", six, "-H", f"If-Match: {tag}").status, 412)
        self.assertEqual(a.ask("/v1/scenes/six", "-X", "DELETE", "-H", f"If-Match: {tag}").status, 412)

    def test_no_change_of_writers_at_once_is_lost(self):
        servers = [self.server(name) for name in "abc"]
        servers[0].put("six", demo_glb("six"))
        rounds, revisions = 8, []

        def write(server):
            for i in range(rounds):
                answer = server.ask("/v1/scenes/six/nodes/0", "-X", "PATCH", "-H", "Content-Type: application/json",
                                    body=json.dumps({"translation": [i, 0, 0]}))
                self.assertEqual(answer.status, 200, answer.body)
                revisions.append(answer.json()["revision"])

        writers = [threading.Thread(target=write, args=(server,)) for server in servers]
        for writer in writers:
            writer.start()
        for writer in writers:
            writer.join()
        self.assertEqual(sorted(revisions), list(range(2, 2 + 3 * rounds)))


class Bucket(Shared):
    def setUp(self):
        super().setUp()
        self.store = ObjectStore()
        self.store.__enter__()
        self.addCleanup(self.store.__exit__)
        self.origin = ["--origin", f"s3://{BUCKET}/of/tests", "--origin-credentials", self.credentials()]

    def credentials(self, **options):
        file = self.folder / "credentials"
        file.write_text(self.store.credentials(**options), encoding="ascii")
        return file

    def test_each_server_answers_what_one_has_stored(self):
        a, b = self.server("a"), self.server("b")
        town = demo_glb("town")
        self.assertEqual(a.put("town", town).status, 201)
        self.assertEqual(a.query("town", "closest", RAYS).body, b.query("town", "closest", RAYS).body)
        self.assertEqual(b.ask("/v1/scenes/town", "-X", "DELETE").status, 204)
        self.assertEqual(a.query("town", "closest", RAYS, *self.least(2)).status, 404)
        names = [name for name in self.store.objects if "/trees/" not in name]
        self.assertTrue(all(name.startswith("of/tests/") for name in names))
        self.assertEqual([name.split("/")[2] for name in sorted(names)], ["blobs", "names", "names"])
        refused = [each for each in self.store.requests if each[2] == 403]
        self.assertEqual(refused, [])

    def test_long_listings_are_read_to_their_end(self):
        a = self.server("a")
        a.put("six", demo_glb("six"))
        name = "of/tests/names/six/"
        record = json.loads(self.store.objects[name + f"{1:016}"])
        self.assertEqual(record["revision"], 1)
        for number in range(2, 2503):
            self.store.objects[name + f"{number:016}"] = b""
        answer = a.put("six", demo_glb("six"))
        self.assertEqual((answer.status, answer.json()["revision"]), (201, 2503))

    def test_a_store_that_overwrites_is_only_read(self):
        a = self.server("a")
        self.assertEqual(a.put("six", demo_glb("six")).status, 201)
        self.store.overwrites = True
        b = self.server("b")
        self.assertIn("ORIGIN_UNSAFE", b.log_text())
        self.assertEqual(b.ask("/v1/scenes/six?wait=60").json()["state"], "ready")
        for answer in (b.put("six", demo_glb("town")), b.ask("/v1/scenes/six", "-X", "DELETE"),
                       b.ask("/v1/scenes/six/nodes/0", "-X", "PATCH", "-H", "Content-Type: application/json", body='{"hidden":true}')):
            self.assertEqual((answer.status, answer.json()["code"]), (409, "ORIGIN_UNSAFE"))

    def test_servers_answer_from_their_caches_while_the_store_is_down(self):
        a, b = self.server("a"), self.server("b", refresh=0.1)
        a.put("six", demo_glb("six"))
        answer = b.query("six", "closest", RAYS).body
        self.store.down = True
        self.assertEqual(b.query("six", "closest", RAYS).body, answer)
        for lost in (b.put("other", demo_glb("six")), b.query("unknown", "closest", RAYS), b.query("six", "closest", RAYS, *self.least(2))):
            self.assertEqual((lost.status, lost.json()["code"], lost.headers["retry-after"]), (503, "ORIGIN_UNREACHABLE", "1"))
        until(lambda: "ORIGIN_UNREACHABLE" in b.ask("/readyz").body.decode())
        self.assertEqual(b.ask("/readyz").status, 200)
        self.assertIn("sightline_origin_failing 1\n", b.ask("/metrics").body.decode())
        c = self.server("c")
        self.assertEqual(c.query("six", "closest", RAYS).json()["code"], "ORIGIN_UNREACHABLE")
        self.store.down = False
        until(lambda: c.query("six", "closest", RAYS).body == answer)
        until(lambda: "ORIGIN_UNREACHABLE" not in b.ask("/readyz").body.decode())
        self.assertIn("sightline_origin_failing 0\n", b.ask("/metrics").body.decode())
        self.assertEqual(b.put("other", demo_glb("six")).status, 201)

    def test_a_read_that_fails_is_repeated(self):
        a = self.server("a")
        a.put("six", demo_glb("six"))
        b = self.server("b")
        self.store.fails = 2
        self.assertEqual(b.query("six", "closest", RAYS).status, 200)

    def test_wrong_credentials_are_told_without_the_secret(self):
        self.credentials(secret="wrong")
        a = self.server("a")
        answer = a.put("six", demo_glb("six"))
        self.assertEqual((answer.status, answer.json()["code"]), (500, "ORIGIN_REFUSED"))
        self.assertIn("SignatureDoesNotMatch", answer.json()["detail"])
        self.assertNotIn("wrong", a.log_text())
        for text, code in (("aws_access_key_id = x\n", "ORIGIN_CREDENTIALS"), ("nonsense\n", "ORIGIN_CREDENTIALS"),
                           ("aws_access_key_id = x\naws_secret_access_key = y\nendpoint_url = ftp://x\n", "ORIGIN_INVALID")):
            (self.folder / "credentials").write_text(text, encoding="ascii")
            with self.assertRaisesRegex(AssertionError, code):
                self.server("a2")

    def test_damaged_objects_give_no_answer(self):
        a = self.server("a")
        a.put("six", demo_glb("six"))
        blob = next(name for name in self.store.objects if "/blobs/" in name)
        self.store.objects[blob] = self.store.objects[blob][:-1] + b"~"
        answer = self.server("b").query("six", "closest", RAYS)
        self.assertEqual((answer.status, answer.json()["code"]), (500, "ORIGIN_DAMAGED"))
        record = next(name for name in self.store.objects if "/names/" in name)
        self.store.objects[record] = self.store.objects[record].replace(b'"bytes":', b'"bytes": ', 1)
        answer = self.server("c").query("six", "closest", RAYS)
        self.assertEqual((answer.status, answer.json()["code"]), (500, "ORIGIN_DAMAGED"))


if __name__ == "__main__":
    case_report.main()
