// Files that other programs' libraries write (tests/formats/write_files.py): the importer reads what was written, and the table of docs/formats.md is that of the
// readers. What VTK's own writers write is in tests/vtk.
#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <random>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>

#include "data/files.h"
#include "data/files/file_formats.h"
#include "data/files/recognise.h"
#include "data/files/referred_names.h"
#include "data/open/import_door.h"
#include "support/mutated_files.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace json = boost::json;
using test::Scratch;

/// All of them, in a folder. deploy/setup installs what the script needs with Debian's Python.
class ForeignFormats : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::string command = "/usr/bin/python3 '" + places::source() + "/tests/formats/write_files.py' '" + folder_.path().string() + "/f' 2>'" +
                                (folder_ / "errors").string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0) << test::read_bytes(folder_ / "errors")
                                               << "\nthe packages of group test in deploy/packages.txt are needed: deploy/setup test";
    facts_ = json::parse(test::read_bytes(folder_ / "f/facts.json")).as_object();
  }
  std::filesystem::path file(const std::string& name) const { return folder_.path() / "f" / name; }

  Scratch folder_;
  json::object facts_;
};

double number(const json::value& value) { return value.to_number<double>(); }

void expect_facts(const Dataset& data, const json::object& facts) {
  EXPECT_EQ(data.grid.kind_name(), std::string(facts.at("grid").as_string()));
  EXPECT_EQ(data.grid.point_count(), facts.at("points").as_int64());
  EXPECT_EQ(data.grid.cell_count(), facts.at("cells").as_int64());
  std::vector<double> times;
  for (const json::value& time : facts.at("times").as_array()) times.push_back(number(time));
  EXPECT_EQ(data.times, times);
  const json::array& bounds = facts.at("bounds").as_array();
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(data.bounds.lower[a], number(bounds.at(static_cast<std::size_t>(2 * a))), 1e-9) << "axis " << a;
    EXPECT_NEAR(data.bounds.upper[a], number(bounds.at(static_cast<std::size_t>(2 * a + 1))), 1e-9) << "axis " << a;
  }
  for (const auto& [name, range] : facts.at("arrays").as_object()) {
    const PointArray& array = data.array(std::string_view(name));
    EXPECT_EQ(array.lower, number(range.at(0))) << name;
    EXPECT_EQ(array.upper, number(range.at(1))) << name;
    EXPECT_EQ(array.nan_count, range.at(2).as_int64()) << name;
  }
  const json::array& at = facts.at("at").as_array();
  const Vec3d place{number(at[0]), number(at[1]), number(at[2])};
  int found = 0;
  for (std::int64_t p = 0; p < data.grid.point_count(); ++p) {
    if (length(data.grid.point(p) - place) > 1e-6) continue;
    ++found;
    EXPECT_EQ(data.array(std::string_view(at[3].as_string())).at(static_cast<std::size_t>(p)), number(at[4])) << at[3].as_string();
  }
  EXPECT_EQ(found, 1) << "points at " << place.x << " " << place.y << " " << place.z;
}

TEST_F(ForeignFormats, HoldWhatWasWritten) {
  ASSERT_GE(facts_.size(), 30u);
  for (const auto& [key, facts] : facts_) {
    SCOPED_TRACE(std::string(key));
    const std::string name(key.substr(0, key.find('@')));
    const int step = key.find('@') == json::string_view::npos ? 0 : std::stoi(std::string(key.substr(key.find('@') + 1)));
    ASSERT_NO_THROW(expect_facts(*test::open(file(name), step), facts.as_object())) << [&] {
      try {
        test::open(file(name), step);
      } catch (const Error& error) {
        return std::string(error.what());
      }
      return std::string();
    }();
  }
}

TEST_F(ForeignFormats, UnitsAreThoseOfTheFiles) {
  const std::tuple<const char*, const char*, const char*> units[] = {
      {"of_root.nc", "T", "K"}, {"climate.zarr", "T", "K"}, {"climate.zarr", "packed", ""}, {"climate3.zarr", "T", "K"}, {"parted", "p", "m2/s2"}, {"collated_binary", "p", "m2/s2"},
      {"sizes.h5", "t0/channel0", "counts"}, {"sizes.h5", "t0/other", "V"}, {"CHGCAR", "charge density", "e/Å³"}, {"LOCPOT", "potential", "eV"}, {"box.med", "TEMP", "K"}, {"boxes.inp", "v_x", "m/s"}, {"box.med", "SIEF_x", "Pa"}, {"inviwo.dat", "scalars", "K"}};
  for (const auto& [name, array, unit] : units) EXPECT_EQ(test::open(file(name))->array(array).unit, unit) << name << ": " << array;
}

TEST_F(ForeignFormats, AxesAreThoseOfTheFiles) {
  struct Said {
    const char *name, *x, *y, *z;
    bool downward = false;
  };
  for (const Said& of : {Said{"lon_first.nc", "lon (degrees_east)", "lat (degrees_north)", "lev (hPa)", true}, Said{"lat_first.nc", "lon", "lat", "lev"}, Said{"millibars.nc", "x", "y", "air pressure (millibars)", true},
                         Said{"pascals.nc", "x", "y", "z (Pa)", true}, Said{"down.nc", "x", "y", "z", true}, Said{"four.nc", "lon (degrees_east)", "lat (degrees_north)", "lev (m)"},
                         Said{"climate.zarr", "lon (degrees_east)", "lat (degrees_north)", "lev (m)"}, Said{"deep.nc", "longitude (degrees_east)", "latitude (degrees_north)", "deep (m)", true},
                         Said{"coast_nodes.nc", "longitude (degrees_east)", "latitude (degrees_north)", "depth (m)", true}, Said{"coast_faces.nc", "longitude (degrees_east)", "latitude (degrees_north)", "altitude (m)"}, Said{"of_root.nc", "lon (degrees_east)", "lat (degrees_north)", "lev (m)"}, Said{"scaled.nii", "x (mm)", "y (mm)", "z (mm)"}, Said{"orbitals.cube", "x (Bohr)", "y (Bohr)", "z (Bohr)"},
                         Said{"CHGCAR", "x (Angstrom)", "y (Angstrom)", "z (Angstrom)"}, Said{"grids.xsf", "x (Angstrom)", "y (Angstrom)", "z (Angstrom)"}, Said{"head.mgh", "x (mm)", "y (mm)", "z (mm)"},
                         Said{"scan/picture1.dcm", "x (mm)", "y (mm)", "z (mm)"}, Said{"parted", "x (m)", "y (m)", "z (m)"}, Said{"sizes.h5", "x (µm)", "y (µm)", "z (µm)"}, Said{"box.med", "x (m)", "y (m)", "z (m)"}, Said{"plain.mif", "x (mm)", "y (mm)", "z (mm)"}, Said{"plain.h5", "x", "y", "z"}}) {
    const auto data = test::open(file(of.name));
    EXPECT_EQ(axis_title(data->axes, 0), of.x) << of.name;
    EXPECT_EQ(axis_title(data->axes, 1), of.y) << of.name;
    EXPECT_EQ(axis_title(data->axes, 2), of.z) << of.name;
    EXPECT_EQ(data->axes[2].downward, of.downward) << of.name;
  }
}

TEST_F(ForeignFormats, ZarrHasTheValuesOfTheSameNumpyArrayWhateverPacksThem) {
  int pairs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "f")) {
    if (entry.path().extension() != ".npy" || !entry.path().filename().string().starts_with("same_")) continue;
    SCOPED_TRACE(entry.path().filename().string());
    const auto numpy = test::open(entry.path()), zarr = test::open(std::filesystem::path(entry.path()).replace_extension(".zarr"));
    ASSERT_EQ(zarr->grid.dims(), numpy->grid.dims());
    const PointArray &expected = numpy->arrays.front(), &found = zarr->arrays.front();
    EXPECT_EQ(found.type, expected.type);
    std::size_t different = 0;
    for (std::size_t p = 0; p < static_cast<std::size_t>(numpy->grid.point_count()); ++p) different += found.at(p) != expected.at(p);
    EXPECT_EQ(different, 0u);
    ++pairs;
  }
  EXPECT_GE(pairs, 11);
}

TEST_F(ForeignFormats, NetcdfAndHdf5ThatAreRefusedSayWhy) {
  for (const auto& [name, code, what] : {std::tuple{"mesh.nc", ErrorCode::unsupported, "UGRID convention that has no faces"}, {"no_time.nc", ErrorCode::bad_data, "time 1 of 'time' is not a finite number"},
                                         {"atoms.nc", ErrorCode::unsupported, "particles (AMBER)"}, {"no_steps.nc", ErrorCode::bad_data, "'time' has length 0"}, {"no_steps_nor_times.nc", ErrorCode::bad_data, "'time' has length 0"},
                                         {"lists.h5", ErrorCode::unsupported, "lists of points or cells ('Mesh/topology', 2000 x 4)"}, {"only_empty.h5", ErrorCode::unsupported, "without an array of two or three axes of numbers (the largest, 'a', has 0 x 4 x 5)"},
                                         {"members.nc", ErrorCode::unsupported, "take one place along each of the others ('ncks -d AXIS,0 IN OUT')"}, {"no_size.ims", ErrorCode::bad_data, "ImageSizeX '' of its first channel"}, {"packed.h5", ErrorCode::unsupported, "packed by filter 32000 (lzf)"},
                                         {"no_corners.nc", ErrorCode::unsupported, "say no corners (bounds of 'lon'); put it on longitudes and latitudes: cdo remapnn"}}) {
    const Error error = test::refusal(file(name));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

TEST(Netcdf, ANameThatIsLongerThanItsLibraryKnowsIsRefused) {
  const auto whole = [](std::uint32_t number) {
    std::string out;
    for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(number >> shift & 0xff);
    return out;
  };
  const Scratch scratch;
  for (const std::uint32_t length : {256u, 260u, 4000u}) {
    const std::string axes = whole(10) + whole(3) + whole(length) + std::string(length, 'd') + whole(2) + whole(4) + "yyyy" + whole(2) + whole(4) + "xxxx" + whole(2);
    const std::string header = "CDF\1" + whole(0) + axes + whole(0) + whole(0) + whole(11) + whole(1) + whole(4) + "data" + whole(3) + whole(0) + whole(1) + whole(2) + whole(0) + whole(0) + whole(5) + whole(32);
    const std::string bytes = header + whole(static_cast<std::uint32_t>(header.size()) + 4) + std::string(32, '\0');
    const auto file = scratch.write("long.nc", bytes);
    if (length <= 256)
      EXPECT_EQ(test::open(file)->grid.point_count(), 8);
    else
      EXPECT_NE(std::string(test::refusal(file).what()).find("has a name of " + std::to_string(length) + " letters; expected at most 256"), std::string::npos) << test::refusal(file).what();
  }
}

TEST_F(ForeignFormats, BlocksOfFlashAndOfAthenaAreOneConformingGrid) {
  const auto flash = test::open(file("sedov_hdf5_chk_0001")), athena = test::open(file("blast.athdf"));
  for (const auto& data : {flash, athena}) {
    SCOPED_TRACE(data->name);
    EXPECT_EQ(data->times, std::vector<double>{2.5});
    EXPECT_EQ(data->bounds.upper, (Vec3d{8, 4, 4}));
    EXPECT_EQ(data->notes.front(), "3 levels, refined by 2: 64, 448 and 512 cells that no finer one covers");
    double volume = 0;
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) volume += test::cell_volume(data->grid, cell);
    EXPECT_NEAR(volume, 128, 1e-9);
    ASSERT_EQ(data->arrays.size(), 2u);
    EXPECT_EQ(data->array("dens").cells->lower, 0.125 * 111) << "the first of the finest cells";
    EXPECT_EQ(data->array("dens").cells->upper, 3.75 * 111) << "the last of the refined ones";
  }
  EXPECT_EQ(flash->cell_types, athena->cell_types);
  ASSERT_EQ(flash->grid.point_count(), athena->grid.point_count());
  for (const char* name : {"dens", "pres"})
    for (std::size_t p = 0; p < static_cast<std::size_t>(flash->grid.point_count()); ++p) ASSERT_NEAR(flash->array(name).at(p), athena->array(name).at(p), 1e-4) << name << " at point " << p;
}

TEST_F(ForeignFormats, BlocksThatAreRefusedSayWhy) {
  for (const auto& [name, code, what] : {std::tuple{"stretched.athdf", ErrorCode::unsupported, "not of one size along x1"}, {"damaged_hdf5_chk_0001", ErrorCode::bad_data, "'bounding box' has 3x2x2 numbers"},
                                         {"far_hdf5_chk_0001", ErrorCode::bad_data, "box 0 and box 1 are of one level and overlap"}}) {
    const Error error = test::refusal(file(name));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

TEST_F(ForeignFormats, XdmfThatIsRefusedSaysWhy) {
  for (const auto& [name, code, what] : {std::tuple{"no_array.xdmf", ErrorCode::bad_data, "'run.h5:/nothing', which is not an array of numbers"}, {"outside.xdmf", ErrorCode::bad_data, "'../run.h5'; expected a file below its own directory"},
                                         {"other_size.xdmf", ErrorCode::bad_data, "'/all' has 3 x 120 values; the file says 7"}, {"short.xdmf", ErrorCode::bad_data, "'p' has 2 values for 3 points"},
                                         {"cut_off.xdmf", ErrorCode::bad_data, "from byte 1432 of 'numbers.bin', which has 1443"}, {"huge.xdmf", ErrorCode::bad_data, "a size of 4000000000"},
                                         {"beyond.xdmf", ErrorCode::bad_data, "takes 3 places from 118"}, {"computes.xdmf", ErrorCode::unsupported, "the function '$0 + $1'"},
                                         {"round.xdmf", ErrorCode::bad_data, "references to references"}, {"no_grid.xdmf", ErrorCode::bad_data, "no Grid"},
                                         {"no_point.xdmf", ErrorCode::bad_data, "cell 0 uses point 3 of 3"}, {"other.xdmf", ErrorCode::bad_data, "<Mesh>; expected <Xdmf>"}}) {
    const Error error = test::refusal(file(name));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  }
}

TEST_F(ForeignFormats, WhatAnXdmfReadsIsListedWithIt) {
  for (const auto& [name, expected] : {std::pair{"dolfinx.xdmf", std::vector<std::string>{"run.h5"}}, {"axes.xmf", {"numbers.bin"}}, {"disk.athdf.xdmf", {"disk.athdf"}}, {"parts.xdmf", {"numbered_0.xmf", "numbered_1.xmf"}}, {"image.xdmf", {}}})
    EXPECT_EQ(referred_names(file(name), recognise(file(name))), expected) << name;
}

TEST_F(ForeignFormats, NetcdfKeepsItsTypesWhereNothingIsMissing) {
  const auto types = test::open(file("types.nc")), gaps = test::open(file("gaps.nc"));
  for (const auto& [name, type] : {std::pair{"of_i1", ScalarType::int8}, {"of_u1", ScalarType::uint8}, {"of_u2", ScalarType::uint16}, {"of_u4", ScalarType::uint32}, {"of_i8", ScalarType::int64}, {"of_u8", ScalarType::uint64}, {"named", ScalarType::uint8}})
    EXPECT_EQ(types->array(std::string_view(name)).type, type) << name;
  for (const auto& [name, type] : {std::pair{"unfilled", ScalarType::int16}, {"filled_i2", ScalarType::float32}, {"filled_i4", ScalarType::float64}})
    EXPECT_EQ(gaps->array(std::string_view(name)).type, type) << name;
}

TEST_F(ForeignFormats, CellsAtPointsWithoutAPlaceAreHidden) {
  for (const auto& [name, expected] : {std::pair{"deep.nc", 4}, {"curved.zarr", 1}, {"round.nc", 0}}) {
    const auto data = test::open(file(name));
    const auto& hidden = data->grid.hidden_cells;
    EXPECT_EQ(std::count_if(hidden.begin(), hidden.end(), [](auto how) { return how != 0; }), expected) << name;
  }
}

TEST_F(ForeignFormats, LinksToNothingAreCounted) {
  const auto data = test::open(file("links.h5"));
  EXPECT_EQ(data->arrays.size(), 3u);
  EXPECT_NE(std::find(data->notes.begin(), data->notes.end(), "2 links skipped that lead to nothing"), data->notes.end());
}

TEST_F(ForeignFormats, AnExodusFileWhoseArraysVtkMissesIsRefused) {
  const Error error = test::refusal(file("unsaid.e"));
  EXPECT_EQ(error.code(), ErrorCode::unsupported);
  EXPECT_NE(std::string(error.what()).find("'file_size'"), std::string::npos) << error.what();
}

TEST_F(ForeignFormats, ElementsOfSecondOrderOfGmshCalculixAndMedFillTheirCellsAndKeepTheirValues) {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "f")) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("second_")) continue;
    SCOPED_TRACE(name);
    ++files;
    const auto data = test::open(entry.path());
    double volume = 0;
    for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
      const double piece = test::cell_volume(data->grid, cell);
      EXPECT_GT(piece * test::cell_volume(data->grid, 0), 0) << "cell " << cell << " is turned against the first";
      volume += piece;
    }
    EXPECT_NEAR(6 * std::abs(volume), std::stod(name.substr(name.rfind('_') + 1)), 1e-9);
    for (std::int64_t p = 0; p < data->grid.point_count(); ++p) {
      const Vec3d at = data->grid.point(p);
      EXPECT_NEAR(data->arrays.front().at(static_cast<std::size_t>(p)), at.x + 10 * at.y + 100 * at.z, 1e-3) << "point " << p;
    }
  }
  EXPECT_EQ(files, 14);
}

TEST_F(ForeignFormats, MeshesOfGmshAndCalculixThatAreRefusedSayWhy) {
  const auto expect = [&](const std::string& name, const std::string& from, const std::string& to, ErrorCode code, const std::string& what) {
    const std::string bytes = test::read_bytes(file(name));
    const auto at = bytes.find(from);
    ASSERT_NE(at, std::string::npos) << name << ": " << from;
    const Error error = test::refusal(folder_.write("f/wrong" + file(name).extension().string(), std::string(bytes).replace(at, from.size(), to)));
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
  };
  expect("four_text.msh", "4.1 0 8", "4 0 8", ErrorCode::unsupported, "version 4 of Gmsh's format; expected 2.2 or 4.1");
  expect("four_text.msh", "$MeshFormat", "$NOD\n1\n", ErrorCode::unsupported, "version 1 of Gmsh's format");
  expect("four_text.msh", "$EndElements", "$", ErrorCode::bad_data, "expected $EndElements");
  expect("four_text.msh", "2 120 1 5000", "2 120000 1 5000", ErrorCode::bad_data, "120000 nodes declared");
  expect("four_text.msh", "3 31 5 20", "3 31 29 20", ErrorCode::unsupported, "elements of type 29");
  expect("two_text.msh", "1001 0.0 0.0 0.0", "999 0.0 0.0 0.0", ErrorCode::bad_data, "has two nodes of number 999");
  expect("two_text.msh", "500 5 2 1 1 1001", "500 5 2 1 1 1002", ErrorCode::bad_data, "element 500 uses node 1002, which is not there");
  expect("two_text.msh", "\n60\n500 0.0", "\n60\n501 0.0", ErrorCode::bad_data, "a value for element 501, which is not there");
  expect("two_text.msh", "\"f\"\n1\n0.5\n3\n0\n1\n", "\"f\"\n1\n0.5\n3\n0\n900\n", ErrorCode::bad_data, "900 components");
  expect("two_text.msh", "\"f\"\n1\n0.5", "\"f\"\n1\nnan", ErrorCode::bad_data, "not a finite number");
  expect("points.dat", "I=6", "I=7", ErrorCode::bad_data, "ends within the numbers of a zone");
  expect("points.dat", "I=6", "I=0", ErrorCode::bad_data, "I of a zone is '0'; expected a whole number of at least 1");
  expect("points.dat", "I=6", "I=60000000000", ErrorCode::bad_data, "ends within the numbers of a zone");
  expect("blocks.tec", "59*2.5", "6000000*2.5", ErrorCode::bad_data, "repeated beyond its zone");
  expect("blocks.tec", "FEBRICK", "FEPOLYHEDRON", ErrorCode::unsupported, "a zone of type fepolyhedron");
  expect("blocks.tec", "\n1 2 8 7 ", "\n1 2 800 7 ", ErrorCode::bad_data, "element 1 of zone 1 has node 800; there are 120");
  expect("blocks.tec", "\n1 2 8 7 ", "\n1 2 0 7 ", ErrorCode::bad_data, "element 1 of zone 1 has node 0; there are 120");
  expect("steps.dat", "([1-3]=1)", "([1-3]=7)", ErrorCode::bad_data, "'7' as the number of a zone before this one");
  expect("steps.dat", "([1-3]=1)", "([1-9]=1)", ErrorCode::bad_data, "variable 5 in '([1-9]=1)'; there are 4");
  expect("ordered.plt", "#!TDV112", "#!TDV107", ErrorCode::unsupported, "version 107 of Tecplot's binary format; expected 112");
  expect("nodal.bov", "DATA_SIZE: 6 5 4", "DATA_SIZE: 6 5 9", ErrorCode::bad_data, "nodal.f32: 6x5x9 float32 declared, which is 1080 bytes in this file; 480 present");
  expect("nodal.bov", "DATA_SIZE: 6 5 4", "DATA_SIZE: 6 5", ErrorCode::bad_data, "data_size has 2 numbers; expected 3");
  expect("nodal.bov", "DATA_FORMAT: FLOAT", "DATA_FORMAT: QUAD", ErrorCode::bad_data, "DATA_FORMAT is 'quad'");
  expect("nodal.bov", "nodal.f32", "n.%04d.f32", ErrorCode::unsupported, "in several files");
  expect("nodal.bov", "nodal.f32", "../n.f32", ErrorCode::bad_data, "../n.f32");
  expect("volvis.dat", "USHORT", "HALF", ErrorCode::unsupported, "Format is 'HALF'");
  expect("volvis.dat", "6 5 4", "6 0 4", ErrorCode::bad_data, "an axis of 0 points");
  expect("plain.mif", "Float32LE", "CFloat32LE", ErrorCode::unsupported, "datatype is 'cfloat32le'");
  expect("plain.mif", "+0,+1,+2", "+0,+1,+1", ErrorCode::bad_data, "expected each of 3 places once");
  expect("plain.mif", "\nEND", "\nEN", ErrorCode::bad_data, "its header has no END");
  expect("potential.dx", "items 120", "items 121", ErrorCode::bad_data, "an array of 121 items; the grid has 120 points");
  expect("potential.dx", "counts 6 5 4\norigin", "counts 6000 5 4\norigin", ErrorCode::bad_data, "the grid has 120000 points");
  expect("potential.dx", "double rank 0 items 120", "double rank 0 items 120 binary", ErrorCode::unsupported, "binary or in another file");
  expect("plain.am", "uniform", "curvilinear", ErrorCode::unsupported, "its grid is of type \"curvilinear\"");
  expect("plain.am", "define Lattice 6 5 4", "define Nodes 6 5 4", ErrorCode::unsupported, "without a Lattice");
  expect("plain.am", "6 5 4", "6 5 40000", ErrorCode::bad_data, "Data takes 4800000 bytes");
  expect("zipped.am", "HxZip", "HxPack", ErrorCode::unsupported, "packed by 'HxPack");
  expect("labels.am", "(HxByteRLE,8)", "(HxByteRLE,6)", ErrorCode::bad_data, "the packed values of Labels are damaged");
  expect("text.am", "int Data", "byte Data", ErrorCode::bad_data, "among the numbers of Data, which are of type uint8");
  expect("boxes.inp", "\n120 61 4 1 0", "\n999999 61 4 1 0", ErrorCode::bad_data, "999999 as the number of nodes");
  expect("boxes.inp", "\n120 61 4 1 0", "\n120 61 5 1 0", ErrorCode::bad_data, "arrays of 4 numbers in all; expected 5");
  expect("boxes.inp", " hex ", " cub ", ErrorCode::bad_data, "is of type 'cub'");
  const auto whole = [](std::initializer_list<std::int32_t> numbers) { return std::string(reinterpret_cast<const char*>(std::data(numbers)), numbers.size() * sizeof(std::int32_t)); };
  expect("box.med", whole({1, 2, 3, 4, 5, 7}), whole({1, 2, 999, 4, 5, 7}), ErrorCode::bad_data, "element 2 uses node 999, which is not there");
  expect("box.med", whole({1, 2, 3, 4, 5, 7}), whole({1, 2, -3, 4, 5, 7}), ErrorCode::bad_data, "element 2 uses node -3, which is not there");
  expect("short.frd", "         120", "       12000", ErrorCode::bad_data, "12000 as the number of nodes");
  expect("short.frd", " -1  500    1", " -1  500   13", ErrorCode::bad_data, "element 500 is of type 13");
  expect("short.frd", " -1 1001 0.00000E+00", " -1  999 0.00000E+00", ErrorCode::bad_data, "two nodes of number 999");
  expect("short.frd", " 0.00000E+00", " 0.0000xE+00", ErrorCode::bad_data, "expected a place in column 9");
}

TEST_F(ForeignFormats, BricksOfTecplotWhoseNodesFallTogetherAreSimplerCells) {
  const auto data = test::open(file("simple.dat"));
  ASSERT_EQ(data->grid.cell_count(), 5);
  EXPECT_EQ(data->cell_types, (std::map<std::string, std::int64_t>{{"tetrahedron", 1}, {"pyramid", 1}, {"wedge", 3}}));
  const double volumes[] = {1.0 / 6, 1.0 / 3, 0.5, 0.5, 0.5};
  for (std::int64_t cell = 0; cell < 5; ++cell) EXPECT_NEAR(std::abs(test::cell_volume(data->grid, cell)), volumes[cell], 1e-12) << cell;
}

TEST_F(ForeignFormats, CellsOfUcdFillTheirPlaces) {
  const auto data = test::open(file("shapes.ucd"));
  ASSERT_EQ(data->grid.cell_count(), 3);
  const double volumes[] = {1.0 / 6, 1.0 / 3, 0.5};
  for (std::int64_t cell = 0; cell < 3; ++cell) EXPECT_NEAR(std::abs(test::cell_volume(data->grid, cell)), volumes[cell], 1e-12) << cell;
}

TEST_F(ForeignFormats, CellsOfTecplotHaveTheirOwnValues) {
  for (const auto& [name, array] : {std::pair{"ordered.plt", "q"}, {"other_order.plt", "q"}}) {
    const auto data = test::open(file(name));
    const PointArray& of = data->array(array);
    ASSERT_TRUE(of.cells) << name;
    const PointArray cells = as_array(*of.cells, array);
    std::size_t n = 0;
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 5; ++i, ++n) EXPECT_EQ(cells.at(n), i + 10 * j + 100 * k) << name;
    EXPECT_EQ(data->array("p").unit, "Pa");
  }
  EXPECT_EQ(axis_title(test::open(file("points.dat"))->axes, 2), "z (m)");
}

TEST_F(ForeignFormats, ASliceOpensItsSeriesAndNoOtherOfTheFolder) {
  const auto whole = test::open(file("scan"));
  std::filesystem::copy_file(file("scan_implicit/picture0.dcm"), file("scan/one_of_another.dcm"));
  std::string bytes = test::read_bytes(file("scan/one_of_another.dcm"));
  bytes.replace(bytes.find("1.2.3\0", bytes.find("9.9.9")), 5, "1.2.4");
  std::ofstream(file("scan/one_of_another.dcm"), std::ios::binary) << bytes;
  for (const std::string name : {"scan", "scan/picture2.dcm"}) {
    const auto data = test::open(file(name));
    EXPECT_EQ(data->grid.point_count(), whole->grid.point_count()) << name;
    EXPECT_EQ(data->bounds.upper, whole->bounds.upper) << name;
  }
  EXPECT_EQ(test::open(file("scan/one_of_another.dcm"))->grid.point_count(), 30);
}

TEST_F(ForeignFormats, CutOffFilesAreErrorsAndMutatedOnesEndInADatasetOrAnError) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const std::string name : {"c_order.npy", "vectors.npy", "classic.nc", "four.nc", "image.vtkhdf", "cells.hdf", "structured.cgns", "unstructured.cgns",
                                 "scaled.nii", "turned.nii", "orbitals.cube", "grids.xsf", "CHGCAR", "head.mgh", "short.mgz", "two_text.msh", "two_binary.msh", "four_text.msh", "four_binary.msh", "second_12_6.msh", "short.frd", "doubles.frd", "points.dat", "blocks.tec", "steps.dat", "ordered.plt", "steps.plt", "bonsai_6x5x4_int16.raw", "plain.mif", "potential.dx", "plain.am", "zipped.am", "labels.am", "text.am", "box.med", "second_P15_3.med", "boxes.inp", "scan/picture1.dcm", "plain.h5", "kinds.h5", "links.h5", "gaps3.nc", "types.nc", "stored.npz", "packed.npz"})
    files.emplace_back(file(name).filename().string(), test::read_bytes(file(name)));
  const Scratch scratch;
  for (const auto& [name, bytes] : files) {
    const Error error = test::refusal(scratch.write(name, bytes.substr(0, bytes.size() / 3)));
    EXPECT_TRUE(error.code() == ErrorCode::bad_data || error.code() == ErrorCode::unsupported) << error.what();
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
  }
  testing::expect_datasets_or_errors(files, 60);
}

TEST_F(ForeignFormats, ACaseWhoseFilesAreMutatedEndsInADatasetOrAnError) {
  int opened = 0, refused = 0;
  for (int round = 0; round < 15; ++round) {
    std::mt19937 random(static_cast<unsigned>(round) + 4711);
    static constexpr const char* kFiles[] = {"points", "faces", "owner", "neighbour", "boundary"};
    const auto path = file("cavity/constant/polyMesh") / kFiles[round % 5];
    const std::string whole = test::read_bytes(path);
    std::ofstream(path, std::ios::binary) << testing::mutated(whole, random);
    try {
      OpenOptions options;
      options.timeout_s = 20;
      options.max_bytes = 256u << 20;
      open_dataset(file("cavity").string(), options, Task());
      ++opened;
    } catch (const Error& error) {
      EXPECT_NE(error.code(), ErrorCode::internal) << "round " << round << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find("ended after"), std::string::npos) << "round " << round << ": " << error.what();
      ++refused;
    }
    std::ofstream(path, std::ios::binary) << whole;
  }
  EXPECT_EQ(opened + refused, 15);
  EXPECT_GT(refused, 0);
}

TEST_F(ForeignFormats, NamesOutsideACaseAreRefused) {
  const std::string rest = "VARIABLE\nscalar per node: 1 p p.scl\nTIME\ntime set: 1\nnumber of steps: 1\ntime values: 0\n";
  for (const std::string geometry : {"/etc/passwd", "../secret.geo", "a/../../secret.geo"}) {
    const Error error = test::refusal(folder_.write("f/x.case", "FORMAT\ntype: ensight gold\nGEOMETRY\nmodel: " + geometry + "\n" + rest));
    EXPECT_EQ(error.code(), ErrorCode::bad_data) << error.what();
    EXPECT_NE(std::string(error.what()).find("below its own directory"), std::string::npos) << error.what();
  }
  const Error list = test::refusal(folder_.write("f/x.vtu.series", R"({"file-series-version":"1.0","files":[{"name":"../x.vtu","time":0}]})"));
  EXPECT_NE(std::string(list.what()).find("below its own directory"), std::string::npos) << list.what();
}

TEST_F(ForeignFormats, ANameWithBlanksInACaseLeadsNowhereElse) {
  const std::string bytes = test::read_bytes(file("lists.case"));
  const auto with = [&](const std::string& from, const std::string& to) { return test::refusal(folder_.write("f/x.case", std::string(bytes).replace(bytes.find(from), from.size(), to))); };
  EXPECT_NE(std::string(with("box.geo", "\"../a box.geo\"").what()).find("below its own directory"), std::string::npos);
  EXPECT_NE(std::string(with("numbers.txt", "../numbers.txt").what()).find("below its own directory"), std::string::npos);
  EXPECT_NE(std::string(with("\"the times.txt\"", "/etc/passwd").what()).find("below its own directory"), std::string::npos);
  EXPECT_NE(std::string(with("numbers.txt", "box.geo").what()).find("expected numbers in 'box.geo', which has 'made'"), std::string::npos);
  EXPECT_EQ(with("box.geo", "\"no such box.geo\"").code(), ErrorCode::bad_data);
}

TEST_F(ForeignFormats, ACollatedCaseOfOpenFoamIsThatOfItsProcessors) {
  for (const auto& [collated, apart] : {std::pair("collated", "parted"), std::pair("collated_binary", "parted_binary")})
    for (const int step : {0, 2}) {
      const auto one = test::open(file(collated), step), other = test::open(file(apart), step);
      ASSERT_EQ(one->grid.point_count(), other->grid.point_count()) << collated;
      for (std::int64_t p = 0; p < one->grid.point_count(); ++p) {
        EXPECT_EQ(one->grid.point(p), other->grid.point(p)) << collated << ", point " << p;
        EXPECT_EQ(one->array("p").at(static_cast<std::size_t>(p)), other->array("p").at(static_cast<std::size_t>(p))) << collated << ", point " << p;
      }
    }
}

TEST_F(ForeignFormats, ADamagedCollatedCaseOfOpenFoamSaysWhatIsWrong) {
  const auto p = file("collated/processors3/0/p");
  const std::string whole = test::read_bytes(p);
  const auto second = whole.find("// Processor1");
  const auto without = [&](const std::string& words) { return std::string(whole).replace(whole.find(words), words.size(), ""); };
  const std::pair<std::string, const char*> wrongs[] = {
      {whole.substr(0, whole.size() - 9), "processors3/0/p: is cut off, or damaged: expected"},
      {whole.substr(0, second), "processors3/0/p: has 1 blocks; expected 3, one of each processor of its folder"},
      {without("\n("), "expected"},
      {std::string(whole).replace(whole.find("\n\n", second) + 2, 1, "99999999999999999"), "as block 1"},
      {std::string(whole).replace(whole.find("\n\n", second) + 2, 1, "x"), "expected the number of bytes of block 1"}};
  for (const auto& [bytes, said] : wrongs) {
    std::ofstream(p, std::ios::binary) << bytes;
    const Error error = test::refusal(file("collated"));
    EXPECT_EQ(error.code(), ErrorCode::bad_data) << error.what();
    EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
  }
  std::ofstream(p, std::ios::binary) << whole;
  std::filesystem::rename(file("collated/processors3/constant/polyMesh/owner"), file("owner"));
  EXPECT_NE(std::string(test::refusal(file("collated")).what()).find("processors3/constant/polyMesh/owner: no such file"), std::string::npos);
  std::filesystem::rename(file("owner"), file("collated/processors3/constant/polyMesh/owner"));
  std::filesystem::rename(file("collated_binary/processors3_0-1"), file("processors3_0-1"));
  EXPECT_NE(std::string(test::refusal(file("collated_binary")).what()).find("expected processor 0 in a folder beside processors3_2-2"), std::string::npos);
  std::filesystem::rename(file("processors3_0-1"), file("collated_binary/processors3_0-1"));
  std::filesystem::create_directories(file("cavity/processors2/0.5"));  // put together already
  EXPECT_EQ(test::open(file("cavity"))->times.size(), 3u);
}

/// What is known and not read says what it is and what to do.
TEST(Recognise, WhatIsRefusedSaysWhatItIsAndWhatToDo) {
  const Scratch scratch;
  for (const auto& [name, what, advice] : std::vector<std::array<std::string, 3>>{{"a.stl", "a surface", "volume"},
                                                                                  {"a.bp", "ADIOS", "VTKHDF"},
                                                                                  {"a.raw", "without a header", ".nhdr"},
                                                                                  {"a.msh", "mesh", "meshio"},
                                                                                  {"a.cas", "mesh", "meshio"},
                                                                                  {"a.csv", "a table", "grid"},
                                                                                  {"a.jpg", "one picture", "slice_*.png"},
                                                                                  {"a.czi", "a microscope's own", "OME-Zarr"},
                                                                                  {"a.plt", "Tecplot", "CGNS"},
                                                                                  {"a.grib2", "GRIB", "netCDF"},
                                                                                  {"a.lammpstrj", "particles", "density"},
                                                                                  {"a.tar.gz", "an archive", "unpack"},
                                                                                  {"a.neu", "mesh", "meshio"},
                                                                                  {"a.stla", "a surface", "volume"},
                                                                                  {"a.facet", "a surface", "volume"},
                                                                                  {"a.dem", "a map of heights", "netCDF"},
                                                                                  {"a.dx", "a grid of another program", ".npy"},
                                                                                  {"a.am", "AmiraMesh of a form that is not read", "Lattice"},
                                                                                  {"a.what", "not a known kind", "docs/formats.md"}}) {
    const Error error = test::refusal(scratch.write(name, "some bytes"));
    EXPECT_EQ(error.code(), ErrorCode::unsupported) << error.what();
    EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(advice), std::string::npos) << error.what();
  }
  for (const auto& [name, bytes, what] : std::vector<std::array<std::string, 3>>{
           {"a.xyz", " 3 \nwater\nO 0.0 0.0 0.1\nH 0 0.7 -4e-1\nH 0 -0.7 -0.4\n", "a list of atoms"},
           {"a.g", "1 4 2 8\n1 2\n0.0 0.0 0.0 1.0 0.0 0.0\n", "a surface (Movie.BYU)"},
           {"lammps.xyz", "2\nAtoms. Timestep: 0\n1 0 0 0\n1 0.5 0.5 0.5\n", "a list of atoms"},
           {"surfer.grd", "DSBB", "a map of heights; save it as netCDF"},
           {"esri.asc", "ncols 3\nnrows 2\n", "a map of heights; save it as netCDF"},
           {"a.mnc", "CDF\x01", "MINC; save it as NIfTI (mnc2nii IN OUT)"},
           {"a.stl.gz", "\x1f\x8b", "a surface"},
           {"a.log.gz", "\x1f\x8b", "text"},
           {"a.plt", std::string("\3\0\0\0\52\0\0\0", 8), "a density of gOpenMol"}})
    EXPECT_NE(std::string(test::refusal(scratch.write(name, bytes)).what()).find(name + ": this is " + what), std::string::npos) << name;
  EXPECT_EQ(std::string(test::refusal(scratch.write("cow.g", "1\n2 2 2\n0 0 0 1 1 1 0 0\n")).what()),
            "cow.g: no PLOT3D solution file beside it; looked for cow.q, cow.Q, cow.f");
  EXPECT_EQ(std::string(test::refusal(scratch.write("blockMeshDict.gz", "\x1f\x8b")).what()),
            "blockMeshDict.gz: its name does not say what is in it; expected NAME.vtk.gz, NAME.vtu.gz or the like");
  for (const char* folder : {"b.bp", "a.bp4", "a.bp5", "a.n5"}) {
    std::filesystem::create_directory(scratch / folder);
    const Error error = test::refusal(scratch / folder);
    EXPECT_EQ(error.code(), ErrorCode::unsupported) << error.what();
    EXPECT_NE(std::string(error.what()).find(folder == std::string("a.n5") ? "this is N5" : "this is ADIOS"), std::string::npos) << error.what();
  }
  std::filesystem::create_directory(scratch / "empty");
  EXPECT_NE(std::string(test::refusal(scratch / "empty").what()).find("OpenFOAM case"), std::string::npos);
}

TEST(Recognise, WhatAReaderNeedsIsThatOfTheFileAndOfAPatternsFirst) {
  const Scratch scratch;
  const auto needs = [&](const std::string& name) {
    const ReaderNeeds of = reader_needs(scratch / name);
    return std::pair(of.all_readers, of.pictures);
  };
  const std::string tiff("II*\0\x08\0\0\0", 8);
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{{"a.nc", "CDF\x01"}, {"s_1.nc", "CDF\x01"}, {"s_2.nc", "CDF\x01"}, {"a.npy", "\x93NUMPY"}, {"a.tif", tiff}, {"scan", tiff}, {"k_1.scan", tiff}, {"k_2.scan", tiff}})
    scratch.write(name, bytes);
  for (const char* all : {"a.nc", "s_*.nc"}) EXPECT_EQ(needs(all), std::pair(true, false)) << all;
  for (const char* pictures : {"scan", "k_*.scan"}) EXPECT_EQ(needs(pictures), std::pair(false, true)) << pictures;
  for (const char* neither : {"a.npy", "a.tif", "absent", "absent_*.nc"}) EXPECT_EQ(needs(neither), std::pair(false, false)) << neither;
}

TEST(FormatTable, OfTheDocumentsIsThatOfTheReaders) {
  std::string table = "| format | names | what is read | reader |\n|---|---|---|---|\n";
  for (const FileFormat& format : file_formats()) {
    std::string names;
    std::istringstream words{std::string(format.extensions)};
    for (std::string word; words >> word;) names += (names.empty() ? "`" : " `") + word + "`";
    table += "| " + std::string(format.name) + " | " + names + " | " + std::string(format.what) + " | " + std::string(format.reader) + " |\n";
  }
  std::string foreign = "| names | what it is | what to do |\n|---|---|---|\n";
  for (const ForeignFormat& format : foreign_formats()) {
    if (format.advice.empty()) continue;
    foreign += "| `" + std::string(format.extensions) + "` | " + std::string(format.what) + " | " + std::string(format.advice) + " |\n";
  }
  const std::string page = test::read_bytes(places::source() + "/docs/formats.md");
  EXPECT_NE(page.find(table), std::string::npos) << "docs/formats.md should hold\n" << table;
  EXPECT_NE(page.find(foreign), std::string::npos) << "docs/formats.md should hold\n" << foreign;
  std::set<FileKind> kinds;
  for (const FileFormat& format : file_formats()) EXPECT_TRUE(kinds.insert(format.kind).second) << format.name;
}

}  // namespace
}  // namespace isostrata
