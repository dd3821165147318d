#include "rendering/picture/clip_tetrahedron.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace isostrata {
namespace {

struct Moments {
  double volume = 0, scalar = 0;  // the integral of 1 and of the scalar
  Vec3d center;                   // the integral of the position
};

Moments moments(const std::vector<ClipTetrahedron>& pieces) {
  Moments sum;
  for (const ClipTetrahedron& t : pieces) {
    const double volume = std::abs(orient3d(t[0].position, t[1].position, t[2].position, t[3].position)) / 6;
    sum.volume += volume;
    sum.scalar += volume * (t[0].scalar + t[1].scalar + t[2].scalar + t[3].scalar) / 4;
    sum.center = sum.center + (t[0].position + t[1].position + t[2].position + t[3].position) * (volume / 4);
  }
  return sum;
}

TEST(ClipTetrahedron, TheTwoSidesOfAPlaneMakeTheWhole) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 300; ++trial) {
    ClipTetrahedron whole;
    for (ClipVertex& v : whole) v = {{number(random), number(random), number(random)}, number(random)};
    const Vec3d normal{number(random), number(random), number(random)};
    const double offset = 0.3 * number(random);
    std::vector<ClipTetrahedron> above{whole}, below{whole};
    clip_tetrahedra(above, normal, offset);
    clip_tetrahedra(below, normal * -1.0, -offset);
    for (const ClipTetrahedron& piece : above)
      for (const ClipVertex& v : piece) ASSERT_GE(dot(normal, v.position), offset - 1e-12) << "trial " << trial << ", seed 31";
    const Moments a = moments(above), b = moments(below), all = moments({whole});
    ASSERT_NEAR(a.volume + b.volume, all.volume, 1e-13) << "trial " << trial << ", seed 31";
    ASSERT_NEAR(a.scalar + b.scalar, all.scalar, 1e-13) << "trial " << trial << ", seed 31";
    ASSERT_LT(length(a.center + b.center - all.center), 1e-13) << "trial " << trial << ", seed 31";
  }
}

}  // namespace
}  // namespace isostrata
