"""Three servers behind one address, by a real HAProxy with deploy/haproxy.cfg: every session stays with its server, and one that is killed takes nobody else's
with it."""

import os
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.error
import urllib.request
from collections import Counter
from pathlib import Path

import isostrata
from served import Served

CONFIG = Path(__file__).resolve().parents[2] / "deploy" / "haproxy.cfg"


class NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *arguments):
        return None


class Affinity(unittest.TestCase):
    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="isostrata-affinity-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        (self.folder / "token").write_text("one-token-for-all-of-them\n")
        self.servers = []
        environment = dict(os.environ)
        for number in (1, 2, 3):
            own = self.folder / f"files-{number}"
            own.mkdir()
            server = Served(
                "torus:12", "--base-url", f"/{number}/", "--token-file", str(self.folder / "token"),
                "--state-dir", str(self.folder / "shared" / str(number)), "--threads", "1", folder=own,
            )  # fmt: skip
            self.addCleanup(server.close)
            self.servers.append(server)
            environment[f"ISOSTRATA_{number}"] = f"127.0.0.1:{server.port}"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"127.0.0.1:{free.getsockname()[1]}"
        environment["ISOSTRATA_BIND"] = self.address
        proxy = subprocess.Popen(["/usr/sbin/haproxy", "-db", "-f", CONFIG], env=environment, stderr=subprocess.DEVNULL)
        self.addCleanup(proxy.wait)
        self.addCleanup(proxy.terminate)
        self.until_answered("/1/healthz")

    def until_answered(self, path):
        end = time.monotonic() + 30
        while True:
            try:
                return urllib.request.urlopen(f"http://{self.address}{path}", timeout=5).read()
            except OSError:
                self.assertLess(time.monotonic(), end, f"nobody answers at {path}")
                time.sleep(0.05)

    def until_kept(self, number, text):
        """What the server keeps is written by a thread of its own."""
        end = time.monotonic() + 30
        while not any(text in file.read_bytes() for file in (self.folder / "shared" / str(number)).rglob("*.journal")):
            self.assertLess(time.monotonic(), end, f"the journal of server {number} does not have {text}")
            time.sleep(0.01)

    def test_who_comes_without_a_path_gets_one_with_the_token(self):
        opener = urllib.request.build_opener(NoRedirect)
        places = Counter()
        for _ in range(60):
            with self.assertRaises(urllib.error.HTTPError) as caught:
                opener.open(f"http://{self.address}/?token=one-token-for-all-of-them", timeout=5)
            self.assertEqual(caught.exception.code, 303)
            places[caught.exception.headers["Location"]] += 1
            caught.exception.close()
        self.assertEqual(set(places), {f"/{n}/?token=one-token-for-all-of-them" for n in (1, 2, 3)})  # by chance not: 1 in 10 milliards

    def test_a_server_that_is_killed_takes_no_session_of_another_and_comes_back_with_its_own(self):
        sessions, events = [], {}
        for i in range(24):
            events[i] = []
            session = isostrata.connect(
                f"http://{self.address}/{i % 3 + 1}/?token=one-token-for-all-of-them", "torus:12", size=(32, 24),
                on_connection=lambda event, heard=events[i]: heard.append(event),
            )  # fmt: skip
            self.addCleanup(session.close)
            session.intervals.set([isostrata.Interval(0.1, 0.2 + 0.01 * i, name=f"of-session-{i}-")])
            sessions.append(session)
        ids = [session.id for session in sessions]
        self.assertEqual(len(set(ids)), 24)
        for i in range(1, 24, 3):
            self.until_kept(2, f"of-session-{i}-".encode())

        began = time.monotonic()
        self.servers[1].stop(signal.SIGKILL)
        restarted = threading.Thread(target=self.servers[1].restart)
        restarted.start()
        for i, session in enumerate(sessions):  # the killed server's as well: their commands wait
            first = session.intervals[0]
            self.assertEqual(session.intervals.move(first, 0.15, first.upper).lower, 0.15)
        print(f"killed, started again, and every session moved: {time.monotonic() - began:.1f} s")
        restarted.join()

        for i, session in enumerate(sessions):
            self.assertEqual([interval.name for interval in session.intervals], [f"of-session-{i}-"])
            self.assertEqual(session.intervals[0].upper, 0.2 + 0.01 * i)
            self.assertEqual(session.id, ids[i])
            self.assertEqual([event.kind for event in events[i]], ["lost", "restored"] if i % 3 == 1 else [], f"session {i}")


if __name__ == "__main__":
    unittest.main()
