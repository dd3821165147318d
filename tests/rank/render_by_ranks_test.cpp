// The picture of N ranks is the picture of one process. Small pictures of small grids; deploy/prove-ranks does the same on larger ones.
#include <gtest/gtest.h>

#include "rank/by_ranks.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace isostrata::testing {
namespace {

constexpr double kFloat = 1e-5, kSteps = 1e-4;

void expect_same(const TemporaryFolder& folder, const std::string& arguments, std::initializer_list<int> ranks, double silhouettes = 0) {
  const Samples one = render_exr(folder, arguments, 0);
  for (const int n : ranks) {
    const Distance off = distance_of(one, render_exr(folder, arguments, n));
    EXPECT_GT(off.brightest, 0.05) << arguments;
    EXPECT_LE(off.above, silhouettes) << n << " ranks: " << arguments << ", worst " << off.worst;
    if (silhouettes == 0) {
      EXPECT_LE(off.worst, kFloat) << n << " ranks: " << arguments;
    }
    EXPECT_LE(off.steps, kSteps) << n << " ranks: " << arguments;
    EXPECT_LE(off.worst_depth, 1e-4) << n << " ranks: " << arguments;
    EXPECT_EQ(off.one_sided, 0u) << n << " ranks: " << arguments;
  }
}

const std::string kTorus = "torus:24 --size 160x120 ";

TEST(RenderByRanks, VolumesLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, kTorus + "--interval 0:0.3,color=#ff3020,opacity=0.4", {2, 4});
  expect_same(folder, kTorus + "--interval 0:0.1,color=map:viridis,opacity=0.7 --interval 0.1:0.4,color=map:#ff0000-#0000ff,opacity=0.2..0.6", {4});
}

// From 4 million tetrahedra on nothing is made of them: each rank draws from the bricks of its part, as one process does from those of the whole.
TEST(RenderByRanks, LargeLayersThatAreDrawnFromBricksLookAsByOneProcess) {
  const TemporaryFolder folder;
  const std::string data = "torus:112 --size 160x120 ";
  expect_same(folder, data + "--interval 0:0.6,opacity=0.1 --interval 0.6:20,opacity=0.05", {3});
  expect_same(folder, data + "--interval 0.05:20,opacity=0.05,surface=lower,surface-opacity=0.5", {2});
}

TEST(RenderByRanks, ACutOutRegionAndAStrideLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, "torus:32 --region 3:30,:,5: --stride 1,2,1 --size 120x90 --interval 0:0.3,opacity=0.4", {3});
}

TEST(RenderByRanks, SurfacesWithTexturesAndSilhouettesLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, kTorus + "--interval 0.05:0.3,color=#30a0ff,opacity=0.3,surface=all,surface-opacity=0.6,silhouette=0.8,texture=stripes,repeat=8", {2, 4}, 1e-4);
}

// The light is of the whole picture's depth, so that no region's edge shows. It adds up many depths that are rounded otherwise.
TEST(RenderByRanks, LightByDepthLooksAsByOneProcess) {
  const TemporaryFolder folder;
  const std::string light = " --occlusion 1 --depth-fade 0.6";
  expect_same(folder, kTorus + "--interval 0:0.3,color=#ff3020,opacity=0.4" + light, {2, 4});
  expect_same(folder, kTorus + "--interval 0:0.1,color=map:viridis,opacity=0.7 --interval 0.1:0.4,color=#0000ff,opacity=0.3" + light, {3}, 1e-3);
  expect_same(folder, kTorus + "--mode prioritized --interval 0:0.1,priority=2,opacity=0.5 --interval 0.1:0.4,priority=1,opacity=0.5" + light, {4});
}

// Of constant colours: a region's plane cuts segments, and where colours run the shade of a segment is not that of its parts.
TEST(RenderByRanks, ShadedBodiesLookAsByOneProcess) {
  const TemporaryFolder folder;
  const std::string shading = " --body-shading 0.8";
  expect_same(folder, kTorus + "--interval 0:0.3,color=#ff3020,opacity=0.4" + shading, {2, 4});
  expect_same(folder, "tets:9 --size 120x90 --interval 0.2:0.6,opacity=0.4" + shading, {3});
}

TEST(RenderByRanks, PrioritiesCombinedRangesAndClipPlanesLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, kTorus + "--mode prioritized --interval 0:0.1,priority=2,opacity=0.5 --interval 0.1:0.4,priority=1,opacity=0.5", {4});
  const std::string flow = "cylinder --array Density --size 160x120 ";
  expect_same(folder, flow + "--interval 0.9:0.99,opacity=0.5 --interval 0.995:1.05,color=map:viridis,opacity=0.2..0.6 --clip 'normal=0.3,1,0.2;offset=0.1' --clip 'x<3'", {4});
}

TEST(RenderByRanks, ScaledAxesLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, kTorus + "--interval 0:0.3,opacity=0.4,surface=both --axis-scale 2,3,0.5 --clip 'x<0.3'", {2, 4});
  expect_same(folder, "tets:9 --size 120x90 --interval 0.2:0.6,opacity=0.4 --axis-scale 0.25,1,4", {3});
}

TEST(RenderByRanks, ParallelRaysAndAnEyeInsideLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same(folder, kTorus + "--interval 0:0.3,opacity=0.4 --camera '+x;projection=orthographic'", {4});
  expect_same(folder, kTorus + "--interval 0:0.6,opacity=0.3 --camera 'eye=0.1,0.05,0.02;at=1,0.3,0.2;up=0,0,1;fov=70'", {4});
}

TEST(RenderByRanks, EveryKindOfGridLooksAsByOneProcess) {
  const TemporaryFolder folder;
  for (const SampleFile& file : write_sample_files(folder)) {
    const std::string name = file.path.stem().string();
    if (name == "hexahedra" || name == "voxels" || name.starts_with("quadratic") || name.ends_with("prisms") || name == "left_handed" || name == "wedges") continue;  // as others here
    SCOPED_TRACE(name);
    expect_same(folder, quoted(file.path) + " " + middle_third(file.path) + ",opacity=0.5,color=#3080ff,surface=both,surface-opacity=0.4 --size 96x96", {3});
  }
}

// Where a colour map is straight enough over the values that are there (kStraight of rendering/segments/segment_optics.h: 1e-3), it is drawn as a
// straight line. A region has fewer values than the whole, so its line may be another one; in thick cells that is seen.
TEST(RenderByRanks, ColourMapsOnThickCellsDifferByLessThanWhatIsTakenForStraight) {
  const TemporaryFolder folder;
  const std::vector<SampleFile> files = write_sample_files(folder);
  for (const SampleFile& file : files) {
    if (file.path.filename() != "uniform.vti" && file.path.filename() != "mixed.vtu") continue;
    const std::string arguments = quoted(file.path) + " " + middle_third(file.path) + ",opacity=0.5,color=map:viridis --size 96x96";
    const Distance off = distance_of(render_exr(folder, arguments, 0), render_exr(folder, arguments, 3));
    EXPECT_GT(off.brightest, 0.05);
    EXPECT_LE(off.worst, 1e-3);
    EXPECT_LE(off.steps, 3e-4);
  }
}

// Where two intervals are at one place, their order within a cell is by the middle of what is drawn of it, so that a plane through cells may turn it.
// In grids of boxes no plane goes through a cell.
TEST(RenderByRanks, OverlappingIntervalsDifferInFewPixelsOfAGridOfBoxes) {
  const TemporaryFolder folder;
  const std::string arguments = kTorus + "--interval 0:0.1,color=map:viridis,opacity=0.7 --interval 0.05:0.4,color=map:#ff0000-#0000ff,opacity=0.2..0.6";
  const Distance off = distance_of(render_exr(folder, arguments, 0), render_exr(folder, arguments, 4));
  EXPECT_LE(off.above, 1e-3);  // 12 of 19,200 pixels; where regions part decides which
  EXPECT_LE(off.steps, 3e-4);
}

TEST(RenderByRanks, MoreRanksThanCellsAndRegionsWithoutACellDoNoHarm) {
  const TemporaryFolder folder;
  expect_same(folder, "torus:2 --size 64x64 --interval -10:10,opacity=0.5", {4});
}

TEST(RenderByRanks, AComparisonWouldSeeAWrongOrderAndMissingGhosts) {
  const TemporaryFolder folder;
  const std::string arguments = kTorus + "--interval 0:0.1,color=#ff0000,opacity=0.9,surface=both --interval 0.1:0.4,color=#0000ff,opacity=0.9,surface=both";
  const Samples one = render_exr(folder, arguments, 0);
  EXPECT_LE(distance_of(one, render_exr(folder, arguments, 4)).worst, kFloat);
  EXPECT_GT(distance_of(one, render_exr(folder, arguments, 4, "ISOSTRATA_RANKS_CONTROL=reversed")).worst, 0.01);
  EXPECT_GT(distance_of(one, render_exr(folder, arguments, 4, "ISOSTRATA_RANKS_CONTROL=no-ghosts")).worst, 0.01);
}

TEST(RenderByRanks, PicturesOfEightBitsHaveTheSameNumbers) {
  const TemporaryFolder folder;
  const std::string arguments = "render " + kTorus + "--interval 0:0.3,color=map:viridis --samples 2 --axes --legend --background '#203040' --out ";
  ASSERT_EQ(run_isostrata(arguments + quoted(folder / "one.png")).status, 0);
  const CommandResult four = run_isostrata(arguments + quoted(folder / "four.png") + " --ranks '" + launcher(4) + "'", launcher_environment());
  ASSERT_EQ(four.status, 0) << four.err;
  const auto bytes = [&](const char* name) {
    const auto in = OIIO::ImageInput::open((folder / name).string());
    std::vector<unsigned char> out(static_cast<std::size_t>(in->spec().width * in->spec().height * in->spec().nchannels));
    in->read_image(0, 0, 0, in->spec().nchannels, OIIO::TypeDesc::UINT8, out.data());
    return out;
  };
  const auto a = bytes("one.png"), b = bytes("four.png");
  ASSERT_EQ(a.size(), b.size());
  std::size_t off = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_LE(std::abs(a[i] - b[i]), 1);
    off += a[i] != b[i];
  }
  EXPECT_LE(static_cast<double>(off), 1e-4 * static_cast<double>(a.size()));
}

// Measured and computed data: curvilinear, non-convex, of shells, of tetrahedra.
TEST(SharedDataRenderByRanks, LayersLookAsByOneProcess) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const TemporaryFolder folder;
  for (const char* name : {"plot3d_bluntfin/bluntfinxyz.bin", "ug_fire/fire_ug.vtu", "exo_can/can.vtu", "ug_post_tets/post.vtk"}) {
    SCOPED_TRACE(name);
    ASSERT_TRUE(std::filesystem::exists(shared_data() / name));
    expect_same(folder, quoted(shared_data() / name) + " " + middle_third(shared_data() / name) + ",opacity=0.4,color=#30a0ff --size 240x240", {4}, 1e-4);
  }
}

}  // namespace
}  // namespace isostrata::testing
