"""Files of a session, its layers as a mesh or a film, which the server makes while it goes on with everything else."""

from __future__ import annotations

import time
from os import PathLike
from typing import Any, Callable

from .connection import Connection
from .errors import IsostrataError
from .patience import Retries
from .rest import Rest
from .v1 import isostrata_pb2 as v1


def patiently(connection: Connection, request: Callable[[], Any]) -> Any:
    """A request has a connection of its own; it is tried as long as the session's would be."""
    retries = Retries(connection.reconnect, 1.0, first=0.05)
    while True:
        try:
            return request()
        except IsostrataError as lost:
            # A server that came back without the session does not have it under its old name.
            passing = lost.code == "connection" or (lost.code == "not_found" and not connection.is_up)
            if not passing or retries.over or connection.has_failed:
                raise
        time.sleep(retries.pause())


def made_file(connection: Connection, rest: Rest, path: str | PathLike[str], kind: str, wanted: dict[str, Any]) -> None:
    """kind: "exports" or "films"."""
    session, made = connection.told.welcome.session, connection.made
    operation = patiently(connection, lambda: rest.json("POST", f"sessions/{connection.told.welcome.session}/{kind}", wanted))
    where = f"sessions/{session}/operations/{operation['id']}"
    try:
        pause = 0.02
        while operation["status"] == "running":
            time.sleep(pause)
            pause = min(2 * pause, 0.5)
            operation = patiently(connection, lambda: rest.json("GET", where))
            if connection.on_progress:
                connection.on_progress(v1.Progress(stage=operation["stage"], fraction=operation["fraction"]))
        if operation["status"] != "done":
            error = operation.get("error", {})
            raise IsostrataError(error.get("code", "internal"), error.get("detail", f"the server could not make {path}"), error.get("field", ""))
        data = rest.request("GET", f"sessions/{session}/{kind}/{operation['id']}")[0]
        with open(path, "wb") as file:
            file.write(data)
    except IsostrataError as lost:
        if lost.code == "not_found" and connection.made != made:
            raise IsostrataError("interrupted", "the server that made the file is gone; ask again") from None
        raise
    finally:
        try:
            rest.request("DELETE", where)  # ends it, or forgets it and its file
        except IsostrataError:
            pass
