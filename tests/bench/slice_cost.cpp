// Beside CI: what it costs a frame that it can be interrupted. The same picture drawn in one go, with nobody to ask, and as work of a session, which asks
// at each block whether it goes on and whose turn it is (base/work.h): in turns, by the processor time of the whole process, so that whatever
// else the machine does meets both alike.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/parallel.h"
#include "base/work.h"
#include "bench/quantile.h"
#include "data/dataset/dataset.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "rendering/picture/renderer.h"

namespace {

using namespace isostrata;

double processor_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

Scene scene_of(const std::string& look) {
  Scene scene;
  scene.array = "distance";
  for (std::uint32_t i = 0; i < (look == "layers" ? 4u : 1u); ++i) {
    SceneInterval layer{i + 1, 0.1 + 0.1 * i, 0.2 + 0.1 * i, {1, 0.5f, 0}, "", look == "surface" ? 1.0 : 0.4, 0, true};
    if (look == "mapped") layer.color_map = "viridis";
    scene.intervals.push_back(layer);
  }
  return scene;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string data = argc > 1 ? argv[1] : "torus:64";
  const int frames = argc > 2 ? std::atoi(argv[2]) : 100;
  const std::shared_ptr<const Dataset> dataset = open_dataset(data, {}, Task{});
  std::printf("%s, %d threads, %d pairs of frames in turns, processor time of a frame\n", data.c_str(), thread_count(), frames);
  for (const char* look : {"surface", "layers", "mapped"})
    for (const int width : {640, 1280}) {
      const int height = width * 9 / 16;
      Scene scene = scene_of(look);
      const auto extracted = extract_scene(dataset, scene, nullptr, Task{});
      const auto renderer = make_renderer({"native", "native"});
      std::vector<double> whole, sliced, ratios;
      for (int i = 0; i < frames; ++i) {
        const double turn = 0.05 * i;
        scene.camera = Camera{{4 * std::cos(turn), 1, 4 * std::sin(turn)}, {0, 0, 0}, {0, 1, 0}, 30};
        const DrawInput input = draw_input(*extracted, scene, width, height);
        const auto draw = [&](bool in_slices) {
          const Task task;
          std::optional<Work> work;
          if (in_slices) work.emplace(1, WorkClass::frame, Work::Options{.task = &task});
          const double before = processor_ms();
          renderer->draw(input);
          (in_slices ? sliced : whole).push_back(processor_ms() - before);
        };
        draw(i % 2 == 0);  // who comes first finds the caches as the last frame left them
        draw(i % 2 != 0);
        ratios.push_back(sliced.back() / whole.back());
      }
      std::printf("%-8s %4dx%-4d in one go %7.2f ms median, %7.2f min; in slices %7.2f, %7.2f; slices / one go %.3f by medians, %.3f by minima, %.3f median of pairs\n", look, width,
                  height, quantile(whole, 0.5), quantile(whole, 0), quantile(sliced, 0.5), quantile(sliced, 0), quantile(sliced, 0.5) / quantile(whole, 0.5),
                  quantile(sliced, 0) / quantile(whole, 0), quantile(ratios, 0.5));
      std::fflush(stdout);
    }
}
