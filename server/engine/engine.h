// The engine: scenes become frames. Plain messages in, plain messages out (messages.h); what happens in between is nobody else's
// business.
//
// Threads: one render thread owns the renderer and its context; a few job threads load, extract and count; encoder threads make
// bytes, each session always on the same one, so that its frames leave in the order they were drawn. Sessions take turns at the
// render thread.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "engine/catalogue.h"
#include "engine/dataset_store.h"
#include "engine/draw_scene.h"
#include "engine/messages.h"
#include "rendering/renderer.h"

namespace isostrata {

struct EngineOptions {
  Catalogue catalogue;
  RendererChoice renderer_choice;
  DatasetStoreOptions store;
  TetrahedraWay tetrahedra = TetrahedraWay::automatic;  // where the renderer cuts_intervals()
  /// Makes the renderer, called on the render thread; empty: make_renderer(renderer_choice). Tests bring their own.
  std::function<std::unique_ptr<Renderer>()> renderer;
  /// The renderer from then on, made on the render thread when the device has failed three frames in a row
  /// (ErrorCode::unavailable; after each the renderer has tried a new context). The frames' device says so. Empty: native.
  std::function<std::unique_ptr<Renderer>()> fallback_renderer;
};

/// Any thread may call any function but the destructor.
class Engine {
 public:
  /// Called from the engine's threads, one event at a time for one session's frames; must return quickly and not call the engine
  /// back.
  using Sink = std::function<void(EngineEvent event)>;

  /// Throws unavailable where no device can draw, saying what was tried.
  Engine(EngineOptions options, Sink sink);
  /// Cancels what runs and waits for it; no event comes afterwards.
  ~Engine();

  /// Requests of one session are taken in the order they are posted. Never waits for work.
  void post(EngineRequest request);

  const Catalogue& catalogue() const;
  const std::string& device() const;  // "llvmpipe (LLVM 15.0.6, 256 bits), EGL surfaceless"
  bool device_is_software() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

/// Whether a GL renderer's name is that of one that runs on the CPU.
bool is_software_device(const std::string& device);

/// Whether the extraction made for one scene serves the other: same dataset, the same layer_request and steps of a smear
/// (draw_scene.h).
bool same_extraction(const Scene& a, const Scene& b);

}  // namespace isostrata
