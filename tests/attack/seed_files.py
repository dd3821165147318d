"""Small right files for mutants.py: seed_files.write(FOLDER, PROGRAM) writes what tests/formats/write_files.py does, and, as text or plain bytes, VTK's formats in every
encoding, hyper trees, plotfiles, NRRD, MetaImage, FITS, MRC, PLOT3D, series, parts and meshes of our own. The field is x + 10 y + 100 z on 6 x 5 x 4 points.
"""
import base64
import gzip
import itertools
import pathlib
import struct
import subprocess
import zlib

NX, NY, NZ = 6, 5, 4
POINTS = [(float(x), float(y), float(z)) for z in range(NZ) for y in range(NY) for x in range(NX)]
FIELD = [x + 10 * y + 100 * z for x, y, z in POINTS]


def corner(x, y, z):
    return x + NX * (y + NY * z)


def hexahedra():
    for z, y, x in itertools.product(range(NZ - 1), range(NY - 1), range(NX - 1)):
        low = [corner(x, y, z), corner(x + 1, y, z), corner(x + 1, y + 1, z), corner(x, y + 1, z)]
        yield low + [point + NX * NY for point in low]


# A cell of each kind, by VTK's numbers, over the points of the lattice.
KINDS = [(10, [0, 1, 6, 30]), (14, [0, 1, 7, 6, 30]), (13, [0, 1, 6, 30, 31, 36]), (12, [0, 1, 7, 6, 30, 31, 37, 36]), (11, [0, 1, 6, 7, 30, 31, 36, 37]),
         (24, [0, 2, 12, 60, 1, 7, 6, 30, 31, 36]), (5, [0, 1, 6]), (9, [0, 1, 7, 6]), (3, [0, 1]), (1, [0]), (41, [0, 1, 7, 6, 30, 31, 37, 36])]
CELLS = [(12, cell) for cell in hexahedra()] + KINDS


def floats(values, code="f", order="<"):
    values = list(values)
    return struct.pack(f"{order}{len(values)}{code}", *values)


def flat(rows):
    return [value for row in rows for value in row]


def legacy(folder):
    def lines(values, binary, code):
        return struct.pack(f">{len(values)}{code}", *values) + b"\n" if binary else (" ".join(map(str, values)) + "\n").encode()

    for binary in (False, True):
        kind = "BINARY" if binary else "ASCII"
        data = f"POINT_DATA {len(POINTS)}\nSCALARS s float 1\nLOOKUP_TABLE default\n".encode() + lines(FIELD, binary, "f")
        data += b"VECTORS v double\n" + lines(flat(POINTS), binary, "d") + b"FIELD more 1\nw 1 %d short\n" % len(POINTS) + lines([int(v) for v in FIELD], binary, "h")
        places = f"POINTS {len(POINTS)} double\n".encode() + lines(flat(POINTS), binary, "d")
        sides = b"".join(f"{axis}_COORDINATES {n} float\n".encode() + lines([float(i) for i in range(n)], binary, "f") for axis, n in zip("XYZ", (NX, NY, NZ)))
        cells = flat([len(cell), *cell] for _, cell in CELLS)
        mesh = places + f"CELLS {len(CELLS)} {len(cells)}\n".encode() + lines(cells, binary, "i") + f"CELL_TYPES {len(CELLS)}\n".encode() + lines([t for t, _ in CELLS], binary, "i")
        for name, what, body in (("points", "STRUCTURED_POINTS", b"ORIGIN 0 0 0\nSPACING 1 1 1\n"), ("curved", "STRUCTURED_GRID", places), ("sides", "RECTILINEAR_GRID", sides),
                                 ("mesh", "UNSTRUCTURED_GRID", mesh)):
            size = b"" if name == "mesh" else f"DIMENSIONS {NX} {NY} {NZ}\n".encode()
            (folder / f"{name}_{kind.lower()}.vtk").write_bytes(f"# vtk DataFile Version 3.0\na title\n{kind}\nDATASET {what}\n".encode() + size + body + data)


def xml(folder):
    """Inline as text, as base64 and compressed; appended raw and as base64."""
    extent = f"0 {NX - 1} 0 {NY - 1} 0 {NZ - 1}"
    types = {"f": "Float32", "d": "Float64", "i": "Int32", "B": "UInt8", "q": "Int64"}

    def packed(raw, compressed):
        if not compressed:
            return struct.pack("<I", len(raw)), raw
        blocks = [raw[i:i + 256] for i in range(0, len(raw), 256)]
        small = [zlib.compress(block) for block in blocks]
        return struct.pack(f"<{3 + len(small)}I", len(blocks), 256, len(blocks[-1]) if len(blocks[-1]) < 256 else 0, *map(len, small)), b"".join(small)

    for encoding in ("ascii", "binary", "zlib", "appended", "appended64", "appendedzlib"):
        appended = b""

        def array(name, values, code, components=1):
            nonlocal appended
            head = f'<DataArray type="{types[code]}" Name="{name}" NumberOfComponents="{components}"'
            if encoding == "ascii":
                return f'{head} format="ascii">{" ".join(map(str, values))}</DataArray>'
            header, body = packed(struct.pack(f"<{len(values)}{code}", *values), encoding.endswith("zlib"))
            text = base64.b64encode(header).decode() + base64.b64encode(body).decode() if encoding == "zlib" else base64.b64encode(header + body).decode()
            if not encoding.startswith("appended"):
                return f'{head} format="binary">{text}</DataArray>'
            offset = len(appended)
            appended += text.encode() if encoding == "appended64" else header + body
            return f'{head} format="appended" offset="{offset}"/>'

        for ending, kind in (("vti", "ImageData"), ("vtr", "RectilinearGrid"), ("vts", "StructuredGrid"), ("vtu", "UnstructuredGrid")):
            appended = b""
            data = f'<PointData Scalars="s">{array("s", FIELD, "f")}{array("v", flat(POINTS), "d", 3)}</PointData>'
            if ending == "vti":
                body = f'<ImageData WholeExtent="{extent}" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="{extent}">{data}'
            elif ending == "vtu":
                ends = list(itertools.accumulate(len(cell) for _, cell in CELLS))
                body = (f'<UnstructuredGrid><Piece NumberOfPoints="{len(POINTS)}" NumberOfCells="{len(CELLS)}">{data}'
                        f'<CellData>{array("part", [n % 3 for n in range(len(CELLS))], "i")}</CellData><Points>{array("p", flat(POINTS), "f", 3)}</Points>'
                        f'<Cells>{array("connectivity", flat(cell for _, cell in CELLS), "q")}{array("offsets", ends, "q")}{array("types", [t for t, _ in CELLS], "B")}</Cells>')
            elif ending == "vtr":
                sides = "".join(array(axis, [float(i) for i in range(n)], "d") for axis, n in zip("xyz", (NX, NY, NZ)))
                body = f'<RectilinearGrid WholeExtent="{extent}"><Piece Extent="{extent}">{data}<Coordinates>{sides}</Coordinates>'
            else:
                body = f'<StructuredGrid WholeExtent="{extent}"><Piece Extent="{extent}">{data}<Points>{array("p", flat(POINTS), "f", 3)}</Points>'
            compressor = ' compressor="vtkZLibDataCompressor"' if encoding.endswith("zlib") else ""
            text = f'<VTKFile type="{kind}" version="0.1" byte_order="LittleEndian" header_type="UInt32"{compressor}>{body}</Piece></{kind}>'.encode()
            if appended:
                text += f'<AppendedData encoding="{"base64" if encoding == "appended64" else "raw"}">_'.encode() + appended + b"</AppendedData>"
            (folder / f"{encoding}.{ending}").write_bytes(text + b"</VTKFile>\n")
    (folder / "parts.pvti").write_text(f'<VTKFile type="PImageData"><PImageData WholeExtent="{extent}" GhostLevel="0" Origin="0 0 0" Spacing="1 1 1"><PPointData Scalars="s">'
                                       f'<PDataArray type="Float32" Name="s"/></PPointData><Piece Extent="{extent}" Source="ascii.vti"/></PImageData></VTKFile>\n')
    (folder / "parts.pvtu").write_text('<VTKFile type="PUnstructuredGrid"><PUnstructuredGrid GhostLevel="0"><PPointData Scalars="s"><PDataArray type="Float32" Name="s"/></PPointData><PPoints>'
                                       '<PDataArray type="Float32" NumberOfComponents="3"/></PPoints><Piece Source="ascii.vtu"/><Piece Source="binary.vtu"/></PUnstructuredGrid></VTKFile>\n')
    (folder / "blocks.vtm").write_text('<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet><DataSet index="0" name="a" file="ascii.vtu"/>'
                                       '<Block index="1" name="b"><DataSet index="0" file="zlib.vtu"/></Block></vtkMultiBlockDataSet></VTKFile>\n')
    for name, size, origin in (("coarse", 1, 0), ("fine", 0.5, 1)):
        (folder / f"{name}.vti").write_text(f'<VTKFile type="ImageData" version="0.1"><ImageData WholeExtent="0 4 0 4 0 4" Origin="{origin} {origin} {origin}" Spacing="{size} {size} {size}"><Piece Extent="0 4 0 4 0 4">'
                                            f'<CellData><DataArray type="Float32" Name="s" format="ascii">{" ".join(map(str, range(64)))}</DataArray></CellData></Piece></ImageData></VTKFile>\n')
    (folder / "levels.vthb").write_text('<VTKFile type="vtkOverlappingAMR" version="1.1"><vtkOverlappingAMR origin="0 0 0" grid_description="XYZ"><Block level="0" spacing="1 1 1"><DataSet index="0" '
                                        'amr_box="0 3 0 3 0 3" file="coarse.vti"/></Block><Block level="1" spacing="0.5 0.5 0.5"><DataSet index="0" amr_box="2 5 2 5 2 5" file="fine.vti"/></Block>'
                                        '</vtkOverlappingAMR></VTKFile>\n')
    (folder / "steps.pvd").write_text('<VTKFile type="Collection"><Collection><DataSet timestep="0" file="ascii.vtu"/><DataSet timestep="0.5" file="zlib.vtu"/></Collection></VTKFile>\n')
    (folder / "steps.vtu.series").write_text('{"file-series-version": "1.0", "files": [{"name": "ascii.vtu", "time": 0}, {"name": "binary.vtu", "time": 2}]}\n')


def trees(folder):
    """Hyper tree grids of both versions: two roots, of which the second is refined, and two of its children once more."""
    counts, refined, values = [1, 1, 8, 16], [1, 0, 1, 0, 1, 0, 0, 0, 0], list(range(26))

    def array(binary, kind, name, values):
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfTuples="{len(values)}" format='
        if not binary:
            return f'{head}"ascii">{" ".join(map(str, values))}</DataArray>'
        bits = bytes(sum(bit << 7 - i for i, bit in enumerate(values[at:at + 8])) for at in range(0, len(values), 8)) if kind == "Bit" else b""
        raw = bits or struct.pack(f"<{len(values)}{dict(Float64='d', Int64='q', UInt32='I', Float32='f', Bit='B')[kind]}", *values)
        return f'{head}"binary">{base64.b64encode(struct.pack("<I", len(raw)) + raw).decode()}</DataArray>'

    for version, binary, name in ((2, False, "trees"), (2, True, "packed_trees"), (1, True, "old_trees")):
        def one(*what):
            return array(binary, *what)
        axes = "".join(one("Float64", f"{axis}Coordinates", places) for axis, places in zip("XYZ", ([0, 1, 2], [0, 1], [0, 1])))
        if version == 2:
            body = (f'<Trees>{one("Bit", "Descriptors", refined)}{one("Int64", "NumberOfVerticesPerDepth", counts)}{one("Int64", "TreeIds", [0, 1])}{one("UInt32", "DepthPerTree", [1, 3])}'
                    f'{one("Bit", "Mask", [0] * 25 + [1])}</Trees><CellData>{one("Float32", "s", values)}</CellData>')
        else:
            body = "<Trees>" + "".join(f'<Tree Index="{tree}" NumberOfLevels="{len(own)}" NumberOfVertices="{sum(own)}">{one("Bit", "Descriptor", bits)}{one("Int64", "NbVerticesByLevel", own)}'
                                       f'<CellData>{one("Float32", "s", part)}</CellData></Tree>' for tree, own, bits, part in ((0, [1], [], values[:1]), (1, counts[1:], refined[:5], values[1:]))) + "</Trees>"
        (folder / f"{name}.htg").write_text(f'<VTKFile type="HyperTreeGrid" version="{version}.0" byte_order="LittleEndian" header_type="UInt32"><HyperTreeGrid BranchFactor="2" '
                                            f'TransposedRootIndexing="0" Dimensions="3 2 2"><Grid>{axes}</Grid>{body}</HyperTreeGrid></VTKFile>\n')


def plotfile(folder):
    """Two levels of AMReX, a box each."""
    levels = [(1.0, (0, 0, 0), (3, 3, 3)), (0.5, (2, 2, 2), (5, 5, 5))]
    head = ["HyperCLaw-V1.1", "1", "s", "3", "0.5", "1", "0 0 0", "4 4 4", "2", "((0,0,0) (3,3,3) (0,0,0)) ((0,0,0) (7,7,7) (0,0,0))", "0 0", "1 1 1", "0.5 0.5 0.5", "0", "0"]
    for level, (size, low, high) in enumerate(levels):
        below = folder / f"plotfile/Level_{level}"
        below.mkdir(parents=True)
        box = "((%d,%d,%d) (%d,%d,%d) (0,0,0))" % (*low, *high)
        below.joinpath("Cell_D_00000").write_bytes(f"FAB ((8, (64 11 52 0 1 12 0 1023)),(8, (8 7 6 5 4 3 2 1))){box} 1\n".encode() + floats(range(64), "d"))
        below.joinpath("Cell_H").write_text(f"1\n1\n1\n0\n(1 0\n{box}\n)\n1\nFabOnDisk: Cell_D_00000 0\n")
        head += [f"{level} 1 0.5", "0", *(f"{low[axis] * size} {(high[axis] + 1) * size}" for axis in range(3)), f"Level_{level}/Cell"]
    (folder / "plotfile/Header").write_text("\n".join(head) + "\n")


def rice(row):
    """A row of a FITS image in RICE_1 for 32-bit numbers: the first, then one block of differences, three bits of each as they are."""
    bits = f"{row[0]:032b}{4:05b}"
    for value, before in zip(row, [row[0], *row]):
        folded = 2 * (value - before) if value >= before else 2 * (before - value) - 1
        bits += "0" * (folded >> 3) + f"1{folded & 7:03b}"
    bits += "0" * (-len(bits) % 8)
    return bytes(int(bits[at:at + 8], 2) for at in range(0, len(bits), 8))


def tiles(folder):
    """As fpack packs them: a tile for each row."""
    rows = [[int(v) for v in FIELD[at:at + NX]] for at in range(0, len(FIELD), NX)]

    def cards(*pairs):
        return ("".join(f"{key:8}= {value}".ljust(80) for key, value in pairs) + "END").ljust(2880 * (1 + len(pairs) // 36)).encode()

    for name, kind, pack in (("rice", "RICE_1", rice), ("gzip", "GZIP_1", lambda row: gzip.compress(struct.pack(f">{NX}i", *row)))):
        heap, table = b"", b""
        for row in rows:
            packed = pack(row)
            table += struct.pack(">2i", len(packed), len(heap))
            heap += packed
        head = cards(("XTENSION", "'BINTABLE'"), ("BITPIX", 8), ("NAXIS", 2), ("NAXIS1", 8), ("NAXIS2", len(rows)), ("PCOUNT", len(heap)), ("GCOUNT", 1), ("TFIELDS", 1),
                     ("TTYPE1", "'COMPRESSED_DATA'"), ("TFORM1", "'1PB(100)'"), ("ZIMAGE", "T"), ("ZBITPIX", 32), ("ZNAXIS", 3), ("ZNAXIS1", NX), ("ZNAXIS2", NY), ("ZNAXIS3", NZ),
                     ("ZTILE1", NX), ("ZTILE2", 1), ("ZTILE3", 1), ("ZCMPTYPE", f"'{kind}'"), ("ZNAME1", "'BLOCKSIZE'"), ("ZVAL1", 32), ("ZNAME2", "'BYTEPIX'"), ("ZVAL2", 4))
        body = table + heap
        (folder / f"{name}.fits.fz").write_bytes(cards(("SIMPLE", "T"), ("BITPIX", 8), ("NAXIS", 0)) + head + body + bytes(-len(body) % 2880))


def images(folder):
    raw = floats(FIELD)
    (folder / "field.raw").write_bytes(raw)
    head = f"NRRD0004\ntype: float\ndimension: 3\nsizes: {NX} {NY} {NZ}\nendian: little\nspace: left-posterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,2)\n"
    for encoding, body in (("raw", raw), ("gzip", gzip.compress(raw)), ("ascii", " ".join(map(str, FIELD)).encode()), ("hex", raw.hex().encode())):
        (folder / f"{encoding}.nrrd").write_bytes(f"{head}encoding: {encoding}\n\n".encode() + body)
    (folder / "apart.nhdr").write_text(head + "encoding: raw\ndata file: field.raw\n")
    (folder / "inside.mha").write_bytes(f"ObjectType = Image\nNDims = 3\nDimSize = {NX} {NY} {NZ}\nElementType = MET_FLOAT\nElementByteOrderMSB = False\nElementDataFile = LOCAL\n".encode() + raw)
    cards = ["SIMPLE  =                    T", "BITPIX  =                  -32", "NAXIS   =                    3", f"NAXIS1  = {NX:20}", f"NAXIS2  = {NY:20}", f"NAXIS3  = {NZ:20}", "END"]
    body = floats(FIELD, order=">")
    (folder / "sky.fits").write_bytes("".join(card.ljust(80) for card in cards).ljust(2880).encode() + body + bytes(-len(body) % 2880))
    mrc = struct.pack("<10i", NX, NY, NZ, 2, 0, 0, 0, NX, NY, NZ) + floats([NX, NY, NZ, 90, 90, 90]) + struct.pack("<3i", 1, 2, 3) + floats([0, 500, 200])
    (folder / "map.mrc").write_bytes((mrc.ljust(208, b"\0") + b"MAP DA\0\0").ljust(1024, b"\0") + raw)
    grid = struct.pack("<3i", NX, NY, NZ) + floats(p[0] for p in POINTS) + floats(p[1] for p in POINTS) + floats(p[2] for p in POINTS)
    (folder / "flow.xyz").write_bytes(grid)
    (folder / "flow.q").write_bytes(struct.pack("<3i", NX, NY, NZ) + floats([0.5, 0, 1000, 0]) + floats([v + 1 for v in FIELD]) * 5)


def write(folder, program):
    """All of them into FOLDER, by PROGRAM (isostrata) and Debian's Python, which has the libraries of the formats."""
    folder = pathlib.Path(folder)
    tests = pathlib.Path(__file__).resolve().parent.parent
    subprocess.run(["/usr/bin/python3", "-B", tests / "formats/write_files.py", folder], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    (folder / "facts.json").unlink()
    legacy(folder)
    xml(folder)
    trees(folder)
    plotfile(folder)
    images(folder)
    tiles(folder)
    for name, more in (("layer.vtu", []), ("layer_plain.vtu", ["--compress", "0"]), ("layer.vtkhdf", [])):
        subprocess.run([program, "extract", "torus:6", "--interval", "0:0.3", "--out", folder / name, *more], check=True, stdout=subprocess.DEVNULL)
