// 1. Connect to a server by the address that it printed, and see what it offers.
//
//   01_connect 'http://127.0.0.1:8080/?token=...'
#include <cstdio>

#include "isostrata/client.h"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s URL\n", argv[0]), 2;
  try {
    const isostrata::client::Client client({.url = argv[1]});
    std::printf("%s on %s\n", client.welcome().server().c_str(), client.welcome().device().c_str());
    for (const auto& dataset : client.welcome().datasets()) std::printf("  %s\n", dataset.name().c_str());
    return 0;
  } catch (const isostrata::client::ClientError& error) {  // everything that goes wrong is one of these
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
