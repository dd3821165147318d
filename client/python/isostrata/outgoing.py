"""What goes out to a session, over all connections to it: what is said while there is none waits, and what the session has not judged
goes out again."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Callable, Deque, Optional

from .sent import Sent
from .v1 import isostrata_pb2 as v1

_UNMARKED = 64  # commands without a ping after them: whoever only ever sends learns by one what has come


@dataclass(frozen=True)
class Resent:
    count: int  # commands
    same_session: bool
    verdict: Optional[v1.ServerMessage]  # on a command that was judged before the loss, and never heard


class Outgoing:
    """Not thread-safe. ``write`` gives a message's bytes to the connection that stands; it does not wait."""

    def __init__(self, write: Callable[[bytes], None]) -> None:
        self.up = False  # what is queued goes out
        self.session = ""  # that it goes to
        self.opening = ""  # a dataset that is opened once more after a loss
        self._write = write
        self._sent = Sent()
        self._pings: Deque[tuple[float, int]] = deque(maxlen=4096)  # without an answer, and their numbers
        self._mark = 0
        self._unmarked = 0  # commands since the last ping
        self._interacting = False
        self._known = 0  # the newest revision that was told before Welcome

    def queue(self, message: v1.ClientMessage) -> int:
        """The message's number, which grows over all connections. Without one a command waits until it can go out, and a question is lost:
        it is to be asked again."""
        kind = message.WhichOneof("body")
        if kind == "interaction":
            self._interacting = message.interaction.active
        number = self._sent.note(message)
        if kind == "ping":
            self._pings.append((message.ping.client_time_ms, number))
            self._unmarked = 0
        elif message.command:
            self._unmarked += 1
        if self.up:
            self._write(self._sent.put(message, number))
        if self._unmarked >= _UNMARKED:
            self.queue(v1.ClientMessage(ping=v1.Ping(client_time_ms=-self.mark())))
        return number

    def mark(self) -> float:
        """For a ping, by which its answer is known."""
        self._mark += 1
        return float(self._mark)

    def acknowledge(self, frame_id: int) -> None:
        self._write(self._sent.put(v1.ClientMessage(frame_ack=v1.FrameAck(frame_id=frame_id))))

    def begin(self, hello: v1.Hello) -> bytes:
        """The first message of a new connection."""
        self._sent.new_connection()
        self._pings.clear()
        return self._sent.put(v1.ClientMessage(hello=hello))

    def resume(self, welcome: v1.Welcome, state: v1.State) -> Resent:
        """From here on what is queued goes out; first what the session has not judged. ``state``: the newest that was told."""
        same = welcome.session == self.session
        again, unheard = self._sent.again(welcome.last_command, same, same and welcome.state.revision < self._known)
        verdict = None
        if unheard and welcome.HasField("last_command_error"):
            verdict = v1.ServerMessage(error=welcome.last_command_error)
            verdict.error.in_reply_to = unheard
        self.opening = self._sent.opening() if again and state.dataset != self._sent.opening() else ""
        for data in again:
            self._write(data)
        if self._interacting:
            self._write(self._sent.put(v1.ClientMessage(interaction=v1.Interaction(active=True))))
        self.up = True
        self.session = welcome.session
        self._known = state.revision
        return Resent(len(again), same, verdict)

    def heard(self, message: v1.ServerMessage) -> bool:
        """Gives the message the caller's numbers in place of this connection's, and learns from it what has been judged. False: it is of no
        more use to anybody, a ping's answer that nobody waits for."""
        kind = message.WhichOneof("body")
        if kind == "state":
            message.heeded = self._sent.number_of(message.heeded)
            if message.state.dataset == self.opening:
                self.opening = ""
            if self.up:
                self._known = message.state.revision
        elif kind == "frame":
            message.frame.input_seq = self._sent.number_of(message.frame.input_seq)
            self._sent.judged(message.frame.input_seq)
        elif kind == "error":
            self.opening = ""
            message.error.in_reply_to = self._sent.number_of(message.error.in_reply_to, exact=True)
        elif kind == "probe_result":
            message.probe_result.in_reply_to = self._sent.number_of(message.probe_result.in_reply_to, exact=True)
        elif kind == "probed_curve":
            message.probed_curve.in_reply_to = self._sent.number_of(message.probed_curve.in_reply_to, exact=True)
        elif kind == "layer_statistics":
            message.layer_statistics.in_reply_to = self._sent.number_of(message.layer_statistics.in_reply_to, exact=True)
        elif kind == "pong":
            return self._answered(message.pong.client_time_ms)
        return True

    def _answered(self, mark: float) -> bool:
        if all(mark != sent for sent, _ in self._pings):
            return False
        while self._pings:
            sent, number = self._pings.popleft()  # they are answered in order
            self._sent.judged(number)
            if sent == mark:
                break
        return mark > 0
