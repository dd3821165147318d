"""A WebSocket by whichever release of `websockets` is installed: from 14 on it has another client than before."""

from __future__ import annotations

import inspect
import socket
import ssl
from typing import Any, Mapping, Optional

import websockets
from websockets.exceptions import ConnectionClosed, InvalidStatus, WebSocketException

try:
    from websockets.asyncio.client import ClientConnection, connect as _connect

    _new = hasattr(ClientConnection, "state")  # not yet in 13
except ImportError:
    _new = False
if not _new:
    from websockets import connect as _connect
    from websockets.exceptions import InvalidStatusCode

__all__ = ["ConnectionClosed", "Refused", "WebSocketException", "close_code", "connect", "is_open"]


class Refused(Exception):
    """The server answered, and not with a WebSocket."""

    def __init__(self, status: int):
        super().__init__(f"the server refused the WebSocket with {status}")
        self.status = status


async def connect(
    address: str,
    subprotocol: str,
    headers: Mapping[str, str],
    context: Optional[ssl.SSLContext],
    timeout: float,
    max_size: int,
    unix: str = "",
) -> Any:
    """Raises Refused, OSError, EOFError, WebSocketException or asyncio.TimeoutError. What it returns has send, close, and messages by
    `async for`."""
    options: dict = {"additional_headers" if _new else "extra_headers": headers}
    if "proxy" in inspect.signature(_connect).parameters:
        options["proxy"] = None  # as releases before 15, and as our REST
    if context:
        options["ssl"] = context
    if unix:
        options["sock"] = socket.socket(socket.AF_UNIX)
        options["sock"].connect(unix)
        options["sock"].setblocking(False)
    try:
        return await _connect(
            address,
            subprotocols=[websockets.Subprotocol(subprotocol)],
            compression=None,
            max_size=max_size,
            open_timeout=timeout,
            close_timeout=2,
            **options,
        )
    except InvalidStatus as refused:
        raise Refused(refused.response.status_code) from None
    except WebSocketException as refused:
        if not _new and isinstance(refused, InvalidStatusCode):
            raise Refused(refused.status_code) from None
        raise


def is_open(connection: Any) -> bool:
    return connection.state.name == "OPEN"


def close_code(closed: ConnectionClosed) -> int:
    return closed.rcvd.code if closed.rcvd else 1006
