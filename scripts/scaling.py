#!/usr/bin/env python3
"""How many machines a load needs, and how several servers behave behind a balancer (docs/explanation/scaling.md).

  scripts/scaling.py plan [--rays-per-day N] [--rays-per-request N] [--form binary|json]...
  scripts/scaling.py simulate [--replicas N] [--seconds N] [--rate N] [--failures-per-hour N]...

`plan` prints machines and money for 10^9 and 10^12 rays a day, and what limits them: processors, network or origin. `simulate` runs a
discrete simulation: consistent hashing with bounded load as in docker/haproxy.cfg, caches, fetches from the origin, failures.
Both use measured costs (--costs FILE, a file that tests/cluster/scaling_check.py writes; default: those of docs/benchmarks).
"""

import argparse
import bisect
import collections
import hashlib
import heapq
import json
import math
import random
import sys

# Measured: docs/benchmarks/http.md (scan of 100,002 triangles, AMD EPYC; fields t, instance, primitive, triangle), and
# docs/guides/replicas.md. CPU is of the server; bytes are of the bodies, both ways, without the 500 bytes of the headers.
COSTS = {
    "binary": {"request_us": 20.9, "ray_ns": 91.0, "bytes_in": 48, "bytes_out": 24},
    "json": {"request_us": 20.3, "ray_ns": 271.0, "bytes_in": 120, "bytes_out": 60},
    "header_bytes": 500,
    "load_cpu_ms": 10.0,  # of a scene whose trees the origin has
    "scene_bytes": 10_000_000,  # file and trees of 100,000 triangles
}
BALANCE_FACTOR = 1.25  # hash-balance-factor of docker/haproxy.cfg
RING_POINTS = 16  # of a server of weight 1 in HAProxy


def plan(costs, form, rays_per_day, options):
    """Machines for a load. Peak load is `peak` times the mean; a machine is used to the part `use` at most."""
    each, seconds = costs[form], 86400
    requests = rays_per_day / options.rays_per_request
    cores = (requests * each["request_us"] * 1e-6 + rays_per_day * each["ray_ns"] * 1e-9) / seconds
    received = requests * costs["header_bytes"] + rays_per_day * each["bytes_in"]
    sent = requests * costs["header_bytes"] + rays_per_day * each["bytes_out"]
    cold = requests * options.cold
    cores += cold * costs["load_cpu_ms"] * 1e-3 / seconds
    fetched = cold * costs["scene_bytes"]
    # A network card works both ways at once: the larger direction limits.
    network = max(received + fetched, sent) * 8 / seconds / 1e9
    origin = fetched * 8 / seconds / 1e9
    factor = options.peak / options.use
    needs = {"processors": cores * factor / options.machine_cores, "network": network * factor / options.machine_gbit}
    # Two at least: one may be away.
    machines = max(2, *(math.ceil(need) for need in needs.values()))
    limit = max(needs, key=needs.get)
    if max(needs.values()) <= 1:
        limit = "none: two for the loss of one"
    if origin * options.peak > options.origin_gbit:
        limit = f"origin ({origin * options.peak:.0f} Gbit/s at the peak)"
    month = 30 * 24 * machines * options.machine_price
    month += 30 * cold / 1000 * 2 * options.get_price + 30 * (received + sent) / 1e9 * options.gb_price
    return {"requests_per_second": requests / seconds, "cores": cores, "network_gbit": network, "origin_gbit": origin, "machines": machines,
            "limit": limit, "price_per_month": month, "price_per_billion_rays": month / (rays_per_day * 30) * 1e9}


def number(text):
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big")


class Replica:
    def __init__(self, name):
        self.name = name
        self.is_up = self.is_seen = True  # is_seen: the balancer takes it for ready
        self.served = 0  # requests that the balancer has under way here
        self.running = 0
        self.queue = collections.deque()
        self.cache = collections.OrderedDict()  # scenes, the least recently used first
        self.fetching = {}  # scene -> requests that wait for it
        self.life = 0  # number of its starts: what an earlier life had begun never ends
        self.requests = self.loads = 0
        self.busy = 0.0


class Request:
    def __init__(self, arrival, scene, cpu, done):
        self.arrival, self.scene, self.cpu = arrival, scene, cpu  # cpu: seconds
        self.done = done  # called with the answer; may be None
        self.replica = None  # that has accepted it


class Simulation:
    """Time in seconds."""

    def __init__(self, replicas, *, cores=2, cache_scenes=1000, fetch_seconds=0.02, scene_bytes=0, replica_gbit=10.0, origin_gbit=10.0,
                 load_cpu=0.0, notice=1.5, factor=BALANCE_FACTOR):
        self.now, self.events, self.sequence = 0.0, [], 0
        self.replicas = [Replica(i) for i in range(replicas)]
        self.cores, self.cache_scenes, self.load_cpu, self.notice, self.factor = cores, cache_scenes, load_cpu, notice, factor
        self.fetch_seconds, self.scene_bytes = fetch_seconds, scene_bytes
        self.replica_rate, self.origin_rate, self.origin_free = replica_gbit * 1e9 / 8, origin_gbit * 1e9 / 8, 0.0
        self.ring = sorted((number(f"{i}/{point}"), i) for i in range(replicas) for point in range(RING_POINTS))
        self.orders, self.total_served = {}, 0
        self.rank()
        self.times, self.repeated, self.failed = [], 0, 0
        self.under_way = {}  # requests that a replica has accepted and not answered, in their order: keys of a dict

    def at(self, time, action, *arguments):
        self.sequence += 1
        heapq.heappush(self.events, (time, self.sequence, action, arguments))

    def run(self, until=math.inf):
        while self.events and self.events[0][0] <= until:
            self.now, _, action, arguments = heapq.heappop(self.events)
            action(*arguments)

    def order(self, scene):
        """All replicas in the order of the ring from the scene on."""
        if scene not in self.orders:
            first = bisect.bisect(self.ring, (number(f"scene/{scene}"), 0))
            self.orders[scene] = tuple(dict.fromkeys(i for _, i in self.ring[first:] + self.ring[:first]))
        return self.orders[scene]

    def rank(self):
        self.ranks = {replica: rank for rank, replica in enumerate(each for each in self.replicas if each.is_seen)}

    def share(self, slots, replica):
        """Slots of a server, as HAProxy divides them: whole numbers whose sum is `slots`, but one at least."""
        rank, count = self.ranks[replica], len(self.ranks)
        return max(1, slots * (rank + 1) // count - slots * rank // count)

    def send(self, request):
        """The first server of the ring that has room; a dead one that the balancer has not noticed refuses, and the next is asked."""
        slots = math.ceil(self.factor * (self.total_served + 1))
        for name in self.order(request.scene):
            replica = self.replicas[name]
            if not replica.is_seen or replica.served >= self.share(slots, replica):
                continue
            if not replica.is_up:
                self.repeated += 1
                continue
            replica.served += 1
            self.total_served += 1
            replica.requests += 1
            request.replica = replica
            self.under_way[request] = None
            self.arrive(replica, request)
            return
        if self.ranks:  # All that are left refuse: the client repeats.
            self.at(self.now + 0.1, self.send, request)
        else:
            self.failed += 1
            if request.done:
                request.done()

    def arrive(self, replica, request):
        scene = request.scene
        if scene in replica.cache:
            replica.cache.move_to_end(scene)
            self.queue(replica, request)
        elif scene in replica.fetching:
            replica.fetching[scene].append(request)
        else:
            replica.fetching[scene] = [request]
            begin = max(self.now, self.origin_free)
            self.origin_free = begin + self.scene_bytes / self.origin_rate
            self.at(max(self.origin_free, begin + self.scene_bytes / self.replica_rate) + self.fetch_seconds, self.fetched, replica, replica.life, scene)

    def fetched(self, replica, life, scene):
        if life != replica.life:
            return
        replica.loads += 1
        replica.cache[scene] = True
        if len(replica.cache) > self.cache_scenes:
            replica.cache.popitem(last=False)
        waiting = replica.fetching.pop(scene)
        waiting[0].cpu += self.load_cpu
        for request in waiting:
            self.queue(replica, request)

    def queue(self, replica, request):
        replica.queue.append(request)
        self.begin(replica)

    def begin(self, replica):
        while replica.queue and replica.running < self.cores:
            request = replica.queue.popleft()
            replica.running += 1
            self.at(self.now + request.cpu, self.end, replica, replica.life, request)

    def end(self, replica, life, request):
        if life != replica.life:
            return
        replica.running -= 1
        replica.busy += request.cpu
        replica.served -= 1
        self.total_served -= 1
        del self.under_way[request]
        self.times.append(self.now - request.arrival)
        self.begin(replica)
        if request.done:
            request.done()

    def ask(self, scene, cpu, done=None):
        self.send(Request(self.now, scene, cpu, done))

    def fail(self, replica, lose_cache=True):
        """A replica dies. What it had under way is sent again at once; the balancer avoids it after `notice` seconds."""
        if not replica.is_up:
            return
        replica.is_up, replica.running, replica.served = False, 0, 0
        replica.life += 1
        replica.queue.clear()
        replica.fetching.clear()
        if lose_cache:
            replica.cache.clear()
        lost = [each for each in self.under_way if each.replica is replica]
        self.total_served -= len(lost)
        self.at(self.now + self.notice, self.unsee, replica, replica.life)
        for request in lost:
            del self.under_way[request]
            self.repeated += 1
            self.send(request)

    def unsee(self, replica, life):
        if life == replica.life and replica.is_seen:
            replica.is_seen = False
            self.rank()

    def come_back(self, replica):
        replica.life += 1
        replica.is_up = replica.is_seen = True
        self.rank()

    def closed(self, scenes, clients, cpu):
        """`clients` ask one after the other until all `scenes` (an iterable, one for each request) have an answer."""
        rest = iter(scenes)

        def following():
            scene = next(rest, None)
            if scene is not None:
                self.ask(scene, cpu, following)

        for _ in range(clients):
            following()
        self.run()

    def open(self, seconds, rate, popularity, cpu, dice):
        """Requests arrive at random; popularity: cumulative weights of the scenes."""
        end = self.now + seconds

        def arrival():
            self.ask(bisect.bisect(popularity, dice.random() * popularity[-1]), dice.expovariate(1 / cpu))
            if self.now < end:
                self.at(self.now + dice.expovariate(rate), arrival)

        self.at(self.now, arrival)
        self.run(end)


def zipf(scenes, exponent):
    """Cumulative weights 1/rank^exponent."""
    total, weights = 0.0, []
    for rank in range(1, scenes + 1):
        total += rank ** -exponent
        weights.append(total)
    return weights


def simulate(costs, options):
    dice = random.Random(options.seed)
    each = costs[options.form]
    cpu = each["request_us"] * 1e-6 + options.rays_per_request * each["ray_ns"] * 1e-9
    simulation = Simulation(options.replicas, cores=options.machine_cores, cache_scenes=options.cache_scenes, scene_bytes=costs["scene_bytes"],
                            replica_gbit=options.machine_gbit, origin_gbit=options.origin_gbit, load_cpu=costs["load_cpu_ms"] * 1e-3)
    rate = options.rate or options.load * options.replicas * options.machine_cores / cpu
    popularity = zipf(options.scenes, options.zipf)
    simulation.open(options.warm_seconds, rate, popularity, cpu, dice)  # Caches fill; not counted.
    simulation.times, simulation.repeated, simulation.failed = [], 0, 0
    for replica in simulation.replicas:
        replica.loads, replica.busy = 0, 0.0
    failures = 0
    if options.failures_per_hour:
        time = dice.expovariate(options.failures_per_hour / 3600)
        while time < options.seconds:
            replica = dice.choice(simulation.replicas)
            simulation.at(simulation.now + time, simulation.fail, replica)
            simulation.at(simulation.now + time + options.down_seconds, simulation.come_back, replica)
            failures += 1
            time += dice.expovariate(options.failures_per_hour / 3600)
    simulation.open(options.seconds, rate, popularity, cpu, dice)
    times = sorted(simulation.times)
    uses = [replica.busy / options.seconds / options.machine_cores for replica in simulation.replicas]
    return {"requests": len(times), "failed": simulation.failed, "failures": failures, "sent again": simulation.repeated,
            "p50 ms": 1e3 * times[len(times) // 2], "p99 ms": 1e3 * times[len(times) * 99 // 100], "p99.9 ms": 1e3 * times[len(times) * 999 // 1000],
            "mean use": sum(uses) / len(uses), "largest use": max(uses), "loads": sum(replica.loads for replica in simulation.replicas),
            "loads for each scene": sum(replica.loads for replica in simulation.replicas) / options.scenes}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    plans, simulations = commands.add_parser("plan", help="machines and money"), commands.add_parser("simulate", help="servers with failures")
    for each in (plans, simulations):
        each.add_argument("--costs", help="JSON of tests/cluster/scaling_check.py; default: docs/benchmarks")
        each.add_argument("--form", choices=("binary", "json"), default="binary", help="default: %(default)s")
        each.add_argument("--rays-per-request", type=float, help="default: 1, 100 and 10,000 for plan, 100,000 for simulate")
        each.add_argument("--machine-cores", type=int, default=8 if each is plans else 2, help="default: %(default)s")
        each.add_argument("--machine-gbit", type=float, default=10, help="network of a machine; default: %(default)s")
        each.add_argument("--origin-gbit", type=float, default=100, help="network of the origin; default: %(default)s")
    plans.add_argument("--rays-per-day", type=float, help="default: 1e9 and 1e12")
    plans.add_argument("--cold", type=float, default=1e-5, help="part of the requests whose scene the server must fetch; default: %(default)s")
    plans.add_argument("--peak", type=float, default=3, help="peak load over mean load; default: %(default)s")
    plans.add_argument("--use", type=float, default=0.6, help="largest use of a machine; default: %(default)s")
    plans.add_argument("--machine-price", type=float, default=0.4, help="of a machine for an hour; default: %(default)s")
    plans.add_argument("--get-price", type=float, default=0.0004, help="of 1,000 reads of the origin; default: %(default)s")
    plans.add_argument("--gb-price", type=float, default=0.0, help="of a GB to and from the clients; default: %(default)s")
    simulations.add_argument("--replicas", type=int, default=100, help="default: %(default)s")
    simulations.add_argument("--seconds", type=float, default=20, help="default: %(default)s")
    simulations.add_argument("--warm-seconds", type=float, default=5, help="before them, without failures; default: %(default)s")
    simulations.add_argument("--rate", type=float, help="requests a second; default: --load of the processors")
    simulations.add_argument("--load", type=float, default=0.5, help="part of the processors that requests take; default: %(default)s")
    simulations.add_argument("--scenes", type=int, default=3000, help="default: %(default)s")
    simulations.add_argument("--zipf", type=float, default=0.8, help="popularity of scene k is 1/k^ZIPF; default: %(default)s")
    simulations.add_argument("--cache-scenes", type=int, default=1000, help="scenes that a server holds; default: %(default)s")
    simulations.add_argument("--failures-per-hour", type=float, default=600, help="of all servers; default: %(default)s")
    simulations.add_argument("--down-seconds", type=float, default=20, help="default: %(default)s")
    simulations.add_argument("--seed", type=int, default=1, help="default: %(default)s")
    options = parser.parse_args()
    costs = COSTS
    if options.costs:
        with open(options.costs, encoding="utf-8") as file:
            costs = {**COSTS, **json.load(file)}
    if options.command == "simulate":
        options.rays_per_request = options.rays_per_request or 100_000
        for name, value in simulate(costs, options).items():
            print(f"{name:22} {value:,.3f}" if isinstance(value, float) else f"{name:22} {value:,}")
        return 0
    print("| rays a day | rays in a request | requests a second | processors | network, Gbit/s | origin, Gbit/s | machines | limit | a month | 10^9 rays |")
    print("|--:|--:|--:|--:|--:|--:|--:|---|--:|--:|")
    for rays in [options.rays_per_day] if options.rays_per_day else [1e9, 1e12]:
        for batch in [options.rays_per_request] if options.rays_per_request else [1, 100, 10000]:
            options.rays_per_request = batch
            found = plan(costs, options.form, rays, options)
            print(f"| {rays:.0e} | {batch:,.0f} | {found['requests_per_second']:,.0f} | {found['cores']:,.2f} | {found['network_gbit']:,.2f} | "
                  f"{found['origin_gbit']:,.2f} | {found['machines']:,} | {found['limit']} | {found['price_per_month']:,.0f} | "
                  f"{found['price_per_billion_rays']:,.4f} |")
            options.rays_per_request = None
    return 0


if __name__ == "__main__":
    sys.exit(main())
