#include "base/vec.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace isostrata {
namespace {

// Calls law(next) for twenty seeds; next() makes a random vector of whole numbers, small enough that every product below is exact
// in double, so laws hold to the last bit.
template <class Law>
void for_random_vectors(Law law) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> whole(-1000, 1000);
    const auto number = [&] { return static_cast<double>(whole(random)); };
    law([&] { return Vec3d{number(), number(), number()}; });
  }
}

TEST(VecLaws, TheCrossProductIsPerpendicularAndTurnsWithTheOrder) {
  for_random_vectors([](auto next) {
    const Vec3d a = next(), b = next();
    EXPECT_EQ(dot(cross(a, b), a), 0);
    EXPECT_EQ(dot(cross(a, b), b), 0);
    EXPECT_EQ(cross(a, b), cross(b, a) * -1.0);
  });
}

TEST(VecLaws, LagrangesIdentityHolds) {
  for_random_vectors([](auto next) {
    const Vec3d a = next(), b = next();
    EXPECT_EQ(dot(cross(a, b), cross(a, b)), dot(a, a) * dot(b, b) - dot(a, b) * dot(a, b));
  });
}

TEST(VecLaws, Orient3dChangesSignWithEverySwapAndNotWithATurnOfThree) {
  for_random_vectors([](auto next) {
    const Vec3d a = next(), b = next(), c = next(), d = next();
    const double volume = orient3d(a, b, c, d);
    EXPECT_EQ(orient3d(b, a, c, d), -volume);
    EXPECT_EQ(orient3d(a, c, b, d), -volume);
    EXPECT_EQ(orient3d(a, b, d, c), -volume);
    EXPECT_EQ(orient3d(b, c, a, d), volume);
  });
}

TEST(VecLaws, Orient3dDoesNotSeeTranslation) {
  for_random_vectors([](auto next) {
    const Vec3d a = next(), b = next(), c = next(), d = next(), t = next();
    EXPECT_EQ(orient3d(a + t, b + t, c + t, d + t), orient3d(a, b, c, d));
  });
}

TEST(VecLaws, APointInsideSplitsTheVolumeWithoutRemainder) {
  for_random_vectors([](auto next) {
    const Vec3d a = next(), b = next(), c = next(), d = next(), p = next();
    EXPECT_EQ(orient3d(p, b, c, d) + orient3d(a, p, c, d) + orient3d(a, b, p, d) + orient3d(a, b, c, p), orient3d(a, b, c, d));
  });
}

TEST(VecLaws, ABoxHoldsThePointsItIncludesAndNoMore) {
  for_random_vectors([](auto next) {
    Box3d box;
    EXPECT_TRUE(box.empty());
    EXPECT_EQ(box.diagonal(), 0);
    const Vec3d a = next(), b = next();
    box.include(a);
    EXPECT_FALSE(box.empty());
    EXPECT_EQ(box.lower, a);
    EXPECT_EQ(box.upper, a);
    box.include(b);
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_EQ(box.lower[axis], std::min(a[axis], b[axis]));
      EXPECT_EQ(box.upper[axis], std::max(a[axis], b[axis]));
    }
    EXPECT_EQ(box.center(), (a + b) / 2.0);
    EXPECT_DOUBLE_EQ(box.diagonal(), length(a - b));
  });
}

TEST(VecLaws, AMatrixProductActsRightToLeft) {
  for_random_vectors([](auto next) {
    Mat4d a, b;
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row) {
        a.m[column][row] = next().x;
        b.m[column][row] = next().x;
      }
    const Vec3d p = next();
    const std::array<double, 4> v{p.x, p.y, p.z, 1};
    EXPECT_EQ((a * b) * v, a * (b * v));
    EXPECT_EQ((Mat4d::identity() * a).m, a.m);
    EXPECT_EQ((a * Mat4d::identity()).m, a.m);
  });
}

TEST(Orient3d, IsPositiveForTheRightHandedUnitTetrahedron) {
  EXPECT_EQ(orient3d(Vec3d{0, 0, 0}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}), 1);
}

TEST(Mat4d, IsColumnMajor) {
  Mat4d translate = Mat4d::identity();
  translate.m[3] = {10, 20, 30, 1};
  EXPECT_EQ(translate * (std::array<double, 4>{1, 2, 3, 1}), (std::array<double, 4>{11, 22, 33, 1}));
}

TEST(Lerp, StartsAtOneEndAndStopsAtTheOther) {
  const Vec3d a{1, 2, 3}, b{5, -6, 7};
  EXPECT_EQ(lerp(a, b, 0.0), a);
  EXPECT_EQ(lerp(a, b, 1.0), b);
  EXPECT_EQ(lerp(a, b, 0.5), (a + b) / 2.0);
}

}  // namespace
}  // namespace isostrata
