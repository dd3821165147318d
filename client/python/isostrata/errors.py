"""What goes wrong."""

from __future__ import annotations


class IsostrataError(Exception):
    """Anything that goes wrong, with a code: the server's ("not_found", "invalid_argument", "bad_data", ...) or one of ours:
    "bad_url", "connection", "tls" (a certificate that is not trusted), "unauthorized", "timeout", "closed", "session_lost" (the
    server came back without the session), "interrupted" (work of the server that a lost connection took with it), "bad_image".
    ``field`` names the member that the server refused, where it named one."""

    def __init__(self, code: str, message: str, field: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.field = field

    def __str__(self) -> str:
        return f"{self.code}: {super().__str__()}"
