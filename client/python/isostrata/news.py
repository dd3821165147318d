"""What a server tells by itself, as Python iterates over it: frames, and changes of what is shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Iterator, List

import numpy as np

from .connection import Connection
from .picture import decode_image
from .v1 import isostrata_pb2 as v1


@dataclass(frozen=True)
class Frame:
    """A picture that the server sent by itself."""

    id: int
    revision: int  # of the state that it shows
    lossless: bool
    width: int
    height: int
    format: str  # "png", "jpeg"
    payload: bytes
    message: v1.Frame  # all that the server says of it: stage times, tetrahedra, device, ...

    def image(self) -> np.ndarray:
        """uint8 [height, width, channels]."""
        return decode_image(self.payload)


@dataclass(frozen=True)
class Change:
    """What a session shows is no longer what it was."""

    revision: int
    fields: frozenset[str]  # of v1.State: "intervals", "camera", "array", ... that differ from the change before
    state: v1.State


def frames(connection: Connection, count: int | None, timeout: float | None) -> Iterator[Frame]:
    given = 0
    while count is None or given < count:
        taken: List[v1.Frame] = []

        def came() -> bool:
            frame = connection.take_frame()
            if frame is not None:
                taken.append(frame)
            return bool(taken)

        connection.wait(came, "no frame came in time", timeout)
        f = taken[0]
        given += 1
        yield Frame(f.frame_id, f.revision, f.phase == v1.FRAME_PHASE_LOSSLESS, f.width, f.height, f.format, f.payload, f)


def changes(connection: Connection, shown: v1.State, count: int | None, timeout: float | None) -> Iterator[Change]:
    """From ``shown`` on."""
    told, given = connection.told, 0
    while count is None or given < count:
        connection.wait(lambda: told.state is not shown, "the session did not change in time", timeout)
        before, shown = shown, told.state
        fields = changed_fields(before, shown)
        if fields:
            given += 1
            yield Change(shown.revision, fields - {"revision"}, shown)


def changed_fields(before: v1.State, after: v1.State) -> frozenset[str]:
    old, new = ({field.name: value for field, value in state.ListFields()} for state in (before, after))
    # Not by get: a list of messages can be compared with another one, and not with None.
    return frozenset(name for name in old.keys() | new.keys() if not (name in old and name in new and old[name] == new[name]))
