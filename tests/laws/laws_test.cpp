// A fast part of what isostrata-laws checks over all of the shared data, and the reason why its last column is the one that
// counts.
#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "extraction/small_grids.h"
#include "laws/partition_law.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace isostrata {
namespace {

constexpr double kRounding = 1e-11;

void expect_laws(const Dataset& data, const PointArray& array, int parts) {
  const laws::Partition law = laws::partition_law(data, array, parts, 200'000);
  EXPECT_EQ(law.whole.unmatched, 0) << data.name << " " << array.name;
  EXPECT_EQ(law.cut.unmatched, 0) << data.name << " " << array.name;
  EXPECT_GT(law.active_cells, 0) << data.name << " " << array.name;
  EXPECT_LE(law.unexplained(), kRounding) << data.name << " " << array.name << ", partition error " << law.error();
}

TEST(Laws, HoldOnEveryKindOfGridAndCell) {
  const testing::TemporaryFolder folder;
  for (const testing::SampleFile& sample : testing::write_sample_files(folder))
    for (int step = 0; step < sample.steps; ++step) {
      OpenOptions options;
      options.step = step;
      const auto data = open_dataset(sample.path.string(), options, Task());
      const std::string where = sample.path.filename().string() + " step " + std::to_string(step);
      for (const PointArray& array : data->arrays) {
        SCOPED_TRACE(where + " " + array.name);
        const laws::Solid all = laws::measure_solid(*data, array, {{-1e6, 1e6}}, nullptr);
        EXPECT_NEAR(std::abs(all.signed_volume), sample.volume, 1e-12 * sample.volume) << "the volume of the cells";
        EXPECT_EQ(all.unmatched, 0);
        expect_laws(*data, array, 5);
      }
    }
}

struct Sample {
  const char* file;
  std::vector<const char*> arrays;
};

TEST(SharedDataLaws, HoldOnEveryKindOfGrid) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const std::vector<Sample> samples{
      {"exo_can/can.vtu", {"EQPS", "DISPL_y"}},                   // badly shaped hexahedra
      {"ug_fire/fire_ug.vtu", {"t"}},                             // left-handed hexahedra
      {"ug_patch_antenna/patch_antenna.vtu", {"ElectricField"}},  // slivers, left-handed
      {"ug_notch/notch_stress_fixed.vtk", {"Nodal Stress_0"}},    // hexahedra and wedges
      {"ug_notch/notch_disp.vtu", {"Nodal Displacement"}},        // quadratic cells
      {"vtk_cells/PentaHexa.vtk", {"scalar2"}},                   // prisms
      {"vtk_cells/AngularSector.vtk", {"PointId"}},               // hexahedra and pyramids
      {"plot3d_bluntfin/bluntfinxyz.bin", {"Density"}},           // curved faces
      {"plot3d_post/postxyz.bin", {"StagnationEnergy"}},          // an O-grid that closes on itself
      {"exo_disk_out_ref/disk_out_ref.ex2", {"Temp"}},
      {"vtk_ironprot/ironProt.vtk", {"scalars"}},  // bytes that equal the isovalues
  };
  for (const Sample& sample : samples) {
    const auto data = open_dataset((testing::shared_data() / sample.file).string(), {}, Task());
    for (const char* name : sample.arrays) expect_laws(*data, data->array(name), 5);
  }
}

TEST(Laws, HoldOnAnalyticData) {
  for (const char* name : {"torus:24", "marschner-lobb:24", "mixed:9", "tets:9", "cylinder:24x16x12"}) {
    const auto data = make_analytic(name, {}, Task());
    for (const PointArray& array : data->arrays) expect_laws(*data, array, 4);
  }
}

/// A row of bent hexahedra: nothing plane, inside or outside.
std::shared_ptr<Dataset> bent_row(double bend, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Vec3d> points;
  const auto moved = random_values(3 * 4 * 4 * 4, -bend, bend, random);
  for (int p = 0; p < 64; ++p) {
    const auto at = static_cast<std::size_t>(3 * p);
    points.push_back({p % 4 + moved[at], p / 4 % 4 + moved[at + 1], p / 16 + moved[at + 2]});
  }
  auto data = std::make_shared<Dataset>();
  data->grid = curvilinear_grid({4, 4, 4}, std::move(points));
  data->bounds = data->grid.bounds();
  data->arrays.push_back(point_array(random_values(64, 0, 1, random)));
  measure_range(data->arrays.back());
  return data;
}

TEST(Laws, BentFacesOfTheBoundaryAreSpannedInTwoWaysAndNothingElseIsLost) {
  double largest = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto plane = bent_row(0, seed), bent = bent_row(0.2, seed);
    const laws::Partition flat = laws::partition_law(*plane, plane->arrays[0], 5, 1000);
    EXPECT_LE(flat.error(), 1e-13) << "seed " << seed;
    const laws::Partition law = laws::partition_law(*bent, bent->arrays[0], 5, 1000);
    EXPECT_LE(law.unexplained(), 1e-13) << "seed " << seed;
    largest = std::max(largest, law.error());
  }
  EXPECT_GT(largest, 1e-4) << "bent boundaries do change the solid: without this the test shows nothing";
}

}  // namespace
}  // namespace isostrata
