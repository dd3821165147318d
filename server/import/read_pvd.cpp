#include <vtkSmartPointer.h>
#include <vtkXMLDataElement.h>
#include <vtkXMLUtilities.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <map>

#include "import/read_file.h"
#include "import/read_vtk.h"
#include "import/recognise.h"
#include "import/vtk_messages.h"

namespace isostrata {
namespace {

double time_of(vtkXMLDataElement* entry, const std::string& name) {
  const char* text = entry->GetAttribute("timestep");
  if (!text) return 0.0;
  std::string trimmed(text);
  trimmed.erase(0, trimmed.find_first_not_of(" \t\r\n"));
  trimmed.erase(trimmed.find_last_not_of(" \t\r\n") + 1);
  double time = 0;
  const auto [end, error] = std::from_chars(trimmed.data(), trimmed.data() + trimmed.size(), time);
  if (error != std::errc{} || end != trimmed.data() + trimmed.size() || !std::isfinite(time))
    throw Error(ErrorCode::bad_data, name + ": timestep '" + text + "' is not a finite number");
  return time;
}

}  // namespace

Imported read_pvd(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  if (std::filesystem::file_size(request.file) > (64u << 20))
    throw Error(ErrorCode::too_large, name + ": above 64 MiB; a list of time steps is not that long");
  auto root = vtkSmartPointer<vtkXMLDataElement>::Take(vtkXMLUtilities::ReadElementFromFile(request.file.c_str()));
  throw_on_vtk_error(name);
  vtkXMLDataElement* collection = root ? root->FindNestedElementWithName("Collection") : nullptr;
  if (!collection) throw Error(ErrorCode::bad_data, name + ": expected a <Collection> of <DataSet> elements");

  std::map<double, std::vector<std::string>> files;  // ordered by time
  for (int i = 0; i < collection->GetNumberOfNestedElements(); ++i) {
    vtkXMLDataElement* entry = collection->GetNestedElement(i);
    if (!entry->GetName() || std::strcmp(entry->GetName(), "DataSet") != 0) continue;
    const char* file = entry->GetAttribute("file");
    if (!file) throw Error(ErrorCode::bad_data, name + ": a <DataSet> without a file");
    files[time_of(entry, name)].push_back(file);
  }
  if (files.empty()) throw Error(ErrorCode::bad_data, name + ": lists no files");
  check_step(request, files.size());

  Imported imported;
  const auto step = std::next(files.begin(), request.step);
  for (const std::string& file : step->second) {
    ReadRequest part = request;
    part.file = referred_file(request.file, file);
    part.step = 0;
    if (recognise(part.file).kind == FileKind::pvd)
      throw Error(ErrorCode::bad_data, name + ": lists another list, '" + file + "'");
    Imported one = read_file(part);
    for (Block& block : one.blocks) imported.blocks.push_back(std::move(block));
    for (std::string& note : one.notes) imported.notes.push_back(std::move(note));
  }
  imported.times.clear();
  for (const auto& [time, ignored] : files) imported.times.push_back(time);
  return imported;
}

}  // namespace isostrata
