// The sessions of an engine: each with its newest scene and its pictures (latest_extraction.h, draw_queue.h), all within one memory (scene_memory.h).
// Here it is decided what happens next; the threads of others do it.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/engine/draw_queue.h"
#include "engine/engine/latest_extraction.h"
#include "engine/engine/render_thread.h"
#include "engine/engine/renderer_traits.h"
#include "engine/engine/scene_extractor.h"
#include "engine/engine/scene_memory.h"
#include "engine/engine/turns.h"
#include "engine/messages/frame_engine.h"
#include "engine/messages/running_operations.h"

namespace isostrata {

/// Any thread may call any function. Lock: mutex_, never while anything is read, extracted, drawn or encoded. What is made out of a session's reach comes
/// too late, and is dropped.
class LiveSessions {
 public:
  using Extracted = std::shared_ptr<const ExtractedScene>;

  /// Whom a decision is told. All but `send` are called with the lock held: they must not wait, nor call back.
  struct Ports {
    FrameEngine::Sink send;
    std::function<void(ExtractionJob job)> extract;
    std::function<void(SessionKey session, PictureKind kind)> draw_in_lane;  // as DrawLanes::post
    std::function<void(SessionKey session)> drop_renderers;                  // nobody looks at it, and its memory is wanted
    std::function<void(const FrameRequest& request)> accepted;               // before it can be drawn
    std::function<void(SessionKey, const Extracted&, const Scene&)> prepare_motion;  // as WorkAhead's
  };

  /// memory: of which scenes have what is left. by_ranks: nobody has all points, so there are never fewer.
  LiveSessions(SceneMemory memory, bool by_ranks, RunningOperations& operations, Ports ports);

  // ---- what viewers ask for ----

  void take(SceneUpdate update);
  /// What cannot be drawn is answered at once.
  void take(const FrameRequest& request);
  void forget(const ForgetFrame& of);
  /// Until a picture is asked for, nothing is extracted for the session, and it holds nothing. If somebody waits for a picture, nothing happens.
  void rest(SessionKey session);
  struct Closed {
    bool was_there = false, was_last = false;
  };
  Closed close(SessionKey session);
  /// These datasets have changed: what could not be read of them while they were being written is tried again.
  void try_again(const std::set<std::string>& datasets);
  /// What is ready for a scene of the same extraction, all points of the grid; else null.
  Extracted ready_for(SessionKey session, const Scene& scene);
  /// Nothing begins any more, and all pictures are cancelled.
  void stop();

  // ---- what has been extracted ----

  /// As SceneExtractor::Ports.
  void take_first_look(const ExtractionJob& of, Extracted coarse);
  void take_extracted(const ExtractionJob& of, Extracted extracted, const std::exception_ptr& why_not);
  /// As WorkAhead::Ports.
  bool wants_coarse(SessionKey session, const Extracted& of, std::uint64_t bytes);
  void take_coarse(SessionKey session, const Extracted& of, Extracted coarse, const Scene& scene);

  // ---- memory ----

  /// What the session's next scene may take, until take_extracted. Others make room, or go altogether: then this waits a while for who is at work.
  std::uint64_t room_for_scene(SessionKey session, bool altogether);
  /// Begins a work of the session if at least as many bytes are free as it takes, after others have made room. Returns how many.
  std::uint64_t begin_work(SessionKey session, std::uint64_t bytes);
  /// The same of what is free as it is. Whether it begins.
  bool begin_work_in_free(std::uint64_t bytes);
  /// Who waits for room looks again.
  void end_work(std::uint64_t bytes);
  std::uint64_t quarter_of_free();
  /// What an export may take: as much as the session's own scene of the same layers does, if that is known, else a quarter of what is free.
  std::uint64_t room_for_export(const ExportRequest& request);

  // ---- drawing ----

  /// The renderer from now on. What was made for one that draws more than this one is made anew. in_lanes: it needs no device.
  void draw_by(const RendererTraits& renderer, bool in_lanes);
  /// As RenderThread::Ports. Sessions take turns.
  RenderThread::Ports::Turn wait_for_turn(std::chrono::milliseconds longest, std::optional<PictureOrder>& order);
  /// The same. Frames alone, and of the session itself only beside a still of its own: a frame comes after those before it.
  std::optional<PictureOrder> next_between(const FrameRequest& of);
  /// As DrawLanes::Ports. A large still comes with its room, or waits for others that work, or is refused when it is drawn.
  std::optional<PictureOrder> next_in_lane(SessionKey session, PictureKind kind);
  void free_lane(SessionKey session, PictureKind kind);
  /// As FrameMaker::Ports.
  bool if_there(SessionKey session, const std::function<void()>& then);
  bool overtaken(SessionKey session, std::uint64_t revision);
  void ended(SessionKey session, RequestId request);
  void seen(SessionKey session, bool rests);

 private:
  struct Session {
    LatestExtraction latest;
    DrawQueue pictures;
    std::uint64_t room = 0;  // that its last scene was given
    bool rests = false;
  };
  // With mutex_ held:
  Session* find(SessionKey key);
  Session* session_of(const ExtractionJob& job);
  void advance(SessionKey key, Session& session);
  void draw_soon(SessionKey key, Session& session);
  std::optional<PictureOrder> next_still(SessionKey key, Session& session, std::vector<Extracted>& given_back);
  SceneMemory::MayGo may_go();
  std::vector<Extracted> let_rest(SessionKey key, Session& session);
  std::vector<Extracted> take_back(const std::vector<SessionKey>& gone);

  const bool by_ranks_;
  RunningOperations& operations_;
  const Ports ports_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  bool stopping_ = false;
  bool in_lanes_ = false;
  std::map<SessionKey, Session> sessions_;
  SceneMemory memory_;
  Turns turns_;
};

}  // namespace isostrata
