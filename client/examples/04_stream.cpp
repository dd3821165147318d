// 4. Move a layer as a hand would, and look at the frames that come meanwhile: quick ones while it moves, an exact one at rest.
#include <chrono>
#include <cstdio>

#include "isostrata/client.h"

using namespace std::chrono_literals;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s URL DATASET\n", argv[0]), 2;
  try {
    isostrata::client::Client client({.url = argv[1], .width = 320, .height = 240});
    client.open_dataset(argv[2]);
    const auto layer = client.state().intervals(0);  // a dataset opens with some
    client.lossless_frame();

    client.set_interaction(true);  // quick frames are wanted now
    for (int step = 1; step <= 20; ++step) {
      const double width = (layer.upper() - layer.lower()) * (1 - 0.02 * step);
      client.move_interval(layer.id(), layer.lower(), layer.lower() + width);
      if (const auto frame = client.next_frame(20ms))
        std::printf("revision %llu as %s, %zu bytes\n", static_cast<unsigned long long>(frame->revision()),
                    frame->format().c_str(), frame->payload().size());
    }
    client.set_interaction(false);

    const auto frame = client.lossless_frame();
    const auto picture = isostrata::client::decode(frame.payload());  // rgb bytes, row by row
    std::printf("at rest: revision %llu, %d x %d pixels, the first is %d %d %d\n",
                static_cast<unsigned long long>(frame.revision()), picture.width, picture.height, picture.rgb[0], picture.rgb[1],
                picture.rgb[2]);
    return 0;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
