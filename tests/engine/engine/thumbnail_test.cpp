// Small pictures of datasets: what they show, what they cost others, where they are kept.
#include "engine/engine/thumbnail.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <optional>
#include <set>

#include "data/open/import_cache.h"
#include "data/open/sandbox.h"
#include "encoding/image_file.h"
#include "engine/engine/engine.h"
#include "engine/first/first_scene.h"
#include "engine/heard_events.h"
#include "engine/picture/draw_input.h"
#include "engine/picture/extract_scene.h"
#include "rendering/choice/native_renderer.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

class Thumbnail : public ::testing::Test, protected HeardEvents {
 protected:
  void begin(const std::vector<std::string>& sources, std::uint64_t max_bytes = std::uint64_t{8} << 30) {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources(sources);
    options.renderer_choice.renderer = options.renderer_choice.device = "native";
    options.store.max_bytes = max_bytes;
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~Thumbnail() override { engine_.reset(); }

  void ask(RequestId request, const std::string& dataset) { engine_->post(ThumbnailRequest{0, request, dataset}); }
  Bytes picture_of(RequestId request) {
    return *wait_for<ThumbnailReady>([=](const ThumbnailReady& r) { return r.request == request; }).png;
  }
  /// Of `count` requests, in the order of their answers.
  std::vector<RequestId> answers(std::size_t count) {
    std::vector<RequestId> order;
    std::unique_lock lock(mutex_);
    EXPECT_TRUE(changed_.wait_for(lock, std::chrono::minutes(1), [&] {
      order.clear();
      for (const EngineEvent& event : events_)
        if (!std::holds_alternative<FrameStarted>(event) && !std::holds_alternative<OperationProgress>(event) && !std::holds_alternative<OperationDone>(event))
          if (const RequestId request = request_of(event)) order.push_back(request);
      return order.size() >= count;
    }));
    return order;
  }

  std::unique_ptr<Engine> engine_;
};

/// Width and height, as the PNG's header has them.
std::pair<int, int> size_of_png(const Bytes& png) {
  const auto number = [&](std::size_t at) { return png[at + 2] << 8 | png[at + 3]; };
  EXPECT_EQ(std::memcmp(png.data(), "\x89PNG\r\n\x1a\n", 8), 0);
  return {number(16), number(20)};
}

/// n x n x n distances from a point, as a file.
std::string field(int n, double at) {
  std::string text = "NRRD0004\ntype: float\ndimension: 3\nsizes: " + std::to_string(n) + ' ' + std::to_string(n) + ' ' + std::to_string(n) +
                     "\nencoding: raw\nendian: little\n\n";
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto value = static_cast<float>(std::hypot(i - at, j - n / 2.0, k - n / 2.0));
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
      }
  return text;
}

TEST_F(Thumbnail, IsTheFirstViewToTheLastBit) {
  begin({"torus:24"});
  ask(1, "torus-24");
  const Bytes png = picture_of(1);
  EXPECT_EQ(size_of_png(png), std::pair(kThumbnailWidth, kThumbnailHeight));
  const auto dataset = open_dataset("torus:24", {}, Task());
  const StepSource steps = [&](int, const Task&) { return dataset; };
  const Scene scene = first_scene(first_view(*dataset, steps, {}, Task()), 4.0 / 3);
  const auto extracted = extract_scene(steps, scene, nullptr, Task());
  const auto image = std::get<Image>(make_native_renderer()->draw(draw_input(*extracted, scene, kThumbnailWidth, kThumbnailHeight)).image);
  EXPECT_EQ(png, encode_png(image));
  std::set<std::array<std::uint8_t, 3>> colors;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) colors.insert({image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]});
  EXPECT_GT(colors.size(), 20u) << "it shows something";
}

TEST_F(Thumbnail, AreMadeOneAfterTheOtherAndAFrameComesBetween) {
  begin({"torus:12", "torus:96", "torus:95", "torus:94", "torus:93", "torus:92"});
  RequestId request = 10;
  for (const char* dataset : {"torus-96", "torus-95", "torus-94", "torus-93", "torus-92"}) ask(request++, dataset);
  engine_->post(SceneUpdate{1, scene(7)});
  engine_->post(frame(1, 1));
  const auto order = answers(6);
  EXPECT_NE(std::find(order.begin(), order.end() - 1, RequestId{1}), order.end() - 1) << "the frame did not wait for all of them";
}

TEST_F(Thumbnail, ThatNobodyWantsAnyMoreAreNotMade) {
  begin({"torus:200", "torus:12"});
  ask(1, "torus-200");
  ask(2, "torus-12");
  engine_->post(CancelRequest{0, 0, 2, true});
  engine_->post(CancelRequest{0, 0, 1, true});
  EXPECT_EQ(failure_of(1).code, ErrorCode::cancelled);
  EXPECT_EQ(failure_of(2).code, ErrorCode::cancelled);
  ask(3, "torus-12");
  EXPECT_FALSE(picture_of(3).empty());
}

TEST_F(Thumbnail, WhatHasNoneSaysWhy) {
  begin({"torus:12", "torus:200"}, 16 << 20);
  ask(1, "nothing");
  EXPECT_EQ(failure_of(1).code, ErrorCode::not_found);
  ask(2, "torus-200");  // 32 MB, and an eighth of 16 is left to it
  EXPECT_EQ(failure_of(2).code, ErrorCode::too_large);
  ask(3, part_id("torus-12", [] { Region half; half.stride = {2, 2, 2}; return half; }()));
  EXPECT_EQ(failure_of(3).code, ErrorCode::unsupported);
}

TEST_F(Thumbnail, OfADatasetThatSomebodyHasIsMadeOfThat) {
  const testing::TemporaryFolder folder;
  folder.write("a.nrrd", field(16, 4));
  begin({(folder / "a.nrrd").string()});
  const std::string id = engine_->catalogue().entries().at(0).id;
  engine_->post(OpenRequest{1, 1, id});
  wait_for<DatasetReady>([](const DatasetReady& r) { return r.request == 1; });
  ask(2, id);
  const Bytes before = picture_of(2);
  std::ofstream(folder / "a.nrrd") << "no field any more";
  ask(3, id);
  EXPECT_EQ(picture_of(3), before);
}

/// With an import cache for as long as it lives.
struct WithCache {
  testing::TemporaryFolder folder;
  WithCache() { set_import_cache(ImportCache{folder / "cache"}); }
  ~WithCache() { set_import_cache(std::nullopt); }
};

// A file that is another and looks like the one before says whether the picture was made anew.
TEST_F(Thumbnail, IsKeptForTheNextServerAndMadeAnewOfAnotherFile) {
  if (sandbox_support().landlock <= 0) GTEST_SKIP() << "this machine cannot keep a reader out of the cache: nothing is kept";
  const WithCache cache;
  const testing::TemporaryFolder folder;
  const fs::path file = folder / "a.nrrd";
  folder.write("a.nrrd", field(16, 4));
  const auto time = fs::last_write_time(file);
  const auto picture = [&](RequestId request) {
    begin({file.string()});  // the next server
    ask(request, engine_->catalogue().entries().at(0).id);
    return picture_of(request);
  };
  const Bytes first = picture(1);
  EXPECT_EQ(use_of(*import_cache()).entries, 1) << "the picture, and no import";
  const auto rewrite = [&](double at) { std::fstream(file, std::ios::in | std::ios::out | std::ios::binary) << field(16, at); };
  rewrite(12);
  fs::last_write_time(file, time);
  EXPECT_EQ(picture(2), first);
  fs::last_write_time(file, time + std::chrono::seconds(1));
  EXPECT_NE(picture(3), first);
  rewrite(4);
  fs::last_write_time(file, time + std::chrono::seconds(2));
  EXPECT_EQ(picture(4), first);
}

}  // namespace
}  // namespace isostrata
