"""Raw numbers whose sizes and type are said by a name or by a small header, and two formats of text beside them, for write_files.py. FIELD has i + 10 j + 100 k at
(i, j, k), [k][j][i]."""

import gzip
import zlib

import numpy as np

NX, NY, NZ = 6, 5, 4
UNIT = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
RANGE = {"scalars": [0, 345, 0]}
AT = [5, 3, 2, "scalars", 235]


def put(name, *parts):
    with open(name, "wb") as out:
        for part in parts:
            out.write(part.encode() if isinstance(part, str) else np.ascontiguousarray(part).tobytes())


def named(field, lattice, expect):
    for name, type in {"bonsai_6x5x4_int16.raw": "<i2", "a-6X5X4-float.bin": "<f4", "Head6x5x4.F64": "<f8", "other_6x5x4_uint16_be.raw": ">u2", "no_type_6x5x4.raw": "<f4",
                       "three_6_5_4_u16.dat": "<u2", "of_0.5x0.5_6x5x4_short.raw": "<i2"}.items():
        put(name, field.astype(type))
        lattice(name, RANGE, UNIT, AT)
    put("bytes_6x5x4_uint8.raw", (field / 2).astype("u1"))
    lattice("bytes_6x5x4_uint8.raw", {"scalars": [0, 172, 0]}, UNIT, [5, 3, 2, "scalars", 117])
    with gzip.open("packed_6x5x4_int32.raw.gz", "wb") as out:
        out.write(field.astype("<i4").tobytes())
    lattice("packed_6x5x4_int32.raw.gz", RANGE, UNIT, AT)
    put("steps_6x5x4x2_float32.raw", field.astype("<f4"), (2 * field).astype("<f4"))
    lattice("steps_6x5x4x2_float32.raw", RANGE, UNIT, AT, times=(0.0, 1.0))
    lattice("steps_6x5x4x2_float32.raw", {"scalars": [0, 690, 0]}, UNIT, [5, 3, 2, "scalars", 470], times=(0.0, 1.0), step=1)
    for t in (2, 7):
        put(f"run_t{t:03}_6x5x4_float.raw", (t * field).astype("<f4"))
    lattice("run_t*_6x5x4_float.raw", {"scalars": [0, 690, 0]}, UNIT, [5, 3, 2, "scalars", 470], times=(2.0, 7.0))
    put("flat_6x5_float.raw", field[0].astype("<f4"))
    expect("flat_6x5_float.raw", "uniform", 30, 20, {"scalars": [0, 45, 0]}, [0, 5, 0, 4, 0, 0], [5, 4, 0, "scalars", 45])
    # Smooth, of two bytes, and the wrong way round without a word.
    z, y, x = np.mgrid[0:4, 0:5, 0:64]
    put("smooth_64x5x4_u16.raw", (1000 + 40 * x + 300 * y + 2000 * z).astype(">u2"))
    expect("smooth_64x5x4_u16.raw", "uniform", 1280, 63 * 4 * 3, {"scalars": [1000, 10720, 0]}, [0, 63, 0, 4, 0, 3], [63, 4, 3, "scalars", 10720])


def headers(field, lattice, expect):
    put("nodal.f32", "1234", field.astype("<f4"))
    put("nodal.bov", "TIME: 0.25\nDATA_FILE: nodal.f32\n# remarks\nDATA_SIZE: 6 5 4\nDATA_FORMAT: FLOAT\nVARIABLE: rho\nDATA_ENDIAN: LITTLE\nCENTERING: nodal\n"
        "BRICK_ORIGIN: 1 2 3\nBRICK_SIZE: 10. 4. 3.\nBYTE_OFFSET: 4\n")
    lattice("nodal.bov", {"rho": [0, 345, 0]}, [1, 11, 2, 6, 3, 6], [11, 5, 5, "rho", 235], times=(0.25,))
    put("zonal.gz", gzip.compress(np.full((3, 4, 5), 7, ">i2").tobytes()))
    put("zonal.bov", "DATA_FILE: zonal.gz\nDATA_SIZE: 5 4 3\nDATA_FORMAT: SHORT\nVARIABLE: mat\nDATA_ENDIAN: BIG\nCENTERING: zonal\nBRICK_ORIGIN: 0 0 0\nBRICK_SIZE: 10 4 3\n")
    lattice("zonal.bov", {"mat": [7, 7, 0]}, [0, 10, 0, 4, 0, 3], [10, 3, 2, "mat", 7])
    put("vectors.bin", np.stack([field, 2 * field, 3 * field], -1).astype("<f8"))
    put("vectors.bov", "DATA_FILE: vectors.bin\nDATA_SIZE: 6 5 4\nDATA_FORMAT: DOUBLE\nVARIABLE: v\nDATA_COMPONENTS: 3\nBRICK_SIZE: 5 4 3\n")
    lattice("vectors.bov", {"v_x": [0, 345, 0], "v_z": [0, 1035, 0]}, UNIT, [1, 2, 3, "v_y", 642])

    put("volvis.raw", field.astype("<u2"))
    put("volvis.dat", "ObjectFileName: \tvolvis.raw\nTaggedFileName: ---\nResolution: \t6 5 4\nSliceThickness:\t1 2 0.5\nFormat:\t\tUSHORT\nNbrTags: 0\nObjectType: TEXTURE_VOLUME_OBJECT\n")
    lattice("volvis.dat", RANGE, [0, 5, 0, 8, 0, 1.5], [5, 6, 1, "scalars", 235])
    put("inviwo.raw", field.astype(">f4"))
    put("inviwo.dat", "RawFile: inviwo.raw\r\nResolution: 6 5 4\r\nFormat: FLOAT32\r\nByteOrder: BigEndian\r\nBasisVector1: 12, 0, 0\r\nBasisVector2: 0 5 0\r\nBasisVector3: 0 0 8\r\n"
        "Offset: 0 0 0\r\nValueUnit: K\r\n")
    lattice("inviwo.dat", RANGE, [1, 11, 0.5, 4.5, 1, 7], [11, 3.5, 5, "scalars", 235])

    head = "mrtrix image\ndim: 6,5,4\nvox: 2,3,4\nlayout: +0,+1,+2\ndatatype: Float32LE\ntransform: 1,0,0,10\ntransform: 0,1,0,20\ntransform: 0,0,1,30\n"
    put("plain.mif", (head + "file: . 256\nEND\n").ljust(256, "\0"), field.astype("<f4"))
    lattice("plain.mif", RANGE, [10, 20, 20, 32, 30, 42], [20, 29, 38, "scalars", 235])
    # x from its end to its beginning, z the fastest; scaled.
    turned = head.replace("+0,+1,+2", "-1,+2,+0").replace("Float32LE", "UInt16BE")
    put("turned.mih", turned + "scaling: 5,2\nfile: turned.values 0\nEND\n")
    put("turned.values", field[:, :, ::-1].transpose(1, 2, 0).astype(">u2"))
    lattice("turned.mih", {"scalars": [5, 695, 0]}, [10, 20, 20, 32, 30, 42], [20, 29, 38, "scalars", 475])
    volumes = head.replace("6,5,4", "6,5,4,2").replace("2,3,4", "2,3,4,nan").replace("+2\n", "+2,+3\n")
    put("volumes.mif", (volumes + "file: . 256\nEND\n").ljust(256, "\0"), field.astype("<f4"), (2 * field).astype("<f4"))
    lattice("volumes.mif", {"scalars": [0, 690, 0]}, [10, 20, 20, 32, 30, 42], [20, 29, 38, "scalars", 470], times=(0.0, 1.0), step=1)


def texts(field, lattice, expect):
    turned = field.transpose(2, 1, 0).ravel()  # z is the fastest
    rows = "\n".join(" ".join(f"{v:.6e}" for v in turned[i:i + 3]) for i in range(0, turned.size, 3))
    put("potential.dx", "# Data from APBS\n#\nobject 1 class gridpositions counts 6 5 4\norigin -1.0e+00 2 3\ndelta 2 0 0\ndelta 0 1 0\ndelta 0 0 1\n"
        "object 2 class gridconnections counts 6 5 4\nobject 3 class array type double rank 0 items 120 data follows\n" + rows +
        '\nattribute "dep" string "positions"\nobject "regular positions regular connections" class field\ncomponent "positions" value 1\n')
    lattice("potential.dx", {"values": [0, 345, 0]}, [-1, 9, 2, 6, 3, 6], [9, 5, 5, "values", 235])

    def amira(name, first, lines, *sections):
        put(name, first, "\n\ndefine Lattice 6 5 4\n\nParameters {\n    Content \"6x5x4 field\",\n    BoundingBox 0 10 0 4 -3 0,\n    CoordType \"uniform\"\n}\n\n", lines,
            "\n\n# Data section follows\n", *sections)

    box, at = [0, 10, 0, 4, -3, 0], [10, 3, -1]
    amira("plain.am", "# AmiraMesh BINARY-LITTLE-ENDIAN 2.1", "Lattice { float Data } @1\nLattice { ushort Other } @2", "@1\n", field.astype("<f4"), "\n\n@2\n", (2 * field).astype("<u2"), "\n")
    lattice("plain.am", {"Data": [0, 345, 0], "Other": [0, 690, 0]}, box, [*at, "Other", 470])
    amira("older.am", "# AmiraMesh 3D BINARY 2.0", "Lattice { short[2] V } = @1", "@1\n", np.stack([field, field + 1], -1).astype(">i2"), "\n")
    lattice("older.am", {"V_x": [0, 345, 0], "V_y": [1, 346, 0]}, box, [*at, "V_y", 236])
    zipped = zlib.compress(field.astype("<f8").tobytes())
    amira("zipped.am", "# Avizo BINARY-LITTLE-ENDIAN 2.1", f"Lattice {{ double Data }} @1(HxZip,{len(zipped)})", "@1\n", np.frombuffer(zipped, "u1"), "\n")
    lattice("zipped.am", {"Data": [0, 345, 0]}, box, [*at, "Data", 235])
    labels = (field >= 200).astype("u1").ravel()  # 80 zeros or so, then ones
    zeros = int((labels == 0).sum())
    runs = bytes([zeros, 0]) + bytes([128 + 3, 1, 1, 1]) + bytes([labels.size - zeros - 3, 1])
    amira("labels.am", "# AmiraMesh BINARY-LITTLE-ENDIAN 2.1", f"Lattice {{ byte Labels }} @1(HxByteRLE,{len(runs)})", "@1\n", np.frombuffer(runs, "u1"), "\n")
    lattice("labels.am", {"Labels": [0, 1, 0]}, box, [*at, "Labels", 1])
    amira("text.am", "# AmiraMesh ASCII 1.0", "Lattice { int Data } = @1", "@1\n", "\n".join(f"{int(v)}" for v in field.ravel()) + "\n")
    lattice("text.am", {"Data": [0, 345, 0]}, box, [*at, "Data", 235])


def write(field, lattice, expect):
    named(field, lattice, expect)
    headers(field, lattice, expect)
    texts(field, lattice, expect)
