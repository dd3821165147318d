"""What is shown, as plain values: intervals, surfaces, cameras, terms. The server judges them and says which field is wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Sequence, Tuple, Union

import numpy as np

from .errors import IsostrataError
from .v1 import isostrata_pb2 as v1

Color = Union[str, Sequence[float]]  # "#rrggbb", or three numbers in [0, 1]
Vector = Tuple[float, float, float]
Point = Tuple[float, Color, float]  # of a transfer function: value, colour, opacity


def rgb(color: Color) -> v1.Rgb:
    """"#rrggbb", "#rgb", or three numbers in [0, 1]."""
    if isinstance(color, str):
        digits = color[1:]
        if len(digits) == 3:
            digits = "".join(c * 2 for c in digits)
        try:
            if not color.startswith("#") or len(digits) != 6:
                raise ValueError
            value = int(digits, 16)
        except ValueError:
            raise IsostrataError("invalid_argument", f"colour {color!r}: expected #rrggbb or three numbers", "color") from None
        return v1.Rgb(r=(value >> 16) / 255, g=(value >> 8 & 255) / 255, b=(value & 255) / 255)
    red, green, blue = (float(c) for c in color)
    return v1.Rgb(r=red, g=green, b=blue)


def hex_of(color: v1.Rgb) -> str:
    return "#" + "".join(f"{round(min(max(c, 0.0), 1.0) * 255):02x}" for c in (color.r, color.g, color.b))


def vec3(xyz: Sequence[float]) -> v1.Vec3:
    x, y, z = (float(c) for c in xyz)
    return v1.Vec3(x=x, y=y, z=z)


def to_points(points: Sequence[Point]) -> list[v1.TransferPoint]:
    return [v1.TransferPoint(value=value, color=rgb(color), opacity=opacity) for value, color, opacity in points]


def _only_given(**fields: Any) -> dict[str, Any]:
    return {name: value for name, value in fields.items() if value is not None}


@dataclass(frozen=True)
class Surface:
    """The looks of an interval's boundary. None: the default that the protocol names."""

    lower: bool = True
    upper: bool = True
    domain: bool = False
    color: Color | None = None
    opacity: float | None = None
    ambient: float | None = None
    diffuse: float | None = None
    specular: float | None = None
    shininess: float | None = None
    silhouette: float = 0.0
    texture: str = ""
    texture_repeat: float | None = None

    def to_wire(self) -> v1.Surface:
        given = {name: value for name, value in self.__dict__.items() if name != "color"}
        return v1.Surface(**_only_given(**given, color=None if self.color is None else rgb(self.color)))

    @classmethod
    def from_wire(cls, wire: v1.Surface) -> Surface:
        optional = ("opacity", "ambient", "diffuse", "specular", "shininess", "texture_repeat")
        given = {name: getattr(wire, name) for name in optional if wire.HasField(name)}
        color = hex_of(wire.color) if wire.HasField("color") else None
        return cls(wire.lower, wire.upper, wire.domain, color, silhouette=wire.silhouette, texture=wire.texture, **given)


@dataclass(frozen=True)
class Interval:
    """One layer: the solid region lower <= f <= upper. ``id`` is given by the server."""

    lower: float
    upper: float
    color: Color | None = None  # None: the server chooses by its place
    opacity: float = 0.5  # of a layer one unit distance thick
    color_map: str = ""  # over the color_by array; empty: the colour
    opacity_upper: float | None = None  # at the top of the range that colour runs over
    own_range: bool = False  # colour and opacity run from lower to upper
    priority: int = 0
    visible: bool = True
    name: str = ""
    surface: Surface | None = None
    id: int = 0
    transfer: Sequence[Point] = ()  # (value, colour, opacity) each: in place of all looks above, from the first value to the last

    def to_wire(self) -> v1.Interval:
        given = {name: value for name, value in self.__dict__.items() if name not in ("color", "surface", "transfer")}
        if self.transfer:
            given["transfer_function"] = v1.TransferFunction(points=to_points(self.transfer))
        color = None if self.color is None else rgb(self.color)
        surface = None if self.surface is None else self.surface.to_wire()
        return v1.Interval(**_only_given(**given, color=color, surface=surface))

    @classmethod
    def from_wire(cls, wire: v1.Interval) -> Interval:
        return cls(
            wire.lower,
            wire.upper,
            hex_of(wire.color),
            wire.opacity,
            wire.color_map,
            wire.opacity_upper if wire.HasField("opacity_upper") else None,
            wire.own_range,
            wire.priority,
            wire.visible,
            wire.name,
            Surface.from_wire(wire.surface) if wire.HasField("surface") else None,
            wire.id,
            tuple((point.value, hex_of(point.color), point.opacity) for point in wire.transfer_function.points),
        )

    @classmethod
    def of(cls, given: Interval | Sequence[float]) -> Interval:
        """An interval, or a pair of its ends."""
        if isinstance(given, Interval):
            return given
        lower, upper = (float(end) for end in given)
        return cls(lower, upper)


@dataclass(frozen=True)
class Camera:
    """World space is the dataset's. ``fov`` is the full vertical angle of view in degrees."""

    eye: Vector
    at: Vector
    up: Vector
    fov: float = 30.0
    orthographic: bool = False

    def to_wire(self) -> v1.Camera:
        return v1.Camera(eye=vec3(self.eye), at=vec3(self.at), up=vec3(self.up), fov_deg=self.fov, orthographic=self.orthographic)

    @classmethod
    def from_wire(cls, wire: v1.Camera) -> Camera:
        def vector(v: v1.Vec3) -> Vector:
            return (v.x, v.y, v.z)

        return cls(vector(wire.eye), vector(wire.at), vector(wire.up), wire.fov_deg, wire.orthographic)

    def turned(self, azimuth: float, elevation: float = 0.0) -> Camera:
        """Turned about ``at``: to the right about the up direction, then upwards. In degrees."""
        at, up = np.array(self.at), np.array(self.up) / np.linalg.norm(self.up)
        back = _rotated(np.array(self.eye) - at, up, azimuth)
        right = np.cross(up, back)
        right /= np.linalg.norm(right)
        back, up = _rotated(back, right, -elevation), _rotated(up, right, -elevation)
        return replace(self, eye=tuple((at + back).tolist()), up=tuple(up.tolist()))

    def zoomed(self, factor: float) -> Camera:
        """Nearer to ``at``: 2 shows everything twice as large."""
        at = np.array(self.at)
        return replace(self, eye=tuple((at + (np.array(self.eye) - at) / factor).tolist()))


def _rotated(v: np.ndarray, axis: np.ndarray, degrees: float) -> np.ndarray:
    """O. Rodrigues' formula; the axis has unit length."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return v * c + np.cross(axis, v) * s + axis * (axis @ v) * (1 - c)


@dataclass(frozen=True)
class Term:
    """A range of another array, combined with the intervals: ``op`` is "and", "or", "minus" or "xor"."""

    op: str
    array: str
    lower: float
    upper: float
    color: Color | None = None
    color_map: str = ""
    opacity: float | None = None
    priority: int | None = None
    hidden: bool = False

    _OPERATORS: ClassVar[dict[str, int]] = {
        "and": v1.RANGE_OPERATOR_INTERSECT,
        "or": v1.RANGE_OPERATOR_UNITE,
        "minus": v1.RANGE_OPERATOR_SUBTRACT,
        "xor": v1.RANGE_OPERATOR_EXCLUSIVE_OR,
    }

    def to_wire(self) -> v1.RangeTerm:
        op = self._OPERATORS.get(self.op)
        if op is None:
            raise IsostrataError("invalid_argument", f"operator {self.op!r}: expected and, or, minus or xor", "op")
        given = {name: value for name, value in self.__dict__.items() if name not in ("op", "color")}
        return v1.RangeTerm(op=op, **_only_given(**given, color=None if self.color is None else rgb(self.color)))
