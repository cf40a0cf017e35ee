"""A sightline server process for a test, and curl to ask it."""

import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

BINARY = sys.argv[1] if len(sys.argv) > 1 else "build/dev/sightline"
SOURCE = Path(os.environ.get("SIGHTLINE_SOURCE") or Path(__file__).resolve().parents[2])
DATA = Path(os.environ.get("SIGHTLINE_DATA") or SOURCE.parent / "shared/data")
# Nothing here depends on how fast the machine is: this only ends what hangs.
PATIENCE = 120

JSON_TYPE = "Content-Type: application/json"
GLB_TYPE = "Content-Type: model/gltf-binary"


class Answer:
    def __init__(self, status, headers, body):
        self.status = status
        self.headers = headers  # lower-case names
        self.body = body

    def json(self):
        return json.loads(self.body)


def parse_heads(text):
    """Status and headers of the last answer in curl's header dump (100 Continue comes first)."""
    blocks = [block for block in text.replace("\r\n", "\n").split("\n\n") if block.strip()]
    lines = blocks[-1].splitlines()
    headers = {}
    for line in lines[1:]:
        name, _, value = line.partition(":")
        headers[name.strip().lower()] = value.strip()
    return int(lines[0].split()[1]), headers


def curl(url, *arguments, body=None):
    """Runs curl; `body` is bytes or text, sent as it is."""
    with tempfile.TemporaryDirectory() as folder:
        heads, out, sent = Path(folder, "heads"), Path(folder, "body"), Path(folder, "sent")
        command = ["curl", "-sS", "--globoff", "--max-time", str(PATIENCE), "-D", heads, "-o", out]
        if body is not None:
            sent.write_bytes(body.encode() if isinstance(body, str) else body)
            command += ["--data-binary", f"@{sent}"]
        done = subprocess.run([*command, *arguments, url], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise AssertionError(f"curl {url}: {done.stderr.strip()}")
        status, headers = parse_heads(heads.read_text(encoding="latin-1"))
        return Answer(status, headers, out.read_bytes() if out.exists() else b"")


class Server:
    """`with Server("--preload", "six=demo:six") as server:` is ready, and ended by its own pid."""

    def __init__(self, *arguments, wait=True, prefix=(), memory=56 << 20):
        """`prefix` runs the server's command line in its own process: "strace -D", not "strace".

        `memory` is small, so that tests reach limits on any machine; None: the server's own default.
        """
        if memory is not None and "--memory" not in arguments:
            arguments = ("--memory", memory, *arguments)
        level = () if "--log-level" in arguments else ("--log-level", "debug")
        self.log = tempfile.TemporaryFile()
        self.process = subprocess.Popen([*map(str, prefix), BINARY, "serve", "--listen", "127.0.0.1:0", *level,
                                         *map(str, arguments)], stdout=subprocess.PIPE, stderr=self.log, text=True)
        first = self.process.stdout.readline()
        if not first.startswith("listening on http://127.0.0.1:"):
            self.end()
            raise AssertionError(f"first line {first!r}; {self.log_text()}")
        self.url = first.split()[-1]
        self.port = int(self.url.rsplit(":", 1)[1])
        if wait:
            try:
                self.wait_ready()
            except BaseException:
                self.end()
                raise

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.end()

    def wait_ready(self):
        end = time.monotonic() + PATIENCE
        try:
            while curl(self.url + "/readyz").status != 200:
                if time.monotonic() > end or self.process.poll() is not None:
                    raise AssertionError("it takes too long")
        except AssertionError as fault:
            raise AssertionError(f"the server did not become ready: {fault}; exit code {self.process.poll()}; "
                                 f"its log: {self.log_text()}") from fault

    def log_text(self):
        # The server shares this file's position: it stays where it is.
        file = self.log.fileno()
        return os.pread(file, os.fstat(file).st_size, 0).decode("utf-8", "replace")

    def signal(self, number=signal.SIGTERM):
        self.process.send_signal(number)

    def wait(self):
        return self.process.wait(timeout=PATIENCE)

    def stop(self):
        """SIGTERM; returns the exit code."""
        self.signal()
        return self.wait()

    def kill(self):
        self.process.kill()
        return self.wait()

    def end(self):
        """Whatever happened, nothing stays behind."""
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(timeout=PATIENCE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.process.stdout.close()

    def ask(self, path, *arguments, **options):
        return curl(self.url + path, *arguments, **options)

    def metric(self, name):
        """The value of a metric without labels."""
        return int(re.search(f"^{name} ([0-9]+)$", self.ask("/metrics").body.decode(), re.MULTILINE)[1])

    def traffic(self):
        """Bytes of memory that connections and requests hold."""
        return self.metric("sightline_traffic_bytes")

    def spooled(self):
        """Bytes of temporary files that bodies and answers hold."""
        return self.metric("sightline_spool_bytes")

    def put(self, scene, body, *arguments):
        return self.ask(f"/v1/scenes/{scene}", "-X", "PUT", "-H", GLB_TYPE, *arguments, body=body)

    def query(self, scene, kind, body, *arguments):
        if not isinstance(body, (str, bytes)):
            body = json.dumps(body)
        return self.ask(f"/v1/scenes/{scene}/rays:{kind}", "-H", JSON_TYPE, *arguments, body=body)

    def closest(self, scene, *rays, fields=None):
        """The hits of rays given as (origin, direction)."""
        body = {"rays": [{"origin": origin, "direction": direction} for origin, direction in rays]}
        if fields:
            body["fields"] = fields
        answer = self.query(scene, "closest", body)
        if answer.status != 200:
            raise AssertionError(f"{answer.status} {answer.body}")
        return answer.json()["hits"]

    def connect(self):
        connection = socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE)
        return connection

    def exchange(self, *pieces):
        """Sends all pieces at once and returns all answers until the connection ends."""
        connection = self.connect()
        with connection, connection.makefile("rwb") as stream:
            stream.write(b"".join(pieces))
            stream.flush()
            answers = []
            while (answer := read_answer(stream)) is not None:
                answers.append(answer)
            return answers


def read_answer(stream):
    """The next HTTP answer on a binary stream of a socket (with Content-Length, or without body);
    None at its end."""
    line = stream.readline()
    if not line:
        return None
    status, headers = int(line.split()[1]), {}
    while (line := stream.readline().strip()):
        name, _, value = line.decode("latin-1").partition(":")
        headers[name.lower()] = value.strip()
    return Answer(status, headers, stream.read(int(headers.get("content-length", 0))))


def shared_scene(test, name):
    """The bytes of a scene of the shared data; `test` is skipped where there is none."""
    path = DATA / "scenes" / name
    if not path.exists():
        test.skipTest(f"there is no {path}")
    return path.read_bytes()


def demo_glb(name):
    """The bytes of a demo scene, by the program itself."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "demo.glb")
        subprocess.run([BINARY, "demo", name, file], check=True, timeout=PATIENCE)
        return file.read_bytes()


def with_document(glb, change):
    """The GLB after change(its JSON)."""
    length, = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20:20 + length])
    change(document)
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = glb[20 + length:]
    return glb[:8] + struct.pack("<III", 20 + len(text) + len(rest), len(text), 0x4E4F534A) + text + rest


def make_key(role, name):
    """(key, line for the file), by the program itself."""
    done = subprocess.run([BINARY, "key", "new", "--role", role, "--name", name], capture_output=True, text=True, check=True,
                          timeout=PATIENCE)
    key, line = done.stdout.splitlines()
    return key.removeprefix("key: "), line.removeprefix("line: ")


def write_keys(file, *lines):
    """As --keys wants its file: nobody else may read it."""
    file.write_text("".join(f"{line}\n" for line in lines), encoding="ascii")
    file.chmod(0o600)
    return file


def bearer(key):
    return "-H", f"Authorization: Bearer {key}"
