// Whether the process that draws for `isostrata serve` can be started here, and replaced when it dies: proven by doing so.
#pragma once

#include <string>

#include "rendering/picture/renderer.h"

namespace isostrata {

struct WorkerProbe {
  bool ok = false;        // it started and drew; it was killed, and its successor drew
  std::string device;     // on what
  std::string detail;     // what was done, or what failed
  std::string shut_in;    // what kept it to its own files, as confine_worker
  double start_ms = 0;    // until the first was ready
  double frame_ms = 0;    // its first frame of 64x48 pixels, with the loading and the extraction of a small field
  double replace_ms = 0;  // from its death to the next frame
};

/// Takes about as long as the device takes to start, twice.
WorkerProbe probe_worker(const RendererChoice& choice);

}  // namespace isostrata
