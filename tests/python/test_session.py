"""The package before a real server."""

import base64
import json
import signal
import tempfile
import threading
import time
import types
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import isostrata
from isostrata import Interval, IsostrataError, Surface, Term, decode_image, v1
from isostrata.line import Line

from served import Served


class WithServer(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = Served("torus:12", "cylinder:12x12x8x3")
        cls.addClassCleanup(cls.server.close)

    def connect(self, dataset="torus:12", **options):
        options.setdefault("size", (96, 72))
        session = isostrata.connect(self.server.url, dataset, **options)
        self.addCleanup(session.close)
        return session

    def assertRefused(self, code, call, *arguments, field=None, **named):
        with self.assertRaises(IsostrataError) as caught:
            call(*arguments, **named)
        self.assertEqual(caught.exception.code, code, str(caught.exception))
        if field is not None:
            self.assertEqual(caught.exception.field, field)


class Sessions(WithServer):
    def test_a_server_tells_what_it_offers(self):
        s = isostrata.connect(self.server.url)
        self.addCleanup(s.close)
        self.assertEqual(s.datasets, ["torus:12", "cylinder:12x12x8x3"])
        self.assertIn("viridis", s.color_maps)
        s.open("cylinder:12x12x8x3")
        self.assertEqual((s.info.grid, len(s.info.times)), ("curvilinear", 3))
        self.assertIn("Density", s.arrays)
        self.assertRefused("not_found", s.open, "nosuch")

    def test_a_part_of_a_grid_opens_as_a_dataset_and_values_are_taken_whole(self):
        s = self.connect()
        whole = s.info.id
        s.open("torus:12", region="0:5,:,:", stride="2")
        self.assertEqual((s.info.points, s.info.id), (3 * 6 * 6, whole + "@:5,:,:*2"))
        self.assertEqual(s.values, "interpolated")
        s.values = "whole"
        self.assertEqual(s.values, "whole")
        self.assertRefused("invalid_argument", s.open, "torus:12", region="5:2,:,:", field="region")
        s.open("torus:12")
        self.assertEqual((s.info.points, s.values), (12**3, "interpolated"))

    def test_addresses_and_tokens_that_are_wrong_are_said(self):
        for url in ("nonsense", "ftp://x/", "http://", "http://h:port/"):
            self.assertRefused("bad_url", isostrata.connect, url)
        self.assertRefused("connection", isostrata.connect, "http://127.0.0.1:1/?token=x")
        wrong = self.server.url.split("token=")[0] + "token=wrong"
        self.assertRefused("unauthorized", isostrata.connect, wrong)
        self.assertRefused("unauthorized", isostrata.sessions, wrong)
        self.assertRefused("not_found", isostrata.connect, self.server.url, session="0123456789abcdef")

    def test_the_token_may_come_apart_from_the_address(self):
        base, _, token = self.server.url.partition("?token=")
        s = isostrata.connect(base, token=token, size=(32, 32))
        self.addCleanup(s.close)
        self.assertTrue(s.id)

    def test_a_unix_socket_is_an_address_too(self):
        with tempfile.TemporaryDirectory() as folder:
            path = str(Path(folder) / "a socket")
            server = Served("torus:8", "--socket", path)
            self.addCleanup(server.close)
            token = server.url.partition("?token=")[2]
            s = isostrata.connect(f"unix:{path.replace(' ', '%20')}?token={token}", size=(32, 32))
            self.addCleanup(s.close)
            self.assertEqual([each["id"] for each in isostrata.sessions(f"unix:{path}", token=token)], [s.id])
            self.assertRefused("connection", isostrata.connect, f"unix:{folder}/absent")
            self.assertRefused("bad_url", isostrata.connect, "unix:relative")

    def test_two_clients_of_one_session_see_the_same(self):
        a = self.connect()
        b = self.connect("", session=a.id)
        a.intervals.set([(0.2, 0.4)])
        b.wait(lambda s: s.revision >= a.revision)
        self.assertEqual(b.intervals[0], a.intervals[0])
        b.intervals.move(b.intervals[0], 0.25, 0.5)
        a.wait(lambda s: s.intervals[0].upper == 0.5)
        self.assertIn(a.id, [each["id"] for each in isostrata.sessions(self.server.url)])

    def test_a_closed_session_says_so(self):
        s = self.connect()
        s.close()
        self.assertRefused("closed", s.view, "+x")
        s.close()


class Layers(WithServer):
    def test_intervals_are_set_added_changed_and_removed(self):
        s = self.connect()
        s.intervals.set([(0.1, 0.2), Interval(0.3, 0.4, color="#f80", opacity=0.75, name="shell", color_map="viridis")])
        self.assertEqual(len(s.intervals), 2)
        second = s.intervals[1]
        self.assertEqual((second.lower, second.upper, second.color, second.opacity, second.name, second.color_map),
                         (0.3, 0.4, "#ff8800", 0.75, "shell", "viridis"))
        third = s.intervals.add(0.5, 0.6, color=(0, 1, 0))
        self.assertEqual((third.color, third.priority), ("#00ff00", 1))
        self.assertEqual(s.intervals.move(third, 0.5, 0.7).upper, 0.7)
        changed = s.intervals.patch(third, opacity=0.1, opacity_upper=0.9, surface=Surface(opacity=0.5, domain=True), visible=False)
        self.assertEqual((changed.opacity_upper, changed.surface.opacity, changed.surface.domain, changed.visible), (0.9, 0.5, True, False))
        plain = s.intervals.patch(third, opacity_upper=None, surface=None)
        self.assertIsNone(plain.opacity_upper)
        self.assertTrue(plain.surface is None or not (plain.surface.lower or plain.surface.upper or plain.surface.domain))
        s.intervals.reorder([s.intervals[0], s.intervals[2], s.intervals[1]])
        self.assertEqual([i.priority for i in s.intervals], [2, 0, 1])
        s.intervals.remove(third)
        self.assertEqual([i.name for i in s.intervals], ["", "shell"])

    def test_a_change_that_changes_nothing_ends_and_is_no_news(self):
        s = self.connect(timeout=20.0)
        first, news = s.intervals[0], []
        s.on_change(lambda session: news.append(session.revision))
        before = s.revision
        s.intervals.move(first.id, first.lower, first.upper)
        s.open("torus:12")
        s.camera = s.camera
        s.cancel()
        self.assertEqual((s.revision, news), (before, []))
        s.on_change(None)

    def test_intervals_may_be_open(self):
        s = self.connect()
        s.intervals.set([(float("-inf"), 0.2), (0.2, float("inf"))])
        self.assertEqual([(i.lower, i.upper) for i in s.intervals], [(float("-inf"), 0.2), (0.2, float("inf"))])
        state = json.loads(json.dumps(s.save_state()))
        s.intervals.set([(0.1, 0.2)])
        s.load_state(state)
        self.assertEqual(s.intervals[1].upper, float("inf"))
        self.assertEqual(s.image().shape[:2], (72, 96))

    def test_a_refused_change_names_its_field_and_changes_nothing(self):
        s = self.connect()
        before = s.save_state()
        self.assertRefused("invalid_argument", s.intervals.set, [(0.1, 0.2), (2, 1)], field="intervals[1].lower")
        self.assertRefused("invalid_argument", s.intervals.patch, s.intervals[0], opacity=7)
        self.assertRefused("invalid_argument", s.intervals.patch, s.intervals[0], colour="red")
        self.assertRefused("invalid_argument", s.intervals.add, 0.1, 0.2, color="red")
        self.assertRefused("not_found", s.intervals.remove, 4711)
        self.assertRefused("not_found", s.intervals.set, [Interval(0, 1, color_map="nosuch")])
        self.assertEqual(s.save_state(), before)

    def test_arrays_times_terms_and_transfer_functions(self):
        s = self.connect("cylinder:12x12x8x3")
        s.array = "Density"
        s.color_by = "Energy"
        s.texture = "Momentum"
        self.assertEqual((s.array, s.color_by, s.texture), ("Density", "Energy", "Momentum"))
        s.step = 2
        self.assertEqual((s.step, s.time), (2, s.info.times[2]))
        middle = (s.info.times[0] + s.info.times[1]) / 2
        s.set_time(middle, "interpolate")
        self.assertEqual((s.time, s.message.time_mode), (middle, v1.TIME_MODE_INTERPOLATE))
        self.assertRefused("invalid_argument", s.set_time, middle, "sideways", field="mode")
        lower, upper = s.arrays["Momentum"]
        s.combine(("and", "Momentum", lower, (lower + upper) / 2), Term("minus", "Energy", 77.5, 78, hidden=True))
        self.assertEqual([t.op for t in s.message.terms], [v1.RANGE_OPERATOR_INTERSECT, v1.RANGE_OPERATOR_SUBTRACT])
        s.combine()
        self.assertEqual(len(s.message.terms), 0)
        lower, upper = s.arrays["Density"]
        s.set_transfer_function([(lower, "#000000", 0), ((lower + upper) / 2, "#ff0000", 0.5), (upper, "#ffffff", 0)])
        middle = (lower + upper) / 2
        self.assertEqual([(i.lower, i.upper, i.transfer[1][1:]) for i in s.intervals], [(lower, upper, ("#ff0000", 0.5))])
        self.assertRefused("unsupported", setattr, s, "color_by", "Energy", field="color_by")
        changed = s.intervals.patch(s.intervals[0], transfer=[(lower, "#00ff00", 0.25), (middle, "#0000ff", 0.5)])
        self.assertEqual((changed.upper, changed.transfer[0]), (middle, (lower, "#00ff00", 0.25)))
        again = s.intervals.set(list(s.intervals))  # a value brings all of itself along
        self.assertEqual(again[0].transfer, changed.transfer)
        self.assertEqual(s.intervals.patch(changed, transfer=()).transfer, ())
        s.transfer_from_matplotlib(lambda t: (t, 0, 1 - t, 1), opacity=0.25, count=5)
        self.assertEqual([p[1] for p in s.intervals[0].transfer], ["#0000ff", "#4000bf", "#800080", "#bf0040", "#ff0000"])
        self.assertRefused("not_found", setattr, s, "array", "Temperature")

    def test_histograms_are_numpys(self):
        s = self.connect()
        histogram = s.histogram(bins=16)
        self.assertEqual((histogram.counts.sum(), len(histogram.edges)), (12**3, 17))
        self.assertEqual((histogram.edges[0], histogram.edges[-1]), s.arrays["distance"])
        self.assertRefused("not_found", s.histogram, "nosuch")


class Pictures(WithServer):
    def test_images_are_arrays_that_follow_the_scene(self):
        s = self.connect()
        s.view("+x")
        first = s.image()
        self.assertEqual((first.shape, first.dtype), ((72, 96, 3), np.uint8))
        np.testing.assert_array_equal(first, s.image(), "pictures of one state are the same")
        s.intervals.set([(0.05, 0.2)])
        self.assertFalse(np.array_equal(first, s.image()))
        self.assertEqual(s.image(50, 40).shape, (40, 50, 3))
        s.appearance(background="#ffffff", mode="prioritized", unit_distance=0.1)
        np.testing.assert_array_equal(s.image()[0, 0], [255, 255, 255])
        self.assertEqual((s.message.mode, s.message.unit_distance), (v1.RENDER_MODE_PRIORITIZED, 0.1))
        plain = s.image()
        s.appearance(depth_fade=0.8, occlusion=0.5, body_shading=0.25)
        self.assertEqual((s.message.occlusion, s.message.depth_fade, s.message.body_shading), (0.5, 0.8, 0.25))
        self.assertFalse(np.array_equal(plain, s.image()))
        self.assertRefused("invalid_argument", s.appearance, occlusion=2)
        s.appearance(depth_fade=0, occlusion=0, body_shading=0)
        np.testing.assert_array_equal(plain, s.image())
        s.appearance(color_range=(0.25, 4), color_log=True)
        self.assertEqual((s.message.color_range.lower, s.message.color_range.upper, s.message.color_range.log), (0.25, 4, True))
        s.appearance(color_log=False)
        self.assertEqual((s.message.color_range.lower, s.message.color_range.log), (0.25, False))
        s.appearance(color_range="all_steps")
        self.assertEqual(s.message.color_range.span, v1.COLOR_SPAN_ALL_STEPS)
        self.assertRefused("invalid_argument", s.appearance, color_range="all", field="color_range")
        self.assertRefused("invalid_argument", s.appearance, color_range=(3, 2), field="color_range.lower")
        self.assertRefused("invalid_argument", s.appearance, mode="sideways", field="mode")

    def test_cuts_annotations_cycles_and_smears(self):
        s = self.connect("cylinder:12x12x8x3")
        whole = s.image()
        s.clip(((1, 0, 0), 0.0))
        self.assertFalse(np.array_equal(whole, s.image()))
        s.clip()
        np.testing.assert_array_equal(whole, s.image())
        s.annotate(axes=True, box=True, legend=True)
        self.assertFalse(np.array_equal(whole, s.image()))
        s.annotate()
        s.cycle(seconds=2, phase=1)
        s.appearance(mode="cycled")
        self.assertFalse(np.array_equal(whole, s.image()))
        s.smear([0, 2], ["#ff0000", "#0000ff"])
        s.appearance(mode="smear")
        self.assertEqual(list(s.message.smear.steps), [0, 2])
        self.assertEqual(s.image().shape, whole.shape)

    def test_cameras_turn_and_zoom(self):
        s = self.connect()
        s.view("+x")
        start = s.camera
        s.camera = start.turned(90)
        self.assertAlmostEqual(np.linalg.norm(np.subtract(s.camera.eye, s.camera.at)), np.linalg.norm(np.subtract(start.eye, start.at)))
        self.assertAlmostEqual(np.dot(np.subtract(s.camera.eye, s.camera.at), np.subtract(start.eye, start.at)), 0)
        back = start.turned(30, 20).turned(0, -20).turned(-30)
        np.testing.assert_allclose(back.eye, start.eye, atol=1e-9)
        near = start.zoomed(2)
        self.assertAlmostEqual(np.linalg.norm(np.subtract(near.eye, near.at)) * 2, np.linalg.norm(np.subtract(start.eye, start.at)))
        self.assertRefused("invalid_argument", setattr, s, "camera", isostrata.Camera((0, 0, 0), (0, 0, 0), (0, 0, 1)))

    def test_pictures_are_saved_as_their_name_says(self):
        s = self.connect()
        with tempfile.TemporaryDirectory() as folder:
            s.save_image(Path(folder) / "a.png", 20, 10)
            s.save_image(Path(folder) / "a.jpg", 20, 10)
            self.assertEqual(decode_image((Path(folder) / "a.png").read_bytes()).shape, (10, 20, 3))
            self.assertEqual((Path(folder) / "a.jpg").read_bytes()[:2], b"\xff\xd8")
            s.save_image(Path(folder) / "b.png", 40, 30, transparent=True)
            clear = decode_image((Path(folder) / "b.png").read_bytes())
            self.assertEqual(clear.shape, (30, 40, 4))
            self.assertEqual(clear[0, 0, 3], 0)
            self.assertRefused("invalid_argument", s.save_image, Path(folder) / "b.jpg", 40, 30, True)
        self.assertRefused("invalid_argument", s.still, "bmp")

    def test_meshes_are_exported(self):
        s = self.connect()
        told = []
        s.on_progress(lambda stage, fraction: told.append(fraction))
        with tempfile.TemporaryDirectory() as folder:
            s.export(Path(folder) / "a.vtu")
            s.export(Path(folder) / "a.stl")
            s.export(Path(folder) / "lower.stl", facets=["lower"])
            self.assertIn(b"UnstructuredGrid", (Path(folder) / "a.vtu").read_bytes()[:200])
            self.assertLess((Path(folder) / "lower.stl").stat().st_size, (Path(folder) / "a.stl").stat().st_size)
            self.assertRefused("invalid_argument", s.export, Path(folder) / "a.obj")
            s.intervals.set([])
            self.assertRefused("not_found", s.export, Path(folder) / "none.vtu")
            self.assertFalse((Path(folder) / "none.vtu").exists())
        self.assertTrue(told)
        self.assertEqual(s.rest.json("GET", f"sessions/{s.id}/operations")["operations"], [])

    def test_films_are_made_of_turns_and_steps(self):
        s = self.connect()
        told = []
        s.on_progress(lambda stage, fraction: told.append(stage))
        with tempfile.TemporaryDirectory() as folder:
            small = {"width": 64, "height": 48, "samples": 1}
            s.film(Path(folder) / "turn.webm", turn=90, seconds=0.5, **small)
            self.assertEqual((Path(folder) / "turn.webm").read_bytes()[:4], bytes.fromhex("1a45dfa3"))
            self.assertIn("15 pictures", told)
            s.film(Path(folder) / "step.webm", steps=slice(None), annotations=["box"], **small)
            self.assertTrue((Path(folder) / "step.webm").exists())
            self.assertRefused("invalid_argument", s.film, Path(folder) / "still.webm")
            self.assertRefused("invalid_argument", s.film, Path(folder) / "turn.mp4", 90)
            self.assertRefused("invalid_argument", s.film, Path(folder) / "none.webm", 0, range(5, 5))
            self.assertRefused("invalid_argument", s.film, Path(folder) / "beyond.webm", 0, range(0, 99))
            self.assertFalse((Path(folder) / "still.webm").exists())
        self.assertEqual(s.rest.json("GET", f"sessions/{s.id}/operations")["operations"], [])

    def test_statistics_agree_with_the_histogram(self):
        s = self.connect()
        statistics, histogram = s.statistics(), s.histogram(bins=4096)
        middles = (histogram.edges[1:] + histogram.edges[:-1]) / 2
        mean = np.average(middles, weights=histogram.counts)
        self.assertAlmostEqual(statistics["mean"], mean, delta=histogram.edges[1] - histogram.edges[0])

    def test_layer_facts_hold_the_solids_volume_and_how_sure_it_is(self):
        s = self.connect()
        facts = s.layer_facts()
        self.assertEqual([one["id"] for one in facts], [interval.id for interval in s.intervals])
        for one in facts:
            self.assertGreater(one["tetrahedra"], 0)
            self.assertGreater(one["volume"], 0)
            self.assertLess(one["volumeError"], 0.2 * one["volume"])

    def test_a_probe_finds_the_layer_that_a_picture_shows(self):
        s = self.connect()
        s.intervals.set([(0.1, 0.3)])
        picture, hits = s.image(48, 36), 0
        background = picture[0, 0]
        for j in range(2, 36, 5):
            for i in range(2, 48, 5):
                found = s.probe((i + 0.5) / 48, (j + 0.5) / 36, 48, 36)
                self.assertEqual(found.hit, bool((picture[j, i] != background).any()), (i, j))
                if not found.hit:
                    self.assertIn("background", found.miss)
                    continue
                hits += 1
                self.assertEqual(found.interval, s.intervals[0].id)
                self.assertTrue(0.1 - 1e-6 <= found.values["distance"] <= 0.3 + 1e-6)
                self.assertEqual(len(found.position), 3)
                self.assertEqual(found.cell, found.cell_index[0] + 11 * (found.cell_index[1] + 11 * found.cell_index[2]))
        self.assertGreater(hits, 5)
        self.assertRefused("invalid_argument", s.probe, 1.5, 0.5)

    def test_a_line_has_the_values_of_the_data_and_its_layers(self):
        s = self.connect()
        s.intervals.set([(0.1, 0.3)])
        line = s.probe_line((-2, 0, 0), (2, 0, 0))
        self.assertEqual(line.array, "distance")
        self.assertFalse(line.thinned)
        np.testing.assert_allclose(line.values, np.abs(np.abs(line.at - 2) - 0.6), atol=0.15)
        self.assertTrue((np.diff(line.at) > 0).all())
        self.assertEqual({interval for _, _, interval in line.layers}, {s.intervals[0].id})
        inside = [np.interp((begin + end) / 2, line.at, line.values) for begin, end, _ in line.layers]
        self.assertTrue(all(0.1 <= value <= 0.3 for value in inside), inside)
        self.assertRefused("invalid_argument", s.probe_line, (0, 0, 0), (0, 0, 0))
        self.assertRefused("invalid_argument", s.probe_steps, (0, 0, 0))

    def test_a_layer_is_told_in_numbers(self):
        s = self.connect()
        s.intervals.set([(0.1, 0.3)])
        found = s.layer_statistics(s.intervals[0])
        self.assertAlmostEqual(found["volume"], s.layer_facts()[0]["volume"], 6)
        self.assertTrue(0.1 < found["mean"] < 0.3, found)
        self.assertEqual((found["pieces"], found["array"]), (1, "distance"))
        np.testing.assert_allclose(found["centroid"], (0, 0, 0), atol=2e-3)  # the cells are not cut alike on all sides
        self.assertEqual(s.layer_statistics(s.intervals[0].id, "distance"), found)
        self.assertRefused("not_found", s.layer_statistics, 999)

    def test_frames_come_while_things_change_and_end_lossless(self):
        s = self.connect(frames=True)
        s.intervals.move(s.intervals[0], 0.1, 0.3)
        for frame in s.frames(timeout=60):
            self.assertEqual((frame.width, frame.height), (96, 72))
            if frame.lossless and frame.revision == s.revision:
                break
        np.testing.assert_array_equal(frame.image()[:, :, :3], s.image())
        with self.assertRaises(IsostrataError) as caught:
            next(s.frames(timeout=0.3))
        self.assertEqual(caught.exception.code, "timeout")

    def test_moving_frames_are_pictures_too(self):
        s = self.connect(frames=True)
        s.interacting(True)
        for step in range(1, 4):
            s.intervals.move(s.intervals[0], 0.1, 0.3 + 0.1 * step)
            frame = next(s.frames(1))
            self.assertEqual(frame.image().shape, (72, 96, 3))


class Notebooks(WithServer):
    def test_a_view_is_a_picture_and_its_layers(self):
        s = self.connect()
        s.intervals.set([Interval(0.1, 0.25, color="#ff8800", name="<core>")])
        view = s.show(64, 48)
        self.assertEqual(decode_image(view._repr_png_()).shape, (48, 64, 3))
        bundle = view._repr_mimebundle_()
        self.assertEqual(set(bundle), {"image/png", "text/html", "text/plain"})
        np.testing.assert_array_equal(decode_image(base64.b64decode(bundle["image/png"])), s.image(64, 48))
        self.assertIn("#ff8800", bundle["text/html"])
        self.assertIn("&lt;core&gt; 0.1 &hellip; 0.25", bundle["text/html"])
        self.assertIn("0.1:0.25", repr(view))
        self.assertEqual(set(view._repr_mimebundle_(include=["image/png", "text/html"], exclude={"text/html"})), {"image/png"})
        json.dumps(bundle)

    def test_simple_controls_change_the_session_and_give_the_view_back(self):
        s = self.connect()
        view = s.show()
        before, camera = view._repr_png_(), s.camera
        self.assertIs(view.turn(40, 10).zoom(1.5).interval(0, upper=0.6, opacity=0.9), view)
        self.assertNotEqual(view._repr_png_(), before)
        self.assertEqual((s.intervals[0].upper, s.intervals[0].opacity), (0.6, 0.9))
        view.view("reset")
        self.assertEqual(s.camera, camera)

    def test_sliders_move_the_layers(self):
        """The widgets are stand-ins with ipywidgets' names: what is tested is what they do to the session."""

        class Widget:
            def __init__(self, *children, **options):
                self.__dict__.update(options, children=children)

            def observe(self, handler, name):
                self.handler = handler

            def on_click(self, handler):
                self.handler = handler

        names = ("Image", "FloatRangeSlider", "Button", "Layout", "HBox", "VBox")
        s = self.connect()
        with mock.patch.dict("sys.modules", ipywidgets=types.SimpleNamespace(**{name: Widget for name in names})):
            box = s.show(64, 48).interact()
        picture, buttons, first, *_ = box.children[0]
        before = picture.value
        first.handler({"new": (0.15, 0.45)})
        self.assertEqual((s.intervals[0].lower, s.intervals[0].upper), (0.15, 0.45))
        self.assertNotEqual(picture.value, before)
        camera = s.camera
        buttons.children[0][0].handler(None)
        self.assertNotEqual(s.camera, camera)


class States(WithServer):
    def test_a_state_is_saved_and_brought_back_elsewhere(self):
        s = self.connect("cylinder:12x12x8x3")
        s.view("+y")
        s.intervals.set([Interval(s.arrays["Density"][0], 1.0, color="#123456", surface=Surface(silhouette=0.5))])
        picture = s.image()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "state.json"
            saved = s.save_state(path)
            self.assertEqual(json.loads(path.read_text()), saved)
            other = self.connect()
            other.load_state(path)
        np.testing.assert_array_equal(other.image(), picture)
        other.intervals.set([])
        other.load_state(saved)
        self.assertEqual(len(other.intervals), 1)
        self.assertRefused("invalid_argument", other.load_state, {**saved, "intervals": [{"lower": 2, "upper": 1}]})
        self.assertRefused("malformed", other.load_state, {**saved, "nonsense": 1})


class Troubles(unittest.TestCase):
    def test_nothing_that_opens_a_dataset_is_on_its_way_when_it_is_open(self):
        server = Served("torus:100", "cylinder:12x12x8x3")  # a newcomer's session opens the first by itself, which takes a moment
        self.addCleanup(server.close)
        s = isostrata.connect(server.url, "cylinder:12x12x8x3", size=(64, 48))
        self.addCleanup(s.close)
        saved = s.save_state()
        write = Line._write

        def late(line, socket, data):  # as over a long line
            line.loop.call_later(0.4, write, line, socket, data)

        with mock.patch.object(Line, "_write", late):
            other = isostrata.connect(server.url, "torus:100", size=(64, 48))
            self.addCleanup(other.close)
            other.load_state(saved)
            time.sleep(0.6)
            self.assertEqual(other.message.dataset, saved["dataset"])

    def test_progress_is_told_and_work_can_be_cancelled(self):
        server = Served("torus:12", "torus:300")
        self.addCleanup(server.close)
        s = isostrata.connect(server.url, "torus:12", size=(64, 48), frames=True)
        self.addCleanup(s.close)
        s.image()  # the first extraction is over
        told = []

        def listen(stage, fraction):
            told.append((stage, fraction))
            s.cancel()

        s.on_progress(listen)
        try:
            s.open("torus:300")
            s.wait(lambda _: len(told) > 0)
        except IsostrataError as given_up:
            self.assertEqual(given_up.code, "cancelled")
        self.assertTrue(told)
        self.assertTrue(all(0 <= fraction <= 1 for _, fraction in told), told)
        s.on_progress(None)
        s.open("torus:12")
        self.assertEqual(s.image().shape, (48, 64, 3))

    def test_a_server_that_dies_or_ends_is_an_error_and_no_hang(self):
        for number in (signal.SIGKILL, signal.SIGTERM):
            server = Served("torus:12")
            self.addCleanup(server.close)
            s = isostrata.connect(server.url, "torus:12", reconnect=0)
            self.addCleanup(s.close)
            server.stop(number)
            with self.assertRaises(IsostrataError) as caught:
                s.wait(lambda _: False)
            self.assertEqual(caught.exception.code, "closed")
            with self.assertRaises(IsostrataError) as caught:
                s.image()
            self.assertEqual(caught.exception.code, "connection")

    def test_listeners_and_loops_hear_of_changes(self):
        server = Served("torus:12")
        self.addCleanup(server.close)
        s = isostrata.connect(server.url, "torus:12")
        self.addCleanup(s.close)
        other = isostrata.connect(server.url, session=s.id)
        self.addCleanup(other.close)
        heard = []
        s.on_change(lambda session: heard.append(session.intervals[0].lower))
        changes = s.changes(count=2, timeout=30)
        other.intervals.set([(0.1, 0.2)])
        first = next(changes)
        self.assertEqual((first.fields, first.state.intervals[0].lower), ({"intervals"}, 0.1))
        waiting = threading.Thread(target=lambda: (time.sleep(0.2), other.view("+x")))
        waiting.start()
        self.assertEqual(next(changes).fields, {"camera"})
        self.assertEqual(list(changes), [])
        waiting.join()
        self.assertIn(0.1, heard)
        s.on_change(lambda session: session.view("+y"))  # which would wait for its own thread
        other.view("-x")
        s.wait(lambda session: session.revision >= other.revision)
        s.on_change(None)
        s.view("+z")
        with self.assertRaises(IsostrataError) as caught:
            next(s.changes(timeout=0.2))
        self.assertEqual(caught.exception.code, "timeout")


if __name__ == "__main__":
    unittest.main()
