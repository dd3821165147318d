#include "engine/picture/draw_still.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/draw_lit.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/scene_legend.h"
#include "rendering/light/light_rows.h"
#include "support/pictures.h"

namespace isostrata {
namespace {

using testing::test_device;

class DrawStill : public ::testing::Test {
 protected:
  DrawStill() : dataset_(make_analytic("torus:12", {}, Task{})) {
    scene_.array = dataset_->arrays[0].name;
    for (const auto& [lower, upper] : {std::pair{-0.2, 0.1}, {0.15, 0.4}}) {
      SceneInterval interval;
      interval.lower = lower;
      interval.upper = upper;
      interval.color = default_interval_color(scene_.intervals.size());
      scene_.intervals.push_back(interval);
    }
    scene_.intervals[1].color_map = "viridis";
    extracted_ = extract_scene(dataset_, scene_, nullptr, task_);
  }

  Still still(int width, int height) const {
    Still out;
    out.input = draw_input(*extracted_, scene_, width, height);
    return out;
  }

  FloatImage floats(const Still& still, Task* task = nullptr) {
    FloatImage all{still.input.width, 0, {}, {}};
    draw_still(testing::test_renderer(), still, task ? *task : task_, [&](const AnyImage& rows) {
      const auto& image = std::get<FloatImage>(rows);
      EXPECT_EQ(image.width, all.width);
      all.height += image.height;
      all.rgba.insert(all.rgba.end(), image.rgba.begin(), image.rgba.end());
      all.depth.insert(all.depth.end(), image.depth.begin(), image.depth.end());
    });
    EXPECT_EQ(all.height, still.input.height);
    return all;
  }

  Task task_;
  std::shared_ptr<const Dataset> dataset_;
  Scene scene_;
  std::shared_ptr<const ExtractedScene> extracted_;
};

TEST_F(DrawStill, APartOfAPictureIsThatPartOfTheWholeWhateverDrawsIt) {
  for (const char* name : {"raster", "native", "compute"}) {
    const auto renderer = make_renderer({name, std::string(name) == "native" ? "native" : test_device()});
    for (const bool constant : {false, true})
      for (const bool orthographic : {false, true}) {
        DrawInput input = still(70, 50).input;
        input.camera.orthographic = orthographic;
        if (constant) input.styles[1].color_map.clear();
        input.clip_planes = {{{1, 0.2, 0}, -0.3}};
        const FloatImage whole = testing::draw_floats(input, *renderer);
        for (const PictureWindow window : {PictureWindow{0, 0, 70, 50}, {13, 7, 70, 50}, {50, 31, 70, 50}, {69, 49, 70, 50}}) {
          DrawInput part = input;
          part.window = window;
          part.width = std::min(20, 70 - window.x);
          part.height = std::min(19, 50 - window.y);
          const FloatImage image = testing::draw_floats(part, *renderer);
          double error = 0;
          for (int y = 0; y < part.height; ++y)
            for (int x = 0; x < part.width; ++x)
              for (std::size_t c = 0; c < 4; ++c)
                error = std::max(error, std::abs(static_cast<double>(testing::pixel(image, x, y)[c]) -
                                                 static_cast<double>(testing::pixel(whole, x + window.x, y + window.y)[c])));
          EXPECT_LT(error, 2e-3) << name << " at " << window.x << ", " << window.y << (orthographic ? ", orthographic" : "")
                                 << (constant ? ", constant" : "");
        }
      }
  }
}

TEST_F(DrawStill, SamplesAreTheMeanOfALargerPicture) {
  Still fine = still(72, 48);
  fine.input.float_image = true;
  const FloatImage large = floats(fine);
  Still sampled = still(24, 16);
  sampled.input.float_image = true;
  sampled.samples = 3;
  const FloatImage image = floats(sampled);
  ASSERT_EQ(image.depth.size(), 24u * 16u);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x) {
      std::array<double, 4> mean{};
      float nearest = std::numeric_limits<float>::infinity();
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) {
          for (std::size_t c = 0; c < 4; ++c) mean[c] += testing::pixel(large, 3 * x + i, 3 * y + j)[c] / 9.0;
          nearest = std::min(nearest, large.depth[static_cast<std::size_t>((3 * y + j) * 72 + 3 * x + i)]);
        }
      for (std::size_t c = 0; c < 4; ++c) ASSERT_NEAR(testing::pixel(image, x, y)[c], mean[c], 2e-3) << x << ", " << y;
      ASSERT_EQ(std::isinf(image.depth[static_cast<std::size_t>(24 * y + x)]), std::isinf(nearest));
    }
}

/// Surfaces in a fog, lit by depth.
class LitStill : public DrawStill {
 protected:
  LitStill() {
    scene_.intervals[0].surface.upper = true;
    scene_.intervals[1].color_map.clear();
    scene_.intervals[1].opacity = 0.05;
    scene_.light = {1, 0.5};
    extracted_ = extract_scene(dataset_, scene_, nullptr, task_);
  }
  Still lit(int width, int height) const {
    Still out = still(width, height);
    out.light = scene_.light;
    return out;
  }
};

TEST_F(LitStill, LooksTheSameWhateverDrawsIt) {
  const Still of = lit(90, 70);
  const auto native = make_renderer({"native", "native"});
  const FloatImage plain = testing::draw_floats(of.input, *native);
  DrawInput floats = of.input;
  floats.float_image = true;
  const FloatImage expected = std::get<FloatImage>(draw_lit(*native, floats, of.light).image);
  double changed = 0;
  for (std::size_t i = 0; i < plain.rgba.size(); ++i) changed += std::abs(plain.rgba[i] - expected.rgba[i]);
  EXPECT_GT(changed / static_cast<double>(plain.rgba.size()), 0.002);
  for (const char* name : {"raster", "compute"}) {
    const auto renderer = make_renderer({name, test_device()});
    const FloatImage other = std::get<FloatImage>(draw_lit(*renderer, floats, of.light).image);
    double sum = 0;
    std::size_t far = 0;
    for (std::size_t i = 0; i < expected.rgba.size(); ++i) {
      const double off = std::abs(double{other.rgba[i]} - expected.rgba[i]);
      sum += off;
      far += off > 1.0 / 255;
    }
    EXPECT_LT(sum / static_cast<double>(expected.rgba.size()), 1e-3) << name;
    EXPECT_LT(static_cast<double>(far) / static_cast<double>(expected.rgba.size()), 0.01) << name;
  }
}

TEST_F(LitStill, IsTheUnlitOneToTheLastBitWithoutLight) {
  DrawInput input = still(60, 50).input;
  const auto native = make_renderer({"native", "native"});
  EXPECT_EQ(std::get<Image>(draw_lit(*native, input, {}).image).rgba, testing::draw_bytes(input, *native).rgba);
  // And what lies nearest by a hundredth of it is hardly another picture.
  const Image faint = std::get<Image>(draw_lit(*native, input, {0.004, 0.004}).image), plain = testing::draw_bytes(input, *native);
  for (std::size_t i = 0; i < plain.rgba.size(); ++i) ASSERT_NEAR(faint.rgba[i], plain.rgba[i], 2) << i;
}

TEST_F(LitStill, IsThatOfTheWholePictureInBandsWithSamplesAndUnderAnnotations) {
  // Of samples: more than a part holds.
  Still large = lit(1200, 900);
  large.samples = 4;
  large.input.float_image = true;
  const auto native = make_renderer({"native", "native"});
  std::vector<float> banded, averaged, mean;
  int bands = 0;
  draw_still(*native, large, task_, [&](const AnyImage& rows) {
    const auto& image = std::get<FloatImage>(rows);
    banded.insert(banded.end(), image.rgba.begin(), image.rgba.end());
    ++bands;
  });
  EXPECT_GT(bands, 1);
  ASSERT_EQ(banded.size(), 4u * 1200 * 900);
  // The same samples without light in the whole, lit at once.
  DrawInput fine = large.input;
  fine.mean_depth = true;
  FloatImage all{1200, 900, std::vector<float>(4u * 1200 * 900), {}, std::vector<float>(1200 * 900)};
  constexpr int kRows = 100;
  for (int y = 0; y < 900; y += kRows) {
    fine.window = {0, 4 * y, 4 * 1200, 4 * 900};
    fine.width = 4 * 1200;
    fine.height = 4 * kRows;
    const FloatImage part = std::get<FloatImage>(native->draw(fine).image);
    for (int row = 0; row < 4 * kRows; ++row)
      for (int x = 0; x < 4 * 1200; ++x) {
        const auto from = static_cast<std::size_t>(row * 4 * 1200 + x), to = static_cast<std::size_t>((y + row / 4) * 1200 + x / 4);
        for (std::size_t c = 0; c < 4; ++c) all.rgba[4 * to + c] += part.rgba[4 * from + c] / 16;
        all.mean_depth[to] += part.mean_depth[from] / 16;
      }
  }
  const FloatImage expected = LightRows(large.light, large.input).add(std::move(all));
  std::size_t off = 0;
  for (std::size_t i = 0; i < banded.size(); ++i) off += std::abs(banded[i] - expected.rgba[i]) > 1e-3f;
  EXPECT_LT(off, banded.size() / 20000);

  // Annotations are not lit: a frame's edge is as bright as without light.
  Still boxed = lit(96, 96);
  scene_.annotations.box = true;
  boxed.annotations = annotate(annotation_input(*extracted_, scene_, boxed.input));
  boxed.light = {0, 1};
  Still unlit = boxed;
  unlit.light = {};
  const auto brightest = [&](const Still& of) {
    int most = 0;
    draw_still(*native, of, task_, [&](const AnyImage& rows) {
      for (const std::uint8_t value : std::get<Image>(rows).rgba) most = std::max<int>(most, value == 255 ? 0 : value);
    });
    return most;
  };
  EXPECT_NEAR(brightest(boxed), brightest(unlit), 1);
}

/// Draws nothing but where its pixels lie in the whole picture, in less memory than a picture.
class GridRenderer final : public Renderer {
 public:
  DrawResult draw(const DrawInput& input) override {
    ++draws;
    largest = std::max(largest, static_cast<std::int64_t>(input.width) * input.height);
    EXPECT_LE(std::max(input.width, input.height), 16384);
    Image image{input.width, input.height,
                std::vector<std::uint8_t>(4 * static_cast<std::size_t>(input.width) * static_cast<std::size_t>(input.height))};
    for (int y = 0; y < input.height; ++y)
      for (int x = 0; x < input.width; x += 257) {
        std::uint8_t* pixel =
            &image.rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(input.width) + static_cast<std::size_t>(x))];
        pixel[0] = static_cast<std::uint8_t>(y + input.window.y);
        pixel[1] = static_cast<std::uint8_t>((y + input.window.y) >> 8);
      }
    return {std::move(image), {}};
  }
  const std::string& device() const override { return device_; }
  int draws = 0;
  std::int64_t largest = 0;

 private:
  const std::string device_ = "grid";
};

TEST_F(DrawStill, TheLargestPictureComesInBandsThatFitMemory) {
  GridRenderer renderer;
  int row = 0;
  draw_still(renderer, still(16384, 16384), task_, [&](const AnyImage& rows) {
    const auto& image = std::get<Image>(rows);
    ASSERT_EQ(image.width, 16384);
    for (int y = 0; y < image.height; ++y, ++row) {
      const std::uint8_t* pixel = &image.rgba[4 * static_cast<std::size_t>(y) * 16384];
      ASSERT_EQ(pixel[0] + 256 * pixel[1], row);
    }
  });
  EXPECT_EQ(row, 16384);
  EXPECT_LE(renderer.largest, 1 << 24);
}

TEST_F(DrawStill, IsCancelledBetweenBands) {
  GridRenderer renderer;
  Task task;
  EXPECT_THROW(draw_still(renderer, still(16384, 8192), task, [&](const AnyImage&) { task.cancel(); }), Error);
  EXPECT_EQ(renderer.draws, 1);
}

TEST_F(DrawStill, RefusesSamplesThatAreNone) {
  for (const int samples : {-1, 0, 17}) {
    Still wrong = still(8, 8);
    wrong.samples = samples;
    EXPECT_THROW(draw_still(testing::test_renderer(), wrong, task_, [](const AnyImage&) {}), Error);
  }
}

TEST_F(DrawStill, TheFarEdgesOfTheBoxShowThroughTheVolumeAndNotOverIt) {
  // Opaque intervals: what lies under them must not show, however the picture is asked for.
  scene_.intervals.resize(1);
  scene_.intervals[0].color_map.clear();
  scene_.intervals[0].lower = -10;
  scene_.intervals[0].upper = 10;
  scene_.intervals[0].opacity = 1;
  scene_.intervals[0].color = {0, 1, 0};
  scene_.background = {0, 0, 0};
  scene_.annotations.box = true;
  extracted_ = extract_scene(dataset_, scene_, nullptr, task_);
  Still boxed = still(96, 96);
  boxed.annotations = annotate(annotation_input(*extracted_, scene_, boxed.input));
  Image image;
  draw_still(testing::test_renderer(), boxed, task_, [&](const AnyImage& rows) { image = std::get<Image>(rows); });
  Still hidden = boxed;
  hidden.annotations.under.clear();
  Image without;
  draw_still(testing::test_renderer(), hidden, task_, [&](const AnyImage& rows) { without = std::get<Image>(rows); });
  ASSERT_EQ(boxed.annotations.under.size(), 3u);
  int inside_changed = 0;
  const FloatImage plain = testing::draw_floats(still(96, 96).input);
  for (std::size_t p = 0; p < plain.rgba.size() / 4; ++p)
    if (plain.rgba[4 * p + 3] > 0.999f)
      for (std::size_t c = 0; c < 3; ++c) inside_changed += std::abs(image.rgba[4 * p + c] - without.rgba[4 * p + c]) > 1;
  EXPECT_EQ(inside_changed, 0);

  // The stream's way to the same picture.
  for (const bool exact : {true, false}) {
    DrawInput asked = boxed.input;
    ask_for_annotated(asked, exact);
    const Image streamed =
        finish_annotated(testing::test_renderer().draw(asked).image, boxed.annotations, scene_.background, false);
    int largest = 0;
    for (std::size_t i = 0; i < image.rgba.size(); ++i) largest = std::max(largest, std::abs(image.rgba[i] - streamed.rgba[i]));
    EXPECT_LE(largest, exact ? 0 : 2);
  }
}

}  // namespace
}  // namespace isostrata
