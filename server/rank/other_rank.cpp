#include "rank/other_rank.h"

#include <algorithm>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <thread>
#include <utility>

#include "base/parallel.h"
#include "base/pulse.h"
#include "base/stopwatch.h"
#include "data/sandbox.h"
#include "rank/picture_of_ranks.h"
#include "rank/rank_work.h"

namespace isostrata {
namespace {

constexpr double kBeatEveryMs = 500;

/// One extraction, on a thread of its own, so that this rank goes on drawing what is extracted already.
struct Job {
  explicit Job(std::function<void(Job&)> work)
      : thread([this, work = std::move(work)] {
          const PulseScope beating(&beats);
          work(*this);
        }) {}
  ~Job() {
    task.cancel();
    thread.join();
  }
  Task task;
  Pulse beats{0};
  std::uint64_t told_beats = 0;  // of the thread that replies
  std::mutex mutex;  // guards what follows
  std::shared_ptr<const ExtractedScene> extracted;
  std::optional<RankReply> reply;  // to be sent
  std::thread thread;
};

void set_failure(RankReply& reply, const std::exception_ptr& failure) {
  reply.failed = true;
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    reply.code = error.code();
    reply.message = error.what();
  } catch (const std::bad_alloc&) {
    reply.code = ErrorCode::too_large;
    reply.message = "out of memory";
  } catch (const std::exception& error) {
    reply.message = error.what();
  }
}

class OtherRank {
 public:
  explicit OtherRank(RankLine& line) : line_(line), work_(line.rank()), compositor_(line.communicator()) {}

  void serve() {
    for (bool more = true; more;) {
      const RankOrder order = line_.receive([this] { send_replies(); });
      more = std::visit([this](const auto& of) { return obey(of); }, order);
    }
  }

 private:
  void send_replies() {
    for (auto& [number, job] : jobs_) {
      const std::lock_guard lock(job->mutex);
      if (job->reply) line_.reply(std::move(*job->reply));
      job->reply.reset();
    }
    if (since_beat_.elapsed_ms() < kBeatEveryMs) return;
    since_beat_ = Stopwatch();
    for (auto& [number, job] : jobs_)
      if (const std::uint64_t beats = job->beats.load(); std::exchange(job->told_beats, beats) != beats) {
        RankReply beat{number};
        beat.beat = true;
        line_.reply(std::move(beat));
      }
  }

  bool obey(const RankSetup& setup) {
    setup_ = setup;
    if (!setup.sandbox.empty()) use_sandbox(setup.sandbox);
    set_thread_count(setup.threads > 0 ? setup.threads : std::max(1, static_cast<int>(std::thread::hardware_concurrency()) / line_.ranks_on_node()));
    work_.configure(setup);
    renderer_.reset();
    return true;
  }

  bool obey(const RankExtract& order) {
    std::shared_ptr<const ExtractedScene> previous;
    if (const auto it = jobs_.find(order.previous); it != jobs_.end()) {
      const std::lock_guard lock(it->second->mutex);
      previous = it->second->extracted;
    }
    regions_[order.number] = order.regions;
    jobs_[order.number] = std::make_unique<Job>([this, order, previous](Job& job) {
      RankReply reply{order.number};
      std::shared_ptr<const ExtractedScene> extracted;
      try {
        SceneAids aids;
        aids.max_bytes = order.max_bytes;
        extracted = work_.extract(order, work_.open(order.source), previous, job.task, aids, reply.made);
      } catch (...) {
        set_failure(reply, std::current_exception());
      }
      const std::lock_guard lock(job.mutex);
      job.extracted = std::move(extracted);
      job.reply = std::move(reply);
    });
    return true;
  }

  bool obey(const RankWrite& order) {
    jobs_[order.number] = std::make_unique<Job>([this, order](Job& job) {
      RankReply reply{order.number};
      try {
        reply.made = work_.write(order, work_.open(order.source), job.task);
      } catch (...) {
        set_failure(reply, std::current_exception());
      }
      const std::lock_guard lock(job.mutex);
      job.reply = std::move(reply);
    });
    return true;
  }

  bool obey(const RankDraw& order) {
    try {
      std::shared_ptr<const ExtractedScene> extracted;
      if (const auto it = jobs_.find(order.number); it != jobs_.end()) {
        const std::lock_guard lock(it->second->mutex);
        extracted = it->second->extracted;
      }
      draw(order, extracted.get());
    } catch (...) {
      RankReply reply{order.picture};
      set_failure(reply, std::current_exception());
      line_.reply(std::move(reply));
    }
    return true;
  }

  /// A rank that cannot even begin says so where the others agree, or they would wait for it.
  void draw(const RankDraw& order, const ExtractedScene* extracted) {
    DrawInput input;
    try {
      if (!extracted) throw Error(ErrorCode::internal, "extraction " + std::to_string(order.number) + " is to be drawn and is not there");
      if (!renderer_) renderer_ = make_renderer({setup_.renderer, setup_.device});
      input = input_of(order, *extracted);
    } catch (...) {
      line_.agree(0);
      throw;
    }
    draw_by_ranks(line_, compositor_, *renderer_, input, regions_.at(order.number));
  }

  static DrawInput input_of(const RankDraw& order, const ExtractedScene& extracted) {
    DrawInput input;
    input.grid = extracted.same_grid ? &extracted.dataset->grid : nullptr;
    input.bounds = order.bounds;
    input.mesh = extracted.mesh;
    input.color_values = extracted.color_values;
    if (order.with_normals) input.normals = extracted.normals;
    input.texture_values = extracted.texture_values;
    input.styles = order.styles;
    input.mode = order.mode;
    input.integral = order.integral;
    input.clip_planes = order.clip_planes;
    input.camera = order.camera;
    input.width = order.width;
    input.height = order.height;
    input.window = order.window;
    input.unit_distance = order.unit_distance;
    input.float_image = order.with_depth;
    return input;
  }

  bool obey(const RankCancel& order) {
    if (const auto it = jobs_.find(order.number); it != jobs_.end()) it->second->task.cancel();
    return true;
  }

  bool obey(const RankForget& order) {
    for (const std::uint64_t number : order.numbers) jobs_.erase(number), regions_.erase(number);
    return true;
  }

  bool obey(const RankEnd&) { return false; }

  RankLine& line_;
  RankWork work_;
  Compositor compositor_;
  RankSetup setup_;
  Stopwatch since_beat_;
  std::unique_ptr<Renderer> renderer_;
  std::map<std::uint64_t, RegionTree> regions_;
  std::map<std::uint64_t, std::unique_ptr<Job>> jobs_;  // last: their threads use the rest
};

}  // namespace

void serve_orders(RankLine& line) { OtherRank(line).serve(); }

}  // namespace isostrata
