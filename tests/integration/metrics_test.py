"""What a server says of its scenes' costs and of its own work."""

import json
import re
import time
import unittest
import urllib.request

import case_report
from sightline_server import PATIENCE, SOURCE, Server, demo_glb

SCENES = SOURCE / "tests/data/scenes"
DOWN = {"rays": [{"origin": [-10, 1, 0], "direction": [1, 0, 0]}]}


def series(text):
    """{'name{labels}': value}; every line that is no comment must be one."""
    values = {}
    for line in text.decode().splitlines():
        if line and not line.startswith("#"):
            name, _, value = line.rpartition(" ")
            values[name] = float(value)
    return values


class Metrics(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Server()
        cls.addClassCleanup(cls.server.end)

    def ask(self):
        answer = self.server.ask("/metrics")
        self.assertEqual((answer.status, answer.headers["content-type"]), (200, "text/plain; version=0.0.4; charset=utf-8"))
        for line in answer.body.decode().splitlines():
            self.assertRegex(line, r'^(# (HELP|TYPE) (sightline|process)_\w+ .+|(sightline|process)_\w+(\{\w+="[^"]*"(,\w+="[^"]*")*\})? [0-9.e+-]+)$')
        return series(answer.body)

    def test_the_dashboard_names_series_and_labels_that_there_are(self):
        self.server.put("six", demo_glb("six"))
        self.server.query("six", "closest", DOWN)
        labels = {}
        for name in self.ask():
            labels.setdefault(name.partition("{")[0], set()).update(re.findall(r'(\w+)="', name))
        dashboard = json.loads((SOURCE / "docs/deploy/grafana.json").read_text(encoding="utf-8"))
        exprs = [target["expr"] for panel in dashboard["panels"] for target in panel["targets"]]
        for expr in exprs:
            names = re.findall(r"\b(?:sightline|process)_\w+", expr)
            self.assertTrue(names, expr)
            self.assertLessEqual(set(names), set(labels), expr)
            known = set().union(*(labels[name] for name in names)) | {"instance"}
            wanted = re.findall(r"by \((.*?)\)", expr)
            self.assertLessEqual({each for group in wanted for each in group.split(", ")}, known, expr)
        shown = set(re.findall(r"\bsightline_\w+?(?=_bucket\b|\b)", " ".join(exprs)))
        documented = re.findall(r"^\| `(sightline_\w+)`", (SOURCE / "docs/reference/metrics.md").read_text(encoding="utf-8"), re.MULTILINE)
        self.assertLessEqual(shown, set(documented))

    def test_requests_rays_and_loads_are_counted(self):
        before = self.ask()
        self.assertEqual(self.server.put("six", demo_glb("six")).status, 201)
        for _ in range(3):
            self.assertEqual(self.server.query("six", "closest", {"rays": DOWN["rays"] * 5}).status, 200)
        self.assertEqual(self.server.ask("/v1/scenes/six/boxes:any", "-H", "Content-Type: application/json",
                                         body='{"boxes":[{"min":[0,0,0],"max":[1,1,1]}]}').status, 200)
        self.server.put("bad", b"no scene")
        for path in ("/none", "/none2", "/v1/scenes/none", "/v1/scenes/none3"):
            self.server.ask(path)
        self.server.ask("/none", "-X", "BREW")
        self.server.ask("/v1/scenes/none/nodes/0", "-X", "PATCH", "-H", "Content-Type: application/json", body="{}")
        after = self.ask()

        def grown(name):
            return after.get(name, 0) - before.get(name, 0)

        closest = 'route="/v1/scenes/{id}/rays:closest"'
        self.assertEqual(grown("sightline_rays_total"), 15)
        self.assertEqual(grown("sightline_boxes_total"), 1)
        self.assertEqual(grown('sightline_requests_total{method="POST",%s,status="200"}' % closest), 3)
        self.assertEqual(grown('sightline_requests_total{method="GET",route="none",status="404"}'), 2)
        self.assertEqual(grown('sightline_requests_total{method="GET",route="/v1/scenes/{id}",status="404"}'), 2)
        self.assertEqual(grown('sightline_requests_total{method="PATCH",route="/v1/scenes/{id}/nodes/{node}",status="422"}'), 1)
        self.assertIn(" method=PATCH ", self.server.log_text())
        self.assertEqual(grown('sightline_request_seconds_count{%s}' % closest), 3)
        self.assertEqual(grown('sightline_request_seconds_bucket{%s,le="+Inf"}' % closest), 3)
        self.assertEqual(grown('sightline_loads_total{outcome="ready"}'), 1)
        self.assertEqual(grown('sightline_loads_total{outcome="failed"}'), 1)
        self.assertEqual(after['sightline_scenes{state="ready"}'], 1)
        self.assertFalse([name for name in after if "none2" in name or "BREW" in name])

    def test_rays_of_a_stream_are_counted_as_they_come(self):
        self.assertEqual(self.server.put("streamed", demo_glb("six")).status, 201)
        before = self.ask()
        line = json.dumps({"origin": [-10, 1, 0], "direction": [1, 0, 0]}) + "\n"
        answer = self.server.ask("/v1/scenes/streamed/rays:closest", "-H", "Content-Type: application/x-ndjson", body=line * 7)
        self.assertEqual((answer.status, answer.body.count(b"\n")), (200, 7))
        after = self.ask()
        self.addCleanup(self.server.ask, "/v1/scenes/streamed", "-X", "DELETE")
        self.assertEqual(after["sightline_rays_total"] - before["sightline_rays_total"], 7)
        name = 'sightline_work_total{what="blocks"}'
        self.assertGreater(after[name], before[name])

    def test_who_closes_after_the_whole_answer_is_not_gone(self):
        gone = 'sightline_connections_total{event="gone"}'
        before = self.ask()[gone]
        for _ in range(5):
            with urllib.request.urlopen(self.server.url + "/healthz", timeout=PATIENCE) as answer:
                self.assertEqual((answer.status, answer.headers["connection"]), (200, "close"))
                answer.read()
        end = time.monotonic() + PATIENCE
        while self.ask()["sightline_connections"] > 1:
            self.assertLess(time.monotonic(), end)
        self.assertEqual(self.ask()[gone], before)

    def test_totals_outlive_their_scenes(self):
        text = self.server.ask("/metrics").body.decode()
        for name, kind in re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE):
            self.assertEqual(name.endswith("_total"), kind == "counter", name)
        self.assertIn('sightline_build_info{version="%s",' % self.server.ask("/version").json()["version"], text)
        self.assertLess(self.ask()["process_start_time_seconds"], time.time())
        with Server() as server:
            server.put("six", demo_glb("six"))
            self.assertEqual(server.query("six", "any", DOWN).status, 200)
            before = series(server.ask("/metrics").body)
            builds = [name for name in before if name.startswith("sightline_tree_builds_total")]
            self.assertGreater(sum(before[name] for name in builds), 0)
            self.assertGreater(before["sightline_geometry_bytes"], 0)
            self.assertGreater(before["sightline_tree_bytes"], 0)
            self.assertEqual(server.ask("/v1/scenes/six", "-X", "DELETE").status, 204)
            end = time.monotonic() + PATIENCE
            while (after := series(server.ask("/metrics").body))["sightline_geometry_bytes"] > 0:
                self.assertLess(time.monotonic(), end)
            self.assertEqual(after["sightline_tree_bytes"], 0)
            for name in builds:
                self.assertGreaterEqual(after[name], before[name])

    def test_every_metric_stands_in_the_table(self):
        page = (SOURCE / "docs/reference/metrics.md").read_text(encoding="utf-8")
        written = dict(re.findall(r"^\| `(\w+)`(?: by .*?)? \| (\w+) \|", page, re.MULTILINE))
        self.server.query("none", "any", DOWN)
        self.assertEqual(written, dict(re.findall(r"^# TYPE (\S+) (\S+)$", self.server.ask("/metrics").body.decode(), re.MULTILINE)))

    def test_stats_tell_what_was_read_skipped_and_built(self):
        put = self.server.put("features", (SCENES / "features.glb").read_bytes()).json()
        stats = self.server.ask("/v1/scenes/features/stats").json()
        self.assertEqual((stats["id"], stats["revision"]), ("features", put["revision"]))
        for name in ("nodes", "instances", "meshes", "triangles"):
            self.assertEqual(stats["counts"][name], put["counts"][name])
        self.assertEqual(stats["counts"]["warnings"], len(put["warnings"]))
        self.assertEqual(stats["bytes"]["touched"], sum(stats["bytes"]["by_kind"].values()))
        self.assertEqual(stats["bytes"]["touched"], put["counts"]["bytes_touched"])
        self.assertEqual(stats["bytes"]["by_kind"]["others"], 0)
        self.assertGreater(sum(stats["skipped"].values()), 0)
        self.server.query("features", "any", DOWN)
        metrics = self.ask()
        for scene in self.server.ask("/v1/scenes").json()["scenes"]:
            if scene["id"] != "features":
                self.server.ask("/v1/scenes/" + scene["id"], "-X", "DELETE")
        metrics = self.ask()
        for name, count in stats["skipped"].items():
            self.assertEqual(metrics[f'sightline_skipped{{what="{name}"}}'], count)
        self.assertEqual(metrics['sightline_bytes_touched{kind="positions"}'], stats["bytes"]["by_kind"]["positions"])
        self.assertEqual(metrics["sightline_triangles"], put["counts"]["triangles"])
        self.assertEqual(self.server.ask("/v1/scenes/none/stats").status, 404)

    def test_what_is_not_skipped_is_counted_as_read(self):
        with Server("--skip", "none") as server:
            server.put("features", (SCENES / "features.glb").read_bytes())
            stats = server.ask("/v1/scenes/features/stats").json()
            self.assertEqual(stats["trees"]["complete"], True)
            self.assertEqual(stats["bytes"]["touched"], sum(stats["bytes"]["by_kind"].values()))


if __name__ == "__main__":
    case_report.main()
