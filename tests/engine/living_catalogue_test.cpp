// A catalogue that follows what happens in its folders. Every law holds by inotify and by looking again and again.
#include "engine/data/living_catalogue.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <deque>
#include <fstream>
#include <mutex>

#include "base/error.h"
#include "data/files/look_at_folder.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using News = CatalogueNews;

class LivingFolder : public ::testing::TestWithParam<bool> {
 protected:
  void begin(std::vector<std::string> sources = {}) {
    LivingOptions options;
    options.watch.inotify = GetParam();
    options.watch.poll = milliseconds(100);
    options.watch.quiet = milliseconds(300);
    if (sources.empty()) sources = {folder_.path().string()};
    living_ = std::make_unique<LivingCatalogue>(sources, options);
    newest_ = living_->now();
    living_->follow([this](std::shared_ptr<const Catalogue> now) {
      const std::lock_guard lock(mutex_);
      newest_ = std::move(now);
      changed_.notify_all();
    });
  }
  void TearDown() override { living_.reset(); }

  static const CatalogueEntry* named(const Catalogue& catalogue, const std::string& name) {
    for (const CatalogueEntry& entry : catalogue.entries())
      if (entry.name == name) return &entry;
    return nullptr;
  }
  /// Waits until the entry is like that, for longer than anything may take.
  template <class Law>
  CatalogueEntry wait_for(const std::string& name, const Law& law) {
    std::unique_lock lock(mutex_);
    const auto good = [&] {
      const CatalogueEntry* entry = named(*newest_, name);
      return entry && law(*entry);
    };
    EXPECT_TRUE(changed_.wait_for(lock, std::chrono::seconds(20), good)) << name;
    const CatalogueEntry* entry = named(*newest_, name);
    return entry ? *entry : CatalogueEntry{};
  }
  std::shared_ptr<const Catalogue> newest() {
    const std::lock_guard lock(mutex_);
    return newest_;
  }
  /// As programs do that are careful: complete under another name, then renamed.
  void put(const std::string& name, const std::string& text) {
    outside_.write("new", text);
    fs::rename(outside_ / "new", folder_ / name);
  }

  testing::TemporaryFolder folder_, outside_;
  std::unique_ptr<LivingCatalogue> living_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<const Catalogue> newest_;
};

INSTANTIATE_TEST_SUITE_P(Ways, LivingFolder, ::testing::Bool(), [](const auto& info) { return info.param ? "inotify" : "polling"; });

TEST_P(LivingFolder, ANewFileAppearsAChangedOneIsAnotherVersionADeletedOneIsGone) {
  folder_.write("a.vtk", "x");
  begin();
  const CatalogueEntry a = *named(*newest(), "a.vtk");
  EXPECT_EQ(a.news, News::none);
  put("b.vtk", "xy");
  const CatalogueEntry b = wait_for("b.vtk", [](const auto& e) { return e.news == News::appeared && !e.writing; });
  EXPECT_EQ(b.bytes, 2u);
  EXPECT_GT(b.noticed_unix_ms, 1'600'000'000'000);
  put("a.vtk", "xyz");
  const CatalogueEntry other = wait_for("a.vtk", [](const auto& e) { return e.news == News::changed && !e.writing; });
  EXPECT_EQ(other.id, a.id);
  EXPECT_EQ(other.version, a.version + 1);
  EXPECT_NE(version_id(other), a.id);
  EXPECT_EQ(plain_id(version_id(other)), a.id);
  EXPECT_EQ(other.mark, mark_on_disk(other.source, 1));
  fs::remove(folder_ / "a.vtk");
  EXPECT_EQ(wait_for("a.vtk", [](const auto& e) { return e.news == News::gone; }).id, a.id);
}

TEST_P(LivingFolder, AZarrFolderIsOneEntryWhichIsAnotherVersionIfItsMetadataIsRewritten) {
  const std::string array = R"({"zarr_format":2,"shape":[2,2,2],"chunks":[2,2,2],"dtype":"|u1","compressor":null,"fill_value":0,"order":"C","filters":null})";
  folder_.write("i.zarr/.zattrs", R"({"multiscales":[{"datasets":[{"path":"0"}]}]})");
  folder_.write("i.zarr/0/.zarray", array);
  folder_.write("i.zarr/0/0.0.0", "12345678");
  begin();
  EXPECT_EQ(newest()->entries().size(), 1u);
  const CatalogueEntry first = wait_for("i.zarr", [](const auto& e) { return !e.writing; });
  EXPECT_EQ(first.kind, "Zarr");
  folder_.write("i.zarr/.zattrs", R"({"multiscales":[{"name":"other","datasets":[{"path":"0"}]}]})");
  const CatalogueEntry other = wait_for("i.zarr", [&](const auto& e) { return e.version > first.version && !e.writing; });
  EXPECT_EQ(other.id, first.id);
  EXPECT_EQ(other.news, News::changed);
  folder_.write("i.zarr/1/.zarray", array);  // a level more
  EXPECT_EQ(wait_for("i.zarr", [&](const auto& e) { return e.version > other.version && !e.writing; }).news, News::changed);
  fs::remove_all(folder_ / "i.zarr");
  EXPECT_EQ(wait_for("i.zarr", [](const auto& e) { return e.news == News::gone; }).id, first.id);
}

TEST_P(LivingFolder, ASeriesGrowsAtItsEndAndIsAnotherVersionIfAStepIsRewritten) {
  for (const int n : {1, 2}) folder_.write("s_" + std::to_string(n) + ".vti", "step");
  begin();
  const CatalogueEntry two = *named(*newest(), "s_*.vti");
  EXPECT_EQ(two.parts, 2);
  put("s_3.vti", "step 3");
  const CatalogueEntry three = wait_for("s_*.vti", [](const auto& e) { return e.parts == 3 && !e.writing; });
  EXPECT_EQ(three.news, News::grown);
  EXPECT_EQ(version_id(three), version_id(two));
  EXPECT_EQ(three.mark, mark_on_disk(three.source, 3));
  put("s_2.vti", "another step");
  const CatalogueEntry other = wait_for("s_*.vti", [](const auto& e) { return e.news == News::changed && !e.writing; });
  EXPECT_EQ(other.version, two.version + 1);
  fs::remove(folder_ / "s_1.vti");
  EXPECT_EQ(wait_for("s_*.vti", [&](const auto& e) { return e.parts == 2 && !e.writing; }).version, other.version + 1);
}

TEST_P(LivingFolder, AFileBecomesASeriesUnderTheSameId) {
  folder_.write("s_1.vti", "step");
  begin();
  const CatalogueEntry one = *named(*newest(), "s_1.vti");
  put("s_2.vti", "step 2");
  const CatalogueEntry two = wait_for("s_*.vti", [](const auto& e) { return e.parts == 2 && !e.writing; });
  EXPECT_EQ(two.id, one.id);
  EXPECT_EQ(two.version, one.version);
  EXPECT_EQ(two.news, News::grown);
  EXPECT_EQ(named(*newest(), "s_1.vti"), nullptr);
}

TEST_P(LivingFolder, AStepCountsOnceItIsCompleteAndTheSeriesIsBeingWrittenUntilThen) {
  for (const int n : {1, 2}) folder_.write("s_" + std::to_string(n) + ".vti", "step");
  begin();
  std::ofstream out(folder_ / "s_3.vti");
  for (int i = 0; i < 3; ++i) {
    out << "more" << std::flush;
    const CatalogueEntry entry = wait_for("s_*.vti", [](const auto& e) { return e.writing; });
    EXPECT_EQ(entry.parts, 2);
  }
  out.close();
  const CatalogueEntry done = wait_for("s_*.vti", [](const auto& e) { return e.parts == 3 && !e.writing; });
  EXPECT_EQ(done.version, 0u);
  EXPECT_EQ(done.mark, mark_on_disk(done.source, 3));
}

TEST_P(LivingFolder, FoldersComeAndGo) {
  folder_.write("keep.vtk", "x");
  begin();
  outside_.write("run/deep/late.vtk", "x");
  fs::rename(outside_ / "run", folder_ / "run");
  wait_for("run/deep/late.vtk", [](const auto& e) { return e.news == News::appeared; });
  folder_.write("run/deep/later.vtk", "x");
  wait_for("run/deep/later.vtk", [](const auto& e) { return e.news == News::appeared; });
  fs::remove_all(folder_ / "run");
  wait_for("run/deep/late.vtk", [](const auto& e) { return e.news == News::gone; });
  EXPECT_EQ(named(*newest(), "keep.vtk")->news, News::none);
}

TEST_P(LivingFolder, TheFolderItselfMayGoAndComeBack) {
  folder_.write("data/a.vtk", "x");
  begin({(folder_ / "data").string()});
  fs::rename(folder_ / "data", folder_ / "away");
  wait_for("a.vtk", [](const auto& e) { return e.news == News::gone; });
  fs::rename(folder_ / "away", folder_ / "data");
  EXPECT_EQ(wait_for("a.vtk", [](const auto& e) { return e.news == News::appeared; }).version, 0u);
}

TEST_P(LivingFolder, AFileAndAPatternAreFollowedAmongOthers) {
  for (const char* name : {"one.vtk", "s_1.vti", "s_2.vti", "other.vtk"}) folder_.write(name, "x");
  begin({(folder_ / "one.vtk").string(), "torus:8", (folder_ / "s_*.vti").string()});
  ASSERT_EQ(newest()->entries().size(), 3u);
  EXPECT_EQ(newest()->entries().front().name, "one.vtk");
  put("s_3.vti", "x");
  wait_for("s_*.vti", [](const auto& e) { return e.parts == 3; });
  put("one.vtk", "another");
  wait_for("one.vtk", [](const auto& e) { return e.version == 1; });
  put("third.vtk", "x");
  fs::remove(folder_ / "one.vtk");
  wait_for("one.vtk", [](const auto& e) { return e.news == News::gone; });
  EXPECT_EQ(newest()->entries().size(), 3u);
}

TEST_P(LivingFolder, AParaViewCollectionGrowsWithItsList) {
  const auto collection = [](int steps) {
    std::string text = "<VTKFile type=\"Collection\"><Collection>";
    for (int i = 0; i < steps; ++i) text += "<DataSet timestep=\"" + std::to_string(i) + "\" file=\"in/p" + std::to_string(i) + ".vtu\"/>";
    return text + "</Collection></VTKFile>";
  };
  for (int i = 0; i < 4; ++i) folder_.write("in/p" + std::to_string(i) + ".vtu", "<VTKFile type=\"UnstructuredGrid\"/>");
  folder_.write("run.pvd", collection(2));
  begin();
  put("run.pvd", collection(3));
  const CatalogueEntry grown = wait_for("run.pvd", [](const auto& e) { return e.parts == 3 && !e.writing; });
  EXPECT_EQ(grown.news, News::grown);
  EXPECT_EQ(grown.version, 0u);
  put("run.pvd", collection(1));
  EXPECT_EQ(wait_for("run.pvd", [](const auto& e) { return e.parts == 1 && !e.writing; }).version, 1u);
}

TEST_P(LivingFolder, ACaseOfOpenFoamGrowsByTimesThatAllItsProcessorsHave) {
  const std::map<std::string, std::vector<std::string>> cases{{"alone", {"."}}, {"apart", {"processor0", "processor1"}}, {"collated", {"processors2"}}, {"ranks", {"processors2_0-0", "processors2_1-1"}}};
  for (const auto& [name, parts] : cases) {
    folder_.write(name + "/system/controlDict", "FoamFile {}");
    for (const std::string& part : parts) {
      folder_.write(name + "/" + part + "/constant/polyMesh/points", "");
      folder_.write(name + "/" + part + "/0/p", "");
    }
  }
  begin();
  EXPECT_EQ(newest()->entries().size(), cases.size());
  for (const auto& [name, parts] : cases) {
    const CatalogueEntry first = wait_for(name, [](const auto& e) { return !e.writing; });
    for (const std::string& part : parts) {
      EXPECT_EQ(named(*newest(), name)->news, first.news) << name << ", " << part;
      folder_.write(name + "/" + part + "/0.5/p", "");
    }
    const CatalogueEntry grown = wait_for(name, [](const auto& e) { return e.news == News::grown && !e.writing; });
    EXPECT_EQ(version_id(grown), version_id(first)) << name;
  }
}

TEST(FolderWatch, WhereTheWatchesAreUsedUpFoldersAreLookedAt) {
  testing::TemporaryFolder folder;
  folder.write("a/x.vtk", "x");
  folder.write("b/x.vtk", "x");
  FolderWatchOptions options;
  options.most_watches = 1;
  options.poll = milliseconds(50);
  FolderWatch watch(options);
  const fs::path a = fs::canonical(folder / "a"), b = fs::canonical(folder / "b");
  EXPECT_EQ(watch.watch({a, b}), (std::set<fs::path>{a, b}));
  EXPECT_NE(watch.how().find("1 folders are looked at"), std::string::npos) << watch.how();
  for (const fs::path& of : {a, b}) {
    std::ofstream(of / "new.vtk") << "x";
    std::set<fs::path> told;
    for (int i = 0; i < 200 && !told.contains(of); ++i) told.merge(watch.wait(milliseconds(100)).folders);
    EXPECT_TRUE(told.contains(of)) << of;
  }
}

}  // namespace
}  // namespace isostrata
