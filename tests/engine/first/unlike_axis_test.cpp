#include "engine/first/unlike_axis.h"

#include <gtest/gtest.h>

#include "base/task.h"

namespace isostrata {
namespace {

/// Of so many degrees of longitude and latitude, and of `height` in a unit of its own.
Dataset map_of(double height, const std::string& unit, const std::string& across = "degrees_") {
  Dataset data = *open_dataset("torus:4", {}, Task{});
  data.bounds = {{0, 0, 0}, {60, 40, height}};
  data.axes = {Axis{"longitude", across + "east"}, Axis{"latitude", across + "north"}, Axis{"height", unit}};
  if (across == "m") data.axes[0].unit = data.axes[1].unit = across;
  return data;
}

TEST(UnlikeAxis, OfDegreesIsAboutATenthOfTheirLength) {
  for (const double height : {1000.0, 1e5, 90.0, 0.5, 1e-3})
    for (const char* unit : {"hPa", "m", ""}) {
      const auto unlike = unlike_axis(map_of(height, unit));
      ASSERT_TRUE(unlike) << height << unit;
      EXPECT_EQ(unlike->axis, 2);
      EXPECT_EQ(unlike->scale.x, 1);
      const double drawn = height * unlike->scale.z;
      EXPECT_LE(drawn, 6.0001) << height;
      EXPECT_GE(drawn, 6 / 2.51) << height;
    }
}

TEST(UnlikeAxis, ThatLooksWellAsItIsStaysSo) {
  EXPECT_FALSE(unlike_axis(map_of(10, "km")));
  EXPECT_FALSE(unlike_axis(map_of(29, "km")));
}

TEST(UnlikeAxis, OfTheSameUnitIsNone) {
  EXPECT_FALSE(unlike_axis(map_of(90, "m", "m")));
  EXPECT_FALSE(unlike_axis(map_of(90, "", "m"))) << "nobody knows";
  EXPECT_TRUE(unlike_axis(map_of(90, "hPa", "m")));
  Dataset degrees = map_of(300, "degrees");
  EXPECT_FALSE(unlike_axis(degrees));
}

}  // namespace
}  // namespace isostrata
