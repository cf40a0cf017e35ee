"""Everything at once, for a moment; scripts/stress.sh soak does it for longer and says how fast."""

import argparse
import tempfile
import unittest

import case_report
import soak
from process_status import is_sanitized
from sightline_server import Server


class Soak(unittest.TestCase):
    def test_every_answer_is_right_and_none_is_missing(self):
        # A sanitizer takes minutes for the truth of whole batches.
        with Server() as server:
            if is_sanitized(server):
                soak.BATCH = 10_000
        truth = soak.Truth(Server, seed=7, checked_rays=10)
        options = argparse.Namespace(minutes=0.1, workers=8, seed=7, difficult=False)
        with tempfile.TemporaryDirectory() as folder:
            with Server("--preload", "town=demo:town", "--data", folder, "--workers", 8, "--log-level", "warn") as server:
                told, _, _ = soak.measure(server, truth, options)
                self.assertEqual(server.stop(), 0)
        for name, asked, _, wrong, _, failed, _, _, _ in told:
            print(f"{name}: {asked} requests")
            self.assertEqual((wrong, failed), ([], []))
            self.assertGreater(asked, 0)


if __name__ == "__main__":
    case_report.main()
