"""The package when its connection is lost, and over https: before a real server that is killed and started again."""

import shutil
import signal
import ssl
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import isostrata
from isostrata import Interval, IsostrataError, v1
from isostrata.sent import Sent

from served import Served


class WithState(unittest.TestCase):
    more = ()

    def setUp(self):
        self.folder = Path(tempfile.mkdtemp(prefix="isostrata-python-"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        (self.folder / "token").write_text("the-same-token-in-every-life\n")
        keep = ("--token-file", str(self.folder / "token"), "--state-dir", str(self.folder / "state"))
        self.server = Served("torus:12", *keep, *self.more_arguments(), folder=self.folder)
        self.addCleanup(self.server.close)
        self.events = []

    def more_arguments(self):
        return ()

    def connect(self, dataset="torus:12", url="", **options):
        options.setdefault("size", (64, 48))
        session = isostrata.connect(url or self.server.url, dataset, on_connection=self.events.append, **options)
        self.addCleanup(session.close)
        return session

    def wait_until_kept(self, text):
        """What the server keeps is written by a thread of its own; a kill before that would be another test."""
        end = time.monotonic() + 30
        while not any(text in file.read_bytes() for file in (self.folder / "state").rglob("*.journal")):
            self.assertLess(time.monotonic(), end, f"the journal does not have {text}")
            time.sleep(0.01)

    def kinds(self):
        return [event.kind for event in self.events]

    def assertRefused(self, code, call, *arguments, **named):
        with self.assertRaises(IsostrataError) as caught:
            call(*arguments, **named)
        self.assertEqual(caught.exception.code, code, str(caught.exception))


class Lost(WithState):
    def test_a_client_goes_on_while_the_server_is_killed_and_started_again(self):
        s = self.connect()
        s.intervals.set([(0.1, 0.2), Interval(0.3, 0.4, name="the-second")])
        session, first = s.id, s.intervals[0]
        killer = threading.Thread(target=lambda: (self.wait_until_kept(b"the-second"), self.server.restart()))
        killer.start()
        after = moves = 0
        while after < 20:
            lower = 0.05 + 0.0001 * (moves % 100)
            self.assertEqual(s.intervals.move(first, lower, 0.25).lower, lower)
            after += "restored" in self.kinds()
            moves += 1
        killer.join()
        self.assertEqual(self.kinds(), ["lost", "restored"])
        self.assertEqual((s.id, s.intervals[1].upper, s.info.id), (session, 0.4, "torus-12"))
        other = self.connect("", session=session)
        self.assertEqual(other.intervals[0], s.intervals[0])
        np.testing.assert_array_equal(other.image(), s.image())

    def test_what_the_server_did_not_hear_is_sent_again_in_its_order(self):
        s = self.connect()
        first = s.intervals[0].id
        self.wait_until_kept(b"torus-12")
        self.server.stop(signal.SIGKILL)
        for i in range(1, 31):
            s._connection.send(v1.ClientMessage(patch_interval=v1.PatchInterval(id=first, upper=0.5 + 0.001 * i)))
        self.server.restart()
        s.wait(lambda session: session.intervals[0].upper == 0.53)
        self.assertGreaterEqual(self.events[-1].resent, 30)

    def test_pictures_and_questions_wait_for_the_server(self):
        s = self.connect()
        before, counts = s.image(), s.histogram(bins=8).counts
        self.wait_until_kept(b"torus-12")
        self.server.stop(signal.SIGKILL)
        again = threading.Thread(target=self.server.restart)
        again.start()
        np.testing.assert_array_equal(s.image(), before)
        np.testing.assert_array_equal(s.histogram(bins=8).counts, counts)
        again.join()

    def test_a_server_without_memory_is_told_what_was_shown(self):
        s = self.connect()
        s.intervals.set([Interval(0.1, 0.2, color="#ff8000", name="kept")])
        joined = self.connect("", session=s.id)
        before, session = s.image(), s.id
        self.server.stop(signal.SIGKILL)
        shutil.rmtree(self.folder / "state")
        self.server.restart()
        s.annotate()
        self.assertEqual([i.name for i in s.intervals], ["kept"])
        np.testing.assert_array_equal(s.image(), before)
        self.assertNotEqual(s.id, session)
        self.assertTrue(any(event.new_session for event in self.events))
        self.assertRefused("session_lost", joined.view, "+x")
        self.assertRefused("session_lost", joined.view, "+x")

    def test_nobody_there_is_an_error_after_the_time_that_was_given(self):
        s = self.connect(reconnect=0.3)
        self.server.stop(signal.SIGKILL)
        self.assertRefused("closed", s.view, "+x")
        self.assertEqual(self.kinds(), ["lost", "given_up"])
        self.assertIn("could not be made again", self.events[-1].reason)
        self.assertRefused("closed", s.view, "+x")

    def test_what_ends_for_good_is_not_asked_again(self):
        s = self.connect(reconnect=3600)
        s.rest.request("DELETE", f"sessions/{s.id}")
        self.assertRefused("closed", s.view, "+x")
        other = self.connect(reconnect=3600)
        (self.folder / "token").write_text("another-token-than-before\n")
        self.server.restart()
        self.assertRefused("unauthorized", other.view, "+x")

    def test_a_session_can_be_closed_while_it_is_lost(self):
        s = self.connect(reconnect=3600)
        self.server.stop(signal.SIGKILL)
        end = time.monotonic() + 30
        while "lost" not in self.kinds() and time.monotonic() < end:
            time.sleep(0.01)
        s.close()
        self.assertRefused("closed", s.view, "+x")

    def test_a_session_can_be_closed_at_each_moment_of_a_try_to_connect(self):
        sessions = []

        def close(turn, turns):
            """So many turns of its loop after the loss: among the first are all the steps of a try that is refused."""
            loop = sessions[turn]._connection.line.loop
            loop.call_soon(close, turn, turns - 1) if turns else sessions[turn].close()

        for turn in range(24):
            lost = lambda event, turn=turn: event.kind == "lost" and close(turn, turn)  # noqa: E731
            sessions.append(isostrata.connect(self.server.url, "torus:12", size=(8, 8), reconnect=3600, on_connection=lost))
        self.server.stop(signal.SIGKILL)
        for s in sessions:
            s._connection.line.thread.join(10)
            self.assertFalse(s._connection.line.thread.is_alive())
            self.assertRefused("closed", s.view, "+x")


class Kept(unittest.TestCase):
    """What a client keeps of its commands for the case of a loss."""

    def commands(self, sent, count):
        return [sent.note(v1.ClientMessage(patch_interval=v1.PatchInterval(name="x" * 100_000))) for _ in range(count)]

    def test_of_those_that_were_done_only_so_many_bytes(self):
        sent = Sent()
        for number in self.commands(sent, 200):
            sent.judged(number)
        self.commands(sent, 1)
        again, _ = sent.again(0, True, True)
        self.assertTrue(3 << 20 < sum(map(len, again)) <= (4 << 20) + 200_000, len(again))

    def test_of_those_that_were_not_all(self):
        sent = Sent()
        numbers = self.commands(sent, 60)
        sent.judged(numbers[9])
        again, _ = sent.again(10, True, False)
        self.assertEqual([v1.ClientMessage.FromString(data).command for data in again], numbers[10:])


class Tls(WithState):
    def more_arguments(self):
        self.certificate = self.folder / "certificate.pem"
        subject = ["-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"]
        subprocess.run(
            ["openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-days", "2", "-keyout", self.folder / "key.pem",
             "-out", self.certificate, *subject],
            check=True, capture_output=True,
        )  # fmt: skip
        return ("--tls-cert", str(self.certificate), "--tls-key", str(self.folder / "key.pem"))

    def test_a_self_signed_certificate_is_trusted_where_it_is_named(self):
        self.assertTrue(self.server.url.startswith("https://"))
        by_name = self.server.url.replace("127.0.0.1", "localhost")
        s = self.connect(url=by_name, ca_file=str(self.certificate))
        s.intervals.set([(0.1, 0.3)])
        self.assertEqual(s.image().shape, (48, 64, 3))
        context = ssl.create_default_context(cafile=str(self.certificate))
        self.assertIn(s.id, [each["id"] for each in isostrata.sessions(by_name, ssl_context=context)])
        self.assertTrue(self.connect(insecure=True).image().any())
        self.wait_until_kept(b"torus-12")
        self.server.restart()
        s.intervals.set([(0.2, 0.4)])
        self.assertEqual(s.image().shape, (48, 64, 3))

    def test_what_is_not_trusted_is_refused(self):
        by_name = self.server.url.replace("127.0.0.1", "localhost")
        self.assertRefused("tls", isostrata.connect, by_name)
        self.assertRefused("tls", isostrata.sessions, by_name)
        self.assertRefused("tls", isostrata.connect, self.server.url, ca_file=str(self.certificate))
        self.assertRefused("invalid_argument", isostrata.connect, by_name, ca_file=str(self.folder / "nosuch.pem"))


if __name__ == "__main__":
    unittest.main()
