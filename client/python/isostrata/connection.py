"""One session, as the caller's thread and that of the WebSocket share it: notebooks and scripts may block, sleep or compute as they like,
pings are answered, frames acknowledged and the newest state kept meanwhile. A connection that is lost is made again, to the same session;
what waits for an answer goes on waiting."""

from __future__ import annotations

import ssl
import threading
import traceback
import uuid
from dataclasses import dataclass
from typing import AsyncIterator, Callable, List, Optional

from .address import Address
from .errors import IsostrataError
from .line import Line, Lost
from .outgoing import Outgoing
from .patience import Deadline
from .told import Told
from .v1 import isostrata_pb2 as v1


@dataclass(frozen=True)
class ConnectionEvent:
    """What has become of a connection: "lost", then "restored" or "given_up"."""

    kind: str
    reason: str = ""  # of lost and given_up
    resent: int = 0  # of restored: commands that the server had not done, and was sent again
    new_session: bool = False  # of restored: the server no longer had the session; what it showed was brought to a new one


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
        self.told = Told()
        self.on_progress: Optional[Callable[[v1.Progress], None]] = None
        self.on_state: Optional[Callable[[], None]] = None
        self.on_files: Optional[Callable[[v1.DatasetsChanged], None]] = None
        self.on_event = on_event
        self.made = 0  # how often the connection has been made
        self._hello = hello
        self._hello.client_id = uuid.uuid4().hex
        self._joined = joined
        self._bring_back = bring_back
        self._changed = threading.Condition()
        self.line = Line(address, context, timeout, reconnect, self)
        self._outgoing = Outgoing(self.line.put)
        self._failure: Optional[IsostrataError] = None
        self.line.start()
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
            mark = self._outgoing.mark()
            seq = self._queue(message)

        def judged() -> bool:
            self.told.refuse(seq)
            # Commands that follow a dataset wait for it in the server, and pings do not.
            return not self._outgoing.opening and self.told.has_answered(mark)

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
            self.told.refuse(put[1])
            return answered()

        self.wait(holds, late)

    def answer_to(self, question: v1.ClientMessage, kind: str, fits: Callable[[v1.ServerMessage], bool], late: str) -> v1.ServerMessage:
        """The answer of this kind that fits the question."""
        found: List[v1.ServerMessage] = []

        def came() -> bool:
            answer = self.told.take_answer(kind, fits)
            if answer:
                found.append(answer)
            return bool(found)

        self.ask(question, came, late)
        return found[0]

    def wait(self, holds: Callable[[], object], late: str, timeout: Optional[float] = None) -> None:
        """Until ``holds()``, which is asked under the lock after each message. Progress begins the timeout anew, and so does a
        connection that is back; while it is being tried again the time stands still."""
        if self.line.is_current:
            raise IsostrataError("invalid_argument", "a listener may not wait for the server: it is called by the thread that listens to it")
        limit = self.timeout if timeout is None else timeout
        with self._changed:
            deadline = Deadline(limit, (self.told.progress, self.made))
            while not holds():
                if self._failure:
                    raise self._failure
                left = deadline.left((self.told.progress, self.made), not self.made or self._outgoing.up)
                if left <= 0:
                    raise IsostrataError("timeout", late)
                self._changed.wait(min(left, 1.0))  # not for ever, so that Ctrl-C is heard everywhere

    def take_frame(self) -> Optional[v1.Frame]:
        with self._changed:
            return self.told.take_frame()

    @property
    def is_up(self) -> bool:
        return self._outgoing.up

    @property
    def has_failed(self) -> bool:
        return self._failure is not None

    def close(self) -> None:
        self.line.close()

    def _queue(self, message: v1.ClientMessage) -> int:
        """Numbered and queued under one lock, so that numbers rise on the wire whichever thread sends."""
        if self._failure:
            raise self._failure
        return self._outgoing.queue(message)

    # ---- the line's side: called by its thread ---------------------------------------------------------------------------------

    def begins(self) -> bytes:
        with self._changed:
            return self._outgoing.begin(self._hello)

    def lost(self, why: str) -> None:
        with self._changed:
            self._outgoing.up = False
        self._tell(ConnectionEvent("lost", why))

    def given_up(self, why: str) -> None:
        self._tell(ConnectionEvent("given_up", why))

    def ended(self, failure: IsostrataError) -> None:
        with self._changed:
            self._outgoing.up = False
            self._failure = self._failure or failure
            self._changed.notify_all()

    async def listens(self, messages: AsyncIterator[v1.ServerMessage]) -> None:
        early: Optional[List[v1.ServerMessage]] = []  # until the session is awake
        async for message in messages:
            kind = message.WhichOneof("body")
            if kind == "frame":
                # The picture has arrived: that is what the acknowledgement is to prove, whoever looks at it and when.
                with self._changed:
                    self._outgoing.acknowledge(message.frame.frame_id)
            if early is None:
                self._hear(message)
                continue
            if not early and kind == "error":
                if message.error.code == "unavailable" and self.made:
                    raise Lost(message.error.message)
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
        elif welcome.session != self._outgoing.session:
            if self._joined:
                raise IsostrataError("session_lost", f"the server came back without session {self._outgoing.session}")
            state = self.told.state
            if state.dataset and self._bring_back:
                try:
                    await self.line.loop.run_in_executor(None, self._bring_back, welcome.session, state)
                except IsostrataError as refused:
                    if refused.code in ("connection", "timeout"):
                        raise Lost(str(refused)) from None
                    raise IsostrataError(
                        "session_lost", f"the server came back without session {self._outgoing.session}, and refuses what it showed: {refused}"
                    ) from None
        if welcome.resume_token:
            self._hello.resume_token = welcome.resume_token

    def _back(self, welcome: v1.Welcome) -> None:
        with self._changed:
            resent = self._outgoing.resume(welcome, self.told.state)
            if resent.verdict:
                self.told.keep(resent.verdict)
            self.made += 1
            first = self.made == 1
            self._changed.notify_all()
        if not first:
            self._tell(ConnectionEvent("restored", "", resent.count, not resent.same_session))

    def _tell(self, event: ConnectionEvent) -> None:
        with self._changed:
            self._changed.notify_all()
        if self.on_event:
            _call(self.on_event, event)

    def _hear(self, message: v1.ServerMessage) -> None:
        with self._changed:
            news = self.told.hear(message) if self._outgoing.heard(message) else ""
            listeners = {"state": self.on_state, "files": self.on_files, "progress": self.on_progress}
            listener = listeners.get(news)
            self._changed.notify_all()
        if listener:
            _call(listener, *([] if news == "state" else [getattr(message, message.WhichOneof("body"))]))


def _call(listener: Callable[..., None], *what: object) -> None:
    """What a listener gets wrong is its own affair, and the connection goes on."""
    try:
        listener(*what)
    except Exception:
        traceback.print_exc()
