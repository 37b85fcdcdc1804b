"""A browser without a window, driven by the WebDriver protocol of its own driver, without other packages."""

import base64
import json
import re
import shutil
import subprocess
import tempfile
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

QUIET = (
    "no-sandbox",
    "disable-gpu",
    "no-first-run",
    "disable-background-networking",
    "disable-component-update",
)
CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
CHROMEDRIVER = shutil.which("chromedriver")
MISSING = "no chromium with chromedriver: apt-get install chromium chromium-driver"


class Browser:
    """A page in a browser: what it logs, what scripts say about it, and what it looks like."""

    def __init__(self, port):
        self.address = f"http://127.0.0.1:{port}/session"
        folder = tempfile.mkdtemp()
        arguments = ["headless=new", f"user-data-dir={folder}", *QUIET]
        options = {"binary": CHROMIUM, "args": [f"--{name}" for name in arguments]}
        wanted = {"goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}
        opened = self._ask("", {"capabilities": {"alwaysMatch": wanted}})
        self.address += f"/{opened['sessionId']}"
        self.folder, self.shown = folder, None
        self._ask("/timeouts", {"script": 100_000, "pageLoad": 100_000})

    def _ask(self, path, content=None, method=None):
        body = None if content is None else json.dumps(content).encode()
        request = urllib.request.Request(
            self.address + path, body, {"Content-Type": "application/json"}, method=method
        )
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def show(self, path, width=1280):
        """Show a file unless it is open, for tests that do not mind what others have done to the page."""
        if self.shown != (path, width):
            self.open(path, width)

    def open(self, path, width=1280, height=1000):
        """Open a file in a window of this size (pixels)."""
        self.shown = path, width
        self._ask("/window/rect", {"width": width, "height": height})
        address = Path(path).absolute().as_uri()
        self._ask("/url", {"url": address})
        # on a busy machine the answer may come before the page
        for _ in range(600):
            if self.run("return [document.readyState, location.href.split('#')[0]];") == [
                "complete",
                address,
            ]:
                return
            time.sleep(0.1)
        raise TimeoutError(address)

    def run(self, script, *arguments):
        """Value that a script returns, also by a promise."""
        wrapped = (
            "const done = arguments[arguments.length - 1]; const own = [...arguments].slice(0, -1);"
            f"(async (...given) => {{ {script} }})(...own).then(done, (error) => done(String(error)));"
        )
        return self._ask("/execute/async", {"script": wrapped, "args": list(arguments)})

    def log(self):
        """Messages of the page since the last call: errors of scripts, files that are missing."""
        return [entry["message"] for entry in self._ask("/se/log", {"type": "browser"})]

    def picture(self, path):
        """Write what the window shows as PNG."""
        Path(path).write_bytes(base64.b64decode(self._ask("/screenshot")))

    def close(self):
        self._ask("", method="DELETE")
        shutil.rmtree(self.folder, ignore_errors=True)


@contextmanager
def browser():
    """A browser, closed at the end."""
    driver = subprocess.Popen([CHROMEDRIVER, "--port=0"], stdout=subprocess.PIPE, text=True)
    try:
        port = next(filter(None, (re.search(r"on port (\d+)\.", line) for line in driver.stdout)))[1]
        page = Browser(port)
        try:
            yield page
        finally:
            page.close()
    finally:
        driver.terminate()
        driver.wait()
