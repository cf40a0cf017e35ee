"""The browser of the page's tests, and why there is none."""

import shutil
import subprocess
import tempfile

from sightline_server import PATIENCE

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]


def started(browser):
    """Whether it shows an empty document: a container may forbid what it needs."""
    with tempfile.TemporaryDirectory() as profile:
        try:
            done = subprocess.run([browser, *FLAGS, f"--user-data-dir={profile}", "--dump-dom", "about:blank"], capture_output=True,
                                  timeout=PATIENCE, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return False
    return done.returncode == 0 and b"<html>" in done.stdout


FOUND = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
BROWSER = FOUND if FOUND and started(FOUND) else None
MISSING = "" if BROWSER else "no chromium is installed" if FOUND is None else f"{FOUND} does not start here"
