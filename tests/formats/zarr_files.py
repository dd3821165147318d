"""Folders of Zarr and OME-Zarr by Debian's python3-zarr, for write_files.py. Its version 2 (Debian 12) writes Zarr 2; its version 3 writes both."""

import json
import os

import numcodecs
import numpy as np
import zarr

WRITES_3 = int(zarr.__version__.split(".")[0]) >= 3
TCZYX = [("t", "time", "second"), ("c", "channel", None), ("z", "space", "micrometer"), ("y", "space", "micrometer"), ("x", "space", "micrometer")]
LEVELS = [("0", [2, 1, 3, 1, 0.5], [0, 0, 10, 0, 0]), ("1", [2, 1, 3, 1, 1], [0, 0, 10, 0, 0.25])]
BLOSC = {"blosclz": 0, "lz4": 1, "lz4hc": 2, "zlib": 1, "zstd": 2}  # inner codec: shuffle
PACKERS = {"raw": None, "zlib": numcodecs.Zlib(1), "gzip": numcodecs.GZip(1), "bz2": numcodecs.BZ2(1), "zstd": numcodecs.Zstd(1), "lz4": numcodecs.LZ4(),
           **{"blosc_" + name: numcodecs.Blosc(name, 5, shuffle) for name, shuffle in BLOSC.items()}}
TYPES = ["<f4", ">f8", "<u2", ">i4", "<i8", ">u4", "|u1", "<i2", "<u8", ">u2", "|i1"]


def array(path, values, written=slice(None), **settings):
    if WRITES_3:
        settings["zarr_format"] = 2
    settings = {"chunks": (3, 2, 4)[-values.ndim:], "compressor": None, "fill_value": 0, **settings}
    zarr.open_array(path, mode="w", shape=values.shape, dtype=values.dtype, **settings)[written] = values[written]


def image(path, axes, levels, more=None, **of_all):
    """axes: (name, type, unit) of each; levels: (path, scale, translation or None) of each."""
    def steps(scale, translation):
        return [{"type": "scale", "scale": scale}] + ([{"type": "translation", "translation": translation}] if translation else [])

    attributes = {"multiscales": [{"axes": [{"name": n, "type": t, **({"unit": u} if u else {})} for n, t, u in axes],
                                   "datasets": [{"path": p, "coordinateTransformations": steps(s, o)} for p, s, o in levels], **of_all}], **(more or {})}
    if "version" in attributes["multiscales"][0]:
        os.makedirs(path)
        for name, text in ((".zgroup", {"zarr_format": 2}), (".zattrs", attributes)):
            with open(os.path.join(path, name), "w") as out:
                json.dump(text, out)
    else:
        zarr.open_group(path, mode="w", zarr_format=3, attributes={"ome": {"version": "0.5", **attributes}})


def five_axes(field):
    """Two steps of two channels, at two levels of which the second has every second point along x."""
    whole = np.stack([np.stack([field + 1000 * t, -field]) for t in range(2)])
    return {"0": whole, "1": whole[..., ::2]}


def expect_five_axes(name, lattice, expect):
    for step in range(2):
        arrays = {"nuclei": [1000 * step, 1000 * step + 345, 0], "channel 1": [-345, 0, 0]}
        lattice(name, arrays, [0, 2.5, 0, 4, 10, 19], [2.5, 3, 16, "nuclei", 1000 * step + 235], [0, 2], step)
        arrays = {"nuclei": [1000 * step, 1000 * step + 344, 0], "channel 1": [-344, 0, 0]}
        expect(name + "/1", "uniform", 60, 24, arrays, [0.25, 2.25, 0, 4, 10, 19], [2.25, 3, 16, "channel 1", -234], [0, 2], step)


LABELS = {"omero": {"channels": [{"label": "nuclei"}, {"label": ""}]}}


def version_2(field, lattice, expect):
    depth, height, width = field.shape
    unit = [0, width - 1, 0, height - 1, 0, depth - 1]
    image("image.zarr", TCZYX, LEVELS, LABELS, version="0.4")
    for path, values in five_axes(field).items():
        array("image.zarr/" + path, values.astype(">i2"), chunks=(1, 1, 3, 2, 4), compressor=numcodecs.Blosc("lz4"), dimension_separator="/")
    expect_five_axes("image.zarr", lattice, expect)

    random = np.random.default_rng(7)
    for n, (name, packer) in enumerate(PACKERS.items()):
        settings = {"compressor": packer, "order": "CF"[n % 2], "dimension_separator": "./"[n // 2 % 2]}
        values = (field / 3).astype(TYPES[n])
        folder = name + (".zarr" if n % 2 else "")
        array(folder, values, **settings)
        lattice(folder, {name: [0, float(values.max()), 0]}, unit, [5, 3, 2, name, float(values[2, 3, 5])])
        same = (random.standard_normal((9, 11, 13)) * 50 + 60).astype(TYPES[n])
        np.save(f"same_{name}.npy", same)
        array(f"same_{name}.zarr", same, **settings)

    array("bool.zarr", field > 200)
    lattice("bool.zarr", {"bool": [0, 1, 0]}, unit, [5, 3, 2, "bool", 1])
    array("holes.zarr", field.astype("f4"), slice(0, 3), fill_value=-7)  # the chunks of the fourth layer are never written
    lattice("holes.zarr", {"holes": [-7, 245, 0]}, unit, [5, 3, 3, "holes", -7])
    array("gaps.zarr", field.astype("<f8"), slice(0, 3), fill_value=float("nan"))
    lattice("gaps.zarr", {"gaps": [0, 245, width * height]}, unit, [5, 3, 2, "gaps", 235])
    both = [{"type": "scale", "scale": [2, 2]}, {"type": "translation", "translation": [7, 0]}]
    image("flat.zarr", TCZYX[3:], [("0", [1, 0.5], None)], version="0.4", coordinateTransformations=both)
    array("flat.zarr/0", field[0].astype("u1"))
    expect("flat.zarr", "uniform", 30, 20, {"intensity": [0, 45, 0]}, [0, 5, 7, 15, 0, 0], [5, 13, 0, "intensity", 35])
    image("across.zarr", TCZYX[:1:-1], [("deep/0", [0.5, 1, 2], None)], version="0.4")  # x, y, z
    array("across.zarr/deep/0", field.T.astype("f4"), chunks=(2, 5, 3))
    lattice("across.zarr", {"intensity": [0, 345, 0]}, [0, 2.5, 0, 4, 0, 6], [2.5, 3, 4, "intensity", 235])


def array_3(path, values, chunks=(3, 2, 4), **settings):
    zarr.create_array(store=path, shape=values.shape, dtype=values.dtype.newbyteorder("="), chunks=chunks, **settings)[...] = values


def version_3(field, lattice, expect):
    from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, TransposeCodec, ZstdCodec

    depth, height, width = field.shape
    unit = [0, width - 1, 0, height - 1, 0, depth - 1]
    image("image3.zarr", TCZYX, LEVELS, LABELS)
    for path, values in five_axes(field).items():
        array_3("image3.zarr/" + path, values.astype("i2"), (1, 1, 3, 2, 4))
    expect_five_axes("image3.zarr", lattice, expect)
    random = np.random.default_rng(8)
    for n, (name, settings) in enumerate({
            "default3": {}, "raw3": {"compressors": None}, "big3": {"compressors": None, "serializer": BytesCodec(endian="big")},
            "gzip3": {"compressors": GzipCodec()}, "sums3": {"compressors": [ZstdCodec(checksum=True), Crc32cCodec()]}, "inner3": {"compressors": [Crc32cCodec(), GzipCodec()]},
            "turned3": {"filters": [TransposeCodec(order=(1, 2, 0))]}, "keys3": {"chunk_key_encoding": {"name": "v2", "separator": "."}},
            **{f"{inner}3": {"compressors": BloscCodec(typesize=4, cname=inner, shuffle="shuffle")} for inner in BLOSC}}.items()):
        values = (field / 3).astype(TYPES[n % len(TYPES)])
        array_3(name + ".zarr", values, **settings)
        lattice(name + ".zarr", {name: [0, float(values.max()), 0]}, unit, [5, 3, 2, name, float(values[2, 3, 5])])
        same = (random.standard_normal((9, 11, 13)) * 50 + 60).astype(TYPES[n % len(TYPES)])
        np.save(f"same_{name}.npy", same)
        array_3(f"same_{name}.zarr", same, (4, 3, 5), **settings)
    array_3("named3.zarr", np.stack([field, 2 * field]).astype("f4"), (1, 3, 2, 4), dimension_names=["channel", "z", "y", "x"])
    lattice("named3.zarr", {"channel 0": [0, 345, 0], "channel 1": [0, 690, 0]}, unit, [5, 3, 2, "channel 1", 470])
    array_3("shards3.zarr", field.astype("f4"), (2, 5, 3), shards=(4, 5, 6))
    lattice("shards3.zarr", {"shards3": [0, 345, 0]}, unit, [5, 3, 2, "shards3", 235])
    array_3("halves3.zarr", field.astype("f2"), (2, 5, 3), shards=(4, 5, 6))
    lattice("halves3.zarr", {"halves3": [0, 345, 0]}, unit, [5, 3, 2, "halves3", 235])


def write(field, lattice, expect):
    version_2(field, lattice, expect)
    if WRITES_3:
        version_3(field, lattice, expect)
