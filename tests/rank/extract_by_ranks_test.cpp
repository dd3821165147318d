// What ranks count is what one process counts, and their pieces are one mesh.
#include <gtest/gtest.h>
#include <unistd.h>

#include "data/open/import_door.h"
#include "rank/by_ranks.h"
#include "support/sample_files.h"

namespace isostrata::testing {
namespace {

boost::json::object extract(const std::string& arguments, int ranks) {
  const CommandResult run = run_isostrata("extract " + arguments + " --json" + (ranks > 0 ? " --ranks '" + launcher(ranks) + "'" : ""), launcher_environment());
  if (run.status != 0) throw std::runtime_error(arguments + ": " + run.err);
  return boost::json::parse(run.out).as_object();
}

void expect_same_facts(const std::string& arguments, int ranks) {
  const boost::json::object one = extract(arguments, 0), many = extract(arguments, ranks);
  for (const char* name : {"cells", "active_cells", "tetrahedra", "boundary_facets", "unmatched_facets"}) EXPECT_EQ(one.at(name), many.at(name)) << name << ": " << arguments;
  ASSERT_EQ(one.at("intervals").as_array().size(), many.at("intervals").as_array().size());
  for (std::size_t i = 0; i < one.at("intervals").as_array().size(); ++i) {
    const auto &a = one.at("intervals").as_array()[i].as_object(), &b = many.at("intervals").as_array()[i].as_object();
    for (const char* name : {"active_cells", "tetrahedra", "inverted"}) EXPECT_EQ(a.at(name), b.at(name)) << name << ": " << arguments;
    for (const char* name : {"volume", "absolute_volume"})
      EXPECT_NEAR(a.at(name).to_number<double>(), b.at(name).to_number<double>(), 1e-12 * a.at("absolute_volume").to_number<double>()) << name << ": " << arguments;
  }
}

TEST(ExtractByRanks, FactsAreThoseOfOneProcess) {
  const TemporaryFolder folder;
  expect_same_facts("torus:20 --interval 0:0.1 --interval 0.1:0.4", 4);
  expect_same_facts("cylinder --array Density --interval 0.95:1.01 --interval -inf:0.9", 3);
  for (const SampleFile& file : write_sample_files(folder)) {
    SCOPED_TRACE(file.path.filename().string());
    expect_same_facts(quoted(file.path) + " " + middle_third(file.path), 2);
  }
}

TEST(ExtractByRanks, PiecesBesideThePvtuAreReadAsTheWholeMesh) {
  const TemporaryFolder folder;
  const boost::json::object one = extract("torus:20 --interval 0:0.1 --interval 0.1:0.4 --out " + quoted(folder / "one.vtu"), 0);
  const boost::json::object many = extract("torus:20 --interval 0:0.1 --interval 0.1:0.4 --out " + quoted(folder / "all.pvtu"), 4);
  for (int rank = 0; rank < 4; ++rank) EXPECT_TRUE(std::filesystem::exists(folder / ("all_" + std::to_string(rank) + ".vtu")));
  const auto a = open_import(folder / "one.vtu", {}, Task{}), b = open_import(folder / "all.pvtu", {}, Task{});
  EXPECT_EQ(a->grid.cell_count(), b->grid.cell_count());
  // The importer joins pieces by the bits of their points: a point more would be one that two ranks have put at two places.
  EXPECT_EQ(a->grid.point_count(), b->grid.point_count());
  EXPECT_EQ(a->arrays.size(), b->arrays.size());
  EXPECT_GT(many.at("points").to_number<std::int64_t>(), one.at("points").to_number<std::int64_t>());
}

// As where each node has a folder of that name for itself.
TEST(ExtractByRanks, APieceThatTheFirstRankDoesNotSeeIsAnError) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "own");
  const auto works = [](const std::string& command) { return std::system((command + " true").c_str()) == 0; };
  std::string unshare = geteuid() == 0 ? "unshare --mount" : "unshare --user --map-root-user --mount";  // in a root folder nobody may have users of their own
  if (geteuid() == 0 && !works(unshare)) unshare += " --propagation unchanged";                         // nor is its root a mount
  const auto start = folder.write("start.sh", "[ \"$OMPI_COMM_WORLD_RANK\" != 1 ] || exec " + unshare + " sh -c 'mount -t tmpfs tmpfs \"'" +
                                                  (folder / "own").string() + "'\" && exec \"$@\"' sh \"$@\"\nexec \"$@\"\n");
  if (!works(unshare)) GTEST_SKIP() << "no namespaces here";
  const CommandResult run = run_isostrata("extract torus:8 --interval 0:0.3 --out " + quoted(folder / "own" / "all.pvtu") + " --ranks '" + launcher(2) + " sh " + start.string() + "'",
                                          launcher_environment());
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("all_1.vtu: rank 1 has written it, and it is not there for the first rank on "), std::string::npos) << run.err;
  EXPECT_TRUE(std::filesystem::is_empty(folder / "own"));
}

TEST(ExtractByRanks, WhatNeedsTheWholeMeshIsRefused) {
  const TemporaryFolder folder;
  for (const std::string& more : {std::string("--verify"), "--out " + quoted(folder / "a.vtu"), "--out " + quoted(folder / "a.stl")}) {
    const CommandResult run = run_isostrata("extract torus:8 --interval 0:1 " + more + " --ranks 'mpirun -n 2'");
    EXPECT_EQ(run.status, 1);
    EXPECT_NE(run.err.find("rank"), std::string::npos) << run.err;
  }
}

}  // namespace
}  // namespace isostrata::testing
