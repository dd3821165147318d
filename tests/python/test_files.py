"""Files that come, grow and change while a script looks at them."""

import struct
import tempfile
import unittest
from pathlib import Path

import isostrata
from isostrata.v1 import isostrata_pb2 as v1
from served import Served


def write(folder: Path, name: str, offset: float) -> None:
    """A NRRD file of 4 x 4 x 4 numbers, complete under another name before it has its own."""
    head = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\n\n"
    (folder / "new").write_bytes(head.encode() + struct.pack("<64f", *(i + offset for i in range(64))))
    (folder / "new").rename(folder / name)


class Files(unittest.TestCase):
    def setUp(self) -> None:
        self.folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        for n in (1, 2):
            write(self.folder, f"run_{n}.nrrd", n)
        self.served = Served(str(self.folder))
        self.addCleanup(self.served.close)
        self.session = self.enterContext(isostrata.connect(self.served.url, size=(64, 48)))

    def test_a_series_gains_its_steps_and_a_rewritten_one_waits_to_be_reloaded(self) -> None:
        s, told = self.session, []
        s.on_files(lambda of, changed: told.extend(changed.entries))
        s.open("run_*.nrrd")
        self.assertEqual(len(s.info.times), 2)
        write(self.folder, "run_3.nrrd", 3)
        s.wait(lambda s: len(s.info.times) == 3, 20)
        s.step = 2
        self.assertEqual(s.state["step"], 2)
        self.assertEqual([e.news for e in told if e.name == "run_*.nrrd"][-1], v1.DATASET_NEWS_GROWN)
        layers = len(s.intervals)
        write(self.folder, "run_3.nrrd", 1000)
        s.wait(lambda s: s.info.on_disk == v1.ON_DISK_CHANGED, 20)
        self.assertLess(s.arrays[s.array][1], 1000)
        s.reload()
        self.assertEqual(s.info.on_disk, v1.ON_DISK_UNSPECIFIED)
        self.assertEqual((s.step, len(s.intervals)), (2, layers))
        s.wait(lambda s: s.arrays[s.array][1] > 1000, 20)

    def test_what_comes_is_listed_with_its_facts(self) -> None:
        s = self.session
        (self.folder / "deep").mkdir()
        write(self.folder, "deep/late.nrrd", 0)
        (self.folder / "notes.txt").write_text("text")
        s.wait(lambda s: "deep/late.nrrd" in s.datasets, 20)
        top = s.list_datasets()
        self.assertEqual([f.name for f in top.folders], ["deep"])
        self.assertEqual([(d.name, d.kind, d.steps) for d in top.datasets], [("run_*.nrrd", "NRRD", 2)])
        found = s.list_datasets(search="LATE nrrd").datasets
        self.assertEqual([(d.name, d.news) for d in found], [("deep/late.nrrd", v1.DATASET_NEWS_APPEARED)])
        self.assertGreater(found[0].bytes, 256)
        (self.folder / "deep" / "late.nrrd").unlink()
        s.wait(lambda s: "deep/late.nrrd" not in s.datasets, 20)

    def test_a_file_has_a_small_picture_of_its_own_or_none(self) -> None:
        s = self.session
        head = "NRRD0004\ntype: float\ndimension: 3\nsizes: 16 16 16\nencoding: raw\nendian: little\n\n"
        for name, at in (("a", 3), ("b", 12)):
            numbers = [((i - at) ** 2 + (j - 8) ** 2 + (k - 8) ** 2) ** 0.5 for k in range(16) for j in range(16) for i in range(16)]
            (self.folder / f"{name}.nrrd").write_bytes(head.encode() + struct.pack("<4096f", *numbers))
        (self.folder / "broken.nrrd").write_text(head)
        s.wait(lambda s: {"a.nrrd", "b.nrrd", "broken.nrrd"} <= set(s.datasets), 20)
        s.open("a.nrrd")  # which waits until it is written
        a, b = s.thumbnail(), s.thumbnail("b.nrrd")
        self.assertEqual((a.shape, a.dtype), ((144, 192, 3), "uint8"))
        self.assertGreater((a != a[0, 0]).any(axis=2).mean(), 0.1)  # it shows something
        self.assertTrue((a != b).any())
        s.wait(lambda s: not any(d.writing for d in s.list_datasets(search="broken").datasets), 20)
        self.assertIsNone(s.thumbnail("broken.nrrd"))
        with self.assertRaises(isostrata.IsostrataError) as refused:
            s.thumbnail("nothing")
        self.assertEqual(refused.exception.code, "not_found")


if __name__ == "__main__":
    unittest.main()
