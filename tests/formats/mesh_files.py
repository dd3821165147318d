"""Meshes of Gmsh and CalculiX as text and binary, for write_files.py. Nodes and elements have numbers with gaps, in an order that is not theirs."""

import struct

import numpy as np

NX, NY, NZ = 6, 5, 4
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
HEXAHEDRON = CORNERS.astype(float)
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
PYRAMID = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]])
# Elements of second order, as the programs' manuals number them: of each node behind the corners, the corners whose middle it is.
HEXAHEDRON_EDGES = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 5), (2, 3), (2, 6), (3, 7), (4, 5), (4, 7), (5, 6), (6, 7)]
HEXAHEDRON_FACES = [(0, 1, 2, 3), (0, 1, 4, 5), (0, 3, 4, 7), (1, 2, 5, 6), (2, 3, 6, 7), (4, 5, 6, 7)]
WEDGE_EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 4), (2, 5), (3, 4), (3, 5), (4, 5)]
PYRAMID_EDGES = [(0, 1), (0, 3), (0, 4), (1, 2), (1, 4), (2, 3), (2, 4), (3, 4)]
GMSH_SECOND = {11: (TETRAHEDRON, [(0, 1), (1, 2), (0, 2), (0, 3), (2, 3), (1, 3)], 1 / 6),
               12: (HEXAHEDRON, HEXAHEDRON_EDGES + HEXAHEDRON_FACES + [tuple(range(8))], 1),
               13: (WEDGE, WEDGE_EDGES + [(0, 1, 3, 4), (0, 2, 3, 5), (1, 2, 4, 5)], 1 / 2),
               14: (PYRAMID, PYRAMID_EDGES + [(0, 1, 2, 3)], 1 / 3),
               17: (HEXAHEDRON, HEXAHEDRON_EDGES, 1), 18: (WEDGE, WEDGE_EDGES, 1 / 2), 19: (PYRAMID, PYRAMID_EDGES, 1 / 3)}
FRD_SECOND = {4: (HEXAHEDRON, [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 5), (2, 6), (3, 7), (4, 5), (5, 6), (6, 7), (7, 4)], 1),
              5: (WEDGE, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 4), (2, 5), (3, 4), (4, 5), (5, 3)], 1 / 2),
              6: (TETRAHEDRON, [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)], 1 / 6)}


def boxes():
    """Nodes {number: place}, backwards and two apart, and hexahedra {number: nodes}, of the lattice of 6 x 5 x 4 points."""
    places = [(x, y, z) for z in range(NZ) for y in range(NY) for x in range(NX)]
    number = {place: 1001 - 2 * i for i, place in enumerate(places)}
    cells = [[number[tuple(np.array(low) + corner)] for corner in CORNERS] for low in places if all(np.array(low) < (NX - 1, NY - 1, NZ - 1))]
    return {n: place for place, n in number.items()}, {500 + 3 * i: cell for i, cell in enumerate(cells)}


def field(place):
    return place[0] + 10 * place[1] + 100 * place[2]


class GmshWriter:
    def __init__(self, binary, order="<"):
        self.binary, self.order, self.out = binary, order, []

    def text(self, text):
        self.out.append(text.encode())

    def row(self, kinds, *values):
        """kinds: i whole of 32 bits, Q of 64, d real"""
        self.out.append(struct.pack(self.order + kinds, *values) if self.binary else (" ".join(repr(v) for v in values) + "\n").encode())

    def head(self, version):
        self.text(f"$MeshFormat\n{version} {int(self.binary)} 8\n")
        if self.binary:
            self.row("i", 1)
        self.text("\n$EndMeshFormat\n$PhysicalNames\n3\n2 7 \"wall\"\n3 1 \"low half\"\n3 2 \"high half\"\n$EndPhysicalNames\n")

    def data(self, kind, name, step, time, components, rows):
        self.text(f"${kind}\n1\n\"{name}\"\n1\n{time}\n3\n{step}\n{components}\n{len(rows)}\n")
        for number, values in rows.items():
            self.row("ii"[:2 if kind == "ElementNodeData" else 1] + "d" * len(values), number, *([8] if kind == "ElementNodeData" else []), *map(float, values))
        self.text(f"\n$End{kind}\n")

    def values(self, nodes, cells):
        for step in range(2):
            self.data("NodeData", "f", step, 0.5 + step, 1, {n: [field(p) + 1000 * step] for n, p in nodes.items()})
        self.data("NodeData", "place", 0, 0, 3, {n: p for n, p in nodes.items()})  # at one step: it is there at all
        self.data("ElementNodeData", "jump", 0, 0, 1, {n: [field(nodes[v]) + (-1) ** (i // 5) for v in cell] for i, (n, cell) in enumerate(cells.items())})
        self.data("ElementData", "number", 0, 0, 1, {n: [i] for i, n in enumerate(cells)})


def halves(cells):
    low = dict(list(cells.items())[:20])
    return [(1, low), (2, {n: cell for n, cell in cells.items() if n not in low})]


def gmsh_2(writer, nodes, cells):
    writer.head("2.2")
    writer.text(f"$Nodes\n{len(nodes)}\n")
    for n, place in nodes.items():
        writer.row("iddd", n, *map(float, place))
    writer.text(f"\n$EndNodes\n$Elements\n{len(cells) + 1}\n")
    if writer.binary:
        writer.row("iii", 2, 1, 2)
    writer.row("iiiiii" if writer.binary else "", *((1, 7, 7) if writer.binary else (1, 2, 2, 7, 7)), *next(iter(cells.values()))[:3])
    for group, of in halves(cells):
        if writer.binary:
            writer.row("iii", 5, len(of), 2)
        for n, cell in of.items():
            writer.row("i" * 11, *((n, group, group) if writer.binary else (n, 5, 2, group, group)), *cell)
    writer.text("\n$EndElements\n")
    writer.values(nodes, cells)


def gmsh_4(writer, nodes, cells):
    writer.head("4.1")
    writer.text("$Entities\n")
    writer.row("QQQQ", 0, 0, 1, 2)
    writer.row("i" + "d" * 6 + "QiQii", 9, *[0.0] * 6, 1, 7, 2, 4, -5)
    for volume, group in ((31, 1), (32, 2)):
        writer.row("i" + "d" * 6 + "QiQi", volume, *[0.0] * 6, 1, group, 1, 9)
    writer.text("\n$EndEntities\n$Nodes\n")
    split = list(nodes.items())
    writer.row("QQQQ", 2, len(nodes), 1, 5000)
    for surface, of in ((True, split[:50]), (False, split[50:])):
        writer.row("iiiQ", 2 if surface else 3, 9 if surface else 31, int(surface), len(of))
        for n, _ in of:
            writer.row("Q", n)
        for _, place in of:
            writer.row("ddddd" if surface else "ddd", *map(float, place), *([0.25, 0.5] if surface else []))
    writer.text("\n$EndNodes\n$Elements\n")
    writer.row("QQQQ", 3, len(cells) + 1, 1, 5000)
    writer.row("iiiQ", 2, 9, 2, 1)
    writer.row("QQQQ", 1, *next(iter(cells.values()))[:3])
    for volume, (_, of) in zip((31, 32), halves(cells)):
        writer.row("iiiQ", 3, volume, 5, len(of))
        for n, cell in of.items():
            writer.row("Q" * 9, n, *cell)
    writer.text("\n$EndElements\n")
    writer.values(nodes, cells)


def gmsh(expect):
    nodes, cells = boxes()
    for name, write, binary, order in (("two_text.msh", gmsh_2, False, "<"), ("two_binary.msh", gmsh_2, True, "<"), ("four_text.msh", gmsh_4, False, "<"),
                                       ("four_binary.msh", gmsh_4, True, "<"), ("four_other_order.msh", gmsh_4, True, ">")):
        writer = GmshWriter(binary, order)
        write(writer, nodes, cells)
        with open(name, "wb") as out:
            out.write(b"".join(writer.out))
        for step in range(2):
            expect(name, "unstructured", NX * NY * NZ, len(cells), {"f": [1000 * step, 345 + 1000 * step, 0], "place_z": [0, NZ - 1, 0], "jump": [1, 344, 0], "number": [0, 59, 0], "physical group": [1, 2, 0]},
                   [0, NX - 1, 0, NY - 1, 0, NZ - 1], [5, 3, 2, "f", 235 + 1000 * step], [0.5, 1.5], step)


def second_order():
    """One element a file; the volume is in the name, in sixths."""
    for kind, (corners, middles, volume) in GMSH_SECOND.items():
        places = [*corners, *(corners[list(of)].mean(0) for of in middles)]
        with open(f"second_{kind}_{round(6 * volume)}.msh", "w") as out:
            out.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + f"$Nodes\n{len(places)}\n" + "".join(f"{i + 1} {p[0]} {p[1]} {p[2]}\n" for i, p in enumerate(places)) +
                      f"$EndNodes\n$Elements\n1\n1 {kind} 2 1 1 " + " ".join(str(i + 1) for i in range(len(places))) + f"\n$EndElements\n$NodeData\n1\n\"f\"\n1\n0\n3\n0\n1\n{len(places)}\n" +
                      "".join(f"{i + 1} {field(p)}\n" for i, p in enumerate(places)) + "$EndNodeData\n")
    for kind, (corners, middles, volume) in FRD_SECOND.items():
        places = [*corners, *(corners[list(of)].mean(0) for of in middles)]
        write_frd(f"second_{kind}_{round(6 * volume)}.frd", 1, {i + 1: p for i, p in enumerate(places)}, {1: range(1, len(places) + 1)}, kind, [("NDTEMP", 0, 1, ["T"], {i + 1: [field(p)] for i, p in enumerate(places)})])


def write_frd(name, form, nodes, cells, kind, sets):
    """form: 0, 1 as text with numbers of 5 or 10 columns; 2, 3 binary with real numbers of 4 or 8 bytes."""
    whole = (lambda v: f"{v:5d}") if form == 0 else (lambda v: f"{v:10d}")
    real = "f" if form == 2 else "d"
    with open(name, "wb") as out:
        text = lambda line: out.write((line + "\n").encode())
        text("    1C\n    1UPGM               CalculiX")
        text("    2C" + " " * 18 + f"{len(nodes):12d}" + " " * 37 + str(form))
        for n, p in nodes.items():
            text(" -1" + whole(n) + "".join(f"{x:12.5E}" for x in p)) if form < 2 else out.write(struct.pack("<i3" + real, n, *p))
        if form < 2:
            text(" -3")
        text("    3C" + " " * 18 + f"{len(cells):12d}" + " " * 37 + str(form))
        for n, cell in cells.items():
            cell = list(cell)
            if form < 2:
                text(" -1" + whole(n) + f"{kind:5d}    0    1")
                for at in range(0, len(cell), 15 if form == 0 else 10):
                    text(" -2" + "".join(map(whole, cell[at:at + (15 if form == 0 else 10)])))
            else:
                out.write(struct.pack(f"<4i{len(cell)}i", n, kind, 0, 1, *cell))
        if form < 2:
            text(" -3")
        for array, time, step, components, values in sets:
            text(f"  100CL  101{time:12.9f}{len(values):12d}" + " " * 20 + f" 0{step:5d}" + " " * 10 + f"{form:2d}")
            text(f" -4  {array:8s}{len(components) + (len(components) == 3):5d}    1")
            for i, component in enumerate(components):
                text(f" -5  {component:8s}    1    2{i + 1:5d}    0")
            if len(components) == 3:
                text(" -5  ALL         1    2    0    0    1ALL")
            for n, row in values.items():
                if form >= 2:
                    out.write(struct.pack(f"<i{len(row)}{real}", n, *row))
                for at in range(0, len(row) if form < 2 else 0, 6):
                    text((" -1" + whole(n) if at == 0 else " -2" + " " * len(whole(n))) + "".join(f"{v:12.5E}" for v in row[at:at + 6]))
            if form < 2:
                text(" -3")
        text(" 9999")


def calculix(expect):
    nodes, cells = boxes()
    stress = ["SXX", "SYY", "SZZ", "SXY", "SYZ", "SZX"]
    for form, name in enumerate(("short.frd", "long.frd", "binary.frd", "doubles.frd")):
        sets = []
        for step in range(2):
            sets += [("DISP", 0.5 + step, step + 1, ["D1", "D2", "D3"], {n: np.array(p) * (step + 1) for n, p in nodes.items()}),
                     ("STRESS", 0.5 + step, step + 1, stress, {n: [-field(p) - 1000 * step - c for c in range(6)] for n, p in nodes.items()}),
                     ("MANY", 0.5 + step, step + 1, [f"M{c}" for c in range(8)], {n: [field(p) + c for c in range(8)] for n, p in list(nodes.items())[:100]})]
        write_frd(name, form, nodes, cells, 1, sets)
        for step in range(2):
            expect(name, "unstructured", NX * NY * NZ, len(cells), {"DISP_x": [0, 5 * (step + 1), 0], "DISP_z": [0, 3 * (step + 1), 0], "STRESS_SZX": [-350 - 1000 * step, -5 - 1000 * step, 0], "MANY_M7": [7, 320, 20]},
                   [0, NX - 1, 0, NY - 1, 0, NZ - 1], [5, 3, 2, "STRESS_SYY", -236 - 1000 * step], [0.5, 1.5], step)


def ucd(expect):
    nodes, cells = boxes()
    rows = lambda lines: "".join(" ".join(str(v) for v in line) + "\n" for line in lines)
    low = {c: field(nodes[cell[0]]) for c, cell in cells.items()}
    with open("boxes.inp", "w") as out:  # the face that VTK has last comes first
        out.write(f"# remarks\n# of a program\n{len(nodes)} {len(cells) + 1} 4 1 0\n" + rows([n, *p] for n, p in nodes.items()) + rows([c, 1, "hex", *cell[4:], *cell[:4]] for c, cell in cells.items()) +
                  f"9999 1 line {list(nodes)[0]} {list(nodes)[1]}\n" + "2 1 3\nT, K\nv, m/s\n" + rows([n, field(p), 1, 2, field(p)] for n, p in nodes.items()) +
                  "1 1\nmat, none\n" + rows([c, v] for c, v in low.items()) + "9999 -5\n")
    expect("boxes.inp", "unstructured", len(nodes), len(cells), {"T": [0, 345, 0], "v_z": [0, 345, 0]}, [0, NX - 1, 0, NY - 1, 0, NZ - 1], [5, 3, 2, "T", 235])
    shapes = [("tet", TETRAHEDRON, [0, 1, 3, 2]), ("pyr", PYRAMID, [4, 0, 1, 2, 3]), ("prism", WEDGE, [3, 4, 5, 0, 1, 2])]
    with open("shapes.ucd", "w") as out:
        places = [corner + [3 * i, 0, 0] for i, (_, corners, _) in enumerate(shapes) for corner in corners]
        out.write(f"{len(places)} {len(shapes)} 1 0 0\n" + rows([i + 1, *p] for i, p in enumerate(places)))
        first = 1
        for i, (name, corners, order) in enumerate(shapes):
            out.write(rows([[i + 1, 1, name, *(first + k for k in order)]]))
            first += len(corners)
        out.write("1 1\nf,\n" + rows([i + 1, field(p)] for i, p in enumerate(places)))


def write(expect):
    ucd(expect)
    gmsh(expect)
    calculix(expect)
    second_order()
