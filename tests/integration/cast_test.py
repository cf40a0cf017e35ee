"""The command line without a server."""

import json
import subprocess
import tempfile
import unittest
from pathlib import Path

import case_report
from sightline_server import BINARY, PATIENCE, SOURCE, Server

FEATURES = SOURCE / "tests/data/scenes/features.glb"


def sightline(*arguments):
    return subprocess.run([BINARY, *map(str, arguments)], capture_output=True, text=True, timeout=PATIENCE, check=False)


def cast(source, origin, direction, *arguments):
    return sightline("cast", source, "--origin", origin, "--direction", direction, *arguments)


class Cast(unittest.TestCase):
    def test_a_hit_is_a_line_of_json_and_exit_code_0(self):
        done = cast("demo:six", "-10,1,0", "1,0,0")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        hit = json.loads(done.stdout)
        self.assertEqual((hit["t"], hit["position"], hit["node"], hit["mesh"]), (4.5, [-5.5, 1, 0], "left", "left"))

    def test_a_miss_is_null_and_exit_code_1(self):
        done = cast("demo:six", "1,10,0", "0,-1,0")
        self.assertEqual((done.returncode, done.stdout, done.stderr), (1, "null\n", ""))
        done = cast("demo:six", "-10,1,0", "1,0,0", "--tmax", "4.25")
        self.assertEqual((done.returncode, done.stdout), (1, "null\n"))

    def test_limits_and_fields_are_heeded(self):
        done = cast("demo:six", "-10,1,0", "1,0,0", "--tmin", "5", "--fields", "t,triangle")
        self.assertEqual((done.returncode, done.stdout), (0, '{"t":6.5,"triangle":1}\n'))

    def test_the_file_says_more_of_a_place_when_it_is_asked(self):
        done = cast("demo:painted", "0.5,-0.5,5", "0,0,-1", "--fields", "t,uv,colour")
        # The corners weigh 1/4, 1/2 and 1/4: (0,1), (1,1), (1,0), and red, green, blue.
        self.assertEqual((done.returncode, done.stdout), (0, '{"t":5,"uv":[0.75,0.75],"colour":[0.25,0.5,0.25,1]}\n'))

    def test_any_is_true_or_false(self):
        done = cast("demo:six", "-10,1,0", "1,0,0", "--any")
        self.assertEqual((done.returncode, done.stdout), (0, "true\n"))
        done = cast("demo:six", "1,10,0", "0,-1,0", "--any")
        self.assertEqual((done.returncode, done.stdout), (1, "false\n"))

    def test_all_is_a_line_for_each_hit_and_count_their_number(self):
        ray = ("demo:town", "0,100,0", "0,-1,0", "--tmax", "76")
        done = cast(*ray, "--all", "--fields", "t,node")
        self.assertEqual(done.returncode, 0, done.stderr)
        # The tip of the spire, then the diagonals of the tower's top and of the spire's bottom.
        self.assertEqual(done.stdout, '{"t":68,"node":"spire"}\n' * 4 + '{"t":76,"node":"clock tower"}\n' * 2
                         + '{"t":76,"node":"spire"}\n' * 2)
        self.assertEqual(cast(*ray, "--count").stdout, "8\n")
        once = cast(*ray, "--all", "--crossings", "once", "--fields", "t,node")
        self.assertEqual(once.stdout, '{"t":68,"node":"spire"}\n{"t":76,"node":"clock tower"}\n{"t":76,"node":"spire"}\n')
        self.assertEqual(cast(*ray, "--count", "--crossings", "once").stdout, "3\n")
        for mode, printed in (("--all", ""), ("--count", "0\n")):
            done = cast("demo:six", "1,10,0", "0,-1,0", mode)
            self.assertEqual((done.returncode, done.stdout, done.stderr), (1, printed, ""))

    def test_a_file_is_read_from_disk(self):
        self.assertIn(cast(FEATURES, "0,100,0", "0,-1,0").returncode, (0, 1))
        self.assertIn(cast(SOURCE / "tests/data/scenes/features_external.gltf", "0,100,0", "0,-1,0").returncode, (0, 1))

    def test_a_demo_can_be_written_and_read_back(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "six.glb")
            self.assertEqual(sightline("demo", "six", file).returncode, 0)
            self.assertEqual(cast(file, "-10,1,0", "1,0,0").stdout, cast("demo:six", "-10,1,0", "1,0,0").stdout)
            self.assertEqual(sightline("demo", "none", file).returncode, 2)
            self.assertEqual(sightline("demo", "six", Path(folder, "no/such/folder.glb")).returncode, 2)

    def test_every_error_is_exit_code_2_and_silence_on_standard_output(self):
        for arguments in [
                ("demo:six", "1,2,3", "0,0,0"), ("demo:six", "1,2", "0,0,1"), ("demo:six", "1,2,3,4", "0,0,1"),
                ("demo:six", "1,2,x", "0,0,1"), ("demo:six", "1,2,nan", "0,0,1"), ("demo:six", "1,2,", "0,0,1"),
                ("demo:six", "1,2,inf", "0,0,1"), ("demo:six", "1,2,1e999", "0,0,1"),
                ("demo:six", "1,2,3", "0,0,1", "--tmin", "2", "--tmax", "1"),
                ("demo:six", "1,2,3", "0,0,1", "--fields", "t,weight"),
                ("demo:six", "1,2,3", "0,0,1", "--kernel", "abacus"),
                ("demo:none", "1,2,3", "0,0,1"), ("/no/such/file.glb", "1,2,3", "0,0,1"),
                (SOURCE / "README.md", "1,2,3", "0,0,1"), (FEATURES, "1,2,3", "0,0,1", "--scene", "99")]:
            with self.subTest(arguments=arguments):
                done = cast(*arguments)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertTrue(done.stderr.strip())

    def test_an_error_names_the_flag_and_says_what_it_wants(self):
        ray = ("--origin", "1,2,3", "--direction", "0,0,1")
        for arguments, words in [
                (("--origin", "1,2,3", "--direction", "0,0,0"), ("RAY_DIRECTION_ZERO", "--direction")),
                (("--origin", "1,2,nan", "--direction", "0,0,1"), ("RAY_NOT_FINITE", "--origin")),
                ((*ray, "--tmin", "2", "--tmax", "1"), ("RAY_LIMITS_REVERSED", "--tmin")),
                (("--origin", "1,2,1e999", "--direction", "0,0,1"), ("--origin", "'1e999'", "float64")),
                (("--origin", "1,2", "--direction", "0,0,1"), ("--origin", "three numbers")),
                ((*ray, "--fields", "t,weight"), ("--fields", "'weight'", "barycentrics")),
                ((*ray, "--fields", ","), ("--fields", "''")),
                ((*ray, "--scene", "-1"), ("--scene", "'-1'", "number of a scene")),
                ((*ray, "--scene", "x"), ("--scene", "'x'", "number of a scene")),
                ((*ray, "--any", "--all"), ("--any", "--all", "excludes")),
                ((*ray, "--crossings", "once"), ("--crossings", "--all or --count")),
                ((*ray, "--nothing"), ("--nothing",)),
                (("--direction", "0,0,1"), ("--origin", "required")),
                (("--origin",), ("--origin", "X,Y,Z"))]:
            with self.subTest(arguments=arguments):
                done = sightline("cast", "demo:six", *arguments)
                self.assertEqual((done.returncode, done.stdout), (2, ""))
                self.assertTrue(done.stderr.startswith("sightline: "), done.stderr)
                for word in words:
                    self.assertIn(word, done.stderr)
                if not words[0].startswith("RAY_"):
                    self.assertIn("sightline cast --help", done.stderr)

    def test_cast_and_query_share_flags_and_formats(self):
        rays = "-10 1 0  1 0 0\n1,10,0, 0,-1,0\n{\"origin\":[3,10,0],\"direction\":[0,-1,0]}\n"
        with tempfile.TemporaryDirectory() as folder, Server("--preload", "six=demo:six") as server:
            file = Path(folder, "rays.txt")
            file.write_text(rays, encoding="utf-8")
            one = ("--origin", "-10,1,0", "--direction", "1,0,0", "--tmin", "1", "--tmax", "30")
            miss = ("--origin", "1,10,0", "--direction", "0,-1,0")
            for ray in (one, miss, ("--rays", file)):
                for mode in ((), ("--any",), ("--count",), ("--count", "--crossings", "once"), ("--all",)):
                    fields = ("--fields", "t,node") if mode in ((), ("--all",)) else ()
                    for form in ("text", "json", "hits"):
                        with self.subTest(ray=ray, mode=mode, format=form):
                            shared = (*map(str, ray), *mode, *fields, "--format", form)
                            local, remote = sightline("cast", "demo:six", *shared), sightline("query", server.url, "six", *shared)
                            self.assertEqual((local.returncode, local.stdout, local.stderr), (remote.returncode, remote.stdout, remote.stderr))
                            self.assertIn(local.returncode, (0, 1))
            flags = [{word for word in sightline(name, "--help").stdout.replace(",", " ").split() if word.startswith("--")} for name in ("cast", "query")]
            self.assertEqual(flags[0] - {"--scene", "--kernel", "--version);", "--version)"}, flags[1] - {"--key-file"})
        done = subprocess.run([BINARY, "cast", "demo:six", "--rays", "-", "--fields", "t", "--json"], input=rays, capture_output=True, text=True,
                              timeout=PATIENCE, check=False)
        self.assertEqual((done.returncode, done.stdout), (0, '{"t":4.5}\nnull\n{"t":8}\n'))

    def test_numbers_are_rounded_once(self):
        # Halfway cases that go wrong by way of an 80-bit number.
        done = cast("demo:six", "-10,1,0", "1,0,0", "--fields", "t", "--tmin",
                    "4.500000000000000444089209850062616169452667236328125000000000000000000000000000001")
        self.assertEqual(json.loads(done.stdout)["t"], 6.5)

    def test_version_and_help(self):
        done = sightline("--version")
        self.assertEqual(done.returncode, 0)
        self.assertRegex(done.stdout, r"^sightline \d+\.\d+\.\d+\nkernels: \w+")
        for arguments in (["--help"], ["serve", "--help"], ["cast", "--help"], ["demo", "--help"]):
            done = sightline(*arguments)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertEqual(sightline("help").stdout, sightline("--help").stdout)
        self.assertEqual(sightline("help", "cast").stdout, sightline("cast", "--help").stdout)
        for arguments in ([], ["nonsense"], ["serve", "--listen", "nowhere"], ["serve", "--listen", "127.0.0.1:99999"],
                          ["serve", "--workers", "0"], ["serve", "--kernel", "abacus", "--listen", "127.0.0.1:0"]):
            done = sightline(*arguments)
            self.assertEqual((done.returncode, done.stdout), (2, ""))


if __name__ == "__main__":
    case_report.main()
