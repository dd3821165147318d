// Files with bytes changed at random: whatever the reader makes of them, it is a dataset or one clear error.
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "data/dataset/dataset.h"
#include "support/temporary_folder.h"

namespace isostrata::testing {

/// Flips, cuts, repeats and overwrites, most of the time in the first kilobyte, where headers are.
inline std::string mutated(std::string bytes, std::mt19937& random) {
  const auto pick = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const int changes = 1 + static_cast<int>(pick(4));
  for (int c = 0; c < changes && !bytes.empty(); ++c) {
    const std::size_t at = pick(2) ? pick(std::min<std::size_t>(bytes.size(), 1024)) : pick(bytes.size());
    switch (pick(6)) {
      case 0:
        bytes[at] = static_cast<char>(pick(256));
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << pick(8)));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, 1 + pick(16)));
        break;
      case 4:
        bytes.erase(at, 1 + pick(16));
        break;
      default:
        bytes[at] = "0123456789-9"[pick(12)];
        break;
    }
  }
  return bytes;
}

/// Opens `rounds` changed files, of each of `files` (name and bytes) in turn. $ISOSTRATA_MUTATIONS and $ISOSTRATA_MUTATION_SEED ask for
/// more of them, and for others. Returns at how many the reader crashed, which is an error like others.
inline int expect_datasets_or_errors(const std::vector<std::pair<std::string, std::string>>& files, int rounds) {
  if (const char* wished = std::getenv("ISOSTRATA_MUTATIONS")) rounds = std::atoi(wished);
  const char* wished_seed = std::getenv("ISOSTRATA_MUTATION_SEED");
  const unsigned seed = wished_seed ? static_cast<unsigned>(std::atoi(wished_seed)) : 20040717;
  int opened = 0, refused = 0, crashed = 0;
  for (int round = 0; round < rounds; ++round) {
    std::mt19937 random(seed + static_cast<unsigned>(round));
    const auto& [name, bytes] = files[static_cast<std::size_t>(round) % files.size()];
    const TemporaryFolder folder;
    OpenOptions options;
    options.max_bytes = 256u << 20;
    options.timeout_s = 20;
    try {
      const auto data = open_dataset(folder.write(name, mutated(bytes, random)).string(), options, Task());
      // Everything that other rooms will touch can be touched.
      std::array<std::int64_t, kMaxCellVertices> ids{};
      for (std::int64_t cell = 0; cell < data->grid.cell_count(); ++cell) {
        const int n = data->grid.cell_points(cell, ids);
        for (int v = 0; v < n; ++v) data->grid.point(ids[static_cast<std::size_t>(v)]);
      }
      ++opened;
    } catch (const Error& error) {
      EXPECT_NE(error.code(), ErrorCode::internal) << name << ", seed " << seed << ", round " << round << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find("ended after"), std::string::npos)
          << name << ", seed " << seed << ", round " << round << ": " << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
      ++refused;
      crashed += std::string(error.what()).find("crashed") != std::string::npos;
    }
  }
  std::printf("  %d mutated files: %d opened, %d refused, in %d of these the reader crashed\n", rounds, opened, refused, crashed);
  EXPECT_EQ(opened + refused, rounds);
  return crashed;
}

}  // namespace isostrata::testing
