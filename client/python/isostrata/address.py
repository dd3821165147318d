"""A server's printed address, taken apart."""

from __future__ import annotations

import ssl
from dataclasses import dataclass
from urllib.parse import parse_qs, unquote, urlsplit

from .errors import IsostrataError


@dataclass(frozen=True)
class Address:
    scheme: str  # http or https
    host: str  # with the port
    path: str  # ends with a slash
    token: str
    unix: str = ""  # the path of a Unix socket, in place of host and port

    @classmethod
    def parse(cls, url: str, token: str = "") -> Address:
        try:
            parts = urlsplit(url)
            parts.port  # raises if it is not a number
        except ValueError as wrong:
            raise IsostrataError("bad_url", f"{url.split('?')[0]!r} is not a server's address: {wrong}") from None
        given = parse_qs(parts.query).get("token", [token])[0]
        if parts.scheme == "unix" and parts.path.startswith("/") and not parts.netloc:
            return cls("http", "localhost", "/", given, unquote(parts.path))
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise IsostrataError("bad_url", f"{url.split('?')[0]!r} is not a server's address; expected http://HOST:PORT/?token=TOKEN, https:// or unix:/PATH")
        path = parts.path if parts.path.endswith("/") else parts.path + "/"
        return cls(parts.scheme, parts.netloc.rpartition("@")[2], path, given)

    @property
    def base(self) -> str:
        return f"{self.scheme}://{self.host}{self.path}"

    @property
    def socket(self) -> str:
        return f"{'wss' if self.scheme == 'https' else 'ws'}://{self.host}{self.path}ws"

    @property
    def headers(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self.token}"} if self.token else {}


def tls_context(address: Address, given: ssl.SSLContext | None, ca_file: str, insecure: bool) -> ssl.SSLContext | None:
    """What https judges certificates by: ``given``, or one that trusts ``ca_file`` in place of the system's, or anybody."""
    if address.scheme != "https" or given is not None:
        return given if address.scheme == "https" else None
    try:
        context = ssl.create_default_context(cafile=ca_file or None)
    except (OSError, ssl.SSLError) as wrong:
        raise IsostrataError("invalid_argument", f"{ca_file}: no certificates in PEM: {wrong}", "ca_file") from None
    if insecure:
        context.check_hostname = False
        context.verify_mode = ssl.CERT_NONE
    return context
