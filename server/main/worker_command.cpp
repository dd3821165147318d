// isostrata worker: the process that draws for `isostrata serve`. Not for people, so it is not listed.
#include <sys/prctl.h>

#include <cstdlib>
#include <memory>
#include <utility>

#include "main/commands.h"
#include "main/ranks.h"
#include "worker/launch_ranks.h"
#include "worker/run_worker.h"

namespace isostrata {

void add_worker_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("worker", "Draws for `isostrata serve`, which starts it");
  command->group("");
  const auto arguments = std::make_shared<WorkerArguments>();
  command->add_option("--socket", arguments->socket)->required();
  command->add_option("--board", arguments->board)->required();
  command->add_option("--parent", arguments->parent)->required();
  command->add_flag("--shut-in", arguments->shut_in);
  for (auto [option, places] : {std::pair{"--read", &arguments->reach.read}, {"--names", &arguments->reach.names}, {"--write", &arguments->reach.write}})
    command->add_option(option, *places)->allow_extra_args(false);
  const auto launcher = std::make_shared<std::string>();
  add_ranks_option(*command, *launcher);
  command->callback([arguments, launcher] {
    prctl(PR_SET_DUMPABLE, 0);  // as in serve
    if (!launcher->empty()) std::exit(launch_ranks(*arguments, launcher_words(*launcher), rank_program()));
    std::exit(run_worker(*arguments));
  });
}

}  // namespace isostrata
