#include "data/hull_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

namespace isostrata {
namespace {

/// How many faces of each size.
std::map<std::size_t, int> face_sizes(const std::vector<Vec3d>& points) {
  std::vector<std::int64_t> ids(points.size());
  std::iota(ids.begin(), ids.end(), 100);
  PolyhedronFaces faces;
  hull_faces(points, ids, faces);
  std::map<std::size_t, int> sizes;
  for (std::size_t f = 0; f < faces.size(); ++f) ++sizes[faces.face(f).size()];
  return sizes;
}

TEST(HullFaces, AreWholePolygonsOfTurnedSolids) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 30; ++trial) {
    SCOPED_TRACE("seed 41, trial " + std::to_string(trial));
    const auto vector = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
    const Vec3d x = vector(), y = vector(), z = vector();
    if (std::abs(dot(cross(x, y), z)) < 0.1) continue;
    const auto turned = [&](std::vector<Vec3d> points) {
      for (Vec3d& p : points) p = x * p.x + y * p.y + z * p.z;
      std::shuffle(points.begin(), points.end(), random);
      return points;
    };
    std::vector<Vec3d> cube;
    for (int p = 0; p < 8; ++p) cube.push_back({double(p & 1), double(p >> 1 & 1), double(p >> 2)});
    EXPECT_EQ(face_sizes(turned(cube)), (std::map<std::size_t, int>{{4, 6}}));
    std::vector<Vec3d> dotted = cube;
    dotted.push_back({0.5, 0.5, 0.5});  // inside
    dotted.push_back({0.3, 0.4, 0});    // in a face
    dotted.push_back({0.5, 0, 0});      // on an edge: a corner of two faces
    EXPECT_EQ(face_sizes(turned(dotted)), (std::map<std::size_t, int>{{4, 4}, {5, 2}}));
    EXPECT_EQ(face_sizes(turned({{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}})),
              (std::map<std::size_t, int>{{3, 8}}));
  }
}

TEST(HullFaces, OfWhatHasNoVolumeThereAreNone) {
  EXPECT_TRUE(face_sizes({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}).empty());
  EXPECT_TRUE(face_sizes({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}).empty());
  EXPECT_TRUE(face_sizes({{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}).empty());
  EXPECT_TRUE(face_sizes({}).empty());
}

}  // namespace
}  // namespace isostrata
