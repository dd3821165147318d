// isostrata-rank: one rank of a parallel job. The first rank is `isostrata render`, `isostrata extract` or the worker of `isostrata serve`, with
// the same options; the others extract and draw with it.
#include <sys/prctl.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "base/simd_level.h"
#include "main/cache_environment.h"
#include "main/commands.h"
#include "main/ranks.h"
#include "main/simd_option.h"
#include "rank/first_rank.h"
#include "rank/other_rank.h"
#include "session/journal/protobuf_log.h"
#include "worker/launch_ranks.h"

namespace isostrata {
namespace {

int lead(RankLine& line, int argc, char** argv) {
  CLI::App app{"One of the processes that hold a dataset together: started by `isostrata COMMAND --ranks LAUNCHER`, or by a launcher itself: "
               "mpirun -n 4 isostrata-rank render FILE ..."};
  app.set_version_flag("--version", "isostrata-rank " ISOSTRATA_VERSION);
  app.require_subcommand(1);
  const std::unique_ptr<SceneRanks> ranks = lead_ranks(line);
  use_ranks(ranks.get());
  add_render_command(app);
  add_extract_command(app);
  CLI::App* worker = app.add_subcommand("worker", "Draws for `isostrata serve --ranks`, which starts it");
  worker->group("");
  std::string socket;
  int status = 0;
  worker->add_option("--socket", socket)->required();
  worker->callback([&] {
    prctl(PR_SET_DUMPABLE, 0);  // as in serve
    status = run_worker(take_worker_descriptors(socket), {}, ranks.get());
  });
  for (CLI::App* command : app.get_subcommands({})) add_simd_option(*command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "isostrata-rank: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-rank: %s\n", error.what());
    return 1;
  }
  return status;
}

/// Of what it can still say of one order it replies; here is what remains.
int follow(RankLine& line) {
  try {
    serve_orders(line);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-rank: rank %d on %s: %s\n", line.rank(), line.node().c_str(), error.what());
    std::fflush(stderr);
    line.abort();
    return 1;
  }
}

}  // namespace
}  // namespace isostrata

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // no rank outlives what has started it
  isostrata::silence_protobuf();
  try {
    isostrata::use_simd_level_of_environment();
    isostrata::set_import_cache(isostrata::import_cache_of_environment());
    isostrata::RankLine line(argc, argv);
    return line.rank() == 0 ? isostrata::lead(line, argc, argv) : isostrata::follow(line);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata-rank: %s\n", error.what());
    std::fflush(stderr);
    return 1;
  }
}
