"""What a server has told: the newest of what it says again and again, and what nobody has taken yet of what it says once."""

from __future__ import annotations

from collections import deque
from typing import Callable, Deque, Dict, Optional

from .errors import IsostrataError
from .v1 import isostrata_pb2 as v1

_KEPT_FRAMES = 8  # that nobody has asked for yet; older ones are forgotten


class Told:
    """Not thread-safe, but for reading a member that is not a method. Each is replaced as a whole, but
    ``datasets``, to which entries are added."""

    def __init__(self) -> None:
        self.welcome: Optional[v1.Welcome] = None
        self.state = v1.State()
        self.dataset = v1.DatasetInfo()
        self.datasets: Dict[str, v1.DatasetEntry] = {}  # by id, the first of what can be opened
        self.progress: Optional[v1.Progress] = None
        self.heeded = 0  # the newest message of ours that a State has answered
        self.last_words = ""  # what it said of an end, or refused last
        self.for_good = False  # it has said that it does not come back
        self._frames: Deque[v1.Frame] = deque(maxlen=_KEPT_FRAMES)
        self._answers: Deque[v1.ServerMessage] = deque(maxlen=256)  # errors, pongs, histograms

    def hear(self, message: v1.ServerMessage) -> str:
        """A message, in which messages of ours have the numbers that the caller knows. What of it is news for a listener: "state", "files",
        "progress", or nothing."""
        kind = message.WhichOneof("body")
        if kind == "welcome":
            self.state = message.welcome.state
            self.dataset = message.welcome.dataset_info
            self.welcome = message.welcome
            self.datasets = {entry.id: entry for entry in message.welcome.datasets}
            return "state"
        if kind == "state":
            # One that answers a command which changed nothing is not news.
            news = "state" if message.state.revision != self.state.revision else ""
            self.state = message.state
            self.heeded = message.heeded
            return news
        if kind == "dataset_info":
            self.dataset = message.dataset_info
        elif kind == "datasets_changed":
            for entry in message.datasets_changed.entries:
                self.datasets[entry.id] = entry
            return "files"
        elif kind == "frame":
            self._frames.append(message.frame)
        elif kind == "progress":
            self.progress = message.progress
            return "progress"
        elif kind == "done":
            self.progress = None
        elif kind == "shutdown":
            self.last_words = message.shutdown.reason
            if not message.shutdown.notice:
                self.for_good = not message.shutdown.comes_back
        elif kind is not None:
            if kind == "error":
                self.last_words = message.error.message
            self.keep(message)
        return ""

    def keep(self, answer: v1.ServerMessage) -> None:
        """For whoever asks."""
        self._answers.append(answer)

    def take_frame(self) -> Optional[v1.Frame]:
        return self._frames.popleft() if self._frames else None

    def take_answer(self, kind: str, fits: Callable[[v1.ServerMessage], bool]) -> Optional[v1.ServerMessage]:
        for answer in self._answers:
            if answer.WhichOneof("body") == kind and fits(answer):
                self._answers.remove(answer)
                return answer
        return None

    def refuse(self, number: int) -> None:
        """Raises if the server has refused this message of ours."""
        refusal = self.take_answer("error", lambda answer: answer.error.in_reply_to == number)
        if refusal:
            raise IsostrataError(refusal.error.code, refusal.error.message, refusal.error.field)

    def has_answered(self, mark: float) -> bool:
        """Whether the ping of this mark has been, and so everything before it."""
        return any(a.WhichOneof("body") == "pong" and a.pong.client_time_ms == mark for a in self._answers)
