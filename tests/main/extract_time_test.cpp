// isostrata extract --time and --time-mode, on built-in and on real series.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "support/run_json.h"
#include "support/sample_files.h"
#include "support/shared_data.h"
#include "support/vtk_text.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
namespace json = boost::json;

double volume(const json::value& document) { return number(document.at("intervals").at(0).at("signed_volume")); }

TEST(ExtractAtTime, SaysWhichStepsAndWhichModeWereUsed) {
  const std::string cylinder = "cylinder:20x14x8x5 --interval 0.99:1";  // at the times 0, 0.25294..., ...
  const json::value first = extract_json(cylinder);
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first.at("time").at("steps"), (json::array{0}));
  EXPECT_EQ(first.at("time").at("mode"), "step");
  EXPECT_FALSE(first.at("ms").as_object().contains("slice"));

  const json::value nearest = extract_json(cylinder + " --time 0.3");
  EXPECT_EQ(nearest.at("time").at("steps"), (json::array{1}));
  EXPECT_EQ(number(nearest.at("time").at("value")), 0.3);
  EXPECT_EQ(volume(nearest), volume(extract_json(cylinder + " --step 1")));

  const json::value between = extract_json(cylinder + " --time 0.3 --time-mode interpolate");
  EXPECT_EQ(between.at("time").at("steps"), (json::array{1, 2}));
  EXPECT_EQ(between.at("time").at("mode"), "interpolate");
  EXPECT_GT(number(between.at("time").at("weight")), 0.1);
  EXPECT_LT(number(between.at("time").at("weight")), 0.3);

  const json::value sliced = extract_json(cylinder + " --time 0.3 --time-mode spacetime --color-by Energy");
  EXPECT_EQ(sliced.at("time").at("steps"), (json::array{1, 2}));
  EXPECT_EQ(sliced.at("time").at("mode"), "spacetime");
  EXPECT_EQ(number(sliced.at("unmatched_facets")), 0);
  EXPECT_GT(number(sliced.at("ms").at("build")), 0);
  EXPECT_GT(number(sliced.at("ms").at("slice")), 0);
  EXPECT_GT(number(sliced.at("time").at("simplices")), 0);
  EXPECT_NEAR(volume(sliced), volume(between), 0.05 * volume(between)) << "the same field on different cells";
}

TEST(ExtractAtTime, TilesTheDomainInEveryMode) {
  for (const char* mode : {"step", "interpolate", "spacetime"}) {
    const json::value whole = extract_json("cylinder:16x10x6x3 --interval -9:9 --time 0.1 --time-mode " + std::string(mode));
    const json::value parts = extract_json(
        "cylinder:16x10x6x3 --interval -9:0.99 --interval 0.99:1.0 --interval 1.0:9 --time 0.1 "
        "--time-mode " +
        std::string(mode));
    ASSERT_TRUE(whole.is_object() && parts.is_object());
    double sum = 0;
    for (const auto& row : parts.at("intervals").as_array()) sum += number(row.at("signed_volume"));
    EXPECT_NEAR(sum, volume(whole), (mode == std::string("spacetime") ? 1e-11 : 1e-5) * volume(whole)) << mode;
    EXPECT_EQ(number(parts.at("unmatched_facets")), 0) << mode;
  }
}

TEST(ExtractAtTime, KeepsEveryLawWhileTheMeshMoves) {
  // A block of hexahedra whose points each go their own way, in single precision, as crash simulations write them.
  const TemporaryFolder folder;
  constexpr int kPoints = 6;
  std::mt19937 random(51);
  std::uniform_real_distribution<float> way(-0.15f, 0.15f), value(0, 1);
  const auto write = [&](const std::string& name, float stretch) {
    std::vector<float> points, f;
    for (int p = 0; p < kPoints * kPoints * kPoints; ++p) {
      const float x[3] = {float(p % kPoints), float(p / kPoints % kPoints), float(p / (kPoints * kPoints))};
      for (int axis = 0; axis < 3; ++axis) points.push_back(100 + stretch * x[axis] + way(random));
      f.push_back(value(random));
    }
    const auto size = std::to_string(kPoints - 1);
    const std::string extent = "0 " + size + " 0 " + size + " 0 " + size;
    folder.write(name, vtk_file("StructuredGrid", "<StructuredGrid WholeExtent=\"" + extent + "\"><Piece Extent=\"" + extent +
                                                      "\"><PointData>" + data_array("f", "Float32", f) + "</PointData><Points>" +
                                                      data_array("p", "Float32", points, 3) +
                                                      "</Points></Piece></StructuredGrid>\n"));
  };
  write("a.vts", 1);
  write("b.vts", 1.4f);
  const auto series =
      folder.write("moving.pvd", vtk_file("Collection", "<Collection><DataSet timestep=\"0\" file=\"a.vts\"/>"
                                                        "<DataSet timestep=\"1\" file=\"b.vts\"/></Collection>"));
  for (const char* time : {"0", "0.3", "0.7", "1"}) {
    const json::value document = extract_json("'" + series.string() + "' --interval -1:0.4 --interval 0.4:0.6 --interval 0.6:2 " +
                                              "--time-mode spacetime --verify --time " + time);
    ASSERT_TRUE(document.is_object()) << time;
    for (const auto& row : document.at("intervals").as_array()) EXPECT_EQ(number(row.at("inverted")), 0) << time;
  }
}

TEST(ExtractAtTime, RefusesWithOneClearLine) {
  const std::pair<const char*, const char*> refusals[] = {
      {"torus:8 --interval 0:1 --time 3", "torus:8: time 3 is outside its times; expected 0, the time of its only step"},
      {"torus:8 --interval 0:1 --time nan", "time nan is outside"},
      {"cylinder:8x4x4x3 --interval 0:1 --time -1", "time -1 is outside its times; expected 0 to "},
      {"cylinder:8x4x4x3 --interval 0:1 --time 0.1 --time-mode spacetime --color-by nothing", "no array 'nothing'"},
      {"cylinder:8x4x4x3 --interval 0:1 --step 7 --time-mode spacetime", "no step 7"},
  };
  for (const auto& [arguments, says] : refusals) {
    const CommandResult result = run_isostrata(std::string("extract ") + arguments);
    EXPECT_EQ(result.status, 1) << arguments;
    EXPECT_THAT(result.err, HasSubstr(says)) << arguments;
    EXPECT_EQ(result.out, "") << arguments;
  }
  EXPECT_EQ(run_isostrata("extract cylinder:8x4x4x3 --interval 0:1 --time 0 --step 1").status, 2);
  EXPECT_EQ(run_isostrata("extract cylinder:8x4x4x3 --interval 0:1 --time-mode sometimes").status, 2);
  EXPECT_EQ(run_isostrata("extract torus:8 --interval 0:1 --time 0 --time-mode spacetime").status, 0) << "its only step";
}

struct SeriesExample {
  std::filesystem::path file;
  const char* layer;
  double from, to;  // times of two successive steps
};

void expect_smooth_passage(const SeriesExample& example) {
  const auto at = [&](double part, const char* mode) {
    return extract_json("'" + example.file.string() + "' " + example.layer + " --time " +
                        std::to_string(example.from + part * (example.to - example.from)) + " --time-mode " + mode);
  };
  const json::value begin = at(0.001, "spacetime"), middle = at(0.5, "spacetime"), end = at(0.999, "spacetime");
  ASSERT_TRUE(begin.is_object() && middle.is_object() && end.is_object());
  for (const json::value* document : {&begin, &middle, &end}) {
    EXPECT_EQ(number(document->at("unmatched_facets")), 0) << example.file;
    EXPECT_EQ(number(document->at("intervals").at(0).at("inverted")), 0) << example.file;
  }
  // The steps' own cells are hexahedra, a slice's are split: near, not equal.
  EXPECT_NEAR(volume(begin), volume(at(0, "step")), 0.03 * volume(begin)) << example.file;
  EXPECT_NEAR(volume(end), volume(at(1, "step")), 0.03 * volume(end)) << example.file;
  EXPECT_NEAR(volume(middle), volume(at(0.5, "interpolate")), 0.03 * volume(middle)) << example.file;
}

TEST(ExtractAtTime, SeriesOfFilesConformAndPassSmoothlyFromStepToStep) {
  const TemporaryFolder folder;
  const std::array<int, 3> dims{17, 15, 16};
  std::vector<std::pair<double, std::string>> images, meshes;
  for (int step = 0; step < 3; ++step) {
    const SampleGridArrays arrays = sample_grid_arrays(dims, 0.05 * step);
    images.emplace_back(0.5 + step, "image_" + std::to_string(step) + ".vti");
    folder.write(images.back().second, vti_text({0, 0, 0}, dims, arrays.points));
    VtuText mesh;
    const CubeLattice lattice(mesh, 10, 0.1);
    for (const auto& cube : lattice.cubes()) mesh.add(12, {cube.begin(), cube.end()});
    add_sample_arrays(mesh, 0.05 * step);
    meshes.emplace_back(0.25 * step, "mesh_" + std::to_string(step) + ".vtu");
    folder.write(meshes.back().second, mesh.text());
  }
  expect_smooth_passage({folder.write("image.pvd", pvd_text(images)), "--array distance --interval 0.3:0.5", 0.5, 1.5});
  expect_smooth_passage({folder.write("mesh.pvd", pvd_text(meshes)), "--array distance --interval 0.3:0.5", 0.25, 0.5});
}

TEST(SharedDataExtractAtTime, RealSeriesConformAndPassSmoothlyFromStepToStep) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  expect_smooth_passage({shared_data() / "ts_tornado/tornado.pvd", "--array speed --interval 0.2:0.25", 1, 2});
  expect_smooth_passage({shared_data() / "exo_mug_transient/mug.pvd", "--array convected --interval 0.3:0.6", 0.5, 0.6});
  expect_smooth_passage({shared_data() / "exo_mug_transient/mug.e", "--array diffused --interval 0.3:0.6", 0.5, 0.6});
}

}  // namespace
