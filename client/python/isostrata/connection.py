"""One session's WebSocket, served by a thread of its own so that notebooks and scripts may block, sleep or compute as they like: pings
are answered, frames acknowledged and the newest state kept meanwhile. A connection that is lost is made again, to the same session;
what waits for an answer goes on waiting."""

from __future__ import annotations

import asyncio
import ssl
import threading
import time
import traceback
import uuid
from collections import deque
from dataclasses import dataclass
from typing import Any, Callable, Deque, Dict, List, Optional

from google.protobuf.message import DecodeError

from .address import Address
from .errors import IsostrataError
from .rest import untrusted
from .sent import Sent
from .v1 import isostrata_pb2 as v1
from .web_socket import ConnectionClosed, Refused, WebSocketException, close_code, connect, is_open

_MAX_MESSAGE = 512 << 20  # a lossless frame of the largest size
_KEPT_FRAMES = 8  # that nobody has asked for yet; older ones are forgotten
_LONGEST_PAUSE = 2.0  # seconds between two tries
_FINAL = (1002, 1008)  # goodbyes of a server that will say the same again: a broken protocol, an invitation taken back


@dataclass(frozen=True)
class ConnectionEvent:
    """What has become of a connection: "lost", then "restored" or "given_up"."""

    kind: str
    reason: str = ""  # of lost and given_up
    resent: int = 0  # of restored: commands that the server had not done, and was sent again
    new_session: bool = False  # of restored: the server no longer had the session; what it showed was brought to a new one


class _Lost(Exception):
    """The way there is at fault, which may be better in a moment."""


class Connection:
    """Thread-safe: everything that both threads touch is under ``_changed``, which also tells of news."""

    def __init__(
        self,
        address: Address,
        hello: v1.Hello,
        timeout: float,
        *,
        context: ssl.SSLContext | None = None,
        reconnect: float = 0.0,
        joined: bool = False,
        bring_back: Callable[[str, v1.State], None] | None = None,
        on_event: Callable[[ConnectionEvent], None] | None = None,
    ) -> None:
        """``reconnect``: seconds that a lost connection is tried again. ``joined``: the session is somebody else's, so without it there
        is nothing to go on with. ``bring_back`` makes the session of this id show a state."""
        self.timeout = timeout
        self.reconnect = reconnect
        self.welcome: Optional[v1.Welcome] = None
        self.state = v1.State()
        self.dataset = v1.DatasetInfo()
        self.progress: Optional[v1.Progress] = None
        self.on_progress: Optional[Callable[[v1.Progress], None]] = None
        self.on_state: Optional[Callable[[], None]] = None
        self.on_files: Optional[Callable[[v1.DatasetsChanged], None]] = None
        self.datasets: Dict[str, v1.DatasetEntry] = {}  # by id, the first of what can be opened
        self.heeded = 0  # the newest message of ours that a State has answered
        self.on_event = on_event
        self.made = 0  # how often the connection has been made
        self._address = address
        self._hello = hello
        self._hello.client_id = uuid.uuid4().hex
        self._context = context
        self._joined = joined
        self._bring_back = bring_back
        self._session = ""
        self._changed = threading.Condition()
        self._frames: Deque[v1.Frame] = deque(maxlen=_KEPT_FRAMES)
        self._answers: Deque[v1.ServerMessage] = deque(maxlen=256)  # errors, pongs, histograms
        self._failure: Optional[IsostrataError] = None
        self._sent = Sent()
        self._pings: Deque[tuple[float, int]] = deque(maxlen=4096)  # without an answer, and their numbers
        self._mark = 0
        self._unmarked = 0  # commands since the last ping
        self._interacting = False
        self._up = False  # what is queued goes out
        self._opening = ""  # a dataset that is opened once more after a loss
        self._known = 0  # the newest revision that was told before Welcome
        self._last_words = ""
        self._for_good = False  # the server has said that it does not come back
        self._closing = False
        self._loop = asyncio.new_event_loop()
        self._socket: Any = None  # of web_socket.connect
        self._serving = self._loop.create_task(self._serve())
        self._thread = threading.Thread(target=self._run, name="isostrata", daemon=True)
        self._thread.start()
        try:
            self.wait(lambda: self.made, "the server did not answer Hello")
        except BaseException:
            self.close()
            raise

    # ---- the caller's side ---------------------------------------------------------------------------------------------------

    def send(self, message: v1.ClientMessage) -> int:
        """Does not wait. The message's number, which grows over all connections."""
        with self._changed:
            return self._queue(message)

    def command(self, message: v1.ClientMessage) -> None:
        """Sends, and waits until the server has done it or refused it, which raises."""
        with self._changed:
            self._mark += 1
            mark = float(self._mark)
            seq = self._queue(message)

        def judged() -> bool:
            self._refuse(seq)
            if self._opening:  # commands that follow a dataset wait for it in the server, and pings do not
                return False
            return any(a.WhichOneof("body") == "pong" and a.pong.client_time_ms == mark for a in self._answers)

        # Messages are answered in order: when the ping is answered, the command has been judged.
        self.ask(v1.ClientMessage(ping=v1.Ping(client_time_ms=mark)), judged, "the server did not answer a command")

    def ask(self, question: v1.ClientMessage, answered: Callable[[], object], late: str) -> None:
        """Puts a question and waits for its answer; a lost connection makes it be put again."""
        put = [0, 0]  # for which connection, with which number

        def holds() -> object:
            if put[0] != self.made:
                again = v1.ClientMessage()
                again.CopyFrom(question)
                put[:] = self.made, self._queue(again)
            self._refuse(put[1])
            return answered()

        self.wait(holds, late)

    def wait(self, holds: Callable[[], object], late: str, timeout: Optional[float] = None) -> None:
        """Until ``holds()``, which is asked under the lock after each message. Progress begins the timeout anew, and so does a
        connection that is back; while it is being tried again the time stands still."""
        if threading.current_thread() is self._thread:
            raise IsostrataError("invalid_argument", "a listener may not wait for the server: it is called by the thread that listens to it")
        limit = self.timeout if timeout is None else timeout
        with self._changed:
            end, heard = time.monotonic() + limit, (self.progress, self.made)
            while not holds():
                if self._failure:
                    raise self._failure
                if (self.progress, self.made) != heard or (self.made and not self._up):
                    end, heard = time.monotonic() + limit, (self.progress, self.made)
                left = end - time.monotonic()
                if left <= 0:
                    raise IsostrataError("timeout", late)
                self._changed.wait(min(left, 1.0))  # not for ever, so that Ctrl-C is heard everywhere

    def refused(self, seq: int) -> None:
        """Raises if the server has refused this message."""
        with self._changed:
            self._refuse(seq)

    def take_answer(self, kind: str, fits: Callable[[v1.ServerMessage], bool]) -> Optional[v1.ServerMessage]:
        with self._changed:
            for answer in self._answers:
                if answer.WhichOneof("body") == kind and fits(answer):
                    self._answers.remove(answer)
                    return answer
            return None

    def take_frame(self) -> Optional[v1.Frame]:
        with self._changed:
            return self._frames.popleft() if self._frames else None

    def close(self) -> None:
        self._closing = True
        if not self._thread.is_alive():
            return

        try:
            self._loop.call_soon_threadsafe(lambda: self._loop.create_task(self._end()))
        except RuntimeError:
            return  # it has ended meanwhile
        if threading.current_thread() is not self._thread:
            self._thread.join(5)

    # ---- under the lock ------------------------------------------------------------------------------------------------------

    def _queue(self, message: v1.ClientMessage) -> int:
        """Numbered and queued under one lock, so that numbers rise on the wire whichever thread sends. What is queued while there is no
        connection is a command that will be sent again, or a question that will be asked again."""
        if self._failure:
            raise self._failure
        kind = message.WhichOneof("body")
        if kind == "interaction":
            self._interacting = message.interaction.active
        number = self._sent.note(message)
        if kind == "ping":
            self._pings.append((message.ping.client_time_ms, number))
            self._unmarked = 0
        elif message.command:
            self._unmarked += 1
        if self._up:
            self._put(self._sent.put(message, number))
        if self._unmarked >= 64:  # whoever only ever sends learns so what has come
            self._mark += 1
            self._queue(v1.ClientMessage(ping=v1.Ping(client_time_ms=-self._mark)))
        return number

    def _put(self, data: bytes) -> None:
        self._loop.call_soon_threadsafe(self._write, self._socket, data)

    def _refuse(self, seq: int) -> None:
        for answer in self._answers:
            if answer.WhichOneof("body") == "error" and answer.error.in_reply_to == seq:
                self._answers.remove(answer)
                raise IsostrataError(answer.error.code, answer.error.message, answer.error.field)

    # ---- the thread's side -----------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        failure = IsostrataError("closed", "the connection has been closed")
        try:
            self._loop.run_until_complete(self._serving)
        except IsostrataError as wrong:
            failure = wrong
        except asyncio.CancelledError:
            pass
        finally:
            with self._changed:
                self._up = False
                self._failure = self._failure or failure
                self._changed.notify_all()
            self._loop.run_until_complete(self._tidy())
            self._loop.close()

    async def _end(self) -> None:
        if self._socket is not None and is_open(self._socket):
            await self._socket.close()
        self._serving.cancel()

    async def _tidy(self) -> None:
        rest = asyncio.all_tasks() - {asyncio.current_task()}  # what was to be sent
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)
        await self._loop.shutdown_asyncgens()

    async def _serve(self) -> None:
        """Connects, and again after each loss, until there is nothing more to hope for."""
        while True:
            try:
                await self._connect_once()
                why = self._last_words or "the connection has been closed"
            except _Lost as lost:
                if not self.made:
                    raise IsostrataError("connection", str(lost)) from None
                why = str(lost)
            self._check_closing()
            with self._changed:
                self._up = False
            if self.reconnect <= 0 or self._for_good:
                raise IsostrataError("closed", f"the server ended the connection: {why}")
            self._tell(ConnectionEvent("lost", why))
            await self._come_back(why)

    def _check_closing(self) -> None:
        """After whatever may take a cancellation for its own: asyncio.wait_for forgets one that meets the end of what it waits for."""
        if self._closing:
            raise IsostrataError("closed", "the connection has been closed")

    async def _come_back(self, why: str) -> None:
        made, pause, last = self.made, 0.0, why
        end = time.monotonic() + self.reconnect
        try:
            while True:
                self._check_closing()
                await asyncio.sleep(min(pause, max(0.0, end - time.monotonic())))
                if time.monotonic() >= end:
                    raise IsostrataError(
                        "closed", f"the connection was lost ({why}) and could not be made again in {self.reconnect:g} s: {last}"
                    )
                pause = min(max(0.05, 2 * pause), _LONGEST_PAUSE)
                try:
                    self._last_words = ""
                    await self._connect_once()
                    last = self._last_words or "the connection has been closed"
                except _Lost as lost:
                    last = str(lost)
                if self.made > made:  # it was back, and has been lost once more
                    if self._closing or self._for_good:
                        raise IsostrataError("closed", f"the server ended the connection: {last}")
                    with self._changed:
                        self._up = False
                    self._tell(ConnectionEvent("lost", last))
                    made, pause, why = self.made, 0.0, last
                    end = time.monotonic() + self.reconnect
        except IsostrataError as given_up:
            if not self._closing:
                self._tell(ConnectionEvent("given_up", str(given_up)))
            raise

    async def _connect_once(self) -> None:
        """One connection, to its end. Raises _Lost if it may be tried again."""
        host = self._address.host
        try:
            socket = await connect(
                self._address.socket, "isostrata.v1", self._address.headers, self._context, self.timeout, _MAX_MESSAGE, self._address.unix
            )
        except Refused as refused:
            if refused.status == 401:
                raise IsostrataError(
                    "unauthorized", f"{host}: a token is needed; use the address that the server printed"
                ) from None
            raise _Lost(f"{host}: {refused}") from None
        except ssl.SSLCertVerificationError as why:
            raise untrusted(self._address, why) from None
        except (OSError, EOFError, WebSocketException, asyncio.TimeoutError) as wrong:
            raise _Lost(f"{host}: {wrong or type(wrong).__name__}") from None
        try:
            self._check_closing()
            with self._changed:
                self._socket = socket
                self._sent.new_connection()
                self._pings.clear()
                hello = v1.ClientMessage(hello=self._hello)
                first = self._sent.put(hello)
            await socket.send(first)
            await self._listen(socket)
        except ConnectionClosed as closed:
            self._for_good = self._for_good or close_code(closed) in _FINAL
            # What was refused long ago is no reason; what was said with a goodbye is.
            raise _Lost((closed.rcvd and (self._last_words or closed.rcvd.reason)) or str(closed)) from None
        finally:
            await socket.close()

    async def _listen(self, socket: Any) -> None:
        early: Optional[List[v1.ServerMessage]] = []  # until the session is awake
        async for data in socket:
            message = v1.ServerMessage()
            try:
                message.ParseFromString(data if isinstance(data, bytes) else data.encode())
            except DecodeError:
                continue
            kind = message.WhichOneof("body")
            if kind == "frame":
                # The picture has arrived: that is what the acknowledgement is to prove, whoever looks at it and when.
                with self._changed:
                    ack = v1.ClientMessage(frame_ack=v1.FrameAck(frame_id=message.frame.frame_id))
                    self._put(self._sent.put(ack))
            if early is None:
                self._hear(message)
                continue
            if not early and kind == "error":
                if message.error.code == "unavailable" and self.made:
                    raise _Lost(message.error.message)
                raise IsostrataError(message.error.code, message.error.message, message.error.field)
            early.append(message)
            if early[0].WhichOneof("body") != "welcome":
                continue
            # A session that sleeps since a restart has a state, and its dataset only in a moment: commands would wait, and questions
            # be refused.
            welcome = early[0].welcome
            awake = not welcome.state.dataset or welcome.HasField("dataset_info") or kind in ("dataset_info", "error")
            if awake:
                await self._arrive(welcome)
                for each in early:
                    self._hear(each)
                early = None
                self._back(welcome)

    async def _arrive(self, welcome: v1.Welcome) -> None:
        """Nobody else is there when the server has forgotten the session, and what was shown here is known: a new session begins with it."""
        if not self.made:
            self._joined = self._joined or not welcome.resume_token
        elif welcome.session != self._session:
            if self._joined:
                raise IsostrataError("session_lost", f"the server came back without session {self._session}")
            if self.state.dataset and self._bring_back:
                try:
                    await self._loop.run_in_executor(None, self._bring_back, welcome.session, self.state)
                except IsostrataError as refused:
                    if refused.code in ("connection", "timeout"):
                        raise _Lost(str(refused)) from None
                    raise IsostrataError(
                        "session_lost", f"the server came back without session {self._session}, and refuses what it showed: {refused}"
                    ) from None
        if welcome.resume_token:
            self._hello.resume_token = welcome.resume_token

    def _back(self, welcome: v1.Welcome) -> None:
        """From here on what is queued goes out; first what the server has not judged."""
        with self._changed:
            same = welcome.session == self._session
            again, unheard = self._sent.again(welcome.last_command, same, same and welcome.state.revision < self._known)
            if unheard and welcome.HasField("last_command_error"):
                verdict = v1.ServerMessage(error=welcome.last_command_error)
                verdict.error.in_reply_to = unheard
                self._answers.append(verdict)
            self._opening = self._sent.opening() if again and self.state.dataset != self._sent.opening() else ""
            for data in again:
                self._put(data)
            if self._interacting:
                self._put(self._sent.put(v1.ClientMessage(interaction=v1.Interaction(active=True))))
            self._up = True
            self._session = welcome.session
            self._known = self.state.revision
            self.made += 1
            first = self.made == 1
            self._changed.notify_all()
        if not first:
            self._tell(ConnectionEvent("restored", "", len(again), not same))

    def _tell(self, event: ConnectionEvent) -> None:
        with self._changed:
            self._changed.notify_all()
        if self.on_event:
            _call(self.on_event, event)

    def _write(self, socket: Any, data: bytes) -> None:
        if is_open(socket):
            # Tasks start in the order they are made, and writes are in the order of their tasks.
            self._loop.create_task(_send(socket, data))

    def _hear(self, message: v1.ServerMessage) -> None:
        kind = message.WhichOneof("body")
        progress = changed = files = None
        with self._changed:
            if kind == "welcome":
                self.state = message.welcome.state
                self.dataset = message.welcome.dataset_info
                self.welcome = message.welcome
                self.datasets = {entry.id: entry for entry in message.welcome.datasets}
                changed = self.on_state
            elif kind == "state":
                # One that answers a command which changed nothing is no news.
                changed = self.on_state if message.state.revision != self.state.revision else None
                self.state = message.state
                self.heeded = self._sent.number_of(message.heeded)
                if self.state.dataset == self._opening:
                    self._opening = ""
                if self._up:
                    self._known = message.state.revision
            elif kind == "dataset_info":
                self.dataset = message.dataset_info
            elif kind == "datasets_changed":
                for entry in message.datasets_changed.entries:
                    self.datasets[entry.id] = entry
                files = self.on_files
            elif kind == "frame":
                message.frame.input_seq = self._sent.number_of(message.frame.input_seq)
                self._sent.judged(message.frame.input_seq)
                self._frames.append(message.frame)
            elif kind == "progress":
                self.progress = message.progress
                progress = self.on_progress
            elif kind == "done":
                self.progress = None
            elif kind == "shutdown":
                self._last_words = message.shutdown.reason
                if not message.shutdown.notice:
                    self._for_good = not message.shutdown.comes_back
            elif kind == "pong":
                self._pong(message)
            elif kind is not None:
                if kind == "error":
                    self._opening = ""
                    self._last_words = message.error.message
                    message.error.in_reply_to = self._sent.number_of(message.error.in_reply_to, exact=True)
                self._answers.append(message)
            self._changed.notify_all()
        if progress:
            _call(progress, message.progress)
        if changed:
            _call(changed)
        if files:
            _call(files, message.datasets_changed)

    def _pong(self, message: v1.ServerMessage) -> None:
        mark = message.pong.client_time_ms
        if all(mark != sent for sent, _ in self._pings):
            return
        while self._pings:
            sent, number = self._pings.popleft()  # they are answered in order
            self._sent.judged(number)
            if sent == mark:
                break
        if mark > 0:
            self._answers.append(message)


def _call(listener: Callable[..., None], *what: object) -> None:
    """What a listener gets wrong is its own affair, and the connection goes on."""
    try:
        listener(*what)
    except Exception:
        traceback.print_exc()


async def _send(socket: Any, data: bytes) -> None:
    try:
        await socket.send(data)
    except ConnectionClosed:
        pass  # the reader says so
