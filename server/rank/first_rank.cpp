#include "rank/first_rank.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <type_traits>

#include "base/parallel.h"
#include "base/pulse.h"
#include "base/stopwatch.h"
#include "data/open/sandbox.h"
#include "data/parts/region.h"
#include "extraction/files/write_vtu.h"
#include "rank/picture_of_ranks.h"
#include "rank/rank_work.h"
#include "rendering/picture/check_draw_input.h"
#include "rendering/picture/lit_surfaces.h"
#include "rendering/tiles/resolve_simd.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;

/// A mesh and what is drawn of it, by which a picture's input is known again: no two extractions have all three.
using MeshKey = std::tuple<const void*, const void*, const void*>;

template <class Of>
MeshKey key_of(const Of& of) {
  return {of.mesh.get(), of.color_values.get(), of.texture_values.get()};
}

/// The nearest point of a place may be another rank's.
void check_values(FieldValues values) {
  if (values == FieldValues::whole) throw Error(ErrorCode::unsupported, "ranks take no whole values; expected interpolated values, or one process");
}

class FirstRank final : public SceneRanks {
 public:
  explicit FirstRank(RankLine& line) : line_(line), work_(line.rank(), line.count()), compositor_(line.communicator()) {}
  ~FirstRank() override {
    const std::lock_guard lock(line_.mutex());
    line_.send(RankEnd{});
  }

  int count() const override { return line_.count(); }

  void configure(const RankSettings& settings) override {
    RankSetup setup;
    setup.importer = settings.store.importer.string();
    setup.sandbox = to_string(sandbox());
    setup.max_bytes = settings.store.max_bytes;
    setup.import_timeout_s = settings.store.timeout_s;
    setup.renderer = settings.renderer.renderer;
    setup.device = settings.renderer.device;
    setup.threads = settings.threads;
    setup.region = settings.region;
    choice_ = settings.renderer;
    set_thread_count(line_.threads(settings.threads));
    work_.configure(setup);
    const std::lock_guard lock(line_.mutex());
    line_.send(setup);
  }

  std::shared_ptr<const Dataset> open(const RankedSource& of, int step, const Task& task) override {
    const auto whole = work_.open(of.source)(step, task);
    if (whole->whole || std::none_of(whole->arrays.begin(), whole->arrays.end(), is_unread)) return whole;
    auto measured = std::make_shared<Dataset>(*whole);
    if (whole->grid.flat() || whole->grid.cell_count() == 0) {  // which is not shared out
      for (PointArray& array : measured->arrays) measure_range(array);
      return measured;
    }
    const RankMeasured made = measure(of, whole, {}, task);
    for (std::size_t i = 0; i < measured->arrays.size(); ++i) {
      measured->arrays[i].lower = made.ranges.at(i).lower;
      measured->arrays[i].upper = made.ranges.at(i).upper;
      measured->arrays[i].nan_count = made.ranges.at(i).nan_count;
    }
    work_.know_ranges(of.version, *measured);
    return measured;
  }

  std::vector<std::uint64_t> histogram(const RankedSource& of, const std::shared_ptr<const Dataset>& whole, const std::string& array, double lower,
                                       double upper, int bins, const Task& task) override {
    RankMeasure order;
    order.array = array;
    order.lower = lower;
    order.upper = upper;
    order.bins = bins;
    return measure(of, whole, order, task).counts;
  }

  Statistics statistics(const RankedSource& of, const std::shared_ptr<const Dataset>& whole, const std::string& array, const Task& task) override {
    RankMeasure order;
    order.array = array;
    order.lower = whole->array(array).lower;
    order.upper = whole->array(array).upper;
    return statistics_of(measure(of, whole, order, task).moments, order.lower, order.upper);
  }

  std::shared_ptr<const ExtractedScene> extract(const RankedSource& of, const StepSource& whole, const Scene& scene,
                                                const std::shared_ptr<const ExtractedScene>& previous, const Task& task,
                                                const SceneAids& aids) override {
    check_values(scene.values);
    RankExtract order;
    order.source = of.source;
    order.version = of.version;
    order.scene = scene;
    order.max_bytes = aids.max_bytes;
    const std::vector<SmearMoment> moments = smear_moments(scene);
    order.regions = regions_of(of, whole, moments.empty() ? scene.step : moments.front().step, task);
    if (previous) order.previous = number_of(key_of(*previous));
    // A limit in bytes is of each rank; one on the size of all is shared out.
    const bool draws_bricks = aids.least_in_bricks != std::numeric_limits<std::int64_t>::max();
    order.least_in_bricks = draws_bricks ? aids.least_in_bricks / line_.count() : aids.least_in_bricks;
    RankedExtraction made;
    std::shared_ptr<const ExtractedScene> own;
    by_all(order, task, made, [&] {
      RankedExtraction part;
      own = work_.extract(order, whole, previous, draws_bricks, task, part);
      return part;
    });
    auto extracted = std::make_shared<ExtractedScene>(*own);
    extracted->whole_summaries = std::move(made.summaries);
    const std::lock_guard lock(line_.mutex());
    forget_the_gone();
    drawable_[order.number] = {extracted, key_of(*extracted), scaled_regions(order.regions, scene.axis_scale)};
    return extracted;
  }

  RankedExtraction write_pieces(const RankedSource& of, const StepSource& whole, const LayerRequest& request, const std::string& path,
                                const WriteOptions& options, const Task& task) override {
    check_values(request.values);
    RankWrite order;
    order.source = of.source;
    order.version = of.version;
    order.request = request;
    order.path = path.empty() ? "" : fs::absolute(path).string();
    order.compression = options.compression;
    order.regions = regions_of(of, whole, request.step, task);
    RankedExtraction made;
    try {
      by_all(order, task, made, [&] { return work_.write(order, whole, task); });
      if (!path.empty()) write_index(order);
    } catch (...) {
      if (!path.empty()) {
        std::error_code ignored;
        for (int rank = 0; rank < line_.count(); ++rank) fs::remove(piece_path(order.path, rank), ignored);
      }
      throw;
    }
    return made;
  }

  std::unique_ptr<Renderer> make_renderer() override;

  DrawResult draw(Renderer& own, const DrawInput& input) {
    check(input);
    const Stopwatch watch;
    const std::lock_guard lock(line_.mutex());
    const auto found = std::find_if(drawable_.begin(), drawable_.end(), [&](const auto& of) {
      const auto held = of.second.extracted.lock();
      // Of one mesh there may be an extraction from before its bodies were shaded.
      return held && of.second.key == key_of(input) && (!(input.body_shading > 0) || held->body_normals == input.body_normals);
    });
    if (found == drawable_.end()) throw Error(ErrorCode::internal, "a picture of what the ranks have not extracted");
    const auto extracted = found->second.extracted.lock();
    RankDraw order;
    order.number = found->first;
    order.picture = ++numbers_;
    order.bounds = input.bounds;
    order.styles = input.styles;
    order.mode = input.mode;
    order.integral = input.integral;
    order.clip_planes = input.clip_planes;
    order.with_normals = lit_along_gradient(input);  // of a rank that draws from bricks none are there before it draws
    order.body_shading = input.body_shading;
    order.camera = input.camera;
    order.width = input.width;
    order.height = input.height;
    order.window = input.window;
    order.unit_distance = input.unit_distance;
    order.with_depth = input.float_image && !input.rounded;
    order.with_mean_depth = input.float_image && input.mean_depth;
    line_.send(order);
    RankedPicture picture = [&] {
      try {
        return draw_by_ranks(line_, compositor_, own, input, found->second.regions);
      } catch (const Error& error) {
        if (error.code() == ErrorCode::cancelled) wait_for_failure(order.picture);
        throw;
      }
    }();
    DrawResult result;
    result.facts = std::move(picture.facts);
    result.facts.device += ", " + std::to_string(line_.count()) + (line_.count() == 1 ? " rank" : " ranks");
    result.facts.tetrahedra = 0;
    for (std::size_t i = 0; i < input.styles.size() && extracted && i < extracted->summaries().size(); ++i)
      if (input.styles[i].visible) result.facts.tetrahedra += extracted->summaries()[i].tetrahedra;
    if (input.float_image) {
      FloatImage floats = *picture.image;
      floats.depth = std::move(picture.depth);
      floats.mean_depth = std::move(picture.mean_depth);
      result.image = std::move(floats);
    } else {
      result.image = resolved(*picture.image, input.background, input.transparent);
    }
    result.facts.draw_ms = watch.elapsed_ms() - result.facts.order_ms - result.facts.readback_ms;  // of the picture: the others' part and compositing, too
    return result;
  }

 private:
  struct Drawable {
    std::weak_ptr<const ExtractedScene> extracted;
    MeshKey key;
    RegionTree regions;
  };

  RankMeasured measure(const RankedSource& of, const std::shared_ptr<const Dataset>& whole, RankMeasure order, const Task& task) {
    const StepSource steps = [&](int, const Task&) { return whole; };
    order.source = of.source;
    order.version = of.version;
    order.step = whole->step;
    order.regions = regions_of(of, steps, whole->step, task);
    RankMeasured made;
    by_all(order, task, made, [&] { return work_.measure(order, steps, task); });
    return made;
  }

  /// Those of a dataset stay as the first step that was looked at has made them: any regions are right for any step.
  RegionTree regions_of(const RankedSource& of, const StepSource& whole, int step, const Task& task) {
    {
      const std::lock_guard lock(line_.mutex());
      if (const auto it = regions_.find(of.version); it != regions_.end()) return it->second;
    }
    const auto dataset = whole(step, task);
    RegionTree made = dataset->whole ? dataset->whole->regions : make_regions(dataset->grid, line_.count());
    const std::lock_guard lock(line_.mutex());
    return regions_[of.version] = std::move(made);
  }

  std::uint64_t number_of(const MeshKey& key) {
    const std::lock_guard lock(line_.mutex());
    for (const auto& [number, of] : drawable_)
      if (of.key == key && !of.extracted.expired()) return number;
    return 0;
  }

  /// With the line's mutex.
  void forget_the_gone() {
    RankForget forget;
    std::erase_if(drawable_, [&](const auto& of) {
      if (of.second.extracted.expired()) forget.numbers.push_back(of.first);
      return of.second.extracted.expired();
    });
    if (!forget.numbers.empty()) line_.send(forget);
  }

  /// Has all ranks do it, this one by own(), and adds up what they made. The first failure, by rank, is thrown once all are done.
  template <class Order, class Sum, class Own>
  void by_all(Order& order, const Task& task, Sum& sum, const Own& own) {
    {
      const std::lock_guard lock(line_.mutex());
      order.number = ++numbers_;
      line_.send(order);
    }
    std::exception_ptr failure;
    Sum part;
    try {
      part = own();
    } catch (...) {
      failure = std::current_exception();
    }
    const std::vector<RankReply> replies = wait_for_all(order.number, failure != nullptr, task);
    const auto failed = first_failure(replies);
    if (failure || failed != replies.end()) {
      const std::lock_guard lock(line_.mutex());
      line_.send(RankForget{{order.number}});
    }
    if (failure) std::rethrow_exception(failure);
    task.check();
    if (failed != replies.end()) throw Error(failed->code, failed->message);
    add(sum, part);
    for (const RankReply& of : replies)
      if constexpr (std::is_same_v<Sum, RankMeasured>)
        add(sum, of.measured);
      else
        add(sum, of.made);
  }

  /// Once one has failed the others are cancelled, which is not the reason.
  static std::vector<RankReply>::const_iterator first_failure(const std::vector<RankReply>& replies) {
    const auto reason = std::find_if(replies.begin(), replies.end(), [](const RankReply& of) { return of.failed && of.code != ErrorCode::cancelled; });
    return reason != replies.end() ? reason : std::find_if(replies.begin(), replies.end(), [](const RankReply& of) { return of.failed; });
  }

  /// In the order of the ranks.
  std::vector<RankReply> wait_for_all(std::uint64_t number, bool cancel, const Task& task) {
    bool told = false;
    GrowingSleep pause;
    for (;;) {
      {
        const std::lock_guard lock(line_.mutex());
        if ((cancel || task.cancelled()) && !told) {
          line_.send(RankCancel{number});
          told = true;
        }
        collect();
        std::vector<RankReply>& of = replies_[number];
        if (static_cast<int>(of.size()) == line_.count() - 1) {
          std::vector<RankReply> all = std::move(of);
          replies_.erase(number);
          signs_.erase(number);
          std::sort(all.begin(), all.end(), [](const RankReply& a, const RankReply& b) { return a.rank < b.rank; });
          return all;
        }
        if (std::any_of(of.begin(), of.end(), [](const RankReply& r) { return r.failed; })) cancel = true;
        beat_with(number, of);
      }
      pause.sleep();
    }
  }

  /// Moves this thread's pulse once every rank that is still at it has given a sign of life: whoever watches sees the slowest. With the line's mutex.
  void beat_with(std::uint64_t number, const std::vector<RankReply>& done) {
    std::set<int>& signs = signs_[number];
    if (signs.size() + done.size() < static_cast<std::size_t>(line_.count() - 1)) return;
    signs.clear();
    pulse();
  }

  /// Throws what the rank says that could not draw. With the line's mutex.
  [[noreturn]] void wait_for_failure(std::uint64_t picture) {
    GrowingSleep pause;
    for (;;) {
      collect();
      const auto it = replies_.find(picture);
      // Ranks that could draw say only that another one could not.
      if (it != replies_.end())
        for (const RankReply& of : it->second)
          if (of.code != ErrorCode::cancelled) {
            const Error error(of.code, of.message);
            replies_.erase(it);
            throw error;
          }
      pause.sleep();
    }
  }

  /// With the line's mutex.
  void collect() {
    for (RankReply& reply : line_.collect()) {
      if (reply.beat) {
        if (const auto it = signs_.find(reply.number); it != signs_.end()) it->second.insert(reply.rank);
        continue;
      }
      if (const auto it = signs_.find(reply.number); it != signs_.end()) it->second.erase(reply.rank);
      replies_[reply.number].push_back(std::move(reply));
    }
  }

  void write_index(const RankWrite& order) const;

  RankLine& line_;
  RankWork work_;
  Compositor compositor_;
  RendererChoice choice_;
  // Guarded by the line's mutex:
  std::uint64_t numbers_ = 0;
  std::map<std::string, RegionTree> regions_;  // by version
  std::map<std::uint64_t, Drawable> drawable_;
  std::map<std::uint64_t, std::vector<RankReply>> replies_;  // that nobody has taken yet
  std::map<std::uint64_t, std::set<int>> signs_;             // of ranks that work on what this one waits for
};

class RanksRenderer final : public Renderer {
 public:
  RanksRenderer(FirstRank& ranks, std::unique_ptr<Renderer> own)
      : ranks_(ranks), own_(std::move(own)), device_(own_->device() + ", " + std::to_string(ranks.count()) + (ranks.count() == 1 ? " rank" : " ranks")) {}
  DrawResult draw(const DrawInput& input) override { return ranks_.draw(*own_, input); }
  const std::string& device() const override { return device_; }
  bool draws_bricks() const override { return own_->draws_bricks(); }

 private:
  FirstRank& ranks_;
  const std::unique_ptr<Renderer> own_;
  const std::string device_;
};

std::unique_ptr<Renderer> FirstRank::make_renderer() { return std::make_unique<RanksRenderer>(*this, isostrata::make_renderer(choice_)); }

void FirstRank::write_index(const RankWrite& order) const {
  std::vector<std::string> pieces;
  for (int rank = 0; rank < line_.count(); ++rank) {
    const fs::path piece = piece_path(order.path, rank);
    std::error_code ignored;
    if (!fs::exists(piece, ignored))
      throw Error(ErrorCode::unavailable, piece.string() + ": rank " + std::to_string(rank) + " has written it, and it is not there for the first rank on " + line_.node() +
                                              "; expected a folder that all nodes share");
    pieces.push_back(piece.filename().string());
  }
  OutputFile out(order.path);
  write_pvtu(out, pieces, order.request.terms.empty() ? order.request.array : "", order.request.carry);
  out.finish();
}

}  // namespace

std::unique_ptr<SceneRanks> lead_ranks(RankLine& line) { return std::make_unique<FirstRank>(line); }

}  // namespace isostrata
