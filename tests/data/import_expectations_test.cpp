// The readers against others' files: what is in each, as VTK and the files' authors say.
#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <optional>

#include "data/files.h"

namespace isostrata {
namespace {

struct Expected {
  const char* file;
  const char* grid;
  std::int64_t points;
  std::map<std::string, std::int64_t> cells;
  struct Array {
    const char* name;
    ScalarType type;
    double lower, upper;  // to six digits
    Association association = Association::point;
  };
  std::vector<Array> arrays;  // some of them
  std::size_t times = 1;
};

void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.file; }

constexpr auto u8 = ScalarType::uint8;
constexpr auto i8 = ScalarType::int8;
constexpr auto i16 = ScalarType::int16;
constexpr auto u16 = ScalarType::uint16;
constexpr auto i32 = ScalarType::int32;
constexpr auto f32 = ScalarType::float32;
constexpr auto f64 = ScalarType::float64;
constexpr auto averaged = Association::cell_averaged;

std::map<std::string, std::int64_t> hexahedra(std::int64_t n) { return {{"hexahedron", n}}; }
std::map<std::string, std::int64_t> tetrahedra(std::int64_t n) { return {{"tetrahedron", n}}; }

const std::vector<Expected>& expectations() {
  static const std::vector<Expected> table{
      {"plot3d_bluntfin/bluntfinxyz.bin",
       "curvilinear",
       40960,
       hexahedra(37479),
       {{"Density", f32, 0.1926, 4.9775}, {"Momentum", f32, 0, 6.25568}, {"StagnationEnergy", f32, 0.768957, 25.161}}},
      {"plot3d_comb/combxyz.bin",
       "curvilinear",
       47025,
       hexahedra(43008),
       {{"Density", f32, 0.197813, 0.710419}, {"Momentum", f32, 0, 446.741}, {"StagnationEnergy", f32, 0, 0}}},
      {"plot3d_post/postxyz.bin",
       "curvilinear",
       109744,
       hexahedra(102675),
       {{"IBlank", i32, -1, 1},
        {"Density", f32, 1, 1},
        {"Momentum", f32, 0, 1.39144},
        {"StagnationEnergy", f32, -0.541506, 4.39584}}},
      {"plot3d_variants/multi-ascii.xyz", "unstructured", 2160, hexahedra(1694), {{"Density", f64, 0.19896, 4.8283}}},
      {"plot3d_variants/multi-bin.xyz",
       "unstructured",
       2160,
       hexahedra(1694),
       {{"Density", f64, 0.19896, 4.8283}, {"Function 0", f64, 0.19896, 4.8283}}},
      {"plot3d_variants/multi-bin-C.xyz", "unstructured", 2160, hexahedra(1694), {{"Density", f64, 0.19896, 4.8283}}},
      {"plot3d_variants/multi-bin-oflow.q",
       "unstructured",
       2160,
       hexahedra(1694),
       {{"Density", f64, 0.19896, 4.8283}, {"StagnationEnergy", f64, 0.788637, 24.0777}}},
      {"plot3d_variants/multi-bin.f",
       "unstructured",
       2160,
       hexahedra(1694),
       {{"Function 0", f64, 0.19896, 4.8283}, {"Function 1", f64, 0.788637, 24.0777}}},
      {"plot3d_variants/multi-bin-2D.xyz", "unstructured", 357, {{"quadrilateral", 320}}, {{"Density", f64, 0.26623, 2.694}}},
      {"plot3d_variants/mbwavelet_ascii.xyz", "unstructured", 1331, hexahedra(900), {{"Density", f64, 37.3531, 260}}},
      {"vtk_ironprot/ironProt.vtk", "uniform", 314432, hexahedra(300763), {{"scalars", u8, 0, 255}}},
      {"vtk_office/office.binary.vtk",
       "curvilinear",
       8400,
       hexahedra(7220),
       {{"scalars", f32, -3.86956, 0.71856}, {"vectors", f32, 0, 0.804935}}},
      {"vtk_office/kitchen.vtk", "curvilinear", 11424, hexahedra(9936), {{"velocity", f32, 0, 0.452266}}},
      {"vtk_carotid/carotid.vtk", "uniform", 167580, hexahedra(158400), {{"scalars", f32, 0, 580}, {"vectors", f32, 0, 22.6949}}},
      {"vtk_cth/cth.vtr", "rectilinear", 545025, hexahedra(524288), {{"Void Volume Fraction", f32, 0, 1, averaged}}},
      {"vtk_rectgrid/RectGrid2.vtk",
       "rectilinear",
       17061,
       hexahedra(14720),
       {{"scalars", f32, 0, 10.3964}, {"vectors", f32, 0, 10.3964}}},
      {"vtk_rectgrid/SampleStructGrid.vtk", "curvilinear", 24000, hexahedra(21489), {{"scalars", f64, 0, 1.30456}}},
      {"vtk_rectgrid/HeadMRVolume.mhd", "uniform", 124992, hexahedra(117547), {{"MetaImage", u8, 0, 255}}},
      {"vol_embryo256/embryo256.vti", "uniform", 16777216, hexahedra(16581375), {{"SLCImage", u8, 0, 197}}},
      {"vol_heptane302/heptane302.nrrd", "uniform", 27543608, hexahedra(27270901), {{"scalars", u8, 0, 255}}},
      {"vol_hydrogen/hydrogen.vti", "uniform", 262144, hexahedra(250047), {{"probability_density", f32, 0, 1}}},
      {"vol_neghip/neghip.nrrd", "uniform", 287496, hexahedra(274625), {{"scalars", u8, 0, 255}}},
      {"vol_neghip/neghip.slc", "uniform", 287496, hexahedra(274625), {{"SLCImage", u8, 0, 255}}},
      {"vol_headsq/headsq.vti", "uniform", 380928, hexahedra(365148), {{"ImageFile", i16, 0, 3926}}},
      {"ts_tornado/tornado.pvd",
       "uniform",
       110592,
       hexahedra(103823),
       {{"u", f32, -0.308206, 0.305503}, {"speed", f32, 0.0298344, 0.312684}},
       10},
      {"exo_mug_transient/mug.pvd", "unstructured", 3774, hexahedra(2476), {{"convected", f64, 0, 0}}, 21},
      {"exo_mug_transient/mug.e", "unstructured", 3774, hexahedra(2476), {{"convected", f64, 0, 0}}, 21},
      {"exo_mug_transient/mug_01.vtu",
       "unstructured",
       3774,
       hexahedra(2476),
       {{"convected", f64, 0, 1}, {"diffused", f64, 0, 2}}},
      {"exo_disk_out_ref/disk_out_ref.ex2",
       "unstructured",
       8499,
       hexahedra(7472),
       {{"Temp", f64, 293.15, 913.15}, {"V", f64, 0, 22.4188}, {"Pres", f64, 0.00678552, 0.0288185}}},
      {"exo_disk_out_ref/disk_out_ref.vtu",
       "unstructured",
       8499,
       hexahedra(7472),
       {{"Temp", f64, 293.15, 913.15}, {"CH4", f64, 0, 0.00117024}, {"H2", f64, 0.807613, 0.917688}}},
      {"exo_can/can.vtu",
       "unstructured",
       6724,
       hexahedra(4800),
       {{"DISPL", f64, 2.46112, 18.5944}, {"VEL", f64, 2006.42, 5221.33}, {"ACCL", f64, 240352, 2.01941e+08}}},
      {"ug_fire/fire_ug.vtu",
       "unstructured",
       12323,
       hexahedra(10462),
       {{"t", f32, 298.381, 692.24}, {"uvw", f32, 0.0099482, 3.82231}, {"mfrac", f32, 0, 0.51559}}},
      {"ug_aneurysm_fem/output_fem.vtu",
       "unstructured",
       21332,
       {{"tetrahedron", 63008}, {"wedge", 16748}},
       {{"p", f64, -5.37829, 369.059}, {"Umag", f64, 0, 0.521671}}},
      {"ug_post_tets/post.vtk", "unstructured", 2288, tetrahedra(8750), {{"Pressure", f32, 0.355368, 1.64124}}},
      {"ug_post_tets/tetraMesh.vtk", "unstructured", 55, tetrahedra(160), {{"scalars", i32, 0, 4}}},
      {"ug_patch_antenna/patch_antenna.vtu",
       "unstructured",
       1464,
       tetrahedra(3997),
       {{"ElectricField", f32, 10.0121, 24061.5}, {"MagneticField", f32, 0.0483244, 14.6477}}},
      {"ug_notch/notch_stress_fixed.vtk",
       "unstructured",
       3537,
       {{"hexahedron", 2188}, {"wedge", 4}},
       {{"Nodal Stress", f64, 3206.61, 8.1098e+06}, {"Nodal Stress_0", f64, -145362, 8.10777e+06}}},
      {"ug_notch/notch_disp.vtu",
       "unstructured",
       12717 + 10018,  // and the middles of hexahedra and of their faces
       {{"hexahedron", 8 * 2188}, {"wedge", 8 * 4}},
       {{"Nodal Displacement", f64, 0, 2.79363e-06}}},
      {"vtk_cells/AngularSector.vtk", "unstructured", 10141, {{"hexahedron", 7632}, {"pyramid", 144}}, {}},
      {"vtk_cells/CylinderLinear.vtk",
       "unstructured",
       465,
       tetrahedra(1522),
       {{"velocity", f64, 0, 1.0044}, {"vel_norm", f64, 0, 1.0044}}},
      {"vtk_cells/PentaHexa.vtk", "unstructured", 401 + 210, {{"pyramid", 960}, {"tetrahedron", 1644}}, {{"scalar2", f32, 0, 1}}},
      {"vtk_cells/QuadraticPyramid.vtu", "unstructured", 153 + 36, {{"pyramid", 6 * 48}, {"tetrahedron", 4 * 48}}, {{"Polynomial", f32, 1, 7}}},
      {"vtk_cells/QuadraticTetra.vtu", "unstructured", 189, tetrahedra(8 * 96), {{"DistanceToCenter", f32, 0, 1.73205}}},
      {"vtk_cells/QuadraticWedge.vtu", "unstructured", 93 + 32, {{"wedge", 8 * 16}}, {{"DistanceToCenter", f32, 0, 1.73205}}},
      {"vtk_cells/Tetrahedron.vtu", "unstructured", 35, tetrahedra(96), {{"Polynomial", f32, 1, 7}}},
      {"vtk_cells/Wedge.vtu", "unstructured", 27, {{"wedge", 16}}, {{"Polynomial", f32, 1, 7}}},
      {"vtk_cells/VTKCellTypes.vtk",
       "unstructured",
       27,
       {{"hexahedron", 2}, {"tetrahedron", 1}},
       {{"scalars", f32, 0, 26}, {"vectors", f32, 1, 2}}},
      {"vtk_cells/uGridEx.vtk", "unstructured", 27, {{"hexahedron", 2}, {"tetrahedron", 2}}, {{"scalars", f32, 0, 26}}},
      {"vtk_cells/hexa.vtk", "unstructured", 12167, hexahedra(10648), {{"scalars", f32, 0.753065, 17.3205}}},
      {"vtk_cells/polyhedron2pieces.vtu", "unstructured", 18, {{"pyramid", 2}, {"hexahedron", 2}}, {}},
      {"vtk_cells/tensors.vtk",
       "unstructured",
       8,
       hexahedra(1),
       {{"scalars", f32, 0, 4}, {"other_scalars", f32, 0, 7}, {"tensors1", f32, 0, 4.79583}}},
      {"fmt_vtk_variants/hexahedron_ascii.vtu",
       "unstructured",
       8,
       hexahedra(1),
       {{"uint16x1", u16, 40, 47}, {"float64x1", f64, 1, 128}, {"uint8x1 (cell)", f32, 40, 40, averaged}}},
      {"fmt_vtk_variants/volume_complex.vtk", "uniform", 72, hexahedra(30), {{"volume_scalars", i8, 0, 50}}},
      {"fmt_vtk_variants/volume_complex.vti", "uniform", 72, hexahedra(30), {}},
      {"fmt_vtk_variants/structured_grid.vtk",
       "curvilinear",
       8,
       hexahedra(1),
       {{"ptval", f32, 0, 7}, {"cellval", f32, 1489, 1489, averaged}}},
      {"fmt_vtk_variants/rectilinear_grid.vtk", "rectilinear", 12, {{"quadrilateral", 6}}, {}},
      {"fmt_vtk_variants/RectilinearGrid.pvtr", "rectilinear", 16, hexahedra(3), {{"X Velocity", f32, 0, 1.4, averaged}}},
      {"fmt_vtk_variants/hexahedron_parallel.pvtu", "unstructured", 8, hexahedra(1), {}},
      {"fmt_vtk_variants/hexahedron_parallel_lzma.pvtu", "unstructured", 8, hexahedra(1), {}},
      {"fmt_vtk_variants/unstructured_grid_complex.vtk",
       "unstructured",
       27,
       {{"tetrahedron", 2 + 8}, {"hexahedron", 2}},
       {}},  // one is quadratic
  };
  return table;
}

bool near(double value, double expected) { return std::abs(value - expected) <= 1e-5 * std::max(std::abs(expected), 1e-12); }

class Expectation : public ::testing::TestWithParam<Expected> {};

TEST_P(Expectation, IsMet) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const Expected& expected = GetParam();
  const auto data = test::open(test::shared_data() / expected.file);
  EXPECT_STREQ(data->grid.kind_name(), expected.grid);
  EXPECT_EQ(data->grid.point_count(), expected.points);
  EXPECT_EQ(data->cell_types, expected.cells);
  EXPECT_EQ(data->times.size(), expected.times);
  for (const auto& wanted : expected.arrays) {
    const PointArray& array = data->array(wanted.name);
    EXPECT_EQ(array.type, wanted.type) << wanted.name;
    EXPECT_EQ(array.association, wanted.association) << wanted.name;
    EXPECT_TRUE(near(array.lower, wanted.lower)) << wanted.name << " " << array.lower << ", expected " << wanted.lower;
    EXPECT_TRUE(near(array.upper, wanted.upper)) << wanted.name << " " << array.upper << ", expected " << wanted.upper;
  }
}

std::string test_name(const ::testing::TestParamInfo<Expected>& info) {
  std::string name = info.param.file;
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(SharedData, Expectation, ::testing::ValuesIn(expectations()), test_name);

TEST(SharedDataImport, EncodingsOfOneMeshAgree) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  for (const auto& [pattern, cells] : std::map<std::string, std::string>{{"RectilinearGrid", ".vtr"}, {"hexahedron", ".vtu"}}) {
    std::optional<Box3d> bounds;
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(test::shared_data() / "fmt_vtk_variants")) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(pattern) || entry.path().extension() != cells) continue;
      const auto data = test::open(entry.path());
      if (!bounds) bounds = data->bounds;
      EXPECT_EQ(data->bounds.lower, bounds->lower) << name;
      EXPECT_EQ(data->bounds.upper, bounds->upper) << name;
      ++files;
    }
    EXPECT_GE(files, 5) << pattern;
  }
}

TEST(SharedDataImport, VectorsBecomeMagnitudeAndComponents) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto data = test::open(test::shared_data() / "plot3d_bluntfin" / "bluntfinxyz.bin");
  const PointArray& magnitude = data->array("Momentum");
  EXPECT_EQ(magnitude.components, 3);
  EXPECT_EQ(magnitude.component, "magnitude");
  EXPECT_EQ(data->array("Momentum_y").component, "y");
  EXPECT_EQ(data->array("Density").component, "");
  for (std::size_t p = 0; p < 40960; p += 17) {
    const Vec3d m{data->array("Momentum_x").at(p), data->array("Momentum_y").at(p), data->array("Momentum_z").at(p)};
    EXPECT_NEAR(magnitude.at(p), length(m), 1e-6 * (1 + length(m)));
  }
}

TEST(SharedDataImport, CellsOfBothOrientationsKeepVtksOrder) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto sign = [](const char* file) {
    const auto data = test::open(test::shared_data() / file);
    double volume = 0;
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) volume += test::cell_volume(data->grid, cell);
    return volume;
  };
  EXPECT_NEAR(sign("vtk_cells/Cells_Voxel.vtu"), 1, 1e-6);
  EXPECT_NEAR(sign("vtk_cells/Cells_Hexahedron.vtu"), 1, 1e-6);
  EXPECT_NEAR(sign("vtk_cells/Tetrahedron.vtu"), 8, 1e-5);
  EXPECT_NEAR(std::abs(sign("vtk_cells/Wedge.vtu")), 8, 1e-5);
  EXPECT_NEAR(std::abs(sign("vtk_cells/QuadraticPyramid.vtu")), 8, 1e-5);
  EXPECT_LT(sign("ug_fire/fire_ug.vtu"), 0);
}

TEST(SharedDataImport, StepsOfATimeSeriesAreThoseOfItsFiles) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto folder = test::shared_data() / "ts_tornado";
  const auto series = test::open(folder / "tornado.pvd", 9), last = test::open(folder / "tornado_10.vti");
  EXPECT_EQ(series->step, 9);
  EXPECT_EQ(series->array("u").lower, last->array("u").lower);
  const auto exodus = test::open(test::shared_data() / "exo_mug_transient/mug.e", 20);
  EXPECT_EQ(exodus->times.front(), 0);
  EXPECT_NEAR(exodus->times.back(), 2, 1e-12);
  EXPECT_NEAR(exodus->array("diffused").upper, 2, 1e-6);
  OpenOptions beyond;
  beyond.step = 10;
  EXPECT_EQ(test::refusal(folder / "tornado.pvd", beyond).code(), ErrorCode::not_found);
  beyond.step = 1;
  EXPECT_EQ(test::refusal(folder / "tornado_10.vti", beyond).code(), ErrorCode::not_found);
}

TEST(SharedDataImport, SaysWhatItSkippedOrChanged) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto notes = test::open(test::shared_data() / "vtk_cells/Cells_Polygon.vtu")->notes;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("1 vtkPolygon read as 4 triangles"), std::string::npos) << notes[0];
  const auto quadratic = test::open(test::shared_data() / "vtk_cells/QuadraticTetra.vtu")->notes;
  ASSERT_EQ(quadratic.size(), 1u);
  EXPECT_NE(quadratic[0].find("96 vtkQuadraticTetra divided into 768 linear cells between their nodes"), std::string::npos) << quadratic[0];
}

TEST(SharedDataImport, HidesNoCellOfPostWhoseBlankingIsNeverZero) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  EXPECT_TRUE(test::open(test::shared_data() / "plot3d_post/postxyz.bin")->grid.hidden_cells.empty());
}

TEST(SharedDataImport, RefusesWhatHoldsNoVolume) {
  ISOSTRATA_NEEDS_SHARED_DATA();
  const auto folder = test::shared_data() / "fmt_vtk_variants";
  for (const char* name : {"point.vtp", "polyEx0.vtp", "cube.pvtp", "square.vtk", "tri.vtk", "cube_complex.vtk"})
    EXPECT_EQ(test::refusal(folder / name).code(), ErrorCode::unsupported) << name;
  EXPECT_EQ(test::refusal(folder / "field.vtk").code(), ErrorCode::bad_data);
  for (const auto& entry : std::filesystem::directory_iterator(test::shared_data() / "fmt_nrrd_variants" / "headers"))
    EXPECT_EQ(test::refusal(entry.path()).code(), ErrorCode::not_found) << entry.path();
}

}  // namespace
}  // namespace isostrata
