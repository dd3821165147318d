#!/usr/bin/env python3
"""ParaView's web delivery beside ours, in one run: tests/bench/paraview_web.py [--bin DIR] [--size WxH...] [--seconds S] [--frame DIR].

The same tetrahedra (`isostrata extract`) as a volume in ParaView, turned by a WebSocket client on loopback, and `isostrata bench stream
--link loopback --codec jpeg` on the same interval and size, in turns on the same cores. Prints a table for RESULTS.md; nothing passes or fails.

ParaView's part is its own: the view, its projected tetrahedra, vtkPVWebApplication's pictures and encoder, and the methods
ParaViewWebViewPort, ParaViewWebViewPortImageDelivery and ParaViewWebPublishImageDelivery of paraview.web.protocols. Debian ships them without
`wslink`, the package that carries them; the few lines of Carrier stand in for it, over Debian's python3-websockets. Three ways to get pictures are
tried, and the table has each: asking for one ("render"), being sent one for each new camera ("push"), and the loop that ParaView's pages run
while the mouse is down ("animation"). The client sends a camera when it has seen the last one, which is kinder to ParaView than 60 inputs a second,
which ours gets. Which camera a picture shows is told by its background, of a colour for each: ParaView may send an older picture than
the newest, and that counts as what it is.

Debian's paraview cannot be installed beside libvtk9-dev; unpacked it does: apt-get download paraview python3-paraview,
dpkg -x each into DIR, its other libraries by apt-get install xvfb python3-websockets python3-pil python3-numpy libvtk9.1 (what `ldd` still misses,
too), and --paraview DIR."""
import argparse
import asyncio
import base64
import io
import json
import math
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time
import types

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
INTERVAL = "0.9934:0.9949"  # of the built-in cylinder: 55.6 K tetrahedra
COLOR, OPACITY = (0xE6 / 255, 0x1F / 255, 0x1F / 255), 0.6  # as `isostrata bench stream` has them
QUALITY = 80
LEVELS = 8  # of green and blue of the background: 64 cameras are told apart


# ---- what is served: run by ParaView's Python --------------------------------------------------------------------------------


class Carrier:
    """The part of wslink that the protocols use: named methods, pictures sent with a message, calls put off."""

    def __init__(self):
        self.methods = {}
        self.attachments = []
        self.outgoing = None  # asyncio.Queue while somebody is connected
        self.shared = {}

    def module(self):
        wslink, websocket = types.ModuleType("wslink"), types.ModuleType("wslink.websocket")
        carrier = self

        def register(name):
            def mark(method):
                method.rpc_name = name
                return method
            return mark

        class LinkProtocol:
            def getSharedObject(self, key):
                return carrier.shared.get(key)

            def addAttachment(self, payload):
                carrier.attachments.append(bytes(payload))
                return len(carrier.attachments) - 1

        wslink.register = register
        wslink.schedule_callback = lambda delay, call: asyncio.get_running_loop().call_later(delay, call)
        wslink.websocket = websocket
        websocket.LinkProtocol = LinkProtocol
        websocket.ServerProtocol = object
        sys.modules["wslink"], sys.modules["wslink.websocket"] = wslink, websocket

    def publish(self, topic, data):
        self.send({"topic": topic, "data": data})

    def take(self, protocol):
        protocol.coreServer = self
        for name in dir(type(protocol)):
            method = getattr(protocol, name)
            if hasattr(method, "rpc_name"):
                self.methods[method.rpc_name] = method

    def send(self, message):
        if self.outgoing is not None:
            self.outgoing.put_nowait([json.dumps(message), *self.attachments])
        self.attachments.clear()

    async def serve(self, socket):
        self.outgoing = asyncio.Queue()

        async def write():
            while True:
                for part in await self.outgoing.get():
                    await socket.send(part)

        writing = asyncio.ensure_future(write())
        async for text in socket:
            call = json.loads(text)
            result = self.methods[call["method"]](*call.get("args", []))
            self.send({"id": call["id"], "result": result})
            await asyncio.sleep(0)  # the writer's turn: the protocols render where they stand
        writing.cancel()


def serve(job):
    import websockets

    carrier = Carrier()
    carrier.module()
    from paraview import simple
    from paraview.modules.vtkPVClientWeb import vtkPVWebApplication
    from paraview.web import protocols

    application = carrier.shared["app"] = vtkPVWebApplication()
    if job["way"] != "render":
        application.SetImageEncoding(0)  # pictures as they are, not as base64: what ParaView's applications choose for them
    for protocol in (protocols.ParaViewWebViewPort(), protocols.ParaViewWebViewPortImageDelivery(),
                     protocols.ParaViewWebPublishImageDelivery(decode=False)):
        carrier.take(protocol)

    reader = simple.XMLUnstructuredGridReader(FileName=[job["mesh"]])
    reader.UpdatePipeline()
    view = simple.CreateView("RenderView")
    view.ViewSize = job["size"]
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    shown = simple.Show(reader, view)
    shown.SetRepresentationType("Volume")
    array = reader.PointData.keys()[0]
    simple.ColorBy(shown, ("POINTS", array))
    low, high = reader.PointData[array].GetRange()
    colors, opacities = simple.GetColorTransferFunction(array), simple.GetOpacityTransferFunction(array)
    colors.RGBPoints = [low, *COLOR, high, *COLOR]
    opacities.Points = [low, OPACITY, 0.5, 0, high, OPACITY, 0.5, 0]
    box = reader.GetDataInformation().GetBounds()
    shown.ScalarOpacityUnitDistance = math.dist(box[0::2], box[1::2]) / 20
    shown.SetScalarBarVisibility(view, False)
    simple.Render(view)
    # The view that `isostrata bench stream` begins with: the whole dataset, seen from three quarters, at 30 degrees.
    at = [(a + b) / 2 for a, b in job["bounds"]]
    k, side = [0, 1, 0], [0.55, 0.45, 1]
    away = math.dist(*zip(*job["bounds"])) / 2 / math.sin(math.radians(15)) / math.hypot(*side)
    v = [c * away for c in side]
    view.CameraViewAngle = 30
    simple.Render(view)

    def turn(number, degrees):
        """The camera turned about its up axis, and the background that names it."""
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        along = sum(a * b for a, b in zip(k, v)) * (1 - c)
        cross = [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]]
        view.Background = background(number)
        return at, k, [a + b * c + d * s + e * along for a, b, d, e in zip(at, v, cross, k)]

    def camera(number, degrees, push):
        carrier.methods["viewport.camera.update"]("-1", *turn(number, degrees), push)

    carrier.methods["bench.turn"] = camera

    async def run():
        server = await websockets.serve(carrier.serve, "127.0.0.1", 0, compression=None, max_size=None)
        print(json.dumps({"port": server.sockets[0].getsockname()[1], "cells": reader.GetDataInformation().GetNumberOfCells(),
                          "mapper": str(shown.SelectMapper), "view": view.GetGlobalIDAsString(),
                          "version": str(simple.GetParaViewSourceVersion())}), flush=True)
        await asyncio.get_running_loop().run_in_executor(None, sys.stdin.read)  # until the other end is closed

    asyncio.run(run())
    os._exit(0)  # ParaView's own end of a process takes its time


def background(number):
    return [0, number % LEVELS * 0.7 / (LEVELS - 1), number // LEVELS % LEVELS * 0.7 / (LEVELS - 1)]


def number_of(rgb):
    low, high = (min(LEVELS - 1, max(0, round(v / 255 / 0.7 * (LEVELS - 1)))) for v in rgb[1:3])
    return low + high * LEVELS


# ---- who looks at it ---------------------------------------------------------------------------------------------------------


class Looker:
    """Turns the camera and notes when which camera was seen."""

    def __init__(self, socket, view, way, frame_file):
        self.socket, self.view, self.way, self.frame_file = socket, view, way, frame_file
        self.calls = 0
        self.lost = 0  # newest pictures that ParaView never sent by itself: they were asked for after a second
        self.seen, self.frames, self.bytes, self.latency = asyncio.Event(), [], 0, []

    async def call(self, method, *args):
        self.calls += 1
        await self.socket.send(json.dumps({"id": self.calls, "method": method, "args": args}))

    def picture(self, data):
        from PIL import Image

        image = Image.open(io.BytesIO(data))
        image.load()
        now = time.monotonic()
        self.last = image
        shown = number_of(image.getpixel((3, 3)))
        if shown == self.wanted % LEVELS**2 and not self.seen.is_set():
            self.frames.append(now)
            self.bytes += len(data)
            self.latency.append((now - self.sent) * 1e3)
            self.seen.set()

    async def read(self):
        coming = []
        async for part in self.socket:
            if isinstance(part, bytes):
                if coming.pop(0):
                    self.picture(part)
                continue
            message = json.loads(part)
            if message.get("topic") == "viewport.image.push.subscription":
                coming.append(True)
            result = message.get("result")
            if isinstance(result, dict) and isinstance(result.get("image"), str):
                self.picture(base64.standard_b64decode(result["image"]))
                if not self.seen.is_set():  # it was an older one: ask again, as ParaView's pages do
                    await self.ask()

    async def ask(self):
        await self.call("viewport.image.render", {"view": "-1", "mtime": 0, "quality": QUALITY})

    async def look(self, seconds):
        self.wanted, self.sent = 0, 0
        reading = asyncio.ensure_future(self.read())
        if self.way != "render":
            await self.call("viewport.image.push.observer.add", self.view)
            await self.call("viewport.image.push.quality", self.view, QUALITY)
        if self.way == "animation":
            await self.call("viewport.image.animation.start", self.view)
        warm = 5
        end = None
        number = 0
        while end is None or time.monotonic() < end:
            number += 1
            self.wanted = number
            self.seen.clear()
            self.sent = time.monotonic()
            await self.call("bench.turn", number % LEVELS**2, 1.5 * number, self.way == "push")
            if self.way == "render":
                await self.ask()
            seen = asyncio.ensure_future(self.seen.wait())
            for _ in range(30):
                await asyncio.wait({seen, reading}, timeout=1, return_when=asyncio.FIRST_COMPLETED)
                if seen.done() or reading.done():
                    break
                self.lost += 1
                await self.call("viewport.image.push", {"view": self.view})
            if not seen.done():
                raise reading.exception() if reading.done() else TimeoutError(f"picture {number} has not come within 30 s")
            if number == warm:
                self.frames.clear(), self.latency.clear()
                self.bytes, self.begin = 0, time.monotonic()
                end = self.begin + seconds
        reading.cancel()
        if self.frame_file:
            self.last.save(self.frame_file)
        covered = sum(p[0] > 40 for p in self.last.getdata()) / (self.last.width * self.last.height)
        latency = sorted(self.latency)
        return {"fps": len(self.frames) / (self.frames[-1] - self.begin), "p50": statistics.median(latency),
                "p95": latency[int(0.95 * (len(latency) - 1))], "max": latency[-1], "bytes": self.bytes / len(self.frames),
                "covered": covered, "lost": self.lost, "size": list(self.last.size)}


def start_display():
    """A window system for ParaView, which Debian builds for X alone: the process and its display."""
    read, write = os.pipe()
    display = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "2048x2048x24", "-nolisten", "tcp", "-noreset"], pass_fds=[write],
                               stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write)
    with os.fdopen(read) as told:
        return display, ":" + told.readline().strip()


def paraview_environment(root, display):
    environment = dict(os.environ, DISPLAY=display)
    if root:
        libraries = [str(p) for p in (root / "usr/lib").glob("*-linux-gnu")]
        environment["LD_LIBRARY_PATH"] = ":".join(libraries)
        environment["PYTHONPATH"] = str(root / "usr/lib/python3/dist-packages")
    return environment


def measure_paraview(arguments, mesh, size, way):
    import websockets

    server = subprocess.Popen([arguments.python, __file__, "--serve", json.dumps({"mesh": str(mesh), "size": size, "way": way, "bounds": arguments.bounds})],
                              stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=arguments.environment, text=True)
    try:
        facts = None
        for line in server.stdout:
            if line.startswith('{"port"'):
                facts = json.loads(line)
                break
        if not facts:
            sys.exit("ParaView's server ended before it was ready")

        async def client():
            async with websockets.connect(f"ws://127.0.0.1:{facts['port']}/", compression=None, max_size=None) as socket:
                name = f"paraview-{size[0]}x{size[1]}-{way}.png"
                return await Looker(socket, facts["view"], way, arguments.frame and arguments.frame / name).look(arguments.seconds)

        return {**asyncio.run(client()), **{k: facts[k] for k in ("cells", "mapper", "version")}}
    finally:
        server.stdin.close()
        try:
            server.wait(20)
        except subprocess.TimeoutExpired:
            server.kill()


def measure_ours(arguments, size):
    done = subprocess.run([str(arguments.bin / "isostrata"), "bench", "stream", "--link", "loopback", "--codec", "jpeg", "--interval", INTERVAL,
                           "--size", f"{size[0]}x{size[1]}", "--seconds", str(arguments.seconds), "--json"],
                          capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        sys.exit(f"isostrata bench stream: {done.stderr.strip()}")
    run = json.loads(done.stdout)["runs"][0]
    return {**run["input_to_decoded_ms"], "fps": run["fps"], "bytes": run["bytes_per_frame"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bin", type=pathlib.Path, default=REPOSITORY / "build/release/bin")
    parser.add_argument("--paraview", type=pathlib.Path, help="where the packages were unpacked; else ParaView is installed")
    parser.add_argument("--python", default="/usr/bin/python3", help="Debian's, which ParaView's modules are built for")
    parser.add_argument("--size", action="append", help="WIDTHxHEIGHT; may be repeated")
    parser.add_argument("--way", action="append", choices=["render", "push", "animation"])
    parser.add_argument("--seconds", type=float, default=6)
    parser.add_argument("--rounds", type=int, default=2, help="of ours and ParaView's in turns; the better of each counts")
    parser.add_argument("--frame", type=pathlib.Path, help="folder for ParaView's last picture of each run")
    parser.add_argument("--serve", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.serve:
        return serve(json.loads(arguments.serve))
    display, name = start_display()
    arguments.environment = paraview_environment(arguments.paraview, name)
    try:
        compare(arguments)
    finally:
        display.terminate()


def compare(arguments):
    if arguments.frame:
        arguments.frame.mkdir(parents=True, exist_ok=True)
    ways = arguments.way or ["render", "push", "animation"]
    with tempfile.TemporaryDirectory() as folder:
        mesh = pathlib.Path(folder) / "cylinder.vtu"
        subprocess.run([str(arguments.bin / "isostrata"), "extract", "cylinder", "--interval", INTERVAL, "--out", str(mesh)], check=True,
                       stdout=subprocess.DEVNULL)
        info = subprocess.run([str(arguments.bin / "isostrata"), "info", "cylinder", "--json"], check=True, capture_output=True, text=True)
        arguments.bounds = json.loads(info.stdout)["bounds"]
        print("| size | ParaView's way | ParaView: frames/s | p50 / p95 ms | bytes | ours: frames/s | p50 / p95 ms | bytes | frames/s, ratio "
              "| p95, ratio |\n|---|---|---|---|---|---|---|---|---|---|")
        for text in arguments.size or ["512x512", "1024x1024", "1280x720"]:
            size = [int(v) for v in text.split("x")]
            for way in ways:
                peers, mine = [], []
                for _ in range(arguments.rounds):
                    mine.append(measure_ours(arguments, size))
                    peers.append(measure_paraview(arguments, mesh, size, way))
                ours, peer = max(mine, key=lambda r: r["fps"]), max(peers, key=lambda r: r["fps"])
                print(f"| {text} | {way} | {peer['fps']:.1f} | {peer['p50']:.0f} / {peer['p95']:.0f} | {peer['bytes']:.0f} | {ours['fps']:.1f} "
                      f"| {ours['p50']:.0f} / {ours['p95']:.0f} | {ours['bytes']:.0f} | {ours['fps'] / peer['fps']:.1f} "
                      f"| {peer['p95'] / ours['p95']:.1f} |", flush=True)
                if peer["lost"]:
                    print(f"{text}, {way}: {peer['lost']} of ParaView's newest pictures were sent only when asked for again", file=sys.stderr)
                if peer["size"] != size or peer["covered"] < 0.005:
                    print(f"ParaView's picture is {peer['size']}, {peer['covered']:.1%} of it not background", file=sys.stderr)
    print(f"\n{peer['version']}, {peer['mapper']}, {peer['cells']} tetrahedra, {peer['covered']:.0%} of the last picture covered; load average "
          f"{os.getloadavg()[0]:.1f}")


if __name__ == "__main__":
    main()
