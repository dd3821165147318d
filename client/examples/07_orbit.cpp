// 7. Move the camera and save a picture of each place. `isostrata-client record` does this along any path, and makes films.
#include <cstdio>
#include <fstream>
#include <string>

#include "isostrata/client.h"

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s URL DATASET FOLDER\n", argv[0]), 2;
  try {
    isostrata::client::Client client({.url = argv[1], .width = 320, .height = 240});
    client.open_dataset(argv[2]);
    client.set_view("reset");
    const auto start = client.state().camera();
    constexpr int kFrames = 8;
    for (int i = 0; i < kFrames; ++i) {
      client.set_camera(isostrata::client::turned(start, 360.0 * i / kFrames, 15));
      const auto frame = client.lossless_frame();
      std::ofstream(argv[3] + ("/" + std::to_string(i)) + ".png", std::ios::binary) << frame.payload();
    }
    return 0;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
