"""The server's REST interface, for what is one question and one answer."""

from __future__ import annotations

import json
import socket
import ssl
from http.client import HTTPConnection, HTTPException
from typing import Any
from urllib.error import HTTPError, URLError
from urllib.parse import quote, urlencode
from urllib.request import HTTPHandler, HTTPSHandler, ProxyHandler, Request, build_opener

from .address import Address
from .errors import IsostrataError


class _UnixHandler(HTTPHandler):
    """HTTP by a Unix socket, whatever the address says."""

    def __init__(self, path: str) -> None:
        super().__init__()
        self._path = path

    def http_open(self, request: Request) -> Any:
        path = self._path

        class Connection(HTTPConnection):
            def connect(self) -> None:
                self.sock = socket.socket(socket.AF_UNIX)
                self.sock.settimeout(self.timeout)
                self.sock.connect(path)

        return self.do_open(Connection, request)


class Rest:
    """``api/v1`` below a server's address. Errors are IsostrataError with the problem document's code, detail and field."""

    def __init__(self, address: Address, timeout: float, context: ssl.SSLContext | None = None) -> None:
        self._address = address
        self._timeout = timeout
        # The server is on this machine or behind a tunnel that ends here: a proxy of the environment is for other things.
        handlers = [ProxyHandler({}), *([HTTPSHandler(context=context)] if context else [])]
        if address.unix:
            handlers.append(_UnixHandler(address.unix))
        self._open = build_opener(*handlers).open

    def request(
        self, method: str, path: str, body: Any = None, *, query: dict[str, Any] | None = None, headers: dict[str, str] | None = None
    ) -> tuple[bytes, dict[str, str]]:
        """The body and the headers of an answer. ``path`` is below api/v1; ``body`` is sent as JSON."""
        url = f"{self._address.base}api/v1/{quote(path)}"
        if query:
            url += "?" + urlencode({name: value for name, value in query.items() if value is not None})
        data = None if body is None else json.dumps(body).encode()
        given = {**self._address.headers, **({"Content-Type": "application/json"} if data is not None else {}), **(headers or {})}
        try:
            with self._open(Request(url, data=data, headers=given, method=method), timeout=self._timeout) as answer:
                return answer.read(), {name.lower(): value for name, value in answer.headers.items()}
        except HTTPError as refused:
            raise _problem(refused) from None
        except TimeoutError:
            raise IsostrataError("timeout", f"no answer to {method} {path} in {self._timeout} s") from None
        except (URLError, OSError, HTTPException) as wrong:
            reason = getattr(wrong, "reason", wrong)
            if isinstance(reason, ssl.SSLCertVerificationError):
                raise untrusted(self._address, reason) from None
            raise IsostrataError("connection", f"{self._address.host}: {reason}") from None

    def json(self, method: str, path: str, body: Any = None, **more: Any) -> Any:
        """The same, if the answer is JSON."""
        content, _ = self.request(method, path, body, **more)
        return json.loads(content) if content else None


def untrusted(address: Address, why: ssl.SSLCertVerificationError) -> IsostrataError:
    return IsostrataError("tls", f"{address.host}: its certificate is not trusted: {why.verify_message}; ca_file may say whom to trust")


def _problem(refused: HTTPError) -> IsostrataError:
    code, detail, field = ("unauthorized" if refused.code == 401 else "protocol"), f"status {refused.code}", ""
    try:
        document = json.loads(refused.read())
        code, detail, field = document.get("code", code), document.get("detail", detail), document.get("field", field)
    except (ValueError, AttributeError, OSError):
        pass
    return IsostrataError(code, detail, field)
