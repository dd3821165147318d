#include "main/run_program.h"

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "main/cache_environment.h"
#include "main/ranks.h"
#include "session/journal/protobuf_log.h"

namespace isostrata {

int run_program(CLI::App& app, int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of the write, not the end of the program
  silence_protobuf();             // a server has it speak through its log; a worker's lines would be nobody's
  app.set_version_flag("--version", "isostrata " ISOSTRATA_VERSION);
  set_command_line(argc, argv);
  try {
    use_simd_level_of_environment();
    set_import_cache(import_cache_of_environment());
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "isostrata: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace isostrata
