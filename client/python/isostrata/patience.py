"""How long to wait and when to try again. ``now`` is the clock, in seconds: a test's own stands until it is moved."""

from __future__ import annotations

import time
from typing import Callable

Clock = Callable[[], float]


class Deadline:
    """The end of a wait for what a server does. News begin it anew; while there is no connection it does not come nearer."""

    def __init__(self, limit: float, news: object, now: Clock = time.monotonic) -> None:
        self._limit = limit
        self._news = news
        self._now = now
        self._end = now() + limit

    def left(self, news: object, connected: bool) -> float:
        """Seconds; none are left at 0 and below."""
        if news != self._news or not connected:
            self._news = news
            self._end = self._now() + self._limit
        return self._end - self._now()


class Retries:
    """When to try again what was lost, for so many seconds: after ``first``, then after pauses of 50 ms and more that double up to
    ``longest``."""

    def __init__(self, seconds: float, longest: float, first: float = 0.0, now: Clock = time.monotonic) -> None:
        self._now = now
        self._end = now() + seconds
        self._longest = longest
        self._pause = first

    @property
    def over(self) -> bool:
        return self._now() >= self._end

    def pause(self) -> float:
        """Seconds until the next try."""
        pause = min(self._pause, max(0.0, self._end - self._now()))
        self._pause = min(max(0.05, 2 * self._pause), self._longest)
        return pause
