#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "data/files/decimal_names.h"
#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "import/adaptive/amrex_header.h"
#include "import/imported/declared_time.h"
#include "import/imported/list_file.h"
#include "import/imported/read_file.h"
#include "import/imported/read_own.h"

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

/// One step of a list: where it lies, and which step of its files it is.
struct Listed {
  double time = 0;
  std::vector<std::filesystem::path> files;
  int step = 0;
};

constexpr std::size_t kMostSteps = 1'000'000;

/// Of a step that is one file, and the only one there.
const Listed* in_memory(const ReadRequest& request, const std::vector<Listed>& steps) {
  if (!request.like_step || *request.like_step >= static_cast<int>(steps.size())) return nullptr;
  const Listed& like = steps[static_cast<std::size_t>(*request.like_step)];
  return like.files.size() == 1 && like.step == 0 ? &like : nullptr;
}

/// An array of NumPy has no name but its file's, which differs from step to step: it gets that of the series, "p" of "p_*.npy".
void name_by_series(const std::filesystem::path& series, const std::filesystem::path& file, Imported& step) {
  const std::string name = small_letters(file.filename().string());
  if (!name.ends_with(".npy") && !name.ends_with(".npy.gz")) return;
  std::string common = series.stem().string();
  if (series.extension() == ".series" || small_letters(series.extension().string()) == ".gz") common = std::filesystem::path(common).stem().string();
  std::erase(common, '*');
  constexpr std::string_view kBetween = " _-.";
  common.erase(0, common.find_first_not_of(kBetween));
  common.erase(common.find_last_not_of(kBetween) + 1);
  for (Block& block : step.blocks)
    for (FileArray& array : block.arrays) array.name = common.empty() ? "values" : common;
}

Imported read_listed(const ReadRequest& request, const std::vector<Listed>& steps) {
  check_step(request, steps.size());
  Imported imported;
  imported.times.clear();
  for (const Listed& step : steps) imported.times.push_back(step.time);
  if (request.times_only) return imported;
  const Listed& wanted = steps[static_cast<std::size_t>(request.step)];
  for (const std::filesystem::path& file : wanted.files) {
    ReadRequest part = request;
    part.file = file;
    part.step = wanted.step;
    part.like_step.reset();
    if (const Listed* const like = in_memory(request, steps); like && wanted.files.size() == 1) part.like = like->files.front();
    ++part.depth;
    Imported one = read_file(part);
    name_by_series(request.file, file, one);
    imported.axes = std::move(one.axes);
    for (Block& block : one.blocks) imported.blocks.push_back(std::move(block));
    for (std::string& note : one.notes) imported.notes.push_back(std::move(note));
  }
  return imported;
}

/// All of its steps with their times; none if the file does not say a time.
std::vector<double> times_of(const std::filesystem::path& file, const ReadRequest& request) {
  const FileKind kind = recognise(file).kind;
  if (kind == FileKind::amrex) return {read_amrex_header(file).time};
  if (kind == FileKind::vtk_xml || kind == FileKind::vtk_legacy || kind == FileKind::multi_block) {
    const std::optional<double> time = declared_time(file);
    return time ? std::vector<double>{*time} : std::vector<double>{};
  }
  if (kind != FileKind::exodus && kind != FileKind::netcdf && kind != FileKind::cgns && kind != FileKind::vtkhdf && kind != FileKind::xdmf) return {};
  ReadRequest asked = request;
  asked.file = file;
  asked.step = 0;
  asked.times_only = true;
  ++asked.depth;
  asked.progress = [](double) {};
  const std::vector<double> times = read_file(asked).times;
  return times == std::vector<double>{0.0} ? std::vector<double>{} : times;
}

/// The last file of a series that grows may not be one yet: it is left out, and what is said of that is given back.
std::string leave_out_unfinished(std::vector<SeriesFile>& files) {
  if (files.size() < 2) return {};
  try {
    recognise(files.back().path);
    return {};
  } catch (const Error& error) {
    files.pop_back();
    return "the last file is left out: " + std::string(error.what());
  }
}

}  // namespace

Imported read_pvd(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_list_depth(request);
  const auto root = parse_small_xml(request);
  vtkXMLDataElement* collection = root->FindNestedElementWithName("Collection");
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
  std::vector<Listed> steps;
  for (const auto& [time, names] : files) {
    Listed& step = steps.emplace_back();
    step.time = time;
    const int number = static_cast<int>(steps.size()) - 1;
    if (number != request.step && number != request.like_step) continue;  // the others may not be there yet
    for (const std::string& file : names) {
      step.files.push_back(referred_file(request.file, file));
      if (recognise(step.files.back()).kind == FileKind::pvd) throw Error(ErrorCode::bad_data, name + ": lists another list, '" + file + "'");
    }
  }
  return read_listed(request, steps);
}

// {"file-series-version": "1.0", "files": [{"name": "x_0.vtu", "time": 0.5}, ...]}
Imported read_series_file(const ReadRequest& request) {
  namespace json = boost::json;
  const std::string name = request.file.filename().string();
  check_list_depth(request);
  check_text_size(request.file);
  std::ifstream in(request.file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  boost::system::error_code error;
  const json::value root = json::parse(text, error);
  const json::object* object = error ? nullptr : root.if_object();
  const json::value* list = object ? object->if_contains("files") : nullptr;
  if (!list || !list->is_array() || list->as_array().empty())
    throw Error(ErrorCode::bad_data, name + ": expected {\"file-series-version\":\"1.0\",\"files\":[{\"name\":...,\"time\":...},...]}");
  std::multimap<double, std::string> files;
  for (const json::value& entry : list->as_array()) {
    const json::object* of = entry.if_object();
    const json::value* file = of ? of->if_contains("name") : nullptr;
    const json::value* at = of ? of->if_contains("time") : nullptr;
    boost::system::error_code no_number;
    const double time = at ? at->to_number<double>(no_number) : static_cast<double>(files.size());
    if (!file || !file->is_string() || no_number || !std::isfinite(time))
      throw Error(ErrorCode::bad_data, name + ": entry " + std::to_string(files.size()) + " has no name, or a time that is not a finite number");
    files.emplace(time, std::string(file->as_string()));
    if (files.size() > kMostSteps) throw Error(ErrorCode::too_large, name + ": more than " + std::to_string(kMostSteps) + " files");
  }
  check_step(request, files.size());
  std::vector<Listed> steps;
  for (const auto& [time, file] : files) {
    Listed& step = steps.emplace_back();
    step.time = time;
    if (const int number = static_cast<int>(steps.size()) - 1; number == request.step || number == request.like_step) step.files.push_back(referred_file(request.file, file));
  }
  return read_listed(request, steps);
}

Imported read_numbered(const ReadRequest& request) {
  const std::string name = request.file.filename().string();
  check_list_depth(request);
  std::vector<SeriesFile> files = series_files(request.file);
  if (is_dicom_slice(files.front().path)) return read_dicom(request);
  const std::string left_out = leave_out_unfinished(files);
  std::vector<Listed> said, counted;
  bool all_say = true;
  const std::vector<double> decimals = decimals_in_names(name, files);
  const bool one_number = files.back().numbers.size() == 1 || !decimals.empty();
  for (std::size_t i = 0; i < files.size(); ++i) {
    const SeriesFile& file = files[i];
    const double number = !decimals.empty() ? decimals[i] : one_number ? static_cast<double>(file.numbers[0]) : static_cast<double>(i);
    counted.push_back({number, {file.path}, 0});
    if (!all_say) continue;
    const std::vector<double> times = times_of(file.path, request);
    all_say = !times.empty();
    if (all_say && name.ends_with("-s*"))  // what a restart computed again replaces what was there
      std::erase_if(said, [&](const Listed& before) { return before.time >= times.front(); });
    for (std::size_t t = 0; t < times.size(); ++t) said.push_back({times[t], {file.path}, static_cast<int>(t)});
    if (said.size() > kMostSteps) throw Error(ErrorCode::too_large, name + ": more than " + std::to_string(kMostSteps) + " steps");
  }
  const auto later = [](const Listed& a, const Listed& b) { return a.files == b.files ? b.time < a.time : !(a.time < b.time); };  // one file may have a time twice
  const bool increasing = std::adjacent_find(said.begin(), said.end(), later) == said.end();
  const bool use_said = all_say && increasing;
  Imported imported = read_listed(request, use_said ? said : counted);
  imported.notes.push_back(std::to_string(files.size()) + " files as one series; times are " +
                           (use_said ? "those that the files say" : one_number ? "the numbers in their names" : "counted from 0"));
  if (!left_out.empty()) imported.notes.push_back(left_out);
  return imported;
}

}  // namespace isostrata
