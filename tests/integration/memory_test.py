"""A server that has too little memory says so and lives on."""

import resource
import unittest

import case_report
from sightline_server import Server, demo_glb

MIB = 1 << 20


def status_bytes(server, name):
    """VmSize, VmRSS, ... of the server's process, as the kernel counts them."""
    with open(f"/proc/{server.process.pid}/status", encoding="ascii") as lines:
        for line in lines:
            if line.startswith(name + ":"):
                return int(line.split()[1]) << 10
    raise AssertionError(f"no {name}")


def many_values(count):
    return b'{"asset":{"version":"2.0"},"extras":[' + b",".join([b"[]"] * count) + b"]}"


def many_arrays_in_nodes(count):
    return b'{"asset":{"version":"2.0"},"nodes":[' + b",".join([b'{"extras":[[],[],[]]}'] * count) + b"]}"


def many_nodes(count):
    return b'{"asset":{"version":"2.0"},"nodes":[' + b",".join([b"{}"] * count) + b"]}"


class LittleMemory(unittest.TestCase):
    def setUp(self):
        self.server = Server("--preload", "six=demo:six", "--workers", 8, "--threads", 1)
        self.addCleanup(self.server.end)
        # Every thread that will ever be has its stack before the limit comes.
        for _ in range(32):
            self.server.ask("/healthz")
        self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))
        if status_bytes(self.server, "VmSize") > 1 << 40:
            self.skipTest("a sanitized process takes terabytes of addresses")

    def limit(self, spare):
        size = status_bytes(self.server, "VmSize") + spare if spare else resource.RLIM_INFINITY
        resource.prlimit(self.server.process.pid, resource.RLIMIT_AS, (size, resource.RLIM_INFINITY))

    def test_a_scene_whose_json_needs_more_than_there_is_is_refused_and_the_server_lives(self):
        for make, count in ((many_values, 1000000), (many_arrays_in_nodes, 150000), (many_nodes, 250000)):
            body = make(count)
            refused = taken = 0
            for spare in (12, 24, 48, 64, 80, 96, 128, 160, 192, 256, 320, 384, 512, 640, 4096):
                with self.subTest(shape=make.__name__, spare=spare):
                    self.limit(spare * MIB)
                    answer = self.server.put("heavy", body, "-H", "Expect:")
                    self.limit(None)
                    self.assertIn(answer.status, (200, 201, 413, 507), answer.body)
                    refused += answer.status == 507
                    taken += answer.status < 300
                    self.assertEqual(self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))[0]["t"], 4.5)
                self.assertIsNone(self.server.process.poll(), "the server ended")
            print(f"{make.__name__}: {len(body)} bytes, refused {refused} times, taken {taken} times")
            self.assertGreater(refused, 0)
            self.assertGreater(taken, 0)

    def test_a_scene_whose_geometry_needs_more_than_there_is_is_refused_and_the_server_lives(self):
        body = demo_glb("town")
        refused = taken = 0
        for spare in (8, 12, 16, 24, 32, 48, 64, 68, 72, 80, 96, 112, 128, 160, 192, 256, 1024):
            with self.subTest(spare=spare):
                self.limit(spare * MIB)
                answer = self.server.put("town", body, "-H", "Expect:")
                self.limit(None)
                self.assertIn(answer.status, (200, 201, 507), answer.body)
                refused += answer.status == 507
                taken += answer.status < 300
                self.assertEqual(self.server.closest("six", ([-10, 1, 0], [1, 0, 0]))[0]["t"], 4.5)
            self.assertIsNone(self.server.process.poll(), "the server ended")
        print(f"{len(body)} bytes, refused {refused} times, taken {taken} times")
        self.assertGreater(refused, 0)
        self.assertGreater(taken, 0)


if __name__ == "__main__":
    case_report.main()
