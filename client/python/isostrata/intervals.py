"""The layers of a session."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Iterator, Sequence, Union

from .errors import IsostrataError
from .scene import Interval, Surface, rgb, to_points
from .v1 import isostrata_pb2 as v1

if TYPE_CHECKING:
    from .session import Session

Which = Union[int, Interval]  # an interval, or its id


class Intervals(Sequence[Interval]):
    """As they are now, in the order they were added. What is taken out of it is a value: change it by ``patch``."""

    def __init__(self, session: Session) -> None:
        self._session = session

    def _all(self) -> list[Interval]:
        return [Interval.from_wire(wire) for wire in self._session.message.intervals]

    def __len__(self) -> int:
        return len(self._session.message.intervals)

    def __getitem__(self, index):  # type: ignore[no-untyped-def]
        return self._all()[index]

    def __iter__(self) -> Iterator[Interval]:
        return iter(self._all())

    def __repr__(self) -> str:
        return repr(self._all())

    def get(self, which: Which) -> Interval:
        """The one of this id, as it is now."""
        wanted = _id(which)
        for interval in self._all():
            if interval.id == wanted:
                return interval
        raise IsostrataError("not_found", f"interval {wanted} is not in this session", "id")

    def set(self, intervals: Sequence[Interval | Sequence[float]]) -> list[Interval]:
        """Replaces all, by intervals or pairs of ends. Those with an id of this session keep it."""
        wires = [Interval.of(given).to_wire() for given in intervals]
        self._session.command(set_intervals=v1.SetIntervals(intervals=wires))
        return self._all()

    def add(self, lower: float, upper: float, **looks: Any) -> Interval:
        """A new one above all others, with an Interval's other fields."""
        all_ = self._all()
        looks.setdefault("priority", max((interval.priority for interval in all_), default=-1) + 1)
        return self.set([*all_, Interval(lower, upper, **looks)])[-1]

    def move(self, which: Which, lower: float, upper: float) -> Interval:
        return self.patch(which, lower=lower, upper=upper)

    def patch(self, which: Which, **changes: Any) -> Interval:
        """Changes the fields that are named; ``opacity_upper=None``, ``surface=None`` and ``transfer=()`` take them
        away. ``transfer`` brings its own ends."""
        patch = v1.PatchInterval(id=_id(which))
        for name, value in changes.items():
            if name == "color":
                patch.color.CopyFrom(rgb(value))
            elif name == "surface":
                patch.surface.CopyFrom((value or Surface(lower=False, upper=False)).to_wire())
            elif name == "transfer":
                patch.transfer_function.CopyFrom(v1.TransferFunction(points=to_points(value or ())))
            elif name == "opacity_upper" and value is None:
                patch.clear_opacity_upper = True
            elif name in ("lower", "upper", "color_map", "opacity", "opacity_upper", "visible", "own_range", "name"):
                setattr(patch, name, value)
            else:
                raise IsostrataError("invalid_argument", f"an interval's {name!r} cannot be patched", name)
        self._session.command(patch_interval=patch)
        return self.get(which)

    def remove(self, which: Which) -> None:
        self._session.command(remove_interval=v1.RemoveInterval(id=_id(which)))

    def reorder(self, highest_first: Sequence[Which]) -> None:
        """All of them, the highest priority first."""
        self._session.command(reorder_priorities=v1.ReorderPriorities(ids=[_id(which) for which in highest_first]))


def _id(which: Which) -> int:
    return which.id if isinstance(which, Interval) else int(which)
