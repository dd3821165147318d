// isostrata-import: reads one time step of one foreign file and writes plain arrays, or makes a copy of itself for each that is to be read. What it has
// no reader for becomes isostrata-import-all's, if it is there. Started by data/open/import_door.h only; what a reader says:
//   standard output   "progress FRACTION" lines
//   standard error    one last line "error CODE MESSAGE" if it fails, exit status 1
#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/parallel.h"
#include "base/program_file.h"
#include "base/spawn.h"
#include "data/files/recognise.h"
#include "data/files/zarr_folder.h"
#include "data/open/importer_request.h"
#include "import/limits/confine.h"
#ifdef ISOSTRATA_READS_ENSIGHT
#include "import/meshes/ensight_quotes.h"
#endif
#include "import/limits/fork_for_files.h"
#include "import/limits/memory_limit.h"
#ifdef ISOSTRATA_READS_OPENFOAM
#include "import/meshes/openfoam_collated.h"
#include "import/meshes/openfoam_originals.h"
#endif
#include "import/bytes/parsed_number.h"
#include "import/dataset/missing_values.h"
#include "import/dataset/write_dataset.h"
#include "import/imported/read_file.h"
#include "import/imported/read_own.h"
#include "import/imported/vtk_messages.h"

namespace {

using isostrata::Error;
using isostrata::ErrorCode;

constexpr int kMostThreads = 4;  // each has 8 MiB of the address space, which is bounded

constexpr const char* kUsage =
    "usage: isostrata-import FILE DIRECTORY STEP MAX-BYTES CPU-SECONDS require|try|off [LIKE], or --fork-for-files (started by isostrata, not by people)\n";

/// Readers that met damage were seen to crash in their destructors, so nothing is destroyed at the end: everything is on disk, or
/// said.
[[noreturn]] void end(int status) {
  std::fflush(nullptr);
  std::_Exit(status);
}

[[noreturn]] void fail(ErrorCode code, const std::string& message) {
  std::string line = message;
  for (char& c : line)
    if (c == '\n' || c == '\r') c = ' ';
  std::fprintf(stderr, "error %s %s\n", to_string(code), line.c_str());
  end(1);
}

std::uint64_t number(const std::string& text) {
  const auto value = isostrata::parsed_number<std::uint64_t>(text);
  if (!value) throw Error(ErrorCode::invalid_argument, "'" + text + "' is not a number");
  return *value;
}

void run(const std::vector<std::string>& words) {
  isostrata::ReadRequest request;
  request.file = std::filesystem::absolute(words[0]);
  const std::filesystem::path output = words[1];
  request.scratch = output;
  request.step = static_cast<int>(number(words[2]));
  request.max_bytes = number(words[3]);
  if (words.size() == 7) request.like_step = static_cast<int>(number(words[6]));
  double reported = -1;
  request.progress = [reported](double fraction) mutable {
    if (fraction < reported + 0.01) return;
    reported = fraction;
    std::printf("progress %.3f\n", fraction);
    std::fflush(stdout);
  };
  isostrata::set_thread_count(kMostThreads);
  isostrata::collect_vtk_messages(request.file.filename().string());
  isostrata::prepare_pictures(request.file);
#ifdef ISOSTRATA_READS_OPENFOAM
  isostrata::make_folders_of_processors(request);
  isostrata::make_links_without_originals(request);
#endif
#ifdef ISOSTRATA_READS_ENSIGHT
  isostrata::make_links_without_blanks(request);
#endif
  std::error_code error;
  const bool folder = std::filesystem::is_directory(request.file, error);
  isostrata::confine({.directory = folder ? request.file : request.file.parent_path(),
                      .file = request.file,
                      .beside = folder ? isostrata::zarr_files_above(request.file) : std::vector<std::filesystem::path>{},
                      .output = output,
                      .memory_bytes = isostrata::memory_limit(request.file, request.max_bytes),
                      .cpu_seconds = isostrata::cpu_limit(request.file, number(words[4])),
                      .sandbox = isostrata::sandbox_of(words[5])});
  isostrata::Imported imported = read_file(request);
  leave_out_missing(imported, request);
  write_dataset(std::move(imported), request, output);
}

#ifdef ISOSTRATA_HANDS_ON
/// This process becomes the program that has all readers, if the file needs it, or notes that it needs the reader of pictures. Who asks a process that is loaded already has chosen between the two, so a
/// copy looks at no file before it is confined.
void hand_on(const std::vector<std::string>& words) {
  try {
    const isostrata::ReaderNeeds needs = isostrata::reader_needs(words[0]);
    if (needs.pictures) setenv(isostrata::kPictureVariable, "yes", 1);
    if (needs.all_readers) isostrata::become(isostrata::program_file().parent_path() / "isostrata-import-all", words);
  } catch (const Error& error) {
    fail(error.code(), error.what());
  }
}
#endif

/// words: those of the usage.
[[noreturn]] void read_one(const std::vector<std::string>& words) {
  if (words.size() != 6 && words.size() != 7) {
    std::fprintf(stderr, "%s", kUsage);
    end(2);
  }
  const std::string name = std::filesystem::path(words[0]).filename().string();
  try {
    run(words);
  } catch (const Error& error) {
    fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    fail(ErrorCode::too_large, name + ": needs more memory than the import is allowed");
  } catch (const std::length_error&) {
    fail(ErrorCode::bad_data, name + ": declares an absurd size");
  } catch (const std::exception& error) {
    fail(ErrorCode::bad_data, name + ": " + error.what());
  }
  end(0);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  if (words.size() == 1 && words[0] == isostrata::kForkForFiles) isostrata::fork_for_files(read_one);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for what a dead worker has asked for; a copy has seen to it
#ifdef ISOSTRATA_HANDS_ON
  if (!words.empty()) hand_on(words);
#endif
  read_one(words);
}
