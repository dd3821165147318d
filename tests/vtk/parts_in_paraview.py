#!/usr/bin/env pvpython
"""What ParaView makes of lists of pieces that `isostrata partition` has written: pvpython tests/vtk/parts_in_paraview.py LIST...
One line for each list: its cells, how many of them are ghosts, the volume of the others, and each array's range. Compare with `isostrata info FILE` of the
file that was divided; nothing here passes or fails. Colours each list and saves it as LIST.png, too."""
import sys

import paraview
from paraview import simple

print("ParaView", paraview.__version__)
for path in sys.argv[1:]:
    whole = simple.OpenDataFile(path)
    whole.UpdatePipeline()
    data = simple.servermanager.Fetch(whole)
    marks = data.GetCellData().GetArray("vtkGhostType")
    ghosts = sum(int(marks.GetValue(i)) & 1 for i in range(marks.GetNumberOfTuples())) if marks else 0
    measured = simple.IntegrateVariables(Input=whole)
    measured.UpdatePipeline()
    volume = simple.servermanager.Fetch(measured).GetCellData().GetArray("Volume")
    arrays = whole.GetPointDataInformation()
    ranges = ", ".join(f"{arrays[i].Name} {arrays[i].GetRange()}" for i in range(len(arrays.keys())) if not arrays[i].Name.startswith("vtk"))
    print(f"{path}: {data.GetNumberOfCells()} cells, {ghosts} of them ghosts, volume {volume.GetValue(0) if volume else 'none'}, {ranges}", flush=True)
    view = simple.CreateView("RenderView")
    shown = simple.Show(whole, view)
    shown.Representation = "Surface"
    simple.ColorBy(shown, ("POINTS", arrays[0].Name))
    view.ResetCamera()
    simple.SaveScreenshot(path + ".png", view, ImageResolution=[640, 480])
