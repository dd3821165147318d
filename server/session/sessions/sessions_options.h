// What a server says of all its sessions.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/unix_time.h"
#include "encoding/encoder.h"
#include "engine/messages/frame_engine.h"
#include "session/pacing/frame_scheduler.h"
#include "session/pacing/viewer_budget.h"

namespace isostrata {

struct SessionsOptions {
  std::size_t max_sessions = 32;
  std::size_t max_viewers = 64;  // of one session
  std::int64_t max_viewer_pixels = kMaxViewerPixels;  // of a picture of who may only look
  Duration session_ttl = std::chrono::minutes(10);  // a session that nobody uses is kept that long
  Duration stall_time = FrameScheduler::kStall;     // without an acknowledgement: nothing more is drawn for that viewer
  std::string server_name = "isostrata";            // with its version, for Welcome
  std::string device;
  bool device_is_software = false;
  std::function<EngineFacts()> engine;  // whose process draws, asked again each time; empty: device is all that is known
  std::shared_ptr<const Catalogue> catalogue = std::make_shared<Catalogue>();
  bool follows_files = false;           // the catalogue will be replaced by newer ones, and the engine is told of entries when they are asked for
  std::string watching;                 // DatasetList.watching
  std::filesystem::path journal;                       // the directory where sessions survive the process; empty: they do not
  std::function<void(const std::string& what)> warn;  // of the journal's trouble; any thread
  UnixMs ends = 0;                                     // when the server is known to end, by the system's clock; 0: not known
  std::vector<Codec> moving_codecs =
      isostrata::moving_codecs();  // that frames in motion may be sent in, the best first, JPEG last

  EngineFacts drawing() const {
    if (engine) return engine();
    EngineFacts facts;
    facts.device = device;
    facts.device_is_software = device_is_software;
    return facts;
  }
};

}  // namespace isostrata
