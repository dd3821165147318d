#include "import/adaptive/level_weights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace isostrata {
namespace {

/// A leaf at a point, seen from there.
struct Around {
  double weight = 0;
  Vec3d to_middle;
  std::array<bool, 3> below{}, above{};  // by axis: it fills space on this side
};

/// By Newton's method the vector a for which the weights times exp(a . d) have no first moment: the least of log(sum), which is convex.
class LinearKeeper {
 public:
  explicit LinearKeeper(std::span<Around> around) : around_(around) {
    std::array<bool, 3> below{}, above{};
    Vec3d widest;
    for (const Around& leaf : around_)
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        below[at] = below[at] || leaf.below[at];
        above[at] = above[at] || leaf.above[at];
        widest[axis] = std::max(widest[axis], std::abs(leaf.to_middle[axis]));
      }
    for (Around& leaf : around_)
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(axis);
        leaf.to_middle[axis] = below[at] && above[at] && widest[axis] > 0 ? leaf.to_middle[axis] / widest[axis] : 0;
      }
  }

  /// Multiplies the weights, and makes their sum 1.
  void run() {
    constexpr int kMostSteps = 40;
    constexpr double kExact = 1e-13;
    Vec3d a;
    Moments now = moments(a);
    for (int step = 0; step < kMostSteps && length(now.first) > kExact; ++step) {
      const Vec3d towards = newton_step(now);
      double part = std::min(1.0, 4 / length(towards));
      Moments next = moments(a + towards * part);
      for (int halved = 0; halved < 20 && !(next.log_sum <= now.log_sum); ++halved) next = moments(a + towards * (part /= 2));
      a = a + towards * part;
      now = next;
    }
    if (!(length(now.first) <= 1e3 * kExact)) a = {};  // the point is not between the middles
    double sum = 0;
    for (Around& leaf : around_) sum += leaf.weight *= std::exp(dot(a, leaf.to_middle));
    for (Around& leaf : around_) leaf.weight /= sum;
  }

 private:
  struct Moments {
    double log_sum = 0;
    Vec3d first;
    std::array<Vec3d, 3> second{};  // about the first
  };

  Moments moments(const Vec3d& a) const {
    Moments out;
    double sum = 0;
    for (const Around& leaf : around_) {
      const double weight = leaf.weight * std::exp(dot(a, leaf.to_middle));
      sum += weight;
      out.first = out.first + leaf.to_middle * weight;
      for (int axis = 0; axis < 3; ++axis) out.second[static_cast<std::size_t>(axis)] = out.second[static_cast<std::size_t>(axis)] + leaf.to_middle * (weight * leaf.to_middle[axis]);
    }
    out.log_sum = std::log(sum);
    out.first = out.first / sum;
    for (int axis = 0; axis < 3; ++axis) out.second[static_cast<std::size_t>(axis)] = out.second[static_cast<std::size_t>(axis)] / sum - out.first * out.first[axis];
    return out;
  }

  /// Along an axis in which no leaf lies to a side there is nothing to do.
  static Vec3d newton_step(const Moments& at) {
    std::array<Vec3d, 3> m = at.second;
    for (int axis = 0; axis < 3; ++axis)
      if (m[static_cast<std::size_t>(axis)][axis] <= 0) m[static_cast<std::size_t>(axis)][axis] = 1;
    const double determinant = dot(m[0], cross(m[1], m[2]));
    if (!(determinant > 0)) return at.first * -1.0;
    return Vec3d{dot(at.first, cross(m[1], m[2])), dot(m[0], cross(at.first, m[2])), dot(m[0], cross(m[1], at.first))} * (-1 / determinant);
  }

  const std::span<Around> around_;
};

/// use(first cell, last cell) for the cells of each leaf.
template <class Use>
void for_each_leaf(const LeafCells& leaves, const Use& use) {
  for (std::size_t first = 0, last = 0; first < leaves.source.size(); first = last) {
    while (last < leaves.source.size() && leaves.source[last] == leaves.source[first]) ++last;
    use(first, last);
  }
}

class Weigher {
 public:
  Weigher(const LevelLattice& lattice, const LeafCells& leaves) : lattice_(lattice), leaves_(leaves) {}

  PointWeights run() {
    find_points();
    if (out_.points.empty()) return {};
    count();
    around_.resize(out_.first.back());
    out_.cells.resize(around_.size());
    std::vector<std::size_t> filled = out_.first;
    for_each_point_of_leaves([&](std::size_t first, std::size_t last, std::size_t at) {
      if (first != known_) measure(first, last);
      const std::size_t entry = filled[at]++;
      out_.cells[entry] = static_cast<std::int64_t>(first);
      around_[entry] = seen_from(point(out_.points[at]), first);
    });
    out_.weights.resize(around_.size());
    for (std::size_t at = 0; at < out_.points.size(); ++at) {
      if (middle_of_[at] >= 0) continue;
      LinearKeeper(std::span(around_).subspan(out_.first[at], out_.first[at + 1] - out_.first[at])).run();
      for (std::size_t entry = out_.first[at]; entry < out_.first[at + 1]; ++entry) out_.weights[entry] = around_[entry].weight;
    }
    for (std::size_t at = 0; at < out_.points.size(); ++at)
      if (middle_of_[at] >= 0) add_means(at, filled[at]);
    return std::move(out_);
  }

 private:
  const Vec3d& point(std::int64_t id) const { return leaves_.points[static_cast<std::size_t>(id)]; }

  std::span<const std::int64_t> ids(std::size_t first, std::size_t last) const {
    const auto begin = static_cast<std::size_t>(leaves_.offsets[first]), end = static_cast<std::size_t>(leaves_.offsets[last]);
    return std::span(leaves_.connectivity).subspan(begin, end - begin);
  }

  bool hidden(std::size_t cell) const { return !leaves_.hidden.empty() && leaves_.hidden[cell] != 0; }

  std::uint8_t level_of(std::size_t cell) const { return leaves_.level[static_cast<std::size_t>(leaves_.source[cell])]; }

  void find_points() {
    std::vector<std::uint8_t> lowest(leaves_.points.size(), 255), highest(leaves_.points.size(), 0);
    for (std::size_t cell = 0; cell < leaves_.types.size(); ++cell)
      for (const std::int64_t id : ids(cell, hidden(cell) ? cell : cell + 1)) {
        lowest[static_cast<std::size_t>(id)] = std::min(lowest[static_cast<std::size_t>(id)], level_of(cell));
        highest[static_cast<std::size_t>(id)] = std::max(highest[static_cast<std::size_t>(id)], level_of(cell));
      }
    number_.assign(leaves_.points.size(), -1);
    const auto levels_meet = [&](std::int64_t id) { return lowest[static_cast<std::size_t>(id)] < highest[static_cast<std::size_t>(id)]; };
    for (const auto& [middle, a, b, c, d] : leaves_.middles)  // their corners have to be known, whatever is around these
      if (levels_meet(middle))
        for (const std::int64_t corner : {a, b, c, d}) number_[static_cast<std::size_t>(corner)] = 0;
    for (std::size_t p = 0; p < number_.size(); ++p)
      if (number_[p] == 0 || lowest[p] < highest[p]) {
        number_[p] = static_cast<std::int32_t>(out_.points.size());
        out_.points.push_back(static_cast<std::int64_t>(p));
      }
    middle_of_.assign(out_.points.size(), -1);
    for (std::size_t m = 0; m < leaves_.middles.size(); ++m)
      if (const std::int64_t middle = leaves_.middles[m][0]; levels_meet(middle)) middle_of_[number_of(middle)] = static_cast<std::int64_t>(m);
  }

  std::size_t number_of(std::int64_t id) const { return static_cast<std::size_t>(number_[static_cast<std::size_t>(id)]); }

  /// use(number) for the corners of the face whose middle the point is.
  template <class Use>
  void for_each_corner(std::size_t at, const Use& use) const {
    const auto& face = leaves_.middles[static_cast<std::size_t>(middle_of_[at])];
    for (std::size_t corner = 1; corner < face.size(); ++corner) use(number_of(face[corner]));
  }

  void add_means(std::size_t at, std::size_t entry) {
    for_each_corner(at, [&](std::size_t corner) {
      for (std::size_t of = out_.first[corner]; of < out_.first[corner + 1]; ++of, ++entry) {
        out_.cells[entry] = out_.cells[of];
        out_.weights[entry] = out_.weights[of] / 4;
      }
    });
  }

  /// use(the leaf's first cell, its last, number of the point) once for each leaf and each point of it that has weights.
  template <class Use>
  void for_each_point_of_leaves(const Use& use) const {
    std::vector<std::int64_t> last_leaf(out_.points.size(), -1);
    for_each_leaf(leaves_, [&](std::size_t first, std::size_t last) {
      if (hidden(first)) return;
      for (const std::int64_t id : ids(first, last)) {
        if (number_[static_cast<std::size_t>(id)] < 0) continue;
        const std::size_t at = number_of(id);
        if (middle_of_[at] >= 0 || last_leaf[at] == leaves_.source[first]) continue;
        last_leaf[at] = leaves_.source[first];
        use(first, last, at);
      }
    });
  }

  void count() {
    out_.first = std::vector<std::size_t>(out_.points.size() + 1);
    for_each_point_of_leaves([&](std::size_t, std::size_t, std::size_t at) { ++out_.first[at + 1]; });
    for (std::size_t at = 0; at < out_.points.size(); ++at)
      if (middle_of_[at] >= 0) for_each_corner(at, [&](std::size_t corner) { out_.first[at + 1] += out_.first[corner + 1]; });  // not yet sums; corners are not middles
    for (std::size_t at = 0; at < out_.points.size(); ++at) out_.first[at + 1] += out_.first[at];
  }

  void measure(std::size_t first, std::size_t last) {
    Box3d box;
    for (const std::int64_t id : ids(first, last)) box.include(point(id));
    known_ = first;
    middle_ = (box.lower + box.upper) * 0.5;
    half_ = (box.upper - box.lower) * 0.5;
  }

  /// The leaf that was measured last.
  Around seen_from(const Vec3d& p, std::size_t first) const {
    constexpr double kInside = 1 - 1e-6;  // of a leaf's half
    Around out;
    out.weight = 1 / static_cast<double>(lattice_.levels[level_of(first)].unit);
    for (int axis = 0; axis < 3; ++axis) {
      if (axis == lattice_.flat_axis) continue;
      const auto a = static_cast<std::size_t>(axis);
      const double to = middle_[axis] - p[axis];
      const bool inside = std::abs(to) < kInside * half_[axis];
      out.to_middle[axis] = to;
      out.below[a] = inside || to < 0;
      out.above[a] = inside || to > 0;
      if (inside) out.weight *= 2;
    }
    return out;
  }

  const LevelLattice& lattice_;
  const LeafCells& leaves_;
  std::vector<std::int32_t> number_;  // [points] among those with weights; -1 of others
  std::vector<std::int64_t> middle_of_;  // [points with weights] the face, among LeafCells::middles; -1 of others
  std::vector<Around> around_;        // as out_.cells
  std::size_t known_ = static_cast<std::size_t>(-1);
  Vec3d middle_, half_;               // of the leaf whose first cell that is
  PointWeights out_;
};

}  // namespace

PointWeights level_weights(const LevelLattice& lattice, const LeafCells& leaves) { return Weigher(lattice, leaves).run(); }

}  // namespace isostrata
