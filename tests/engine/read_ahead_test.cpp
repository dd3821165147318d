// Who plays a series finds the next step read.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "data/open/import_cache.h"
#include "engine/engine/engine.h"
#include "engine/heard_events.h"
#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

std::string nrrd(int step) {
  std::string file = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 12 12 12\nencoding: raw\n\n";
  for (int p = 0; p < 12 * 12 * 12; ++p) file += static_cast<char>((p + 20 * step) % 200);
  return file;
}

/// Steps that were imported are counted by their entries in a cache of the test's own.
class ReadAhead : public HeardEvents, public ::testing::Test {
 protected:
  ReadAhead() : before_(import_cache()) {
    ImportCache cache;
    cache.folder = folder_ / "cache";
    cache.least_seconds = 0;
    set_import_cache(cache);
    for (int step = 0; step < 6; ++step) folder_.write("steps/a_" + std::to_string(step) + ".nrrd", nrrd(step));
    EngineOptions options;
    options.catalogue = Catalogue::from_sources({(folder_ / "steps/a_*.nrrd").string()});
    options.renderer_choice = {"native", "auto"};
    dataset_ = options.catalogue.entries().front().id;
    engine_ = std::make_unique<Engine>(std::move(options), [this](EngineEvent event) { note(std::move(event)); });
  }
  ~ReadAhead() override {
    engine_.reset();
    set_import_cache(before_);
  }
  void show(int step) {
    Scene of = scene(++revision_, 120, dataset_);
    of.array = "scalars";
    of.intervals[0].lower = 40;
    of.step = step;
    engine_->post(SceneUpdate{1, of});
    engine_->post(frame(1, revision_, true));
    EXPECT_EQ(frame_of(revision_).step, step);
  }
  int imported() const { return use_of(*import_cache()).entries; }
  bool comes_to(int entries) const {
    for (int i = 0; i < 1000 && imported() < entries; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return imported() == entries;
  }

  testing::TemporaryFolder folder_;
  std::optional<ImportCache> before_;
  std::string dataset_;
  std::uint64_t revision_ = 0;
  std::unique_ptr<Engine> engine_;
};

TEST_F(ReadAhead, TheStepAfterTheNextIsReadInTheDirectionOfPlay) {
  show(2);
  EXPECT_EQ(imported(), 1) << "nobody plays yet";
  show(3);
  EXPECT_TRUE(comes_to(3)) << "2, 3, and 4 ahead: " << imported();
  show(4);
  EXPECT_TRUE(comes_to(4)) << "5 ahead: " << imported();
  show(3);
  show(2);
  EXPECT_TRUE(comes_to(5)) << "back: 1 ahead: " << imported();
}

TEST_F(ReadAhead, AJumpIsNoPlay) {
  show(0);
  show(3);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  EXPECT_EQ(imported(), 2);
}

}  // namespace
}  // namespace isostrata
