"""What the system says of a server's process."""

from pathlib import Path


def status_bytes(server, key):
    for line in Path(f"/proc/{server.process.pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024
    raise AssertionError(f"no {key}")


def forget_peak(server):
    """VmHWM is from now on the most of what comes."""
    Path(f"/proc/{server.process.pid}/clear_refs").write_text("5", encoding="ascii")


def is_sanitized(server):
    """AddressSanitizer and ThreadSanitizer reserve terabytes of addresses, and keep what is freed."""
    return status_bytes(server, "VmSize") > 1 << 40


def spent_by_threads(server):
    """{thread: nanoseconds on a processor}; None where the system does not count them."""
    spent = {}
    for thread in Path(f"/proc/{server.process.pid}/task").iterdir():
        try:
            spent[thread.name] = int((thread / "schedstat").read_text(encoding="ascii").split()[0])
        except FileNotFoundError:  # The thread has ended, or no thread has this file.
            continue
    return spent if any(spent.values()) else None
