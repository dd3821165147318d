// Meshes whose arrays are appended raw are read past VTK, and come out as VTK has them.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <set>
#include <utility>

#include "data/files.h"
#include "data/open/import_cache.h"
#include "data/open/import_door.h"
#include "data/values/source_mapping.h"
#include "support/places.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using test::Scratch;

constexpr std::size_t kPoints = 8'500'000;  // mostly a hole in the file, so that 64 MiB of values are there

struct Cell {
  std::uint8_t type;  // VTK's
  std::vector<std::int64_t> ids;
};

struct MeshInPlace : ::testing::Test {
  Scratch data;
  ImportOptions options;
  MeshInPlace() { options.importer = fs::path(isostrata::places::binaries()) / "isostrata-import"; }

  struct Ways {
    bool wide = true;         // ids of 64 bits
    std::size_t off = 0;      // where values begin, of 8
    bool by_vtk = false;      // with marks of ghosts, all 0, which are VTK's reader's to understand
    bool long_head = true;    // lengths of 64 bits
    bool of_cells = true;     // values on cells, too
    double first = -3.25;     // value
    float moved = 0;          // the first point, by so much
    std::function<void(std::vector<Cell>&)> change = [](auto&) {};
  };

  /// Cells of all four kinds over the first points; values on points and cells, and vectors.
  fs::path write(const std::string& name, const Ways& ways) {
    std::vector<Cell> cells{{10, {0, 1, 2, 3}}, {12, {4, 5, 6, 7, 8, 9, 10, 11}}, {13, {1, 2, 3, 4, 5, 6}}, {14, {7, 8, 9, 10, 11}}};
    for (std::int64_t i = 0; i < 70'000; ++i) cells.push_back({10, {i, i + 1, i + 2, static_cast<std::int64_t>(kPoints) - 1 - i}});
    ways.change(cells);
    std::vector<std::int64_t> ids, ends;
    std::string types;
    std::vector<double> of_cells;
    for (const Cell& cell : cells) {
      ids.insert(ids.end(), cell.ids.begin(), cell.ids.end());
      ends.push_back(static_cast<std::int64_t>(ids.size()));
      types += static_cast<char>(cell.type);
      of_cells.push_back(static_cast<double>(of_cells.size()) * 0.5);
    }
    struct Array {
      std::string in, head, bytes;
      std::uint64_t length;
    };
    const auto numbers = [&](const std::vector<std::int64_t>& all) {
      std::string out;
      for (const std::int64_t one : all) out.append(reinterpret_cast<const char*>(&one), ways.wide ? 8 : 4);
      return out;
    };
    std::vector<float> positions;
    std::vector<double> values;
    std::vector<std::int16_t> vectors;
    for (int p = 0; p < 1000; ++p) {
      for (const float at : {0.5f * static_cast<float>(p % 10), 0.25f * static_cast<float>(p % 7), 1.0f * static_cast<float>(p)}) positions.push_back(at);
      values.push_back(p + ways.first);
      for (const int v : {1, p, -2}) vectors.push_back(static_cast<std::int16_t>(v));
    }
    positions[0] += ways.moved;
    const auto bytes_of = [](const auto& all) { return std::string(reinterpret_cast<const char*>(all.data()), all.size() * sizeof all[0]); };
    const std::string integers = ways.wide ? "Int64" : "Int32";
    std::vector<Array> arrays{{"PointData", "type=\"Float64\" Name=\"f\"", bytes_of(values), 8 * kPoints},
                              {"PointData", "type=\"Int16\" Name=\"v\" NumberOfComponents=\"3\"", bytes_of(vectors), 6 * kPoints},
                              {"CellData", "type=\"Float64\" Name=\"c\"", bytes_of(of_cells), 8 * of_cells.size()},
                              {"Points", "type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\"", bytes_of(positions), 12 * kPoints},
                              {"Cells", "type=\"" + integers + "\" Name=\"connectivity\"", numbers(ids), 0},
                              {"Cells", "type=\"" + integers + "\" Name=\"offsets\"", numbers(ends), 0},
                              {"Cells", "type=\"UInt8\" Name=\"types\"", types, 0}};
    if (!ways.of_cells) arrays.erase(arrays.begin() + 2);
    if (ways.by_vtk) arrays.insert(arrays.begin() + 3, {"CellData", "type=\"UInt8\" Name=\"vtkGhostType\"", std::string(cells.size(), '\0'), 0});
    std::string head = "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"" +
                       std::string(ways.long_head ? " header_type=\"UInt64\"" : "") +
                       ">\n<UnstructuredGrid>\n<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">2.5</DataArray></FieldData>\n"
                       "<Piece NumberOfPoints=\"" + std::to_string(kPoints) + "\" NumberOfCells=\"" + std::to_string(cells.size()) + "\">\n";
    std::uint64_t offset = 0;
    std::string last;
    const std::size_t length_bytes = ways.long_head ? 8 : 4;
    for (Array& array : arrays) {
      if (array.length == 0) array.length = array.bytes.size();
      if (array.in != last) head += (last.empty() ? "" : "</" + last + ">\n") + "<" + array.in + ">\n";
      last = array.in;
      head += "<DataArray " + array.head + " format=\"appended\" offset=\"" + std::to_string(offset) + "\"/>\n";
      offset += length_bytes + array.length;
    }
    head += "</" + last + ">\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">";
    while ((head.size() + 1 + length_bytes) % 8 != ways.off) head += ' ';
    head += '_';
    const fs::path path = data / name;
    std::ofstream out(path, std::ios::binary);
    out << head;
    auto at = static_cast<std::streamoff>(head.size());
    for (const Array& array : arrays) {
      out.seekp(at);
      out.write(reinterpret_cast<const char*>(&array.length), static_cast<std::streamsize>(length_bytes));
      out << array.bytes;
      at += static_cast<std::streamoff>(length_bytes + array.length);
    }
    out.seekp(at);
    out << "\n</AppendedData>\n</VTKFile>\n";
    return path;
  }
  bool is_in_place(const Dataset& dataset) {
    return std::visit([](auto values) { return is_in_source(values.data()); }, dataset.arrays.at(0).values);
  }
  template <class T>
  static bool same(std::span<const T> a, std::span<const T> b) {
    return a.size_bytes() == b.size_bytes() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
  }
  void expect_same(const Dataset& ours, const Dataset& by_vtk) {
    const auto& a = std::get<UnstructuredGrid>(ours.grid.shape);
    const auto& b = std::get<UnstructuredGrid>(by_vtk.grid.shape);
    EXPECT_TRUE(same(a.types, b.types));
    EXPECT_TRUE(same(a.offsets, b.offsets));
    EXPECT_TRUE(same(a.connectivity, b.connectivity));
    EXPECT_TRUE(same(std::get<0>(a.points), std::get<0>(b.points)));
    EXPECT_TRUE(ours.grid.hidden_cells.empty() && by_vtk.grid.hidden_cells.empty());
    EXPECT_EQ(ours.times, by_vtk.times);
    EXPECT_EQ(ours.notes, by_vtk.notes);
    ASSERT_EQ(ours.arrays.size(), by_vtk.arrays.size());
    for (std::size_t i = 0; i < ours.arrays.size(); ++i) {
      EXPECT_EQ(ours.arrays[i].name, by_vtk.arrays[i].name);
      ASSERT_EQ(ours.arrays[i].values.index(), by_vtk.arrays[i].values.index()) << ours.arrays[i].name;
      std::visit([&](auto values) { EXPECT_TRUE(same(values, std::get<decltype(values)>(by_vtk.arrays[i].values))) << ours.arrays[i].name; }, ours.arrays[i].values);
    }
  }
};

TEST_F(MeshInPlace, IsWhatVtksReaderMakesOfIt) {
  const auto by_vtk = open_import(write("vtk.vtu", {.by_vtk = true}), options, Task());
  EXPECT_FALSE(is_in_place(*by_vtk));
  EXPECT_EQ(by_vtk->times, std::vector<double>{2.5});
  EXPECT_EQ(by_vtk->arrays.size(), 6u);  // f, the magnitude and the components of v, c
  for (const Ways& ways : {Ways{}, Ways{.wide = false, .off = 3}, Ways{.off = 4, .long_head = false}}) {
    SCOPED_TRACE(std::to_string(ways.wide) + ", " + std::to_string(ways.off));
    const auto ours = open_import(write("ours.vtu", ways), options, Task());
    EXPECT_EQ(is_in_place(*ours), ways.off == 0);
    expect_same(*ours, *by_vtk);
  }
}

TEST_F(MeshInPlace, OtherCellsAreVtksReadersToReadAndBrokenOnesToRefuse) {
  const auto quadratic = [](std::vector<Cell>& cells) { cells[3] = {24, {0, 1, 2, 3, 4, 5, 6, 7, 8, 9}}; };
  const auto mixed = open_import(write("mixed.vtu", {.change = quadratic}), options, Task());
  EXPECT_EQ(mixed->grid.cell_count(), 70'003 + 8) << "the quadratic one becomes eight";
  const auto refused = [&](const std::string& name, const std::function<void(std::vector<Cell>&)>& change, const std::string& why) {
    try {
      open_import(write(name, {.change = change}), options, Task());
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_data) << name;
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused("below.vtu", [](auto& cells) { cells.back().ids[0] = -1; }, "uses point -1 of 8500000");
  refused("five.vtu", [](auto& cells) { cells[7].ids.push_back(0); }, "cell 7 has 5 points");
}

TEST_F(MeshInPlace, TwoOfThemAreBlocksOfOneDataset) {
  write("a.vtu", {.off = 1});
  const auto other = [](std::vector<Cell>& cells) { cells = {{12, {20, 21, 22, 23, 24, 25, 26, 27}}, {10, {30, 31, 32, 33}}}; };
  write("b.vtu", {.change = other});
  data.write("both.vtm",
             "<?xml version=\"1.0\"?><VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\"><vtkMultiBlockDataSet>"
             "<DataSet index=\"0\" name=\"a\" file=\"a.vtu\"/><DataSet index=\"1\" name=\"b\" file=\"b.vtu\"/></vtkMultiBlockDataSet></VTKFile>");
  const auto both = open_import(data / "both.vtm", options, Task());
  EXPECT_EQ(both->grid.cell_count(), 70'004 + 2);
  const auto& cells = std::get<UnstructuredGrid>(both->grid.shape);
  EXPECT_EQ(cells.connectivity[4], 4);
  EXPECT_EQ(cells.types[70'004], static_cast<std::uint8_t>(CellType::hexahedron));

  // As foamToVTK writes regions.
  data.write("regions.vtm",
             "<?xml version=\"1.0\"?><VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\" byte_order=\"LittleEndian\"><vtkMultiBlockDataSet>"
             "<Block name=\"air\"><DataSet name=\"internal\" file=\"a.vtu\"/></Block><Block name=\"heater\"><DataSet name=\"internal\" file=\"b.vtu\"/></Block>"
             "</vtkMultiBlockDataSet></VTKFile>");
  const auto notes = open_import(data / "regions.vtm", options, Task())->notes;
  EXPECT_NE(std::find(notes.begin(), notes.end(), "blocks: air, heater"), notes.end());
}

TEST_F(MeshInPlace, AListOfBlocksHasTheTimeThatItSays) {
  write("a.vtu", {.of_cells = false});
  for (const auto& [name, time] : {std::pair{"run_20.vtm", "0.02"}, {"run_45.vtm", "0.045"}})  // foamToVTK's names count the steps of the solver
    data.write(name, "<?xml version='1.0'?>\n<VTKFile type='vtkMultiBlockDataSet' version='1.0' byte_order='LittleEndian'><vtkMultiBlockDataSet><DataSet name='internal' file='a.vtu' />"
                     "</vtkMultiBlockDataSet><FieldData><DataArray type='Float32' Name='TimeValue' NumberOfTuples='1' format='ascii'>\n" + std::string(time) + "\n</DataArray></FieldData></VTKFile>");
  EXPECT_EQ(open_import(data / "run_45.vtm", options, Task())->times, std::vector<double>{0.045});
  EXPECT_EQ(open_import(data / "run_*.vtm", options, Task())->times, (std::vector<double>{0.02, 0.045}));
}

TEST_F(MeshInPlace, AStepOnTheMeshOfOneInMemoryBringsItsValuesAlone) {
  const auto swapped = [](std::vector<Cell>& cells) { std::swap(cells[5].ids[0], cells[5].ids[1]); };
  const std::vector<Ways> steps{{.of_cells = false},
                                {.wide = false, .of_cells = false, .first = 1},
                                {.off = 3, .of_cells = false, .first = 2},
                                {.of_cells = false, .moved = 0.5f},
                                {.of_cells = false, .change = swapped},
                                {}};
  std::string list = "{\"file-series-version\": \"1.0\", \"files\": [";
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::string name = "step_" + std::to_string(i) + ".vtu";
    write(name, steps[i]);
    list += std::string(i ? ", " : "") + "{\"name\": \"" + name + "\", \"time\": " + std::to_string(i) + "}";
  }
  data.write("all.vtu.series", list + "]}");
  for (const fs::path& file : {data / "step_*.vtu", data / "all.vtu.series"}) {
    SCOPED_TRACE(file);
    options.like = nullptr;
    options.step = 0;
    const auto first = open_import(file, options, Task());
    for (int step = 1; step < static_cast<int>(steps.size()); ++step) {
      SCOPED_TRACE(step);
      options.step = step;
      options.like = nullptr;
      const auto alone = open_import(file, options, Task());
      options.like = first;
      const auto beside = open_import(file, options, Task());
      EXPECT_EQ(beside->grid.storage == first->grid.storage, step == 2) << "that alone has the first one's mesh, as it was written";
      expect_same(*beside, *alone);
      EXPECT_EQ(beside->step, step);
      EXPECT_EQ(beside->bounds.lower, alone->bounds.lower);
      EXPECT_EQ(beside->cell_types, alone->cell_types);
    }
  }
}

TEST_F(MeshInPlace, AStepOfCellsThatAreDividedIsReadWhole) {
  const auto quadratic = [](std::vector<Cell>& cells) {
    cells[1] = {25, {}};
    for (std::int64_t i = 0; i < 20; ++i) cells[1].ids.push_back(20 + i);
  };
  write("step_0.vtu", {.of_cells = false, .change = quadratic});
  write("step_1.vtu", {.of_cells = false, .first = 1, .change = quadratic});
  const fs::path file = data / "step_*.vtu";
  options.step = 1;
  const auto alone = open_import(file, options, Task());
  options.step = 0;
  options.like = open_import(file, options, Task());
  options.step = 1;
  expect_same(*open_import(file, options, Task()), *alone);
}

TEST_F(MeshInPlace, AStepThatNeedsOneInMemoryIsKeptForWhoHasThatOne) {
  ImportCache cache;
  cache.folder = data / "cache";
  cache.least_seconds = 0;
  write("step_0.vtu", {.of_cells = false});
  write("step_1.vtu", {.of_cells = false, .first = 1});
  options.step = 0;
  options.like = open_import_cached(data / "step_*.vtu", options, cache, Task());
  options.step = 1;
  const auto beside = open_import_cached(data / "step_*.vtu", options, cache, Task());
  EXPECT_EQ(beside->grid.storage, options.like->grid.storage);
  EXPECT_EQ(use_of(cache).entries, 2);
  const auto found = find_import_cached(data / "step_*.vtu", options, cache);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->grid.storage, options.like->grid.storage);
  expect_same(*found, *beside);
  const auto first = std::exchange(options.like, nullptr);
  EXPECT_FALSE(find_import_cached(data / "step_*.vtu", options, cache)) << "its mesh is not at hand";
  const auto whole = open_import_cached(data / "step_*.vtu", options, cache, Task());
  expect_same(*whole, *beside);
  EXPECT_EQ(use_of(cache).entries, 3);
  options.step = 0;
  options.like = whole;
  EXPECT_NE(find_import_cached(data / "step_*.vtu", options, cache)->grid.storage, whole->grid.storage) << "its own";
  options.step = 1;
  options.like = first;
  write("step_0.vtu", {.of_cells = false, .moved = 0.5f});
  EXPECT_FALSE(find_import_cached(data / "step_*.vtu", options, cache)) << "that was another mesh";
  write("step_0.vtu", {.of_cells = false});
  options.like = nullptr;
  const fs::path kept = data / "kept";
  fs::create_directory(kept);
  options.step = 0;
  options.like = open_import_keeping(data / "step_*.vtu", options, kept, Task());
  options.step = 1;
  const auto again = open_import_keeping(data / "step_*.vtu", options, kept, Task());
  EXPECT_EQ(again->grid.storage, options.like->grid.storage);
  EXPECT_EQ(std::distance(fs::directory_iterator(kept), fs::directory_iterator()), 1);
}

TEST_F(MeshInPlace, LeavesNothingBesideTheDatasetsFilesInTheCache) {
  ImportCache cache;
  cache.folder = data / "cache";
  cache.least_seconds = 0;
  const fs::path file = write("kept.vtu", {.off = 1});
  const auto first = open_import_cached(file, options, cache, Task()), second = open_import_cached(file, options, cache, Task());
  expect_same(*first, *second);
  EXPECT_EQ(use_of(cache).entries, 1);
  std::set<fs::path> names;
  for (const auto& entry : fs::recursive_directory_iterator(cache.folder)) names.insert(entry.path().filename());
  EXPECT_TRUE(names.contains("connectivity.bin") && names.contains("offsets.bin"));
  EXPECT_FALSE(names.contains("connectivity.bin.2"));
}

}  // namespace
}  // namespace isostrata
