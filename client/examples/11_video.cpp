// 11. The same frames as video: a third of the bytes while something moves, and still the exact picture at rest. Needs libvpx.
#include <chrono>
#include <cstdio>

#include "isostrata/client.h"
#include "isostrata/video.h"

using namespace std::chrono_literals;
using namespace isostrata::client;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s URL DATASET\n", argv[0]), 2;
  try {
    // Without moving_format the server chooses between JPEG and VP9 by measured times: near by, JPEG is there sooner.
    Client client({.url = argv[1], .width = 320, .height = 240, .moving_formats = video_formats(), .moving_format = "vp9-444"});
    FrameDecoder decoder(video_decoder);
    client.open_dataset(argv[2]);
    const auto start = client.state().camera();

    client.set_interaction(true);
    int shown = 0;
    std::string format;
    for (int step = 1; step <= 20 || (format != "vp9-444" && step <= 400); ++step) {  // the first ones are JPEG, until the encoder is open
      client.set_camera(turned(start, 3 * step, 0));
      if (const auto next = client.next_picture(decoder, 1s)) {
        ++shown;
        format = next->frame.format();
      }
    }
    client.set_interaction(false);
    std::printf("%d pictures, the last as %s\n", shown, format.c_str());

    for (;;) {
      const auto next = client.next_picture(decoder, 10s);
      if (!next) return 1;
      if (next->frame.phase() != isostrata::v1::FRAME_PHASE_LOSSLESS) continue;
      std::printf("at rest: %d x %d pixels\n", next->picture.width, next->picture.height);
      return 0;
    }
  } catch (const ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
