"""What has been sent and what has become of it, over all connections of one client.

Commands have numbers of the client's own (``ClientMessage.command``), of which a server says the newest that it has judged; so after
a loss those that it has not are sent again, and nothing is done twice. Messages have numbers towards the caller, too, that grow
whatever numbers they have on the wire of one connection or another.
"""

from __future__ import annotations

import time
from bisect import bisect_left, bisect_right
from collections import deque
from dataclasses import dataclass
from typing import Deque, List, Tuple

from .v1 import isostrata_pb2 as v1

_KEPT = 10.0  # seconds that judged commands are kept: a server that is killed may lose the last moments of what it kept
_MOST = 4096
_MOST_BYTES = 4 << 20  # of judged ones

# What is about one connection, or a question that can be put again; everything else must be done once, and not be lost.
_NO_COMMANDS = {
    "hello", "viewport", "interaction", "frame_ack", "request_still", "request_histogram", "probe_point", "probe_line", "probe_steps",
    "request_layer_statistics", "cancel",
    "ping", "decoder_failed", "list_invitations", None,
}  # fmt: skip


@dataclass
class _Command:
    number: int
    message: v1.ClientMessage
    at: float
    size: int
    judged: bool = False


class Sent:
    """Not thread-safe."""

    def __init__(self) -> None:
        self.number = 0  # of the newest message, towards the caller
        self._command = 0
        self._log: Deque[_Command] = deque()
        self._bytes = 0  # of the log
        self._wire = 0
        self._wires: List[int] = []  # of this connection, with the numbers of _numbers
        self._numbers: List[int] = []
        self._contained = 0  # the newest number that was judged before this connection

    def note(self, message: v1.ClientMessage) -> int:
        """A new message. Its number towards the caller."""
        self.number += 1
        if message.WhichOneof("body") not in _NO_COMMANDS:
            self._command += 1
            message.command = self._command
            kept = v1.ClientMessage()
            kept.CopyFrom(message)
            self._log.append(_Command(self.number, kept, time.monotonic(), kept.ByteSize()))
            self._bytes += self._log[-1].size
            while self._is_old(self._log[0]):
                self._bytes -= self._log.popleft().size
        return self.number

    def _is_old(self, command: _Command) -> bool:
        if len(self._log) > _MOST:
            return True
        return command.judged and (self._bytes > _MOST_BYTES or time.monotonic() - command.at > _KEPT)

    def put(self, message: v1.ClientMessage, number: int = 0) -> bytes:
        """Its bytes for this connection. ``number``: what note gave; 0: it is nobody's."""
        self._wire += 1
        message.seq = self._wire
        if number:
            self._wires.append(self._wire)
            self._numbers.append(number)
            if len(self._wires) > 4 * _MOST:
                del self._wires[:_MOST], self._numbers[:_MOST]
        return message.SerializeToString()

    def judged(self, number: int) -> None:
        """Everything up to this number has been."""
        for command in self._log:
            if command.number > number:
                break
            command.judged = True

    def number_of(self, wire: int, exact: bool = False) -> int:
        """Of a message of this connection: exactly, or 0; or of the newest up to this one."""
        if exact:
            at = bisect_left(self._wires, wire)
            return self._numbers[at] if at < len(self._wires) and self._wires[at] == wire else 0
        at = bisect_right(self._wires, wire)
        return self._numbers[at - 1] if at else self._contained

    def opening(self) -> str:
        """The dataset that a command without a verdict opens."""
        return next((c.message.open_dataset.id for c in reversed(self._log) if not c.judged and c.message.HasField("open_dataset")), "")

    def new_connection(self) -> None:
        self._wire = 0
        self._wires.clear()
        self._numbers.clear()
        self._contained = 0

    def again(self, last_command: int, same_session: bool, lost_some: bool) -> Tuple[List[bytes], int]:
        """What is to be sent again, of a session that has judged ``last_command``; and the number of that command, where its verdict
        was never heard."""
        unheard = 0
        if same_session:
            for command in self._log:
                if not command.judged and command.message.command <= last_command:
                    command.judged = True
                    if command.message.command == last_command:
                        unheard = command.number
        wanted = [c for c in self._log if not c.judged or (lost_some and c.message.command > last_command)]
        self._contained = wanted[0].number - 1 if wanted else self.number
        for command in wanted:
            command.judged = False
        return [self.put(c.message, c.number) for c in wanted], unheard
