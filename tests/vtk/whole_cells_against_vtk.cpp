// Whole cells of files as VTK's threshold takes them.
#include <gtest/gtest.h>
#include <vtkCellData.h>
#include <vtkDataObject.h>
#include <vtkDataSet.h>
#include <vtkNew.h>
#include <vtkThreshold.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLGenericDataObjectReader.h>

#include "extraction/layers/extract_layers.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace isostrata {
namespace {

using Ends = std::vector<std::pair<double, double>>;

/// How many cells each interval has, ours and VTK's. False if cells were split or left out when they were read, so that they cannot be compared.
bool expect_as_threshold(const std::string& path, const std::string& array, const Ends& intervals) {
  SCOPED_TRACE(path + " " + array);
  vtkNew<vtkXMLGenericDataObjectReader> reader;
  reader->SetFileName(path.c_str());
  reader->Update();
  auto* const written = vtkDataSet::SafeDownCast(reader->GetOutput());
  const auto data = open_dataset(path, {}, Task());
  if (!written || written->GetNumberOfCells() != data->grid.cell_count()) return false;
  for (const auto& [lower, upper] : intervals) {
    vtkNew<vtkThreshold> threshold;
    threshold->SetInputData(written);
    threshold->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_CELLS, array.c_str());
    threshold->SetThresholdFunction(vtkThreshold::THRESHOLD_BETWEEN);
    threshold->SetLowerThreshold(lower);
    threshold->SetUpperThreshold(upper);
    threshold->Update();
    LayerRequest request;
    request.array = array;
    request.values = FieldValues::whole;
    request.intervals = {{lower, upper}};
    const Layers layers = extract_layers(request, [&](int, const Task&) { return data; }, Task());
    EXPECT_EQ(layers.mesh.summaries[0].active_cells, threshold->GetOutput()->GetNumberOfCells()) << lower << ":" << upper;
  }
  return true;
}

TEST(WholeCellsAgainstVtk, AreTheCellsOfItsThreshold) {
  const testing::TemporaryFolder folder;
  int compared = 0;
  for (const testing::SampleFile& sample : testing::write_sample_files(folder)) {
    const std::string ending = sample.path.extension().string();  // of lists VTK reads all parts
    if (sample.path.filename() == "blanked.vti") continue;        // VTK blanks cells in a way of its own
    if (ending == ".vtu" || ending == ".vti" || ending == ".vtr" || ending == ".vts")
      compared += expect_as_threshold(sample.path.string(), "cell", {{-0.5, 2.5}, {3.0, 7.0}, {3.2, 3.8}, {0.0, 10.0}});
  }
  EXPECT_GE(compared, 6);
}

TEST(SharedDataWholeCellsAgainstVtk, AreTheCellsOfItsThreshold) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  EXPECT_TRUE(expect_as_threshold((testing::shared_data() / "exo_can/can.vtu").string(), "EQPS", {{0.0, 0.1}, {0.1, 1.0}, {1.0, 10.0}}));
}

}  // namespace
}  // namespace isostrata
