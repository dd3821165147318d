#include <cstring>

#include "data/files/recognise.h"
#include "import/imported/declared_time.h"
#include "import/imported/list_file.h"
#include "import/imported/read_file.h"
#include "import/imported/read_own.h"

namespace isostrata {
namespace {

constexpr int kDeepestBlocks = 32;
constexpr std::size_t kMostFiles = 100'000;

struct Part {
  std::string name, file;
};

/// Parts in the order of the file; a name is that of the part or of the block around it.
void collect(vtkXMLDataElement* element, const std::string& around, int depth, const std::string& name, std::vector<Part>& parts) {
  if (depth > kDeepestBlocks) throw Error(ErrorCode::bad_data, name + ": blocks within blocks, above 32 deep");
  for (int i = 0; i < element->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* inner = element->GetNestedElement(i);
    const char* own = inner->GetAttribute("name");
    const bool internal = own && std::strcmp(own, "internal") == 0 && !around.empty();  // of a region of OpenFOAM's foamToVTK, whose name stands around it
    const std::string called = own && *own && !internal ? own : around;
    if (const char* file = inner->GetAttribute("file"); file && std::strcmp(inner->GetName(), "DataSet") == 0) {
      if (parts.size() == kMostFiles) throw Error(ErrorCode::too_large, name + ": lists more than 100000 files");
      parts.push_back({called, file});
    } else {
      collect(inner, called, depth + 1, name, parts);
    }
  }
}

}  // namespace

Imported read_multi_block(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_list_depth(request);
  const auto root = parse_small_xml(request);
  std::vector<Part> parts;
  collect(root, "", 0, name, parts);
  if (parts.empty()) throw Error(ErrorCode::bad_data, name + ": lists no files");
  check_step(request, 1);

  Imported imported;
  int surfaces = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    ReadRequest part = request;
    part.file = referred_file(request.file, parts[i].file);
    part.step = 0;
    ++part.depth;
    part.progress = [&](double fraction) { request.progress((static_cast<double>(i) + fraction) / static_cast<double>(parts.size())); };
    const Recognised of = recognise(part.file);
    if (of.vtk_type == "PolyData" || of.vtk_type == "PPolyData") {
      ++surfaces;
      continue;
    }
    Imported one = read_file(part);
    imported.axes = std::move(one.axes);
    const std::string called = parts[i].name.empty() ? "block " + std::to_string(i) : parts[i].name;
    for (Block& block : one.blocks) {
      block.name = called;
      imported.blocks.push_back(std::move(block));
    }
    imported.notes.insert(imported.notes.end(), one.notes.begin(), one.notes.end());
    if (one.times != std::vector<double>{0.0}) imported.times = {one.times.front()};
  }
  if (const auto time = declared_time(request.file)) imported.times = {*time};
  if (imported.blocks.empty()) throw Error(ErrorCode::unsupported, name + ": holds surfaces alone; expected a grid whose cells have a volume");
  if (surfaces > 0) imported.notes.push_back(std::to_string(surfaces) + " surfaces skipped: other blocks have grids");
  return imported;
}

}  // namespace isostrata
