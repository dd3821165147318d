"""XDMF as people's programs write it (FEniCS, meshio, Athena++, XDMF's own library), for write_files.py."""

import h5py
import numpy as np

UNIT = [0, 5, 0, 4, 0, 3]
HEAD = '<?xml version="1.0" ?>\n<!DOCTYPE Xdmf SYSTEM "Xdmf.dtd" []>\n'


def item(values, text=None, format="XML", **more):
    """A DataItem; without a text of its own, of these values."""
    values = np.asarray(values)
    kind = {"f": "Float", "i": "Int", "u": "UInt"}[values.dtype.kind]
    attributes = {"Dimensions": " ".join(map(str, values.shape)), "NumberType": kind, "Precision": values.dtype.itemsize, "Format": format, **more}
    inside = " ".join(repr(v) for v in values.ravel().tolist()) if text is None else text
    return "<DataItem " + " ".join(f'{k}="{v}"' for k, v in attributes.items()) + f">\n{inside}\n</DataItem>"


def attribute(name, values, center="Node", **more):
    return f'<Attribute Name="{name}" AttributeType="Scalar" Center="{center}">' + (values if isinstance(values, str) else item(values, **more)) + "</Attribute>"


def grid(*parts, name="g"):
    return f'<Grid Name="{name}" GridType="Uniform">' + "".join(parts) + "</Grid>"


def temporal(*grids, name="series", time=""):
    return f'<Grid Name="{name}" GridType="Collection" CollectionType="Temporal">{time}' + "".join(grids) + "</Grid>"


def put(name, *grids):
    with open(name, "w") as file:
        file.write(HEAD + '<Xdmf Version="3.0" xmlns:xi="http://www.w3.org/2001/XInclude"><Domain>' + "".join(grids) + "</Domain></Xdmf>\n")


def mesh(field):
    """The lattice as hexahedra, as text of a Topology and a Geometry of run.h5, and its arrays."""
    nz, ny, nx = field.shape
    z, y, x = np.mgrid[0:nz, 0:ny, 0:nx]
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], -1).astype("f8")
    first = (x + nx * (y + ny * z))[:-1, :-1, :-1].ravel()
    cells = np.stack([first + d for d in (0, 1, 1 + nx, nx, nx * ny, nx * ny + 1, nx * ny + nx + 1, nx * ny + nx)], -1)
    return points, cells


def structured(field, lattice):
    shape = " ".join(map(str, field.shape))
    origin = '<Geometry GeometryType="ORIGIN_DXDYDZ">' + item(np.array([3.0, 2.0, 1.0])) + item(np.array([2.0, 1.0, 0.5])) + "</Geometry>"
    put("image.xdmf", grid(f'<Topology TopologyType="3DCoRectMesh" Dimensions="{shape}"/>', origin, attribute("p", field), attribute("c", field[1:, 1:, 1:].astype("i4"), "Cell"),
                           '<Attribute Name="step" Center="Grid">' + item(np.array([7])) + "</Attribute>"))
    lattice("image.xdmf", {"p": [0, 345, 0], "c": [111, 345, 0]}, [1, 3.5, 2, 6, 3, 9], [3.5, 5, 7, "p", 235])

    field.astype(">f4").tofile("numbers.bin")
    with open("numbers.bin", "ab") as file:
        file.write(b"\0" * 3)
        file.write((2 * field).astype("<f8").tobytes())
    axes = [np.arange(6) * 5.0, np.array([-20.0, -10, 0, 10, 20]), np.array([0.0, 10, 30, 70])]
    put("axes.xmf", grid(f'<Topology TopologyType="3DRectMesh" NumberOfElements="{shape}"/>', '<Geometry GeometryType="VXVYVZ">' + "".join(map(item, axes)) + "</Geometry>",
                         attribute("big", field.astype("f4"), text="numbers.bin", format="Binary", Endian="Big"),
                         attribute("behind", field, text="numbers.bin", format="Binary", Endian="Little", Seek=field.size * 4 + 3)))
    lattice("axes.xmf", {"big": [0, 345, 0], "behind": [0, 690, 0]}, [0, 25, -20, 20, 0, 70], [25, 10, 30, "behind", 470], grid="rectilinear")

    z, y, x = np.mgrid[0:field.shape[0], 0:field.shape[1], 0:field.shape[2]].astype("f4")
    apart = '<Geometry GeometryType="X_Y_Z">' + item(x + y) + item(y) + item(z) + "</Geometry>"
    join = '<DataItem ItemType="Function" Function="JOIN($0 , $1, $2)" Dimensions="%s 3">' % shape + item(field) + item(2 * field) + item(3 * field) + "</DataItem>"
    put("bent.xdmf", grid(f'<Topology TopologyType="3DSMesh" Dimensions="{shape}"/>', apart, attribute("v", join)))
    lattice("bent.xdmf", {"v_x": [0, 345, 0], "v_z": [0, 1035, 0]}, [0, 9, 0, 4, 0, 3], [8, 3, 2, "v_y", 470], grid="curvilinear")
    put("flat.xdmf", grid('<Topology TopologyType="2DCoRectMesh" Dimensions="5 6"/>', '<Geometry GeometryType="ORIGIN_DXDY">' + item(np.array([0.0, 10])) + item(np.array([1.0, 2])) + "</Geometry>", attribute("p", field[0])))


def athena(field, expect):
    """Blocks of cells, each a part of arrays of HDF5."""
    with h5py.File("disk.athdf", "w") as file:
        file["prim"] = np.stack([[field[1:, 1:, 1:3 + 1], field[1:, 1:, 3:6]], [field[1:, 1:, 1:4] + 1000, field[1:, 1:, 3:6] + 1000]]).astype("f4")
        for a, n in ((1, 6), (2, 5), (3, 4)):
            file[f"x{a}f"] = np.array([np.arange(4.0), np.arange(3.0, 7)]) if a == 1 else np.array([np.arange(float(n))] * 2)

    def part(of, start, count, size):
        says = np.array([start, [1] * len(start), count])
        return (f'<DataItem ItemType="HyperSlab" Dimensions="{" ".join(map(str, count[-3:]))}">' + item(says) + f'<DataItem Dimensions="{size}" NumberType="Float" Format="HDF"> disk.athdf:/{of} </DataItem></DataItem>')

    blocks = []
    for b in range(2):
        axes = [part(f"x{a}f", [b, 0], [1, n], f"2 {n}") for a, n in ((1, 4), (2, 5), (3, 4))]
        values = [attribute(f"p{q}", part("prim", [q, b, 0, 0, 0], [1, 1, 3, 4, 3], "2 2 3 4 3"), "Cell") for q in range(2)]
        blocks.append(grid('<Topology TopologyType="3DRectMesh" NumberOfElements="4 5 4"/>', '<Geometry GeometryType="VXVYVZ">', *axes, "</Geometry>", *values, name=f"MeshBlock{b}"))
    put("disk.athdf.xdmf", '<Grid Name="Mesh" GridType="Collection" CollectionType="Spatial"><Time Value="1.5"/>', *blocks, "</Grid>")
    expect("disk.athdf.xdmf", "unstructured", 140, 72, {"p0": [111, 345, 0], "p1": [1111, 1345, 0]}, [0, 6, 0, 4, 0, 3], [0, 0, 0, "p0", 111], [1.5])


def series(field, lattice, expect):
    points, cells = mesh(field)
    count = field.size
    with h5py.File("run.h5", "w") as file:
        file["Mesh/geometry"] = points
        file["Mesh/topology"] = cells
        for t in range(3):
            file.create_dataset(f"f/{t}", data=(field + 1000 * t).reshape(-1, 1), chunks=(30, 1), compression="gzip")
            file[f"v/{t}"] = np.stack([field.ravel() * k for k in (1, 2, 3)], -1).astype("f4")
        file["all"] = np.stack([field.ravel() + 1000 * t for t in range(3)])
    heavy = lambda path, shape, kind="Float": f'<DataItem Dimensions="{shape}" NumberType="{kind}" Precision="8" Format="HDF">run.h5:/{path}</DataItem>'
    topology = f'<Topology TopologyType="Hexahedron" NumberOfElements="{len(cells)}" NodesPerElement="8">' + heavy("Mesh/topology", f"{len(cells)} 8", "Int") + "</Topology>"
    geometry = '<Geometry GeometryType="XYZ">' + heavy("Mesh/geometry", f"{count} 3") + "</Geometry>"
    f, v = (lambda t: attribute("f", heavy(f"f/{t}", f"{count} 1"))), (lambda t: attribute("v", heavy(f"v/{t}", f"{count} 3")))
    time = lambda t: f'<Time Value="{t / 4}" />'
    include = lambda path: f'<xi:include xpointer="xpointer({path}/*[self::Topology or self::Geometry])" />'
    listed = '<Time TimeType="List">' + item(np.array([0.0, 0.25, 0.5])) + "</Time>"
    put("meshio.xdmf", grid(topology, geometry, name="mesh"), temporal(*[grid(include("//Grid[@Name=&quot;mesh&quot;]"), time(t), f(t)) for t in range(3)]))
    put("fenics.xdmf", temporal(grid(topology, geometry, time(0), f(0)), *[grid(include("//Grid[@Name='series']/Grid[1]"), time(t), f(t)) for t in (1, 2)]))
    put("dolfinx.xdmf", grid(topology, geometry, name="mesh"), *[temporal(*[grid(include("/Xdmf/Domain/Grid[@GridType='Uniform'][1]"), time(t), a(t)) for t in range(3)], name=n) for n, a in (("f", f), ("v", v))])
    slab = lambda t: f'<DataItem ItemType="HyperSlab" Dimensions="{count}">' + item(np.array([[t, 0], [1, 1], [1, count]])) + heavy("all", f"3 {count}") + "</DataItem>"
    put("references.xdmf", topology, geometry, temporal(*[grid('<Topology Reference="/Xdmf/Domain/Topology[1]"/>', '<Geometry Reference="XML">/Xdmf/Domain/Geometry</Geometry>', attribute("f", slab(t))) for t in range(3)], time=listed))
    put("numbers.xdmf", temporal(*[grid(topology if t == 0 else '<xi:include xpointer="element(/1/1/1/2/1)"/>', geometry if t == 0 else '<xi:include xpointer="element(/1/1/1/2/2)"/>',
                                        attribute("f", heavy(f"all|{t} 0|1 1|1 {count}|3 {count}", f"1 {count}"))) for t in range(3)], time='<Time TimeType="HyperSlab">' + item(np.array([0, 0.25, 3])) + "</Time>"))
    for name in ("meshio", "fenics", "dolfinx", "references", "numbers"):
        for t in range(3):
            arrays = {"f": [1000 * t, 1000 * t + 345, 0], **({"v_z": [0, 1035, 0]} if name == "dolfinx" else {})}
            expect(name + ".xdmf", "unstructured", count, len(cells), arrays, UNIT, [5, 3, 2, "f", 1000 * t + 235], [0, 0.25, 0.5], t)
    for t in range(2):
        put(f"numbered_{t}.xmf", grid(topology, geometry, f'<Time TimeType="Single" Value="{3 + t}"/>', f(t)))
    expect("numbered_*.xmf", "unstructured", count, len(cells), {"f": [1000, 1345, 0]}, UNIT, [5, 3, 2, "f", 1235], [3, 4], 1)
    put("parts.xdmf", *[f'<Grid Name="all" GridType="Tree"><xi:include href="numbered_{t}.xmf" xpointer="//Grid"/></Grid>' for t in range(2)])
    expect("parts.xdmf", "unstructured", count, len(cells), {"f": [1000, 1345, 0]}, UNIT, [5, 3, 2, "f", 1235], [3, 4], 1)


def cells(expect):
    """One cell of each type beside the other, x from 2 k to 2 k + 1; the value is x."""
    kinds = [(6, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]), (7, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]]),
             (8, [[0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1], [0, 1, 1], [1, 0, 1]]), (9, [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]),
             (38, [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [.5, 0, 0], [.5, .5, 0], [0, .5, 0], [0, 0, .5], [.5, 0, .5], [0, .5, .5]])]
    points, stream = [], []
    for k, (number, corners) in enumerate(kinds):
        stream += [number, *range(len(points), len(points) + len(corners))]
        points += [[x + 2 * k, y, z] for x, y, z in corners]
    first = len(points)  # a cube of six faces
    points += [[x + 10, y, z] for x, y, z in kinds[3][1]]
    faces = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    polyhedron = [16, 6] + [n for face in faces for n in (4, *(first + v for v in face))]
    flat = [4, 0, 1, 2, 3, 4, 0, 1, 2, 3, 1, 1, 0]
    points = np.array(points, float)
    for name, list, volumes in (("mixed.xdmf", stream + flat, 12), ("polyhedra.xdmf", stream + polyhedron, 13)):
        put(name, grid(f'<Topology TopologyType="Mixed" NumberOfElements="{volumes}">', item(np.array(list)), "</Topology>", '<Geometry GeometryType="XYZ">', item(points), "</Geometry>", attribute("x", points[:, 0])))
        expect(name, "unstructured", len(points), volumes, {"x": [0, 11, 0]}, [0, 11, 0, 1, 0, 1], [7, 1, 1, "x", 7])
    put("plain.xdmf", grid('<Topology Type="Triangle" NumberOfElements="2" BaseOffset="1">', item(np.array([[1, 2, 3], [2, 4, 3]])), "</Topology>", '<Geometry Type="XY">', item(np.array([[0.0, 0], [1, 0], [0, 1], [1, 1]])), "</Geometry>",
                          attribute("x", np.array([0.0, 1, 2, 3])), attribute("c", np.array([5, 6]), "Cell")))
    expect("plain.xdmf", "unstructured", 4, 2, {"x": [0, 3, 0], "c": [5, 6, 0]}, [0, 1, 0, 1, 0, 0], [1, 1, 0, "x", 3])


def refused():
    triangle = '<Topology TopologyType="Triangle" NumberOfElements="1">' + item(np.array([0, 1, 2])) + "</Topology>"
    place = '<Geometry GeometryType="XYZ">' + item(np.zeros((3, 3))) + "</Geometry>"
    one = lambda *parts: grid(triangle, place, *parts)
    hdf = lambda text, shape="3": attribute("p", f'<DataItem Dimensions="{shape}" Format="HDF">{text}</DataItem>')
    binary = lambda seek, shape="3": attribute("p", f'<DataItem Dimensions="{shape}" Format="Binary" Seek="{seek}">numbers.bin</DataItem>')
    put("no_array.xdmf", one(hdf("run.h5:/nothing")))
    put("outside.xdmf", one(hdf("../run.h5:/all")))
    put("other_size.xdmf", one(hdf("run.h5:/all", "7")))
    put("short.xdmf", one(attribute("p", np.array([1.0, 2]))))
    put("cut_off.xdmf", one(binary(1432)))
    put("huge.xdmf", one(binary(0, "4000000000 4000000000 4000000000")))
    put("beyond.xdmf", one(attribute("p", '<DataItem ItemType="HyperSlab">' + item(np.array([[0, 118], [1, 1], [1, 3]])) + '<DataItem Format="HDF">run.h5:/all</DataItem></DataItem>')))
    put("computes.xdmf", one(attribute("p", '<DataItem ItemType="Function" Function="$0 + $1">' + item(np.zeros(3)) * 2 + "</DataItem>")))
    put("round.xdmf", one(attribute("p", '<DataItem Reference="XML">/Xdmf/Domain/Grid/Attribute/DataItem</DataItem>')))
    put("no_grid.xdmf")
    put("no_point.xdmf", grid(triangle.replace("0 1 2", "0 1 3"), place, attribute("p", np.zeros(3))))
    with open("other.xdmf", "w") as file:
        file.write("<Mesh/>")


def write(field, lattice, expect):
    structured(field, lattice)
    athena(field, expect)
    series(field, lattice, expect)
    cells(expect)
    refused()
