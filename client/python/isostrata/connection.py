"""One WebSocket, served by a thread of its own so that notebooks and scripts may block, sleep or compute as they like: pings are
answered, frames acknowledged and the newest state kept meanwhile."""

from __future__ import annotations

import asyncio
import threading
import time
from collections import deque
from typing import Callable, Deque, Optional

import websockets
from google.protobuf.message import DecodeError

from .address import Address
from .errors import IsostrataError
from .v1 import isostrata_pb2 as v1

_MAX_MESSAGE = 512 << 20  # a lossless frame of the largest size
_KEPT_FRAMES = 8  # that nobody has asked for yet; older ones are forgotten


class Connection:
    """Thread-safe: everything that both threads touch is under ``_changed``, which also tells of news."""

    def __init__(self, address: Address, hello: v1.Hello, timeout: float) -> None:
        self.timeout = timeout
        self.welcome: Optional[v1.Welcome] = None
        self.state = v1.State()
        self.dataset = v1.DatasetInfo()
        self.progress: Optional[v1.Progress] = None
        self.on_progress: Optional[Callable[[v1.Progress], None]] = None
        self._changed = threading.Condition()
        self._frames: Deque[v1.Frame] = deque(maxlen=_KEPT_FRAMES)
        self._answers: Deque[v1.ServerMessage] = deque(maxlen=256)  # errors, pongs, histograms
        self._failure: Optional[IsostrataError] = None
        self._seq = 0
        self._mark = 0
        self._loop = asyncio.new_event_loop()
        self._socket: Optional[websockets.WebSocketClientProtocol] = None
        self._thread = threading.Thread(target=self._run, args=(address, hello), name="isostrata", daemon=True)
        self._thread.start()
        try:
            self.wait(lambda: self.welcome, "the server did not answer Hello")
        except BaseException:
            self.close()
            raise

    # ---- the caller's side ---------------------------------------------------------------------------------------------------

    def send(self, message: v1.ClientMessage) -> int:
        """Does not wait. The message's number."""
        with self._changed:
            if self._failure:
                raise self._failure
            return self._queue(message)

    def command(self, message: v1.ClientMessage) -> None:
        """Sends, and waits until the server has done it or refused it, which raises."""
        with self._changed:
            self._mark += 1
            mark = float(self._mark)
        seq = self.send(message)
        # Messages are answered in order: when the ping is answered, the command has been judged.
        self.send(v1.ClientMessage(ping=v1.Ping(client_time_ms=mark)))

        def judged() -> bool:
            self._refuse(seq)
            return any(a.WhichOneof("body") == "pong" and a.pong.client_time_ms == mark for a in self._answers)

        self.wait(judged, "the server did not answer a command")

    def wait(self, holds: Callable[[], object], late: str, timeout: Optional[float] = None) -> None:
        """Until ``holds()``, which is asked under the lock after each message. Progress begins the timeout anew."""
        limit = self.timeout if timeout is None else timeout
        with self._changed:
            end, heard = time.monotonic() + limit, self.progress
            while not holds():
                if self._failure:
                    raise self._failure
                if self.progress is not heard:
                    end, heard = time.monotonic() + limit, self.progress
                left = end - time.monotonic()
                if left <= 0:
                    raise IsostrataError("timeout", late)
                self._changed.wait(min(left, 1.0))  # not for ever, so that Ctrl-C is heard everywhere

    def refused(self, seq: int) -> None:
        """Raises where the server has refused this message."""
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
        if not self._thread.is_alive():
            return

        async def end() -> None:
            if self._socket is not None:
                await self._socket.close()
            else:
                for task in asyncio.all_tasks(self._loop):
                    if task is not asyncio.current_task():
                        task.cancel()

        try:
            asyncio.run_coroutine_threadsafe(end(), self._loop)
        except RuntimeError:
            return  # it has ended meanwhile
        if threading.current_thread() is not self._thread:
            self._thread.join(5)

    # ---- under the lock ------------------------------------------------------------------------------------------------------

    def _number(self, message: v1.ClientMessage) -> int:
        self._seq += 1
        message.seq = self._seq
        return self._seq

    def _queue(self, message: v1.ClientMessage) -> int:
        """Numbered and queued under one lock, so that numbers rise on the wire whichever thread sends."""
        seq = self._number(message)
        self._loop.call_soon_threadsafe(self._write, message.SerializeToString())
        return seq

    def _refuse(self, seq: int) -> None:
        for answer in self._answers:
            if answer.WhichOneof("body") == "error" and answer.error.in_reply_to == seq:
                self._answers.remove(answer)
                raise IsostrataError(answer.error.code, answer.error.message, answer.error.field)

    # ---- the thread's side -----------------------------------------------------------------------------------------------------

    def _run(self, address: Address, hello: v1.Hello) -> None:
        asyncio.set_event_loop(self._loop)
        failure = IsostrataError("closed", "the connection has been closed")
        try:
            self._loop.run_until_complete(self._serve(address, hello))
        except websockets.InvalidStatusCode as refused:
            if refused.status_code == 401:
                failure = IsostrataError("unauthorized", f"{address.host}: a token is needed; use the address that the server printed")
            else:
                failure = IsostrataError("connection", f"{address.host}: the server refused the WebSocket with {refused.status_code}")
        except websockets.ConnectionClosed as closed:
            if closed.reason:
                failure = IsostrataError("closed", f"the server ended the connection: {closed.reason}")
        except (OSError, websockets.WebSocketException, asyncio.TimeoutError) as wrong:
            failure = IsostrataError("connection", f"{address.host}: {wrong or type(wrong).__name__}")
        except asyncio.CancelledError:
            pass
        finally:
            with self._changed:
                self._failure = self._failure or failure
                self._changed.notify_all()
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()

    async def _serve(self, address: Address, hello: v1.Hello) -> None:
        socket = await websockets.connect(
            address.socket,
            subprotocols=[websockets.Subprotocol("isostrata.v1")],
            extra_headers=address.headers,
            compression=None,
            max_size=_MAX_MESSAGE,
            open_timeout=self.timeout,
            close_timeout=2,
        )
        try:
            with self._changed:
                first = v1.ClientMessage(hello=hello)
                self._number(first)
            await socket.send(first.SerializeToString())
            self._socket = socket
            async for data in socket:
                message = v1.ServerMessage()
                try:
                    message.ParseFromString(data if isinstance(data, bytes) else data.encode())
                except DecodeError:
                    continue
                if message.WhichOneof("body") == "frame":
                    # The picture has arrived: that is what the acknowledgement is to prove, whoever looks at it and when.
                    ack = v1.ClientMessage(frame_ack=v1.FrameAck(frame_id=message.frame.frame_id))
                    with self._changed:
                        self._queue(ack)
                self._hear(message)
        finally:
            await socket.close()

    def _write(self, data: bytes) -> None:
        if self._socket is not None and self._socket.open:
            # Tasks start in the order they are made, and writes are in the order of their tasks.
            self._loop.create_task(_send(self._socket, data))

    def _hear(self, message: v1.ServerMessage) -> None:
        kind = message.WhichOneof("body")
        told = None
        with self._changed:
            if kind == "welcome":
                self.state = message.welcome.state
                self.dataset = message.welcome.dataset_info
                self.welcome = message.welcome
            elif kind == "state":
                self.state = message.state
            elif kind == "dataset_info":
                self.dataset = message.dataset_info
            elif kind == "frame":
                self._frames.append(message.frame)
            elif kind == "progress":
                self.progress = message.progress
                told = self.on_progress
            elif kind == "done":
                self.progress = None
            elif kind == "shutdown":
                self._failure = IsostrataError("closed", f"the server ends: {message.shutdown.reason}")
            elif kind is not None:
                self._answers.append(message)
                if kind == "error" and self.welcome is None:
                    self._failure = IsostrataError(message.error.code, message.error.message, message.error.field)
            self._changed.notify_all()
        if told:
            told(message.progress)


async def _send(socket: websockets.WebSocketClientProtocol, data: bytes) -> None:
    try:
        await socket.send(data)
    except websockets.ConnectionClosed:
        pass  # the reader says so
