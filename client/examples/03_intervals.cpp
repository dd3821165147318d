// 3. Say which layers to show, and save the lossless picture of them.
#include <cstdio>
#include <fstream>

#include "isostrata/client.h"

using isostrata::client::interval;

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s URL DATASET FILE.png\n", argv[0]), 2;
  try {
    isostrata::client::Client client({.url = argv[1], .width = 640, .height = 480});
    client.open_dataset(argv[2]);
    // Layers by their place in the range of the array that is open.
    const auto& array = client.dataset().arrays(0);
    const auto at = [&](double part) { return array.lower() + part * (array.upper() - array.lower()); };
    client.set_intervals({interval(at(0.05), at(0.2), {.color = "#ff8000", .opacity = 0.9}),
                          interval(at(0.3), at(0.5), {.color_map = "viridis", .opacity = 0.3})});
    client.set_view("+x");

    const auto frame = client.lossless_frame();
    std::ofstream(argv[3], std::ios::binary) << frame.payload();  // the bytes of a PNG file
    std::printf("revision %llu: %lld tetrahedra, drawn in %.1f ms\n", static_cast<unsigned long long>(frame.revision()),
                static_cast<long long>(frame.facts().tetrahedra()), frame.stages().total_ms());
    return 0;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
