#include "data/grids/hull_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <random>
#include <string>

#include "support/whole_number_hull.h"

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

/// The volume inside faces that are closed: every edge is in two of them, once each way. -1 if they are not.
double volume_inside(const std::vector<Vec3d>& points) {
  std::vector<std::int64_t> ids(points.size());
  std::iota(ids.begin(), ids.end(), 0);
  PolyhedronFaces faces;
  hull_faces(points, ids, faces);
  std::map<std::pair<std::int64_t, std::int64_t>, int> edges;
  double volume = 0;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto cycle = faces.face(f);
    const auto at = [&](std::size_t i) { return points[static_cast<std::size_t>(cycle[i % cycle.size()])]; };
    for (std::size_t i = 0; i < cycle.size(); ++i) {
      ++edges[{cycle[i], cycle[(i + 1) % cycle.size()]}];
      if (i > 0 && i + 1 < cycle.size()) volume += orient3d(points[0], at(0), at(i), at(i + 1)) / 6;
    }
  }
  for (const auto& [edge, times] : edges)
    if (times != 1 || edges.count({edge.second, edge.first}) != 1) return -1;
  return volume;
}

/// A unit cube turned at random with its corners cut off at `depth` of the edges, in single precision or not, far off or not.
std::vector<Vec3d> truncated_cube(double depth, bool single, const Vec3d& at, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vec3d{normal(random), normal(random), normal(random)}; };
  const Vec3d x = normalized(vector()), y = normalized(cross(x, vector())), z = cross(x, y);
  std::vector<Vec3d> points;
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d p{double(corner & 1), double(corner >> 1 & 1), double(corner >> 2)};
      p[axis] += p[axis] > 0 ? -depth : depth;
      p = at + x * p.x + y * p.y + z * p.z;
      if (single)
        for (int c = 0; c < 3; ++c) p[c] = static_cast<float>(p[c]);
      points.push_back(p);
    }
  std::shuffle(points.begin(), points.end(), random);
  return points;
}

TEST(HullFaces, HoldTheVolumeHoweverSmallAFaceIs) {
  std::mt19937_64 random(42);
  for (const bool single : {false, true})
    for (const double depth : {0.3, 1e-2, 1e-3, 5e-5, 1e-5, 3e-6, 1e-6, 2e-7, 1e-8})
      for (int trial = 0; trial < 20; ++trial) {
        const std::vector<Vec3d> points = truncated_cube(depth, single, {2, -1, 3}, random);
        ASSERT_NEAR(volume_inside(points), 1 - 8 * depth * depth * depth / 6, single || depth < 1e-5 ? 5e-6 : 1e-12)
            << "depth " << depth << (single ? ", single" : "") << ", seed 42, trial " << trial;
        if (depth >= 5e-5) {
          ASSERT_EQ(face_sizes(points), (std::map<std::size_t, int>{{3, 8}, {8, 6}}))
              << "depth " << depth << (single ? ", single" : "") << ", seed 42, trial " << trial;
        }
      }
}

TEST(HullFaces, OfPointsFarFromTheOriginAreWholeInSinglePrecision) {
  std::mt19937_64 random(43);
  for (int trial = 0; trial < 50; ++trial)
    ASSERT_EQ(face_sizes(truncated_cube(0.25, true, {3000, -2000, 900}, random)), (std::map<std::size_t, int>{{3, 8}, {8, 6}}))
        << "seed 43, trial " << trial;
}

TEST(HullFaces, HoldWhatWholeNumbersSayOfRandomPoints) {
  std::mt19937_64 random(46);
  for (int trial = 0; trial < 400; ++trial) {
    const std::int64_t most = std::int64_t{1} << (1 + trial % 5);  // few places: points that coincide, lie in a line, in a plane
    std::vector<test::WholePoint> whole(4 + random() % 20);
    std::vector<Vec3d> points;
    for (test::WholePoint& p : whole) {
      for (std::int64_t& x : p) x = static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(most + 1));
      points.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
    }
    const double six = static_cast<double>(test::six_hull_volumes(whole));
    ASSERT_NEAR(6 * volume_inside(points), six, 1e-12 * six) << "seed 46, trial " << trial;
  }
}

TEST(HullFaces, OfRandomPointsHaveAllPointsOnOneSide) {
  std::mt19937_64 random(44);
  for (int trial = 0; trial < 60; ++trial) {
    const int digits = trial % 3 ? 1 << (trial % 7) : 1 << 20;  // few: points that coincide, lie in a line, in a plane
    std::vector<Vec3d> points;
    for (int i = 0; i < 64; ++i) {
      const auto coordinate = [&] { return double(random() % static_cast<unsigned>(digits + 1)) / digits; };
      points.push_back({coordinate(), coordinate(), coordinate()});
    }
    std::vector<std::int64_t> ids(points.size());
    std::iota(ids.begin(), ids.end(), 0);
    PolyhedronFaces faces;
    hull_faces(points, ids, faces);
    ASSERT_GE(volume_inside(points), 0) << "seed 44, trial " << trial;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      const auto at = [&](std::size_t i) { return points[static_cast<std::size_t>(faces.face(f)[i])]; };
      Vec3d normal;
      for (std::size_t i = 1; i + 1 < faces.face(f).size(); ++i) normal = normal + cross(at(i) - at(0), at(i + 1) - at(0));
      for (const Vec3d& p : points) ASSERT_LE(dot(p - at(0), normalized(normal)), 1e-5) << "seed 44, trial " << trial;
    }
  }
}

TEST(ExactOrientation, KnowsWhatRoundingHides) {
  // Points of a plane through the origin with coordinates that doubles hold, moved by one last place.
  std::mt19937_64 random(45);
  for (int trial = 0; trial < 200; ++trial) {
    const auto number = [&] { return static_cast<double>(static_cast<std::int64_t>(random() % 2000001) - 1000000); };
    const Vec3d u{number(), number(), number()}, v{number(), number(), number()};
    const double i = number(), j = number();
    const Vec3d a = u * 3.0, b = v * 7.0, c = u * -5.0 + v, d = u * i + v * j;
    EXPECT_EQ(exact_orientation(a, b, c, d), 0) << "seed 45, trial " << trial;
    const Vec3d normal = cross(b - a, c - a);
    if (normal.x == 0) continue;
    const Vec3d off{std::nextafter(d.x, 1e300), d.y, d.z};
    EXPECT_EQ(exact_orientation(a, b, c, off), normal.x > 0 ? 1 : -1) << "seed 45, trial " << trial;
    EXPECT_EQ(exact_orientation(b, a, c, off), normal.x > 0 ? -1 : 1);
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
