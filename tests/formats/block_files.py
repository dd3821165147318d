"""Blocks of cells in levels as FLASH and Athena++ write them in HDF5, for write_files.py: the same blocks in both."""

import h5py
import numpy as np

N = 4
# Corner and level: two blocks side by side, of which the first is refined, and the first of its children once more; those and their parents.
ROOTS = [((0.0, 0.0, 0.0), 0), ((4.0, 0.0, 0.0), 0)]
PARENT, REFINED = ROOTS[0], ((0.0, 0.0, 0.0), 1)


def children(corner, level):
    half = N / 2 ** (level + 1)
    return [((corner[0] + i * half, corner[1] + j * half, corner[2] + k * half), level + 1) for k in range(2) for j in range(2) for i in range(2)]


LEAVES = [ROOTS[1]] + children(*PARENT)[1:] + children(*REFINED)
PARENTS = [PARENT, REFINED]


def faces(corner, level, axis):
    return corner[axis] + np.arange(N + 1) / 2**level


def field(corner, level):
    x, y, z = (faces(corner, level, axis)[:-1] + 0.5 / 2**level for axis in range(3))
    return x[None, None, :] + 10 * y[None, :, None] + 100 * z[:, None, None]


def flash(name):
    blocks = PARENTS + LEAVES
    with h5py.File(name, "w") as file:
        file["bounding box"] = np.array([[(c[a], c[a] + N / 2**level) for a in range(3)] for c, level in blocks])
        file["node type"] = np.array([2] * len(PARENTS) + [1] * len(LEAVES), "i4")
        file["refine level"] = np.array([level + 1 for _, level in blocks], "i4")
        file["coordinates"] = np.array([[c[a] + N / 2 ** (level + 1) for a in range(3)] for c, level in blocks])
        file["gid"] = np.zeros((len(blocks), 15), "i4")
        file["unknown names"] = np.array([[b"dens"], [b"pres"]], "S4")
        file["dens"] = np.array([field(*block) for block in blocks])
        file["pres"] = np.array([2 * field(*block) for block in blocks], "f4")
        table = np.dtype([("name", "S80"), ("value", "f8")])
        file["real scalars"] = np.array([(b"dt".ljust(80), 0.1), (b"time".ljust(80), 2.5)], table)


def athena(name):
    with h5py.File(name, "w") as file:
        file.attrs["Time"] = np.float64(2.5)
        file.attrs["VariableNames"] = np.array([b"dens", b"pres"], "S21")
        file.attrs["DatasetNames"] = np.array([b"prim"], "S21")
        file.attrs["Coordinates"] = np.bytes_(b"cartesian")
        file["Levels"] = np.array([level for _, level in LEAVES], "i4")
        file["LogicalLocations"] = np.array([[int(c[a] / (N / 2**level)) for a in range(3)] for c, level in LEAVES], "i8")
        for axis in range(3):
            file[f"x{axis + 1}f"] = np.array([faces(c, level, axis) for c, level in LEAVES], "f4")
        file["prim"] = np.array([[field(*block) for block in LEAVES], [2 * field(*block) for block in LEAVES]], "f4")


def write():
    flash("sedov_hdf5_chk_0001")
    athena("blast.athdf")
    with h5py.File("stretched.athdf", "w") as file:
        file["Levels"] = np.zeros(1, "i4")
        for axis in range(3):
            file[f"x{axis + 1}f"] = np.array([[0, 1, 2.5, 4.75]], "f4")
    with h5py.File("damaged_hdf5_chk_0001", "w") as file:
        file["bounding box"] = np.zeros((3, 2, 2))
        file["node type"] = np.ones(3, "i4")
        file["refine level"] = np.ones(3, "i4")
        file["dens"] = np.zeros((3, 4, 4, 4))
    with h5py.File("far_hdf5_chk_0001", "w") as file:
        file["bounding box"] = np.array([[[0, 4]] * 3, [[2, 6]] * 3])
        file["node type"] = np.ones(2, "i4")
        file["refine level"] = np.ones(2, "i4")
        file["dens"] = np.zeros((2, 4, 4, 4))
