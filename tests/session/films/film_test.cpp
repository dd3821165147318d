#include "session/films/film.h"

#include <gtest/gtest.h>

#include "session/asked_engine.h"
#include "support/fin_facts.h"
#include "support/read_process.h"
#include "support/run_isostrata.h"
#include "support/temporary_folder.h"
#include "support/webm_elements.h"

namespace isostrata {
namespace {

using isostrata::testing::read_text;

/// A film of five pictures, a second each, asked of an engine that answers when the test says so.
class FilmOfFive : public ::testing::Test {
 protected:
  void begin() {
    v1::NewFilm wanted;
    wanted.set_turn_deg(50);
    wanted.set_seconds(5);
    wanted.set_frames_per_second(1);
    wanted.set_width(64);
    wanted.set_height(48);
    FilmPlan plan;
    ASSERT_FALSE(plan_film(wanted, {}, fin_facts(), plan));
    film_ = std::make_shared<Film>(engine_, 77, plan, path_,
                                   Film::Ports{[this](double fraction) { told_.push_back(fraction); },
                                               [this](std::optional<v1::Error> error, std::uint64_t bytes) {
                                                 ++ends_;
                                                 error_ = std::move(error);
                                                 bytes_ = bytes;
                                               }});
    film_->begin();
  }
  const FrameRequest& newest() const { return std::get<FrameRequest>(engine_.asked.back()); }
  /// What is asked for comes, with so many bytes.
  void come(std::size_t bytes = 10) {
    const FrameRequest& of = newest();
    FrameReady frame;
    frame.video = VideoFacts{Codec::vp9_444, of.video->stream, of.video->key};
    frame.bytes = std::make_shared<const Bytes>(Bytes(bytes, static_cast<std::uint8_t>(engine_.asked.size())));
    engine_.answer(engine_.last, frame);
  }
  bool closed() const {
    const auto* last = std::get_if<CloseSession>(&engine_.posted.back());
    return last && last->session == 77;
  }

  isostrata::testing::TemporaryFolder folder_;
  const std::filesystem::path path_ = folder_ / "film.webm";
  AskedEngine engine_;
  std::shared_ptr<Film> film_;
  std::vector<double> told_;
  std::optional<v1::Error> error_;
  std::uint64_t bytes_ = 0;
  int ends_ = 0;
};

TEST_F(FilmOfFive, AsksForOneExactPictureAfterTheOtherOfASceneOfItsOwn) {
  begin();
  std::vector<bool> keys;
  for (std::size_t i = 0; i < 5; ++i) {
    ASSERT_EQ(engine_.asked.size(), i + 1);
    const auto& update = std::get<SceneUpdate>(engine_.posted.at(i));
    EXPECT_EQ(update.session, 77u);
    EXPECT_EQ(update.scene.revision, i + 1);
    EXPECT_EQ(newest().session, 77u);
    EXPECT_TRUE(newest().lossless && newest().video && newest().video->quantizer);
    EXPECT_EQ(newest().width, 64);
    EXPECT_EQ(newest().samples, 2);
    keys.push_back(newest().video->key);
    come();
  }
  EXPECT_EQ(keys, (std::vector{true, false, true, false, true}));  // two seconds apart
  EXPECT_EQ(told_, (std::vector{0.2, 0.4, 0.6, 0.8}));
  EXPECT_EQ(ends_, 1);
  EXPECT_FALSE(error_);
  EXPECT_TRUE(closed());
  EXPECT_TRUE(engine_.listeners.empty());
  const std::string file = read_text(path_);
  EXPECT_EQ(bytes_, file.size());
  const auto frames = isostrata::testing::frames_of(file);
  ASSERT_EQ(frames.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(frames[i].time_ms, i * 1000);
    EXPECT_EQ(frames[i].key, keys[i]);
    EXPECT_EQ(frames[i].bytes, std::string(10, static_cast<char>(i + 1)));
  }
}

TEST_F(FilmOfFive, NothingIsLeftOfOneThatIsCancelledOrFails) {
  for (const bool fails : {false, true}) {
    ends_ = 0;
    begin();
    come();
    come();
    EXPECT_FALSE(std::filesystem::is_empty(folder_.path()));
    const std::weak_ptr<Film> left = film_;
    if (fails)
      engine_.answer(engine_.last, RequestFailed{77, engine_.last, 0, ErrorCode::too_large, "the mesh does not fit"});
    else
      film_->cancel();
    film_.reset();
    EXPECT_TRUE(left.expired());
    EXPECT_TRUE(closed());
    EXPECT_TRUE(engine_.listeners.empty());
    EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
    EXPECT_EQ(ends_, fails ? 1 : 0);
    EXPECT_EQ(error_ ? error_->message() : "", fails ? "the mesh does not fit" : "");
  }
}

TEST_F(FilmOfFive, AFileThatCannotBeWrittenSaysSoAndNotWhereItIs) {
  std::filesystem::create_directory(path_.string() + ".part");
  begin();
  come();
  EXPECT_EQ(ends_, 1);
  ASSERT_TRUE(error_);
  EXPECT_EQ(error_->code(), "unavailable");
  EXPECT_EQ(error_->message().find(folder_.path().string()), std::string::npos) << error_->message();
  EXPECT_TRUE(closed());
}

TEST_F(FilmOfFive, APictureWithoutVideoEndsIt) {
  begin();
  FrameReady frame;
  frame.bytes = std::make_shared<const Bytes>(Bytes(10, 1));
  engine_.answer(engine_.last, frame);
  EXPECT_EQ(ends_, 1);
  ASSERT_TRUE(error_);
  EXPECT_EQ(error_->code(), "internal");
}

}  // namespace
}  // namespace isostrata
