#include "session/datasets/dataset_versions.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

CatalogueEntry plume(std::uint32_t version, int parts = 1, std::uint64_t mark = 1) {
  return {.id = "plume", .name = "plume", .source = "plume.vti", .version = version, .parts = parts, .mark = mark};
}

class DatasetVersionsOfAServer : public ::testing::Test {
 protected:
  static std::shared_ptr<const Catalogue> catalogue(const CatalogueEntry& entry) {
    return std::make_shared<Catalogue>(Catalogue::from_entries({entry, {.id = "other", .name = "other", .source = "other.vti"}}));
  }
  std::string named(EngineRequest request, const std::string& shown = {}) {
    versions_.name_for_engine(request, [&](SessionKey) { return shown; });
    return std::visit(
        [](const auto& r) -> std::string {
          if constexpr (requires { r.dataset; }) return r.dataset;
          else if constexpr (requires { r.scene.dataset; }) return r.scene.dataset;
          else return {};
        },
        request);
  }

  std::vector<CatalogueEntry> told_;
  DatasetVersions versions_{catalogue(plume(2)), "a folder", true, [this](CatalogueEntry entry) { told_.push_back(std::move(entry)); }};
};

TEST_F(DatasetVersionsOfAServer, TheEngineIsToldOfWhatIsUsedBeforeItIsAskedForAndOnce) {
  EXPECT_TRUE(told_.empty());
  EXPECT_EQ(versions_.newest("plume"), "plume~2");
  ASSERT_EQ(told_.size(), 1u);
  EXPECT_EQ(told_[0].id, "plume~2");
  EXPECT_EQ(named(OpenRequest{1, 1, "plume"}), "plume~2");
  EXPECT_EQ(told_.size(), 1u);
  EXPECT_EQ(versions_.newest("no such one"), "no such one");
  EXPECT_EQ(told_.size(), 1u);
}

TEST_F(DatasetVersionsOfAServer, OfANewCatalogueTheEngineIsToldWhatHasChangedOfTheVersionsItKnows) {
  versions_.newest("plume");
  versions_.newest("other");
  versions_.replace(catalogue(plume(2, 3)), "a folder");
  ASSERT_EQ(told_.size(), 3u);
  EXPECT_EQ(told_[2].parts, 3);
  EXPECT_EQ(versions_.revision(), 2u);
  versions_.replace(catalogue(plume(2, 3, 9)), "a folder");
  ASSERT_EQ(told_.size(), 4u);
  EXPECT_EQ(told_[3].mark, 9u);
  versions_.replace(catalogue(plume(2, 3, 9)), "a folder");
  versions_.replace(catalogue(plume(3)), "a folder");
  EXPECT_EQ(told_.size(), 4u) << "nothing new, and a version that nobody has asked for";
  EXPECT_EQ(versions_.newest("plume"), "plume~3");
  EXPECT_EQ(told_.size(), 5u);
}

TEST_F(DatasetVersionsOfAServer, ASessionGoesOnWithTheVersionThatItShows) {
  SceneUpdate update{1, {}};
  update.scene.dataset = "plume";
  EXPECT_EQ(named(update, "plume~1"), "plume~1");
  EXPECT_EQ(named(update), "plume~2");
  EXPECT_EQ(named(update, "other"), "plume~2") << "it shows another dataset";
  EXPECT_EQ(named(OpenRequest{1, 1, "plume~1"}), "plume~1") << "it was named already";
  EXPECT_EQ(named(SceneUpdate{1, {}}, "plume~1"), "") << "nothing is shown";
}

TEST_F(DatasetVersionsOfAServer, PartsHaveTheVersionOfTheirWhole) {
  Region beginning;
  beginning.last[0] = 9;
  const std::string part = part_id("plume", beginning);
  EXPECT_EQ(versions_.entry(part)->id, "plume");
  const std::string version = versions_.newest(part);
  EXPECT_EQ(plain_id(version), part);
  EXPECT_NE(version.find("~2"), std::string::npos);
  EXPECT_EQ(told_.at(0).id, "plume~2") << "the engine makes parts of it itself";
}

TEST_F(DatasetVersionsOfAServer, ClientsNeverHearOfVersions) {
  DatasetReady ready{1, 1, {}};
  ready.facts.id = "plume~2";
  HistogramReady histogram;
  histogram.dataset = "plume~2";
  EXPECT_EQ(std::get<DatasetReady>(*versions_.name_for_clients(ready)).facts.id, "plume");
  EXPECT_EQ(std::get<HistogramReady>(*versions_.name_for_clients(histogram)).dataset, "plume");
  ready.facts.id = "plume";
  EXPECT_FALSE(versions_.name_for_clients(ready)) << "which is large, and is not copied";
  EXPECT_FALSE(versions_.name_for_clients(FrameStarted{1, 1}));
}

TEST_F(DatasetVersionsOfAServer, WithoutFilesThatAreFollowedIdsAreTheEnginesOwn) {
  DatasetVersions still(catalogue(plume(2)), "", false, [](const CatalogueEntry&) { FAIL(); });
  EXPECT_EQ(still.entry("plume"), nullptr);
  EXPECT_EQ(still.newest("plume"), "plume");
  EngineRequest request = OpenRequest{1, 1, "plume"};
  still.name_for_engine(request, [](SessionKey) { return "plume~1"; });
  EXPECT_EQ(std::get<OpenRequest>(request).dataset, "plume");
}

TEST_F(DatasetVersionsOfAServer, ListsSayOfWhichCatalogueTheyAre) {
  versions_.replace(catalogue(plume(3)), "another folder");
  const v1::ServerMessage list = versions_.list({}, 17);
  EXPECT_EQ(list.dataset_list().in_reply_to(), 17u);
  EXPECT_EQ(list.dataset_list().revision(), versions_.news().datasets_changed().revision());
  EXPECT_EQ(list.dataset_list().watching(), "another folder");
  EXPECT_EQ(versions_.news().datasets_changed().all(), 2u);
}

}  // namespace
}  // namespace isostrata
