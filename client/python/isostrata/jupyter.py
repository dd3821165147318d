"""Isostrata in Jupyter: what jupyter-server-proxy (4 or newer, with Tornado 6.3 or newer) finds by the entry point ``isostrata``. Needs nothing of Jupyter
itself.

The server listens on a Unix socket that nobody but its user can open, so Jupyter's login is the only one, and no token is needed. What the page
may be asked by other pages is still judged here, by Host and Origin: a hub's name has to be allowed."""

from __future__ import annotations

import os
import shlex
from typing import Any, Dict, List
from urllib.parse import urlsplit


def serve() -> Dict[str, Any]:
    """How the server is started and shown. ``$ISOSTRATA`` is the program where it is not in $PATH; ``$ISOSTRATA_SERVE`` its paths and then further options,
    as a shell takes them, by default the folder in which Jupyter was started."""
    asked = shlex.split(os.environ.get("ISOSTRATA_SERVE", ".")) or ["."]
    hub = urlsplit(os.environ.get("JUPYTERHUB_PUBLIC_URL", "")).netloc  # JupyterHub 5 says it where its public_url is set
    more = ["--allow-host", hub] if hub else []  # last: it takes several names
    own = [part.replace("{", "{{").replace("}", "}}") for part in (os.environ.get("ISOSTRATA", "isostrata"), *asked, *more)]
    command: List[str] = [own[0], "serve", "--no-auth", "--socket", "{unix_socket}", "--base-url", "{base_url}isostrata/", *own[1:]]
    return {
        "command": command,  # jupyter-server-proxy formats each part
        "unix_socket": True,
        "absolute_url": True,
        "timeout": 60,
        "launcher_entry": {"title": "Isostrata"},
    }
