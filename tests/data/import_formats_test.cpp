// What the importer makes of series, of mirrored cells, of formats that nobody writes any more, and of files that hold no grid. What
// VTK can write itself is in tests/vtk/import_what_vtk_writes.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "data/files.h"
#include "support/sample_files.h"

namespace isostrata {
namespace {

using test::Scratch;

TEST(ImportFormats, CellsOfBothOrientationsKeepVtksOrder) {
  const Scratch scratch;
  for (testing::SampleMesh& mesh : testing::sample_meshes(2)) {
    if (mesh.name != "voxels" && mesh.name != "wedges" && mesh.name != "mixed" && mesh.name != "quadratic_hexahedra" &&
        mesh.name != "quadratic_tetrahedra")
      continue;
    const auto signed_volume = [&] {
      const auto data = test::open(scratch.write("x.vtu", mesh.vtu.text()));
      double sum = 0;
      for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) sum += test::cell_volume(data->grid, cell);
      return sum;
    };
    const double upright = signed_volume();
    for (Vec3d& p : mesh.vtu.points) p.z = -p.z;
    EXPECT_NEAR(signed_volume(), -upright, 1e-12) << mesh.name;
    if (mesh.name != "mixed") {
      EXPECT_NEAR(std::abs(upright), mesh.volume, 1e-12) << mesh.name;
    }
  }
}

TEST(ImportFormats, StepsOfASeriesAreThoseOfItsFiles) {
  const Scratch scratch;
  testing::write_sample_files(scratch);
  for (const std::string name : {"still", "moving"})
    for (int step = 0; step < 3; ++step) {
      const auto series = test::open(scratch / (name + ".pvd"), step);
      const auto file = test::open(scratch / (name + "_" + std::to_string(step) + (name == "still" ? ".vti" : ".vtu")));
      EXPECT_EQ(series->step, step);
      EXPECT_EQ(series->times, name == "still" ? (std::vector<double>{0, 0.5, 1}) : (std::vector<double>{10, 11, 12}));
      ASSERT_EQ(series->grid.point_count(), file->grid.point_count());
      ASSERT_EQ(series->arrays.size(), file->arrays.size());
      for (std::int64_t p = 0; p < file->grid.point_count(); ++p) {
        ASSERT_EQ(series->grid.point(p), file->grid.point(p));
        for (const PointArray& array : file->arrays)
          ASSERT_EQ(series->array(array.name).at(static_cast<std::size_t>(p)), array.at(static_cast<std::size_t>(p)));
      }
    }
  OpenOptions beyond;
  beyond.step = 3;
  EXPECT_EQ(test::refusal(scratch / "still.pvd", beyond).code(), ErrorCode::not_found);
  beyond.step = 1;
  EXPECT_EQ(test::refusal(scratch / "still_0.vti", beyond).code(), ErrorCode::not_found);
}

TEST(ImportFormats, AnArrayWithoutANameIsNamedByItsPlaceInEveryStep) {
  const Scratch scratch;
  const auto file = [&](const std::string& name, double value, const std::string& first, const std::string& cell) {
    const auto array = [](const std::string& of, double v, std::size_t count) { return testing::data_array(of, "Float64", std::vector<double>(count, v)); };
    return scratch.write(name, testing::vti_text({0, 0, 0}, {2, 2, 2}, array(first, value, 8) + array("heat", 7, 8), array(cell, value + 1, 1)));
  };
  file("s_1.vti", 10, "Array 0x10f5d7f0", "Array 0x10b1d0b0");  // as VTK's writers have them
  file("s_2.vti", 20, "Array 0x7ffe0a80", "Array 0x10f5d7f0");
  for (const int step : {0, 1}) {
    const auto data = test::open(scratch / "s_*.vti", step);
    std::vector<std::string> names;
    for (const PointArray& array : data->arrays) names.push_back(array.name);
    EXPECT_EQ(names, (std::vector<std::string>{"array 1", "heat", "array 3"}));
    EXPECT_EQ(data->array("array 1").lower, 10 * (step + 1));
    EXPECT_EQ(data->array("array 3").lower, 10 * (step + 1) + 1);
  }
}

/// Kaufman's VolVis: a header of words, then slices of bytes, whole or in runs.
std::string slc(bool runs) {
  std::string out = "11111\n5 4 3\n8\n1 2 0.5\n3\n0\n0\n" + std::to_string(runs) + "\n1 1 XRGB";  // with an icon of one pixel
  for (int k = 0; k < 3; ++k) {
    std::string slice;
    for (int p = 0; p < 20; ++p) slice += static_cast<char>(p < 8 ? 200 + k : 11 * p + k);
    if (!runs) {
      out += slice;
      continue;
    }
    // Eight times the first byte, then twelve as they are, then the end.
    const std::string packed = std::string(1, '\x08') + slice[0] + static_cast<char>(0x80 | 12) + slice.substr(8) + std::string(1, '\0');
    out += std::to_string(packed.size()) + " X" + packed;
  }
  return out;
}

TEST(ImportFormats, SlcVolumesWholeOrInRuns) {
  const Scratch scratch;
  for (const bool runs : {false, true}) {
    const auto data = test::open(scratch.write("x.slc", slc(runs)));
    ASSERT_EQ(data->grid.dims(), (std::array<std::int64_t, 3>{5, 4, 3})) << runs;
    EXPECT_EQ(data->grid.point(59), (Vec3d{4, 6, 1})) << runs;
    const PointArray& array = data->arrays.at(0);
    ASSERT_EQ(array.type, ScalarType::uint8) << runs;
    for (std::size_t p = 0; p < 60; ++p)
      ASSERT_EQ(array.at(p), p % 20 < 8 ? 200 + p / 20 : (11 * (p % 20) + p / 20) % 256) << runs << " " << p;
  }
}

TEST(ImportFormats, AMetaImageIsKnownByItsFirstLineWhateverItsName) {
  const Scratch scratch;
  const std::string text = "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nabcdefgh";
  for (const char* name : {"a", "a.dat", "a.mha"}) {
    const auto data = test::open(scratch.write(name, text));
    EXPECT_EQ(data->grid.point_count(), 8) << name;
    EXPECT_EQ(data->arrays.front().lower, 'a') << name;
    EXPECT_EQ(data->arrays.front().upper, 'h') << name;
  }
}

TEST(ImportFormats, WhatHoldsNoGridIsRefused) {
  const Scratch scratch;
  const std::string head = "# vtk DataFile Version 3.0\nmade by a test\nASCII\n";
  EXPECT_EQ(test::refusal(scratch.write("field.vtk", head + "FIELD data 1\nf 1 2 float\n1 2\n")).code(), ErrorCode::bad_data);
  EXPECT_EQ(test::refusal(scratch.write("surface.vtk", head + "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
                                                              "POLYGONS 1 4\n3 0 1 2\n"))
                .code(),
            ErrorCode::unsupported);
  EXPECT_EQ(test::refusal(scratch.write("pieces.pvtp", testing::vtk_file("PPolyData", "<PPolyData GhostLevel=\"0\"/>"))).code(),
            ErrorCode::unsupported);
  for (const std::string axes : {"dimension: 2\nsizes: 4 5\n", "dimension: 3\nsizes: 3 4 5\nkinds: vector domain domain\n",
                                 "dimension: 4\nsizes: 4 5 6 2\nkinds: space space space time\n"})
    EXPECT_EQ(test::refusal(scratch.write("x.nhdr", "NRRD0004\ntype: uchar\n" + axes + "encoding: raw\ndata file: absent.raw\n")).code(),
              ErrorCode::not_found)
        << axes;
}

}  // namespace
}  // namespace isostrata
