// Ranks that each read one part of a dataset, and no other.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "rank/by_ranks.h"
#include "support/sample_files.h"
#include "support/shared_data.h"

namespace isostrata::testing {
namespace {

namespace fs = std::filesystem;

struct Parts {
  std::string list;               // its name
  std::string launcher;           // starts each rank in a folder of its own, in which it finds the list, the planes and just one piece
  std::vector<fs::path> folders;  // of the ranks
};

/// `isostrata partition DATA`, shared out as on nodes that each have one piece on a disk of their own.
Parts part(const TemporaryFolder& folder, const std::string& data, int parts) {
  static int number = 0;
  const fs::path all = folder / ("all" + std::to_string(++number));
  const CommandResult run = run_isostrata("partition " + data + " --parts " + std::to_string(parts) + " --json --out " + quoted(all));
  if (run.status != 0) throw std::runtime_error("partition " + data + ": " + run.err);
  const auto made = boost::json::parse(run.out);
  const fs::path list = std::string(made.at("list").as_string()), manifest = std::string(made.at("manifest").as_string());
  Parts out{list.filename().string(), {}, {}};
  for (int rank = 0; rank < parts; ++rank) {
    out.folders.push_back(fs::path(all.string() + "_" + std::to_string(rank)));
    fs::create_directory(out.folders.back());
    const fs::path piece = std::string(made.at("parts").at(static_cast<std::size_t>(rank)).at("file").as_string());
    fs::copy(list, out.folders.back() / list.filename());
    fs::copy(manifest, out.folders.back() / manifest.filename());
    fs::rename(all / piece, out.folders.back() / piece);
  }
  const fs::path script = folder.write("there" + std::to_string(number), "#!/bin/sh\ncd " + quoted(fs::path(all.string() + "_")) + "$OMPI_COMM_WORLD_RANK && exec \"$@\"\n");
  fs::permissions(script, fs::perms::owner_all);
  out.launcher = launcher(parts) + " \"" + script.string() + "\"";
  return out;
}

CommandResult run(const std::string& command, const Parts& parts) { return run_isostrata(command + " --ranks '" + parts.launcher + "'", launcher_environment()); }

void expect_same_picture(const TemporaryFolder& folder, const std::string& data, const std::string& layers, int ranks) {
  SCOPED_TRACE(data + " by " + std::to_string(ranks));
  const Parts parts = part(folder, data, ranks);
  const std::string arguments = layers + " --size 96x96 --background transparent";
  const Samples one = render_exr(folder, data + " " + layers + " --size 96x96", 0);
  const fs::path out = folder / "parts.exr";
  fs::remove(out);
  const CommandResult many = run("render " + parts.list + " " + arguments + " --out " + quoted(out), parts);
  ASSERT_EQ(many.status, 0) << many.err;
  const Distance off = distance_of(one, read_exr(out));
  EXPECT_GT(off.brightest, 0.05);
  EXPECT_LE(off.worst, 1e-5);
  EXPECT_LE(off.steps, 1e-4);
  EXPECT_LE(off.worst_depth, 1e-4);
  EXPECT_EQ(off.one_sided, 0u);
}

const std::string kLook = ",opacity=0.5,color=#3080ff,surface=both,surface-opacity=0.4";

TEST(PartitionByRanks, PicturesOfPartsLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same_picture(folder, "torus:24", "--interval 0:0.3" + kLook, 4);
  expect_same_picture(folder, "cylinder:24x9x7", "--array Density --interval 0.95:1.01" + kLook, 3);
  for (const SampleFile& file : write_sample_files(folder)) {
    const std::string name = file.path.stem().string();
    if (name != "mixed" && name != "rectilinear" && name != "blanked") continue;
    expect_same_picture(folder, quoted(file.path), middle_third(file.path) + kLook, 3);
  }
}

/// 64 MiB and more are mapped where they lie, in each piece.
TEST(PartitionByRanks, PiecesThatAreMappedLookAsByOneProcess) {
  const TemporaryFolder folder;
  expect_same_picture(folder, "torus:344", "--region :,:,: --interval 0.01:0.02,opacity=0.5,color=#ff8030", 2);
}

TEST(PartitionByRanks, FactsOfPartsAreThoseOfOneProcess) {
  const TemporaryFolder folder;
  for (const SampleFile& file : write_sample_files(folder)) {
    const std::string name = file.path.stem().string();
    if (name != "mixed" && name != "uniform" && name != "curvilinear" && name != "blanked" && name != "tetrahedra") continue;
    SCOPED_TRACE(name);
    const Parts parts = part(folder, quoted(file.path), 3);
    const std::string layer = " " + middle_third(file.path) + " --json";
    const CommandResult many = run("extract " + parts.list + layer, parts), one = run_isostrata("extract " + quoted(file.path) + layer);
    ASSERT_EQ(many.status, 0) << many.err;
    const auto a = boost::json::parse(one.out).as_object(), b = boost::json::parse(many.out).as_object();
    for (const char* fact : {"cells", "active_cells", "tetrahedra", "boundary_facets", "unmatched_facets"}) EXPECT_EQ(a.at(fact), b.at(fact)) << fact;
    const auto volume = [](const boost::json::object& of) { return of.at("intervals").as_array()[0].as_object().at("volume").to_number<double>(); };
    EXPECT_NEAR(volume(a), volume(b), 1e-12 * volume(a));
  }
}

// Where the ranks are others than the parts, the list is read whole, which wants all pieces: so the tests above would see a rank that opens another's.
TEST(PartitionByRanks, AnotherNumberOfRanksReadsAllPieces) {
  const TemporaryFolder folder;
  Parts parts = part(folder, "torus:12", 3);
  const std::string all = parts.launcher;
  parts.launcher.replace(parts.launcher.find("-n 3"), 4, "-n 2");
  const std::string command = "extract " + parts.list + " --interval 0:0.3 --json";
  const CommandResult two = run(command, parts);
  EXPECT_NE(two.status, 0);
  EXPECT_NE(two.err.find("torus-12_1.vti"), std::string::npos) << two.err;
  for (int piece = 0; piece < 3; ++piece)
    for (int rank = 0; rank < 3; ++rank) {
      const std::string name = "torus-12_" + std::to_string(piece) + ".vti";
      if (piece != rank) fs::copy(parts.folders[static_cast<std::size_t>(piece)] / name, parts.folders[static_cast<std::size_t>(rank)] / name);
    }
  const CommandResult whole = run(command, parts), one = run_isostrata("extract torus:12 --interval 0:0.3 --json");
  ASSERT_EQ(whole.status, 0) << whole.err;
  EXPECT_EQ(boost::json::parse(whole.out).at("tetrahedra"), boost::json::parse(one.out).at("tetrahedra"));
}

TEST(PartitionByRanks, APieceThatIsMissingOrAnotherOneIsNamed) {
  const TemporaryFolder folder;
  const Parts parts = part(folder, "torus:12", 2);
  const std::string command = "extract " + parts.list + " --interval 0:0.3";
  const fs::path own = parts.folders[1] / "torus-12_1.vti", kept = folder / "kept";
  fs::rename(own, kept);
  CommandResult result = run(command, parts);
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("torus-12_1.vti: no such file"), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("rank 1"), std::string::npos) << result.err;
  folder.write("other.vti", vti_text({0, 0, 0}, {3, 3, 3}, data_array("distance", "Float32", std::vector<float>(27))));
  fs::rename(folder / "other.vti", own);
  result = run(command, parts);
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("torus-12_1.vti: 27 points and 8 cells; expected what torus-12.parts.json says"), std::string::npos) << result.err;
  fs::rename(kept, own);
  EXPECT_EQ(run(command, parts).status, 0);
  // Planes that another partition has, on one node of two.
  const Parts others = part(folder, "torus:12 --region :,:,4:", 2);
  fs::copy(others.folders[1] / "torus-12.parts.json", parts.folders[1] / "torus-12.parts.json", fs::copy_options::overwrite_existing);
  fs::copy(others.folders[1] / "torus-12_1.vti", own, fs::copy_options::overwrite_existing);
  result = run(command, parts);
  EXPECT_EQ(result.status, 1);
  EXPECT_NE(result.err.find("expected the same files on every node"), std::string::npos) << result.err;
}

TEST(SharedDataPartitionByRanks, PartsOfMeasuredDataLookAsByOneProcess) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const TemporaryFolder folder;
  const fs::path fire = shared_data() / "ug_fire/fire_ug.vtu";
  expect_same_picture(folder, quoted(fire), middle_third(fire) + ",opacity=0.4,color=#30a0ff", 4);
}

}  // namespace
}  // namespace isostrata::testing
