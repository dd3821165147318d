// A frame of several samples a pixel is what a still of as many is.
#include "engine/engine/make_picture.h"

#include <gtest/gtest.h>

#include "data/dataset/analytic.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "engine/picture/scene_legend.h"
#include "rendering/choice/native_renderer.h"

namespace isostrata {
namespace {

class MakePicture : public ::testing::Test {
 protected:
  MakePicture() : dataset_(make_analytic("torus:20", {}, Task{})), renderer_(make_renderer({"native", "native"})) {
    order_.scene.array = dataset_->arrays[0].name;
    SceneInterval interval;
    interval.lower = -0.1;
    interval.upper = 0.2;
    interval.surface.lower = interval.surface.upper = true;
    order_.scene.intervals.push_back(interval);
    order_.extracted = extract_scene(dataset_, order_.scene, nullptr, Task{});
    order_.task = std::make_shared<Task>();
    order_.request.width = 90;
    order_.request.height = 60;
    order_.request.lossless = true;
    order_.request.jpeg = false;
  }

  Image drawn(int samples) {
    order_.request.samples = samples;
    DrawnPicture picture = draw_picture(*renderer_, order_, "");
    EXPECT_EQ(picture.frame.samples, samples);
    if (picture.annotations.empty()) return std::get<Image>(std::move(picture.image));
    return finish_annotated(std::move(picture.image), picture.annotations, picture.background, false);
  }
  Image still(int samples) {
    const DrawInput input = draw_input(*order_.extracted, order_.scene, 90, 60);
    Image all{90, 60, {}};
    draw_still(*renderer_, {input, annotate(annotation_input(*order_.extracted, order_.scene, input)), samples, kPartSamples, order_.scene.light}, Task{}, [&](const AnyImage& rows) {
      const Image& image = std::get<Image>(rows);
      all.rgba.insert(all.rgba.end(), image.rgba.begin(), image.rgba.end());
    });
    return all;
  }

  std::shared_ptr<const Dataset> dataset_;
  std::unique_ptr<Renderer> renderer_;
  PictureOrder order_;
};

TEST_F(MakePicture, OfSeveralSamplesIsTheStillOfAsManyWithItsAxes) {
  const Image plain = drawn(1);
  for (const bool annotated : {false, true}) {
    order_.scene.annotations.box = order_.scene.annotations.axes = annotated;
    for (const int samples : {1, 2, 4}) {
      const Image frame = drawn(samples);
      EXPECT_EQ(frame.rgba, still(samples).rgba) << samples << (annotated ? ", annotated" : "");
      EXPECT_EQ(frame.rgba == plain.rgba, samples == 1 && !annotated) << "more samples change nothing: the test shows nothing";
    }
  }
}

TEST_F(MakePicture, LitByDepthIsTheStillThatIs) {
  const Image plain = drawn(1);
  order_.scene.light = {1, 0.5};
  for (const bool annotated : {false, true}) {
    order_.scene.annotations.box = order_.scene.annotations.axes = annotated;
    for (const int samples : {1, 2}) {
      const Image frame = drawn(samples);
      EXPECT_EQ(frame.rgba, still(samples).rgba) << samples << (annotated ? ", annotated" : "");
      EXPECT_NE(frame.rgba, plain.rgba);
    }
  }
  // In motion to the step of 8 bits; letters of a picture as small as this one are smaller then.
  order_.scene.annotations = {};
  const Image exact = drawn(1);
  order_.request.lossless = false;
  const Image moving = drawn(1);
  for (std::size_t i = 0; i < exact.rgba.size(); ++i) ASSERT_NEAR(moving.rgba[i], exact.rgba[i], 1) << i;
}

TEST_F(MakePicture, OfSeveralSamplesIsGivenUpWhenItsTaskIs) {
  order_.task->cancel();
  EXPECT_THROW(drawn(2), Error);
}

}  // namespace
}  // namespace isostrata
