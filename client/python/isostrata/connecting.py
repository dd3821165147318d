"""The way to a session: a new one, or one that others look at."""

from __future__ import annotations

import ssl
from typing import Callable, List, Optional, Tuple

from .address import Address, tls_context
from .connection import Connection, ConnectionEvent
from .errors import IsostrataError
from .rest import Rest
from .session import Session, document
from .v1 import isostrata_pb2 as v1


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
        rest.json("PUT", f"sessions/{session}/state", document(state))

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
    if resume_token and made.resume_token != resume_token:
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
