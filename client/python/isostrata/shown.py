"""What a session shows, as Python's own values: read from the newest state, changed by the protocol's commands."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any, Sequence, Tuple, Union

from .errors import IsostrataError
from .scene import Camera, Color, Point, Term, rgb, to_points, vec3
from .v1 import isostrata_pb2 as v1

_MODES = {
    "sorted": v1.RENDER_MODE_SORTED,
    "prioritized": v1.RENDER_MODE_PRIORITIZED,
    "cycled": v1.RENDER_MODE_CYCLED,
    "smear": v1.RENDER_MODE_SMEAR,
}
_TIME_MODES = {"": 0, "step": v1.TIME_MODE_STEP, "interpolate": v1.TIME_MODE_INTERPOLATE, "spacetime": v1.TIME_MODE_SPACETIME}
_FIELD_VALUES = {"interpolated": v1.FIELD_VALUES_INTERPOLATED, "whole": v1.FIELD_VALUES_WHOLE}
_SPANS = {"step": v1.COLOR_SPAN_STEP, "all_steps": v1.COLOR_SPAN_ALL_STEPS}


class Shown(ABC):
    """Has no state of its own: it needs the newest State and dataset, and a way for commands."""

    @property
    @abstractmethod
    def message(self) -> v1.State:
        """The newest state, as the protocol's message."""

    @property
    @abstractmethod
    def info(self) -> v1.DatasetInfo:
        """Of the open dataset: grid, cells, arrays, times, ..."""

    @abstractmethod
    def command(self, **body: Any) -> None:
        """One message of the protocol: ``command(set_view=v1.SetView(view="+x"))``."""

    @property
    def arrays(self) -> dict[str, Tuple[float, float]]:
        """The open dataset's arrays and their ranges."""
        return {array.name: (array.lower, array.upper) for array in self.info.arrays}

    @property
    def array(self) -> str:
        """The array that intervals are cut from; setting it keeps their place in its range."""
        return self.message.array

    @array.setter
    def array(self, name: str) -> None:
        self.command(select_arrays=v1.SelectArrays(array=name))

    @property
    def color_by(self) -> str:
        """The array that colour maps run over."""
        return self.message.color_by

    @color_by.setter
    def color_by(self, name: str) -> None:
        self.command(select_arrays=v1.SelectArrays(color_by=name))

    @property
    def texture(self) -> str:
        """The array that surfaces' textures run over."""
        return self.message.texture

    @texture.setter
    def texture(self, name: str) -> None:
        self.command(select_arrays=v1.SelectArrays(texture=name))

    @property
    def values(self) -> str:
        """What lies between the values of the array: "interpolated", or "whole": nothing, so that layers take whole cells, or labels of points.

        Another array is interpolated until this is set again."""
        return "whole" if self.message.values == v1.FIELD_VALUES_WHOLE else "interpolated"

    @values.setter
    def values(self, values: str) -> None:
        self.command(select_arrays=v1.SelectArrays(values=_choice(_FIELD_VALUES, values, "values")))

    @property
    def step(self) -> int:
        return self.message.step

    @step.setter
    def step(self, step: int) -> None:
        self.command(set_time_step=v1.SetTimeStep(step=step))

    @property
    def time(self) -> float:
        """In the dataset's units."""
        if self.message.HasField("time"):
            return self.message.time
        return self.info.times[self.step] if self.step < len(self.info.times) else 0.0

    @time.setter
    def time(self, time: float) -> None:
        self.set_time(time)

    def set_time(self, time: float, mode: str = "") -> None:
        """``mode``: what a time between two steps means: "step", "interpolate", "spacetime"; empty: as it is."""
        self.command(set_time=v1.SetTime(time=time, mode=_choice(_TIME_MODES, mode, "mode")))

    def combine(self, *terms: Union[Term, Sequence[Any]]) -> None:
        """Ranges of other arrays, ("and", "Momentum", 0.1, 0.4), combined with the intervals from left to right; none: the intervals
        alone."""
        wires = [(term if isinstance(term, Term) else Term(*term)).to_wire() for term in terms]
        self.command(set_combination=v1.SetCombination(terms=wires))

    def set_transfer_function(self, points: Sequence[Point]) -> None:
        """Replaces all intervals by one that looks as these (value, colour, opacity) say, straight between them."""
        self.command(set_transfer_function=v1.SetTransferFunction(points=to_points(points)))

    def transfer_from_matplotlib(self, color_map: Any, opacity: float = 0.3, count: int = 33) -> None:
        """A transfer function over the whole array, in the colours of a matplotlib colour map: its name, or anything that makes
        (red, green, blue, ...) of a number in [0, 1]."""
        if isinstance(color_map, str):
            import matplotlib

            color_map = matplotlib.colormaps[color_map]
        lower, upper = self.arrays[self.array]
        places = [i / (count - 1) for i in range(count)]
        self.set_transfer_function([(lower * (1 - t) + upper * t, tuple(color_map(t))[:3], opacity) for t in places])

    def appearance(
        self,
        *,
        mode: str | None = None,
        background: Color | None = None,
        unit_distance: float | None = None,
        color_range: str | tuple[float, float] | None = None,
        color_log: bool | None = None,
        occlusion: float | None = None,
        depth_fade: float | None = None,
        body_shading: float | None = None,
        axis_scale: Sequence[float] | None = None,
    ) -> None:
        """Changes what is given. ``occlusion``, ``depth_fade`` and ``body_shading``, in [0, 1]: how dark hollows are, how far what is far away
        fades, how far the layers' interiors are shaded along the array's gradient. ``mode``:
        "sorted", "prioritized", "cycled", "smear". ``color_range``: over what colour maps run, the values of "step" or of "all_steps", or two
        numbers; ``color_log``: by the logarithm. ``axis_scale``: how many times as long x, y and z are drawn, as (1, 1, 50) for vertical
        exaggeration; the camera goes along."""
        change = _appearance(self.message.color_range, mode, background, unit_distance, color_range, color_log, occlusion, depth_fade, body_shading)
        if axis_scale is not None:
            change.axis_scale.CopyFrom(vec3(axis_scale))
        if change.ByteSize():
            self.command(set_appearance=change)

    def cycle(self, *, seconds: float | None = None, phase: float | None = None, playing: bool | None = None) -> None:
        given = {name: value for name, value in (("seconds", seconds), ("phase", phase), ("playing", playing)) if value is not None}
        self.command(set_cycle=v1.SetCycle(**given))

    def smear(self, steps: Sequence[int] = (), colors: Sequence[Color] = (), *, times: Sequence[float] = ()) -> None:
        """Steps, or in their place times, in the order they are painted."""
        self.command(set_smear=v1.SetSmear(smear=v1.Smear(steps=steps, times=times, colors=[rgb(color) for color in colors])))

    def clip(self, *planes: Tuple[Sequence[float], float]) -> None:
        """(normal, offset): keeps what has dot(normal, position) >= offset for all of them; none: nothing is cut away."""
        wires = [v1.ClipPlane(normal=vec3(normal), offset=offset) for normal, offset in planes]
        self.command(set_clip_planes=v1.SetClipPlanes(clip_planes=wires))

    def annotate(self, *, axes: bool = False, box: bool = False, legend: bool = False) -> None:
        self.command(set_annotations=v1.SetAnnotations(annotations=v1.Annotations(axes=axes, box=box, legend=legend)))

    @property
    def camera(self) -> Camera:
        return Camera.from_wire(self.message.camera)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        self.command(set_camera=v1.SetCamera(camera=camera.to_wire()))

    def view(self, view: str = "reset") -> None:
        """"reset": as when the dataset was opened; "+x", "-x", "+y", "-y", "+z" or "-z": the whole dataset from that side."""
        self.command(set_view=v1.SetView(view=view))


def _appearance(
    shown: v1.ColorRange,
    mode: str | None,
    background: Color | None,
    unit_distance: float | None,
    color_range: str | tuple[float, float] | None,
    color_log: bool | None,
    occlusion: float | None,
    depth_fade: float | None,
    body_shading: float | None,
) -> v1.SetAppearance:
    """What is given, and nothing else. A range of colours goes as a whole, so what is not given of it is as it is ``shown``."""
    look = v1.SetAppearance(unit_distance=unit_distance, occlusion=occlusion, depth_fade=depth_fade, body_shading=body_shading)
    if mode is not None:
        look.mode = _choice(_MODES, mode, "mode")
    if background is not None:
        look.background.CopyFrom(rgb(background))
    if color_range is not None or color_log is not None:
        look.color_range.CopyFrom(shown)
    if isinstance(color_range, str):
        look.color_range.CopyFrom(v1.ColorRange(span=_choice(_SPANS, color_range, "color_range"), log=look.color_range.log))
    elif color_range is not None:
        look.color_range.span = v1.COLOR_SPAN_OWN
        look.color_range.lower, look.color_range.upper = color_range
    if color_log is not None:
        look.color_range.log = color_log
    return look


def _choice(known: dict[str, int], given: str, field: str) -> int:
    if given not in known:
        expected = ", ".join(name for name in known if name)
        raise IsostrataError("invalid_argument", f"{field} {given!r} is not known; expected one of {expected}", field)
    return known[given]
