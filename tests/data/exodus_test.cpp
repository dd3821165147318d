// Exodus files of every kind that people publish: most are meshes without time steps, or hold more than volumes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <tuple>

#include "data/files.h"
#include "support/exodus_file.h"

namespace isostrata {
namespace {

using test::Scratch;
using testing::ExodusFile;
using ::testing::HasSubstr;

class Exodus : public ::testing::Test {
 protected:
  /// Two unit cubes side by side along x.
  static ExodusFile cubes() {
    ExodusFile file;
    for (int k = 0; k < 2; ++k)
      for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 3; ++i) file.points.push_back({double(i), double(j), double(k)});
    file.blocks = {hexahedra(0), hexahedra(1)};
    return file;
  }
  static ExodusFile::Block hexahedra(int i) {
    std::vector<std::int32_t> ids{1, 2, 5, 4, 7, 8, 11, 10};
    for (auto& id : ids) id += i;
    return {"HEX8", 8, ids, 0};
  }
  std::shared_ptr<const Dataset> open(const ExodusFile& file, int step = 0) const {
    return test::open(scratch_.write("mesh.exo", file.bytes()), step);
  }
  static double volume(const Dataset& data) {
    double sum = 0;
    for (std::int64_t cell = 0; cell < data.grid.cell_count(); ++cell) sum += test::cell_volume(data.grid, cell);
    return sum;
  }
  static std::string notes(const Dataset& data) {
    std::string all;
    for (const std::string& note : data.notes) all += note + "\n";
    return all;
  }

  const Scratch scratch_;
};

TEST_F(Exodus, AMeshWithoutTimeStepsIsAMeshAtTimeZero) {
  ExodusFile file = cubes();
  const auto bare = open(file);
  EXPECT_EQ(bare->times, std::vector<double>{0});
  EXPECT_EQ(bare->grid.point_count(), 12);
  EXPECT_NEAR(volume(*bare), 2, 1e-14);
  EXPECT_TRUE(bare->arrays.empty());
  file.node_arrays = {"heat"};
  file.element_arrays = {"load"};
  EXPECT_THAT(notes(*open(file)), HasSubstr("arrays skipped: the file has no time steps"));
  EXPECT_THROW(open(file, 1), Error);
}

TEST_F(Exodus, ItsContentsTellItUnderAnyName) {
  for (const char* name : {"mesh.g", "mesh.e.4.0", "mesh.par", "mesh.exoII", "mesh.nc", "mesh"}) {
    const auto data = test::open(scratch_.write(name, cubes().bytes()));
    EXPECT_STREQ(data->grid.kind_name(), "unstructured") << name;
    EXPECT_NEAR(volume(*data), 2, 1e-14) << name;
  }
}

TEST_F(Exodus, EveryStepHasItsTimeAndItsValues) {
  ExodusFile file = cubes();
  file.node_arrays = {"heat", "salt"};
  file.element_arrays = {"load"};
  for (const std::vector<double>& times : {std::vector<double>{2.5}, std::vector<double>{0, 0.5, 7}}) {
    file.times = times;
    for (std::size_t step = 0; step < times.size(); ++step) {
      const auto data = open(file, static_cast<int>(step));
      EXPECT_EQ(data->times, times);
      EXPECT_EQ(data->step, static_cast<int>(step));
      for (std::size_t p = 0; p < 12; ++p) {
        EXPECT_EQ(data->array("heat").at(p), ExodusFile::node_value(0, step, p));
        EXPECT_EQ(data->array("salt").at(p), ExodusFile::node_value(1, step, p));
      }
      EXPECT_EQ(data->array("load").at(0), ExodusFile::element_value(0, step, 0));
    }
  }
}

TEST_F(Exodus, StepsWithoutArraysAreStepsAllTheSame) {
  ExodusFile file = cubes();
  file.times = {1, 2};
  const auto data = open(file, 1);
  EXPECT_EQ(data->times.size(), 2u);
  EXPECT_EQ(data->grid.cell_count(), 2);
  EXPECT_TRUE(data->arrays.empty());
}

TEST_F(Exodus, BlocksOfEveryKindOfCellMeetInTheirPoints) {
  for (const bool steps : {false, true}) {
    ExodusFile file = cubes();  // a cube, and beside it a pyramid and two tetrahedra; a wedge below
    file.points.insert(file.points.end(), {{0, 0, -1}, {1, 0, -1}});
    file.blocks = {hexahedra(0),
                   {"PYRAMID5", 5, {2, 5, 11, 8, 6}, 0},
                   {"TETRA4", 4, {2, 3, 6, 8, 3, 9, 6, 8}, 0},
                   {"WEDGE6", 6, {13, 1, 4, 14, 2, 5}, 0}};
    if (steps) file.times = {0}, file.node_arrays = {"heat"};
    const auto data = open(file);
    EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{
                                    {"hexahedron", 1}, {"pyramid", 1}, {"tetrahedron", 2}, {"wedge", 1}}));
    EXPECT_EQ(data->grid.point_count(), 14);
  }
}

TEST_F(Exodus, WhatIsNoVolumeIsLeftOutAndCounted) {
  const std::pair<const char*, int> kinds[] = {{"SPHERE", 1}, {"CIRCLE", 1}, {"BAR2", 2},   {"BEAM", 2},    {"TRUSS", 2},  {"EDGE2", 2},
                                               {"TRI3", 3},   {"QUAD4", 4},  {"SHELL4", 4}, {"SHELL8", 8}, {"SUPER", 5}};
  for (const auto& [type, nodes] : kinds)
    for (const bool steps : {false, true}) {
      SCOPED_TRACE(type);
      ExodusFile file = cubes();
      std::vector<std::int32_t> ids;
      for (int v = 0; v < nodes; ++v) ids.push_back(v + 1);
      file.blocks.insert(file.blocks.begin() + 1, {type, nodes, ids, 0});
      if (steps) file.times = {0, 1}, file.node_arrays = {"heat"}, file.element_arrays = {"load"};
      const auto data = open(file);
      EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"hexahedron", 2}}));
      EXPECT_NEAR(volume(*data), 2, 1e-14);
      EXPECT_THAT(notes(*data), HasSubstr("skipped"));
    }
}

TEST_F(Exodus, ElementsThatNobodyKnowsAreLeftOutByTheNameThatTheFileGivesThem) {
  for (const char* type : {"ROD", "SPRING", "BRICK", "WHATEVER"})
    for (const std::size_t place : {0u, 1u, 2u}) {
      SCOPED_TRACE(type);
      ExodusFile file = cubes();
      const int nodes = type == std::string("BRICK") ? 8 : 2;
      std::vector<std::int32_t> ids;
      for (int v = 0; v < 3 * nodes; ++v) ids.push_back(v % 12 + 1);
      file.blocks.insert(file.blocks.begin() + static_cast<std::ptrdiff_t>(place), {type, nodes, ids, 0});
      const auto data = open(file);
      EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"hexahedron", 2}}));
      EXPECT_THAT(notes(*data), HasSubstr("3 elements of type '" + std::string(type) + "' skipped"));
    }
}

TEST_F(Exodus, AFileOfNothingElseIsRefusedByThatName) {
  ExodusFile file = cubes();
  file.blocks = {{"BRICK", 8, {1, 2, 5, 4, 7, 8, 11, 10}, 0}};
  const Error refusal = test::refusal(scratch_.write("bricks.exo", file.bytes()));
  EXPECT_EQ(refusal.code(), ErrorCode::unsupported);
  EXPECT_THAT(refusal.what(), HasSubstr("bricks.exo: has no elements but of type 'BRICK'"));
}

TEST_F(Exodus, ArraysOfTheVolumesStayWhenShellsAreLeftOut) {
  ExodusFile file = cubes();
  file.blocks.push_back({"SHELL4", 4, {1, 2, 5, 4}, 0});
  file.times = {0};
  file.element_arrays = {"load"};
  EXPECT_EQ(open(file)->array("load").at(0), ExodusFile::element_value(0, 0, 0));
}

TEST_F(Exodus, TypesAreKnownByAnyOfTheirNames) {
  using Cells = std::map<std::string, std::int64_t>;
  const Cells hexahedra{{"hexahedron", 8}}, tetrahedra{{"tetrahedron", 8}};  // that one of second order is divided into
  const std::tuple<const char*, int, Cells> names[] = {{"HEX", 8, {{"hexahedron", 1}}},
                                                       {"hex8", 8, {{"hexahedron", 1}}},
                                                       {"HEXAHEDRON", 8, {{"hexahedron", 1}}},
                                                       {"HEX20", 20, hexahedra},
                                                       {"HEX27", 27, hexahedra},
                                                       {"TETRA", 4, {{"tetrahedron", 1}}},
                                                       {"tet4", 4, {{"tetrahedron", 1}}},
                                                       {"TETRA8", 8, {{"tetrahedron", 1}}},
                                                       {"TETRA10", 10, tetrahedra},
                                                       {"TETRA11", 11, tetrahedra},
                                                       {"TETRA14", 14, {{"tetrahedron", 1}}},
                                                       {"WEDGE", 6, {{"wedge", 1}}},
                                                       {"WEDGE15", 15, {{"wedge", 8}}},
                                                       {"WEDGE16", 16, {{"wedge", 1}}},
                                                       {"PYRAMID", 5, {{"pyramid", 1}}},
                                                       {"PYR5", 5, {{"pyramid", 1}}},
                                                       {"PYRAMID13", 13, {{"pyramid", 6}, {"tetrahedron", 4}}},
                                                       {"PYRAMID14", 14, {{"pyramid", 1}}}};
  for (const auto& [name, nodes, cells] : names) {
    SCOPED_TRACE(name);
    ExodusFile file;
    std::vector<std::int32_t> ids;
    for (int v = 0; v < nodes; ++v) {
      file.points.push_back({double(v % 3), double(v / 3 % 3), double(v / 9)});
      ids.push_back(v + 1);
    }
    file.blocks = {{name, nodes, ids, 0}};
    const auto data = open(file);
    EXPECT_EQ(data->cell_types, cells) << notes(*data);
    std::array<std::int64_t, kMaxCellVertices> corners{};
    const int n = data->grid.cell_points(0, corners);
    for (int v = 0; v < (data->grid.cell_count() == 1 ? n : 1); ++v) EXPECT_EQ(corners[static_cast<std::size_t>(v)], v);
  }
}

/// Exodus numbers the middles of a hexahedron's edges up before those of its top: here every one has the value of its place.
TEST_F(Exodus, MiddlesOfEdgesAreWhereExodusHasThem) {
  ExodusFile file;
  file.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{
           {0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {4, 5}, {5, 6}, {6, 7}, {7, 4}})
    file.points.push_back({(file.points[a][0] + file.points[b][0]) / 2, (file.points[a][1] + file.points[b][1]) / 2, (file.points[a][2] + file.points[b][2]) / 2});
  std::vector<std::int32_t> ids;
  for (int v = 1; v <= 20; ++v) ids.push_back(v);
  file.blocks = {{"HEX20", 20, ids, 0}};
  const auto data = open(file);
  double volume = 0;
  for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
    EXPECT_NEAR(test::cell_volume(data->grid, cell), 0.125, 1e-12) << cell;
    volume += test::cell_volume(data->grid, cell);
  }
  EXPECT_NEAR(volume, 1, 1e-12);
}

TEST_F(Exodus, EmptyBlocksAndFlatMeshesAndNodesAloneGetAnAnswer) {
  ExodusFile file = cubes();
  file.blocks.push_back({"HEX8", 8, {}, 7});
  file.blocks.insert(file.blocks.begin(), {"TETRA4", 4, {}, 9});
  for (const std::vector<double>& times : {std::vector<double>{}, std::vector<double>{0, 1}}) {
    file.times = times;
    EXPECT_NEAR(volume(*open(file)), 2, 1e-14);
  }

  ExodusFile flat;
  flat.dimensions = 2;
  flat.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  flat.blocks = {{"QUAD4", 4, {1, 2, 3, 4}, 0}};
  EXPECT_EQ(open(flat)->cell_types, (std::map<std::string, std::int64_t>{{"quadrilateral", 1}}));
  flat.times = {0};
  flat.node_arrays = {"heat"};
  EXPECT_EQ(open(flat)->array("heat").at(3), ExodusFile::node_value(0, 0, 3));

  ExodusFile nodes = cubes();
  nodes.blocks.clear();
  nodes.node_sets = {{1, 2, 3}};
  const auto refusal = [&](const ExodusFile& of) { return test::refusal(scratch_.write("none.exo", of.bytes())); };
  EXPECT_EQ(refusal(nodes).code(), ErrorCode::bad_data);
  EXPECT_THAT(refusal(nodes).what(), HasSubstr("none.exo: has no element blocks"));
  EXPECT_THAT(refusal(ExodusFile{}).what(), HasSubstr("none.exo: "));
}

}  // namespace
}  // namespace isostrata
