// isostrata-import: reads one time step of one foreign file and writes plain arrays. Started by data/import_door.h only; what it
// says:
//   standard output   "progress FRACTION" lines
//   standard error    one last line "error CODE MESSAGE" where it fails, exit status 1
#include <sys/prctl.h>

#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <string>

#include "base/error.h"
#include "base/parallel.h"
#include "import/confine.h"
#include "import/memory_limit.h"
#include "import/read_file.h"
#include "import/vtk_messages.h"
#include "import/write_dataset.h"

namespace {

using isostrata::Error;
using isostrata::ErrorCode;

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

std::uint64_t number(const char* text) {
  std::uint64_t value = 0;
  const char* end = text + std::strlen(text);
  const auto [at, error] = std::from_chars(text, end, value);
  if (error != std::errc{} || at != end) throw Error(ErrorCode::invalid_argument, std::string("'") + text + "' is not a number");
  return value;
}

void run(char** argv) {
  isostrata::ReadRequest request;
  request.file = std::filesystem::absolute(argv[1]);
  const std::filesystem::path output = argv[2];
  request.scratch = output;
  request.step = static_cast<int>(number(argv[3]));
  request.max_bytes = number(argv[4]);
  double reported = -1;
  request.progress = [reported](double fraction) mutable {
    if (fraction < reported + 0.01) return;
    reported = fraction;
    std::printf("progress %.3f\n", fraction);
    std::fflush(stdout);
  };
  isostrata::set_thread_count(1);
  isostrata::collect_vtk_messages();
  std::error_code error;
  const bool folder = std::filesystem::is_directory(request.file, error);
  isostrata::confine({.directory = folder ? request.file : request.file.parent_path(),
                      .file = request.file,
                      .output = output,
                      .memory_bytes = isostrata::memory_limit(request.file, request.max_bytes),
                      .cpu_seconds = isostrata::cpu_limit(request.file, number(argv[5])),
                      .sandbox = isostrata::sandbox_of(argv[6])});
  write_dataset(read_file(request), request, output);
}

}  // namespace

int main(int argc, char** argv) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for what a dead worker has asked for
  if (argc != 7) {
    std::fprintf(stderr,
                 "usage: isostrata-import FILE DIRECTORY STEP MAX-BYTES CPU-SECONDS require|try|off (started by isostrata, not by "
                 "people)\n");
    return 2;
  }
  const std::string name = std::filesystem::path(argv[1]).filename().string();
  try {
    run(argv);
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
