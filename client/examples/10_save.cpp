// 10. The whole state as one JSON document: saved, changed, brought back; and errors that say which field is wrong.
#include <cstdio>
#include <fstream>

#include "isostrata/client.h"

namespace ic = isostrata::client;

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "usage: %s URL DATASET FILE.json\n", argv[0]), 2;
  try {
    ic::Client client({.url = argv[1], .width = 320, .height = 240});
    client.open_dataset(argv[2]);
    const auto before = ic::decode(client.lossless_frame().payload());
    const std::string saved = client.save_state();
    std::ofstream(argv[3]) << saved;

    client.set_intervals({});
    client.set_view("+z");
    try {
      client.set_intervals({ic::interval(2, 1)});
    } catch (const ic::ClientError& error) {
      std::printf("refused, as it should be: %s is wrong: %s\n", error.field().c_str(), error.what());
    }

    client.restore_state(saved);
    const auto after = ic::decode(client.lossless_frame().payload());
    std::printf("%d intervals are back, and the picture is %s\n", client.state().intervals_size(),
                before.rgb == after.rgb ? "the same" : "another");
    return before.rgb == after.rgb ? 0 : 1;
  } catch (const ic::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
