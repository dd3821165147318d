// Files of boxes in levels, as datasets.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "data/files.h"
#include "data/files/list_folder.h"
#include "support/block_tree.h"
#include "support/level_files.h"

namespace isostrata {
namespace {

using test::BlockTree;
using test::block_tree;
using test::open;
using test::refusal;
using test::Scratch;
using testing::Plotfile;
using testing::write_plotfile;
using testing::write_vthb;

double bump(const Vec3d& p) { return std::exp(-dot(p, p) / 8); }
double slope(const Vec3d& p) { return 1 + 2 * p.x - 3 * p.y + 0.5 * p.z; }

const BlockTree kTree{.roots = {3, 2, 2}, .depth = 2};
constexpr std::uint64_t kSeed = 4;

void expect_same_values(const PointArray& a, const PointArray& b, double tolerance) {
  ASSERT_EQ(std::visit([](auto v) { return v.size(); }, a.values), std::visit([](auto v) { return v.size(); }, b.values));
  double worst = 0;
  for (std::size_t p = 0; p < std::visit([](auto v) { return v.size(); }, a.values); ++p) worst = std::max(worst, std::abs(a.at(p) - b.at(p)));
  EXPECT_LE(worst, tolerance);
}

TEST(Levels, OfVtkAndOfAmrexAreOneDataset) {
  const Scratch scratch;
  const LevelBoxes levels = block_tree(kTree, kSeed);
  const auto vtk = open(write_vthb(scratch, "levels", levels, bump));
  ASSERT_EQ(vtk->arrays.size(), 1u);
  const Plotfile kinds[] = {{}, {.bytes = 4, .big = true, .ghosts = 1}, {.big = true, .boxes_of_a_file = 1}, {.bytes = 4, .ghosts = 2, .first = {-5, 8, 2}}};
  for (const Plotfile& of : kinds) {
    SCOPED_TRACE(std::to_string(of.bytes) + " bytes, big " + std::to_string(of.big) + ", ghosts " + std::to_string(of.ghosts));
    const auto amrex = open(write_plotfile(scratch, "plt" + std::to_string(&of - kinds), levels, {{"density", bump}, {"slope of z", slope}}, of));
    ASSERT_EQ(amrex->arrays.size(), 2u);
    EXPECT_EQ(amrex->arrays[1].name, "slope of z");
    EXPECT_EQ(amrex->arrays[0].type, of.bytes == 4 ? ScalarType::float32 : ScalarType::float64);
    EXPECT_EQ(amrex->cell_types, vtk->cell_types);
    ASSERT_EQ(amrex->grid.point_count(), vtk->grid.point_count());
    expect_same_values(amrex->arrays[0], vtk->arrays[0], of.bytes == 4 ? 1e-7 : 1e-15);
    ASSERT_TRUE(amrex->arrays[0].cells);
    EXPECT_EQ(amrex->arrays[0].nan_count, 0) << "of a ghost cell";
    double volume = 0;
    for (std::int64_t cell = 0; cell < amrex->grid.cell_count(); ++cell) volume += test::cell_volume(amrex->grid, cell);
    EXPECT_NEAR(volume, 6 * 4 * 4 * 0.75 * 1.25, 1e-9);
  }
}

TEST(Levels, KeepALinearFieldInside) {
  const Scratch scratch;
  const auto data = open(write_plotfile(scratch, "plt", block_tree({.roots = {3, 3, 3}, .depth = 1}, kSeed), {{"slope", slope}}));
  const PointArray& array = data->arrays.front();
  int inside = 0;
  for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
    const Vec3d at = data->grid.point(p);
    bool far = true;
    for (int axis = 0; axis < 3; ++axis) far = far && at[axis] > data->bounds.lower[axis] && at[axis] < data->bounds.upper[axis];
    if (!far) continue;
    ++inside;
    ASSERT_NEAR(array.at(static_cast<std::size_t>(p)), slope(at), 1e-12) << "point " << p;
  }
  EXPECT_GT(inside, 500);
  for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell)
    if (data->grid.cell_type(cell) == CellType::hexahedron) {
      std::array<std::int64_t, kMaxCellVertices> ids{};
      data->grid.cell_points(cell, ids);
      const Vec3d middle = (data->grid.point(ids[0]) + data->grid.point(ids[6])) * 0.5;
      ASSERT_NEAR(std::visit([&](auto v) { return static_cast<double>(v[static_cast<std::size_t>(cell)]); }, array.cells->values), slope(middle), 1e-12) << "cells keep their own values";
    }
}

TEST(Levels, InAPlaneAreFlat) {
  const Scratch scratch;
  const BlockTree flat{.roots = {3, 4, 0}, .depth = 3};
  const auto vtk = open(write_vthb(scratch, "flat", block_tree(flat, kSeed), slope)), amrex = open(write_plotfile(scratch, "plt", block_tree(flat, kSeed), {{"slope", slope}}));
  EXPECT_TRUE(vtk->grid.flat());
  EXPECT_EQ(vtk->cell_types, amrex->cell_types);
  EXPECT_EQ(vtk->cell_types.size(), 2u) << "triangles and quadrilaterals";
}

TEST(Levels, SayHowManyThereAreAndTheirTime) {
  const Scratch scratch;
  const LevelBoxes levels{.boxes = {{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}, {{1, 1, 1}, {0.25, 0.25, 0.25}, {4, 4, 4}}}, .axes = {}};
  const auto data = open(write_plotfile(scratch, "plt00070", levels, {{"f", slope}}, {.time = 2.5}));
  EXPECT_EQ(data->times, std::vector<double>{2.5});
  ASSERT_EQ(data->notes.size(), 2u);
  EXPECT_EQ(data->notes[0], "2 levels, refined by 4: 63 and 64 cells that no finer one covers");
  EXPECT_TRUE(data->notes[1].starts_with("18 cells beside finer ones, cut into ")) << data->notes[1];
}

TEST(Levels, OfPointsAloneAreRefusedAndWhatOneBoxLacksIsLeftOut) {
  const Scratch scratch;
  const LevelBoxes levels{.boxes = {{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}, {{1, 1, 1}, {0.5, 0.5, 0.5}, {4, 4, 4}}}, .axes = {}};
  const auto list = write_vthb(scratch, "levels", levels, slope);
  const std::vector<double> at_points(125, 1.0);
  const std::string array = testing::data_array("p", "Float64", at_points);
  for (const char* box : {"levels/box_0.vti", "levels/box_1.vti"}) {
    std::string text = test::read_bytes(scratch / box);
    text.insert(text.find("</PointData>"), array);
    scratch.write(box, text);
  }
  EXPECT_EQ(open(list)->arrays.size(), 1u);
  EXPECT_EQ(open(list)->notes.back(), "array 'p' left out: it is on points; of levels the values of cells are read");
  std::string text = test::read_bytes(scratch / "levels/box_1.vti");
  scratch.write("levels/box_1.vti", text.replace(text.find("\"field\""), 7, "\"other\""));
  EXPECT_NE(std::string(refusal(list).what()).find("its values are on points"), std::string::npos);
}

TEST(Levels, AreListedAsOneThingEach) {
  const Scratch scratch;
  const LevelBoxes levels = block_tree(kTree, kSeed);
  write_vthb(scratch, "levels", levels, bump);
  write_plotfile(scratch, "run/plotfile", levels, {{"density", bump}});
  const FolderListing listing = list_folder(scratch.path());
  std::vector<std::string> names;
  for (const FolderEntry& entry : listing.entries) names.push_back(entry.name);
  EXPECT_EQ(names, (std::vector<std::string>{"levels.vthb", "run/plotfile"}));
  EXPECT_EQ(listing.entries.back().kind, FileKind::amrex);
  EXPECT_GT(listing.entries.back().bytes, 1000u);
  ASSERT_EQ(listing.passed_over.size(), 1u);
  EXPECT_EQ(listing.passed_over.front().files, std::ssize(levels.boxes));
}

TEST(Levels, OfNumberedPlotfilesAreSteps) {
  const Scratch scratch;
  const LevelBoxes few = block_tree(kTree, kSeed), others = block_tree(kTree, kSeed + 1);
  for (const auto& [number, time] : {std::pair{"00000", 0.0}, {"00010", 0.25}, {"00100", 1.5}})
    write_plotfile(scratch, std::string("plt") + number, time == 0.25 ? others : few, {{"density", [time = time](const Vec3d& p) { return bump(p) + time; }}}, {.time = time});
  write_plotfile(scratch, "other", few, {{"density", bump}});
  const FolderListing listing = list_folder(scratch.path());
  ASSERT_EQ(listing.entries.size(), 2u);
  EXPECT_EQ(listing.entries[0].name, "other");
  EXPECT_EQ(listing.entries[1].name, "plt*");
  EXPECT_EQ(listing.entries[1].files, 3);
  EXPECT_EQ(listing.entries[1].marks.size(), 3u);
  for (int step = 0; step < 3; ++step) {
    const auto data = open(scratch / "plt*", step);
    EXPECT_EQ(data->times, (std::vector<double>{0, 0.25, 1.5})) << "those that their headers say";
    EXPECT_GT(data->arrays.front().upper, data->times[static_cast<std::size_t>(step)] + 0.3);
    EXPECT_LT(data->arrays.front().lower, data->times[static_cast<std::size_t>(step)] + 0.1);
    EXPECT_GT(data->arrays.front().lower, data->times[static_cast<std::size_t>(step)]);
  }
  EXPECT_EQ(refusal(scratch / "plt*", {.step = 3}).code(), ErrorCode::not_found);
}

TEST(Levels, AStepThatFollowsIsListedByALookAtItAlone) {
  const Scratch scratch;
  const LevelBoxes levels = block_tree(kTree, kSeed);
  write_plotfile(scratch, "plt1", levels, {{"density", bump}});
  write_plotfile(scratch, "plt2", levels, {{"density", bump}});
  std::filesystem::rename(scratch / "plt2/Header", scratch / "Header");  // AMReX writes it last
  FolderLister lister(std::filesystem::canonical(scratch.path()));
  const auto names = [&] {
    std::vector<std::string> out;
    for (const FolderEntry& entry : lister.list().entries) out.push_back(entry.name);
    return out;
  };
  EXPECT_EQ(names(), std::vector<std::string>{"plt1"});
  std::filesystem::rename(scratch / "Header", scratch / "plt2/Header");
  lister.look_again(std::filesystem::canonical(scratch / "plt2"));
  EXPECT_EQ(names(), std::vector<std::string>{"plt*"});
  std::filesystem::remove_all(scratch / "plt2");
  lister.look_again(std::filesystem::canonical(scratch.path()));
  EXPECT_EQ(names(), std::vector<std::string>{"plt1"});
}

// ---- what is refused --------------------------------------------------------------------------------------------------------------

TEST(Levels, OfADamagedPlotfileSayWhatIsWrong) {
  const LevelBoxes levels{.boxes = {{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}, {{1, 1, 1}, {0.5, 0.5, 0.5}, {4, 4, 4}}}, .axes = {}};
  struct Damage {
    const char *file, *before, *after, *message;
  };
  const Damage damages[] = {
      {"Header", "HyperCLaw-V1.1\n1\n", "HyperCLaw-V1.1\n99999\n", "the number of components is '99999'; expected a whole number from 1 to 10000"},
      {"Header", "f\n3\n", "f\n4\n", "the number of dimensions is '4'"},
      {"Header", "f\n3\n", "f\n1\n", "one dimension"},
      {"Header", "\n0\n1\n", "\n0\n63\n", ""},
      {"Header", "\n0\n1\n", "\nnan\n1\n", "the time is 'nan'; expected a finite number"},
      {"Header", "(3,3,3)", "(-3,3,3)", "the domain ends before it begins"},
      {"Header", "1 1 1 \n0.5", "1 0 1 \n0.5", "has no finite place and size"},
      {"Header", "1 1 1 \n0.5", "1 1 2 \n0.5", "refined by 4.000000 along z"},
      {"Header", "0\n0\n0 1", "7\n0\n0 1", "the kind of coordinates is '7'"},
      {"Header", "0 1 0\n", "0 1000000000 0\n", "the number of boxes is '1000000000'"},
      {"Header", "Level_1/Cell", "../../Cell", "expected a file below its own directory"},
      {"Header", "Level_1/Cell", "Level_2/Cell", "which is not there"},
      {"Level_1/Cell_H", "1\n1\n1\n0\n", "4\n1\n1\n0\n", "is of version 4; expected 1"},
      {"Level_1/Cell_H", "1\n1\n1\n0\n", "1\n1\n3\n0\n", "the number of components is '3'"},
      {"Level_1/Cell_H", "(1 0\n", "(1000000000 0\n", "the number of boxes is '1000000000'"},
      {"Level_1/Cell_H", "(1 0\n", "(2 0\n", ""},
      {"Level_1/Cell_H", "((2,2,2)", "((3,2,2)", "begins or ends inside a cell"},
      {"Level_1/Cell_H", "((2,2,2)", "((9999999999999,2,2)", "a box is '9999999999999'"},
      {"Level_1/Cell_H", "(5,5,5)", "(7,5,5)", "is not of the cells that Cell_H says"},
      {"Level_1/Cell_H", "(0,0,0)", "(1,0,0)", "has its values on points; expected cells"},
      {"Level_1/Cell_H", "Cell_D_00000 0", "../../Header 0", "expected a file below its own directory"},
      {"Level_1/Cell_H", "Cell_D_00000 0", "/etc/passwd 0", "expected a file below its own directory"},
      {"Level_1/Cell_H", "Cell_D_00000 0", "Cell_D_00009 0", "which is not there"},
      {"Level_1/Cell_H", "Cell_D_00000 0", "Cell_D_00000 99999", "the file ends at"},
      {"Level_1/Cell_H", "Cell_D_00000 0", "Cell_D_00000 -1", "the place of a box is '-1'"},
      {"Level_1/Cell_D_00000", "FAB", "BAF", "expected 'FAB' there"},
      {"Level_1/Cell_D_00000", "(8 7 6 5 4 3 2 1)", "(8 7 5 6 4 3 2 1)", "the order of bytes is neither rising nor falling"},
      {"Level_1/Cell_D_00000", "(5,5,5) (0,0,0)) 1\n", "(5,5,5) (0,0,0)) 2\n", "bytes declared"},
      {"Level_1/Cell_D_00000", "(5,5,5) (0,0,0)) 1\n", "(999,999,99999) (0,0,0)) 1\n", "bytes declared"},
  };
  for (const Damage& damage : damages) {
    SCOPED_TRACE(std::string(damage.file) + ": " + damage.after);
    const Scratch scratch;
    const auto folder = write_plotfile(scratch, "plt", levels, {{"f", slope}});
    std::string bytes = test::read_bytes(folder / damage.file);
    const auto at = bytes.find(damage.before);
    ASSERT_NE(at, std::string::npos) << bytes.substr(0, 600);
    scratch.write(std::string("plt/") + damage.file, bytes.replace(at, std::string(damage.before).size(), damage.after));
    const Error error = refusal(folder);
    EXPECT_NE(std::string(error.what()).find(damage.message), std::string::npos) << error.what();
    EXPECT_NE(error.code(), ErrorCode::internal);
  }
  for (const char* file : {"Header", "Level_0/Cell_H", "Level_1/Cell_H", "Level_1/Cell_D_00000"}) {
    const Scratch scratch;
    const auto folder = write_plotfile(scratch, "plt", levels, {{"f", slope}});
    const std::string bytes = test::read_bytes(folder / file);
    for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 17) {
      scratch.write(std::string("plt/") + file, bytes.substr(0, length));
      EXPECT_NE(refusal(folder).code(), ErrorCode::internal) << file << " of " << length << " bytes";
    }
  }
}

TEST(Levels, OfADamagedListSayWhatIsWrong) {
  const LevelBoxes levels{.boxes = {{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}, {{1, 1, 1}, {0.5, 0.5, 0.5}, {4, 4, 4}}}, .axes = {}};
  struct Damage {
    const char *file, *before, *after, *message;
  };
  const Damage damages[] = {
      {"levels.vthb", "levels/box_1.vti", "../box_1.vti", "expected a file below its own directory"},
      {"levels.vthb", "levels/box_1.vti", "levels/box_7.vti", "which is not there"},
      {"levels.vthb", "levels/box_1.vti", "levels.vthb", "expected a .vti for each box"},
      {"levels.vthb", "</Block>", "</Black>", ""},
      {"levels.vthb", "levels/box_0.vti", "levels/box_1.vti", "box 0 and box 1 are of one level and overlap"},
      {"levels/box_1.vti", "Spacing=\"0.5 0.5 0.5\"", "Spacing=\"-0.5 0.5 0.5\"", "box 1 has no finite place and size"},
      {"levels/box_1.vti", "Spacing=\"0.5 0.5 0.5\"", "Spacing=\"0.5 0.5 0.3\"", "refined by 3.333333 along z"},
      {"levels/box_1.vti", "Origin=\"1 1 1\"", "Origin=\"1.2 1 1\"", "box 1 begins inside a cell of its own level"},
  };
  for (const Damage& damage : damages) {
    SCOPED_TRACE(std::string(damage.file) + ": " + damage.after);
    const Scratch scratch;
    const auto list = write_vthb(scratch, "levels", levels, slope);
    std::string bytes = test::read_bytes(scratch / damage.file);
    const auto at = bytes.find(damage.before);
    ASSERT_NE(at, std::string::npos);
    scratch.write(damage.file, bytes.replace(at, std::string(damage.before).size(), damage.after));
    const Error error = refusal(list);
    EXPECT_NE(std::string(error.what()).find(damage.message), std::string::npos) << error.what();
    EXPECT_NE(error.code(), ErrorCode::internal);
  }
}

}  // namespace
}  // namespace isostrata
