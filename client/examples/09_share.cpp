// 9. Join a session that somebody looks at in a browser, and move one of the layers before their eyes.
//
//   09_share URL            lists the sessions
//   09_share URL SESSION    widens the session's first layer to the middle of its range
#include <algorithm>
#include <cstdio>

#include "isostrata/client.h"

namespace ic = isostrata::client;

int main(int argc, char** argv) {
  if (argc != 2 && argc != 3) return std::fprintf(stderr, "usage: %s URL [SESSION]\n", argv[0]), 2;
  try {
    ic::Options options{.url = argv[1], .width = 0};
    if (argc == 2) return std::printf("%s\n", ic::http_get(options, "api/v1/sessions").c_str()), 0;

    options.session = argv[2];
    ic::Client client(options);
    if (client.state().intervals().empty()) return std::fprintf(stderr, "the session shows no layer\n"), 1;
    const auto layer = client.state().intervals(0);
    const std::string array = client.state().array();
    for (const auto& info : client.dataset().arrays()) {
      if (info.name() != array) continue;
      client.move_interval(layer.id(), layer.lower(), std::max((info.lower() + info.upper()) / 2, layer.upper()));
    }
    const auto& moved = client.interval_of(layer.id());
    std::printf("interval %u is now %g:%g, at revision %llu\n", moved.id(), moved.lower(), moved.upper(),
                static_cast<unsigned long long>(client.state().revision()));
    return 0;
  } catch (const ic::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
