"""The entry point of jupyter-server-proxy: the command that it names is started as the proxy starts it, and asked as the proxy asks, by its Unix socket,
with the browser's path, Host and Origin. The proxy itself is not here (Debian does not have it)."""

import importlib.metadata
import os
import socket
import subprocess
import tempfile
import time
import unittest
from http.client import HTTPConnection
from pathlib import Path
from unittest import mock

from served import BIN

HUB = "hub.example.org"


class UnixConnection(HTTPConnection):
    def __init__(self, path):
        super().__init__("localhost", timeout=30)
        self.path = path

    def connect(self):
        self.sock = socket.socket(socket.AF_UNIX)
        self.sock.settimeout(self.timeout)
        self.sock.connect(str(self.path))


class Jupyter(unittest.TestCase):
    def entry(self, **environment):
        found = [e for e in importlib.metadata.entry_points(group="jupyter_serverproxy_servers") if e.name == "isostrata"]
        self.assertEqual(len(found), 1)
        with mock.patch.dict(os.environ, environment):
            return found[0].load()()

    def start(self, **environment):
        folder = tempfile.TemporaryDirectory(prefix="isostrata-jupyter-")
        self.addCleanup(folder.cleanup)
        self.socket = Path(folder.name) / "socket"
        entry = self.entry(ISOSTRATA=str(BIN / "isostrata"), **environment)
        self.assertIs(entry["unix_socket"], True)
        self.assertIs(entry["absolute_url"], True)
        command = [part.format(unix_socket=self.socket, base_url="/user/ada/", port=0) for part in entry["command"]]
        process = subprocess.Popen([*command, "--state-dir", "none"], cwd=folder.name, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.wait)
        self.addCleanup(process.terminate)
        end = time.monotonic() + 60
        while not self.socket.exists():
            self.assertIsNone(process.poll(), "it ended")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)
        return command

    def status(self, path, host=HUB, **headers):
        connection = UnixConnection(self.socket)
        self.addCleanup(connection.close)
        connection.request("GET", path, headers={"Host": host, **{name.replace("_", "-"): value for name, value in headers.items()}})
        answer = connection.getresponse()
        self.body = b"" if answer.status == 101 else answer.read()
        return answer.status

    def web_socket(self, origin):
        return self.status(
            "/user/ada/isostrata/ws", Origin=origin, Connection="Upgrade", Upgrade="websocket", Sec_WebSocket_Version="13",
            Sec_WebSocket_Key="MDEyMzQ1Njc4OWFiY2RlZg==", Sec_WebSocket_Protocol="isostrata.v1",
        )  # fmt: skip

    def test_a_hub_that_is_allowed_has_the_page_and_its_socket_and_other_pages_have_not(self):
        self.start(ISOSTRATA_SERVE=f"torus:12 --allow-host {HUB}")
        self.assertEqual(self.status("/user/ada/isostrata/healthz"), 200)
        self.assertEqual(self.status("/user/ada/isostrata/api/v1/datasets"), 200)
        self.assertIn(b"torus-12", self.body)
        self.assertEqual(self.status("/user/bob/isostrata/"), 404)
        self.assertEqual(self.web_socket(f"https://{HUB}"), 101)
        self.assertEqual(self.web_socket("https://elsewhere.example"), 403)
        self.assertEqual(self.socket.stat().st_mode & 0o777, 0o600)

    def test_a_hub_says_its_name_itself(self):
        command = self.start(ISOSTRATA_SERVE="torus:12", JUPYTERHUB_PUBLIC_URL=f"https://{HUB}/user/ada/")
        self.assertIn(HUB, command)
        self.assertEqual(self.status("/user/ada/isostrata/api/v1/datasets"), 200)
        self.assertIn(b"torus-12", self.body)
        self.assertNotEqual(self.status("/user/ada/isostrata/api/v1/datasets", host="elsewhere.example"), 200)

    def test_jupyter_on_the_users_own_machine_needs_no_name(self):
        self.start(ISOSTRATA_SERVE="torus:12")
        self.assertEqual(self.status("/user/ada/isostrata/api/v1/datasets", host="localhost:8888"), 200)
        self.assertNotEqual(self.status("/user/ada/isostrata/api/v1/datasets"), 200)

    def test_paths_are_what_a_shell_would_take(self):
        entry = self.entry(ISOSTRATA_SERVE="'a field {1}.vtk' --max-memory 4GB")
        command = [part.format(unix_socket="/s", base_url="/", port=0) for part in entry["command"]]
        self.assertEqual(command[-3:], ["a field {1}.vtk", "--max-memory", "4GB"])
        self.assertEqual(self.entry(ISOSTRATA_SERVE="")["command"][-1], ".")


if __name__ == "__main__":
    unittest.main()
