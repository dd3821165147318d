#include "rendering/raster/projected_tetrahedra.h"

#include <gtest/gtest.h>

#include "support/box_mesh.h"

namespace isostrata {
namespace {

using namespace testing;

std::vector<ConstantVertex> emit(const std::array<Vec3d, 4>& points, const Camera& camera) {
  IntervalMesh mesh;
  for (const Vec3d& p : points) add_point(mesh, p);
  add_tetrahedron(mesh, {0, 1, 2, 3}, 0);
  const Projection projection = make_projection(camera, Box3d{{-2, -2, -2}, {2, 2, 2}}, 200, 200);
  const auto screen = project_points(mesh, projection);
  const std::vector<std::uint32_t> ids{0};
  std::vector<ConstantVertex> out;
  emit_tetrahedra({&mesh, nullptr, screen, &projection}, ids, out);
  return out;
}

const Camera kFront{{0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 60};

TEST(ProjectedTetrahedraClasses, OneVertexInsideTheOthersIsOneTriangle) {
  // Class 1: towards the eye and away from it. The drawn face is the same, at the back and at the front.
  const auto towards = emit({{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {0, 0, 1}}}, kFront);
  const auto away = emit({{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {0, 0, -1}}}, kFront);
  ASSERT_EQ(towards.size(), 3u);
  ASSERT_EQ(away.size(), 3u);
  for (std::size_t v = 0; v < 3; ++v) {
    EXPECT_EQ(towards[v].style_kind & 1u, 1u);
    EXPECT_EQ(away[v].style_kind & 1u, 0u);
    EXPECT_FLOAT_EQ(towards[v].q, away[v].q);
  }
}

TEST(ProjectedTetrahedraClasses, AQuadrilateralIsTheTwoFacesAtTheNearerDiagonal) {
  const auto vertices = emit({{{-1, 0, 1}, {1, 0, 1}, {0, -1, -1}, {0, 1, -1}}}, kFront);  // class 2
  ASSERT_EQ(vertices.size(), 6u);
  for (const std::size_t v : {0, 2, 3, 5}) EXPECT_NEAR(vertices[v].y, 0, 1e-5);  // the diagonal at z = 1
  // On the diagonal, in the middle, both functions reach the full difference of inverse depths.
  const double thick = vertices[0].tent[2];
  EXPECT_NEAR(0.5 * (vertices[0].tent[0] + vertices[2].tent[0]), thick, 1e-6);
  EXPECT_NEAR(0.5 * (vertices[0].tent[1] + vertices[2].tent[1]), thick, 1e-6);
}

TEST(ProjectedTetrahedraClasses, DegenerateSilhouettesAreStillTriangles) {
  // Class 3: a vertex on a side of the others' silhouette. Class 4: two vertices on one ray. Rounding makes them class 1 or 2.
  for (const Vec3d apex : {Vec3d{0, -0.8, 1}, Vec3d{0, 0.8, 1}}) {
    const auto vertices = emit({{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, apex}}, kFront);
    EXPECT_TRUE(vertices.size() == 3 || vertices.size() == 6) << vertices.size();
    for (const ConstantVertex& v : vertices)
      for (const float t : v.tent) EXPECT_TRUE(t >= 0 && t <= 1e7f) << t;
  }
}

TEST(ProjectedTetrahedraClasses, WhatCannotBeSeenIsLeftOut) {
  const std::array<Vec3d, 4> tetrahedron{{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {0, 0, 1}}};
  EXPECT_TRUE(emit(tetrahedron, {{0, 0, 5}, {0, 0, 9}, {0, 1, 0}, 60}).empty());      // behind the eye
  EXPECT_TRUE(emit(tetrahedron, {{0, 0, 5}, {20, 0, 0}, {0, 1, 0}, 60}).empty());     // beside the picture
  EXPECT_TRUE(emit({{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}}, kFront).empty());  // flat, seen from the front: no thickness
  EXPECT_TRUE(emit({{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}}}, kFront).empty());
}

TEST(ProjectedTetrahedraClasses, ATetrahedronBetweenPixelCentresCostsNothing) {
  const double pixel = 2 * 5 * 0.57735 / 200;       // at the distance of the middle
  const Vec3d corner{0.9 * pixel, 0.9 * pixel, 0};  // pixel centres of an even size lie at half pixels
  EXPECT_TRUE(
      emit({{corner, corner + Vec3d{0.2 * pixel, 0, 0}, corner + Vec3d{0, 0.2 * pixel, 0}, corner + Vec3d{0, 0, 0.01}}}, kFront)
          .empty());
}

}  // namespace
}  // namespace isostrata
