// O-grids in files: a ring that goes from 0 to 2 pi is closed, although the sine of 2 pi is no 0.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "data/files.h"
#include "data/grids/grid_sheets.h"
#include "support/vtk_text.h"

namespace isostrata {
namespace {

using test::Scratch;

constexpr std::array<int, 3> kDims{9, 4, 3};  // around, outward, up

/// A part of a hollow cylinder from `bottom` up, as a script makes it: 'f' is of the places, 'jump' and 'id' count around, 'cell' is of cells.
std::string ring(double bottom) {
  std::vector<Vec3d> points;
  std::vector<double> values, jump, cells;
  std::vector<std::int64_t> id;
  for (int k = 0; k < kDims[2]; ++k)
    for (int j = 0; j < kDims[1]; ++j)
      for (int i = 0; i < kDims[0]; ++i) {
        const double around = 2 * M_PI * i / (kDims[0] - 1), r = 1 + j / 3.0;
        points.push_back({r * std::cos(around), r * std::sin(around), bottom + k});
        values.push_back(points.back().y + points.back().z / 7);
        jump.push_back(i);
        id.push_back(i + 100'000'000 * j);  // of a range beside which a step around is no more than rounding
        if (i + 1 < kDims[0] && j + 1 < kDims[1] && k + 1 < kDims[2]) cells.push_back(i + 10 * j + 100 * k);
      }
  using testing::data_array;
  return testing::vts_text(kDims, points, data_array("f", "Float64", values) + data_array("id", "Int64", id) + data_array("jump", "Float64", jump),
                           data_array("cell", "Float64", cells));
}

const PointArray& array_of(const Dataset& data, std::string_view name) {
  const auto at = std::find_if(data.arrays.begin(), data.arrays.end(), [&](const PointArray& a) { return a.name == name; });
  if (at == data.arrays.end()) throw std::runtime_error("no array " + std::string(name));
  return *at;
}

TEST(CloseSeams, TheLastSheetIsTheFirstToTheLastBitWhereRoundingAloneIsBetween) {
  const Scratch scratch;
  const auto data = test::open(scratch.write("ring.vts", ring(0)));
  const GridSheets sheets{data->grid.dims(), 0};
  const PointArray &f = array_of(*data, "f"), &jump = array_of(*data, "jump"), &cell = array_of(*data, "cell"), &id = array_of(*data, "id");
  int points = 0;
  sheets.all_of([&](std::int64_t p) {
    const auto first = static_cast<std::size_t>(p), last = static_cast<std::size_t>(p + sheets.last());
    EXPECT_EQ(data->grid.point(p), data->grid.point(p + sheets.last()));
    EXPECT_EQ(f.at(first), f.at(last));
    EXPECT_EQ(jump.at(first), 0);
    EXPECT_EQ(jump.at(last), 8) << "a jump in the file stays one";
    EXPECT_EQ(id.at(last), id.at(first) + 8) << "whole numbers are never rounded";
    EXPECT_EQ(cell.at(first), cell.at(last)) << "cells of both sides meet there";
    ++points;
    return true;
  });
  EXPECT_EQ(points, 12);
  EXPECT_EQ(cell.at(0), (0 + 7) / 2.0);
}

TEST(CloseSeams, WhatIsFartherApartThanRoundingStaysOpen) {
  std::vector<Vec3d> points;
  std::vector<double> values;
  for (int k = 0; k < kDims[2]; ++k)
    for (int j = 0; j < kDims[1]; ++j)
      for (int i = 0; i < kDims[0]; ++i) {
        const double around = (2 * M_PI - 1e-4) * i / (kDims[0] - 1), r = 1 + j / 3.0;
        points.push_back({r * std::cos(around), r * std::sin(around), static_cast<double>(k)});
        values.push_back(1);
      }
  const Scratch scratch;
  const auto data = test::open(scratch.write("slit.vts", testing::vts_text(kDims, points, testing::data_array("f", "Float64", values))));
  for (std::size_t p = 0; p < points.size(); ++p) EXPECT_EQ(data->grid.point(static_cast<std::int64_t>(p)), points[p]);
}

TEST(CloseSeams, RingsThatBecomeOneGridHaveNoWallInThem) {
  const Scratch scratch;
  // 'id' and 'jump' would keep the two sides of the seam apart, for all arrays share the points.
  for (const auto& [name, bottom] : {std::pair{"low.vts", 0.0}, {"high.vts", 2.0}}) {
    std::string text = ring(bottom);
    for (const char* array : {"id", "jump"}) {
      const auto begin = text.find(std::string("<DataArray Name=\"") + array + "\""), end = text.find("</DataArray>", begin);
      text.erase(begin, end + 12 - begin);
    }
    scratch.write(name, text);
  }
  const auto data = test::open(scratch.write("both.pvd", testing::pvd_text({{0, "low.vts"}, {0, "high.vts"}})));
  ASSERT_EQ(data->grid.cell_count(), 2 * 8 * 3 * 2);
  std::map<std::vector<std::int64_t>, int> faces;
  std::array<std::int64_t, kMaxCellVertices> ids{};
  for (std::int64_t c = 0; c < data->grid.cell_count(); ++c) {
    data->grid.cell_points(c, ids);
    for (const CellFace& face : topology(data->grid.cell_type(c)).faces) {
      std::vector<std::int64_t> key;
      for (int v = 0; v < face.size; ++v) key.push_back(ids[face.vertex[static_cast<std::size_t>(v)]]);
      std::sort(key.begin(), key.end());
      ++faces[key];
    }
  }
  const auto open = std::count_if(faces.begin(), faces.end(), [](const auto& face) { return face.second == 1; });
  EXPECT_EQ(open, 2 * 8 * 4 + 2 * 8 * 3) << "inside and outside, bottom and lid";
}

}  // namespace
}  // namespace isostrata
