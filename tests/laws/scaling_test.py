#!/usr/bin/env python3
"""The simulation and the plan of scripts/scaling.py under test."""

import random
import sys
import types
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import scaling

OPTIONS = types.SimpleNamespace(rays_per_request=100, peak=3, use=0.6, cold=0, machine_cores=8, machine_gbit=10, origin_gbit=100, machine_price=0.4,
                                get_price=0, gb_price=0)


class Plan(unittest.TestCase):
    def plan(self, rays, **options):
        return scaling.plan(scaling.COSTS, "binary", rays, types.SimpleNamespace(**{**vars(OPTIONS), **options}))

    def test_processors_are_the_sum_of_requests_and_rays(self):
        each = scaling.COSTS["binary"]
        found = self.plan(8.64e11)  # 10^7 rays and 10^5 requests a second
        self.assertAlmostEqual(found["cores"], 1e5 * each["request_us"] * 1e-6 + 1e7 * each["ray_ns"] * 1e-9)
        self.assertAlmostEqual(found["requests_per_second"], 1e5)

    def test_the_limit_moves_with_the_size_of_requests(self):
        self.assertEqual(self.plan(1e12, rays_per_request=1)["limit"], "processors")
        self.assertEqual(self.plan(1e12, rays_per_request=10_000)["limit"], "network")
        self.assertTrue(self.plan(1e12, rays_per_request=1, cold=1e-3)["limit"].startswith("origin"))
        self.assertEqual(self.plan(1e6)["machines"], 2)


class Servers(unittest.TestCase):
    def test_every_scene_is_fetched_once_where_nothing_fails_and_one_client_asks(self):
        simulation = scaling.Simulation(3, fetch_seconds=0.01)
        simulation.closed([i % 50 for i in range(500)], 1, 0.001)
        self.assertEqual(sum(each.loads for each in simulation.replicas), 50)
        self.assertEqual(len(simulation.times), 500)
        self.assertAlmostEqual(sum(each.busy for each in simulation.replicas), 0.5)

    def test_only_scenes_of_a_lost_server_move(self):
        simulation = scaling.Simulation(10)
        simulation.closed(range(300), 1, 0.001)
        owned = simulation.replicas[4].loads
        simulation.fail(simulation.replicas[4])
        simulation.closed(range(300), 1, 0.001)
        self.assertEqual(sum(each.loads for each in simulation.replicas), 300 + owned)

    def test_a_failure_loses_no_request(self):
        simulation = scaling.Simulation(5, cores=1)
        for time in range(1, 9):
            simulation.at(time, simulation.fail, simulation.replicas[time % 5])
            simulation.at(time + 3, simulation.come_back, simulation.replicas[time % 5])
        asked = [0]
        scenes = (asked.__setitem__(0, asked[0] + 1) or i % 40 for i in range(2000))
        simulation.closed(scenes, 16, 0.02)
        self.assertEqual((asked[0], len(simulation.times), simulation.failed), (2000, 2000, 0))
        self.assertGreater(simulation.repeated, 0)
        self.assertEqual((simulation.total_served, simulation.under_way), (0, {}))

    def test_a_hot_scene_is_answered_by_as_many_servers_as_its_load_needs(self):
        for clients, least, most in ((1, 1, 1), (40, 4, 5)):
            simulation = scaling.Simulation(5)
            simulation.closed([7] * 1000, clients, 0.001)
            self.assertTrue(least <= sum(each.loads > 0 for each in simulation.replicas) <= most, clients)

    def test_a_cache_drops_the_least_recently_used_scene(self):
        simulation = scaling.Simulation(1, cache_scenes=2)
        simulation.closed([1, 2, 1, 3, 1, 2], 1, 0.001)
        self.assertEqual(simulation.replicas[0].loads, 4)

    def test_times_of_one_server_are_those_of_queueing_theory(self):
        simulation, dice = scaling.Simulation(1, cores=1, fetch_seconds=0), random.Random(1)
        simulation.open(400, 50, [1.0], 0.01, dice)  # M/M/1 at half load: the mean is 0.01 / (1 - 0.5)
        self.assertAlmostEqual(sum(simulation.times) / len(simulation.times), 0.02, delta=0.002)


if __name__ == "__main__":
    unittest.main()
