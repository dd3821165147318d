"""Writes small files of many formats by the libraries of each format's own world (h5py, netCDF4, pydicom, numpy, zarr) or as text, and what is in them, for
tests/data/foreign_formats_test.cpp:   write_files.py FOLDER   writes FOLDER/facts.json:

    {"file": {"grid":, "points":, "cells":, "arrays": {name: [lowest, highest, values that are not finite]}, "times": [...], "bounds": [x0, x1, y0, ...],
              "at": [x, y, z, array, value]}}

The field is x + 10 y + 100 z over the indices of 6 x 5 x 4 points, so that no two axes can be exchanged unnoticed. "at" says what one of the points has.
"""

import gzip
import json
import os
import shutil
import struct
import sys
import zlib

import block_files
import h5py
import hdf5_files
import med_files
import mesh_files
import netCDF4
import netcdf_files
import numpy as np
import PIL.Image
import PIL.TiffImagePlugin
import pydicom
import raw_files
import tecplot_files
import xarray_files
import xdmf_files
import zarr_files
from pydicom.dataset import Dataset, FileDataset, FileMetaDataset

NX, NY, NZ = 6, 5, 4
Z, Y, X = np.mgrid[0:NZ, 0:NY, 0:NX].astype(float)
FIELD = X + 10 * Y + 100 * Z
facts = {}


def expect(name, grid, points, cells, arrays, bounds, at, times=(0.0,), step=None):
    facts[name if step is None else f"{name}@{step}"] = {
        "grid": grid, "points": points, "cells": cells, "times": list(times), "bounds": list(map(float, bounds)), "at": list(at),
        "arrays": {k: list(v) for k, v in arrays.items()}}


def lattice(name, arrays, bounds, at, times=(0.0,), step=None, grid="uniform"):
    expect(name, grid, NX * NY * NZ, (NX - 1) * (NY - 1) * (NZ - 1), arrays, bounds, at, times, step)


def numpy_arrays():
    unit = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
    for name, values in {"c_order": FIELD.astype("f4"), "fortran_order": np.asfortranarray(FIELD), "big_endian": FIELD.astype(">i2"),
                         "bytes": (FIELD / 2).astype("u1"), "halves": FIELD.astype(">f2")}.items():
        np.save(name + ".npy", values)
        top = float(values.max())
        lattice(name + ".npy", {name: [0, top, 0]}, unit, [5, 3, 2, name, float(values[2, 3, 5])])
    np.save("vectors.npy", np.stack([FIELD, 2 * FIELD, 3 * FIELD], -1))
    lattice("vectors.npy", {"vectors_x": [0, 345, 0], "vectors_z": [0, 1035, 0]}, unit, [1, 2, 3, "vectors_y", 2 * 321])
    np.save("flat.npy", FIELD[0])
    expect("flat.npy", "uniform", 30, 20, {"flat": [0, 45, 0]}, [0, 5, 0, 4, 0, 0], [5, 4, 0, "flat", 45])


def climate(name, format, first=0.0):
    with netCDF4.Dataset(name, "w", format=format) as d:
        for dimension, size in (("time", None), ("lev", NZ), ("lat", NY), ("lon", NX)):
            d.createDimension(dimension, size)

        def axis(called, values, **attributes):
            v = d.createVariable(called, "f8", (called,))
            v.setncatts(attributes)
            v[:] = values

        axis("time", [first, first + 6, first + 12], units="hours since 2000-01-01")
        axis("lev", [0, 10, 30, 70], units="m", positive="up", axis="Z")
        axis("lat", [-20, -10, 0, 10, 20], units="degrees_north")
        axis("lon", np.arange(NX) * 5, units="degrees_east")
        t = d.createVariable("T", "f4", ("time", "lev", "lat", "lon"), fill_value=-999.0)
        t.units = "K"
        t[:] = np.stack([FIELD + first + 1000 * i for i in range(3)])
        t[0, 0, 0, 0] = np.ma.masked
        packed = d.createVariable("packed", "i2", ("time", "lev", "lat", "lon"))
        packed.scale_factor, packed.add_offset = 0.5, 100.0
        packed[:] = np.stack([FIELD] * 3)
        missing = d.createVariable("missing", "i2", ("time", "lev", "lat", "lon"), fill_value=-32000)
        missing.scale_factor, missing.add_offset = 0.5, 100.0
        missing[:] = np.stack([FIELD] * 3)
        missing[:, 0, 0, :2] = np.ma.masked
        gone = d.createVariable("gone", "f8", ("time", "lev", "lat", "lon"), fill_value=False)
        gone.missing_value = 1e20
        gone[:] = np.stack([FIELD] * 3)
        gone[:, 0, 0, 1] = 1e20
        d.createVariable("pressure", "f4", ("time", "lat", "lon"))[:] = 1


def netcdf():
    bounds = [0, 25, -20, 20, 0, 70]
    for name, format in (("classic.nc", "NETCDF3_CLASSIC"), ("offset64.cdf", "NETCDF3_64BIT_OFFSET"), ("four.nc", "NETCDF4")):
        climate(name, format)
        lattice(name, {"T": [1, 345, 1], "packed": [0, 345, 0], "missing": [2, 345, 2], "gone": [0, 345, 1]}, bounds, [25, 10, 30, "T", 235], [0, 6, 12], grid="rectilinear")
        lattice(name, {"T": [2000, 2345, 0]}, bounds, [25, 10, 30, "T", 2235], [0, 6, 12], 2, grid="rectilinear")
    with netCDF4.Dataset("weather.nc", "w", format="NETCDF3_64BIT_OFFSET") as d:  # as WRF writes: no axis says that it is time
        for dimension, size in (("Time", None), ("bottom_top", NZ), ("south_north", NY), ("west_east", NX)):
            d.createDimension(dimension, size)
        for name, sign in (("T", 1), ("W", -1)):
            d.createVariable(name, "f4", ("Time", "bottom_top", "south_north", "west_east"))[:] = np.stack([sign * FIELD.astype("f4") + 1000 * i for i in range(3)])
        d.createVariable("XLAT", "f4", ("Time", "south_north", "west_east"))[:] = 1
    unit = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
    for t in range(3):
        lattice("weather.nc", {"T": [1000 * t, 1000 * t + 345, 0], "W": [1000 * t - 345, 1000 * t, 0]}, unit, [5, 3, 2, "T", 1000 * t + 235], [0, 1, 2], t)
    with netCDF4.Dataset("range.nc", "w") as d:
        for dimension, size in (("z", NZ), ("y", NY), ("x", NX)):
            d.createDimension(dimension, size)
        for name, attributes in (("both", {"valid_range": np.array([10, 300], "f4")}), ("least", {"valid_min": np.float32(2)}), ("any", {})):
            v = d.createVariable(name, "f4", ("z", "y", "x"))
            v[:] = FIELD
            v.setncatts(attributes)
    lattice("range.nc", {"both": [10, 300, 35], "least": [2, 345, 2], "any": [0, 345, 0]}, unit, [5, 3, 2, "both", 235])
    climate("ocean_09.nc", "NETCDF3_CLASSIC")
    climate("ocean_10.nc", "NETCDF3_CLASSIC", 18.0)
    lattice("ocean_*.nc", {"T": [1018, 1363, 0]}, bounds, [0, -20, 0, "T", 1018], [0, 6, 12, 18, 24, 30], 4, grid="rectilinear")


def vtkhdf():
    with h5py.File("image.vtkhdf", "w") as file:
        g = file.create_group("VTKHDF")
        g.attrs["Version"] = [1, 0]
        g.attrs.create("Type", np.bytes_("ImageData"))
        g.attrs["WholeExtent"] = np.array([0, NX - 1, 0, NY - 1, 0, NZ - 1])
        g.attrs["Origin"] = [1.0, 2.0, 3.0]
        g.attrs["Spacing"] = [0.5, 1.0, 2.0]
        g.attrs["Direction"] = [1.0, 0, 0, 0, 1, 0, 0, 0, 1]
        g.create_group("PointData").create_dataset("f", data=FIELD.astype("f4"))
    lattice("image.vtkhdf", {"f": [0, 345, 0]}, [1, 3.5, 2, 6, 3, 9], [3.5, 5, 7, "f", 235])
    with h5py.File("image_of_cells.vtkhdf", "w") as file:
        g = file.create_group("VTKHDF")
        g.attrs["Version"] = [1, 0]
        g.attrs.create("Type", np.bytes_("ImageData"))
        for name, value in {"WholeExtent": np.array([0, NX - 1, 0, NY - 1, 0, NZ - 1]), "Origin": [0.0, 0, 0], "Spacing": [1.0, 1, 1], "Direction": [1.0, 0, 0, 0, 1, 0, 0, 0, 1]}.items():
            g.attrs[name] = value
        g.create_group("PointData").create_dataset("f", data=FIELD.astype("f4"))
        cells = g.create_group("CellData")
        cells.create_dataset("c", data=FIELD[1:, 1:, 1:])
        cells.create_dataset("v", data=np.stack([FIELD[1:, 1:, 1:]] * 3, -1))
        g.create_group("FieldData").create_dataset("TimeValue", data=[2.5])
    lattice("image_of_cells.vtkhdf", {"f": [0, 345, 0], "c": [111, 345, 0], "v_x": [111, 345, 0]}, [0, NX - 1, 0, NY - 1, 0, NZ - 1], [5, 4, 3, "c", 345], [2.5])
    with h5py.File("cells.hdf", "w") as file:
        g = file.create_group("VTKHDF")
        g.attrs["Version"] = [1, 0]
        g.attrs.create("Type", np.bytes_("UnstructuredGrid"))
        for called, values in {"NumberOfPoints": [5], "NumberOfCells": [2], "NumberOfConnectivityIds": [8], "Connectivity": [0, 1, 2, 3, 1, 2, 3, 4],
                               "Offsets": [0, 4, 8]}.items():
            g.create_dataset(called, data=np.array(values, "i8"))
        g.create_dataset("Points", data=np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], "f4"))
        g.create_dataset("Types", data=np.array([10, 10], "u1"))
        g.create_group("PointData").create_dataset("f", data=np.arange(5.0))
        g.create_group("CellData").create_dataset("c", data=np.array([3.0, 4.0]))
    expect("cells.hdf", "unstructured", 5, 2, {"f": [0, 4, 0], "c": [3, 4, 0]}, [0, 1] * 3, [1, 1, 1, "c", 4])


def containers():
    unit = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
    whole = {"runs/x": [0, 345, 0], "half": [0, 172, 0]}
    with h5py.File("plain.h5", "w") as file:
        file.create_dataset("runs/x", data=FIELD.astype(">f4"), chunks=(3, 2, 4), compression="gzip", shuffle=True)
        file.create_dataset("half", data=(FIELD / 2).astype("u1"))
        file.create_dataset("positions", data=np.zeros((7, 3)))
        file.create_dataset("records", data=np.zeros((50, 50), [("a", "f4"), ("b", "i2")]))
    lattice("plain.h5", whole, unit, [5, 3, 2, "runs/x", 235])
    with h5py.File("steps.hdf5", "w") as file:
        file.create_dataset("f", data=np.stack([FIELD[:, :, ::-1].repeat(4, 2) + 1000 * t for t in range(3)]).astype("f4"))
    for t in range(3):
        expect("steps.hdf5", "uniform", 4 * 120, 3 * 4 * 23, {"f": [1000 * t, 1000 * t + 345, 0]}, [0, 23, 0, 4, 0, 3], [1, 3, 2, "f", 1000 * t + 235], [0, 1, 2], t)
    with h5py.File("old.mat", "w", userblock_size=512) as file:  # as MATLAB's -v7.3
        file.create_dataset("volume", data=FIELD)
        file.create_dataset("#refs#/a", data=np.zeros((100, 100)))
    with open("old.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\0\2IM")
    lattice("old.mat", {"volume": [0, 345, 0]}, unit, [5, 3, 2, "volume", 235])
    with netCDF4.Dataset("placed.h5", "w") as file:  # by the conventions of netCDF, under HDF5's name
        for name, values in (("z", [0, 10, 30, 70]), ("y", np.arange(NY)), ("x", np.arange(NX) * 5)):
            file.createDimension(name, len(values))
            file.createVariable(name, "f8", (name,))[:] = values
        file.createVariable("T", "f4", ("z", "y", "x"))[:] = FIELD
    lattice("placed.h5", {"T": [0, 345, 0]}, [0, 25, 0, 4, 0, 70], [25, 3, 30, "T", 235], grid="rectilinear")
    arrays = {"x": FIELD, "turned": np.asfortranarray(FIELD.astype("f4") / 2), "half": FIELD.astype("f2"), "times": np.arange(3.0), "name": np.array("text"), "other": FIELD[1:]}
    for name, write in (("stored", np.savez), ("packed", np.savez_compressed)):
        write(name + ".npz", **arrays)
        lattice(name + ".npz", {"x": [0, 345, 0], "turned": [0, 172.5, 0], "half": [0, 345, 0]}, unit, [5, 3, 2, "turned", 117.5])


def cgns_node(parent, name, label, data=None):
    """A node of CGNS/HDF5 (CGNS steering committee, "CGNS/HDF5 file mapping")."""
    g = parent.create_group(name, track_order=True)
    kind = "MT"
    if data is not None:
        if isinstance(data, str):
            data, kind = np.frombuffer(data.encode(), "i1"), "C1"
        else:
            data = np.asarray(data)
            kind = {"int32": "I4", "float64": "R8", "float32": "R4"}[str(data.dtype)]
        g.create_dataset(" data", data=data)
    for attribute, value, size in (("name", name, 33), ("label", label, 33), ("type", kind, 3)):
        g.attrs.create(attribute, np.array(value, dtype=f"S{size}"))
    g.attrs["flags"] = np.array([1], "i4")
    return g


def cgns_file(name):
    file = h5py.File(name, "w", track_order=True)
    for attribute, value, size in (("name", "HDF5 MotherNode", 33), ("label", "Root Node of HDF5 File", 33), ("type", "MT", 3)):
        file.attrs.create(attribute, np.array(value, dtype=f"S{size}"))
    file.create_dataset(" format", data=np.frombuffer(b"IEEE_LITTLE_32\0", "i1"))
    file.create_dataset(" hdf5version", data=np.frombuffer(b"HDF5 Version 1.10.8".ljust(33, b"\0"), "i1"))
    cgns_node(file, "CGNSLibraryVersion", "CGNSLibraryVersion_t", np.array([3.3], "f4"))
    return file, cgns_node(file, "Base", "CGNSBase_t", np.array([3, 3], "i4"))


def cgns():
    file, base = cgns_file("structured.cgns")
    iterative = cgns_node(base, "BaseIterativeData", "BaseIterativeData_t", np.array([2], "i4"))
    cgns_node(iterative, "TimeValues", "DataArray_t", np.array([0.5, 0.75]))
    zone = cgns_node(base, "block", "Zone_t", np.array([[NX, NY, NZ], [NX - 1, NY - 1, NZ - 1], [0, 0, 0]], "i4"))
    cgns_node(zone, "ZoneType", "ZoneType_t", "Structured")
    grid = cgns_node(zone, "GridCoordinates", "GridCoordinates_t")
    for called, values in (("CoordinateX", X + 0.25 * Y), ("CoordinateY", Y), ("CoordinateZ", 2 * Z)):
        cgns_node(grid, called, "DataArray_t", values)
    for step in range(2):
        solution = cgns_node(zone, f"Solution{step}", "FlowSolution_t")
        cgns_node(solution, "GridLocation", "GridLocation_t", "Vertex")
        cgns_node(solution, "Density", "DataArray_t", FIELD + 1000 * step)
    pointers = cgns_node(zone, "ZoneIterativeData", "ZoneIterativeData_t")
    cgns_node(pointers, "FlowSolutionPointers", "DataArray_t", "")
    del pointers["FlowSolutionPointers"][" data"]
    pointers["FlowSolutionPointers"].create_dataset(
        " data", data=np.stack([np.frombuffer(f"Solution{s}".ljust(32).encode(), "i1") for s in range(2)]))
    file.close()
    for step in range(2):
        lattice("structured.cgns", {"Density": [1000 * step, 1000 * step + 345, 0]}, [0, 6, 0, 4, 0, 6], [5.75, 3, 4, "Density", 1000 * step + 235],
                [0.5, 0.75], step, grid="curvilinear")

    file, base = cgns_file("unstructured.cgns")
    zone = cgns_node(base, "tetrahedra", "Zone_t", np.array([[5], [2], [0]], "i4"))
    cgns_node(zone, "ZoneType", "ZoneType_t", "Unstructured")
    grid = cgns_node(zone, "GridCoordinates", "GridCoordinates_t")
    for axis, values in zip("XYZ", ([0, 1, 0, 0, 1], [0, 0, 1, 0, 1], [0, 0, 0, 1, 1])):
        cgns_node(grid, "Coordinate" + axis, "DataArray_t", np.array(values, "f8"))
    elements = cgns_node(zone, "Tetrahedra", "Elements_t", np.array([10, 0], "i4"))
    cgns_node(elements, "ElementRange", "IndexRange_t", np.array([1, 2], "i4"))
    cgns_node(elements, "ElementConnectivity", "DataArray_t", np.array([1, 2, 3, 4, 2, 3, 4, 5], "i4"))
    solution = cgns_node(zone, "Solution", "FlowSolution_t")
    cgns_node(solution, "GridLocation", "GridLocation_t", "CellCenter")
    cgns_node(solution, "Pressure", "DataArray_t", np.array([3.0, 4.0]))
    file.close()
    expect("unstructured.cgns", "unstructured", 5, 2, {"Pressure": [3, 4, 0]}, [0, 1] * 3, [1, 1, 1, "Pressure", 4])


def nifti(name, values, affine, slope=0.0, intercept=0.0, between=0.0, as_qform=None):
    """NIfTI 1 (R. W. Cox, nifti1.h): [t][z][y][x] or [z][y][x] of 16-bit numbers."""
    header = bytearray(352)
    n = list(values.shape[::-1])
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, len(n), *(n + [1] * (7 - len(n))))
    struct.pack_into("<2h", header, 70, 4, 16)
    spacing = [float(np.linalg.norm(affine[:3, a])) for a in range(3)]
    struct.pack_into("<8f", header, 76, -1.0 if as_qform and as_qform[3] < 0 else 1.0, *spacing, between, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352.0, slope, intercept)
    header[123] = 2 | 8  # mm, seconds
    if as_qform:
        struct.pack_into("<2h", header, 252, 1, 0)
        struct.pack_into("<6f", header, 256, *as_qform[:3], *affine[:3, 3])
    else:
        struct.pack_into("<2h", header, 252, 0, 1)
        struct.pack_into("<12f", header, 280, *affine[:3].ravel())
    header[344:348] = b"n+1\0"
    with open(name, "wb") as out:
        out.write(bytes(header) + values.astype("<i2").tobytes())


def nifti_files():
    straight = np.diag([1.0, 2.0, 3.0, 1.0])
    nifti("straight.nii", FIELD, straight)
    lattice("straight.nii", {"intensity": [0, 345, 0]}, [0, 5, 0, 8, 0, 9], [5, 6, 6, "intensity", 235])
    nifti("scaled.nii", np.stack([FIELD + 1000 * t for t in range(3)]), straight, 0.5, 7.0, 2.5)
    lattice("scaled.nii", {"intensity": [507, 679.5, 0]}, [0, 5, 0, 8, 0, 9], [5, 6, 6, "intensity", 624.5], [0, 2.5, 5], 1)
    turned = np.array([[-2, 0, 0, 10], [0, 0, 3, 20], [0, -1.5, 0, 30], [0, 0, 0, 1.0]])
    nifti("turned.nii", FIELD, turned)
    lattice("turned.nii", {"intensity": [0, 345, 0]}, [0, 10, 20, 29, 24, 30], [0, 26, 25.5, "intensity", 235], grid="curvilinear")
    half = np.array([[-1, 0, 0, 5], [0, -2, 0, 6], [0, 0, 3, 7], [0, 0, 0, 1.0]])
    nifti("quaternion.nii", FIELD, half, as_qform=(0.0, 0.0, 1.0, 1.0))  # half a turn about z
    lattice("quaternion.nii", {"intensity": [0, 345, 0]}, [0, 5, -2, 6, 7, 16], [0, 0, 13, "intensity", 235])


def dicom(folder, implicit, thick=2.5):
    os.makedirs(folder)
    syntax = "1.2.840.10008.1.2" if implicit else "1.2.840.10008.1.2.1"
    for k in range(NZ):
        meta = FileMetaDataset()
        meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
        meta.MediaStorageSOPInstanceUID = f"1.2.3.{k + 1}"
        meta.TransferSyntaxUID = syntax
        d = FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
        d.SOPClassUID, d.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
        other = Dataset()
        other.SeriesInstanceUID = "9.9.9"
        d.ReferencedSeriesSequence = pydicom.Sequence([other])
        d.Modality, d.SeriesInstanceUID, d.InstanceNumber = "CT", "1.2.3", NZ - k
        d.ImagePositionPatient, d.ImageOrientationPatient = [-10, -20, 5 + thick * k], [1, 0, 0, 0, 1, 0]
        d.PixelSpacing, d.SliceThickness = [0.75, 0.5], thick
        d.Rows, d.Columns, d.SamplesPerPixel, d.PhotometricInterpretation = NY, NX, 1, "MONOCHROME2"
        d.BitsAllocated, d.BitsStored, d.HighBit, d.PixelRepresentation = 16, 12, 11, 0
        d.RescaleSlope, d.RescaleIntercept = 1, -1024
        d.PixelData = (FIELD[k].astype("<u2") | 0xF000).tobytes()  # the highest bits are not part of the value
        d["PixelData"].VR = "OW"
        path = os.path.join(folder, f"picture{(k * 7 + 2) % NZ}.dcm")
        if int(pydicom.__version__.split(".")[0]) >= 3:
            d.save_as(path, implicit_vr=implicit, little_endian=True, enforce_file_format=True)
        else:
            d.is_little_endian, d.is_implicit_VR = True, implicit
            d.save_as(path, write_like_original=False)
    lattice(folder, {"Hounsfield": [-1024, -679, 0]}, [-10, -7.5, -20, -17, 5, 12.5], [-7.5, -17.75, 10, "Hounsfield", 235 - 1024])


def gaussian_cube():
    with open("orbitals.cube", "w") as out:
        out.write("made by a test\ntwo orbitals\n -1 1.0 2.0 3.0\n")
        for n, step in ((NX, (0.5, 0, 0)), (NY, (0, 1, 0)), (NZ, (0, 0, 2))):
            out.write(f" {n} {step[0]} {step[1]} {step[2]}\n")
        out.write(" 1 1.0 0 0 0\n 2 7 8\n")
        values = np.stack([FIELD, -FIELD], -1).transpose(2, 1, 0, 3).ravel()
        for at in range(0, len(values), 6):
            out.write(" ".join(f"{v:13.5E}" for v in values[at:at + 6]) + "\n")
    lattice("orbitals.cube", {"orbital 7": [0, 345, 0], "orbital 8": [-345, 0, 0]}, [1, 3.5, 2, 6, 3, 9], [3.5, 5, 7, "orbital 8", -235])
    with open("orbitals.cube") as file:  # as Fortran writes numbers: 0.5D-02, and 0.5-102 where the letter finds no place
        text = file.read().replace(" -1 1.0 2.0 3.0\n", " 1 1.0 2.0 3.0 2\n").replace(" 2 7 8\n", "").replace("E+", "D+")
    with open("values.cube", "w") as out:
        out.write(text.replace("  1.00000D+00", "  1.00000-102", 1))
    lattice("values.cube", {"value 1": [0, 345, 0], "value 2": [-345, 0, 0]}, [1, 3.5, 2, 6, 3, 9], [1.5, 2, 3, "value 1", 1e-102])
    one = text.replace(" 1 1.0 2.0 3.0 2\n", " 1 1.0 2.0 3.0\n")
    for i, (remark, name) in enumerate((("-Quickstep-\n HARTREE POTENTIAL\n", "potential"), ("-Quickstep-\n  WAVEFUNCTION            4  spin            1  i.e. HOMO -            0\n", "orbital 4"),
                                        ("-Quickstep-\n  ELF spin            1\n", "localization"), (" Title Card\n Electrostatic potential from Total SCF Density\n", "potential"), ("water\nMO = 12\n", "orbital 12"),
                                        (" Title\n Electron density from Total SCF Density\n", "density"), ("spin density\nof a test\n", "spin density"), ("made by itself\nOUTER LOOP: X, MIDDLE LOOP: Y, INNER LOOP: Z\n", "density"))):
        with open(f"remark_{i}.cube", "w") as out:  # the first of each two values is the field's
            lines = one.split("\n")
            head, numbers = lines[2:7], " ".join(lines[7:]).replace("D", "E").split()[::2]
            out.write(remark + "\n".join(head) + "\n" + "\n".join(numbers) + "\n")
        lattice(f"remark_{i}.cube", {name: [0, 345, 0]}, [1, 3.5, 2, 6, 3, 9], [3.5, 5, 7, name, 235])


def geo_tiffs():
    """The upper left corner at 1000, 5000, pixels of 10 by 20 m; north is up. As corners or middles of pixels, by a scale or by a matrix; turned by a matrix."""
    for name, tags, first in (("corner.tif", {33550: (10.0, 20.0, 0.0), 33922: (0.0, 0.0, 0.0, 1000.0, 5000.0, 0.0), 34735: (1, 1, 0, 1, 1025, 0, 1, 1), 42113: "-9999"}, (1005, 4990)),
                              ("middle.tif", {33550: (10.0, 20.0, 0.0), 33922: (2.0, 1.0, 0.0, 1020.0, 4980.0, 0.0), 34735: (1, 1, 0, 1, 1025, 0, 1, 2), 42113: "-9999"}, (1000, 5000)),
                              ("matrix.tif", {34264: (10.0, 0.0, 0.0, 1000.0, 0.0, -20.0, 0.0, 5000.0) + (0.0,) * 7 + (1.0,), 42113: "-9999 "}, (1005, 4990))):
        values = FIELD[0].astype("f4")
        values[0, 0] = -9999
        info = PIL.TiffImagePlugin.ImageFileDirectory_v2()
        for tag, value in tags.items():
            info[tag] = value
            info.tagtype[tag] = 2 if isinstance(value, str) else 12 if isinstance(value[0], float) else 3
        PIL.Image.fromarray(values).save(name, tiffinfo=info)
        bounds = [first[0], first[0] + 10 * (NX - 1), first[1] - 20 * (NY - 1), first[1], 0, 0]
        expect(name, "uniform", NX * NY, (NX - 1) * (NY - 1), {"Tiff Scalars": [1, 45, 1]}, bounds, [first[0] + 30, first[1] - 20, 0, "Tiff Scalars", 13])


def ensight():
    """EnSight Gold in ASCII (EnSight User Manual, "EnSight Gold casefile format"): two steps of one part, and of a part of another name beside it."""
    with open("box.case", "w") as out:
        out.write("FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: box.geo\nVARIABLE\nscalar per node: 1 f f_**.scl\nscalar per element: 1 c c_**.scl\n"
                  "TIME\ntime set: 1\nnumber of steps: 2\nfilename start number: 0\nfilename increment: 1\ntime values: 0.5 1.5\n")
    parts = [(1, "upstream", 0.0), (2, "downstream", NX - 1.0)]
    reals = lambda values: "".join(f"{v:12.5e}\n" for v in values.ravel())
    number = lambda i, j, k: 1 + i + NX * (j + NY * k)
    cells = [(i, j, k) for k in range(NZ - 1) for j in range(NY - 1) for i in range(NX - 1)]
    with open("box.geo", "w") as out:
        out.write("made by a test\ntwo boxes\nnode id assign\nelement id assign\n")
        for part, called, shift in parts:
            out.write(f"part\n{part:10d}\n{called}\ncoordinates\n{NX * NY * NZ:10d}\n" + reals(X + shift) + reals(Y) + reals(Z))
            out.write(f"hexa8\n{len(cells):10d}\n")
            for i, j, k in cells:
                out.write("".join(f"{number(i + a, j + b, k + c):10d}" for c in (0, 1) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))) + "\n")
    for step in range(2):
        with open(f"f_0{step}.scl", "w") as out:
            out.write("f\n")
            for part, _, shift in parts:
                out.write(f"part\n{part:10d}\ncoordinates\n" + reals(FIELD + shift + 1000 * step))
        with open(f"c_0{step}.scl", "w") as out:
            out.write("c\n")
            for part, _, shift in parts:
                out.write(f"part\n{part:10d}\nhexa8\n" + "7\n" * len(cells))
        expect("box.case", "unstructured", 2 * NX * NY * NZ - NY * NZ, 2 * len(cells), {"f": [1000 * step, 1000 * step + 350, 0], "c": [7, 7, 0]},
               [0, 10, 0, NY - 1, 0, NZ - 1], [10, 3, 2, "f", 1000 * step + 240], [0.5, 1.5], step)


def older_and_binary_ensight():
    """EnSight 6 as text, whose parts stand on one line, and EnSight Gold in C's bytes, whose texts end at a zero and go on with anything."""
    corners = [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    text = lambda words: (words.encode() + b"\0").ljust(80, b"x")
    whole = lambda *numbers: struct.pack(f"<{len(numbers)}i", *numbers)
    reals = lambda numbers: struct.pack(f"<{len(numbers)}f", *numbers)
    with open("six.case", "w") as out:
        out.write("FORMAT\ntype: ensight\nGEOMETRY\nmodel: six.geo\nVARIABLE\nscalar per node: f six.scl\n")
    with open("six.geo", "w") as out:
        out.write("made by a test\na box\nnode id assign\nelement id assign\ncoordinates\n       8\n")
        out.write("".join("%12.5e%12.5e%12.5e\n" % corner for corner in corners) + "part 1\nbox\nhexa8\n       1\n" + "".join(f"{n:8d}" for n in range(1, 9)) + "\n")
    with open("six.scl", "w") as out:
        out.write("f\n" + "".join(f"{n:12.5e}" for n in range(6)) + "\n" + "".join(f"{n:12.5e}" for n in (6, 7)) + "\n")
    with open("gold.case", "w") as out:
        out.write("FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: 1 gold.geo\nVARIABLE\nscalar per node: 1 f gold.scl\nTIME\ntime set: 1 steps\n"
                  "number of steps: 1\ntime values: 0.5\n")
    with open("gold.geo", "wb") as out:
        for line in ("C Binary", "made by a test", "a box", "node id assign", "element id assign", "part"):
            out.write(text(line))
        out.write(whole(1) + text("box") + text("coordinates") + whole(8) + b"".join(reals([corner[axis] for corner in corners]) for axis in range(3)))
        out.write(text("hexa8") + whole(1, *range(1, 9)))
    with open("gold.scl", "wb") as out:
        out.write(text("f") + text("part") + whole(1) + text("coordinates") + reals(range(8)))
    for name, section in (("material.case", "MATERIAL\nmaterial set number: 1 m\n"), ("scripts.case", "SCRIPTS\nmetadata: x.xml\n")):
        with open(name, "w") as out:
            out.write("FORMAT\ntype: ensight\nGEOMETRY\nmodel: six.geo\nVARIABLE\nscalar per node: f six.scl\n" + section)
    os.makedirs("quoted")
    for name in ("six.geo", "six.scl"):
        shutil.copy(name, "quoted")
    with open("quotes.case", "w") as out:  # as newer writers have names, which may then have blanks
        out.write("FORMAT\ntype: ensight\nGEOMETRY\nmodel: \"quoted/six.geo\"\nVARIABLE\nscalar per node: f \"quoted/six.scl\"\r\n")
    for name, time in (("six.case", 0.0), ("gold.case", 0.5), ("material.case", 0.0), ("scripts.case", 0.0), ("quotes.case", 0.0)):
        expect(name, "unstructured", 8, 1, {"f": [0, 7, 0]}, [0, 1, 0, 1, 0, 1], [1, 1, 0, "f", 2], [time])


def named_ensight():
    """Steps of box.case under other names: with blanks, numbered by a list, and by lists in files of their own."""
    def steps(name, model, values, numbers, times="time values: 0.5 1.5"):
        with open(name, "w") as out:
            out.write(f"FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: {model}\nVARIABLE\nscalar per node: 1 f {values}\nTIME\ntime set: 1\nnumber of steps: 2\n{numbers}\n{times}\n")
        for step in range(2):
            expect(name, "unstructured", 2 * NX * NY * NZ - NY * NZ, 2 * (NX - 1) * (NY - 1) * (NZ - 1), {"f": [1000 * step, 1000 * step + 350, 0]},
                   [0, 10, 0, NY - 1, 0, NZ - 1], [10, 3, 2, "f", 1000 * step + 240], [0.5, 1.5], step)

    os.makedirs("my case/my steps")
    shutil.copy("box.geo", "my case/a box.geo")
    for step, number in enumerate((7, 12)):
        shutil.copy(f"f_0{step}.scl", f"my case/my steps/f at {number:04d}.scl")
        shutil.copy(f"f_0{step}.scl", f"f{number}.scl")
    steps("my case/a case.case", '"a box.geo"', '"my steps/f at ****.scl"', "filename numbers: 7 12")
    steps("blanks.case", '"my case/a box.geo"', '"my case/my steps/f at ****.scl"', "filename start number: 7\nfilename increment: 5")
    steps("one_star.case", "box.geo", "f*.scl", "filename numbers:\n7\n12", "time values:\n0.5\n1.5")
    shutil.copy("f12.scl", "f13.scl")
    uneven = "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: box.geo\nVARIABLE\nscalar per node: 1 f f*.scl\nTIME\ntime set: 1\nnumber of steps: 3\nfilename numbers: 7\n12\n13\ntime values: 1 2 4\n"
    with open("uneven.case", "w") as out:
        out.write(uneven)
    with open("uneven_dos.case", "w") as out:
        out.write(uneven.replace("\n", "\r\n"))
    for name in ("uneven.case", "uneven_dos.case"):
        expect(name, "unstructured", 2 * NX * NY * NZ - NY * NZ, 2 * (NX - 1) * (NY - 1) * (NZ - 1), {"f": [1000, 1350, 0]},
               [0, 10, 0, NY - 1, 0, NZ - 1], [10, 3, 2, "f", 1240], [1, 2, 4], 2)
    times = [i / 4 for i in range(80)]
    for step in range(len(times)):
        os.link("f7.scl", f"long{step:02d}.scl")
    with open("long_line.case", "w") as out:
        out.write("FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: box.geo\nVARIABLE\nscalar per node: 1 f long**.scl\nTIME\ntime set: 1\nnumber of steps: 80\n"
                  "filename start number: 0\nfilename increment: 1\ntime values: " + " ".join(map(str, times)) + "\n")
    expect("long_line.case", "unstructured", 2 * NX * NY * NZ - NY * NZ, 2 * (NX - 1) * (NY - 1) * (NZ - 1), {"f": [0, 350, 0]},
           [0, 10, 0, NY - 1, 0, NZ - 1], [10, 3, 2, "f", 240], times, 79)
    with open("numbers.txt", "w") as out:
        out.write("7\n12\n")
    with open("the times.txt", "w") as out:
        out.write("0.5 1.5\n")
    steps("lists.case", "box.geo", "f*.scl", "filename numbers file: numbers.txt", 'time values file: "the times.txt"')


def pictures():
    unit = [0, NX - 1, 0, NY - 1, 0, NZ - 1]
    values = FIELD.astype("u2")
    for k in range(NZ):
        PIL.Image.fromarray(values[k][::-1]).save(f"slice_{k + 8}.png")  # pictures begin at the top
    lattice("slice_*.png", {"PNGImage": [0, 345, 0]}, unit, [5, 3, 2, "PNGImage", 235])
    pages = [PIL.Image.fromarray(page.astype("f4")) for page in FIELD]
    pages[0].save("pages.tif", save_all=True, append_images=pages[1:])
    lattice("pages.tif", {"Tiff Scalars": [0, 345, 0]}, unit, [5, 2, 3, "Tiff Scalars", 325])  # the row in the middle: VTK may turn pages over


def meta_images():
    head = f"ObjectType = Image\nNDims = 3\nDimSize = {NX} {NY} {NZ}\nElementSpacing = 0.5 1 2\nElementType = MET_SHORT\nElementByteOrderMSB = False\n"
    for k in range(NZ):
        FIELD[k].astype("<i2").tofile(f"plane_{k + 1:03d}.raw")
    for name, files in (("pattern.mhd", f"plane_%03d.raw 1 {NZ} 1"), ("list.mhd", "LIST\n" + "".join(f"plane_{k + 1:03d}.raw\n" for k in range(NZ)))):
        with open(name, "w") as out:
            out.write(head + "ElementDataFile = " + files + ("\n" if files[0] == "p" else ""))
        lattice(name, {"MetaImage": [0, 345, 0]}, [0, 2.5, 0, 4, 0, 6], [2.5, 3, 4, "MetaImage", 235])
    for name, matrix, grid, bounds, at in (("mirrored.mhd", "-1 0 0 0 1 0 0 0 1", "uniform", [7.5, 10, 20, 24, 30, 36], [7.5, 23, 34]),
                                           ("turned.mhd", "0 1 0 -1 0 0 0 0 1", "curvilinear", [6, 10, 20, 22.5, 30, 36], [7, 22.5, 34])):
        with open(name, "w") as out:  # the first axis runs along the matrix's first row
            out.write(head + "Offset = 10 20 30\nTransformMatrix = " + matrix + f"\nElementDataFile = plane_%03d.raw 1 {NZ} 1\n")
        lattice(name, {"MetaImage": [0, 345, 0]}, bounds, [*at, "MetaImage", 235], grid=grid)
    placed = [0, 2.5, 0, 4, 0, 6], [2.5, 3, 4, "MetaImage", 235]
    for name, kind in (("long", "<i4"), ("ulong", "<u4"), ("long_long", "<i8"), ("ulong_long", "<u8")):  # ITK's sizes, on every machine
        with open(name + ".mha", "wb") as out:
            out.write((head.replace("MET_SHORT", "MET_" + name.upper()) + "ElementDataFile = LOCAL\n").encode() + FIELD.astype(kind).tobytes())
        lattice(name + ".mha", {"MetaImage": [0, 345, 0]}, *placed)
    with open("compressed.mha", "wb") as out:  # without CompressedDataSize
        out.write((head + "CompressedData = True\nElementDataFile = LOCAL\n").encode() + zlib.compress(FIELD.astype("<i2").tobytes()))
    lattice("compressed.mha", {"MetaImage": [0, 345, 0]}, *placed)
    with open("text.mha", "w") as out:
        out.write(head + "BinaryData = False\nElementDataFile = LOCAL\n" + " ".join(str(int(v)) for v in FIELD.ravel()))
    lattice("text.mha", {"MetaImage": [0, 345, 0]}, *placed)
    with open("pairs.mha", "wb") as out:
        out.write((head.replace("MET_SHORT", "MET_USHORT_ARRAY") + "ElementNumberOfChannels = 2\nHeaderSize = -1\nElementDataFile = LOCAL\n").encode() +
                  np.stack([FIELD, FIELD + 1], -1).astype("<u2").tobytes())
    lattice("pairs.mha", {"MetaImage_x": [0, 345, 0], "MetaImage_y": [1, 346, 0]}, placed[0], [2.5, 3, 4, "MetaImage_y", 236])


def packed():
    text = (f"# vtk DataFile Version 3.0\nmade by a test\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS {NX} {NY} {NZ}\nORIGIN 1 2 3\nSPACING 0.5 1 2\n"
            f"POINT_DATA {NX * NY * NZ}\nSCALARS f float 1\nLOOKUP_TABLE default\n" + " ".join(map(str, FIELD.ravel())) + "\n")
    with gzip.open("legacy.vtk.gz", "wt") as out:
        out.write(text)
    lattice("legacy.vtk.gz", {"f": [0, 345, 0]}, [1, 3.5, 2, 6, 3, 9], [3.5, 5, 7, "f", 235])
    with open("c_order.npy", "rb") as whole, gzip.open("packed.npy.gz", "wb") as out:
        out.write(whole.read())
    lattice("packed.npy.gz", {"packed": [0, 345, 0]}, [0, NX - 1, 0, NY - 1, 0, NZ - 1], [5, 3, 2, "packed", 235])


def xsf():
    """Two grids of the same points, one of others; z fastest is what nobody else has."""
    grid = lambda name, edge, values: (f"BEGIN_BLOCK_DATAGRID_3D\n some_name\nBEGIN_DATAGRID_3D_{name}\n {values.shape[2]} {values.shape[1]} {values.shape[0]}\n 1.0 2.0 3.0\n {edge} 0 0\n 0 8 0\n 0 0 -9\n" +
                                       "\n".join(" ".join(f"{v:.6E}" for v in row) for row in values.reshape(-1, 3)) + "\nEND_DATAGRID_3D\nEND_BLOCK_DATAGRID_3D\n")
    with open("grids.xsf", "w") as out:
        out.write("# a remark\nCRYSTAL\nPRIMVEC\n 5 0 0\n 0 8 0\n 0 0 9\nPRIMCOORD\n1 1\n 8 0.1 0.2 0.3\n" + grid("density", 5, FIELD) + grid("spin", 5, -FIELD) + grid("coarse", 5, FIELD[:2, :, :3]))
    lattice("grids.xsf", {"density": [0, 345, 0], "spin": [-345, 0, 0]}, [1, 6, 2, 10, -6, 3], [6, 10, -6, "density", 345])


def vasp():
    """The cell's volume is 2 * 3 * 4 = 24, by a scale; numbers of points are 6, 5, 4 without the far sides, so the bounds are the cell's."""
    title = lambda scale, a, b, c, names: f"a title\n {scale}\n {a} 0 0\n 0 {b} 0\n 0 0 {c}\n{names} 1 2\nDirect\n" + " 0.5 0.5 0.5\n" * 3 + f"\n {NX} {NY} {NZ}\n"
    rows = lambda values: "\n".join(" " + " ".join(f"{v:.11E}" for v in values.ravel()[i:i + 5]) for i in range(0, values.size, 5)) + "\n"
    augmented = "augmentation occupancies 1 3\n 0.1 0.2 0.3\n"
    files = {"CHGCAR": (title(2, 1, 1.5, 2, " O H\n") + rows(24 * FIELD) + augmented + f" {NX} {NY} {NZ}\n" + rows(-24 * FIELD) + augmented, {"charge density": 1, "magnetization density": -1}),
             "AECCAR0": (title(-24, 1, 1.5, 2, "") + rows(24 * FIELD), {"charge density": 1}),
             "LOCPOT": (title(1, 2, 3, 4, " O H\n").replace("Direct", "Selective dynamics\nDirect").replace("0.5\n", "0.5 T T F\n") + rows(FIELD), {"potential": 1})}
    for name, (text, arrays) in files.items():
        with open(name, "w") as out:
            out.write(text)
        expect(name, "uniform", (NX + 1) * (NY + 1) * (NZ + 1), NX * NY * NZ, {array: sorted([0, 345 * sign]) + [0] for array, sign in arrays.items()}, [0, 2, 0, 3, 0, 4],
               [2 * 5 / 6, 3 * 3 / 5, 4 * 2 / 4, next(iter(arrays)), 235])
    with open("LOCPOT", "rb") as whole, gzip.open("LOCPOT.gz", "wb") as out:
        out.write(whole.read())
    facts["LOCPOT.gz"] = facts["LOCPOT"]


def freesurfer():
    """x to the left, y down, z to the front, as FreeSurfer's own are; the middle of the volume is at 10, 20, 30."""
    affine = np.array([[-1, 0, 0, 10 + NX / 2], [0, 0, 3, 20 - 3 * NZ / 2], [0, -2, 0, 30 + 2 * NY / 2]])
    directions = [-1, 0, 0, 0, 0, -1, 0, 1, 0]
    places = np.stack([affine[:, :3] @ [i, j, k] + affine[:, 3] for k in (0, NZ - 1) for j in (0, NY - 1) for i in (0, NX - 1)])
    bounds = np.stack([places.min(0), places.max(0)], 1).ravel()
    for name, code, kind, frames in (("head.mgh", 3, ">f4", 1), ("short.mgz", 4, ">i2", 2)):
        header = struct.pack(">7i", 1, NX, NY, NZ, frames, code, 0) + struct.pack(">h15f", 1, 1, 2, 3, *directions, 10, 20, 30)
        values = b"".join((FIELD + 1000 * frame).astype(kind).tobytes() for frame in range(frames))
        with (gzip.open if name.endswith("z") else open)(name, "wb") as out:
            out.write(header.ljust(284, b"\0") + values + b"tags")
        for frame in range(frames):
            at = affine[:, :3] @ [5, 3, 2] + affine[:, 3]
            lattice(name, {"intensity": [1000 * frame, 345 + 1000 * frame, 0]}, bounds, [*map(float, at), "intensity", 235 + 1000 * frame], range(frames), frame if frames > 1 else None, "curvilinear")


def openfoam_part(folder, cells, layer=0, binary=False):
    """A box of hexahedra of edge 1, 2, 3, as blockMesh writes it. The first of its layers along z is this one of a whole."""
    nx, ny, nz = cells
    number = lambda i, j, k: i + (nx + 1) * (j + (ny + 1) * k)
    cell = lambda i, j, k: i + nx * (j + ny * k)
    points = [(i, 2 * j, 3 * (k + layer)) for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
    inner, outer = [], []
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                corner = lambda a, b, c: number(i + a, j + b, k + c)
                for face, inside, neighbour in (
                        ((corner(1, 0, 0), corner(1, 1, 0), corner(1, 1, 1), corner(1, 0, 1)), i + 1 < nx, (i + 1, j, k)),
                        ((corner(0, 1, 0), corner(0, 1, 1), corner(1, 1, 1), corner(1, 1, 0)), j + 1 < ny, (i, j + 1, k)),
                        ((corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)), k + 1 < nz, (i, j, k + 1))):
                    (inner if inside else outer).append((face, cell(i, j, k), cell(*neighbour) if inside else None))
                for face, border in (((corner(0, 0, 0), corner(0, 0, 1), corner(0, 1, 1), corner(0, 1, 0)), i == 0),
                                     ((corner(0, 0, 0), corner(1, 0, 0), corner(1, 0, 1), corner(0, 0, 1)), j == 0),
                                     ((corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)), k == 0)):
                    if border:
                        outer.append((face, cell(i, j, k), None))
    faces = inner + outer

    def write(path, kind, body, place, raw=binary):
        os.makedirs(os.path.dirname(os.path.join(folder, path)), exist_ok=True)
        form = "binary;\n    arch \"LSB;label=32;scalar=64\"" if raw else "ascii"
        with open(os.path.join(folder, path), "wb") as out:
            out.write(("FoamFile\n{\n    version 2.0;\n    format " + form + ";\n    class " + kind + ";\n    location \"" + place + "\";\n    object " + os.path.basename(path) + ";\n}\n").encode() + body)

    def listed(rows, code):
        if binary:
            numbers = [number for row in rows for number in row]
            return f"{len(rows)}\n(".encode() + struct.pack(f"<{len(numbers)}{code}", *numbers) + b")\n"
        entries = [str(row[0]) if len(row) == 1 else "(" + " ".join(map(str, row)) + ")" for row in rows]
        return (f"{len(entries)}\n(\n" + "\n".join(entries) + "\n)\n").encode()

    mesh = "constant/polyMesh"
    write(mesh + "/points", "vectorField", listed(points, "d"), mesh)
    if binary:
        write(mesh + "/faces", "faceCompactList", listed([(4 * n,) for n in range(len(faces) + 1)], "i") + listed([(p,) for f, _, _ in faces for p in f], "i"), mesh)
    else:
        write(mesh + "/faces", "faceList", listed([f for f, _, _ in faces], "i").replace(b"\n(", b"\n4(").replace(b"\n4(\n", b"\n(\n"), mesh)
    write(mesh + "/owner", "labelList", listed([(o,) for _, o, _ in faces], "i"), mesh)
    write(mesh + "/neighbour", "labelList", listed([(n,) for _, _, n in inner], "i"), mesh)
    write(mesh + "/boundary", "polyBoundaryMesh", f"1\n(\nwalls\n{{\n type wall;\n nFaces {len(outer)};\n startFace {len(inner)};\n}}\n)\n".encode(), mesh, False)
    if binary:  # it has moved
        write("1/polyMesh/points", "vectorField", listed([(x + 10, y, z) for x, y, z in points], "d"), mesh)
    first = nx * ny * layer
    for time in ("0", "0.5", "1"):
        write(time + "/p", "volScalarField", b"dimensions [0 2 -2 0 0 0 0];\ninternalField nonuniform List<scalar>\n" +
              listed([(c + 100 * float(time),) for c in range(first, first + nx * ny * nz)], "d") + b";\nboundaryField\n{\nwalls\n{\n type zeroGradient;\n}\n}\n", time)


def collate(folder, groups):
    """The folders of the processors as the file handler "collated" has them: in each file a block of bytes for each, of which the first alone has a header."""
    for group in groups:
        parts = [f"{folder}/processor{p}" for p in group]
        total = sum(map(len, groups))
        to = f"{folder}/processors{total}" + (f"_{group[0]}-{group[-1]}" if len(groups) > 1 else "")
        for path, _, names in os.walk(parts[0]):
            below = os.path.relpath(path, parts[0])
            os.makedirs(f"{to}/{below}", exist_ok=True)
            for name in names:
                with open(f"{to}/{below}/{name}", "wb") as out:
                    out.write(f"FoamFile\n{{\n    version     2.0;\n    format      binary;\n    class       decomposedBlockData;\n    location    \"{below}\";\n    object      {name};\n}}\n"
                              "// * * * * * * //\n".encode())
                    for n, part in enumerate(parts):
                        with open(f"{part}/{below}/{name}", "rb") as file:
                            block = file.read()
                        if n > 0:
                            block = block[block.index(b"}\n") + 2:]
                        out.write(f"\n// Processor{group[n]}\n\n{len(block)}\n(".encode() + block + b")\n")
        for part in parts:
            shutil.rmtree(part)
        with open(f"{to}/1/uniform", "w") as out:
            out.write("no field\n")


def openfoam_control(folder):
    os.makedirs(folder + "/system")
    with open(folder + "/system/controlDict", "w") as out:
        out.write("FoamFile\n{\n    version 2.0;\n    format ascii;\n    class dictionary;\n    location \"system\";\n    object controlDict;\n}\n"
                  "application icoFoam;\nstartTime 0;\nendTime 1;\ndeltaT 0.5;\nwriteControl timeStep;\nwriteInterval 1;\n")
    open(folder + "/case.foam", "w").close()


def expect_openfoam(folder, nz, moved=lambda time: 0):
    count = 6 * nz
    for name in (folder, folder + "/case.foam"):
        for step, time in enumerate((0, 0.5, 1)):
            by = moved(time)
            expect(name, "unstructured", 12 * (nz + 1), count, {"p": [100 * time, 100 * time + count - 1, 0]}, [by, 3 + by, 0, 4, 0, 3 * nz],
                   [3 + by, 4, 3 * nz, "p", 100 * time + count - 1], [0, 0.5, 1], step)


def openfoam_regions(folder, part):
    """A case of two regions, and of the whole that they were cut from, which has values at time 0 alone; in the folder of a part of the case or its own."""
    to = os.path.join(folder, part)
    openfoam_part(to, (3, 2, 3))
    for time in ("0.5", "1"):
        os.remove(f"{to}/{time}/p")
    first = 0
    for region, layers in (("lower", 1), ("upper", 2)):
        openfoam_part("region", (3, 2, layers), first)
        for path in ("constant", "0", "0.5", "1"):
            shutil.move("region/" + path, f"{to}/{path}/{region}")
        first += layers
    openfoam_control(folder)
    expect_openfoam(folder, 3)


def openfoam(folder, layers, groups=(), binary=False):
    """A case of 3 x 2 cells in each layer; of several numbers of layers, one that a processor each has computed, in collated files where there are groups of these."""
    for i, count in enumerate(layers):
        openfoam_part(folder if len(layers) == 1 else f"{folder}/processor{i}", (3, 2, count), sum(layers[:i]), binary)
    openfoam_control(folder)
    collate(folder, groups)
    expect_openfoam(folder, sum(layers), lambda time: 10 if binary and time == 1 else 0)


def openfoam_cases():
    openfoam("cavity", [2])
    openfoam("parted", [2, 1, 3])
    openfoam("parted_binary", [2, 1, 3], binary=True)
    openfoam("collated", [2, 1, 3], [[0, 1, 2]])
    openfoam("collated_binary", [2, 1, 3], [[0, 1], [2]], True)
    openfoam_regions("regions", "")
    openfoam_regions("regions_collated", "processor0")
    collate("regions_collated", [[0]])
    openfoam("originals", [2])  # what the first values were made from, as users keep it
    with open("originals/0/p") as values, open("originals/0/p.orig", "w") as out:
        out.write(values.read().replace("nonuniform List<scalar>", "uniform 7;\nformerly"))
    openfoam("gone_on", [1, 2])  # put together at 0.5, and computed further
    openfoam_part("gone_on", (3, 2, 3))
    shutil.rmtree("gone_on/1")


def main():
    os.makedirs(sys.argv[1], exist_ok=True)
    os.chdir(sys.argv[1])
    numpy_arrays()
    netcdf()
    netcdf_files.write(FIELD, lattice, expect)
    vtkhdf()
    containers()
    hdf5_files.write(FIELD, lattice)
    block_files.write()
    xdmf_files.write(FIELD, lattice, expect)
    cgns()
    nifti_files()
    dicom("scan", False)
    dicom("scan_implicit", True)
    gaussian_cube()
    xsf()
    vasp()
    freesurfer()
    mesh_files.write(expect)
    med_files.write(expect)
    tecplot_files.write(FIELD, expect)
    raw_files.write(FIELD, lattice, expect)
    openfoam_cases()
    ensight()
    older_and_binary_ensight()
    named_ensight()
    pictures()
    geo_tiffs()
    meta_images()
    packed()
    zarr_files.write(FIELD, lattice, expect)
    xarray_files.write(FIELD, lattice, expect)
    with open("facts.json", "w") as out:
        json.dump(facts, out)


main()
