#include "worker/run_worker.h"

#include <csignal>
#include <cstdio>
#include <optional>

#include "base/parallel.h"
#include "data/open/loaded_importer.h"
#include "engine/engine/engine.h"
#include "worker/worker_process.h"

namespace isostrata {
namespace {

std::optional<WorkerSetup> receive_setup(MessageChannel& channel) {
  const auto bytes = channel.receive();
  if (!bytes) return std::nullopt;
  ToWorker message = to_worker(*bytes);
  if (auto* setup = std::get_if<WorkerSetup>(&message)) return std::move(*setup);
  throw Error(ErrorCode::bad_data, "the first message to a worker is not its setup");
}

EngineOptions options_of(WorkerSetup setup, ActivityBoard* board) {
  EngineOptions options;
  options.catalogue = Catalogue::from_entries(std::move(setup.catalogue));
  options.renderer_choice.renderer = setup.renderer;
  options.renderer_choice.device = setup.device;
  options.store.max_bytes = setup.max_bytes;
  options.store.importer = setup.importer;
  options.store.timeout_s = setup.import_timeout_s;
  options.store.keep = setup.keep;
  options.store.part = setup.part;
  options.board = board;
  return options;
}

// Where an event cannot be sent the server is gone, and this process about to follow; one that is too long gets an answer that is
// not.
void send(MessageChannel& channel, const EngineEvent& event) {
  try {
    channel.send(to_bytes(FromWorker{event}));
  } catch (const Error& error) {
    const auto* frame = std::get_if<FrameReady>(&event);
    if (error.code() == ErrorCode::too_large && frame)
      send(channel, RequestFailed{frame->session, frame->request, frame->revision, error.code(), error.what()});
  }
}

/// The others do what this process's setup says; what one of them cannot draw, none can.
void use_ranks_of(SceneRanks& ranks, int threads, EngineOptions& options) {
  ranks.configure({options.store, options.renderer_choice, threads, options.store.part});
  options.ranks = &ranks;
  options.renderer = options.fallback_renderer = [&ranks] { return ranks.make_renderer(); };
}

}  // namespace

int run_worker(const WorkerArguments& arguments, std::function<std::unique_ptr<Renderer>()> renderer, SceneRanks* ranks) {
  if (!become_worker(arguments.parent)) return 1;
  try {
    MessageChannel channel{Descriptor(arguments.socket)};
    const SharedBoard board{Descriptor(arguments.board)};
    std::string shut_in;
    try {
      if (arguments.shut_in) shut_in = confine_worker(arguments.reach);
    } catch (const Error& error) {
      channel.send(to_bytes(FromWorker{WorkerRefused{error.code(), error.what()}}));
      return 1;
    }
    std::optional<WorkerSetup> setup = receive_setup(channel);
    if (!setup) return 0;
    const int threads = setup->threads;
    if (threads > 0) set_thread_count(threads);
    EngineOptions options = options_of(std::move(*setup), board.get());
    options.renderer = std::move(renderer);
    if (ranks) {
      std::signal(SIGTERM, SIG_DFL);  // by which a launcher ends its ranks
      use_ranks_of(*ranks, threads, options);
    }
    load_importer();
    std::unique_ptr<Engine> engine;
    try {
      engine = std::make_unique<Engine>(std::move(options), [&channel](EngineEvent event) { send(channel, event); });
    } catch (const Error& error) {
      channel.send(to_bytes(FromWorker{WorkerRefused{error.code(), error.what()}}));
      return 1;
    }
    channel.send(to_bytes(FromWorker{WorkerReady{engine->device(), engine->facts().renderer_trial, shut_in}}));
    while (const auto bytes = channel.receive()) {
      ToWorker message = to_worker(*bytes);
      if (auto* request = std::get_if<EngineRequest>(&message)) engine->post(std::move(*request));
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isostrata worker: %s\n", error.what());
    return 1;
  }
}

}  // namespace isostrata
