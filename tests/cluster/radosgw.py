"""Ceph's radosgw, a real S3, in a folder of its own: one monitor, one disk in memory, one gateway.

Needs Debian's radosgw, ceph-mon, ceph-osd, ceph-common and curl. Nothing runs as a service; stop() ends what start() began.
`radosgw.py [--listen ADDRESS:PORT]` runs one until SIGTERM, as the container of docker/store does.
"""

import argparse
import json
import os
import signal
import socket
import subprocess
import tempfile
import time
import uuid
from pathlib import Path

CONF = """[global]
fsid = {fsid}
mon host = [v1:127.0.0.1:{mon}]
public addr = 127.0.0.1
cluster addr = 127.0.0.1
auth cluster required = cephx
auth service required = cephx
auth client required = cephx
keyring = {folder}/keyring
admin socket = {folder}/$name.asok
pid file = {folder}/$name.pid
log file = {folder}/$name.log
osd pool default size = 1
osd pool default min size = 1
osd pool default pg num = 1
osd pool default pgp num = 1
osd pool default pg autoscale mode = off
mon allow pool size one = true
mon data avail warn = 1
mon data avail crit = 1
osd crush chooseleaf type = 0
ms bind port min = {low}
ms bind port max = {high}
ms bind msgr2 = false
mon data = {folder}/mon
osd data = {folder}/osd
osd objectstore = memstore
memstore device bytes = 4294967296
[client.rgw]
rgw frontends = beast endpoint={listen}:{rgw}
rgw data = {folder}/rgw
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Radosgw:
    def __init__(self, folder, listen="127.0.0.1", port=None):
        self.folder = Path(folder)
        self.port, mon = port or free_port(), free_port()
        for name in ("mon", "osd", "rgw"):
            (self.folder / name).mkdir(parents=True)
        fsid = str(uuid.uuid4())
        self.conf = self.folder / "ceph.conf"
        self.conf.write_text(CONF.format(fsid=fsid, folder=self.folder, mon=mon, listen=listen, rgw=self.port, low=20000 + os.getpid() % 10000,
                                         high=20100 + os.getpid() % 10000), encoding="ascii")
        self.run("ceph-authtool", "--create-keyring", "keyring", "--gen-key", "-n", "mon.", "--cap", "mon", "allow *")
        for name, capabilities in (("client.admin", ("mon", "allow *", "osd", "allow *", "mgr", "allow *")),
                                   ("client.rgw", ("mon", "allow rwx", "osd", "allow rwx"))):
            pairs = [word for i in range(0, len(capabilities), 2) for word in ("--cap", *capabilities[i:i + 2])]
            self.run("ceph-authtool", "keyring", "--gen-key", "-n", name, *pairs)
        self.run("monmaptool", "--create", "--addv", "a", f"[v1:127.0.0.1:{mon}]", "--fsid", fsid, "monmap")
        self.run("ceph-mon", "-c", self.conf, "--mkfs", "-i", "a", "--monmap", "monmap", "--keyring", "keyring")
        self.processes = [self.begin("ceph-mon", "-i", "a")]
        self.run("ceph", "-c", self.conf, "--connect-timeout", "30", "auth", "import", "-i", "keyring")
        disk, secret = str(uuid.uuid4()), self.run("ceph-authtool", "--gen-print-key").strip()
        number = self.run("ceph", "-c", self.conf, "osd", "new", disk, "-i", "-", text=json.dumps({"cephx_secret": secret})).strip()
        self.run("ceph-authtool", "--create-keyring", "osd/keyring", "--name", f"osd.{number}", "--add-key", secret)
        self.run("ceph-osd", "-c", self.conf, "-i", number, "--mkfs", "--osd-uuid", disk, "--keyring", "osd/keyring")
        self.processes.append(self.begin("ceph-osd", "-i", number, "--keyring", "osd/keyring"))
        self.gateway = None
        self.start_gateway()
        self.run("radosgw-admin", "-c", self.conf, "-n", "client.admin", "user", "create", "--uid=t", "--display-name=t", "--access-key=tester",
                 "--secret-key=secret")
        self.run("curl", "-fsS", "--retry", "20", "--retry-all-errors", "-X", "PUT", "-H", "x-amz-content-sha256: UNSIGNED-PAYLOAD", "--aws-sigv4",
                 "aws:amz:us-east-1:s3", "--user", "tester:secret", f"{self.endpoint}/scenes")

    def run(self, *command, text=None):
        done = subprocess.run([*map(str, command)], cwd=self.folder, input=text, capture_output=True, text=True, timeout=120, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{command[0]}: {done.stderr[-500:]}")
        return done.stdout

    def begin(self, program, *arguments):
        with open(self.folder / f"{program}.out", "ab") as out:
            return subprocess.Popen([program, "-f", "-c", str(self.conf), *map(str, arguments)], cwd=self.folder, stdout=out, stderr=out)

    def start_gateway(self):
        self.gateway = self.begin("radosgw", "-n", "client.rgw", "--keyring", "keyring")
        for _ in range(600):
            with socket.socket() as probe:
                if probe.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            time.sleep(0.1)
        raise RuntimeError("radosgw does not listen")

    def stop_gateway(self):
        self.gateway.send_signal(signal.SIGKILL)
        self.gateway.wait()

    @property
    def endpoint(self):
        return f"http://127.0.0.1:{self.port}"

    def credentials(self):
        return f"aws_access_key_id = tester\naws_secret_access_key = secret\nendpoint_url = {self.endpoint}\nregion = us-east-1\n"

    def stop(self):
        for process in [self.gateway, *reversed(self.processes)]:
            if process and process.poll() is None:
                process.kill()
                process.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--listen", default="127.0.0.1:7480", help="default: %(default)s")
    host, _, port = parser.parse_args().listen.rpartition(":")
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGINT})
    with tempfile.TemporaryDirectory() as folder:
        store = Radosgw(folder, host, int(port))
        try:
            print(f"radosgw listens on {host}:{port}; bucket: scenes", flush=True)
            signal.sigwait({signal.SIGTERM, signal.SIGINT})
        finally:
            store.stop()


if __name__ == "__main__":
    main()
