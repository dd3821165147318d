"""The WebSocket, by a thread of its own: opened, listened to, and after a loss opened again for a while. What is said on it is others'
business."""

from __future__ import annotations

import asyncio
import ssl
import threading
from typing import Any, AsyncIterator, Optional, Protocol

from google.protobuf.message import DecodeError

from .address import Address
from .errors import IsostrataError
from .patience import Retries
from .rest import untrusted
from .told import Told
from .v1 import isostrata_pb2 as v1
from .web_socket import ConnectionClosed, Refused, WebSocketException, close_code, connect, is_open

_MAX_MESSAGE = 512 << 20  # a lossless frame of the largest size
_LONGEST_PAUSE = 2.0  # seconds between two tries
_FINAL = (1002, 1008)  # goodbyes of a server that will say the same again: a broken protocol, an invitation taken back


class Lost(Exception):
    """The way there is at fault, which may be better in a moment."""


class Doors(Protocol):
    """What a line calls, always from its own thread."""

    told: Told  # of it last_words and for_good, which say whether to try again and what to tell
    made: int  # how often a connection has come as far as a session

    def begins(self) -> bytes:
        """A WebSocket is open. What is said first."""

    async def listens(self, messages: AsyncIterator[v1.ServerMessage]) -> None:
        """To the end of one connection. Raises Lost if it may be tried again, IsostrataError if not."""

    def lost(self, why: str) -> None:
        """It will be tried again."""

    def given_up(self, why: str) -> None:
        """It has been tried long enough."""

    def ended(self, failure: IsostrataError) -> None:
        """Nothing comes or goes any more."""


class Line:
    def __init__(self, address: Address, context: ssl.SSLContext | None, timeout: float, reconnect: float, doors: Doors) -> None:
        """``timeout``: seconds that one try may take; ``reconnect``: that a lost connection is tried again."""
        self._address = address
        self._context = context
        self._timeout = timeout
        self._reconnect = reconnect
        self._doors = doors
        self._closing = False
        self._socket: Any = None  # of web_socket.connect
        self.loop = asyncio.new_event_loop()
        self.thread = threading.Thread(target=self._run, name="isostrata", daemon=True)
        self._serving: Optional[asyncio.Task] = None

    def start(self) -> None:
        self._serving = self.loop.create_task(self._serve())
        self.thread.start()

    @property
    def is_current(self) -> bool:
        """Whether this is called by the line's own thread."""
        return threading.current_thread() is self.thread

    def put(self, data: bytes) -> None:
        """From any thread; does not wait. Goes to the connection that stands now, or nowhere."""
        self.loop.call_soon_threadsafe(self._write, self._socket, data)

    def close(self) -> None:
        """From any thread; waits for the line's end."""
        self._closing = True
        if not self.thread.is_alive():
            return
        try:
            self.loop.call_soon_threadsafe(lambda: self.loop.create_task(self._end()))
        except RuntimeError:
            return  # it has ended meanwhile
        if not self.is_current:
            self.thread.join(5)

    def _run(self) -> None:
        asyncio.set_event_loop(self.loop)
        failure = IsostrataError("closed", "the connection has been closed")
        try:
            self.loop.run_until_complete(self._serving)
        except IsostrataError as wrong:
            failure = wrong
        except asyncio.CancelledError:
            pass
        finally:
            self._doors.ended(failure)
            self.loop.run_until_complete(self._tidy())
            self.loop.close()

    async def _end(self) -> None:
        if self._socket is not None and is_open(self._socket):
            await self._socket.close()
        self._serving.cancel()

    async def _tidy(self) -> None:
        rest = asyncio.all_tasks() - {asyncio.current_task()}  # what was to be sent
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)
        await self.loop.shutdown_asyncgens()

    def _write(self, socket: Any, data: bytes) -> None:
        if is_open(socket):
            # Tasks start in the order they are made, and writes are in the order of their tasks.
            self.loop.create_task(_send(socket, data))

    async def _serve(self) -> None:
        """Connects, and again after each loss, until there is nothing more to hope for."""
        while True:
            try:
                await self._connect_once()
                why = self._doors.told.last_words or "the connection has been closed"
            except Lost as lost:
                if not self._doors.made:
                    raise IsostrataError("connection", str(lost)) from None
                why = str(lost)
            self._check_closing()
            if self._reconnect <= 0 or self._doors.told.for_good:
                raise IsostrataError("closed", f"the server ended the connection: {why}")
            self._doors.lost(why)
            await self._come_back(why)

    def _check_closing(self) -> None:
        """After whatever may take a cancellation for its own: asyncio.wait_for forgets one that meets the end of what it waits for."""
        if self._closing:
            raise IsostrataError("closed", "the connection has been closed")

    async def _come_back(self, why: str) -> None:
        made, last = self._doors.made, why
        retries = Retries(self._reconnect, _LONGEST_PAUSE)
        try:
            while True:
                self._check_closing()
                await asyncio.sleep(retries.pause())
                if retries.over:
                    raise IsostrataError(
                        "closed", f"the connection was lost ({why}) and could not be made again in {self._reconnect:g} s: {last}"
                    )
                try:
                    self._doors.told.last_words = ""
                    await self._connect_once()
                    last = self._doors.told.last_words or "the connection has been closed"
                except Lost as lost:
                    last = str(lost)
                if self._doors.made > made:  # it was back, and has been lost once more
                    if self._closing or self._doors.told.for_good:
                        raise IsostrataError("closed", f"the server ended the connection: {last}")
                    self._doors.lost(last)
                    made, why = self._doors.made, last
                    retries = Retries(self._reconnect, _LONGEST_PAUSE)
        except IsostrataError as given_up:
            if not self._closing:
                self._doors.given_up(str(given_up))
            raise

    async def _connect_once(self) -> None:
        """One connection, to its end. Raises Lost if it may be tried again."""
        host = self._address.host
        try:
            socket = await connect(
                self._address.socket, "isostrata.v1", self._address.headers, self._context, self._timeout, _MAX_MESSAGE, self._address.unix
            )
        except Refused as refused:
            if refused.status == 401:
                raise IsostrataError(
                    "unauthorized", f"{host}: a token is needed; use the address that the server printed"
                ) from None
            raise Lost(f"{host}: {refused}") from None
        except ssl.SSLCertVerificationError as why:
            raise untrusted(self._address, why) from None
        except (OSError, EOFError, WebSocketException, asyncio.TimeoutError) as wrong:
            raise Lost(f"{host}: {wrong or type(wrong).__name__}") from None
        try:
            self._check_closing()
            self._socket = socket
            await socket.send(self._doors.begins())
            await self._doors.listens(_messages(socket))
        except ConnectionClosed as closed:
            self._doors.told.for_good = self._doors.told.for_good or close_code(closed) in _FINAL
            # What was refused long ago is not a reason; what was said with a goodbye is.
            raise Lost((closed.rcvd and (self._doors.told.last_words or closed.rcvd.reason)) or str(closed)) from None
        finally:
            await socket.close()


async def _messages(socket: Any) -> AsyncIterator[v1.ServerMessage]:
    async for data in socket:
        message = v1.ServerMessage()
        try:
            message.ParseFromString(data if isinstance(data, bytes) else data.encode())
        except DecodeError:
            continue
        yield message


async def _send(socket: Any, data: bytes) -> None:
    try:
        await socket.send(data)
    except ConnectionClosed:
        pass  # the reader says so
