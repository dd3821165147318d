// Files of boxes in levels that tests write themselves, by VTK's and AMReX's own descriptions of them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "import/adaptive/level_lattice.h"
#include "support/temporary_folder.h"
#include "support/vtk_text.h"

namespace isostrata::testing {

using LevelField = std::function<double(const Vec3d&)>;

/// use(middle of the cell) for the cells of a box that is `grown` by so many on each side, x fastest.
inline void for_each_middle(const LevelBox& box, std::int64_t grown, const std::function<void(const Vec3d&)>& use) {
  const auto last = [&](std::size_t a) { return box.cells[a] == 0 ? 1 : box.cells[a] + grown; };
  const auto first = [&](std::size_t a) { return box.cells[a] == 0 ? 0 : -grown; };
  for (std::int64_t k = first(2); k < last(2); ++k)
    for (std::int64_t j = first(1); j < last(1); ++j)
      for (std::int64_t i = first(0); i < last(0); ++i) {
        Vec3d at = box.origin;
        const std::array<std::int64_t, 3> cell{i, j, k};
        for (int axis = 0; axis < 3; ++axis)
          if (box.cells[static_cast<std::size_t>(axis)] > 0) at[axis] += (static_cast<double>(cell[static_cast<std::size_t>(axis)]) + 0.5) * box.spacing[axis];
        use(at);
      }
}

/// Levels by the sizes of cells, the coarsest first: numbers of boxes.
inline std::vector<std::vector<std::size_t>> by_level(const LevelBoxes& levels) {
  std::map<double, std::vector<std::size_t>, std::greater<>> sizes;
  for (std::size_t b = 0; b < levels.boxes.size(); ++b) sizes[levels.boxes[b].cells[0] > 0 ? levels.boxes[b].spacing.x : levels.boxes[b].spacing.y].push_back(b);
  std::vector<std::vector<std::size_t>> out;
  for (auto& [size, boxes] : sizes) out.push_back(std::move(boxes));
  return out;
}

/// name.vthb and its boxes in a folder beside it, with one array on cells, "field".
inline std::filesystem::path write_vthb(const TemporaryFolder& folder, const std::string& name, const LevelBoxes& levels, const LevelField& field) {
  std::ostringstream list;
  list.precision(17);
  const auto words = [](const Vec3d& v) {
    std::ostringstream out;
    out.precision(17);
    out << v.x << " " << v.y << " " << v.z;
    return out.str();
  };
  const auto of_levels = by_level(levels);
  for (std::size_t level = 0; level < of_levels.size(); ++level) {
    list << "<Block level=\"" << level << "\" spacing=\"" << words(levels.boxes[of_levels[level].front()].spacing) << "\">\n";
    for (const std::size_t b : of_levels[level]) {
      const LevelBox& box = levels.boxes[b];
      const std::string file = name + "/box_" + std::to_string(b) + ".vti";
      std::string extent;
      for (const std::int64_t cells : box.cells) extent += "0 " + std::to_string(cells) + " ";
      std::vector<double> values;
      for_each_middle(box, 0, [&](const Vec3d& at) { values.push_back(field(at)); });
      folder.write(file, vtk_file("ImageData", "<ImageData WholeExtent=\"" + extent + "\" Origin=\"" + words(box.origin) + "\" Spacing=\"" + words(box.spacing) + "\">\n<Piece Extent=\"" + extent +
                                                   "\"><PointData></PointData><CellData>" + data_array("field", "Float64", values) + "</CellData></Piece></ImageData>\n"));
      list << "<DataSet index=\"" << b << "\" file=\"" << file << "\"/>\n";
    }
    list << "</Block>\n";
  }
  return folder.write(name + ".vthb", vtk_file("vtkOverlappingAMR", "<vtkOverlappingAMR origin=\"0 0 0\" grid_description=\"XYZ\">\n" + list.str() + "</vtkOverlappingAMR>\n"));
}

struct Plotfile {
  double time = 0;
  int bytes = 8;        // of a number: 4 or 8
  bool big = false;     // the first byte counts most
  int ghosts = 0;       // cells around each box, of NaN
  int boxes_of_a_file = 3;
  std::array<std::int64_t, 3> first{0, 0, 0};  // the cell at the lowest corner of the domain, on every level
};

inline std::string as_stored(const Plotfile& of, double value) {
  std::string bytes(static_cast<std::size_t>(of.bytes), '\0');
  const auto single = static_cast<float>(value);
  std::memcpy(bytes.data(), of.bytes == 4 ? static_cast<const void*>(&single) : &value, bytes.size());
  if (of.big != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// A folder; `fields` by their names are its components.
inline std::filesystem::path write_plotfile(const TemporaryFolder& folder, const std::string& name, const LevelBoxes& levels, const std::vector<std::pair<std::string, LevelField>>& fields,
                                            const Plotfile& of = {}) {
  const std::vector<std::vector<std::size_t>> of_levels = by_level(levels);
  const std::size_t finest = of_levels.size() - 1;
  const int dimensions = levels.boxes.front().cells[2] > 0 ? 3 : 2;
  Vec3d lower = levels.boxes.front().origin, upper = lower;
  for (const LevelBox& box : levels.boxes)
    for (int axis = 0; axis < dimensions; ++axis) {
      lower[axis] = std::min(lower[axis], box.origin[axis]);
      upper[axis] = std::max(upper[axis], box.origin[axis] + static_cast<double>(box.cells[static_cast<std::size_t>(axis)]) * box.spacing[axis]);
    }
  const auto spacing_of = [&](std::size_t level) { return levels.boxes[of_levels[level].front()].spacing; };
  const auto tuple = [&](const auto& number) {
    std::string out = "(";
    for (int axis = 0; axis < dimensions; ++axis) out += (axis ? "," : "") + std::to_string(number(axis));
    return out + ")";
  };
  const auto box_words = [&](std::size_t level, const Vec3d& from, const Vec3d& to, std::int64_t grown) {
    const auto index = [&](const Vec3d& at, int axis) { return std::llround((at[axis] - lower[axis]) / spacing_of(level)[axis]) + of.first[static_cast<std::size_t>(axis)]; };
    return "(" + tuple([&](int axis) { return index(from, axis) - grown; }) + " " + tuple([&](int axis) { return index(to, axis) - 1 + grown; }) + " " + tuple([](int) { return 0; }) + ")";
  };
  const auto upper_of = [](const LevelBox& box) {
    Vec3d at = box.origin;
    for (int axis = 0; axis < 3; ++axis) at[axis] += static_cast<double>(box.cells[static_cast<std::size_t>(axis)]) * box.spacing[axis];
    return at;
  };

  std::ostringstream header;
  header.precision(17);
  const auto reals = [&](const Vec3d& v) {
    for (int axis = 0; axis < dimensions; ++axis) header << v[axis] << " ";
    header << "\n";
  };
  header << "HyperCLaw-V1.1\n" << fields.size() << "\n";
  for (const auto& [field, value] : fields) header << field << "\n";
  header << dimensions << "\n" << of.time << "\n" << finest << "\n";
  reals(lower);
  reals(upper);
  for (std::size_t level = 0; level < finest; ++level) header << std::llround(spacing_of(level).x / spacing_of(level + 1).x) << " ";
  header << "\n";
  for (std::size_t level = 0; level <= finest; ++level) header << box_words(level, lower, upper, 0) << " ";
  header << "\n";
  for (std::size_t level = 0; level <= finest; ++level) header << 7 << " ";
  header << "\n";
  for (std::size_t level = 0; level <= finest; ++level) reals(spacing_of(level));
  header << "0\n0\n";
  for (std::size_t level = 0; level <= finest; ++level) {
    const std::string part = "Level_" + std::to_string(level);
    header << level << " " << of_levels[level].size() << " " << of.time << "\n7\n";
    std::ostringstream boxes, places;
    std::map<std::string, std::string> files;
    for (std::size_t n = 0; n < of_levels[level].size(); ++n) {
      const LevelBox& box = levels.boxes[of_levels[level][n]];
      const Vec3d end = upper_of(box);
      for (int axis = 0; axis < dimensions; ++axis) header << box.origin[axis] << " " << end[axis] << "\n";
      boxes << box_words(level, box.origin, end, 0) << "\n";
      std::string number = std::to_string(n / static_cast<std::size_t>(of.boxes_of_a_file));
      number.insert(0, 5 - number.size(), '0');
      std::string& bytes = files["Cell_D_" + number];
      places << "FabOnDisk: Cell_D_" << number << " " << bytes.size() << "\n";
      std::string order;
      for (int byte = 1; byte <= of.bytes; ++byte) order += (byte > 1 ? " " : "") + std::to_string(of.big ? byte : of.bytes + 1 - byte);
      bytes += std::string("FAB ((8, (") + (of.bytes == 8 ? "64 11 52 0 1 12 0 1023" : "32 8 23 0 1 9 0 127") + ")),(" + std::to_string(of.bytes) + ", (" + order + ")))" +
               box_words(level, box.origin, end, of.ghosts) + " " + std::to_string(fields.size()) + "\n";
      for (const auto& [field, value] : fields)
        for_each_middle(box, of.ghosts, [&](const Vec3d& at) {
          bool inside = true;
          for (int axis = 0; axis < dimensions; ++axis) inside = inside && at[axis] > box.origin[axis] && at[axis] < end[axis];
          bytes += as_stored(of, inside ? value(at) : std::nan(""));
        });
    }
    for (const auto& [file, bytes] : files) folder.write(name + "/" + part + "/" + file, bytes);
    folder.write(name + "/" + part + "/Cell_H", "1\n1\n" + std::to_string(fields.size()) + "\n" + std::to_string(of.ghosts) + "\n(" + std::to_string(of_levels[level].size()) + " 0\n" + boxes.str() + ")\n" +
                                                    std::to_string(of_levels[level].size()) + "\n" + places.str());
    header << part << "/Cell\n";
  }
  folder.write(name + "/Header", header.str());
  return folder / name;
}

}  // namespace isostrata::testing
