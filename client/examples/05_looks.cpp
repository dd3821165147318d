// 5. How it looks: boundary surfaces, cuts, axes and legend, a transfer function, the modes; and stills of any size.
#include <cstdio>
#include <fstream>
#include <string>

#include "isostrata/client.h"

namespace ic = isostrata::client;
namespace v1 = isostrata::v1;

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s URL DATASET FOLDER\n", argv[0]), 2;
  const std::string folder = argv[3];
  try {
    ic::Client client({.url = argv[1], .width = 0});
    client.open_dataset(argv[2]);
    const auto& array = client.dataset().arrays(0);
    const auto at = [&](double part) { return array.lower() + part * (array.upper() - array.lower()); };
    const auto save = [&](const std::string& name, const std::string& format) {
      std::ofstream(folder + "/" + name, std::ios::binary) << client.still(480, 360, format);
    };
    client.set_background(ic::rgb("#ffffff"));
    client.set_annotations(true, true, true);  // axes, box, legend

    // A layer behind its own half transparent skin, cut open through the middle of the box.
    client.set_intervals({ic::interval(
        at(0.05), at(0.3),
        {.color = "#3060ff", .opacity = 0.4, .name = "core", .surface = ic::SurfaceLook{.opacity = 0.5, .silhouette = 0.8}})});
    const auto& box = client.dataset();
    client.set_clip_planes({ic::clip_plane({-1, 0, 0}, -(box.lower().x() + box.upper().x()) / 2)});
    save("surfaces.png", "png");

    client.set_clip_planes({});
    client.set_transfer_function({ic::transfer_point(at(0), "#2000a0", 0.0), ic::transfer_point(at(0.2), "#ff8000", 0.6),
                                  ic::transfer_point(at(0.5), "#ffffff", 0.0)});
    save("transfer.jpg", "jpeg");

    client.set_intervals({ic::interval(at(0.1), at(0.2), {.color = "#ff3020", .priority = 2}),
                          ic::interval(at(0.3), at(0.6), {.color = "#20c040", .priority = 1})});
    client.set_mode(v1::RENDER_MODE_PRIORITIZED);
    save("priorities.png", "png");

    v1::SetCycle cycle;  // one interval at a time; playing cycles are moved on by the server
    cycle.set_phase(1);
    client.set_cycle(cycle);
    client.set_mode(v1::RENDER_MODE_CYCLED);
    save("cycled.png", "png");
    return 0;
  } catch (const ic::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
