// A picture that is drawn slice by slice is the picture, and what is between the slices may end it.
#include "engine/engine/sliced_renderer.h"

#include <gtest/gtest.h>

#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "support/test_device.h"

namespace isostrata {
namespace {

class Slices : public ::testing::TestWithParam<const char*> {
 protected:
  Slices() : renderer_(make_renderer({GetParam(), GetParam() == std::string("native") ? "native" : testing::test_device()})) {
    const auto dataset = make_analytic("torus:20", {}, Task{});
    scene_.array = dataset->arrays[0].name;
    scene_.intervals.resize(1);
    scene_.intervals[0].lower = -0.1;
    scene_.intervals[0].upper = 0.2;
    extracted_ = extract_scene(dataset, scene_, nullptr, Task{});
  }
  DrawInput input(int width, int height) const { return draw_input(*extracted_, scene_, width, height); }
  /// Pixels of a device are where the window puts them, rounded.
  template <class T>
  void expect_same(const std::vector<T>& slices, const std::vector<T>& whole) const {
    ASSERT_EQ(slices.size(), whole.size());
    const double off = GetParam() == std::string("native") ? 0 : std::is_integral_v<T> ? 1 : 1e-3;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      if (slices[i] == whole[i]) continue;  // infinite depths, too
      ASSERT_NEAR(slices[i], whole[i], off) << i;
    }
  }

  std::unique_ptr<Renderer> renderer_;
  Scene scene_;
  std::shared_ptr<const ExtractedScene> extracted_;
};

TEST_P(Slices, AreThePictureWhateverItIsMadeOf) {
  int between = 0;
  SlicedRenderer sliced(*renderer_, 70 * 9, [&] { ++between; });
  for (const bool floats : {false, true})
    for (const bool part : {false, true}) {
      DrawInput of = input(70, 50);
      of.float_image = floats;
      of.mean_depth = floats;
      if (part) of.window = {15, 20, 140, 100};
      const DrawResult whole = renderer_->draw(of), slices = sliced.draw(of);
      ASSERT_EQ(slices.image.index(), whole.image.index());
      EXPECT_EQ(slices.facts.tetrahedra, whole.facts.tetrahedra);
      if (const auto* image = std::get_if<Image>(&whole.image)) {
        expect_same(std::get<Image>(slices.image).rgba, image->rgba);
        continue;
      }
      const auto &a = std::get<FloatImage>(whole.image), &b = std::get<FloatImage>(slices.image);
      expect_same(b.rgba, a.rgba);
      expect_same(b.depth, a.depth);
      expect_same(b.mean_depth, a.mean_depth);
    }
  EXPECT_EQ(between, 4 * 6 - 1) << "before each of six slices but the very first";
}

TEST_P(Slices, OfASmallPictureIsOneAndARowIsTheLeast) {
  int between = 0;
  SlicedRenderer sliced(*renderer_, 10, [&] { ++between; });
  sliced.draw(input(5, 2));
  EXPECT_EQ(between, 0);
  expect_same(std::get<Image>(sliced.draw(input(20, 3)).image).rgba, std::get<Image>(renderer_->draw(input(20, 3)).image).rgba);
  EXPECT_EQ(between, 3);
}

TEST_P(Slices, EndWhereWhatIsBetweenThemThrows) {
  Task task;
  int drawn = 0;
  SlicedRenderer sliced(*renderer_, 70 * 10, [&] {
    if (++drawn == 2) task.cancel();
    task.check();
  });
  EXPECT_THROW(sliced.draw(input(70, 50)), Error);
  EXPECT_EQ(drawn, 2);
  EXPECT_EQ(sliced.device(), renderer_->device());
  EXPECT_EQ(sliced.cuts_intervals(), renderer_->cuts_intervals());
}

INSTANTIATE_TEST_SUITE_P(Renderers, Slices, ::testing::Values("native", "raster", "compute"), [](const auto& of) { return std::string(of.param); });

}  // namespace
}  // namespace isostrata
