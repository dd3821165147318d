// Whole values of files of every kind of grid and cell, as the importer gives them.
#include <gtest/gtest.h>

#include "extraction/laws/check_laws.h"
#include "extraction/layers/extract_layers.h"
#include "extraction/small_grids.h"
#include "support/sample_files.h"

namespace isostrata {
namespace {

TEST(WholeValues, OfCellsAndPointsOfEveryKindOfGridTileItAndConform) {
  const testing::TemporaryFolder folder;
  int labelled = 0;
  for (const testing::SampleFile& sample : testing::write_sample_files(folder)) {
    const auto data = open_dataset(sample.path.string(), {}, Task());
    for (const char* name : {"cell", "ties"}) {
      const auto array = std::find_if(data->arrays.begin(), data->arrays.end(), [&](const PointArray& a) { return a.name == name; });
      if (array == data->arrays.end()) continue;
      SCOPED_TRACE(sample.path.filename().string() + " " + name);
      ++labelled;
      LayerRequest request;
      request.array = name;
      request.values = FieldValues::whole;
      request.facets = true;
      request.intervals = {{-0.5, 2.5}, {2.5, 4.5}, {4.5, 300.5}, {2.2, 2.8}};
      const Layers layers = extract_layers(request, [&](int, const Task&) { return data; }, Task());
      const auto& sums = layers.mesh.summaries;
      EXPECT_NEAR(sums[0].signed_volume + sums[1].signed_volume + sums[2].signed_volume, sample.volume, 1e-12 * sample.volume);
      EXPECT_EQ(sums[3].tetrahedra, 0) << "no whole number is in 2.2:2.8";
      EXPECT_EQ(unmatched(layers.mesh), 0);
      LawOptions laws;
      laws.one_range = false;
      for (const BrokenLaw& law : check_laws(layers.dataset->grid, layers.mesh, laws, Task())) ADD_FAILURE() << law.law << ": " << law.first;
    }
  }
  EXPECT_GT(labelled, 15);
}

}  // namespace
}  // namespace isostrata
