"""For the record: ParaView's IsoVolume filter, timed. Run by `isostrata-peer-bench extract --full` in pvpython, with one argument, a JSON
object: {"raw":FILE, "type":"float32", "array":NAME, "dims":[..], "origin":[..], "spacing":[..], "interval":[a,b], "repeat":N}.
Prints {"version", "ms":[..], "cells", "peak_bytes"} as its last line."""
import json
import resource
import sys
import time

from paraview import servermanager, simple

VTK_TYPES = {"int8": "char", "uint8": "unsigned char", "int16": "short", "uint16": "unsigned short", "int32": "int",
             "uint32": "unsigned int", "float32": "float", "float64": "double"}


def main():
    job = json.loads(sys.argv[1])
    reader = simple.ImageReader(FileNames=[job["raw"]])
    reader.DataScalarType = VTK_TYPES[job["type"]]
    reader.DataByteOrder = "LittleEndian"
    reader.DataExtent = [0, job["dims"][0] - 1, 0, job["dims"][1] - 1, 0, job["dims"][2] - 1]
    reader.DataOrigin = job["origin"]
    reader.DataSpacing = job["spacing"]
    reader.ScalarArrayName = job["array"]
    reader.UpdatePipeline()
    ms = []
    cells = 0
    for _ in range(job["repeat"]):
        volume = simple.IsoVolume(Input=reader)
        volume.InputScalars = ["POINTS", job["array"]]
        volume.ThresholdRange = job["interval"]
        start = time.monotonic()
        volume.UpdatePipeline()
        ms.append((time.monotonic() - start) * 1e3)
        cells = volume.GetDataInformation().GetNumberOfCells()
        simple.Delete(volume)
        del volume
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    if cells == 0:
        sys.exit("IsoVolume made no cells")
    version = servermanager.vtkSMProxyManager.GetParaViewSourceVersion().removeprefix("paraview version ")
    print("\n" + json.dumps({"version": version, "ms": ms, "cells": cells, "peak_bytes": peak}), flush=True)


main()
