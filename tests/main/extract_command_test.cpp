#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/run_json.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace {

using namespace isostrata::testing;
using ::testing::HasSubstr;
namespace json = boost::json;

TEST(ExtractCommand, PrintsWhatItExtracted) {
  const json::value document = extract_json("torus:24 --array distance --interval 0.1:0.2 --interval 0.2:0.4 --threads 1");
  ASSERT_TRUE(document.is_object());
  EXPECT_EQ(number(document.at("cells")), 23 * 23 * 23);
  EXPECT_EQ(number(document.at("unmatched_facets")), 0);
  EXPECT_EQ(number(document.at("threads")), 1);
  EXPECT_GT(number(document.at("points")), 0);
  EXPECT_GT(number(document.at("boundary_facets").at("lower")), 0);
  EXPECT_GT(number(document.at("boundary_facets").at("upper")), 0);
  EXPECT_EQ(number(document.at("boundary_facets").at("domain")), 0);
  for (const char* stage : {"load", "index", "extract", "total"}) EXPECT_GE(number(document.at("ms").at(stage)), 0) << stage;
  const auto& intervals = document.at("intervals").as_array();
  ASSERT_EQ(intervals.size(), 2u);
  double tetrahedra = 0;
  for (const auto& interval : intervals) {
    tetrahedra += number(interval.at("tetrahedra"));
    EXPECT_GT(number(interval.at("active_cells")), 0);
    EXPECT_NEAR(number(interval.at("volume")), number(interval.at("signed_volume")), 1e-3);
  }
  EXPECT_EQ(tetrahedra, number(document.at("tetrahedra")));
  EXPECT_EQ(number(intervals[1].at("lower")), 0.2);
}

TEST(ExtractCommand, TakesTheFirstArrayAndNegativeEnds) {
  const json::value document = extract_json("tets:6 --interval -1:3");
  ASSERT_TRUE(document.is_object());
  EXPECT_NEAR(signed_volume(document), 8, 1e-12);
}

// Everything above and everything below a value: what an end beyond all values gives, and together all that there is.
TEST(ExtractCommand, IntervalsWithOpenEndsHoldEverythingAboveOrBelow) {
  const auto extract = [](const std::string& what) {
    const CommandResult result = run_isostrata("extract " + what + " --json");
    EXPECT_EQ(result.status, 0) << what << ": " << result.err;
    return result.status == 0 ? boost::json::parse(result.out) : boost::json::value();
  };
  for (const std::string data : {"torus:16", "tets:7", "mixed:7", "cylinder:16x12x8 --array Momentum"}) {
    const auto volume = [&](const std::string& interval) {
      const auto document = extract(data + " --verify --interval " + interval);
      EXPECT_EQ(document.at("unmatched_facets").to_number<int>(), 0) << data << " " << interval;
      return document.at("intervals").at(0).at("signed_volume").to_number<double>();
    };
    const double above = volume("0.31:inf"), below = volume("-inf:0.31"), all = volume("-inf:inf");
    EXPECT_EQ(above, volume("0.31:1e6")) << data;
    EXPECT_EQ(below, volume("-1e6:0.31")) << data;
    EXPECT_GT(std::abs(above), 0) << data;
    EXPECT_NEAR(above + below, all, 1e-9 * std::abs(all)) << data;
  }
  const auto both = extract("torus:16 --interval -inf:0.2 --interval 0.2:inf --and distance=-inf:0.5");
  EXPECT_EQ(both.at("intervals").at(0).at("lower").as_string(), "-inf");
  EXPECT_EQ(both.at("intervals").at(1).at("upper").as_string(), "inf");
  const auto closed = extract("torus:16 --interval -9:0.2 --interval 0.2:9 --and distance=-9:0.5");
  for (const int i : {0, 1}) EXPECT_EQ(both.at("intervals").at(i).at("volume"), closed.at("intervals").at(i).at("volume"));
}

TEST(ExtractCommand, WritesFilesByTheirEnding) {
  const TemporaryFolder folder;
  const std::pair<const char*, const char*> formats[] = {{"a.vtu", "<?xml"}, {"a.vtkhdf", "\x89HDF"}, {"a.ply", "ply\n"}, {"a.stl", "interval boundary"}};
  for (const auto& [name, magic] : formats) {
    const CommandResult result =
        run_isostrata("extract cylinder:12x10x8 --interval 0.99:1 --color-by Energy --out '" + (folder / name).string() + "'");
    ASSERT_EQ(result.status, 0) << result.err;
    const std::string text = read_text(folder / name);
    EXPECT_TRUE(text.starts_with(magic)) << name;
    EXPECT_EQ(text.find("Name=\"Energy\"") != std::string::npos, std::string(name) == "a.vtu");
  }
}

TEST(ExtractCommand, TakesValuesWhole) {
  for (const std::string data : {"torus:16", "tets:7", "mixed:7"}) {
    const auto document = extract_json(data + " --values whole --verify --interval 0.31:0.6 --interval -inf:0.31 --interval 0.6:inf --interval 2:2.5");
    ASSERT_TRUE(document.is_object()) << data;
    EXPECT_EQ(number(document.at("unmatched_facets")), 0) << data;
    const auto whole = extract_json(data + " --interval -inf:inf");
    double parts = 0;
    for (const int i : {0, 1, 2}) parts += number(document.at("intervals").at(static_cast<std::size_t>(i)).at("signed_volume"));
    EXPECT_NEAR(parts, signed_volume(whole), 1e-9 * std::abs(parts)) << data;
  }
}

TEST(ExtractCommand, RefusesWithOneClearLine) {
  struct Refusal {
    const char* arguments;
    int status;
    const char* says;
  };
  const Refusal refusals[] = {
      {"torus:8 --interval 2:1", 1, "lower must be less than upper"},
      {"torus:8 --interval 0:1 --values whole --and distance=0:1", 1, "not combined with ranges of other arrays"},
      {"torus:8 --interval 0:1 --values whole --triangulation strict", 1, "expected the triangulation table"},
      {"torus:8 --interval 1:1", 1, "lower must be less than upper"},
      {"torus:8 --interval nan:1", 1, "lower must be less than upper"},
      {"torus:8 --interval inf:inf", 1, "lower must be less than upper"},
      {"torus:8 --interval half:1", 1, "'half' is not a number"},
      {"torus:8 --interval 0:1 --array missing", 1, "no array 'missing'; it has distance"},
      {"torus:8 --interval 0:1 --color-by missing", 1, "no array 'missing'; it has distance"},
      {"torus:8 --interval 0:1 --out mesh.obj", 1, "expected .vtu, .vtkhdf, .ply or .stl"},
      {"torus:8 --interval 0:1 --out /no/such/folder/mesh.vtu", 1, "cannot create"},
      {"torus:8 --interval 0:1 --step 3", 1, "step"},
      {"torus:32 --interval 0:1 --max-memory 1MB", 1, "the limit is 1048576"},
      {"no-such-file.vtk --interval 0:1", 1, "no-such-file.vtk"},
      {"torus:8", 2, "--interval is required"},
      {"torus:8 --interval 0:1 --threads -1", 2, "--threads"},
  };
  for (const Refusal& refusal : refusals) {
    const CommandResult result = run_isostrata(std::string("extract ") + refusal.arguments);
    EXPECT_EQ(result.status, refusal.status) << refusal.arguments << ": " << result.err;
    EXPECT_THAT(result.err, HasSubstr(refusal.says)) << refusal.arguments;
    EXPECT_EQ(result.out, "") << refusal.arguments;
  }
}

TEST(ExtractCommand, VerifiesAndReportsThePartition) {
  for (const char* more : {"", " --triangulation strict", " --and distance=0.15:0.3"}) {
    const CommandResult result =
        run_isostrata("extract torus:24 --interval 0.1:0.2 --interval 0.3:0.4 --verify" + std::string(more));
    EXPECT_EQ(result.status, 0) << more << result.err;
    EXPECT_THAT(result.err, HasSubstr("all laws hold"));
  }
  const json::value document = extract_json("marschner-lobb:40 --interval 0.3:0.5 --triangulation strict --verify");
  EXPECT_GE(number(document.at("partition_error")), 0);
  EXPECT_LE(number(document.at("partition_error")), 1e-12);
  EXPECT_GT(number(document.at("ms").at("proof")), 0);
  EXPECT_EQ(number(document.at("intervals").at(0).at("inverted")), 0);
  EXPECT_EQ(number(document.at("strict").at("tangled_cells")), 0);
}

TEST(ExtractCommand, VerifyEstimatesWhatStraightCutsMiss) {
  const json::value hexahedra = extract_json("marschner-lobb:24 --interval 0.4:0.5 --verify");
  const auto& layer = hexahedra.at("intervals").at(0);
  EXPECT_GT(number(layer.at("volume_error")), 0);
  EXPECT_LT(number(layer.at("volume_error")), 0.2 * number(layer.at("volume")));
  const json::value tetrahedra = extract_json("tets:8 --interval 0.1:0.2 --verify");
  EXPECT_EQ(number(tetrahedra.at("intervals").at(0).at("volume_error")), 0);
  EXPECT_FALSE(extract_json("tets:8 --interval 0.1:0.2").at("intervals").at(0).as_object().contains("volume_error"));
  const CommandResult text = run_isostrata("extract marschner-lobb:24 --interval 0.4:0.5 --verify");
  EXPECT_THAT(text.out, HasSubstr("estimated"));
}

TEST(ExtractCommand, ProvesNothingUnasked) {
  const json::value document = extract_json("torus:24 --interval 0.1:0.2");
  EXPECT_FALSE(document.as_object().contains("partition_error"));
  EXPECT_EQ(number(document.at("ms").at("proof")), 0);
}

TEST(ExtractCommand, VolumeIsTheSolids) {
  // Tables turn some tetrahedra of coarse hexahedra over: their absolute volumes add up to more than there is.
  const json::value document =
      extract_json("marschner-lobb:12 --interval -9:0.3 --interval 0.3:0.5 --interval 0.5:0.7 --interval 0.7:9");
  double volume = 0, absolute = 0, inverted = 0;
  for (const auto& interval : document.at("intervals").as_array()) {
    EXPECT_EQ(number(interval.at("volume")), number(interval.at("signed_volume")));
    volume += number(interval.at("volume"));
    absolute += number(interval.at("absolute_volume"));
    inverted += number(interval.at("inverted"));
  }
  EXPECT_GT(inverted, 0);
  EXPECT_NEAR(volume, 8, 1e-9);
  EXPECT_GT(absolute, 8 + 1e-6);
}

TEST(ExtractCommand, VolumeIsPositiveInLeftHandedCells) {
  const TemporaryFolder folder;
  const auto grid = [&](const std::string& name, double sign) {
    std::ofstream out(folder / name);
    out << "# vtk DataFile Version 3.0\nhand\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 3 3 3\nPOINTS 27 double\n";
    for (int p = 0; p < 27; ++p) out << sign * (p % 3) << ' ' << p / 3 % 3 << ' ' << p / 9 << '\n';
    out << "POINT_DATA 27\nSCALARS f double 1\nLOOKUP_TABLE default\n";
    for (int p = 0; p < 27; ++p) out << (p * 7) % 11 << '\n';
    return "'" + (folder / name).string() + "'";
  };
  const json::value right = extract_json(grid("right.vtk", 1) + " --interval 2:5"), left = extract_json(grid("left.vtk", -1) + " --interval 2:5");
  EXPECT_GT(signed_volume(right), 0);
  EXPECT_NEAR(number(left.at("intervals").at(0).at("volume")), number(right.at("intervals").at(0).at("volume")), 1e-12);
}

TEST(ExtractCommand, VerifyFailsWhereCellsFoldOver) {
  // Two hexahedra on the same side of the face that they share.
  const TemporaryFolder folder;
  const std::string path = (folder / "folded.vtk").string();
  std::ofstream(path) << "# vtk DataFile Version 3.0\nfolded\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 double\n"
                         "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1  0.5 0 0  0.5 1 0  0.5 1 1  0.5 0 1\n"
                         "CELLS 2 18\n8 0 1 2 3 4 5 6 7\n8 0 8 9 3 4 11 10 7\nCELL_TYPES 2\n12\n12\n"
                         "POINT_DATA 12\nSCALARS f double 1\nLOOKUP_TABLE default\n0 1 1 0 0 1 1 0 0.5 0.5 0.5 0.5\n";
  const CommandResult result = run_isostrata("extract '" + path + "' --interval -1:0.4 --verify");
  EXPECT_EQ(result.status, 1);
  EXPECT_THAT(result.err, HasSubstr("broken law 'partition'"));
  EXPECT_THAT(result.err, HasSubstr("expected at most 1e-09"));
}

TEST(ExtractCommand, WritesTheChosenFacets) {
  const TemporaryFolder folder;
  const auto size = [&](const std::string& options) {
    const std::string path = (folder / "b.stl").string();
    const CommandResult result =
        run_isostrata("extract torus:24 --interval 0.1:0.2 --interval 0.2:0.4 --out '" + path + "' " + options);
    EXPECT_EQ(result.status, 0) << result.err;
    return std::filesystem::file_size(path);
  };
  EXPECT_EQ(size("") + 3 * 84 - 84, size("--facets lower") + size("--facets upper") + size("--facets domain"));
  EXPECT_EQ(size("--facets lower"), size("--facets lower@0,lower@1"));
  EXPECT_LT(size("--facets lower@1"), size("--facets lower"));
  for (const char* wrong : {"middle", "lower@2", "lower@x", "lower@"}) {
    const CommandResult result =
        run_isostrata("extract torus:8 --interval 0.1:0.2 --interval 0.2:0.4 --facets " + std::string(wrong));
    EXPECT_EQ(result.status, 1);
    EXPECT_THAT(result.err, HasSubstr("facets '" + std::string(wrong) + "'"));
  }
}

TEST(ExtractCommand, BenchReportsTheFloorBesideTheTimes) {
  const CommandResult result = run_isostrata("bench extract --data torus:24 --data mixed:8 --repeat 3 --json");
  ASSERT_EQ(result.status, 0) << result.err;
  const json::value document = json::parse(result.out);
  const auto& runs = document.at("runs").as_array();
  ASSERT_EQ(runs.size(), 2u);
  for (const auto& run : runs) {
    EXPECT_GT(number(run.at("tetrahedra")), 0);
    EXPECT_GT(number(run.at("read_floor_ms")), 0);
    EXPECT_LE(number(run.at("ms").at("min")), number(run.at("ms").at("median")));
    EXPECT_LE(number(run.at("ms").at("median")), number(run.at("ms").at("max")));
    EXPECT_GE(number(run.at("mesh_bytes")), 18 * number(run.at("tetrahedra")));
  }
  const json::value& drag = runs[0].at("drag");
  EXPECT_GT(number(drag.at("records_bytes")), 4 * number(runs[0].at("active_cells")));
  EXPECT_LE(number(drag.at("bricks_taken_over")), number(drag.at("bricks")));
  EXPECT_GT(number(drag.at("moved_mesh_ms")), 0);
  EXPECT_TRUE(runs[1].at("drag").is_null()) << "bricks are of structured grids";
  EXPECT_GT(document.at("cpu").as_string().size(), 0u);
}

TEST(ExtractCommand, FilesOfEveryKindConformAndTile) {
  const TemporaryFolder folder;
  const auto files = write_sample_files(folder);
  struct Example {
    const char* file;
    const char* array;
    const char* split;
  };
  const Example examples[] = {
      {"mixed.vtu", "distance", "0.4"},        // hexahedra, wedges and pyramids, and lines and vertices among them
      {"both_handed.vtu", "slope", "0.8"},     // hexahedra of either handedness
      {"slivers.vtu", "distance", "0.5"},      // flat tetrahedra
      {"uniform.vti", "ties", "85"},           // 8-bit values that equal the isovalue
      {"flow.xyz", "Density", "1.1"},          // PLOT3D, two blocks, a blanked cell
      {"quadratic_tetrahedra.vtu", "cell", "5"},
  };
  for (const Example& example : examples) {
    const std::string name = "'" + (folder / example.file).string() + "' --array " + example.array;
    const std::string at = example.split;
    const json::value split = extract_json(name + " --interval -1e6:" + at + " --interval " + at + ":1e6");
    ASSERT_TRUE(split.is_object());
    EXPECT_EQ(number(split.at("unmatched_facets")), 0) << example.file;
    for (const json::value& interval : split.at("intervals").as_array())
      EXPECT_GT(number(interval.at("tetrahedra")), 0) << example.file;
    const auto file =
        std::find_if(files.begin(), files.end(), [&](const SampleFile& f) { return f.path.filename() == example.file; });
    ASSERT_NE(file, files.end()) << example.file;
    EXPECT_NEAR(signed_volume(split), file->volume, 1e-9 * file->volume) << example.file;
  }
}

/// A partition of the array's range, by the printed range of `info`.
TEST(SharedDataExtract, BluntfinHasThePapersKindOfLayer) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto grid = shared_data() / "plot3d_bluntfin" / "bluntfinxyz.bin";
  const json::value layer = extract_json("'" + grid.string() + "' --array Density --interval 1.0:1.309");
  ASSERT_TRUE(layer.is_object());
  EXPECT_EQ(number(layer.at("cells")), 37479);
  EXPECT_EQ(number(layer.at("active_cells")), 9479);
  EXPECT_EQ(number(layer.at("unmatched_facets")), 0);

  const json::value halves = extract_json("'" + grid.string() + "' --array Density --interval 0:1 --interval 1:6");
  const json::value parts =
      extract_json("'" + grid.string() + "' --array Density --interval 0:0.7 --interval 0.7:1.1 --interval 1.1:2 --interval 2:6");
  ASSERT_TRUE(halves.is_object() && parts.is_object());
  EXPECT_NEAR(signed_volume(halves), signed_volume(parts), 1e-9 * signed_volume(parts))
      << "every partition has the grid's volume";
  EXPECT_EQ(number(parts.at("unmatched_facets")), 0);
}

TEST(SharedDataExtract, RealMeshesOfAllCellTypesConformAndTile) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  // Where cell faces are curved two triangulations of a face differ by its own ambiguity: a looser bound, and why.
  struct Example {
    const char* file;
    const char* split;  // an isovalue inside the first array's range; the ends go far beyond it
    double tolerance;
  };
  const Example examples[] = {
      {"ug_aneurysm_fem/output_fem.vtu", "0.01", 1e-9},  // tetrahedra and wedges of mixed handedness
      {"ug_fire/fire_ug.vtu", "400", 1e-9},              // left-handed hexahedra
      {"ug_post_tets/post.vtk", "1", 1e-9},              // tetrahedra
      {"vtk_ironprot/ironProt.vtk", "128", 1e-9},        // 8-bit values that equal the isovalue
      {"plot3d_comb/combxyz.bin", "0.4", 1e-5},          // curved faces
  };
  for (const Example& example : examples) {
    const auto file = shared_data() / example.file;
    const std::string name = "'" + file.string() + "'";
    const json::value whole = extract_json(name + " --interval -1e6:1e6");
    const json::value split = extract_json(name + " --interval -1e6:" + example.split + " --interval " + example.split + ":1e6");
    ASSERT_TRUE(whole.is_object() && split.is_object());
    EXPECT_EQ(number(split.at("unmatched_facets")), 0) << example.file;
    EXPECT_GT(number(split.at("intervals").as_array()[0].at("tetrahedra")), 0) << example.file;
    EXPECT_GT(number(split.at("intervals").as_array()[1].at("tetrahedra")), 0) << example.file;
    EXPECT_NEAR(signed_volume(split), signed_volume(whole), example.tolerance * signed_volume(whole)) << example.file;
  }
}

TEST(ExtractCommand, TermsApplyInTheOrderOfTheCommandLine) {
  const auto volume = [](const std::string& terms) {
    return signed_volume(extract_json("tets:16 --array distance --interval 0.2:0.6 " + terms));
  };
  const auto plain = [](const std::string& interval) {
    return signed_volume(extract_json("tets:16 --array distance --interval " + interval));
  };
  EXPECT_NEAR(volume("--or distance=0.7:0.8 --and distance=0.7:0.75"), plain("0.7:0.75"), 1e-12);
  EXPECT_NEAR(volume("--and distance=0.7:0.75 --or distance=0.7:0.8"), plain("0.7:0.8"), 1e-12);
  EXPECT_NEAR(volume("--minus distance=0.1:0.9 --or distance=0.7:0.8 --minus distance=0.7:0.75"), plain("0.75:0.8"), 1e-12);
  EXPECT_NEAR(volume("--minus distance=0.1:0.9 --minus distance=0.7:0.75 --or distance=0.7:0.8"), plain("0.7:0.8"), 1e-12);
  EXPECT_NEAR(volume("--xor distance=0.5:0.8 --and distance=0.55:0.7 --or distance=0.3:0.4 --xor distance=0.65:0.7"),
              plain("0.3:0.4") + plain("0.6:0.65"), 1e-12);
}

TEST(ExtractCommand, LabelsWhatATermAdds) {
  const json::value document = extract_json("torus:24 --interval 0.2:0.3 --or distance=0.4:0.5 --minus distance=0.45:0.6");
  EXPECT_EQ(number(document.at("unmatched_facets")), 0);
  const auto& intervals = document.at("intervals").as_array();
  ASSERT_EQ(intervals.size(), 2u);
  EXPECT_FALSE(intervals[0].as_object().contains("term"));
  EXPECT_EQ(number(intervals[1].at("term")), 0);
  EXPECT_EQ(number(intervals[1].at("lower")), 0.4);
  EXPECT_GT(number(intervals[1].at("volume")), 0);
}

TEST(ExtractCommand, RefusesTermsThatAreNone) {
  const auto refused = [](const std::string& arguments) {
    const CommandResult result = run_isostrata("extract tets:6 --interval 0.2:0.6 " + arguments);
    EXPECT_NE(result.status, 0) << arguments;
    return result.err;
  };
  EXPECT_THAT(refused("--and nothing=1:2"), HasSubstr("no array 'nothing'; it has distance"));
  EXPECT_THAT(refused("--and distance"), HasSubstr("expected NAME=LOWER:UPPER"));
  EXPECT_THAT(refused("--or distance=2:1"), HasSubstr("lower"));
}

}  // namespace
