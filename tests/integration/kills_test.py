"""kill -9 at random moments; scripts/stress.sh kills does it for longer."""

import tempfile
import unittest
from pathlib import Path

import case_report
import kills
from sightline_server import Server

SEED = 20261121


class Kills(unittest.TestCase):
    def test_every_acknowledged_scene_is_there_and_right_after_a_kill(self):
        with tempfile.TemporaryDirectory() as folder:
            trial = kills.Trial(Server, Path(folder, "data"), SEED)
            trial.run(5)
            print(f"seed {SEED}: {trial.text()}")
            self.assertEqual(trial.kills, 5)

    def test_scenes_in_mapped_temporary_files_leave_nothing_on_the_disk(self):
        with tempfile.TemporaryDirectory() as folder:
            trial = kills.Trial(Server, Path(folder, "data"), SEED, budget=1 << 20)
            trial.run(5)
            print(f"seed {SEED}: {trial.text()}")
            self.assertGreater(trial.in_files, 0)


if __name__ == "__main__":
    case_report.main()
