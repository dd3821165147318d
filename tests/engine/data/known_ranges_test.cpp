// What an engine learns of a series' ranges, beside other work.
#include "engine/data/known_ranges.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "data/dataset/analytic.h"
#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "support/plain_renderer.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

constexpr const char* kSeries = "cylinder:8x8x4x6";

class RangesOfASeries : public ::testing::Test, protected HeardEvents {
 protected:
  RangesOfASeries() {
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({kSeries, "cylinder:96x96x48x200"});
    for (const CatalogueEntry& entry : options.catalogue.entries()) ids_[entry.source] = entry.id;
    options.renderer = [] { return std::make_unique<PlainRenderer>(std::make_shared<PlainRendererControl>()); };
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~RangesOfASeries() override { engine_.reset(); }

  DatasetFacts open(RequestId request, bool all, const std::string& source = kSeries) {
    engine_->post(OpenRequest{1, request, ids_[source], all});
    return wait_for<DatasetReady>([=](const DatasetReady& r) { return r.request == request; }).facts;
  }
  static std::vector<std::vector<ValueRange>> truth() {  // [arrays][nt]
    std::vector<std::vector<ValueRange>> ranges;
    for (int step = 0; step < 6; ++step) {
      OpenOptions options;
      options.step = step;
      const auto dataset = make_analytic(kSeries, options, Task());
      ranges.resize(dataset->arrays.size());
      for (std::size_t a = 0; a < ranges.size(); ++a) ranges[a].push_back({dataset->arrays[a].lower, dataset->arrays[a].upper});
    }
    return ranges;
  }

  std::map<std::string, std::string> ids_;
  std::unique_ptr<Engine> engine_;
};

TEST_F(RangesOfASeries, AreThoseOfTheFirstStepUntilAllAreReadAndKnownFromThenOn) {
  const auto expected = truth();
  const DatasetFacts first = open(1, false);
  EXPECT_EQ(first.missing_steps, 1) << "the first view looks at five of six";
  const DatasetFacts all = open(2, true), again = open(3, false);
  bool grew = false;
  for (const DatasetFacts* facts : {&all, &again}) {
    EXPECT_EQ(facts->missing_steps, 0);
    for (std::size_t a = 0; a < expected.size(); ++a) {
      ValueRange looked_at;
      for (const int step : {0, 1, 3, 4, 5}) looked_at = join(looked_at, expected[a][static_cast<std::size_t>(step)]);
      EXPECT_EQ(first.arrays[a].range(), looked_at);
      EXPECT_EQ(facts->arrays[a].steps, expected[a]);
      ValueRange whole;
      for (const ValueRange& step : expected[a]) whole = join(whole, step);
      EXPECT_EQ(facts->arrays[a].range(), whole) << facts->arrays[a].name;
      grew = grew || whole != expected[a][0];
    }
    EXPECT_EQ(facts->first_view, first.first_view) << "what is seen first does not change when more is known";
  }
  EXPECT_TRUE(grew) << "a series whose first step has all values proves nothing";
}

TEST_F(RangesOfASeries, AHistogramSpansWhatItIsToldAtLeast) {
  engine_->post(HistogramRequest{1, 4, ids_[kSeries], 2, "Density", 8, {-100, 100}});
  const auto ready = wait_for<HistogramReady>([](const HistogramReady& h) { return h.request == 4; });
  EXPECT_EQ(ready.lower, -100);
  EXPECT_EQ(ready.upper, 100);
  std::uint64_t sum = 0;
  for (const auto count : ready.counts) sum += count;
  EXPECT_EQ(sum, 8u * 8 * 4);
}

TEST_F(RangesOfASeries, ReadingThemShowsHowFarItIsAndEndsWhenSomebodySaysSo) {
  const std::string large = "cylinder:96x96x48x200";
  engine_->post(OpenRequest{1, 5, ids_[large], true});
  double before = -1;
  for (int i = 0; i < 3; ++i) {
    const auto progress = wait_for<OperationProgress>(
        [&](const OperationProgress& p) { return p.works_for == 5 && p.fraction > before && p.stage.find("all steps") != p.stage.npos; });
    EXPECT_LT(progress.fraction, 1);
    before = progress.fraction;
  }
  // Whoever wants something else meanwhile need not wait for it.
  EXPECT_EQ(open(6, false).missing_steps, 1);
  engine_->post(CancelRequest{1, 0, 5});
  EXPECT_EQ(failure_of(5).code, ErrorCode::cancelled);
  EXPECT_TRUE(wait_for<OperationDone>([](const OperationDone& d) { return d.works_for == 5; }).cancelled);
  const int missing = open(7, false, large).missing_steps;
  EXPECT_GT(missing, 0);
  EXPECT_LT(missing, 195) << "what was read is not forgotten";
}

TEST(KnownRanges, AFileThatWasChangedIsAnotherSeries) {
  const std::string source = "series", changed = "series~2";  // as version_id names them
  const std::vector<float> old_values{0, 1}, new_values{5, 6};
  Dataset step;
  step.times = {0, 1};
  PointArray array;
  array.values = std::span<const float>(old_values);
  measure_range(array);
  step.arrays = {array};
  KnownRanges known;
  EXPECT_FALSE(known.next(source));
  known.add(source, step);
  EXPECT_EQ(known.next(source), 1);
  known.skip(source, 1, "it is broken");
  EXPECT_EQ(known.next(source), -1);
  EXPECT_EQ(known.find(source)->notes, (std::vector<std::string>{"step 1 is left out of the ranges: it is broken"}));

  array.values = std::span<const float>(new_values);
  measure_range(array);
  step.arrays = {array};
  known.add(changed, step);
  EXPECT_EQ(known.next(changed), 1);
  EXPECT_EQ(known.find(changed)->ranges.arrays()[0].all, (ValueRange{5, 6}));
}

}  // namespace
}  // namespace isostrata
