#include "engine/first/kept_first_view.h"

#include <gtest/gtest.h>

#include <fstream>

#include "data/dataset/analytic.h"
#include "data/values/kept_facts.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

struct KeptFirstView : ::testing::Test {
  testing::TemporaryFolder folder;
  std::shared_ptr<const Dataset> dataset = make_analytic("torus:16", {}, Task());

  void place() const { set_place_of_facts(dataset->arrays.front().storage, folder.path(), "array_0."); }
  FirstView look() const {
    return first_view(*dataset, [](int, const Task&) -> std::shared_ptr<const Dataset> { throw Error(ErrorCode::internal, "another step"); }, {}, Task());
  }
};

TEST_F(KeptFirstView, IsTheOneThatWasMade) {
  const FirstView made = look();
  EXPECT_FALSE(kept_first_view(*dataset)) << "an array that was not imported has no place";
  place();
  EXPECT_FALSE(kept_first_view(*dataset));
  EXPECT_EQ(look(), made);
  const auto kept = kept_first_view(*dataset);
  ASSERT_TRUE(kept);
  EXPECT_EQ(*kept, made);
}

TEST_F(KeptFirstView, IsWhatTheSecondLookGivesWithoutLookingAtValues) {
  place();
  FirstView view = look();
  view.array_reason = "kept, and not made again";
  view.values = FieldValues::whole;
  keep_first_view(*dataset, view);
  EXPECT_EQ(look(), view);
  EXPECT_NE(first_view(*dataset, [](int, const Task&) { return std::shared_ptr<const Dataset>(); }, {dataset->arrays.front().name, 0}, Task()), view)
      << "who wishes for something gets it";
}

TEST_F(KeptFirstView, IsNotBelievedIfItIsDamagedOrCutOff) {
  place();
  look();
  const auto file = folder / "array_0.first-view";
  ASSERT_TRUE(std::filesystem::exists(file));
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 8);
  EXPECT_FALSE(kept_first_view(*dataset));
  std::ofstream(file, std::ios::binary) << "nonsense that is long enough to be one";
  EXPECT_FALSE(kept_first_view(*dataset));
  EXPECT_FALSE(look().array.empty()) << "it is made anew";
  EXPECT_TRUE(kept_first_view(*dataset));
}

}  // namespace
}  // namespace isostrata
