"""Compares the simulation of scripts/scaling.py with three real servers behind HAProxy: scaling_check.py BINARY [--costs FILE]

One server behind HAProxy is measured, before and after: CPU for a request, for a ray and for the load of a scene whose trees the origin
has. Between them four clients ask HAProxy for scenes at random, in three phases: three servers; two, after one is killed and its disk is
cleared; three again. The simulation gets the means of the measured costs and the same scenes in the same phases. Compared are CPU seconds of the servers, loads of scenes, and
the share of the busiest server. CPU seconds and counts depend little on what else the machine does; times of answers do, and are not compared.

Closes with "1 passed, 0 failed" if each differs by at most 20%. --costs FILE writes what was measured, for `scripts/scaling.py --costs`.
"""

import argparse
import http.client
import json
import os
import random
import re
import shutil
import sys
import tempfile
import threading
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/integration"), str(SOURCE / "scripts")]

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("binary")
parser.add_argument("--scenes", type=int, default=60, help="default: %(default)s")
parser.add_argument("--requests", type=int, default=1200, help="of each phase; default: %(default)s")
parser.add_argument("--rays", type=int, default=1000, help="of a request; default: %(default)s")
parser.add_argument("--seed", type=int, default=1, help="default: %(default)s")
parser.add_argument("--costs", type=Path, help="file to write")
arguments = parser.parse_args()
sys.argv = [sys.argv[0], arguments.binary]

import scaling  # noqa: E402  (found only now)
from balancer import Balancer  # noqa: E402
from kills import grid_glb  # noqa: E402
from sightline_server import Server, curl  # noqa: E402

CLIENTS = 4


def body(rays):
    dice = random.Random(arguments.seed)
    origins = [number for _ in range(rays) for number in (dice.random(), 5, dice.random())]
    return json.dumps({"origins": origins, "directions": [0.001, -1, 0.002] * rays, "fields": ["t", "instance", "primitive", "triangle"]}).encode()


def cpu_seconds(server):
    fields = Path(f"/proc/{server.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def loads(server):
    return int(re.search(r'sightline_loads_total\{outcome="ready"\} (\d+)', server.ask("/metrics").body.decode())[1])


def requests_of(server):
    return sum(map(int, re.findall(r'^sightline_requests_total\{.*rays:closest".*\} (\d+)$', server.ask("/metrics").body.decode(), re.MULTILINE)))


def ask_all(port, scenes, text):
    """Four clients take the scenes one after the other; returns bytes of an answer."""
    rest, lock, sizes, faults = iter(scenes), threading.Lock(), [], []

    def client():
        connection = http.client.HTTPConnection("127.0.0.1", port)
        while True:
            with lock:
                scene = next(rest, None)
            if scene is None:
                return
            connection.request("POST", f"/v1/scenes/s{scene}/rays:closest", text, {"Content-Type": "application/json"})
            answer = connection.getresponse()
            content = answer.read()
            if answer.status != 200:
                faults.append(content[:200])
            sizes.append(len(content))

    threads = [threading.Thread(target=client) for _ in range(CLIENTS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if faults:
        raise RuntimeError(f"{len(faults)} queries failed: {faults[0]}")
    return sizes[-1]


def port_of(balancer):
    return int(balancer.url.rsplit(":", 1)[1])


def measure(folder, name):
    """Costs of one server, in the form of scaling.COSTS. HAProxy stands in front of it as it does in the phases: what runs on the other
    processors of a machine changes the CPU seconds of a server."""
    with Server("--data", folder / name, "--origin", folder / "origin", "--log-level", "info", "--threads", 1) as server, \
            Balancer([server.port] * 3) as balancer:
        port = port_of(balancer)
        text, single = body(arguments.rays), body(1)
        begin, before = cpu_seconds(server), loads(server)
        ask_all(port, range(arguments.scenes), single)
        load = (cpu_seconds(server) - begin) / (loads(server) - before)
        ask_all(port, [0] * 200, text)
        begin = cpu_seconds(server)
        ask_all(port, [i % arguments.scenes for i in range(4000)], single)
        request = (cpu_seconds(server) - begin) / 4000
        begin = cpu_seconds(server)
        size = ask_all(port, [i % arguments.scenes for i in range(1000)], text)
        ray = ((cpu_seconds(server) - begin) / 1000 - request) / (arguments.rays - 1)
    files = sum(file.stat().st_size for file in (folder / "origin").rglob("*") if file.is_file())
    return {"json": {"request_us": request * 1e6, "ray_ns": ray * 1e9, "bytes_in": len(text) / arguments.rays, "bytes_out": size / arguments.rays},
            "load_cpu_ms": (load - request) * 1e3, "scene_bytes": files // arguments.scenes}


def mean(first, second):
    """Of two trees of numbers."""
    return {key: mean(first[key], second[key]) for key in first} if isinstance(first, dict) else (first + second) / 2


def start(folder, number):
    return Server("--data", folder / f"data{number}", "--origin", folder / "origin", "--log-level", "info", "--threads", 1)


def real(folder, phases, text):
    servers, cpu, load, counts = [start(folder, i) for i in range(3)], 0.0, 0, [0, 0, 0]
    try:
        begin = [cpu_seconds(server) for server in servers]
        ports = [server.port for server in servers]
        with Balancer(ports) as balancer:
            port = port_of(balancer)
            ask_all(port, phases[0], text)
            cpu, load, counts[2] = cpu_seconds(servers[2]) - begin[2], loads(servers[2]), requests_of(servers[2])
            servers.pop().kill()
            shutil.rmtree(folder / "data2")
            ask_all(port, phases[1], text)
        # HAProxy learns the new port by a start of its own: it has three ready servers at once.
        servers.append(start(folder, 2))
        begin[2] = cpu_seconds(servers[2])
        with Balancer([server.port for server in servers]) as balancer:
            ask_all(port_of(balancer), phases[2], text)
        for i, server in enumerate(servers):
            cpu, load, counts[i] = cpu + cpu_seconds(server) - begin[i], load + loads(server), counts[i] + requests_of(server)
        return {"CPU seconds": cpu, "loads": load, "share of the busiest": max(counts) / sum(counts)}
    finally:
        for server in servers:
            server.end()


def simulated(costs, phases):
    each = costs["json"]
    cpu = each["request_us"] * 1e-6 + arguments.rays * each["ray_ns"] * 1e-9
    simulation = scaling.Simulation(3, cores=len(os.sched_getaffinity(0)), load_cpu=costs["load_cpu_ms"] * 1e-3, fetch_seconds=0)
    replica = simulation.replicas[2]
    simulation.closed(phases[0], CLIENTS, cpu)
    simulation.fail(replica)
    simulation.closed(phases[1], CLIENTS, cpu)
    simulation.come_back(replica)
    simulation.closed(phases[2], CLIENTS, cpu)
    counts = [each.requests for each in simulation.replicas]
    return {"CPU seconds": sum(each.busy for each in simulation.replicas), "loads": sum(each.loads for each in simulation.replicas),
            "share of the busiest": max(counts) / sum(counts)}


def main():
    dice = random.Random(arguments.seed)
    weights = scaling.zipf(arguments.scenes, 0.8)
    phases = [dice.choices(range(arguments.scenes), cum_weights=weights, k=arguments.requests) for _ in range(3)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with Server("--data", folder / "first", "--origin", folder / "origin", "--log-level", "info", "--threads", 1) as server:
            for i in range(arguments.scenes):
                put = curl(f"{server.url}/v1/scenes/s{i}?wait=60", "-X", "PUT", body=grid_glb(60, i + 1))
                assert put.status in (200, 201), put.body
        before = measure(folder, "before")
        measured = real(folder, phases, body(arguments.rays))
        costs = mean(before, measure(folder, "after"))
    print(json.dumps(costs, indent=1))
    if arguments.costs:
        arguments.costs.write_text(json.dumps(costs), encoding="ascii")
    predicted = simulated(costs, phases)
    good = True
    for what, value in measured.items():
        away = predicted[what] / value - 1
        good = good and abs(away) <= 0.2
        print(f"{what}: measured {value:.3f}, simulated {predicted[what]:.3f}, {100 * away:+.1f}%")
    print("1 passed, 0 failed" if good else "0 passed, 1 failed")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
