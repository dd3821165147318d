// What passes between the server and a worker process, beside what passes between viewers and an engine.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "engine/data/catalogue.h"
#include "engine/messages/messages.h"

namespace isostrata {

/// The first message to a worker: all that its engine is made from.
struct WorkerSetup {
  std::vector<CatalogueEntry> catalogue;
  std::string renderer, device;  // RendererChoice
  std::uint64_t max_bytes = 0;   // DatasetStoreOptions
  std::string importer;
  double import_timeout_s = 0;
  std::string keep;
  int threads = 0;  // set_thread_count
  Region part;      // DatasetStoreOptions
};

/// The first from a worker: its engine can draw,
struct WorkerReady {
  std::string device;
  std::string renderer_trial;
  std::string shut_in;  // as confine_worker
};
/// or it cannot, and the worker ends.
struct WorkerRefused {
  ErrorCode code = ErrorCode::internal;
  std::string message;
};

using ToWorker = std::variant<WorkerSetup, EngineRequest>;
using FromWorker = std::variant<WorkerReady, WorkerRefused, EngineEvent>;

}  // namespace isostrata
