#!/usr/bin/env python3
"""Counts the instructions that the server executes for one one-ray JSON request.

Usage: request_instructions.py BINARY [BINARY...] [--functions]

Runs each server under valgrind --tool=callgrind, sends keep-alive requests on one connection, starts
counting after a warm-up, and divides the count at the end by the number of requests. Prints one
line for each binary: instructions per request, and the ratio to the first binary. The count does not
depend on other load.
"""

import re
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# An ordinary ray: exact arithmetic for a ray through an edge would hide the server's own work.
BODY = b'{"rays":[{"origin":[3.37,200,5.21],"direction":[0.01,-1,0.02]}]}'
REQUEST = (b"POST /v1/scenes/town/rays:closest HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
           b"Content-Length: %d\r\n\r\n" % len(BODY)) + BODY
WARM_UP, COUNTED = 300, 2000


def ask(connection, count):
    """Sends `count` requests one after the other and checks each answer's status."""
    pending = b""
    for _ in range(count):
        connection.sendall(REQUEST)
        while True:
            head, end, rest = pending.partition(b"\r\n\r\n")
            if end:
                length = int(re.search(rb"(?i)content-length: (\d+)", head).group(1))
                if len(rest) >= length:
                    if not head.startswith(b"HTTP/1.1 200"):
                        raise SystemExit(f"the server answered {head[:60]!r}")
                    pending = rest[length:]
                    break
            pending += connection.recv(65536)


def control(option, server):
    """One command to the running callgrind: --instr=on starts to count, -d writes the counts."""
    subprocess.run(["callgrind_control", option, str(server.pid)], check=True, stdout=subprocess.DEVNULL)


def wait_until_idle(pid):
    """Returns when the process has used no processor for two seconds, however slow the machine is."""
    used = None
    while True:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        now = int(fields[11]) + int(fields[12])
        if used is not None and now - used <= 2:
            return
        used = now
        time.sleep(2)


def per_request(binary, folder):
    """Instructions of one request."""
    output = Path(folder) / "callgrind.out"
    server = subprocess.Popen(
        ["valgrind", "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={output}", binary, "serve",
         "--listen", "127.0.0.1:0", "--preload", "town=demo:town", "--threads", "1"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        port = int(server.stdout.readline().rsplit(":", 1)[1])
        while True:
            with socket.create_connection(("127.0.0.1", port)) as probe:
                probe.sendall(b"GET /readyz HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n")
                if probe.recv(65536).startswith(b"HTTP/1.1 200"):
                    break
            time.sleep(0.2)
        wait_until_idle(server.pid)  # trees are built in the background
        with socket.create_connection(("127.0.0.1", port)) as connection:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            ask(connection, WARM_UP)
            control("--instr=on", server)
            ask(connection, COUNTED)
            control("-d", server)
    finally:
        server.terminate()
        server.wait(timeout=120)
    dump = max(Path(folder).glob("callgrind.out.*"), key=lambda path: path.stat().st_size)
    if len(sys.argv) > 2 and sys.argv[-1] == "--functions":
        subprocess.run(["callgrind_annotate", str(dump)], check=False)
    return int(re.search(r"^totals: (\d+)", dump.read_text(), re.MULTILINE).group(1)) / COUNTED


def main():
    first = None
    for binary in [argument for argument in sys.argv[1:] if argument != "--functions"]:
        with tempfile.TemporaryDirectory() as folder:
            count = per_request(binary, folder)
        first = first or count
        print(f"{binary}: {count:,.0f} instructions per request, {count / first:.2f} of the first")


if __name__ == "__main__":
    sys.exit(main() if len(sys.argv) > 1 else __doc__)
