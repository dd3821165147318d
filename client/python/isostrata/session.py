"""A session of a server: what is shown, and pictures of it."""

from __future__ import annotations

import inspect
import json
from os import PathLike
from typing import Any, Callable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from google.protobuf import json_format

from . import news, questions
from .connection import Connection
from .errors import IsostrataError
from .intervals import Intervals
from .made_file import made_file, patiently
from .picture import decode_image
from .rest import Rest
from .show import View
from .shown import Shown
from .v1 import isostrata_pb2 as v1


def _point(at: Sequence[float]) -> str:
    return ",".join(repr(float(of)) for of in at)


class Session(Shown):
    """Made by ``connect``. Calls return when the server has done what they ask, and raise IsostrataError where it refused; then
    nothing has changed. Others may change the same session: what is read here is the newest that the server has told."""

    def __init__(self, connection: Connection, rest: Rest, size: Tuple[int, int]) -> None:
        self._connection = connection
        self._told = connection.told
        self.rest = rest  #: for what has no method here
        self.size = size
        self.intervals = Intervals(self)

    def close(self) -> None:
        """Ends the connection; the session lives on for a while on the server."""
        self._connection.close()

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        state = self.message
        return f"<isostrata session {self.id}: {state.dataset or 'nothing open'}, {len(state.intervals)} intervals, revision {state.revision}>"

    # ---- what is there ---------------------------------------------------------------------------------------------------------

    @property
    def id(self) -> str:
        return self._told.welcome.session

    @property
    def resume_token(self) -> str:
        return self._told.welcome.resume_token

    @property
    def server(self) -> str:
        return self._told.welcome.server

    @property
    def device(self) -> str:
        return self._told.welcome.device

    @property
    def datasets(self) -> List[str]:
        """The names of what can be opened, of more than 1000 the first; files that come later are among them."""
        return [entry.name for entry in list(self._told.datasets.values()) if entry.news != v1.DATASET_NEWS_GONE]

    def list_datasets(self, folder: str = "", search: str = "", first: int = 0, most: int = 1000) -> v1.DatasetList:
        """What lies in a folder, or below it what has the words of ``search`` in its name: folders, and datasets with kind, bytes, time of
        change, steps and news; what was passed over, and why."""
        return questions.list_datasets(self._connection, v1.ListDatasets(folder=folder, search=search, first=first, most=most))

    @property
    def color_maps(self) -> List[str]:
        return list(self._told.welcome.color_maps)

    @property
    def info(self) -> v1.DatasetInfo:
        """Of the open dataset: grid, cells, arrays, times, ..."""
        return self._told.dataset

    @property
    def message(self) -> v1.State:
        """The newest state, as the protocol's message."""
        return self._told.state

    @property
    def state(self) -> dict[str, Any]:
        """The newest state, as save_state writes it."""
        return document(self.message)

    @property
    def revision(self) -> int:
        return self.message.revision

    # ---- data ------------------------------------------------------------------------------------------------------------------

    def open(self, dataset: str, region: str = "", stride: str = "") -> None:
        """By name or id; waits until it is open.

        Of a structured grid a part can be opened, which is a dataset of its own: its points ``region``, "FIRST:LAST,FIRST:LAST,FIRST:LAST", of which every
        ``stride``-th, "N" or "NX,NY,NZ", is taken."""
        questions.open_dataset(self._connection, v1.OpenDataset(id=self._dataset_id(dataset), region=region, stride=stride))

    def _dataset_id(self, dataset: str) -> str:
        entries = list(self._told.datasets.values())
        return next((e.id for e in entries if e.id == dataset), next((e.id for e in entries if e.name == dataset), dataset))

    def thumbnail(self, dataset: str = "") -> Optional[np.ndarray]:
        """A small picture of what is shown of a dataset first, by name or id, else of the open one: uint8 [144, 192, 3]. None if it has none: it cannot be
        opened, has nothing to show, or is too large to be looked at in passing."""
        wanted = self._dataset_id(dataset) if dataset else self.message.dataset.partition("@")[0]
        data = self._patiently(lambda: self.rest.request("GET", f"datasets/{wanted}/thumbnail")[0])
        return decode_image(data)[:, :, :3] if data else None

    def reload(self) -> None:
        """Shows the open dataset's files as they are now, if they were rewritten (``info.on_disk``); layers, camera and colours stay."""
        questions.reload_dataset(self._connection)

    def on_files(self, listener: Optional[Callable[[Session, v1.DatasetsChanged], None]]) -> None:
        """Called when files that can be opened come, grow, change or go, from another thread, as on_change. What becomes of the open dataset
        is in ``info``, whose ``times`` grow with its series: ``s.wait(lambda s: len(s.info.times) > 10, 600)``. None: no more."""
        self._connection.on_files = listener and (lambda changed: listener(self, changed))

    def histogram(self, array: str = "", bins: int = 256) -> questions.Histogram:
        """Of one array at the state's step; by default of the one that intervals are cut from."""
        return questions.histogram(self._connection, array or self.array, bins)

    # ---- pictures ----------------------------------------------------------------------------------------------------------------

    def png(self, width: int = 0, height: int = 0) -> bytes:
        """The lossless picture of the newest state, as a PNG file's bytes."""
        return self.still("png", width, height)

    def still(self, format: str, width: int = 0, height: int = 0, transparent: bool = False) -> bytes:
        """A picture as a file's bytes: "png", "jpeg" and what else the server knows. transparent: without the background."""
        query = {"width": width or self.size[0], "height": height or self.size[1], "format": format, **({"transparent": "true"} if transparent else {})}
        return self._patiently(lambda: self.rest.request("GET", f"sessions/{self.id}/image", query=query)[0])

    def image(self, width: int = 0, height: int = 0) -> np.ndarray:
        """The lossless picture of the newest state: uint8 [height, width, 3], or 4 if the background is transparent."""
        return decode_image(self.png(width, height))

    def save_image(self, path: str | PathLike[str], width: int = 0, height: int = 0, transparent: bool = False) -> None:
        """As a file; its end says the format. transparent: without the background, of .png and .webp."""
        end = str(path).rpartition(".")[2].lower()
        data = self.still("jpeg" if end == "jpg" else end, width, height, transparent)
        with open(path, "wb") as file:
            file.write(data)

    def show(self, width: int = 0, height: int = 0) -> View:
        """For notebooks: the picture and its layers, drawn anew each time it is displayed."""
        return View(self, width or self.size[0], height or self.size[1])

    def frames(self, count: int | None = None, timeout: float | None = None) -> Iterator[news.Frame]:
        """The frames that the server sends while things change (``connect(..., frames=True)``). Ends after ``count``; raises
        "timeout" where none comes for so long."""
        return news.frames(self._connection, count, timeout)

    def interacting(self, active: bool) -> None:
        """Between True and False frames are quick ones, even if the hand stands still for a moment."""
        self._connection.send(v1.ClientMessage(interaction=v1.Interaction(active=active)))

    def wait(self, holds: Callable[[Session], object], timeout: float | None = None) -> None:
        """Until ``holds(session)``, whoever changes it: ``s.wait(lambda s: s.revision > 7)``."""
        self._connection.wait(lambda: holds(self), "the session did not come to be so in time", timeout)

    def changes(self, count: int | None = None, timeout: float | None = None) -> Iterator[news.Change]:
        """Each change of the state from now on, whoever makes it: ``for change in s.changes(): ...``. Several that come while the loop
        is busy are one. Ends after ``count``; raises "timeout" where none comes for so long."""
        return news.changes(self._connection, self.message, count, timeout)

    def on_change(self, listener: Optional[Callable[[Session], None]]) -> None:
        """Called with this session after each change of its state, from another thread, which may not wait for the server: no calls that
        change or fetch anything. None: no more."""
        self._connection.on_state = listener and (lambda: listener(self))

    def export(self, path: str | PathLike[str], facets: Sequence[str] = ()) -> None:
        """The layers as a mesh file: .vtu or .vtkhdf (tetrahedra), .ply or .stl (their boundary, or of it what ``facets`` names: "lower", "upper",
        "domain"). ``on_progress`` hears of it; Ctrl-C takes the server's work with it."""
        wanted = {"format": str(path).rpartition(".")[2].lower(), **({"facets": list(facets)} if facets else {})}
        made_file(self._connection, self.rest, path, "exports", wanted)

    def film(
        self,
        path: str | PathLike[str],
        turn: float = 0,
        steps: slice | range | None = None,
        seconds: float = 0,
        width: int = 1280,
        height: int = 720,
        fps: float = 30,
        samples: int = 2,
        annotations: Sequence[str] | None = None,
    ) -> None:
        """A film (.webm) of the session as it is now, made by the server, each picture exact: the camera turns by so many degrees about what it looks at, as
        the right hand does about up; or the steps are shown one after the other (``range(0, 40)``, ``slice(None)``: all); or both. seconds: its length, by
        default 6, or a tenth of a second for each step if the camera stands still. annotations: of "axes", "box", "legend"; None: the session's.
        ``on_progress`` hears of it; Ctrl-C takes the server's work with it."""
        if not str(path).lower().endswith(".webm"):
            raise IsostrataError("invalid_argument", f"{path}: expected a name that ends in .webm", "path")
        wanted: dict[str, Any] = {"width": width, "height": height, "turnDeg": turn, "seconds": seconds, "framesPerSecond": fps, "samples": samples}
        if steps is not None:
            shown = range(*steps.indices(len(self.info.times))) if isinstance(steps, slice) else steps
            if not shown:
                raise IsostrataError("invalid_argument", f"steps: {steps} has none", "steps")
            wanted |= {"firstStep": shown[0], "lastStep": shown[-1], "stepStride": abs(shown.step)}
        if annotations is not None:
            wanted["annotations"] = {name: True for name in annotations}
        made_file(self._connection, self.rest, path, "films", wanted)

    def layer_facts(self) -> list[dict[str, Any]]:
        """Of each interval: id, activeCells, tetrahedra, the solid's volume, and volumeError, how far that is estimated to be from the
        volume of the field as the cells interpolate it (0 in tetrahedra, absent if it is not defined)."""
        facts = self._patiently(lambda: self.rest.json("GET", f"sessions/{self.id}/layers")).get("intervals", [])
        return [{**one, "activeCells": int(one.get("activeCells", 0)), "tetrahedra": int(one.get("tetrahedra", 0)),
                 "volume": one.get("volume", 0.0)} for one in facts]

    def statistics(self, array: str = "") -> dict[str, float]:
        """lower, upper, mean, standardDeviation and the like of an array at the state's step."""
        query = {"array": array or self.array}
        return self._patiently(lambda: self.rest.json("GET", f"sessions/{self.id}/statistics", query=query))

    def layer_statistics(self, interval: Any, array: str = "") -> dict[str, Any]:
        """One layer in numbers: ``volume``, ``centroid``, ``pieces`` that do not touch, the volume of the ``largest``, and of an array (none: the shown one) in it
        ``mean``, ``standardDeviation``, ``lower``, ``upper``; ``valued`` is the volume in which it has values. interval: of ``s.intervals``, or its id."""
        number = getattr(interval, "id", interval)
        found = self._patiently(lambda: self.rest.json("GET", f"sessions/{self.id}/intervals/{number}/statistics", query={"array": array or self.array}))
        centre = found.get("centroid")
        numbers = {name: found.get(name, 0.0) for name in ("volume", "largest", "valued")}
        values = {name: found.get(name, 0.0) for name in ("mean", "standardDeviation", "lower", "upper")} if numbers["valued"] else {}
        return {"array": found["array"], "flat": found.get("flat", False), "pieces": int(found.get("pieces", 0)), **numbers, **values,
                "centroid": centre and tuple(centre.get(axis, 0.0) for axis in "xyz")}

    def probe(self, x: float, y: float, width: int = 0, height: int = 0) -> questions.Probe:
        """What lies at a place of the picture of the newest state, from (0, 0), its upper left corner, to (1, 1): ``s.probe(0.5, 0.5).values["distance"]``.
        It is looked up in the data, not in the picture."""
        query = {"x": repr(float(x)), "y": repr(float(y)), "width": width or self.size[0], "height": height or self.size[1]}
        found = self._patiently(lambda: self.rest.json("GET", f"sessions/{self.id}/probe", query=query))
        return questions.probe_of(json_format.ParseDict(found, v1.ProbeResult(), ignore_unknown_fields=True))

    def probe_line(self, start: Sequence[float], end: Sequence[float], array: str = "") -> questions.Curve:
        """The values of an array (none: the shown one) along a line between two points in the dataset's space, at the state's step or time:
        ``c = s.probe_line((0, 0, 0), (1, 0, 0)); plt.plot(c.at, c.values)``."""
        return self._curve("line", {"from": _point(start), "to": _point(end)}, array)

    def probe_steps(self, at: Sequence[float], array: str = "") -> questions.Curve:
        """The values of an array (none: the shown one) at a point over all steps, each of which is read."""
        return self._curve("steps", {"at": _point(at)}, array)

    def _curve(self, along: str, query: dict[str, Any], array: str) -> questions.Curve:
        query["array"] = array or self.array
        found = self._patiently(lambda: self.rest.json("GET", f"sessions/{self.id}/probe/{along}", query=query))
        return questions.curve_of(json_format.ParseDict(found, v1.ProbedCurve(), ignore_unknown_fields=True))

    # ---- long work ----------------------------------------------------------------------------------------------------------------

    def on_progress(self, listener: Optional[Callable[[str, float], None]]) -> None:
        """Called with the stage and a fraction while the server works, from another thread."""
        self._connection.on_progress = listener and (lambda progress: listener(progress.stage, progress.fraction))

    def cancel(self) -> None:
        """Asks the server to give up what it has told progress of."""
        progress = self._told.progress
        if progress is not None:
            self._connection.send(v1.ClientMessage(cancel=v1.Cancel(operation=progress.operation)))

    # ---- the whole state --------------------------------------------------------------------------------------------------------

    def save_state(self, path: str | PathLike[str] | None = None) -> dict[str, Any]:
        """The whole state as one JSON document, and to a file if one is named."""
        state = self.state
        if path is not None:
            with open(path, "w", encoding="utf-8") as file:
                json.dump(state, file, indent=2)
        return state

    def load_state(self, state: Union[dict[str, Any], str, PathLike[str]]) -> None:
        """What save_state gave, or the file's name."""
        if not isinstance(state, dict):
            with open(state, encoding="utf-8") as file:
                state = json.load(file)
        answer = self._patiently(lambda: self.rest.json("PUT", f"sessions/{self.id}/state", state))
        wanted = int(answer["revision"])
        self._connection.wait(lambda: self.revision >= wanted, "the server did not tell the new state")

    # ---- the wire -----------------------------------------------------------------------------------------------------------------

    def _patiently(self, request: Callable[[], Any]) -> Any:
        return patiently(self._connection, request)

    def command(self, **body: Any) -> None:
        """One message of the protocol: ``command(set_view=v1.SetView(view="+x"))``."""
        self._connection.command(v1.ClientMessage(**body))


def document(state: v1.State) -> dict[str, Any]:
    """With every member, also those that have their default; protobuf 5.26 gave the switch another name."""
    names = inspect.signature(json_format.MessageToDict).parameters
    new = "always_print_fields_with_no_presence"
    return json_format.MessageToDict(state, **{new if new in names else "including_default_value_fields": True})
