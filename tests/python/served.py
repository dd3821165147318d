"""A real `isostrata serve`, started and ended with the tests that use it."""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

BIN = Path(os.environ.get("ISOSTRATA_BIN_DIR", Path(__file__).resolve().parents[2] / "build" / "release" / "bin"))


class Served:
    def __init__(self, *data: str, folder: Path | None = None) -> None:
        self.folder = folder or Path(tempfile.mkdtemp(prefix="isostrata-python-"))
        self.arguments = data
        self._start("0")

    def _start(self, port: str) -> None:
        ready = self.folder / "ready.json"
        ready.unlink(missing_ok=True)
        # A test leaves nothing behind.
        keep = () if "--state-dir" in self.arguments else ("--state-dir", "none")
        with open(self.folder / "log", "wb") as log:
            self.process = subprocess.Popen(
                [BIN / "isostrata", "serve", *self.arguments, *keep, "--port", port, "--ready-file", ready], stdout=log, stderr=log
            )
        end = time.monotonic() + 60
        while not ready.exists():
            if self.process.poll() is not None or time.monotonic() > end:
                raise RuntimeError(f"isostrata serve does not start:\n{(self.folder / 'log').read_text()}")
            time.sleep(0.02)
        announced = json.loads(ready.read_text())
        self.url, self.port = announced["url"], str(announced["port"])

    def restart(self, number: int = signal.SIGKILL) -> None:
        """Ends it and starts it again on the same port; what it is to know again, --token-file and --state-dir say."""
        self.stop(number)
        self._start(self.port)

    def stop(self, number: int = signal.SIGTERM) -> None:
        if self.process.poll() is None:
            self.process.send_signal(number)
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()

    def close(self) -> None:
        self.stop()
        shutil.rmtree(self.folder, ignore_errors=True)
