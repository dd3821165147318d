// 6. Several arrays at once: ranges combined, colour by another array, and times between two steps.
#include <cstdio>

#include "isostrata/client.h"

namespace ic = isostrata::client;
namespace v1 = isostrata::v1;

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s URL DATASET\n", argv[0]), 2;
  try {
    ic::Client client({.url = argv[1], .width = 320, .height = 240});
    client.open_dataset(argv[2]);
    const auto& a = client.dataset().arrays(0);
    const auto& b = client.dataset().arrays(client.dataset().arrays_size() > 1 ? 1 : 0);
    const auto part = [](const v1::ArrayInfo& array, double x) { return array.lower() + x * (array.upper() - array.lower()); };
    const auto tell = [&](const char* what) {
      const auto frame = client.lossless_frame();
      std::printf("%-28s %lld tetrahedra\n", what, static_cast<long long>(frame.facts().tetrahedra()));
    };

    client.select_array(a.name());
    client.set_intervals({ic::interval(part(a, 0.2), part(a, 0.7), {.color_map = "viridis"})});
    client.color_by(b.name());
    tell("a layer");
    client.set_combination({ic::range_term(v1::RANGE_OPERATOR_INTERSECT, b.name(), part(b, 0.5), part(b, 0.7))});
    tell("and a range of another");
    client.set_combination({ic::range_term(v1::RANGE_OPERATOR_SUBTRACT, b.name(), part(b, 0.5), part(b, 0.7))});
    tell("without that range");
    client.set_combination({});

    const auto& times = client.dataset().times();
    if (times.size() > 1) {
      client.set_time((times[0] + times[1]) / 2, v1::TIME_MODE_INTERPOLATE);
      tell("between the first two steps");
    }
    return 0;
  } catch (const ic::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
