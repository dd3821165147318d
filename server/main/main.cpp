// isostrata: the server and its offline twin.
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "base/error.h"
#include "base/simd_level.h"
#include "main/cache_environment.h"
#include "main/commands.h"
#include "main/ranks.h"
#include "main/simd_option.h"
#include "session/journal/protobuf_log.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a limit on the size of files is an error of the write, not the end of the program
  isostrata::silence_protobuf();          // a server has it speak through its log; a worker's lines would be nobody's
  CLI::App app{"Isostrata: interval volumes of scalar fields, extracted exactly, rendered here, seen in a browser"};
  app.set_version_flag("--version", "isostrata " ISOSTRATA_VERSION);
  app.require_subcommand(1);
  isostrata::add_serve_command(app);
  isostrata::add_info_command(app);
  isostrata::add_first_view_command(app);
  isostrata::add_extract_command(app);
  isostrata::add_render_command(app);
  isostrata::add_bench_command(app);
  isostrata::add_tables_command(app);
  isostrata::add_doctor_command(app);
  isostrata::add_cache_command(app);
  isostrata::add_worker_command(app);
  for (CLI::App* command : app.get_subcommands({})) isostrata::add_simd_option(*command);

  isostrata::set_command_line(argc, argv);
  try {
    isostrata::use_simd_level_of_environment();
    isostrata::set_import_cache(isostrata::import_cache_of_environment());
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
