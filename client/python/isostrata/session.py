"""A session of a server: what is shown, and pictures of it."""

from __future__ import annotations

import inspect
import json
import ssl
import time
from dataclasses import dataclass
from os import PathLike
from typing import Any, Callable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
from google.protobuf import json_format

from .address import Address, tls_context
from .connection import Connection, ConnectionEvent
from .errors import IsostrataError
from .intervals import Intervals
from .picture import decode_image
from .rest import Rest
from .scene import Camera, Color, Point, Term, rgb, to_points, vec3
from .show import View
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


@dataclass(frozen=True)
class Histogram:
    """Of the finite values of one array, as numpy.histogram gives it."""

    array: str
    counts: np.ndarray  # [bins] uint64
    edges: np.ndarray  # [bins + 1] float64


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


def connect(
    url: str,
    dataset: str = "",
    *,
    session: str = "",
    resume_token: str = "",
    token: str = "",
    size: Tuple[int, int] = (800, 600),
    frames: bool = False,
    timeout: float = 60.0,
    reconnect: float = 30.0,
    on_connection: Optional[Callable[[ConnectionEvent], None]] = None,
    ca_file: str = "",
    insecure: bool = False,
    ssl_context: ssl.SSLContext | None = None,
) -> Session:
    """Connects to the address that the server printed. A session of its own, or one that others look at (``session``, its id, as
    ``sessions()`` lists them). ``size`` is that of frames and of ``image()``; frames are sent only where ``frames`` is set.

    A connection that is lost is tried again for ``reconnect`` seconds, and calls go on as if nothing had been; ``on_connection`` hears
    of it, from another thread. Of https certificates, those of ``ca_file`` (PEM) are trusted in place of the system's, or with
    ``insecure`` all; ``ssl_context`` says all of that and more. Raises IsostrataError."""
    address = Address.parse(url, token)
    context = tls_context(address, ssl_context, ca_file, insecure)
    rest = Rest(address, timeout, context)
    if session:
        resume_token = rest.json("GET", f"sessions/{session}")["resumeToken"]
    hello = v1.Hello(
        protocol_major=1,
        client="isostrata-python",
        viewport=v1.Viewport(width=size[0], height=size[1], hidden=not frames),
        still_formats=["png"],
        moving_formats=["jpeg"],
        resume_token=resume_token,
    )

    def bring_back(session: str, state: v1.State) -> None:
        rest.json("PUT", f"sessions/{session}/state", _document(state))

    connection = Connection(
        address,
        hello,
        timeout,
        context=context,
        reconnect=reconnect,
        joined=bool(resume_token),
        bring_back=bring_back,
        on_event=on_connection,
    )
    made = Session(connection, rest, size)
    if resume_token and made._connection.welcome.resume_token != resume_token:
        made.close()
        raise IsostrataError("not_found", "the session to join is not there any more")
    try:
        if dataset:
            made.open(dataset)
    except BaseException:
        made.close()
        raise
    return made


def sessions(
    url: str,
    *,
    token: str = "",
    timeout: float = 60.0,
    ca_file: str = "",
    insecure: bool = False,
    ssl_context: ssl.SSLContext | None = None,
) -> List[dict]:
    """Those that live on the server: id, dataset, revision, viewers, resumeToken of each."""
    address = Address.parse(url, token)
    return Rest(address, timeout, tls_context(address, ssl_context, ca_file, insecure)).json("GET", "sessions")["sessions"]


class Session:
    """Made by ``connect``. Calls return when the server has done what they ask, and raise IsostrataError where it refused; then
    nothing has changed. Others may change the same session: what is read here is the newest that the server has told."""

    def __init__(self, connection: Connection, rest: Rest, size: Tuple[int, int]) -> None:
        self._connection = connection
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
        return self._connection.welcome.session

    @property
    def resume_token(self) -> str:
        return self._connection.welcome.resume_token

    @property
    def server(self) -> str:
        return self._connection.welcome.server

    @property
    def device(self) -> str:
        return self._connection.welcome.device

    @property
    def datasets(self) -> List[str]:
        """The names of what can be opened, of more than 1000 the first; files that come later are among them."""
        return [entry.name for entry in list(self._connection.datasets.values()) if entry.news != v1.DATASET_NEWS_GONE]

    def list_datasets(self, folder: str = "", search: str = "", first: int = 0, most: int = 1000) -> v1.DatasetList:
        """What lies in a folder, or below it what has the words of ``search`` in its name: folders, and datasets with kind, bytes, time of
        change, steps and news; what was passed over, and why."""
        wanted = v1.ListDatasets(folder=folder, search=search, first=first, most=most)
        found: List[v1.DatasetList] = []

        def listed() -> bool:
            answer = self._connection.take_answer(
                "dataset_list", lambda a: (a.dataset_list.folder, a.dataset_list.search, a.dataset_list.first) == (folder.rstrip("/"), search, first)
            )
            if answer:
                found.append(answer.dataset_list)
            return bool(found)

        self._connection.ask(v1.ClientMessage(list_datasets=wanted), listed, "the server did not list its datasets")
        return found[0]

    @property
    def color_maps(self) -> List[str]:
        return list(self._connection.welcome.color_maps)

    @property
    def info(self) -> v1.DatasetInfo:
        """Of the open dataset: grid, cells, arrays, times, ..."""
        return self._connection.dataset

    @property
    def arrays(self) -> dict[str, Tuple[float, float]]:
        """The open dataset's arrays and their ranges."""
        return {array.name: (array.lower, array.upper) for array in self.info.arrays}

    @property
    def message(self) -> v1.State:
        """The newest state, as the protocol's message."""
        return self._connection.state

    @property
    def state(self) -> dict[str, Any]:
        """The newest state, as save_state writes it."""
        return _document(self.message)

    @property
    def revision(self) -> int:
        return self.message.revision

    # ---- data ------------------------------------------------------------------------------------------------------------------

    def open(self, dataset: str, region: str = "", stride: str = "") -> None:
        """By name or id; waits until it is open.

        Of a structured grid a part can be opened, which is a dataset of its own: its points ``region``, "FIRST:LAST,FIRST:LAST,FIRST:LAST", of which every
        ``stride``-th, "N" or "NX,NY,NZ", is taken."""
        wanted = self._dataset_id(dataset)
        part = bool(region or stride)
        if not part and self.message.dataset == wanted and self.info.id == wanted:
            return
        session = self.id
        seq = self._connection.send(v1.ClientMessage(open_dataset=v1.OpenDataset(id=wanted, region=region, stride=stride)))
        whole = wanted.partition("@")[0]

        def is_it(opened: str) -> bool:  # a part has its text behind the id, as the server writes it
            return opened == wanted or (part and opened.startswith(whole + "@"))

        def is_open() -> bool:
            self._connection._refuse(seq)
            # Not before it has been read: a newcomer's session opens a dataset by itself, and what was asked for would come later.
            heeded = self.id != session or self._connection.heeded >= seq
            return is_it(self.info.id) and self.message.dataset == self.info.id and heeded

        self._connection.wait(is_open, f"dataset {wanted!r} was not open in time")

    def _dataset_id(self, dataset: str) -> str:
        entries = list(self._connection.datasets.values())
        return next((e.id for e in entries if e.id == dataset), next((e.id for e in entries if e.name == dataset), dataset))

    def thumbnail(self, dataset: str = "") -> Optional[np.ndarray]:
        """A small picture of what is shown of a dataset first, by name or id, else of the open one: uint8 [144, 192, 3]. None if it has none: it cannot be
        opened, has nothing to show, or is too large to be looked at in passing."""
        wanted = self._dataset_id(dataset) if dataset else self.message.dataset.partition("@")[0]
        data = self._patiently(lambda: self.rest.request("GET", f"datasets/{wanted}/thumbnail")[0])
        return decode_image(data)[:, :, :3] if data else None

    def reload(self) -> None:
        """Shows the open dataset's files as they are now, if they were rewritten (``info.on_disk``); layers, camera and colours stay."""
        seq = self._connection.send(v1.ClientMessage(reload_dataset=v1.ReloadDataset()))

        def is_read() -> bool:
            self._connection._refuse(seq)
            return self._connection.heeded >= seq and self.info.on_disk != v1.ON_DISK_CHANGED

        self._connection.wait(is_read, "the dataset was not read again in time")

    def on_files(self, listener: Optional[Callable[[Session, v1.DatasetsChanged], None]]) -> None:
        """Called when files that can be opened come, grow, change or go, from another thread, as on_change. What becomes of the open dataset
        is in ``info``, whose ``times`` grow with its series: ``s.wait(lambda s: len(s.info.times) > 10, 600)``. None: no more."""
        self._connection.on_files = listener and (lambda changed: listener(self, changed))

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

    def histogram(self, array: str = "", bins: int = 256) -> Histogram:
        """Of one array at the state's step; by default of the one that intervals are cut from."""
        wanted = array or self.array
        found: List[v1.ServerMessage] = []

        def counted() -> bool:
            answer = self._connection.take_answer("histogram", lambda a: a.histogram.array == wanted and len(a.histogram.counts) == bins)
            if answer:
                found.append(answer)
            return bool(found)

        question = v1.ClientMessage(request_histogram=v1.RequestHistogram(array=wanted, bins=bins))
        self._connection.ask(question, counted, "no histogram came in time")
        histogram = found[0].histogram
        edges = np.linspace(histogram.lower, histogram.upper, len(histogram.counts) + 1)
        return Histogram(wanted, np.array(histogram.counts, np.uint64), edges)

    # ---- looks -------------------------------------------------------------------------------------------------------------------

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
    ) -> None:
        """Changes what is given. ``occlusion`` and ``depth_fade``, in [0, 1]: how dark hollows are, how far what is far away fades. ``mode``: "sorted", "prioritized", "cycled", "smear". ``color_range``: over what colour maps run, the values of
        "step" or of "all_steps", or two numbers; ``color_log``: by the logarithm."""
        look = v1.SetAppearance()
        if mode is not None:
            look.mode = _choice(_MODES, mode, "mode")
        if background is not None:
            look.background.CopyFrom(rgb(background))
        if unit_distance is not None:
            look.unit_distance = unit_distance
        if occlusion is not None:
            look.occlusion = occlusion
        if depth_fade is not None:
            look.depth_fade = depth_fade
        if color_range is not None or color_log is not None:
            look.color_range.CopyFrom(self.message.color_range)
        if isinstance(color_range, str):
            look.color_range.CopyFrom(v1.ColorRange(span=_choice(_SPANS, color_range, "color_range"), log=look.color_range.log))
        elif color_range is not None:
            lower, upper = color_range
            look.color_range.MergeFrom(v1.ColorRange(span=v1.COLOR_SPAN_OWN))
            look.color_range.lower, look.color_range.upper = lower, upper
        if color_log is not None:
            look.color_range.log = color_log
        if look.ByteSize():
            self.command(set_appearance=look)

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

    # ---- pictures ----------------------------------------------------------------------------------------------------------------

    def png(self, width: int = 0, height: int = 0) -> bytes:
        """The lossless picture of the newest state, as a PNG file's bytes."""
        return self.still("png", width, height)

    def still(self, format: str, width: int = 0, height: int = 0) -> bytes:
        """A picture as a file's bytes: "png", "jpeg" and what else the server knows."""
        query = {"width": width or self.size[0], "height": height or self.size[1], "format": format}
        return self._patiently(lambda: self.rest.request("GET", f"sessions/{self.id}/image", query=query)[0])

    def image(self, width: int = 0, height: int = 0) -> np.ndarray:
        """The lossless picture of the newest state: uint8 [height, width, 3], or 4 if the background is transparent."""
        return decode_image(self.png(width, height))

    def save_image(self, path: str | PathLike[str], width: int = 0, height: int = 0) -> None:
        """As a file; its end says the format."""
        end = str(path).rpartition(".")[2].lower()
        data = self.still("jpeg" if end == "jpg" else end, width, height)
        with open(path, "wb") as file:
            file.write(data)

    def show(self, width: int = 0, height: int = 0) -> View:
        """For notebooks: the picture and its layers, drawn anew each time it is displayed."""
        return View(self, width or self.size[0], height or self.size[1])

    def frames(self, count: int | None = None, timeout: float | None = None) -> Iterator[Frame]:
        """The frames that the server sends while things change (``connect(..., frames=True)``). Ends after ``count``; raises
        "timeout" where none comes for so long."""
        given = 0
        while count is None or given < count:
            taken: List[v1.Frame] = []

            def came() -> bool:
                frame = self._connection.take_frame()
                if frame is not None:
                    taken.append(frame)
                return bool(taken)

            self._connection.wait(came, "no frame came in time", timeout)
            f = taken[0]
            given += 1
            yield Frame(f.frame_id, f.revision, f.phase == v1.FRAME_PHASE_LOSSLESS, f.width, f.height, f.format, f.payload, f)

    def interacting(self, active: bool) -> None:
        """Between True and False frames are quick ones, even if the hand stands still for a moment."""
        self._connection.send(v1.ClientMessage(interaction=v1.Interaction(active=active)))

    def wait(self, holds: Callable[[Session], object], timeout: float | None = None) -> None:
        """Until ``holds(session)``, whoever changes it: ``s.wait(lambda s: s.revision > 7)``."""
        self._connection.wait(lambda: holds(self), "the session did not come to be so in time", timeout)

    def changes(self, count: int | None = None, timeout: float | None = None) -> Iterator[Change]:
        """Each change of the state from now on, whoever makes it: ``for change in s.changes(): ...``. Several that come while the loop
        is busy are one. Ends after ``count``; raises "timeout" where none comes for so long."""
        return self._changes(self._connection.state, count, timeout)

    def _changes(self, shown: v1.State, count: int | None, timeout: float | None) -> Iterator[Change]:
        connection, given = self._connection, 0
        while count is None or given < count:
            connection.wait(lambda: connection.state is not shown, "the session did not change in time", timeout)
            before, shown = shown, connection.state
            old, new = ({field.name: value for field, value in state.ListFields()} for state in (before, shown))
            fields = frozenset(name for name in old.keys() | new.keys() if old.get(name) != new.get(name))
            if fields:
                given += 1
                yield Change(shown.revision, fields - {"revision"}, shown)

    def on_change(self, listener: Optional[Callable[[Session], None]]) -> None:
        """Called with this session after each change of its state, from another thread, which may not wait for the server: no calls that
        change or fetch anything. None: no more."""
        self._connection.on_state = listener and (lambda: listener(self))

    def export(self, path: str | PathLike[str], facets: Sequence[str] = ()) -> None:
        """The layers as a mesh file: .vtu or .vtkhdf (tetrahedra), .ply or .stl (their boundary, or of it what ``facets`` names: "lower", "upper",
        "domain"). ``on_progress`` hears of it; Ctrl-C takes the server's work with it."""
        wanted = {"format": str(path).rpartition(".")[2].lower(), **({"facets": list(facets)} if facets else {})}
        session, made = self.id, self._connection.made
        operation = self._patiently(lambda: self.rest.json("POST", f"sessions/{self.id}/exports", wanted))
        where = f"sessions/{session}/operations/{operation['id']}"
        try:
            pause = 0.02
            while operation["status"] == "running":
                time.sleep(pause)
                pause = min(2 * pause, 0.5)
                operation = self._patiently(lambda: self.rest.json("GET", where))
                if self._connection.on_progress:
                    self._connection.on_progress(v1.Progress(stage=operation["stage"], fraction=operation["fraction"]))
            if operation["status"] != "done":
                error = operation.get("error", {})
                raise IsostrataError(error.get("code", "internal"), error.get("detail", "the export failed"), error.get("field", ""))
            data = self.rest.request("GET", f"sessions/{session}/exports/{operation['id']}")[0]
            with open(path, "wb") as file:
                file.write(data)
        except IsostrataError as lost:
            if lost.code == "not_found" and self._connection.made != made:
                raise IsostrataError("interrupted", "the server that wrote the export is gone; ask again") from None
            raise
        finally:
            try:
                self.rest.request("DELETE", where)  # cancels it, or forgets it and its file
            except IsostrataError:
                pass

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

    # ---- long work ----------------------------------------------------------------------------------------------------------------

    def on_progress(self, listener: Optional[Callable[[str, float], None]]) -> None:
        """Called with the stage and a fraction while the server works, from another thread."""
        self._connection.on_progress = listener and (lambda progress: listener(progress.stage, progress.fraction))

    def cancel(self) -> None:
        """Asks the server to give up what it has told progress of."""
        progress = self._connection.progress
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
        """A request has a connection of its own; it is tried as long as the session's would be."""
        end, pause = time.monotonic() + self._connection.reconnect, 0.05
        while True:
            try:
                return request()
            except IsostrataError as lost:
                # A server that came back without the session does not have it under its old name.
                passing = lost.code == "connection" or (lost.code == "not_found" and not self._connection._up)
                if not passing or time.monotonic() >= end or self._connection._failure:
                    raise
            time.sleep(pause)
            pause = min(2 * pause, 1.0)

    def command(self, **body: Any) -> None:
        """One message of the protocol: ``command(set_view=v1.SetView(view="+x"))``."""
        self._connection.command(v1.ClientMessage(**body))


def _document(state: v1.State) -> dict[str, Any]:
    """With every member, also those that have their default; protobuf 5.26 gave the switch another name."""
    names = inspect.signature(json_format.MessageToDict).parameters
    new = "always_print_fields_with_no_presence"
    return json_format.MessageToDict(state, **{new if new in names else "including_default_value_fields": True})


def _choice(known: dict[str, int], given: str, field: str) -> int:
    if given not in known:
        expected = ", ".join(name for name in known if name)
        raise IsostrataError("invalid_argument", f"{field} {given!r} is not known; expected one of {expected}", field)
    return known[given]
