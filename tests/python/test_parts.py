"""The parts of the package that need no server, each by itself; time stands until it is moved."""

import random
import unittest

from isostrata import IsostrataError, news, questions, shown
from isostrata.outgoing import Outgoing
from isostrata.patience import Deadline, Retries
from isostrata.told import Told
from isostrata.v1 import isostrata_pb2 as v1


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


class Patience(unittest.TestCase):
    def test_a_wait_ends_when_nothing_is_new_for_so_long(self):
        clock = Clock()
        deadline = Deadline(10, "begun", clock)
        clock.now = 9
        self.assertEqual(deadline.left("begun", True), 1)
        self.assertEqual(deadline.left("progress", True), 10)
        clock.now = 18
        self.assertEqual(deadline.left("progress", True), 1)
        clock.now = 19
        self.assertLessEqual(deadline.left("progress", True), 0)

    def test_while_there_is_no_connection_the_end_does_not_come_nearer(self):
        clock = Clock()
        deadline = Deadline(10, None, clock)
        for clock.now in range(0, 1000, 9):
            self.assertEqual(deadline.left(None, False), 10)
        clock.now += 4
        self.assertEqual(deadline.left(None, True), 6)

    def test_tries_begin_at_once_double_their_pauses_and_end_in_time(self):
        clock = Clock()
        retries, pauses = Retries(10, 2, now=clock), []
        while not retries.over:
            pauses.append(retries.pause())
            clock.now += pauses[-1]
        self.assertEqual(pauses[:7], [0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6])
        self.assertEqual(pauses[7:9], [2, 2])
        self.assertAlmostEqual(sum(pauses), 10)
        self.assertEqual(Retries(10, 1, first=0.05, now=clock).pause(), 0.05)


def command(id: int) -> v1.ClientMessage:
    return v1.ClientMessage(remove_interval=v1.RemoveInterval(id=id))


def welcome(last_command: int, session: str = "s") -> v1.Welcome:
    return v1.Welcome(session=session, last_command=last_command)


class Wire:
    """What arrives of what is written; all of it, unless it is cut."""

    def __init__(self) -> None:
        self.arrived: list[v1.ClientMessage] = []

    def __call__(self, data: bytes) -> None:
        self.arrived.append(v1.ClientMessage.FromString(data))

    def kinds(self) -> list[str]:
        return [message.WhichOneof("body") for message in self.arrived]


class GoingOut(unittest.TestCase):
    def setUp(self) -> None:
        self.wire = Wire()
        self.outgoing = Outgoing(self.wire)

    def again(self, last_command: int, session: str = "s"):
        self.wire.arrived.clear()
        self.outgoing.up = False
        self.outgoing.begin(v1.Hello())
        return self.outgoing.resume(welcome(last_command, session), v1.State())

    def test_whenever_the_line_breaks_the_session_has_each_command_once_and_in_order(self):
        for seed in range(100):
            chance = random.Random(seed)
            self.wire.arrived.clear()
            outgoing = Outgoing(self.wire)
            judged, done = 0, []

            def arrive():
                nonlocal judged
                for message in self.wire.arrived:
                    if message.command > judged:
                        judged = message.command
                        done.append(message.remove_interval.id)
                self.wire.arrived.clear()

            outgoing.begin(v1.Hello())
            outgoing.resume(welcome(0), v1.State())
            for id in range(20):
                if chance.random() < 0.3:
                    if chance.random() < 0.5:
                        arrive()
                    self.wire.arrived.clear()  # the rest is lost on the way
                    outgoing.up = False
                if not outgoing.up and chance.random() < 0.5:
                    outgoing.begin(v1.Hello())
                    outgoing.resume(welcome(judged), v1.State())
                outgoing.queue(command(id))
            self.wire.arrived.clear()
            outgoing.begin(v1.Hello())
            outgoing.resume(welcome(judged), v1.State())
            arrive()
            self.assertEqual(done, list(range(20)), f"seed {seed}")

    def test_a_verdict_that_was_never_heard_comes_with_the_welcome(self):
        self.again(0)
        number = self.outgoing.queue(command(7))
        self.outgoing.up = False
        self.outgoing.begin(v1.Hello())
        late = welcome(1)
        late.last_command_error.code = "not_found"
        resent = self.outgoing.resume(late, v1.State())
        self.assertEqual((resent.count, resent.same_session), (0, True))
        self.assertEqual((resent.verdict.error.code, resent.verdict.error.in_reply_to), ("not_found", number))

    def test_answers_have_the_callers_numbers_whatever_those_on_the_wire_are(self):
        self.again(0)
        for id in range(5):
            self.outgoing.queue(command(id))
        self.again(5)
        number = self.outgoing.queue(command(9))
        refusal = v1.ServerMessage(error=v1.Error(in_reply_to=self.wire.arrived[-1].seq))
        self.assertNotEqual(refusal.error.in_reply_to, number)
        self.assertTrue(self.outgoing.heard(refusal))
        self.assertEqual(refusal.error.in_reply_to, number)

    def test_a_hand_that_is_down_is_down_on_the_next_connection_too(self):
        self.again(0)
        self.outgoing.queue(v1.ClientMessage(interaction=v1.Interaction(active=True)))
        self.again(0)
        self.assertEqual(self.wire.kinds(), ["interaction"])
        self.outgoing.queue(v1.ClientMessage(interaction=v1.Interaction(active=False)))
        self.again(0)
        self.assertEqual(self.wire.kinds(), [])

    def test_who_only_sends_pings_now_and_then_and_nobody_waits_for_these_answers(self):
        self.again(0)
        for id in range(130):
            self.outgoing.queue(command(id))
        pings = [message.ping.client_time_ms for message in self.wire.arrived if message.HasField("ping")]
        self.assertEqual(len(pings), 2)
        for mark in pings:
            self.assertFalse(self.outgoing.heard(v1.ServerMessage(pong=v1.Pong(client_time_ms=mark))))
        mark = self.outgoing.mark()
        self.outgoing.queue(v1.ClientMessage(ping=v1.Ping(client_time_ms=mark)))
        answer = v1.ServerMessage(pong=v1.Pong(client_time_ms=mark))
        self.assertTrue(self.outgoing.heard(answer))
        self.assertFalse(self.outgoing.heard(answer))  # answered once


class WhatIsTold(unittest.TestCase):
    def test_a_state_that_answers_a_command_without_effect_is_no_news(self):
        told = Told()
        self.assertEqual(told.hear(v1.ServerMessage(welcome=v1.Welcome(state=v1.State(revision=3)))), "state")
        self.assertEqual(told.hear(v1.ServerMessage(state=v1.State(revision=3), heeded=8)), "")
        self.assertEqual(told.heeded, 8)
        self.assertEqual(told.hear(v1.ServerMessage(state=v1.State(revision=4))), "state")

    def test_a_refusal_raises_once_and_for_its_message_only(self):
        told = Told()
        told.hear(v1.ServerMessage(error=v1.Error(in_reply_to=5, code="bad", message="no", field="upper")))
        told.refuse(4)
        with self.assertRaises(IsostrataError) as raised:
            told.refuse(5)
        self.assertEqual((raised.exception.code, raised.exception.field), ("bad", "upper"))
        told.refuse(5)

    def test_of_frames_that_nobody_takes_the_newest_eight_are_kept(self):
        told = Told()
        for id in range(20):
            told.hear(v1.ServerMessage(frame=v1.Frame(frame_id=id)))
        self.assertEqual([told.take_frame().frame_id for _ in range(8)], list(range(12, 20)))
        self.assertIsNone(told.take_frame())

    def test_a_server_that_only_gives_notice_may_come_back(self):
        told = Told()
        told.hear(v1.ServerMessage(shutdown=v1.Shutdown(reason="tonight", notice=True)))
        self.assertFalse(told.for_good)
        told.hear(v1.ServerMessage(shutdown=v1.Shutdown(reason="now", comes_back=True)))
        self.assertFalse(told.for_good)
        told.hear(v1.ServerMessage(shutdown=v1.Shutdown(reason="now")))
        self.assertEqual((told.for_good, told.last_words), (True, "now"))


class Scene(shown.Shown):
    """A session without a server: what it shows, and what it would send."""

    message = v1.State(array="Density", color_range=v1.ColorRange(span=v1.COLOR_SPAN_OWN, lower=1, upper=9, log=True))
    info = v1.DatasetInfo(times=[0.5, 2.5])

    def __init__(self) -> None:
        self.sent: list[dict] = []

    def command(self, **body) -> None:
        self.sent.append(body)


class WhatIsShown(unittest.TestCase):
    def test_an_appearance_says_what_is_given_and_nothing_else(self):
        scene = Scene()
        scene.appearance()
        self.assertEqual(scene.sent, [])
        scene.appearance(body_shading=0.25)
        self.assertEqual(scene.sent.pop(), {"set_appearance": v1.SetAppearance(body_shading=0.25)})
        scene.appearance(occlusion=0, mode="cycled")
        self.assertEqual(scene.sent.pop(), {"set_appearance": v1.SetAppearance(occlusion=0, mode=v1.RENDER_MODE_CYCLED)})
        for given, wanted in (
            ({"color_log": False}, v1.ColorRange(span=v1.COLOR_SPAN_OWN, lower=1, upper=9)),
            ({"color_range": "step"}, v1.ColorRange(span=v1.COLOR_SPAN_STEP, log=True)),
            ({"color_range": (2, 3)}, v1.ColorRange(span=v1.COLOR_SPAN_OWN, lower=2, upper=3, log=True)),
        ):
            scene.appearance(**given)
            self.assertEqual(scene.sent.pop(), {"set_appearance": v1.SetAppearance(color_range=wanted)})

    def test_a_name_that_is_not_known_is_refused_before_it_is_sent(self):
        scene = Scene()
        for wrong in (lambda: scene.appearance(mode="glossy"), lambda: scene.set_time(1, "soon"), lambda: setattr(scene, "values", "half")):
            with self.assertRaises(IsostrataError) as raised:
                wrong()
            self.assertIn("expected one of", str(raised.exception))
        self.assertEqual(scene.sent, [])

    def test_the_time_is_that_of_the_step_unless_it_is_said(self):
        scene = Scene()
        self.assertEqual(scene.time, 0.5)
        scene.message = v1.State(time=1.25)
        self.assertEqual(scene.time, 1.25)


class WhatIsAsked(unittest.TestCase):
    def test_a_part_is_open_under_an_id_of_its_own_and_a_whole_only_under_its_own(self):
        whole, part = v1.OpenDataset(id="fin"), v1.OpenDataset(id="fin", stride="2")
        self.assertTrue(questions.is_that("fin", whole))
        self.assertFalse(questions.is_that("fin@*2", whole))
        self.assertTrue(questions.is_that("fin@*2", part))
        self.assertFalse(questions.is_that("finer@*2", part))

    def test_a_change_names_the_fields_that_differ(self):
        before = v1.State(revision=1, array="a", step=2)
        after = v1.State(revision=2, array="a", intervals=[v1.Interval(id=1)])
        self.assertEqual(news.changed_fields(before, after), {"revision", "step", "intervals"})
        self.assertEqual(news.changed_fields(before, before), frozenset())
