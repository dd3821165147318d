"""netCDF files of what programs write beside float variables over axes that all say what they are, for write_files.py."""

import shutil

import netCDF4
import numpy as np

SPACE = ("z", "y", "x")
PLACED = (("lev", "lev", [0, 10, 30, 70], {"units": "m"}), ("lat", "lat", [-20, -10, 0, 10, 20], {"units": "degrees_north"}), ("lon", "lon", np.arange(6) * 5, {"units": "degrees_east"}))
PLACES = [0, 25, -20, 20, 0, 70]
UNIT = [0, 5, 0, 4, 0, 3]


def opened(name, sizes, format="NETCDF4"):
    file = netCDF4.Dataset(name, "w", format=format)
    file.set_fill_on()
    for dimension, size in sizes:
        file.createDimension(dimension, size)
    return file


def stored(file, name, type, dimensions, values, fill=None, **attributes):
    variable = file.createVariable(name, type, dimensions, fill_value=fill)
    variable.set_auto_maskandscale(False)
    variable.setncatts(attributes)
    if values is not None:
        variable[:] = values
    return variable


def axis(file, name, dimension, values, attributes):
    stored(file, name, "f8", (dimension,), values, **attributes)


def types(field, lattice):
    sizes = list(zip(SPACE, field.shape))
    wholes = {"i1": field % 100 - 50, "i2": -field, "i4": -field * 1000, "i8": field * 1e9, "u1": field % 200, "u2": field * 100, "u4": field * 1e6, "u8": field * 1e12}
    for name, format, kinds in (("types.nc", "NETCDF4", wholes), ("types5.nc", "NETCDF3_64BIT_DATA", wholes), ("bytes.nc", "NETCDF3_CLASSIC", ["i1", "i2", "i4"]),
                                ("whole.nc", "NETCDF4", ["u1"])):
        ranges = {}
        with opened(name, sizes, format) as file:
            for kind in kinds:
                stored(file, "of_" + kind, kind, SPACE, wholes[kind].astype(kind))
                ranges["of_" + kind] = [float(wholes[kind].min()), float(wholes[kind].max()), 0]
            if name != "whole.nc":
                stored(file, "T", "f4", SPACE, field)
                ranges["T"] = [0, 345, 0]
            if name == "bytes.nc":
                stored(file, "no_sign", "i1", SPACE, (field % 200).astype("u1").view("i1"), _Unsigned="true")
                ranges["no_sign"] = [0, 145, 0]
            if name == "types.nc":
                names = file.createEnumType("u1", "names", {"rock": 0, "sand": 1})
                stored(file, "named", names, SPACE, (field % 2).astype("u1"))
                ranges["named"] = [0, 1, 0]
                file.createVariable("records", file.createCompoundType(np.dtype([("a", "f4"), ("b", "f4")]), "pair"), SPACE)
                file.createVariable("text", str, SPACE)
        first = "of_u1" if name == "whole.nc" else "T"
        lattice(name, ranges, UNIT, [5, 3, 2, first, 35 if name == "whole.nc" else 235])


def gaps(field, lattice):
    for name, format in (("gaps.nc", "NETCDF4"), ("gaps3.nc", "NETCDF3_CLASSIC")):
        with opened(name, zip(SPACE, field.shape), format) as file:
            for kind, fill in (("i2", -32767), ("i4", -9999), ("i1", -128)):
                values = (field % 100).astype(kind)
                values[0, 0, 0] = fill
                stored(file, "filled_" + kind, kind, SPACE, values, fill)
            stored(file, "unfilled", "i2", SPACE, field.astype("i2"), -1)
            for kind in ("f4", "f8", "i2", "i4"):
                stored(file, "half_" + kind, kind, SPACE, None)[:2] = field[:2].astype(kind)
            stored(file, "range", "i2", SPACE, field.astype("i2"), valid_range=np.array([10, 300], "i2"))
            stored(file, "two", "f4", SPACE, field, missing_value=np.array([1, 345], "f4"))
        lattice(name, {**{"filled_" + kind: [0, 45, 1] for kind in ("i2", "i4", "i1")}, "unfilled": [0, 345, 0], "range": [10, 300, 35], "two": [0, 344, 2],
                       **{"half_" + kind: [0, 145, 60] for kind in ("f4", "f8", "i2", "i4")}}, UNIT, [5, 3, 1, "half_i4", 135])


def steps(field, lattice):
    """A first axis that does not say that it is time; times that go back or are there twice."""
    at = [25, 10, 30, "T"]
    for name, times, attributes, order in (("nothing_said.nc", [5, 6, 8], {}, [0, 1, 2]), ("years.nc", [2000, 2001, 2002], {"units": "year AD"}, [0, 1, 2]), ("no_times.nc", None, {}, [0, 1, 2]),
                                           ("back.nc", [2, 1, 0], {"units": "days since 2000-01-01"}, [2, 1, 0]), ("twice.nc", [0, 0, 1], {"units": "days since 2000-01-01"}, [0, 1, 2]),
                                           ("restart.nc", [0, 2, 1], {"units": "days since 2000-01-01"}, [0, 2, 1])):
        with opened(name, [("time", None), *((d, len(v)) for d, _, v, _ in PLACED)]) as file:
            for dimension, called, values, of_axis in PLACED:
                axis(file, called, dimension, values, of_axis)
            if times:
                axis(file, "time", "time", times, attributes)
            stored(file, "T", "f4", ("time", "lev", "lat", "lon"), np.stack([field + 1000 * t for t in range(3)]))
        for step, t in enumerate(order):
            lattice(name, {"T": [1000 * t, 1000 * t + 345, 0]}, PLACES, at + [1000 * t + 235], sorted(times or range(3)), step, grid="rectilinear")


def series(field, lattice):
    for name, times in (("run_1.nc", [0, 0, 1]), ("run_2.nc", [2, 3])):
        with opened(name, [("time", None), *zip(SPACE, field.shape)]) as file:
            axis(file, "time", "time", times, {"units": "s"})
            stored(file, "T", "f4", ("time", *SPACE), np.stack([field + 1000 * t for t in range(len(times))]))
    lattice("run_*.nc", {"T": [1000, 1345, 0]}, UNIT, [5, 3, 2, "T", 1235], [0, 0, 1, 2, 3], 1)


def axes(field, lattice, expect):
    said = {"lon": {"units": "degrees_east"}, "lat": {"units": "degrees_north"}, "lev": {"units": "hPa"}}
    letters = {name: {"axis": letter} for name, letter in zip(("lon", "lat", "lev"), "XYZ")}
    places = {"lon": np.arange(6) * 5.0, "lat": np.arange(5) * 10.0 - 20, "lev": np.array([0, 10, 30, 70.0])}
    for name, attributes, order in (("lon_first.nc", said, ("lon", "lat", "lev")), ("lat_first.nc", letters, ("lat", "lon", "lev"))):
        with opened(name, [(d, len(places[d])) for d in order]) as file:
            for dimension in order:
                axis(file, dimension, dimension, places[dimension], attributes[dimension])
            stored(file, "T", "f4", order, field.transpose([("lev", "lat", "lon").index(d) for d in order]))
        down = attributes is said  # a pressure falls upwards, whether or not it says so
        lattice(name, {"T": [0, 345, 0]}, [*PLACES[:4], -70, 0] if down else PLACES, [25, 10, -30 if down else 30, "T", 235], grid="rectilinear")
    for name, levels, kind in (("millibars.nc", [100, 200, 300, 400], "uniform"), ("pascals.nc", [1e5, 8.5e4, 5e4, 1e4], "rectilinear")):
        with opened(name, zip(SPACE, field.shape)) as file:
            axis(file, "z", "z", levels, {"units": name[:-3], "standard_name": "air_pressure"} if kind == "uniform" else {"units": "Pa"})
            stored(file, "T", "f4", SPACE, field)
        lattice(name, {"T": [0, 345, 0]}, [0, 5, 0, 4, -max(levels), -min(levels)], [5, 3, -levels[2], "T", 235], grid=kind)
    with opened("flat_lon_first.nc", [("time", 2), ("lon", 6), ("lat", 5)]) as file:
        axis(file, "time", "time", [1, 2], {"units": "days since 2000-01-01"})
        for dimension in ("lon", "lat"):
            axis(file, dimension, dimension, places[dimension], said[dimension])
        stored(file, "T", "f4", ("time", "lon", "lat"), np.stack([field[0].T, field[0].T + 1000]))
    expect("flat_lon_first.nc", "uniform", 30, 20, {"T": [1000, 1045, 0]}, [0, 25, -20, 20, 0, 0], [25, 10, 0, "T", 1035], [1, 2], 1)
    with opened("down.nc", zip(SPACE, field.shape)) as file:
        axis(file, "z", "z", [10, 20, 30, 40], {"positive": "down"})
        stored(file, "T", "f4", SPACE, field)
    lattice("down.nc", {"T": [0, 345, 0]}, [0, 5, 0, 4, -40, -10], [5, 3, -30, "T", 235])


def refused():
    with opened("mesh.nc", [("node", 4), ("edge", 2), ("corner", 2)]) as file:
        stored(file, "mesh", "i4", (), 0, cf_role="mesh_topology", topology_dimension=1, node_coordinates="nx ny", edge_node_connectivity="corners")
        stored(file, "corners", "i4", ("edge", "corner"), [[0, 1], [2, 3]])
    for name, placed in (("no_steps.nc", True), ("no_steps_nor_times.nc", False)):
        with opened(name, [("time", None), *zip(SPACE, (2, 2, 2))]) as file:
            if placed:
                axis(file, "time", "time", None, {"units": "days since 2000-01-01"})
            stored(file, "T", "f4", ("time", *SPACE), None)
    with opened("no_time.nc", [("time", 3), *zip(SPACE, (2, 2, 2))]) as file:
        axis(file, "time", "time", [0, np.nan, 2], {"units": "days since 2000-01-01"})
        stored(file, "T", "f4", ("time", *SPACE), np.zeros((3, 2, 2, 2)))
    with opened("atoms.nc", [("frame", 2), ("atom", 20), ("spatial", 3)], "NETCDF3_64BIT_OFFSET") as file:
        file.Conventions = "AMBER"
        stored(file, "coordinates", "f4", ("frame", "atom", "spatial"), np.zeros((2, 20, 3)))


def brick(name, expect):
    """Exodus II inside HDF5: one hexahedron."""
    sizes = {"len_string": 33, "num_dim": 3, "time_step": None, "num_nodes": 8, "num_elem": 1, "num_el_blk": 1, "num_el_in_blk1": 1, "num_nod_per_el1": 8}
    with opened(name, sizes.items()) as file:
        file.setncatts({"api_version": np.float32(5.14), "version": np.float32(5.14), "floating_point_word_size": np.int32(8), "file_size": np.int32(1)})
        stored(file, "eb_prop1", "i4", ("num_el_blk",), [1]).setncattr("name", "ID")
        stored(file, "eb_status", "i4", ("num_el_blk",), [1])
        for axis_name, places in zip("xyz", ([0, 1, 1, 0, 0, 1, 1, 0], [0, 0, 2, 2, 0, 0, 2, 2], [0, 0, 0, 0, 3, 3, 3, 3])):
            stored(file, "coord" + axis_name, "f8", ("num_nodes",), places)
        stored(file, "connect1", "i4", ("num_el_in_blk1", "num_nod_per_el1"), [range(1, 9)], elem_type="HEX8")
        stored(file, "time_whole", "f8", ("time_step",), [0.0])
        stored(file, "vals_nod_var1", "f8", ("time_step", "num_nodes"), [range(8)])
        names = file.createVariable("name_nod_var", "S1", (file.createDimension("num_nod_var", 1).name, "len_string"))
        names[0, 0] = "f"
    shutil.copy(name, "unsaid.e")  # as meshio writes it: arrays where those of large files are, and no word of it
    with netCDF4.Dataset("unsaid.e", "a") as file:
        file.delncattr("file_size")
    expect(name, "unstructured", 8, 1, {"f": [0, 7, 0]}, [0, 1, 0, 2, 0, 3], [1, 2, 3, "f", 6])


def many_axes(field, lattice):
    """An axis of one place beside time and space."""
    with opened("member.nc", [("time", None), ("member", 1), *zip(SPACE, field.shape)]) as file:
        axis(file, "time", "time", [0, 1], {"units": "s"})
        stored(file, "T", "f4", ("time", "member", *SPACE), np.stack([field, field + 1000])[:, None])
    lattice("member.nc", {"T": [1000, 1345, 0]}, UNIT, [5, 3, 2, "T", 1235], [0, 1], 1)


def groups(field, lattice):
    """Values in a group; what says where they are beside them, in a group around theirs, or in another one."""
    both = np.stack([field, field + 1000])
    for name, where in (("beside.nc", "run/first"), ("around.nc", "run"), ("at_root.nc", ""), ("elsewhere.nc", "axes"), ("of_root.nc", "axes")):
        with opened(name, [("time", None), *((d, len(v)) for d, _, v, _ in PLACED)]) as file:
            of_axes = file.createGroup(where) if where else file
            for dimension, called, values, said in PLACED:
                axis(of_axes, called, dimension, values, said)
            axis(of_axes, "time", "time", [3, 5], {"units": "hours since 2000-01-01"})
            stored(file if name == "of_root.nc" else file.createGroup("run/first"), "T", "f4", ("time", "lev", "lat", "lon"), both, units="K")
            stored(file, "bounds", "f4", ("lat", "lon"), field[0])
        array = "T" if name == "of_root.nc" else "run/first/T"
        lattice(name, {array: [1000, 1345, 0]}, PLACES, [25, 10, 30, array, 1235], [3, 5], 1, grid="rectilinear")


def time_behind(field, lattice, expect):
    both = np.stack([field, field + 1000], -1)
    for name, order in (("xyzt.nc", ("lon", "lat", "lev")), ("zyxt.nc", ("lev", "lat", "lon"))):
        with opened(name, [*((d, len(v)) for d, _, v, _ in PLACED), ("time", 2)], "NETCDF3_CLASSIC") as file:
            for dimension, called, values, said in PLACED:
                axis(file, called, dimension, values, {**said, "positive": "up"} if called == "lev" else said)
            axis(file, "time", "time", [3, 5], {"units": "hours since 2000-01-01"})
            stored(file, "T", "i2", (*order, "time"), both.transpose([("lev", "lat", "lon").index(d) for d in order] + [3]), scale_factor=0.5)
        for step in range(2):
            lattice(name, {"T": [500 * step, 500 * step + 172.5, 0]}, PLACES, [25, 10, 30, "T", 500 * step + 117.5], [3, 5], step, grid="rectilinear")
    with opened("xyt.nc", [("x", 6), ("y", 5), ("t", 2)]) as file:
        axis(file, "t", "t", [3, 5], {"axis": "T"})
        stored(file, "T", "f4", ("x", "y", "t"), both[0].transpose(1, 0, 2))
    with opened("icon.nc", [("time", 2), ("y", 5), ("x", 6)]) as file:  # a unit of days that only its own programs know
        axis(file, "time", "time", [20200101, 20200101.25], {"units": "day as %Y%m%d.%f"})
        stored(file, "T", "f4", ("time", "y", "x"), np.moveaxis(both[0], -1, 0))
    expect("icon.nc", "uniform", 30, 20, {"T": [1000, 1045, 0]}, [0, 5, 0, 4, 0, 0], [5, 3, 0, "T", 1035], [20200101, 20200101.25], 1)
    expect("xyt.nc", "uniform", 30, 20, {"T": [1000, 1045, 0]}, [0, 5, 0, 4, 0, 0], [5, 3, 0, "T", 1035], [3, 5], 1)


def packed(field, lattice):
    """What is valid of packed values: in the numbers that are stored, or, of the values' own type, in these."""
    scale = {"scale_factor": 0.5, "add_offset": 100.0}  # 0 to 345 are 100 to 272.5
    ranges = {"stored": ({"valid_range": np.array([10, 300], "i2")}, [105, 250, 35]), "meant": ({"valid_range": np.array([105, 250], "f8")}, [105, 250, 35]),
              "ends": ({"valid_min": np.int16(10), "valid_max": np.float32(250)}, [105, 250, 35])}
    with opened("valid.nc", zip(SPACE, field.shape)) as file:
        for name, (valid, _) in ranges.items():
            stored(file, name, "i2", SPACE, field.astype("i2"), **scale, **valid)
        stored(file, "down", "i2", SPACE, field.astype("i2"), scale_factor=-0.5, valid_range=np.array([-150, -5], "f4"))
        stored(file, "rounded", "i2", SPACE, field.astype("i2"), scale_factor=np.float32(0.1), valid_max=np.float32(30))
        no_sign = (field * 180).astype("u2").view("i2")  # up to 62100
        stored(file, "no_sign", "i2", SPACE, no_sign, np.int16(-3436), _Unsigned="true", scale_factor=0.5, valid_range=np.array([1800, 54000], "u2").view("i2"))
    tenth = float(np.float32(0.1))
    lattice("valid.nc", {**{name: facts for name, (_, facts) in ranges.items()}, "down": [-150, -5, 35], "rounded": [0, 300 * tenth, 29],
                         "no_sign": [900, 27000, 35]}, UNIT, [5, 3, 2, "stored", 217.5])


def odd_places(field, lattice):
    """Places and times as packed numbers, as satellites have them; places that have names."""
    both = np.stack([field, field + 1000])
    with opened("packed_places.nc", [("time", 2), *((d, len(v)) for d, _, v, _ in PLACED)]) as file:
        for dimension, called, values, said in PLACED:
            stored(file, called, "i2", (dimension,), np.array(values) * 4 - 100, scale_factor=0.25, add_offset=25.0, **said)
        stored(file, "time", "i2", ("time",), [6, 10], units="hours since 2000-01-01", scale_factor=0.5)
        stored(file, "T", "f4", ("time", "lev", "lat", "lon"), both)
    lattice("packed_places.nc", {"T": [1000, 1345, 0]}, PLACES, [25, 10, 30, "T", 1235], [3, 5], 1, grid="rectilinear")
    with opened("named_places.nc", [("time", 2), ("band", 4), ("y", 5), ("x", 6)]) as file:
        file.createVariable("band", str, ("band",))[:] = np.array(["red", "green", "blue", "nir"], dtype=object)
        for name, count in (("y", 5), ("x", 6)):
            axis(file, name, name, np.arange(count) * 10.0, {"units": "m"})
        axis(file, "time", "time", [3, 5], {"units": "hours since 2000-01-01"})
        stored(file, "T", "f4", ("time", "band", "y", "x"), both)
    lattice("named_places.nc", {"T": [1000, 1345, 0]}, [0, 50, 0, 40, 0, 3], [50, 30, 2, "T", 1235], [3, 5], 1)


def curves(field, expect):
    """Longitudes and latitudes over two axes; depths by levels, by a formula, over three axes, or none; in a group; where nothing is, and across the end of the turn."""
    depth, height, width = field.shape
    y, x = np.mgrid[0:height, 0:width].astype("f8")
    lon, lat = 10 + x + y / 2, 40 + y - x / 4
    steps = np.stack([field, field + 1000])
    box = [10, 17, 38.75, 44]

    def dataset(name, time, z, y, x, group=None):
        file = opened(name, [] if group else [(time, 2), (z, depth), (y, height), (x, width)])
        inner = file.createGroup(group) if group else file
        if group:
            for dimension, size in ((time, 2), (z, depth), (y, height), (x, width)):
                inner.createDimension(dimension, size)
        return file, inner

    def check(name, places, at, times=(0, 1), array="T", step=1, points=None):
        expect(name, "curvilinear", field.size, (width - 1) * (height - 1) * (depth - 1), {array: [1000, 1345, 0]}, box + places, [*at, array, 1235], times, step)

    for name, group in (("nemo.nc", None), ("nemo_in_group.nc", "run")):
        file, of = dataset(name, "time_counter", "deptht", "y", "x", group)
        axis(of, "time_counter", "time_counter", [0, 86400], {"units": "seconds since 2000-01-01"})
        axis(of, "deptht", "deptht", [1, 5, 20, 60], {"units": "m", "positive": "down"})
        stored(of, "nav_lon", "f4", ("y", "x"), lon, units="degrees_east")
        stored(of, "nav_lat", "f4", ("y", "x"), lat, units="degrees_north")
        stored(of, "T", "f4", ("time_counter", "deptht", "y", "x"), steps, coordinates="nav_lat nav_lon deptht")
        file.close()
        check(name, [-60, -1], [16.5, 41.75, -20], [0, 86400], array="run/T" if group else "T")

    file, of = dataset("wrf.nc", "Time", "bottom_top", "south_north", "west_east")
    for name, values, unit in (("XLONG", lon, "degree_east"), ("XLAT", lat, "degree_north")):
        stored(of, name, "f4", ("Time", "south_north", "west_east"), np.stack([values - 100, values]), units=unit)
    stored(of, "T", "f4", ("Time", "bottom_top", "south_north", "west_east"), steps, coordinates="XLONG XLAT XTIME")
    file.close()
    check("wrf.nc", [0, 3], [16.5, 41.75, 2])

    for kind in ("g1", "g2"):
        file, of = dataset(f"roms_{kind}.nc", "ocean_time", "s_rho", "eta_rho", "xi_rho")
        axis(of, "ocean_time", "ocean_time", [0, 1], {"units": "days since 2000-01-01"})
        axis(of, "s_rho", "s_rho", [-0.875, -0.625, -0.375, -0.125], {"positive": "up", "standard_name": "ocean_s_coordinate_" + kind, "formula_terms": "s: s_rho C: Cs_r eta: zeta depth: h depth_c: hc"})
        stored(of, "Cs_r", "f8", ("s_rho",), [-0.75, -0.5, -0.25, -0.0625])
        stored(of, "hc", "f8", (), 10.0)
        stored(of, "h", "f8", ("eta_rho", "xi_rho"), 100 + 10 * x)
        stored(of, "zeta", "f8", ("ocean_time", "eta_rho", "xi_rho"), np.stack([0 * x, 0 * x + 2]))
        stored(of, "lon_rho", "f8", ("eta_rho", "xi_rho"), lon, units="degree_east")
        stored(of, "lat_rho", "f8", ("eta_rho", "xi_rho"), lat, units="degree_north")
        stored(of, "T", "f4", ("ocean_time", "s_rho", "eta_rho", "xi_rho"), steps, coordinates="lon_rho lat_rho s_rho ocean_time")
        file.close()

        def z(s, c, h, zeta=2.0, hc=10.0):
            if kind == "g2":
                return zeta + (zeta + h) * (hc * s + h * c) / (hc + h)
            part = hc * s + (h - hc) * c
            return part + zeta * (1 + part / h)

        check(f"roms_{kind}.nc", [z(-0.875, -0.75, 150.0), z(-0.125, -0.0625, 100.0)], [16.5, 41.75, z(-0.375, -0.25, 150.0)])

    for name, turn in (("deep.nc", 0), ("round.nc", 360)):
        file, of = dataset(name, "time", "k", "j", "i")
        axis(of, "time", "time", [0, 1], {"units": "days since 2000-01-01"})
        deep = np.stack([(k + 1) * (4 + x) for k in range(depth)])
        east = lon + 165 - turn * (lon > 15)
        if not turn:
            deep[3, 4, 5] = 1e20
            east[0, 0] = np.nan
        stored(of, "east", "f8", ("j", "i"), east, units="degrees_east")
        stored(of, "north", "f8", ("j", "i"), lat, units="degrees_north")
        stored(of, "deep", "f8", ("k", "j", "i"), deep, 1e20, positive="down", units="m")
        stored(of, "T", "f4", ("time", "k", "j", "i"), steps, coordinates="east north deep")
        file.close()
        expect(name, "curvilinear", field.size, 60, {"T": [1000, 1345, 0]}, [175.5 if not turn else 175, 182, 38.75, 44, -36, -4], [181.5, 41.75, -27, "T", 1235], [0, 1], 1)


def members(field):
    """An ensemble with times: five axes of more than one place."""
    with netCDF4.Dataset("members.nc", "w") as d:
        for name, size in zip(("member", "time", "z", "y", "x"), (3, 2, *field.shape)):
            d.createDimension(name, size)
        d.createVariable("T", "f4", ("member", "time", "z", "y", "x"))[:] = np.broadcast_to(field, (3, 2, *field.shape))


def cells_on_the_globe(expect):
    """Triangles in layers, by radians, with steps, as of ICON; quadrilaterals, as CDO makes them, across the date line; hexagons; and such without corners."""
    def write(name, outlines, unit, coordinates, levels=None, bounds=True):
        with netCDF4.Dataset(name, "w") as d:
            outlines = np.array(outlines, float) * (np.pi / 180 if unit == "radian" else 1)
            d.createDimension("ncells", len(outlines))
            d.createDimension("vertices", outlines.shape[1])
            for axis, (called, standard) in enumerate(zip(coordinates, ("longitude", "latitude"))):
                v = d.createVariable(called, "f8", ("ncells",))
                v.standard_name, v.units = standard, unit
                v[:] = outlines[:, :, axis].mean(1)
                if bounds:
                    v.bounds = called + "_bounds"
                    d.createVariable(called + "_bounds", "f8", ("ncells", "vertices"))[:] = outlines[:, :, axis]
            d.createDimension("time", None)
            t = d.createVariable("time", "f8", ("time",))
            t.units = "days since 2000-01-01"
            t[:] = [0.5, 1.5]
            axes = ("time", "ncells")
            if levels:
                d.createDimension("height", len(levels))
                z = d.createVariable("height", "f8", ("height",))
                z.units, z.positive, z.axis = "m", "up", "Z"
                z[:] = levels
                axes = ("time", "height", "ncells")
                d.createVariable("ground", "f4", ("ncells",)).coordinates = " ".join(reversed(coordinates))
            v = d.createVariable("v", "f4", axes, fill_value=-99)
            v.units, v.CDI_grid_type, v.coordinates = "K", "unstructured", " ".join(reversed(coordinates))
            cell = np.arange(len(outlines))
            first = np.stack([cell * 0 + 100 * k for k in range(len(levels))]) if levels else cell % 5 + 10 * (cell // 5)
            v[:] = np.stack([first, first + 1000])

    squares = [[(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)] for y in range(4) for x in range(5)]
    write("prisms.nc", [corners for a, b, c, d in squares for corners in ((a, b, c), (a, c, d))], "radian", ("clon", "clat"), [0, 10, 30])
    write("quads.nc", squares, "degrees", ("lon", "lat"))
    write("downward.nc", [corners for a, b, c, d in squares for corners in ((a, b, c), (a, c, d))], "radian", ("clon", "clat"), [30, 10, 0])
    expect("downward.nc", "unstructured", 120, 120, {"v": [0, 200, 0]}, [0, 5, 0, 4, -5, 40], [2, 3, 5, "v", 150], [0.5, 1.5])
    for step in range(2):
        expect("prisms.nc", "unstructured", 120, 120, {"v": [1000 * step, 1000 * step + 200, 0]}, [0, 5, 0, 4, -5, 40], [2, 3, 5, "v", 1000 * step + 50], [0.5, 1.5], step)
        expect("quads.nc", "unstructured", 30, 20, {"v": [1000 * step, 1000 * step + 34, 0]}, [0, 5, 0, 4, 0, 0], [1, 1, 0, "v", 1000 * step + 5.5], [0.5, 1.5], step)
    # A cell lies on the side of the date line that its first corner is on.
    write("date_line.nc", [[((x + 178 + 180) % 360 - 180, y) for x, y in corners] for corners in squares], "degrees", ("lon", "lat"))
    expect("date_line.nc", "unstructured", 35, 20, {"v": [0, 34, 0]}, [-180, 180, 0, 4, 0, 0], [-179, 1, 0, "v", 7.5], [0.5, 1.5])
    write("hexagon.nc", [[(2, 0), (1, 2), (-1, 2), (-2, 0), (-1, -2), (1, -2)]], "degrees", ("lon", "lat"), [0, 2])
    expect("hexagon.nc", "unstructured", 20, 28, {"v": [0, 100, 0]}, [-2, 2, -2, 2, -1, 3], [1, 2, 1, "v", 50], [0.5, 1.5])
    write("no_corners.nc", squares, "degrees", ("lon", "lat"), bounds=False)


def mesh_of_a_coast(expect):
    """By UGRID: squares and the two halves of others, nodes from 1 and no fourth corner of triangles; values on faces in layers (faces first, as Delft3D has them), on nodes at levels, and flat ones."""
    place = lambda x, y: x + 6 * y
    faces = []
    for y in range(4):
        for x in range(5):
            a, b, c, d = place(x, y), place(x + 1, y), place(x + 1, y + 1), place(x, y + 1)
            faces += [[a, b, c, d]] if x % 2 else [[a, b, c], [a, c, d]]
    nodes = np.array([(x, y) for y in range(5) for x in range(6)], float)
    middles = np.array([nodes[f].mean(0) for f in faces])
    for name, location, levels, turned in (("coast_flat.nc", "node", None, False), ("coast_faces.nc", "face", [-30, -10, 0], False), ("coast_nodes.nc", "node", [40, 10, 0], True)):
        with netCDF4.Dataset(name, "w") as d:
            for dimension, size in (("time", None), ("node", len(nodes)), ("face", len(faces)), ("corner", 4), ("layer", 3)):
                d.createDimension(dimension, size)
            m = d.createVariable("mesh", "i4", ())
            m.cf_role, m.topology_dimension, m.node_coordinates, m.face_node_connectivity = "mesh_topology", 2, "y x" if turned else "x y", "corners"
            if turned:
                m.face_dimension = "face"
            for axis, called in enumerate("xy"):
                v = d.createVariable(called, "f8", ("node",))
                v.units, v.standard_name = ("degrees_east", "longitude") if axis == 0 else ("degrees_north", "latitude")
                v[:] = nodes[:, axis]
            v = d.createVariable("corners", "i4", ("corner", "face") if turned else ("face", "corner"), fill_value=-999)
            v.start_index = np.int32(0 if turned else 1)
            table = np.array([[n + (0 if turned else 1) for n in f] + [-999] * (4 - len(f)) for f in faces])
            v[:] = table.T if turned else table
            t = d.createVariable("time", "f8", ("time",))
            t.units = "days since 2000-01-01"
            t[:] = [0.5, 1.5]
            at = middles if location == "face" else nodes
            value = at[:, 0] + 10 * at[:, 1]
            if levels is None:
                axes, values = ("time", location), value
                v = d.createVariable("on_faces", "f4", ("face",))
                v.mesh, v.location = "mesh", "face"
                v[:] = np.arange(len(faces))
            else:
                v = d.createVariable("layer_z" if location == "face" else "layer", "f8", ("layer",))
                v.units, v.positive, v.standard_name = "m", "down" if turned else "up", "depth" if turned else "altitude"
                v[:] = levels
                axes = ("time", location, "layer") if location == "face" else ("time", "layer", location)
                values = 0 * value[:, None] + 100 * np.arange(3) if location == "face" else value + 100 * np.arange(3)[:, None]
            v = d.createVariable("v", "f4", axes)
            v.units, v.mesh, v.location = "K", "mesh", location
            v[:] = np.stack([values, values + 1000])
            v = d.createVariable("of_edges", "f4", ("node",))
            v.mesh, v.location = "mesh", "edge"
            v[:] = 0
    for step in range(2):
        expect("coast_flat.nc", "unstructured", 30, len(faces), {"v": [1000 * step, 1000 * step + 45, 0], "on_faces": [0.5, len(faces) - 1.5, 0]}, [0, 5, 0, 4, 0, 0], [3, 2, 0, "v", 1000 * step + 23], [0.5, 1.5], step)
        expect("coast_nodes.nc", "unstructured", 90, 2 * len(faces), {"v": [1000 * step, 1000 * step + 245, 0]}, [0, 5, 0, 4, -40, 0], [3, 2, -10, "v", 1000 * step + 123], [0.5, 1.5], step)
        expect("coast_faces.nc", "unstructured", 120, 3 * len(faces), {"v": [1000 * step, 1000 * step + 200, 0]}, [0, 5, 0, 4, -40, 5], [1, 1, -20, "v", 1000 * step + 50], [0.5, 1.5], step)


def write(field, lattice, expect):
    mesh_of_a_coast(expect)
    members(field)
    cells_on_the_globe(expect)
    odd_places(field, lattice)
    curves(field, expect)
    groups(field, lattice)
    time_behind(field, lattice, expect)
    packed(field, lattice)
    types(field, lattice)
    gaps(field, lattice)
    steps(field, lattice)
    series(field, lattice)
    many_axes(field, lattice)
    axes(field, lattice, expect)
    with opened("group.nc", zip(SPACE, field.shape)) as file:
        stored(file.createGroup("run"), "T", "f4", SPACE, field)
    lattice("group.nc", {"run/T": [0, 345, 0]}, UNIT, [5, 3, 2, "run/T", 235])
    for name in ("brick.nc", "brick.h5"):
        brick(name, expect)
    refused()
