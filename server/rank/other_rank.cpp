#include "rank/other_rank.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "base/as_error.h"
#include "base/parallel.h"
#include "base/pulse.h"
#include "base/stopwatch.h"
#include "data/derived/scaled_dataset.h"
#include "data/open/sandbox.h"
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

RankReply failed(std::uint64_t number, const std::exception_ptr& failure) {
  const Error error = as_error(failure);
  RankReply reply{number};
  reply.failed = true;
  reply.code = error.code();
  reply.message = error.what();
  return reply;
}

class OtherRank {
 public:
  explicit OtherRank(RankLine& line) : line_(line), work_(line.rank(), line.count()), compositor_(line.communicator()) {}

  void serve() {
    for (bool more = true; more;) {
      const RankOrder order = line_.receive([this] { send_replies(); });
      more = std::visit([this](const auto& of) { return obey(of); }, order);
    }
  }

 private:
  void send_replies() {
    if (std::strcmp(ranks_control(), "silent") == 0) return;
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
    if (std::strcmp(ranks_control(), "no-setup") == 0) throw Error(ErrorCode::internal, "no setup, as was asked for");
    setup_ = setup;
    if (!setup.sandbox.empty()) use_sandbox(setup.sandbox);
    set_thread_count(line_.threads(setup.threads));
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
    regions_[order.number] = scaled_regions(order.regions, order.scene.axis_scale);  // which part the drawn space
    const bool draws_bricks = order.least_in_bricks != std::numeric_limits<std::int64_t>::max() && has_renderer() && renderer_->draws_bricks();
    begin(order.number, [this, order, previous, draws_bricks](Job& job, RankReply& reply) {
      auto extracted = work_.extract(order, work_.open(order.source), previous, draws_bricks, job.task, reply.made);
      const std::lock_guard lock(job.mutex);
      job.extracted = std::move(extracted);
    });
    return true;
  }

  bool obey(const RankWrite& order) {
    begin(order.number, [this, order](Job& job, RankReply& reply) { reply.made = work_.write(order, work_.open(order.source), job.task); });
    return true;
  }

  bool obey(const RankMeasure& order) {
    begin(order.number, [this, order](Job& job, RankReply& reply) { reply.measured = work_.measure(order, work_.open(order.source), job.task); });
    return true;
  }

  /// Why there is none is thrown if it is to draw.
  bool has_renderer() {
    try {
      if (!renderer_) renderer_ = make_renderer({setup_.renderer, setup_.device});
    } catch (const Error&) {
    }
    return renderer_ != nullptr;
  }

  /// The reply goes out once the work is done, or has failed.
  void begin(std::uint64_t number, std::function<void(Job&, RankReply&)> work) {
    jobs_[number] = std::make_unique<Job>([number, work = std::move(work)](Job& job) {
      RankReply reply{number};
      try {
        work(job, reply);
      } catch (...) {
        reply = failed(number, std::current_exception());
      }
      const std::lock_guard lock(job.mutex);
      job.reply = std::move(reply);
    });
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
      line_.reply(failed(order.picture, std::current_exception()));
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
    input.bricks = extracted.bricks;
    if (order.with_normals) input.normals = extracted.normals;
    if (order.body_shading > 0) input.body_normals = extracted.body_normals;
    input.body_shading = order.body_shading;
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
    input.float_image = order.with_depth || order.with_mean_depth;
    input.rounded = !order.with_depth;
    input.mean_depth = order.with_mean_depth;
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
