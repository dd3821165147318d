"""Files of Tecplot, text and binary (version 112), for write_files.py. FIELD has i + 10 j + 100 k at (i, j, k)."""

import struct

import numpy as np

NX, NY, NZ = 6, 5, 4
UNIT = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
CELLS = (NX - 1) * (NY - 1) * (NZ - 1)


def lattice_points():
    return [(i, j, k) for k in range(NZ) for j in range(NY) for i in range(NX)]


def bricks(first=1):
    number = lambda i, j, k: first + i + NX * (j + NY * k)
    around = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    return [[number(i + a, j + b, k + c) for a, b, c in around] for k in range(NZ - 1) for j in range(NY - 1) for i in range(NX - 1)]


def value(p):
    return p[0] + 10 * p[1] + 100 * p[2]


def columns(*columns):
    return "\n".join(" ".join(f"{n:g}" for n in row) for row in columns) + "\n"


def text(expect):
    points = lattice_points()
    with open("points.dat", "w") as out:  # as most programs of computational fluid dynamics write it
        out.write('# a remark\nTITLE = "a flow, at rest"\nvariables = "X [m]" , "Y [m]", "Z [m]"\n"p [Pa]", "T"\n')
        out.write(f'ZONE T="whole", I={NX}, J={NY}, K={NZ}, F=POINT\n')
        out.write(columns(*[(*p, value(p), 2 * value(p)) for p in points]))
    expect("points.dat", "curvilinear", len(points), CELLS, {"p": [0, 345, 0], "T": [0, 690, 0]}, UNIT, [5, 3, 2, "p", 235])
    cells = bricks()
    with open("blocks.tec", "w") as out:  # cells' values, repeated numbers, Fortran's
        out.write("VARIABLES = x y z p q\n")
        out.write(f"zone nodes={len(points)} elements={len(cells)} zonetype=FEBRICK datapacking=BLOCK varlocation=([5]=cellcentered)\n")
        for axis in range(3):
            out.write("\n".join(str(p[axis]) for p in points) + "\n")
        out.write("\n".join(f"{value(p):d}.0D0" for p in points) + "\n")
        out.write(f"{len(cells) - 1}*2.5 7.5\n")
        out.write("\n".join(" ".join(map(str, c)) for c in cells) + "\n")
    expect("blocks.tec", "unstructured", len(points), len(cells), {"p": [0, 345, 0], "q": [2.5, 7.5, 0]}, UNIT, [5, 3, 2, "p", 235])
    with open("steps.dat", "w") as out:  # two times; the second shares places and elements with the first
        out.write('TITLE = ""\nVARIABLES = "x" "y" "z" "p"\n')
        for step, time in enumerate((0.5, 1.5)):
            share = "" if step == 0 else ", VARSHARELIST=([1-3]=1), CONNECTIVITYSHAREZONE=1"
            out.write(f"ZONE T=\"t\", STRANDID=1, SOLUTIONTIME={time}, N={len(points)}, E={len(cells)}, DATAPACKING=BLOCK, ZONETYPE=FEBRICK{share}\n")
            if step == 0:
                for axis in range(3):
                    out.write(" ".join(str(p[axis]) for p in points) + "\n")
            out.write(" ".join(str(value(p) + 1000 * step) for p in points) + "\n")
            if step == 0:
                out.write("\n".join(" ".join(map(str, c)) for c in cells) + "\n")
    for step in range(2):
        expect("steps.dat", "unstructured", len(points), len(cells), {"p": [1000 * step, 1000 * step + 345, 0]}, UNIT, [5, 3, 2, "p", 1000 * step + 235], [0.5, 1.5], step)
    with open("surface.dat", "w") as out:  # x, y and a value: no z
        out.write('VARIABLES = "X", "Y", "h"\nZONE I=6, J=5\n')
        out.write(columns(*[(i, j, i + 10 * j) for j in range(NY) for i in range(NX)]))
    expect("surface.dat", "curvilinear", 30, 20, {"h": [0, 45, 0]}, [0, 5, 0, 4, 0, 0], [5, 3, 0, "h", 35])
    with open("simple.dat", "w") as out:  # bricks whose nodes fall together: a tetrahedron, a pyramid, two wedges, side by side
        nodes = []
        elements = []

        def add(corners, element):
            first = len(nodes) + 1
            nodes.extend((x + 2 * len(elements), y, z) for x, y, z in corners)
            elements.append([first + n for n in element])

        square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
        add([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [0, 1, 2, 2, 3, 3, 3, 3])
        add([*square, (0.5, 0.5, 1)], [0, 1, 2, 3, 4, 4, 4, 4])
        add([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], [0, 1, 2, 2, 3, 4, 5, 5])
        add([*square, (0.5, 0, 1), (0.5, 1, 1)], [0, 1, 2, 3, 4, 4, 5, 5])
        add([*square, (0, 0.5, 1), (1, 0.5, 1)], [0, 1, 2, 3, 4, 5, 5, 4])
        out.write(f'VARIABLES = "X" "Y" "Z" "f"\nZONE N={len(nodes)} E={len(elements)} F=FEPOINT ET=BRICK\n')
        out.write(columns(*[(*p, i) for i, p in enumerate(nodes)]))
        out.write("\n".join(" ".join(map(str, e)) for e in elements) + "\n")


class Plt:
    def __init__(self, name, variables, order="<"):
        self.out, self.order = open(name, "wb"), order
        self.out.write(b"#!TDV112")
        self.whole(1, 0)
        self.text("a flow")
        self.whole(len(variables))
        for one in variables:
            self.text(one)

    def whole(self, *numbers):
        self.out.write(struct.pack(f"{self.order}{len(numbers)}i", *numbers))

    def real(self, number):
        self.out.write(struct.pack(self.order + "f", number))

    def double(self, *numbers):
        self.out.write(struct.pack(f"{self.order}{len(numbers)}d", *numbers))

    def text(self, text):
        self.whole(*text.encode(), 0)

    def zone(self, name, kind, size, locations=None, time=None):
        self.real(299)
        self.text(name)
        self.whole(-1, 0 if time is None else 1)
        self.double(time or 0)
        self.whole(-1, kind, 0 if locations is None else 1, *(locations or []), 0, 0, *size)
        if kind:
            self.whole(0, 0, 0)
        self.whole(1)  # more is said
        self.text("who")
        self.whole(0)
        self.text("nobody")
        self.whole(0)

    def end(self):
        self.real(357)

    def numbers(self, arrays, elements=None, shared=None, mesh_of=-1):
        """arrays: numpy's, None for one that is shared."""
        kinds = {"f4": 1, "f8": 2, "i4": 3, "i2": 4, "u1": 5}
        self.real(299)
        self.whole(*[1 if a is None else kinds[a.dtype.str[1:]] for a in arrays])
        self.whole(0)
        self.whole(0 if shared is None else 1, *(shared or []))
        self.whole(mesh_of)
        for a in arrays:
            if a is not None:
                self.double(float(a.min()), float(a.max()))
        for a in arrays:
            if a is not None:
                self.out.write(a.astype(a.dtype.newbyteorder(self.order)).tobytes())
        if elements is not None and mesh_of < 0:
            self.whole(*[n for e in elements for n in e])

    def close(self):
        self.out.close()


def binary(field, expect):
    points = np.array(lattice_points(), float)
    xyz = [np.ascontiguousarray(points[:, a]) for a in range(3)]
    values = field.reshape(-1).astype("f4")
    cells = bricks(0)
    for name, order in (("ordered.plt", "<"), ("other_order.plt", ">")):
        plt = Plt(name, ["X", "Y", "Z", "p (Pa)", "q", "n"], order)
        plt.zone("box", 0, (NX, NY, NZ), [0, 0, 0, 0, 1, 0])
        plt.end()
        padded = np.full((NZ - 1, NY, NX), -77, "f8")  # along x and y there is more than cells
        padded[:, :-1, :-1] = field[:-1, :-1, :-1]
        plt.numbers([*xyz, values, padded, field.reshape(-1).astype("i2")])
        plt.close()
        expect(name, "curvilinear", len(points), CELLS, {"p": [0, 345, 0], "n": [0, 345, 0]}, UNIT, [5, 3, 2, "p", 235])
    plt = Plt("steps.plt", ["x", "y", "z", "p", "q"])
    for time in (0.5, 1.5):
        plt.zone("mesh", 5, (len(points), len(cells)), [0, 0, 0, 0, 1], time)
    plt.end()
    plt.numbers([*xyz, values, np.arange(CELLS, dtype="f4")], cells)
    plt.numbers([None, None, None, values + 1000, np.arange(CELLS, dtype="f4")], cells, [0, 0, 0, -1, -1], 0)
    plt.close()
    for step in range(2):
        expect("steps.plt", "unstructured", len(points), CELLS, {"p": [1000 * step, 1000 * step + 345, 0]}, UNIT, [5, 3, 2, "p", 1000 * step + 235], [0.5, 1.5], step)


def write(field, expect):
    text(expect)
    binary(field, expect)
