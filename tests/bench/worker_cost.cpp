// Beside CI: what a process of its own costs a frame. The same scene by an engine in this process and by one in a worker, in
// turns, so that whatever else the machine does meets both alike.
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "bench/quantile.h"
#include "engine/engine/engine.h"
#include "worker/worker_engine.h"

namespace {

using namespace isostrata;

class Way {
 public:
  void take(const EngineEvent& event) {
    std::lock_guard lock(mutex_);
    if (const auto* ready = std::get_if<FrameReady>(&event)) last_ = *ready;
    if (const auto* failed = std::get_if<RequestFailed>(&event))
      std::fprintf(stderr, "%s\n", failed->message.c_str()), std::exit(1);
    changed_.notify_all();
  }
  /// From a changed camera to the frame's bytes.
  double frame(FrameEngine& engine, Scene scene, FrameRequest request) {
    request.request = ++number_;
    scene.revision = number_;
    const Stopwatch watch;
    engine.post(SceneUpdate{1, scene});
    engine.post(request);
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return last_ && last_->request == number_; });
    bytes = last_->bytes->size();
    inside_ms = last_->stages.total_ms;
    return watch.elapsed_ms();
  }
  std::vector<double> all_ms, around_ms;  // around: what is not in the frame's own times
  std::size_t bytes = 0;
  double inside_ms = 0;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<FrameReady> last_;
  RequestId number_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const std::string data = argc > 1 ? argv[1] : "torus:32";
  const int frames = argc > 2 ? std::atoi(argv[2]) : 200;
  EngineOptions options;
  options.catalogue = Catalogue::from_sources({data});
  options.renderer_choice = {"native", "native"};
  WorkerOptions worker;
  worker.plan.program = ISOSTRATA_BIN_DIR "/isostrata";
  for (const bool lossless : {false, true})
    for (const int width : {320, 1280}) {
      Way here, there;
      Engine engine(options, [&](EngineEvent event) { here.take(event); });
      WorkerEngine process(options, worker, [&](EngineEvent event) { there.take(event); });
      Scene scene;
      scene.dataset = options.catalogue.entries()[0].id;
      scene.intervals = {SceneInterval{1, 0.2, 0.5, {1, 0, 0}}};
      FrameRequest request;
      request.session = 1;
      request.width = width;
      request.height = width * 9 / 16;
      request.lossless = lossless;
      request.jpeg = !lossless;
      for (int i = 0; i < frames; ++i) {
        const double turn = 0.05 * i;
        scene.camera = Camera{{4 * std::cos(turn), 1, 4 * std::sin(turn)}, {0, 0, 0}, {0, 1, 0}, 30};
        for (auto& [way, by] : {std::pair<Way*, FrameEngine*>{&here, &engine}, {&there, &process}}) {
          way->all_ms.push_back(way->frame(*by, scene, request));
          way->around_ms.push_back(way->all_ms.back() - way->inside_ms);
        }
      }
      const auto print = [](const char* name, const Way& way) {
        std::printf("  %-8s frame %7.2f ms median, %7.2f min; around it %6.3f ms median, %6.3f min\n", name,
                    quantile(way.all_ms, 0.5), quantile(way.all_ms, 0), quantile(way.around_ms, 0.5), quantile(way.around_ms, 0));
      };
      std::printf("%s %dx%d %s, %zu bytes a frame, %d frames each, in turns\n", data.c_str(), width, request.height,
                  lossless ? "png" : "jpeg", here.bytes, frames);
      print("thread", here);
      print("process", there);
      std::printf("  process / thread: %.3f by medians, %.3f by minima\n",
                  quantile(there.all_ms, 0.5) / quantile(here.all_ms, 0.5), quantile(there.all_ms, 0) / quantile(here.all_ms, 0));
    }
}
