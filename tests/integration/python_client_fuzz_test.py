"""The Python client against a model for a moment; scripts/stress.sh client does it for longer."""

import unittest

import case_report
import python_client_fuzz
import python_client_model
from sightline_server import SOURCE, Server

SEED, CALLS = 20261123, 5000


class Model(unittest.TestCase):
    def test_a_line_meets_a_triangle_at_its_edges_and_corners_too(self):
        corners = [[0, 0, 0], [4, 0, 0], [0, 4, 0]]
        for origin, t in (([1, 1, 5], 5), ([0, 0, 5], 5), ([2, 2, -5], -5), ([2, 3, 5], None), ([-1, 0, 5], None)):
            self.assertEqual(python_client_model.meeting(corners, origin, [0, 0, -1]), t)
        self.assertIsNone(python_client_model.meeting(corners, [0, 0, 1], [1, 0, 0]))
        self.assertIs(python_client_model.meeting(corners, [9, 0, 0], [1, 0, 0]), NotImplemented)


@unittest.skipUnless(python_client_fuzz.numpy, "SKIPPED: numpy is not installed")
class PythonClientFuzz(unittest.TestCase):
    def test_every_call_is_refused_or_has_the_answer_of_the_model(self):
        with Server(*python_client_fuzz.PRELOAD, "--log-level", "warn") as server:
            fuzz = python_client_fuzz.run(server, SOURCE, CALLS, SEED)
        print(f"seed {SEED}: {CALLS} calls: {fuzz.text()}")
        self.assertEqual(fuzz.wrong, [])
        self.assertGreater(fuzz.counts["answered"], CALLS // 3)
        self.assertGreater(fuzz.counts["refused"], CALLS // 5)


if __name__ == "__main__":
    case_report.main()
