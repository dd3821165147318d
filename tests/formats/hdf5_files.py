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


def write(field, lattice):
    links(field, lattice)
    kinds(field, lattice)
    lists(field, lattice)
