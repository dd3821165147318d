// 2. Open a dataset, look at its arrays, and count how the values of one are spread.
#include <algorithm>
#include <cstdio>
#include <string>

#include "isostrata/client.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: %s URL DATASET\n", argv[0]), 2;
  try {
    isostrata::client::Client client({.url = argv[1], .width = 0});  // width 0: no pictures are wanted
    client.open_dataset(argv[2]);
    const auto& dataset = client.dataset();
    std::printf("%s: %s grid of %lld cells\n", dataset.name().c_str(), dataset.grid().c_str(),
                static_cast<long long>(dataset.cells()));
    for (const auto& array : dataset.arrays())
      std::printf("  %-12s %s in [%g, %g]\n", array.name().c_str(), array.type().c_str(), array.lower(), array.upper());

    const auto histogram = client.histogram(dataset.arrays(0).name(), 12);
    const auto most = std::max<std::uint64_t>(1, *std::max_element(histogram.counts().begin(), histogram.counts().end()));
    const double width = (histogram.upper() - histogram.lower()) / histogram.counts_size();
    for (int i = 0; i < histogram.counts_size(); ++i)
      std::printf("%10.4g  %s\n", histogram.lower() + i * width, std::string(histogram.counts(i) * 50 / most, '#').c_str());
    return 0;
  } catch (const isostrata::client::ClientError& error) {
    std::fprintf(stderr, "%s: %s\n", error.code().c_str(), error.what());
    return 1;
  }
}
