"""What is asked of a server and takes more than one message, or a while: each waits until it is answered."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Dict, Optional, Tuple

import numpy as np

from .connection import Connection
from .v1 import isostrata_pb2 as v1


@dataclass(frozen=True)
class Histogram:
    """Of the finite values of one array, as numpy.histogram gives it."""

    array: str
    counts: np.ndarray  # [bins] uint64
    edges: np.ndarray  # [bins + 1] float64


@dataclass(frozen=True)
class Probe:
    """What lies at a place of the picture: the first layer there."""

    hit: bool
    miss: str = ""  # why there is none; all that follows is said of a hit alone
    position: Optional[np.ndarray] = None  # [3] float64, in the dataset's space
    distance: float = 0.0  # from the eye
    interval: int = 0  # its id; 0: what a combined range has brought in
    end: str = ""  # what the line of sight comes through: "lower", "upper", "domain", "range", "clip_plane", "eye"
    cell: Optional[int] = None
    point: Optional[int] = None  # the nearest of the cell's
    cell_index: Tuple[int, ...] = ()  # i, j, k on structured grids
    point_index: Tuple[int, ...] = ()
    values: Dict[str, float] = field(default_factory=dict)  # of all arrays, as the layers are drawn; NaN if there is no number
    cell_values: Dict[str, float] = field(default_factory=dict)  # of arrays that the file has on cells


@dataclass(frozen=True)
class Curve:
    """The values of an array along a line, or at a place over all steps. Between two samples the value runs straight."""

    array: str
    at: np.ndarray  # [n] float64: the distance from the line's first point, or the steps
    values: np.ndarray  # [n] float64; NaN: none at this step; along a line a gap begins here
    layers: Tuple[Tuple[float, float, int], ...] = ()  # of a line: from, to, the interval's id (0: what a combined range has brought in)
    thinned: bool = False  # there were more than 4096 samples: the least and the greatest of each small stretch are left
    grids_differ: bool = False  # of values over the steps: the grid is not the same at all of them; the place stays where it is


def curve_of(answer: v1.ProbedCurve) -> Curve:
    layers = tuple((getattr(one, "from"), one.to, one.interval) for one in answer.layers)
    return Curve(answer.array, np.array(answer.at, dtype=np.float64), np.array(answer.value, dtype=np.float64), layers, answer.thinned, answer.grids_differ)


def probe_of(answer: v1.ProbeResult) -> Probe:
    if not answer.hit:
        return Probe(False, answer.miss)
    at = answer.position
    return Probe(
        hit=True,
        position=np.array([at.x, at.y, at.z]),
        distance=answer.distance,
        interval=answer.interval,
        end=v1.ProbeEnd.Name(answer.end).removeprefix("PROBE_END_").lower(),
        cell=answer.cell if answer.HasField("cell") else None,
        point=answer.point if answer.HasField("point") else None,
        cell_index=tuple(answer.cell_index),
        point_index=tuple(answer.point_index),
        values={one.name: one.value if one.HasField("value") else float("nan") for one in answer.arrays},
        cell_values={one.name: one.cell_value for one in answer.arrays if one.HasField("cell_value")},
    )


def histogram(connection: Connection, array: str, bins: int) -> Histogram:
    question = v1.ClientMessage(request_histogram=v1.RequestHistogram(array=array, bins=bins))
    answer = connection.answer_to(
        question, "histogram", lambda a: a.histogram.array == array and len(a.histogram.counts) == bins, "no histogram came in time"
    ).histogram
    return Histogram(array, np.array(answer.counts, np.uint64), np.linspace(answer.lower, answer.upper, len(answer.counts) + 1))


def list_datasets(connection: Connection, wanted: v1.ListDatasets) -> v1.DatasetList:
    asked = (wanted.folder.rstrip("/"), wanted.search, wanted.first)
    return connection.answer_to(
        v1.ClientMessage(list_datasets=wanted),
        "dataset_list",
        lambda a: (a.dataset_list.folder, a.dataset_list.search, a.dataset_list.first) == asked,
        "the server did not list its datasets",
    ).dataset_list


def open_dataset(connection: Connection, wanted: v1.OpenDataset) -> None:
    """Unless it is open. A part of a dataset gets an id of its own, by the server."""
    told = connection.told
    if not wanted.region and not wanted.stride and told.state.dataset == wanted.id and told.dataset.id == wanted.id:
        return
    session = told.welcome.session
    seq = connection.send(v1.ClientMessage(open_dataset=wanted))

    def is_open() -> bool:
        told.refuse(seq)
        # Not before it has been read: a newcomer's session opens a dataset by itself, and what was asked for would come later.
        heeded = told.welcome.session != session or told.heeded >= seq
        return is_that(told.dataset.id, wanted) and told.state.dataset == told.dataset.id and heeded

    connection.wait(is_open, f"dataset {wanted.id!r} was not open in time")


def is_that(opened: str, wanted: v1.OpenDataset) -> bool:
    """A part has its text behind the id, as the server writes it."""
    part = bool(wanted.region or wanted.stride)
    return opened == wanted.id or (part and opened.startswith(wanted.id.partition("@")[0] + "@"))


def reload_dataset(connection: Connection) -> None:
    told = connection.told
    seq = connection.send(v1.ClientMessage(reload_dataset=v1.ReloadDataset()))

    def is_read() -> bool:
        told.refuse(seq)
        return told.heeded >= seq and told.dataset.on_disk != v1.ON_DISK_CHANGED

    connection.wait(is_read, "the dataset was not read again in time")
