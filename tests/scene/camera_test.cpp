#include "scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.h"
#include "support/project_point.h"

namespace isostrata {
namespace {

const Box3d kBox{{-1, -2, -3}, {1, 2, 3}};

std::array<double, 4> apply(const Mat4d& m, Vec3d p) { return m * std::array<double, 4>{p.x, p.y, p.z, 1}; }

TEST(Camera, ViewIsARigidMotionThatPutsTheEyeAtTheOriginAndLooksDownMinusZ) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-5, 5);
  for (int trial = 0; trial < 50; ++trial) {
    const Camera camera{
        {number(random), number(random), number(random)}, {number(random), number(random), number(random)}, {0.1, 1, 0.2}, 40};
    const Mat4d view = view_from_world(camera);
    const auto eye = apply(view, camera.eye), at = apply(view, camera.at), above = apply(view, camera.eye + camera.up);
    EXPECT_NEAR(eye[0], 0, 1e-12);
    EXPECT_NEAR(eye[1], 0, 1e-12);
    EXPECT_NEAR(eye[2], 0, 1e-12);
    EXPECT_NEAR(at[0], 0, 1e-12);
    EXPECT_NEAR(at[1], 0, 1e-12);
    EXPECT_NEAR(at[2], -length(camera.at - camera.eye), 1e-12);
    EXPECT_NEAR(above[0], 0, 1e-12);
    EXPECT_GT(above[1], 0);
    const Vec3d p{number(random), number(random), number(random)};
    const auto q = apply(view, p);
    EXPECT_NEAR(std::hypot(q[0], q[1], q[2]), length(p - camera.eye), 1e-12) << "trial " << trial << ", seed 7";
  }
}

TEST(Camera, EveryNamedViewShowsTheWholeBoxWhateverThePicturesShape) {
  for (const char* side : {"reset", "+x", "-x", "+y", "-y", "+z", "-z"})
    for (const double aspect : {1.0, 0.25, 0.02, 4.0})
      for (const bool orthographic : {false, true}) {
        Camera camera = view_of(kBox, side, aspect);
        camera.orthographic = orthographic;
        check(camera);
        double widest = 0;
        for (int corner = 0; corner < 8; ++corner) {
          const Vec3d p{corner & 1 ? 1.0 : -1.0, corner & 2 ? 2.0 : -2.0, corner & 4 ? 3.0 : -3.0};
          for (const double along : project_point(camera, aspect, p)) {
            EXPECT_LE(std::abs(along), 1) << side << ", aspect " << aspect << ", corner " << corner;
            widest = std::max(widest, std::abs(along));
          }
        }
        EXPECT_GT(widest, 0.25) << side << ", aspect " << aspect;  // and not from too far away
      }
}

TEST(Camera, FromAnEndOfALongBoxItsEndFillsThePicture) {
  const Box3d ocean{{0, -90, -5000}, {360, 90, 0}};
  for (const bool orthographic : {false, true}) {
    const Camera camera = view_of(ocean, "+z", 2, orthographic);
    const auto corner = project_point(camera, 2, {360, 90, 0});
    EXPECT_GT(corner[0], 0.9);
    EXPECT_LE(corner[0], 1);
    EXPECT_GT(camera.eye.z, 0);
    EXPECT_EQ(parse_camera(orthographic ? "+z;projection=orthographic" : "+z", {}, ocean, 2), camera);
  }
}

TEST(Camera, NamedViewsStandOnTheirSide) {
  EXPECT_GT(view_of(kBox, "+x").eye.x, 1);
  EXPECT_LT(view_of(kBox, "-y").eye.y, -2);
  EXPECT_GT(view_of(kBox, "+z").eye.z, 3);
  for (const char* side : {"+x", "-x", "+y", "-y"}) EXPECT_EQ(view_of(kBox, side).up, (Vec3d{0, 0, 1})) << side;
}

TEST(Camera, ABoxWithoutExtentStillHasAView) {
  check(view_of(Box3d{{1, 1, 1}, {1, 1, 1}}, "reset"));
  check(view_of(Box3d{}, "+y"));
}

TEST(Camera, ParsesEveryPartOverTheBase) {
  const Camera base = view_of(kBox, "+x");
  const Camera camera = parse_camera("eye=1,2.5,-3e1;fov=45", base, kBox);
  EXPECT_EQ(camera.eye, (Vec3d{1, 2.5, -30}));
  EXPECT_EQ(camera.at, base.at);
  EXPECT_EQ(camera.fov_deg, 45);
  EXPECT_EQ(parse_camera("at=0,0,1;up=0,0,1;", base, kBox).up, (Vec3d{0, 0, 1}));
  EXPECT_EQ(parse_camera("-z", base, kBox), view_of(kBox, "-z"));
  EXPECT_EQ(parse_camera("-z", base, kBox, 0.5), view_of(kBox, "-z", 0.5));
  Camera parallel = view_of(kBox, "+y", 1, true);
  parallel.orthographic = true;
  EXPECT_EQ(parse_camera("+y;projection=orthographic", base, kBox), parallel);
}

TEST(Camera, RefusesWhatMakesNoView) {
  const Camera base = view_of(kBox, "+x");
  for (const char* text :
       {"", "eye", "eye=1,2", "eye=1,2,3,4", "eye=1,2,x", "eye=1,2,nan", "eye=1,2,inf", "fov=0", "fov=180", "fov=-1", "zoom=2",
        "eye=1,1,1;at=1,1,1", "up=0,0,0", "up=-1,0,0", "eye=1e300,0,0;at=-1e300,0,0", "eye=1,2,3;;"})
    EXPECT_THROW(parse_camera(text, base, kBox), Error) << text;
}

}  // namespace
}  // namespace isostrata
