#include "rendering/segments/color_integrals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace isostrata {
namespace {

double value_of(const float (*coefficient)[ColorIntegrals::kMostPieces], int count, double p, double pieces) {
  const int piece = std::min(static_cast<int>(p), static_cast<int>(pieces) - 1);
  double sum = 0;
  for (int i = count; i-- > 0;) sum = sum * (p - piece) + static_cast<double>(coefficient[i][piece]);
  return sum;
}

TEST(ColorIntegrals, DifferencesAreTheMapsMeanAndMoment) {
  std::vector<std::string> names{"#000000-#ffffff", "#f00-#0f0-#00f-#fff", "#123456-#fedcba-#000-#fff-#f0f-#0f0"};
  for (const auto name : color_map_names()) names.emplace_back(name);
  for (const std::string& name : names) {
    const ColorMap map = color_map(name);
    const auto integrals = make_color_integrals(map);
    ASSERT_TRUE(integrals) << name;
    const double pieces = static_cast<double>(integrals->pieces);
    for (const auto& range : {std::pair{0.0, 1.0}, {0.1, 0.9}, {0.33, 0.4}, {0.7, 0.72}, {0.99, 1.0}})
      for (std::size_t c = 0; c < 3; ++c) {
        const double from = range.first, to = range.second;
        double mean = 0, moment = 0;
        constexpr int kSteps = 4000;
        for (int i = 0; i < kSteps; ++i) {
          const double u = from + (to - from) * (i + 0.5) / kSteps;
          const auto color = static_cast<double>(sample(map, static_cast<float>(u))[c]);
          mean += color / kSteps;
          moment += color * (u - 0.5) / kSteps;
        }
        const auto over = [&](const float(*table)[ColorIntegrals::kMostPieces], int count) {
          return (value_of(table, count, to * pieces, pieces) - value_of(table, count, from * pieces, pieces)) /
                 ((to - from) * pieces);
        };
        EXPECT_NEAR(over(integrals->g0[c], 5), mean, kPieceError) << name << " from " << from << " to " << to;
        EXPECT_NEAR(over(integrals->g1[c], 6) / pieces, moment, kPieceError) << name << " from " << from << " to " << to;
      }
  }
}

TEST(ColorIntegrals, AMapThatJumpsAboutHasNone) {
  std::vector<Rgb> rgb;
  for (int i = 0; i < 256; ++i) rgb.push_back(i % 2 ? Rgb{1, 0, 0} : Rgb{0, 1, 1});
  EXPECT_FALSE(make_color_integrals({"jumps", rgb}));
}

TEST(ColorIntegrals, WhatWasMadeIsRemembered) {
  ColorIntegralMemory memory;
  const ColorMap viridis = color_map("viridis");
  const auto first = memory.of(viridis);
  for (int i = 0; i < 40; ++i) memory.of({"ramp " + std::to_string(i), {{0, 0, 0}, {static_cast<float>(i) / 40, 1, 1}}});
  const auto again = memory.of(viridis);
  EXPECT_NE(first, again);  // it was forgotten, since forty others came
  EXPECT_EQ(again, memory.of(viridis));
}

}  // namespace
}  // namespace isostrata
