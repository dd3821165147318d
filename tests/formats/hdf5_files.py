"""HDF5 as people's programs write it beside plain arrays, for write_files.py."""

import h5py
import numpy as np

UNIT = [0, 5, 0, 4, 0, 3]


def links(field, lattice):
    with h5py.File("links.h5", "w") as file:
        file["run/x"] = field
        file["run/itself"] = file["run"]
        file["again"] = h5py.SoftLink("/run/x")
        file["nothing"] = h5py.SoftLink("/nowhere")
        file["elsewhere"] = h5py.ExternalLink("not_there.h5", "/x")
        file["type"] = np.dtype("f4")
        file.create_dataset("named", data=field.astype("f4") / 2, dtype=file["type"])
    lattice("links.h5", {"run/x": [0, 345, 0], "again": [0, 345, 0], "named": [0, 172.5, 0]}, UNIT, [5, 3, 2, "run/x", 235])


def kinds(field, lattice):
    with h5py.File("kinds.h5", "w") as file:
        file["above"] = field > 100
        file.create_dataset("named", data=(field % 3).astype("u1"), dtype=h5py.enum_dtype({"A": 0, "B": 1, "C": 2}, "u1"))
        file["long"] = field.astype("g")
        file["half"] = field.astype("f2")
    lattice("kinds.h5", {"above": [0, 1, 0], "named": [0, 2, 0], "long": [0, 345, 0], "half": [0, 345, 0]}, UNIT, [5, 3, 2, "above", 1])
    with h5py.File("user_block.h5", "w", userblock_size=1024) as file:
        file["x"] = field
    lattice("user_block.h5", {"x": [0, 345, 0]}, UNIT, [5, 3, 2, "x", 235])


def vectors(field, lattice):
    with h5py.File("two_vectors.h5", "w") as file:
        file["u"] = np.stack([field, 2 * field, 3 * field], -1)
        file["v"] = np.stack([4 * field, 5 * field, 6 * field], -1)
    lattice("two_vectors.h5", {"u_x": [0, 345, 0], "u_z": [0, 1035, 0], "v_x": [0, 1380, 0], "v_z": [0, 2070, 0]}, UNIT, [5, 3, 2, "v_y", 1175])


def lists(field, lattice):
    with h5py.File("lists.h5", "w") as file:
        file["Mesh/geometry"] = np.zeros((500, 3))
        file["Mesh/topology"] = np.zeros((2000, 4), "i8")
    with h5py.File("lists_and_values.h5", "w") as file:
        file["Mesh/topology"] = np.zeros((2000, 4), "i8")
        file["x"] = field
    lattice("lists_and_values.h5", {"x": [0, 345, 0]}, UNIT, [5, 3, 2, "x", 235])
    with h5py.File("packed.h5", "w") as file:
        file.create_dataset("x", data=field, chunks=(2, 2, 2), compression="lzf")


def imaris(field, lattice):
    """As Imaris has it: attributes of single letters, arrays as large as their chunks need, a coarser level beside the finest."""
    depth, height, width = field.shape
    with h5py.File("cells.ims", "w") as file:
        def says(group, **attributes):
            for name, value in attributes.items():
                file.require_group(group).attrs[name] = np.array(list(str(value)), "S1")

        says("DataSetInfo/Image", X=width, Y=height, Z=depth, ExtMin0=1, ExtMax0=4, ExtMin1=0, ExtMax1=5, ExtMin2=-4, ExtMax2=4, Unit="um")
        says("DataSetInfo/Channel 0", Name="nuclei")
        says("DataSetInfo/Channel 1", Name="(name not specified)")
        says("DataSetInfo/TimeInfo", TimePoint1="2024-02-28 23:59:30.500", TimePoint2="2024-02-29 00:00:00.000")
        for level in range(2):
            for time in range(2):
                for channel, values in enumerate((field + 1000 * time, field * (1 + time))):
                    path = f"DataSet/ResolutionLevel {level}/TimePoint {time}/Channel {channel}"
                    values = values[:, ::level + 1, ::level + 1]
                    padded = np.full([-(-n // 4) * 4 for n in values.shape], 9999, "u2")
                    padded[tuple(map(slice, values.shape))] = values
                    file.create_dataset(path + "/Data", data=padded, chunks=(4, 4, 4), compression="gzip")
                    says(path, ImageSizeX=values.shape[2], ImageSizeY=values.shape[1], ImageSizeZ=values.shape[0])
    with h5py.File("no_size.ims", "w") as file:
        file["DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data"] = field
        file.create_group("DataSetInfo")
    for time in range(2):
        lattice("cells.ims", {"nuclei": [1000 * time, 1000 * time + 345, 0], "channel 1": [0, 345 * (1 + time), 0]}, [1.25, 3.75, 0.5, 4.5, -3, 3], [3.75, 3.5, 1, "nuclei", 1000 * time + 235], [0, 29.5], time)


def empty(field, lattice):
    """Beside values a list that nobody has added to, and alone."""
    for name in ("beside_empty.h5", "only_empty.h5"):
        with h5py.File(name, "w") as file:
            file.create_dataset("a", (0, 4, 5), maxshape=(None, 4, 5))
            if name == "beside_empty.h5":
                file["b"] = field
    lattice("beside_empty.h5", {"b": [0, 345, 0]}, [0, 5, 0, 4, 0, 3], [5, 3, 2, "b", 235])


def sizes(field, lattice):
    """As Fiji and ilastik say how large an element is, z first, in micrometres; units as h5py and as Fortran write them."""
    with h5py.File("sizes.h5", "w") as file:
        file["t0/channel0"] = field
        file["t0/channel0"].attrs["element_size_um"] = np.array([2, 0.5, 0.25], "f4")
        file["t0/channel0"].attrs["units"] = "counts"
        file["t0/other"] = field
        file["t0/other"].attrs["Units"] = np.bytes_("V  ")
    lattice("sizes.h5", {"t0/channel0": [0, 345, 0]}, [0, 1.25, 0, 2, 0, 6], [1.25, 1.5, 4, "t0/channel0", 235])


def write(field, lattice):
    sizes(field, lattice)
    empty(field, lattice)
    imaris(field, lattice)
    links(field, lattice)
    kinds(field, lattice)
    vectors(field, lattice)
    lists(field, lattice)
