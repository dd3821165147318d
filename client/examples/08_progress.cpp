// 8. Work that takes long: its progress, and Ctrl-C that stops the server's work too.
#include <atomic>
#include <csignal>
#include <cstdio>

#include "isostrata/client.h"

namespace {
std::atomic<bool> stop = false;
}

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s URL DATASET\n", argv[0]), 2;
  std::signal(SIGINT, [](int) { stop = true; });
  try {
    isostrata::client::Options options{.url = argv[1], .width = 320, .height = 240, .stop = &stop};
    options.on_progress = [](const isostrata::v1::Progress& progress) {
      std::fprintf(stderr, "\r%s %3.0f %%\x1b[K", progress.stage().c_str(), progress.fraction() * 100);
    };
    isostrata::client::Client client(options);
    client.open_dataset(argv[2]);
    const auto frame = client.lossless_frame();
    std::fprintf(stderr, "\r\x1b[K");
    std::printf("%lld tetrahedra\n", static_cast<long long>(frame.facts().tetrahedra()));
    return 0;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "\n%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
