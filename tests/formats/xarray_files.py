"""Groups of Zarr as xarray writes them, for write_files.py: arrays that name their axes, with coordinates of the same names. They are text and bytes,
since the library of Debian 12 has no version 3."""

import base64
import functools
import json
import pathlib
import zlib

import numpy as np

LEV, LAT, LON = [0.0, 10, 30, 70], [20.0, 10, 0, -10, -20], np.arange(6) * 5.0
BOUNDS = [0, 25, -20, 20, 0, 70]
TIME = {"units": "hours since 2000-01-01", "calendar": "noleap"}


def chunks_of(values, chunks):
    """The index and the bytes of each."""
    for index in np.ndindex(*[-(-n // c) for n, c in zip(values.shape, chunks)]):
        part = values[tuple(slice(i * c, (i + 1) * c) for i, c in zip(index, chunks))]
        whole = np.zeros(chunks, values.dtype)
        whole[tuple(slice(n) for n in part.shape)] = part
        yield index, whole.tobytes()


def version_2(folder, name, values, dimensions, fill=None, chunks=None, dtype=None, **attributes):
    values = np.asarray(values)
    to = pathlib.Path(folder, name)
    to.mkdir(parents=True)
    (to.parent / ".zgroup").write_text('{"zarr_format": 2}')
    chunks = chunks or values.shape
    (to / ".zarray").write_text(json.dumps({"zarr_format": 2, "shape": values.shape, "chunks": chunks, "dtype": dtype or values.dtype.str, "fill_value": fill, "order": "C", "filters": None,
                                            "compressor": {"id": "zlib", "level": 1}}))
    (to / ".zattrs").write_text(json.dumps({**attributes, "_ARRAY_DIMENSIONS": dimensions}))
    for index, part in chunks_of(values, chunks):
        (to / ".".join(map(str, index or (0,)))).write_bytes(zlib.compress(part))


def version_3(folder, name, values, dimensions, fill=0, chunks=None, **attributes):
    values = np.asarray(values)
    to = pathlib.Path(folder, name)
    to.mkdir(parents=True)
    chunks = chunks or values.shape
    kinds = {"f": "float", "i": "int", "u": "uint"}
    (to / "zarr.json").write_text(json.dumps({
        "zarr_format": 3, "node_type": "array", "shape": values.shape, "data_type": kinds[values.dtype.kind] + str(8 * values.dtype.itemsize), "fill_value": fill,
        "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": chunks}}, "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
        "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}], "attributes": attributes, "dimension_names": dimensions}))
    for index, part in chunks_of(values, chunks):
        file = to.joinpath("c", *map(str, index))
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(part)


def climate(put, field, offset=0.0):
    put("time", np.array([12, 0, 6]), ["time"], **TIME)
    put("lev", np.array(LEV), ["lev"], units="m", positive="up", axis="Z")
    put("lat", np.array(LAT), ["lat"], units="degrees_north", bounds="lat_bnds")
    put("lon", (LON * 10).astype("i2"), ["lon"], units="degrees_east", scale_factor=0.1)
    put("lat_bnds", np.stack([np.array(LAT) + 5, np.array(LAT) - 5], -1), ["lat", "nv"])
    axes = ["time", "lev", "lat", "lon"]
    fields = np.stack([field + 1000 * i for i in (2, 0, 1)]) + offset
    t = fields.astype("f4")
    t[1, 0, 0, 0] = -999
    put("T", t, axes, -999.0, (1, 2, 5, 4), units="K")
    packed = fields.astype("i2")
    packed[1, 0, 0, :2] = -32767
    put("packed", packed, axes, -32767, scale_factor=0.5, add_offset=100.0)
    put("whole", np.where(fields == 1, -1, fields).astype("i4"), axes, -1)
    put("surface", t[:, 0], ["time", "lat", "lon"])


def expect_climate(name, lattice):
    arrays = {"T": [1, 345, 1], "packed": [101, 272.5, 2], "whole": [0, 345, 1]}
    lattice(name, arrays, BOUNDS, [25, -10, 30, "T", 235], [0, 6, 12], 0, grid="rectilinear")
    lattice(name, {"T": [2000, 2345, 0]}, BOUNDS, [25, -10, 30, "T", 2235], [0, 6, 12], 2, grid="rectilinear")


def write(field, lattice, expect):
    for folder in ("climate.zarr", "deep.zarr/run"):
        climate(functools.partial(version_2, folder), field)
        version_2(folder, "crs", np.array(0), [], grid_mapping_name="latitude_longitude")
        version_2(folder, "station", np.zeros(5, "i8"), ["lat"], dtype="|O")
        expect_climate(folder, lattice)
    pathlib.Path("deep.zarr/.zgroup").write_text('{"zarr_format": 2}')

    def third(name, values, dimensions, fill=0, chunks=None, **attributes):
        if fill:  # as xarray has it: a number for whole ones, eight bytes as text for real ones
            attributes["_FillValue"] = fill if np.asarray(values).dtype.kind == "i" else base64.b64encode(np.array(fill, "<f8").tobytes()).decode()
        version_3("climate3.zarr", name, values, dimensions, fill, chunks, **attributes)

    climate(third, field)
    pathlib.Path("climate3.zarr/zarr.json").write_text(json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {}}))
    expect_climate("climate3.zarr", lattice)

    # Longitudes and latitudes over two axes, depths over three; nothing is said of one point.
    y, x = np.mgrid[0:field.shape[1], 0:field.shape[2]].astype("f8")
    deep = np.stack([(k + 1) * (4 + x) for k in range(field.shape[0])])
    deep[0, 0, 0] = np.nan
    for name, put in (("curved.zarr", version_2), ("curved3.zarr", version_3)):
        more = {"fill": "NaN"}
        put(name, "lon", 10 + x + y / 2, ["j", "i"], units="degrees_east", **more)
        put(name, "lat", 40 + y - x / 4, ["j", "i"], units="degrees_north", **more)
        put(name, "deep", deep, ["k", "j", "i"], positive="down", **more)
        put(name, "T", np.stack([field, field + 1000]).astype("f4"), ["time", "k", "j", "i"], coordinates="lon lat deep", **more)
        expect(name, "curvilinear", field.size, 60, {"T": [1000, 1345, 0]}, [10, 17, 38.75, 44, -36, -4], [16.5, 41.75, -27, "T", 1235], [0, 1], 1)
    pathlib.Path("curved3.zarr/zarr.json").write_text(json.dumps({"zarr_format": 3, "node_type": "group", "attributes": {}}))

    # Axes in another order, time behind them, without coordinates.
    version_2("turned_fields", "p", np.stack([field.T, field.T + 1000], -1), ["x", "y", "z", "time"])
    lattice("turned_fields", {"p": [1000, 1345, 0]}, [0, 5, 0, 4, 0, 3], [5, 3, 2, "p", 1235], [0, 1], 1)
