// A worker process for tests: draws plain colours, and fails in the ways of drivers where a scene's unit distance says so.
#include <sys/resource.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>

#include "support/plain_renderer.h"
#include "worker/run_worker.h"

namespace {

using namespace isostrata;

class FaultyRenderer final : public Renderer {
 public:
  DrawResult draw(const DrawInput& input) override {
    if (input.unit_distance == 13) std::abort();
    while (input.unit_distance == 14) pause();
    if (input.unit_distance == 15) std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return plain_.draw(input);
  }
  const std::string& device() const override { return plain_.device(); }

 private:
  PlainRenderer plain_{std::make_shared<PlainRendererControl>()};
};

}  // namespace

int main(int argc, char** argv) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  WorkerArguments arguments;
  for (int i = 1; i + 1 < argc; ++i) {
    if (!std::strcmp(argv[i], "--socket")) arguments.socket = std::atoi(argv[i + 1]);
    if (!std::strcmp(argv[i], "--board")) arguments.board = std::atoi(argv[i + 1]);
    if (!std::strcmp(argv[i], "--parent")) arguments.parent = std::atoi(argv[i + 1]);
  }
  return run_worker(arguments, [] { return std::make_unique<FaultyRenderer>(); });
}
