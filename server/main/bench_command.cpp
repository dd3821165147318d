#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/program_file.h"
#include "base/spawn.h"
#include "main/commands.h"

namespace isostrata {

void add_bench_command(CLI::App& app) {
  CLI::App* bench = app.add_subcommand("bench", "Measures this machine: extraction, drawing, codecs, what viewers get (isostrata-bench)");
  bench->prefix_command();   // every word behind it is the other program's
  bench->set_help_flag("");  // --help as well
  bench->callback([bench] {
    const std::filesystem::path program = program_file().parent_path() / "isostrata-bench";
    if (!std::filesystem::exists(program))
      throw Error(ErrorCode::unavailable, program.string() + " is not there; deploy/build isostrata-bench makes it");
    become(program, bench->remaining());
  });
}

}  // namespace isostrata
