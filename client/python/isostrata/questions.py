"""What is asked of a server and takes more than one message, or a while: each waits until it is answered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .connection import Connection
from .v1 import isostrata_pb2 as v1


@dataclass(frozen=True)
class Histogram:
    """Of the finite values of one array, as numpy.histogram gives it."""

    array: str
    counts: np.ndarray  # [bins] uint64
    edges: np.ndarray  # [bins + 1] float64


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
