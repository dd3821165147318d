#include "data/open/import_door.h"

#include <fcntl.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <functional>
#include <iterator>
#include <optional>
#include <system_error>
#include <utility>

#include "base/program_file.h"
#include "base/temporary_directory.h"
#include "data/files/beneath.h"
#include "data/files/file_series.h"
#include "data/files/recognise.h"
#include "data/open/child_process.h"
#include "data/open/loaded_importer.h"
#include "data/open/sandbox.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

ErrorCode code_of(std::string_view word) {
  for (const ErrorCode code : {ErrorCode::invalid_argument, ErrorCode::not_found, ErrorCode::bad_data, ErrorCode::unsupported,
                               ErrorCode::too_large, ErrorCode::unavailable, ErrorCode::internal})
    if (word == to_string(code)) return code;
  return ErrorCode::bad_data;
}

std::string last_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  if (const auto newline = text.rfind('\n'); newline != std::string::npos) text.erase(0, newline + 1);
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c == 127; }, ' ');
  return text.substr(0, 2000);
}

/// What the child's end means. Its last line is "error CODE MESSAGE" where it could still say so.
[[noreturn]] void throw_failure(const ChildResult& result, const std::string& name) {
  if (result.signal == SIGXCPU)
    throw Error(ErrorCode::bad_data, name + ": the reader was ended because it used too much processor time");
  if (result.signal != 0)
    throw Error(ErrorCode::bad_data, name + ": the reader crashed (signal " + std::to_string(result.signal) + ")");
  const std::string line = last_line(result.errors);
  if (line.starts_with("error ")) {
    const auto space = line.find(' ', 6);
    if (space != std::string::npos) throw Error(code_of(std::string_view(line).substr(6, space - 6)), line.substr(space + 1));
  }
  throw Error(ErrorCode::bad_data,
              name + ": the reader failed with status " + std::to_string(result.exit_status) + (line.empty() ? "" : ": " + line));
}

}  // namespace

fs::path default_importer(bool all_readers) {
  std::error_code error;
  const fs::path importer = program_file().parent_path() / (all_readers ? "isostrata-import-all" : "isostrata-import");
  if (!fs::exists(importer, error))
    throw Error(ErrorCode::unavailable, importer.string() + " is not there: files cannot be read, only analytic data");
  return importer;
}

namespace {

/// A dataset and the files that it is mapped from.
struct Kept {
  std::shared_ptr<const Dataset> dataset;
  std::optional<TemporaryDirectory> files;
};

/// What the kept directory of this step of this file is called, and what is written into it, so that no other is taken for it.
std::pair<std::string, std::string> kept_name(const fs::path& file, int step) {
  const SourceStamp stamp = stamp_of(file);
  const std::string text = fs::absolute(file).string() + '\n' + std::to_string(step) + '\n' + std::to_string(stamp.bytes) + '\n' +
                           std::to_string(stamp.changed) + '\n';
  return {"kept-" + std::to_string(std::hash<std::string>{}(text)), text};
}

bool is_kept(const fs::path& directory, const std::string& origin) {
  std::ifstream file(directory / kOriginFile, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return file && text == origin;
}

}  // namespace

bool may_lie_in_place(const fs::path& file) {
  const std::string ending = small_letters(file.extension().string());
  static constexpr std::array<std::string_view, 10> kEndings{".nrrd", ".nhdr", ".mha", ".mhd", ".vti", ".npy", ".raw", ".bov", ".mif", ".am"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

bool has_own_grid(const Dataset& dataset, const ImportOptions& options) {
  return !options.like || !dataset.grid.storage || dataset.grid.storage != options.like->grid.storage;
}

void check_source(const fs::path& file, const OpenOptions& options) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  const int opened = open_beneath(file, O_PATH);
  const int why = errno;
  if (opened >= 0) close(opened);
  if (opened < 0 && why == EXDEV)
    throw Error(ErrorCode::not_found, file.string() + ": is now a link out of the directory that is served, and is not followed");
  if (is_series_pattern(file))
    series_files(file);  // throws if there are none
  else if (file.empty() || !fs::exists(status))
    throw Error(ErrorCode::not_found, file.string() + ": no such file or analytic data");
  if (options.step < 0)
    throw Error(ErrorCode::not_found, file.string() + ": no step " + std::to_string(options.step) + "; steps count from 0");
}

void import_into(const fs::path& directory, const fs::path& file, const ImportOptions& options, const Task& task) {
  const std::string name = file.filename().string();
  task.report(0, "reading");
  const auto cpu_seconds = static_cast<std::uint64_t>(std::clamp(std::ceil(options.timeout_s), 1.0, 1e6)) + 1;
  ChildResult result;
  try {
    std::vector<std::string> words{fs::absolute(file).string(), directory.string(), std::to_string(options.step),
                                   std::to_string(options.max_bytes), std::to_string(cpu_seconds), to_string(sandbox())};
    if (options.like) words.push_back(std::to_string(options.like->step));
    const auto on_line = [&](std::string_view line) {
      if (!line.starts_with("progress ")) return;
      double fraction = 0;
      std::from_chars(line.data() + 9, line.data() + line.size(), fraction);
      if (fraction >= 0 && fraction <= 1) task.report(0.9 * fraction, "reading");
    };
    if (options.importer.empty()) {
      const ReaderNeeds needs = options.needs ? *options.needs : reader_needs(file);
      const auto start = [&](int out, int err) { return start_loaded_importer(words, needs, out, err); };
      result = follow_child(start, options.timeout_s, task, on_line);
    } else {
      result = run_child({options.importer, words, importer_environment()}, options.timeout_s, task, on_line);
    }
  } catch (const Error& failure) {
    if (failure.code() != ErrorCode::bad_data) throw;
    throw Error(ErrorCode::bad_data, name + ": " + failure.what());
  }
  if (result.signal != 0 || result.exit_status != 0) throw_failure(result, name);
  task.report(0.9, "checking");
}

std::shared_ptr<const Dataset> open_import(const fs::path& file, const ImportOptions& options, const Task& task) {
  check_source(file, options);
  const TemporaryDirectory directory(temporary_base(), "isostrata-import-");
  import_into(directory.path(), file, options, task);
  auto dataset = map_import(directory.path(), file, options, ImportFiles::unlinked);
  task.report(1, "reading");
  return dataset;
}

std::shared_ptr<const Dataset> open_import_keeping(const fs::path& file, const ImportOptions& options, const fs::path& keep,
                                                   const Task& task) {
  check_source(file, options);
  const auto [name, origin] = kept_name(file, options.step);
  const fs::path place = keep / name;
  auto kept = std::make_shared<Kept>();
  if (is_kept(place, origin)) {
    kept->files.emplace(place);
    try {
      kept->dataset = map_import(place, file, options, ImportFiles::left);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::bad_data) throw;
      kept = std::make_shared<Kept>();  // damaged since: it is gone, and read again
    }
  }
  if (!kept->dataset) {
    kept->files.emplace(temporary_base(), "isostrata-import-");
    import_into(kept->files->path(), file, options, task);
    kept->dataset = map_import(kept->files->path(), file, options, ImportFiles::left);
    if (has_own_grid(*kept->dataset, options)) {
      std::ofstream(kept->files->path() / kOriginFile, std::ios::binary) << origin;
      if (!kept->files->move_to(place)) kept->files.reset();  // there is one already
    }
  }
  task.report(1, "reading");
  return {kept, kept->dataset.get()};
}

}  // namespace isostrata
