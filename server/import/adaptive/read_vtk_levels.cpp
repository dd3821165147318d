#include <algorithm>
#include <cstring>
#include <set>

#include "data/files/recognise.h"
#include "import/adaptive/leaf_block.h"
#include "import/imported/list_file.h"
#include "import/imported/read_file.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr std::size_t kMostBoxFiles = 100'000;

/// The files of all levels, in their order.
std::vector<std::string> listed_files(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  const auto root = parse_small_xml(request);
  std::vector<std::string> files;
  const auto inner = [](vtkXMLDataElement* element, const char* called, const auto& use) {
    for (int i = 0; i < element->GetNumberOfNestedElements(); ++i)
      if (std::strcmp(element->GetNestedElement(i)->GetName(), called) == 0) use(element->GetNestedElement(i));
  };
  for (int i = 0; i < root->GetNumberOfNestedElements(); ++i)
    inner(root->GetNestedElement(i), "Block", [&](vtkXMLDataElement* level) {
      inner(level, "DataSet", [&](vtkXMLDataElement* box) {
        if (files.size() == kMostBoxFiles) throw Error(ErrorCode::too_large, name + ": lists more than 100000 files");
        if (const char* file = box->GetAttribute("file")) files.emplace_back(file);
      });
    });
  if (files.empty()) throw Error(ErrorCode::bad_data, name + ": lists no files");
  return files;
}

LevelBox box_of(const Grid& grid, const std::string& file) {
  const auto* uniform = std::get_if<UniformGrid>(&grid.shape);
  if (!uniform) throw Error(ErrorCode::unsupported, file + ": is a " + grid.kind_name() + " grid; expected image data along the axes, as a box of a level is");
  LevelBox box{.origin = uniform->origin, .spacing = uniform->spacing};
  for (std::size_t a = 0; a < 3; ++a) box.cells[a] = uniform->dims[a] - 1;
  return box;
}

const FileArray* find(const Block& block, const FileArray& like) {
  for (const FileArray& array : block.arrays)
    if (array.on_cells && array.name == like.name && array.components == like.components && array.type == like.type) return &array;
  return nullptr;
}

}  // namespace

Imported read_vtk_levels(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_step(request, 1);
  const std::vector<std::string> files = listed_files(request);
  Imported imported;
  LevelBoxes levels;
  std::vector<Block> blocks;
  for (const std::string& file : files) {
    ReadRequest part = request;
    part.file = referred_file(request.file, file);
    part.progress = [](double) {};
    if (const Recognised of = recognise(part.file); of.kind != FileKind::vtk_xml || of.vtk_type != "ImageData")
      throw Error(ErrorCode::unsupported, name + ": lists '" + file + "', which is " + std::string(format_of(of.kind).name) + "; expected a .vti for each box");
    Imported one = read_file(part);
    if (one.times != std::vector<double>{0.0}) imported.times = {one.times.front()};
    levels.boxes.push_back(box_of(one.blocks.front().grid, file));
    blocks.push_back(std::move(one.blocks.front()));
    request.progress(0.3 * static_cast<double>(blocks.size()) / static_cast<double>(files.size()));
  }
  LeafBlock leaves(levels, request, imported.notes);
  std::set<std::string> left_out, on_points;
  for (const Block& block : blocks)
    for (const FileArray& array : block.arrays) {
      if (!array.on_cells)
        on_points.insert(array.name);
      else if (&block != &blocks.front() || !std::all_of(blocks.begin(), blocks.end(), [&](const Block& other) { return find(other, array) != nullptr; }))
        left_out.insert(array.name);
    }
  for (const FileArray& array : blocks.front().arrays) {
    if (!array.on_cells || !std::all_of(blocks.begin(), blocks.end(), [&](const Block& other) { return find(other, array) != nullptr; })) continue;
    leaves.add(array, [&](std::size_t box) { return find(blocks[box], array)->values; });
    left_out.erase(array.name);
  }
  Block block = leaves.take();
  if (block.arrays.empty() && !on_points.empty()) throw Error(ErrorCode::unsupported, name + ": its values are on points; expected values of cells, as boxes of levels have them (ParaView: Point Data to Cell Data)");
  for (const std::string& array : left_out) imported.notes.push_back("array '" + array + "' left out: not all boxes have it, in one type");
  for (const std::string& array : on_points) imported.notes.push_back("array '" + array + "' left out: it is on points; of levels the values of cells are read");
  imported.blocks.push_back(std::move(block));
  return imported;
}

}  // namespace isostrata
