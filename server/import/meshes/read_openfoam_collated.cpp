#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "data/files/file_beginning.h"
#include "data/files/openfoam_case.h"
#include "import/bytes/mapped_file.h"
#include "import/bytes/parsed_number.h"
#include "import/meshes/openfoam_collated.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestHead = 8192;
constexpr std::size_t kMostProcessors = 100'000;
constexpr const char* kMeshFiles[] = {"points", "faces", "owner", "neighbour", "boundary"};

/// Of "processors8_2-3": 8 processors, of which this folder has number 2 to before 4.
struct Processors {
  std::size_t all = 0, first = 0, end = 0;
};

std::optional<Processors> processors_named(std::string_view name) {
  if (!name.starts_with("processors")) return std::nullopt;
  name.remove_prefix(10);
  const auto line = name.find('_'), dash = name.find('-');
  const auto all = parsed_number<std::size_t>(name.substr(0, line));
  if (!all) return std::nullopt;
  if (line == std::string_view::npos) return Processors{*all, 0, *all};
  if (dash == std::string_view::npos || dash < line) return std::nullopt;
  const auto first = parsed_number<std::size_t>(name.substr(line + 1, dash - line - 1)), last = parsed_number<std::size_t>(name.substr(dash + 1));
  if (!first || !last || *last < *first || *last >= *all) return std::nullopt;
  return Processors{*all, *first, *last + 1};
}

/// Where the entry FoamFile of a text ends; 0 if there is none.
std::size_t end_of_header(std::string_view text) {
  const auto at = text.substr(0, kLongestHead).find("FoamFile"), open = at == std::string_view::npos ? at : text.find('{', at);
  const auto close = open == std::string_view::npos ? open : text.substr(0, 2 * kLongestHead).find('}', open);
  return close == std::string_view::npos ? 0 : close + 1;
}

/// What FoamFile says it is: "volScalarField". Empty if it says nothing.
std::string_view class_of(std::string_view text) {
  text = text.substr(0, end_of_header(text));
  constexpr std::string_view kBlanks = " \t\r\n";
  for (auto at = text.find("class"); at != std::string_view::npos; at = text.find("class", at + 5)) {
    const auto begin = text.find_first_not_of(kBlanks, at + 5), end = text.find(';', at);
    if (begin == at + 5 || end == std::string_view::npos || begin >= end) continue;
    const std::string_view word = text.substr(begin, end - begin);
    return word.substr(0, word.find_last_not_of(kBlanks) + 1);
  }
  return {};
}

std::string_view all_text(const MappedFile& file) { return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()}; }

/// "processors4/0.5/p", for messages.
std::string place_of(const fs::path& file, const fs::path& folder) { return (folder.filename() / file.lexically_relative(folder)).string(); }

/// Behind blanks and remarks.
std::size_t next_word(std::string_view text, std::size_t at) {
  while (at < text.size()) {
    if (std::isspace(static_cast<unsigned char>(text[at])))
      ++at;
    else if (text.substr(at, 2) == "//")
      at = std::min(text.find('\n', at), text.size());
    else
      break;
  }
  return at;
}

/// The blocks of a file: a number of bytes, then these in brackets.
std::vector<std::string_view> blocks_of(std::string_view text, std::size_t expected, const std::string& place) {
  std::vector<std::string_view> blocks;
  for (std::size_t at = next_word(text, end_of_header(text)); at < text.size(); at = next_word(text, at)) {
    const auto number_end = std::min(text.find_first_not_of("0123456789", at), text.size());
    const auto bytes = parsed_number<std::uint64_t>(text.substr(at, number_end - at));
    if (!bytes) throw Error(ErrorCode::bad_data, place + ": expected the number of bytes of block " + std::to_string(blocks.size()) + ", as a file of class decomposedBlockData has it");
    at = next_word(text, number_end);
    const bool open = at < text.size() && text[at] == '(';
    if (!open && *bytes == 0) {
      blocks.emplace_back();
      continue;
    }
    if (!open || *bytes > text.size() - at - 1 || at + 1 + *bytes == text.size() || text[at + 1 + *bytes] != ')')
      throw Error(ErrorCode::bad_data, place + ": is cut off, or damaged: expected " + std::to_string(*bytes) + " bytes in brackets as block " + std::to_string(blocks.size()));
    blocks.push_back(text.substr(at + 1, *bytes));
    at += *bytes + 2;
  }
  if (blocks.size() != expected)
    throw Error(ErrorCode::bad_data, place + ": has " + std::to_string(blocks.size()) + " blocks; expected " + std::to_string(expected) + ", one of each processor of its folder");
  return blocks;
}

/// What VTK's reader reads, not what flows through faces.
bool is_field(const fs::path& file) {
  const std::string head = file_beginning(file, 4 * kLongestHead);
  if (class_of(head) != "decomposedBlockData") return false;
  const std::string_view kind = class_of(std::string_view(head).substr(end_of_header(head)));
  return kind.starts_with("vol") || kind.starts_with("point");
}

/// A mesh that moves or changes has its new files in the folders of times.
fs::path newest(const CollatedCase& of, std::size_t step, const fs::path& folder, const fs::path& file) {
  std::error_code error;
  for (std::size_t i = step + 1; i-- > 0;)
    if (const fs::path at = folder / of.names[i] / file; fs::exists(at, error)) return at;
  const fs::path at = folder / "constant" / file;
  if (!fs::exists(at, error)) throw Error(ErrorCode::not_found, place_of(at, folder) + ": no such file; expected it in the mesh of a collated case");
  return at;
}

std::vector<std::string> regions_of(const fs::path& folder) {
  std::vector<std::string> out;
  std::error_code error;
  if (fs::is_directory(folder / "constant/polyMesh", error)) out.emplace_back();
  for (fs::directory_iterator it(folder / "constant", error), end; !error && it != end; it.increment(error))
    if (fs::is_directory(it->path() / "polyMesh", error)) out.push_back(it->path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

std::vector<fs::path> parts_of(const CollatedCase& of, const ReadRequest& request) {
  std::vector<fs::path> out;
  for (const fs::path& folder : of.folders) {
    const Processors own = *processors_named(folder.filename().string());
    for (std::size_t p = own.first; p < own.end; ++p) out.push_back(request.scratch / ("processor" + std::to_string(p)));
  }
  return out;
}

}  // namespace

CollatedCase collated_case(const std::vector<fs::path>& folders, const std::string& name) {
  std::map<std::size_t, std::pair<Processors, fs::path>> found;
  for (const fs::path& folder : folders)
    if (const auto of = processors_named(folder.filename().string())) found.emplace(of->first, std::pair(*of, folder));
  CollatedCase out;
  std::size_t next = 0, all = 0;
  std::map<double, std::string> times;
  for (const auto& [first, part] : found) {
    if (first != next || (all > 0 && part.first.all != all)) throw Error(ErrorCode::bad_data, name + ": expected processor " + std::to_string(next) + " in a folder beside " + part.second.filename().string());
    all = part.first.all;
    next = part.first.end;
    const auto own = openfoam_times(part.second);
    if (out.folders.empty())
      times = own;
    else
      std::erase_if(times, [&](const auto& time) { return !own.contains(time.first) || own.at(time.first) != time.second; });
    out.folders.push_back(part.second);
  }
  if (all > kMostProcessors) throw Error(ErrorCode::too_large, name + ": has files of " + std::to_string(all) + " processors; expected at most " + std::to_string(kMostProcessors));
  if (next != all || all == 0) throw Error(ErrorCode::bad_data, name + ": expected folders of " + std::to_string(all) + " processors, and " + std::to_string(next) + " have one");
  if (times.empty()) throw Error(ErrorCode::bad_data, name + ": its folder " + out.folders.front().filename().string() + " has no times, or none in common with the others");
  for (const auto& [time, called] : times) {
    out.times.push_back(time);
    out.names.push_back(called);
  }
  out.regions = regions_of(out.folders.front());
  if (out.regions.size() > 1 && out.regions.front().empty() && has_fields_in_regions_alone(out.folders.front())) out.regions.erase(out.regions.begin());
  if (out.regions.empty()) throw Error(ErrorCode::bad_data, name + ": expected a mesh in " + out.folders.front().filename().string() + "/constant/polyMesh");
  return out;
}

void make_folders_of_processors(const ReadRequest& request) {
  std::error_code error;
  const fs::path folder = fs::is_directory(request.file, error) ? request.file : request.file.parent_path();
  if (folder != request.file && request.file.extension() != ".foam" && request.file.extension() != ".openfoam") return;
  const std::vector<fs::path> folders = openfoam_parts(folder);
  if (folders.empty() || !is_collated_name(folders.front().filename().string())) return;
  try {
    const CollatedCase of = collated_case(folders, request.file.filename().string());
    if (static_cast<std::size_t>(request.step) >= of.names.size()) return;
    for (const fs::path& part : parts_of(of, request))
      for (const std::string& region : of.regions) {
        fs::create_directories(part / "constant" / region / "polyMesh", error);
        fs::create_directories(part / of.names[static_cast<std::size_t>(request.step)] / region, error);
      }
  } catch (const Error&) {
    // The reader says it.
  }
}

TakenApart::TakenApart(const CollatedCase& of, const ReadRequest& request) : request_(request), folders_(parts_of(of, request)) {
  const auto step = static_cast<std::size_t>(request.step);
  std::size_t first = 0;
  for (const fs::path& folder : of.folders) {
    const Processors own = *processors_named(folder.filename().string());
    for (const std::string& region : of.regions) {
      for (const char* name : kMeshFiles) {
        const fs::path file = fs::path(region) / "polyMesh" / name;
        split(newest(of, step, folder, file), folder, {first, own.end - own.first}, "constant" / file);
      }
      std::error_code error;
      for (fs::directory_iterator it(folder / of.names[step] / region, error), end; !error && it != end; it.increment(error))
        if (it->is_regular_file(error) && is_field(it->path())) split(it->path(), folder, {first, own.end - own.first}, fs::path(of.names[step]) / region / it->path().filename());
    }
    first += own.end - own.first;
  }
}

TakenApart::~TakenApart() {
  std::error_code ignored;
  for (const fs::path& file : files_) fs::remove(file, ignored);
}

void TakenApart::split(const fs::path& from, const fs::path& folder, const Run& processors, const fs::path& to) {
  const MappedFile file(from);
  const std::string place = place_of(from, folder);
  const std::string_view text = all_text(file);
  if (class_of(text) != "decomposedBlockData") throw Error(ErrorCode::bad_data, place + ": expected a file of class decomposedBlockData");
  const auto blocks = blocks_of(text, processors.count, place);
  const std::string_view header = blocks.front().substr(0, end_of_header(blocks.front()));
  if (header.empty()) throw Error(ErrorCode::bad_data, place + ": its first block has no entry FoamFile");
  check_bytes(request_, bytes_ += text.size(), request_.file.filename().string() + ": its blocks");
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    files_.push_back(folders_[processors.first + i] / to);
    std::ofstream out(files_.back(), std::ios::binary);
    if (class_of(blocks[i]).empty()) out << header << "\n";  // the first block has it for all
    out << blocks[i];
    if (!out.flush()) throw Error(ErrorCode::unavailable, place + ": cannot be taken apart: no room for it in " + request_.scratch.string());
  }
}

}  // namespace isostrata
