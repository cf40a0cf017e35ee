"""Which files a server process opens, by strace."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

# `12 openat(AT_FDCWD, "/etc/passwd", O_RDONLY) = 3`, refused ones included.
CALL = re.compile(r'(?:open|creat|openat|openat2)\((?:(?:AT_FDCWD|[0-9]+)(?:<[^>]*>)?)?,? ?"((?:[^"\\]|\\.)*)"')


def why_not():
    """Empty where processes can be traced."""
    if not shutil.which("strace"):
        return "strace is not installed"
    done = subprocess.run(["strace", "-D", "-o", "/dev/null", "true"], capture_output=True, text=True, check=False)
    return "" if done.returncode == 0 else "ptrace is not permitted: " + done.stderr.strip().splitlines()[-1]


class OpenedFiles:
    """`Server(..., prefix=opened.prefix)`, and later `opened.paths()`."""

    def __init__(self, test):
        folder = tempfile.TemporaryDirectory()
        test.addCleanup(folder.cleanup)
        self.log = Path(folder.name, "strace")
        # -D: the server is our child, strace its grandchild, so that signals and /proc find the server.
        self.prefix = ["strace", "-D", "-f", "-qq", "-y", "-s", "4096", "--seccomp-bpf", "-o", str(self.log),
                       "-e", "trace=open,openat,openat2,creat"]

    def opened(self):
        """Where the files really lie that were opened, however they were named."""
        text = self.log.read_text(encoding="utf-8", errors="replace") if self.log.exists() else ""
        return set(re.findall(r"= [0-9]+<([^>]*)>$", text, re.MULTILINE))

    def paths(self):
        """All that were asked for, also those that could not be opened."""
        text = self.log.read_text(encoding="utf-8", errors="replace") if self.log.exists() else ""
        return {found.group(1) for found in CALL.finditer(text)}
