#!/usr/bin/env python3
"""Damaged files of every format against `isostrata info`: mutants.py [--count N] [--seed S] [--only escapes|rules|mutants] [--also FOLDER]
[--keep FOLDER] [BIN], BIN being build/release/bin.

Right files are written first (seed_files.py); --also adds those of a folder that are not above 1 MB. Then come
* files by rule: each right file cut short at seven places, made longer, with its numbers enlarged, negative or NaN, under another format's name, and so on;
* N mutants (20,000): up to eight changes of bits, numbers, blocks, or a piece of another file; each is told by the seed and its number;
* escapes: files that name files outside their folder, in each way that their format has, with Landlock and without. inotify says what was opened.

What is counted: the program itself died; the reader crashed (it may, in 0.2 % of cases); above 10 s of processor time; more memory than four times the file and 256 MB;
opened outside. Each is named; --keep keeps such files. Exit status 1 if a count is above its limit. 20,000 take about
an hour on two cores.
"""
import argparse
import collections
import concurrent.futures
import ctypes
import os
import pathlib
import random
import re
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import threading

import seed_files

HERE = pathlib.Path(__file__).resolve().parent
SECONDS, MEMORY = 10, lambda size: 4 * size + (256 << 20)
CRASHES = 0.002
INTEGERS = [0, 1, -1, 127, 128, 255, 256, 32767, 32768, 65535, 65536, 1 << 24, (1 << 31) - 1, -(1 << 31), 1 << 40, (1 << 63) - 1]
NUMBERS = [b"0", b"-1", b"1", b"2147483647", b"4294967296", b"9223372036854775807", b"99999999999999999999", b"1e308", b"-1e400", b"nan", b"0x10", b"1.5", b"", b"x"]
TEXT_NUMBER = re.compile(rb"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])")


# ---- running one file ----------------------------------------------------------------------------------------------------------
class Run:
    """What became of `isostrata info PATH`."""

    def __init__(self, program, path, size, before=()):
        environment = {**os.environ, "ISOSTRATA_CACHE": "off", "LC_ALL": "C"}
        child = subprocess.Popen([*before, program, "info", path], env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL)
        killer = threading.Timer(20 * SECONDS, child.kill)
        killer.start()
        said = child.stdout.read().decode(errors="replace")
        _, status, usage = os.wait4(child.pid, 0)
        killer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
        self.seconds, self.memory = usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024  # of all its processes; the largest of them
        self.said = said.strip().splitlines()[-1] if said.strip() else ""
        self.opened = child.returncode == 0
        self.faults = []
        if child.returncode not in (0, 1, 2):
            self.faults.append(f"died: {child.returncode}")
        if child.returncode != 0 and not self.said:
            self.faults.append("died: without a word")
        if found := re.search(r"the reader crashed \(signal \d+\)", said):
            self.faults.append(found.group())
        if self.seconds > SECONDS:
            self.faults.append(f"slow: {self.seconds:.1f} s")
        if self.memory > MEMORY(size):
            self.faults.append(f"large: {self.memory >> 20} MB for {size} bytes")


class Counts:
    def __init__(self, keep):
        self.lock, self.kinds, self.keep = threading.Lock(), collections.defaultdict(collections.Counter), keep

    def add(self, kind, name, run, kept=()):
        with self.lock:
            count = self.kinds[kind]
            count["files"] += 1
            count["opened"] += run.opened
            count["slowest, ms"] = max(count["slowest, ms"], int(1000 * run.seconds))
            count["largest, MB"] = max(count["largest, MB"], run.memory >> 20)
            for fault in run.faults:
                count[fault.split(":")[0].split(" (")[0]] += 1
                print(f"{kind} {name}: {fault}", flush=True)
            if run.faults and self.keep:
                for path in kept:
                    to = self.keep / f"{kind}-{name}".replace("/", "_")
                    to.mkdir(parents=True, exist_ok=True)
                    shutil.copy(path, to / path.name)

    def passed(self):
        good = True
        for kind, count in self.kinds.items():
            print(f"{kind}: " + ", ".join(f"{value} {what}" for what, value in count.items()))
            bad = count["died"] or count["slow"] or count["large"] or count["opened outside"] or count["the reader crashed"] > CRASHES * count["files"]
            good = good and not bad
        return good


# ---- damaged files --------------------------------------------------------------------------------------------------------------
def words(data, value):
    """The first 256 bytes, as numbers of 32 bits that are replaced where they are small."""
    head = bytearray(data[:256])
    for at in range(0, len(head) - 3, 4):
        for order in "<>":
            if 0 < struct.unpack_from(order + "i", head, at)[0] < 10000:
                struct.pack_into(order + "i", head, at, value)
                break
    return bytes(head) + data[256:]


def by_rule(data):
    """(name, bytes) of what each rule makes of a file."""
    for name, end in (("nothing", 0), ("one byte", 1), ("16 bytes", 16), ("256 bytes", 256), ("a third", len(data) // 3), ("nine tenths", len(data) * 9 // 10), ("all but one", len(data) - 1)):
        yield name, data[:max(end, 0)]
    yield "one more", data + b"\0"
    yield "twice", data + data
    yield "zeros behind", data[:256] + bytes(max(len(data) - 256, 0))
    yield "ones behind", data[:256] + b"\xff" * max(len(data) - 256, 0)
    yield "no beginning", bytes(16) + data[16:]
    yield "backwards", data[::-1]
    yield "two-byte lines", data.replace(b"\n", b"\r\n")
    yield "a mark before", b"\xef\xbb\xbf" + data
    for value in (0x7FFFFFFF, -1, 0, 0x01000000):
        yield f"words {value}", words(data, value)
    for number in (b"0", b"-1", b"2147483647", b"9223372036854775807", b"nan", b"1e308"):
        yield f"numbers {number.decode()}", TEXT_NUMBER.sub(number, data)


def mutate(data, other, rng):
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 5, 8))):
        if not data:
            data = bytearray(b"\0")
        # Headers stand in front, and in many formats the tables at the end.
        span = rng.choice((64, 512, len(data), len(data)))
        at = rng.randrange(min(span, len(data)))
        if rng.random() < 0.1:
            at = len(data) - 1 - at
        what = rng.randrange(9)
        if what == 0:
            data[at] ^= 1 << rng.randrange(8)
        elif what == 1:
            data[at] = rng.choice((0, 1, 0x20, 0x7F, 0x80, 0xFF))
        elif what in (2, 3):
            code, size = rng.choice((("i", 4), ("q", 8), ("h", 2)))
            data[at:at + size] = struct.pack(rng.choice("<>") + code, max(min(rng.choice(INTEGERS), (1 << 8 * size - 1) - 1), -(1 << 8 * size - 1)))
        elif what == 4:
            del data[at:at + rng.choice((1, 4, 16, 256, 4096))]
        elif what == 5:
            block = data[at:at + rng.choice((1, 4, 16, 256, 4096))]
            data[at:at] = block * rng.choice((1, 1, 2, 100))
        elif what == 6:
            del data[at:]
        elif what == 7 and other:
            begin = rng.randrange(len(other))
            data[at:at + 64] = other[begin:begin + rng.choice((8, 64, 512))]
        else:
            found = [match.span() for match in TEXT_NUMBER.finditer(bytes(data[:1 << 16]))]
            if found:
                begin, end = rng.choice(found)
                data[begin:end] = rng.choice(NUMBERS)
            else:
                data[at] = rng.randrange(256)
        del data[4 << 20:]
    return bytes(data)


class Seeds:
    """Right files: each with the entry that is opened to have it read, itself or who names it."""

    def __init__(self, folder, program):
        self.folder, entries = folder, []
        for path in sorted(folder.iterdir()):
            if Run(program, path, 1 << 30).opened:
                entries.append(path)
        texts = {path: path.read_bytes() for path in entries if path.is_file() and path.stat().st_size < 1 << 16}
        self.files, taken = [], collections.Counter()
        for path in sorted(path for path in folder.rglob("*") if path.is_file() and not path.is_symlink()):
            above = [entry for entry in entries if entry == path or entry in path.parents]
            above += [entry for entry, text in texts.items() if path.name.encode() in text or entry.stem == path.stem]
            if path.suffix == ".png":
                above = [folder / "slice_*.png"]
            taken[path.relative_to(folder).parts[0]] += 1
            if above and (path.parent == folder or taken[path.relative_to(folder).parts[0]] <= 6):  # of a folder with hundreds of chunks, six
                self.files.append((path.relative_to(folder), above[0].relative_to(folder)))

    def copy(self, to):
        shutil.copytree(self.folder, to, symlinks=True)


def damaged(program, seeds, jobs, counts, workers, place):
    """Each of jobs (kind, name, file, entry, bytes, name of the file) in a copy of the seeds of its worker, which has them right again after it."""
    homes = threading.local()

    def one(job):
        kind, name, file, entry, data, called = job()
        if not hasattr(homes, "folder"):
            homes.folder = pathlib.Path(tempfile.mkdtemp(dir=place)) / "seeds"
            seeds.copy(homes.folder)
        target = homes.folder / (called or file)
        target.write_bytes(data)
        run = Run(program, homes.folder / (called or entry), max(len(data), 1))
        counts.add(kind, name, run, [target])
        if called:
            target.unlink()
        else:
            shutil.copyfile(seeds.folder / file, target)

    with concurrent.futures.ThreadPoolExecutor(workers) as pool:
        for _ in pool.map(one, jobs):
            pass


def rule_jobs(seeds):
    endings = sorted({file.suffix for file, entry in seeds.files if file == entry and file.suffix})
    for number, (file, entry) in enumerate(seeds.files):
        data = (seeds.folder / file).read_bytes()
        for name, bad in by_rule(data):
            yield lambda a=("rule", f"{file}: {name}", file, entry, bad, None): a
        if file == entry:
            called = f"another{endings[number % len(endings)]}"
            yield lambda a=("rule", f"{file} as {called}", file, entry, data, called): a


def mutant_jobs(seeds, count, first):
    for number in range(count):
        def job(number=number):
            rng = random.Random(f"{first} {number}")
            file, entry = rng.choice(seeds.files)
            other = (seeds.folder / rng.choice(seeds.files)[0]).read_bytes()
            return "mutant", f"{number} {file}", file, entry, mutate((seeds.folder / file).read_bytes(), other, rng), None
        yield job


# ---- escapes ----------------------------------------------------------------------------------------------------------------------
class Watch:
    """inotify on a folder and on those below: which of its files were opened since the last look."""

    OPEN = 0x20

    def __init__(self, folder):
        self.libc = ctypes.CDLL(None, use_errno=True)
        self.fd = self.libc.inotify_init1(os.O_NONBLOCK)
        for path in [folder, *(path for path in folder.rglob("*"))]:
            if self.libc.inotify_add_watch(self.fd, os.fsencode(path), self.OPEN) < 0:
                raise OSError(ctypes.get_errno(), "inotify_add_watch")

    def opened(self):
        try:
            return bool(os.read(self.fd, 1 << 16))
        except BlockingIOError:
            return False


def references(inside, outside):
    """Ways to name `outside`/NAME from a file in `inside`."""
    (inside / "door").symlink_to(outside)
    (inside / "sub").mkdir()
    return {"absolute": str(outside), "upwards": f"../{outside.name}", "through a folder": f"sub/../../{outside.name}", "a link": "door", "a URL": f"file://{outside}",
            "the process's root": f"/proc/self/root{outside}"}


def escapes(program, place, counts):
    outside, inside = place / "outside", place / "inside"
    seed_files.write(outside, program)
    inside.mkdir()
    ways = references(inside, outside)
    right, pieces = (outside / "ascii.vtu").read_text(), {}
    for way, to in ways.items():
        pieces |= {
            f"{way}, pvd": ("a.pvd", f'<VTKFile type="Collection"><Collection><DataSet timestep="0" file="{to}/ascii.vtu"/></Collection></VTKFile>'),
            f"{way}, vtm": ("a.vtm", f'<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet><DataSet index="0" file="{to}/ascii.vtu"/></vtkMultiBlockDataSet></VTKFile>'),
            f"{way}, vthb": ("a.vthb", (outside / "levels.vthb").read_text().replace('file="', f'file="{to}/')),
            f"{way}, pvtu": ("a.pvtu", (outside / "parts.pvtu").read_text().replace('Source="', f'Source="{to}/')),
            f"{way}, pvti": ("a.pvti", (outside / "parts.pvti").read_text().replace('Source="', f'Source="{to}/')),
            f"{way}, series": ("a.vtu.series", '{"file-series-version": "1.0", "files": [{"name": "%s/ascii.vtu", "time": 0}]}' % to),
            f"{way}, nhdr": ("a.nhdr", (outside / "apart.nhdr").read_text().replace("field.raw", f"{to}/field.raw")),
            f"{way}, mhd": ("a.mhd", f"NDims = 3\nDimSize = 6 5 4\nElementType = MET_FLOAT\nElementDataFile = {to}/field.raw\n"),
            f"{way}, mhd list": ("a.mhd", f"NDims = 3\nDimSize = 6 5 2\nElementType = MET_FLOAT\nElementDataFile = LIST\n{to}/plane_001.raw\n{to}/plane_002.raw\n"),
            f"{way}, mhd pattern": ("a.mhd", f"NDims = 3\nDimSize = 6 5 4\nElementType = MET_FLOAT\nElementDataFile = {to}/plane_%03d.raw 1 4 1\n"),
            f"{way}, bov": ("a.bov", f"DATA_FILE: {to}/field.raw\nDATA_SIZE: 6 5 4\nDATA_FORMAT: FLOAT\n"),
            f"{way}, volvis": ("a.dat", f"ObjectFileName: {to}/field.raw\nResolution: 6 5 4\nFormat: FLOAT\n"),
            f"{way}, mih": ("a.mih", f"mrtrix image\ndim: 6,5,4\nvox: 1,1,1\nlayout: +0,+1,+2\ndatatype: Float32LE\nfile: {to}/field.raw 0\nEND\n"),
            f"{way}, case": ("a.case", (outside / "box.case").read_text().replace("box.geo", f"{to}/box.geo").replace(" c_", f" {to}/c_").replace(" f_", f" {to}/f_")),
            f"{way}, XML entity": ("a.vtu", f'<!DOCTYPE x [<!ENTITY e SYSTEM "{to}/ascii.vtu">]>\n' + right.replace("<Piece", "&e;<Piece", 1)),
        }
    # HDF5 names other files in three ways.
    makes = f"""
import h5py, numpy
for n, to in enumerate({list(ways.values())!r}):
    with h5py.File(f"{inside}/link{{n}}.h5", "w") as f: f["a"] = h5py.ExternalLink(to + "/plain.h5", "/")
    with h5py.File(f"{inside}/raw{{n}}.h5", "w") as f: f.create_dataset("a", (4, 5, 6), "f4", external=[(to + "/field.raw", 0, 480)])
    layout = h5py.VirtualLayout((4, 5, 6), "f4"); layout[...] = h5py.VirtualSource(to + "/plain.h5", "a", (4, 5, 6))
    with h5py.File(f"{inside}/virtual{{n}}.h5", "w") as f: f.create_virtual_dataset("a", layout)
"""
    subprocess.run(["/usr/bin/python3", "-c", makes], check=True)
    files = [(name, file, text) for name, (file, text) in pieces.items()] + [(path.name, path.name, None) for path in sorted(inside.glob("*.h5"))]
    watch = Watch(outside)
    without = [program.with_name("isostrata-sandbox-escape"), "--without", "landlock"]
    for limit, before in (("with Landlock", []), ("without Landlock", without)):
        for name, file, text in files:
            path = inside / file
            if text is not None:
                path.write_text(text)
            watch.opened()
            run = Run(program, path, 1 << 20, before)
            if watch.opened():
                run.faults.append("opened outside")
            counts.add(f"escape {limit}", name, run, [path])
    # The watch sees what is opened.
    watch.opened()
    Run(program, outside / "ascii.vtu", 1 << 20)
    if not watch.opened():
        sys.exit("inotify saw nothing of a file that was read: the escapes prove nothing")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--also", type=pathlib.Path)
    parser.add_argument("--keep", type=pathlib.Path)
    parser.add_argument("--only", choices=("escapes", "rules", "mutants"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("bin", nargs="?", type=pathlib.Path, default=HERE.parent.parent / "build/release/bin")
    given = parser.parse_args()
    program = (given.bin / "isostrata").resolve()
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    counts = Counts(given.keep)
    with tempfile.TemporaryDirectory(prefix="isostrata-mutants-") as place:
        place = pathlib.Path(place)
        seed_files.write(place / "seeds", program)
        if given.also:
            for path in sorted(path for path in given.also.rglob("*") if path.is_file() and path.stat().st_size <= 1 << 20):
                to = place / "seeds" / path.relative_to(given.also).as_posix().replace("/", "-")
                shutil.copy(path, to)
        if given.only in (None, "escapes"):
            escapes(program, place, counts)
        if given.only != "escapes":
            seeds = Seeds(place / "seeds", program)
            print(f"{len(seeds.files)} right files", flush=True)
        if given.only in (None, "rules"):
            damaged(program, seeds, rule_jobs(seeds), counts, given.jobs, place)
        if given.only in (None, "mutants"):
            damaged(program, seeds, mutant_jobs(seeds, given.count, given.seed), counts, given.jobs, place)
    return 0 if counts.passed() else 1


sys.exit(main())
