// The worker process from its first line to its last: an Engine whose requests come over a socket and whose events go back.
#pragma once

#include <sys/types.h>

#include <functional>
#include <memory>

#include "engine/picture/scene_ranks.h"
#include "rendering/picture/renderer.h"
#include "worker/confine.h"

namespace isostrata {

struct WorkerArguments {
  int socket = -1, board = -1;  // descriptors that WorkerProcess has handed over
  pid_t parent = 0;
  bool shut_in = false;  // it confines itself to `reach` first
  ReachablePlaces reach;
};

/// Serves until the other end of the socket is closed. renderer: empty, or what tests draw with. ranks: null, or those that extract and draw
/// with this process. Returns the exit status.
int run_worker(const WorkerArguments& arguments, std::function<std::unique_ptr<Renderer>()> renderer = {}, SceneRanks* ranks = nullptr);

}  // namespace isostrata
