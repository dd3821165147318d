"""Files of MED (Salome, Code_Aster) as its library lays them out in HDF5, for write_files.py: numbers of one axis or component after the other, nodes counted from 1."""

import h5py
import numpy as np

from mesh_files import HEXAHEDRON, NX, NY, NZ, PYRAMID, TETRAHEDRON, WEDGE, boxes, field

# The corners of each node behind the corners; cells are those of VTK seen from the other side.
SECOND = {"T10": (TETRAHEDRON, [0, 2, 1, 3], [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)], 1),
          "P13": (PYRAMID, [0, 3, 2, 1, 4], [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)], 2),
          "P15": (WEDGE, [0, 2, 1, 3, 5, 4], [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)], 3),
          "H20": (HEXAHEDRON, [0, 3, 2, 1, 4, 7, 6, 5], [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)], 6)}
NONE = "-0000000000000000001"


class Med:
    def __init__(self, name):
        self.file = h5py.File(name, "w")
        self.file.create_group("INFOS_GENERALES").attrs.update({"MAJ": 4, "MIN": 0, "REL": 0})

    def mesh(self, name, points, cells):
        """cells: {type: [[node, ...], ...]}, from 0."""
        mesh = self.file.create_group(f"ENS_MAA/{name}")
        mesh.attrs.update({"DIM": 3, "ESP": points.shape[1], "TYP": 0, "UNI": np.bytes_("m".ljust(16) * 3), "NOM": np.bytes_("X" + " " * 15)})
        step = mesh.create_group(NONE + NONE)
        step.attrs.update({"NDT": -1, "NOR": -1, "PDT": -1.0})
        coordinates = step.create_dataset("NOE/COO", data=points.T.ravel().astype("f8"))
        coordinates.attrs.update({"CGT": 1, "NBR": len(points)})
        for kind, ids in cells.items():
            nodes = step.create_dataset(f"MAI/{kind}/NOD", data=(np.array(ids).T.ravel() + 1).astype("i4"))
            nodes.attrs.update({"CGT": 1, "NBR": len(ids)})

    def values(self, name, mesh, number, time, entity, values, unit="", profile=None, gauss=1):
        """values: [tuples][components]; of several points [tuples][points][components]."""
        field = self.file.require_group(f"CHA/{name}")
        field.attrs.update({"MAI": np.bytes_(mesh), "NCO": values.shape[-1], "TYP": 6, "UNI": np.bytes_(unit.ljust(16) * values.shape[-1]), "NOM": np.bytes_("c".ljust(16) * values.shape[-1])})
        step = field.require_group(f"{number:020d}{NONE}")
        step.attrs.update({"NDT": number, "NOR": -1, "PDT": time})
        inside = step.create_group(f"{entity}/{profile or 'MED_NO_PROFILE_INTERNAL'}")
        step[entity].attrs["PFL"] = np.bytes_(profile or "MED_NO_PROFILE_INTERNAL")
        inside.attrs.update({"NBR": len(values), "NGA": gauss})
        inside["CO"] = np.moveaxis(values.astype("f8"), -1, 0).ravel()

    def profile(self, name, places):
        group = self.file.create_group(f"PROFILS/{name}")
        group.attrs["NBR"] = len(places)
        group["PFL"] = (np.array(places) + 1).astype("i4")


def write(expect):
    nodes, cells = boxes()
    numbers = {n: i for i, n in enumerate(nodes)}
    points = np.array(list(nodes.values()), float)
    hexahedra = [[numbers[n] for n in cell] for cell in cells.values()]
    turned = [[cell[i] for i in (0, 3, 2, 1, 4, 7, 6, 5)] for cell in hexahedra]
    low = points[[cell[0] for cell in hexahedra]]
    at_nodes, at_cells = np.array([field(p) for p in points])[:, None], np.array([field(p) for p in low])[:, None]
    with_med = Med("box.med")
    with_med.mesh("box", points, {"HE8": turned, "QU4": [cell[:4] for cell in hexahedra[:3]]})
    with_med.mesh("small", points[:4], {"SE2": [[0, 1]]})
    for number, time in ((1, 0.5), (2, 1.5)):
        with_med.values("TEMP", "box", number, time, "NOE", at_nodes + 1000 * (number - 1), "K")
        with_med.values("SIEF", "box", number, time, "MAI.HE8", np.stack([np.stack([at_cells[:, 0] - 1, at_cells[:, 0] + 1], 1), np.full((len(low), 2), 7.0)], -1), "Pa", gauss=2)
        with_med.values("ELNO", "box", number, time, "NOE.HE8", np.zeros((8 * len(low), 1)))
    with_med.profile("some", [0, 3])
    with_med.values("PART", "box", 2, 1.5, "MAI.HE8", np.array([[5.0], [6.0]]), profile="some")
    with_med.file.close()
    bounds = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
    for step in (0, 1):
        part = {"PART": [5, 6, 104]} if step else {}
        expect("box.med", "unstructured", len(points), len(hexahedra), {"TEMP": [1000 * step, 345 + 1000 * step, 0], "SIEF_y": [7, 7, 0], **part}, bounds, [5, 3, 2, "TEMP", 235 + 1000 * step], [0.5, 1.5], step)
    for kind, (corners, order, middles, sixths) in SECOND.items():
        first = corners[order]
        places = np.array([*first, *(first[list(of)].mean(0) for of in middles)])
        one = Med(f"second_{kind}_{sixths}.med")
        one.mesh("one", places, {kind: [list(range(len(places)))]})
        one.values("f", "one", 1, 0.0, "NOE", np.array([field(p) for p in places])[:, None])
        one.file.close()
