// The engine: scenes become frames. Plain messages in, plain messages out (messages.h); what happens in between is nobody else's
// business.
//
// Threads: each session has lanes of its own (lanes.h) in which its files are opened, its scene is extracted, its frames and stills
// are drawn and encoded, so that whatever one session asks for, the others' threads are free. Whose loops run is decided block by
// block (base/work.h): frames before stills before exports, sessions by the time that they had. A device has one thread, the render
// thread, at which sessions take turns between pictures.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/data/dataset_store.h"
#include "engine/messages/activity.h"
#include "engine/messages/frame_engine.h"
#include "engine/picture/scene_ranks.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

struct EngineOptions {
  Catalogue catalogue;
  RendererChoice renderer_choice;
  DatasetStoreOptions store;
  /// Makes the renderer, called on the render thread, and on lanes' threads where it needs_no_device (native_renderer.h); empty:
  /// make_renderer(renderer_choice). Tests bring their own.
  std::function<std::unique_ptr<Renderer>()> renderer;
  /// The renderer from then on, made on the render thread when the device has failed three frames in a row
  /// (ErrorCode::unavailable; after each the renderer has tried a new context). The frames' device says so. Empty: native.
  std::function<std::unique_ptr<Renderer>()> fallback_renderer;
  /// Where the engine's threads say what they do; must outlive the engine. Null: nowhere.
  ActivityBoard* board = nullptr;
  /// Who extracts, and whose renderer `renderer` makes; must outlive the engine. Null: this process alone. What is counted of whole arrays, the
  /// first view and exported meshes are made by this process in any case.
  SceneRanks* ranks = nullptr;
  /// Of a structured grid with more cells the first picture is of every n-th point (FrameReady::point_stride), for those of all points take seconds.
  std::int64_t least_coarse_cells = std::int64_t{1} << 26;
  /// And scenes of more tetrahedra are made of every n-th point as well, for moving frames that ask for it (FrameRequest::coarse).
  std::int64_t least_coarse_tetrahedra = 1'500'000;
};

class Engine final : public FrameEngine {
 public:
  /// Throws unavailable if no device can draw, saying what was tried.
  Engine(EngineOptions options, Sink sink);
  /// Cancels what runs and waits for it; no event comes afterwards.
  ~Engine() override;

  void post(EngineRequest request) override;
  const Catalogue& catalogue() const override;
  std::string device() const override;
  EngineFacts facts() const override;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata
