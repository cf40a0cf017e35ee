"""HAProxy with docker/haproxy.cfg in front of three servers on loopback."""

import os
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request

from sightline_server import PATIENCE, SOURCE

CONFIGURATION = SOURCE / "docker/haproxy.cfg"
PROGRAM = shutil.which("haproxy", path=os.environ["PATH"] + ":/usr/sbin")  # None: HAProxy is not installed.


def free_ports(count):
    probes = [socket.socket() for _ in range(count)]
    try:
        for probe in probes:
            probe.bind(("127.0.0.1", 0))
        return [probe.getsockname()[1] for probe in probes]
    finally:
        for probe in probes:
            probe.close()


class Balancer:
    """`ports` of three servers. `with Balancer(ports) as balancer:` passes requests on; balancer.url, balancer.stats_url."""

    def __init__(self, ports):
        front, stats = free_ports(2)
        self.url, self.stats_url = f"http://127.0.0.1:{front}", f"http://127.0.0.1:{stats}"
        self.environment = {"LISTEN": f"127.0.0.1:{front}", "STATS": f"127.0.0.1:{stats}",
                            **{f"REPLICA{number}": f"127.0.0.1:{port}" for number, port in enumerate(ports, 1)}}

    def check(self):
        """What `haproxy -c` says of the configuration; empty if all is good."""
        done = subprocess.run([PROGRAM, "-c", "-f", CONFIGURATION], env=self.environment, capture_output=True, text=True, check=False)
        return "".join(line for line in done.stderr.splitlines(keepends=True) if "[NOTICE]" not in line)

    def __enter__(self):
        self.process = subprocess.Popen([PROGRAM, "-q", "-db", "-f", CONFIGURATION], env=self.environment)
        end = time.monotonic() + PATIENCE
        while True:
            try:
                urllib.request.urlopen(self.url + "/readyz", timeout=PATIENCE).close()
                return self
            except urllib.error.HTTPError:
                pass
            except OSError:
                assert self.process.poll() is None, "HAProxy ended"
            if time.monotonic() > end:
                self.__exit__()
                raise AssertionError("HAProxy has no ready server")
            time.sleep(0.05)

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
