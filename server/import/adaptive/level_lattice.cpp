#include "import/adaptive/level_lattice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.h"
#include "import/imported/imported.h"

namespace isostrata {
namespace {

constexpr double kAlike = 0.01;             // sizes of cells of one level may differ by so much of themselves, as their decimals are rounded
constexpr double kOffLattice = 0.05;        // and their corners by so much of a cell
constexpr double kMostPlaces = 0x1p50;      // along an axis

class LatticeMaker {
 public:
  LatticeMaker(const LevelBoxes& levels, const std::string& name) : boxes_(levels.boxes), name_(name) { out_.axes = levels.axes; }

  LevelLattice run() {
    if (boxes_.empty()) broken("has no boxes of cells");
    check_boxes();
    find_levels();
    place_boxes();
    for (std::size_t level = 0; level < out_.levels.size(); ++level) {
      LevelLattice::Level& own = out_.levels[level];
      own.tree = BoxTree(out_.cells, own.boxes);
      refuse_overlap(level);
      for (const std::size_t box : own.boxes) out_.leaves += out_.cells[box].count() - covered_by(box);
    }
    return std::move(out_);
  }

 private:
  [[noreturn]] void broken(const std::string& what) const { throw Error(ErrorCode::bad_data, name_ + ": " + what); }
  static std::string called(std::size_t box) { return "box " + std::to_string(box); }
  bool flat(int axis) const { return axis == out_.flat_axis; }

  void check_boxes() {
    for (int axis = 0; axis < 3; ++axis)
      if (boxes_.front().cells[static_cast<std::size_t>(axis)] == 0) {
        if (out_.flat_axis >= 0) throw Error(ErrorCode::unsupported, name_ + ": its boxes are flat in two directions; expected cells with a volume or an area");
        out_.flat_axis = axis;
      }
    out_.first_cell.assign(1, 0);
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      const LevelBox& box = boxes_[b];
      for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t cells = box.cells[static_cast<std::size_t>(axis)];
        if (flat(axis) ? cells != 0 : cells < 1) broken(called(b) + " has " + std::to_string(cells) + " cells along " + "xyz"[axis] + (flat(axis) ? "; box 0 is flat there" : ""));
        if (!std::isfinite(box.origin[axis]) || !std::isfinite(box.spacing[axis]) || (!flat(axis) && !(box.spacing[axis] > 0)))
          broken(called(b) + " has no finite place and size");
      }
      const auto of = [&](std::size_t axis) { return std::max<std::int64_t>(box.cells[axis], 1); };
      std::int64_t sum = 0;
      if (__builtin_add_overflow(out_.first_cell.back(), checked_product({of(0), of(1), of(2)}, name_ + ": " + called(b)), &sum) || sum > (std::int64_t{1} << 62))
        broken("its boxes have more cells than can be counted");
      out_.first_cell.push_back(sum);
    }
  }

  void find_levels() {
    const int first_axis = out_.flat_axis == 0 ? 1 : 0;
    std::vector<std::size_t> order(boxes_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return boxes_[a].spacing[first_axis] > boxes_[b].spacing[first_axis]; });
    out_.level_of.resize(boxes_.size());
    for (const std::size_t b : order) {
      const Vec3d& spacing = boxes_[b].spacing;
      if (out_.levels.empty() || spacing[first_axis] < (1 - kAlike) * out_.levels.back().spacing[first_axis]) {
        if (!out_.levels.empty()) out_.levels.back().ratio = ratio(out_.levels.back().spacing, spacing);
        out_.levels.emplace_back().spacing = spacing;
      }
      for (int axis = 0; axis < 3; ++axis)
        if (!flat(axis) && std::abs(spacing[axis] / out_.levels.back().spacing[axis] - 1) > kAlike)
          broken(called(b) + " has cells of another shape than " + called(out_.levels.back().boxes.front()) + ", which are as long along " + "xyz"[first_axis]);
      out_.level_of[b] = out_.levels.size() - 1;
      out_.levels.back().boxes.push_back(b);
    }
    double places = 2;
    for (std::size_t level = out_.levels.size(); level-- > 0;) {
      LevelLattice::Level& own = out_.levels[level];
      places *= static_cast<double>(own.ratio);
      if (places > kMostPlaces) broken("its cells differ in size by more than can be counted");
      own.unit = static_cast<std::int64_t>(places);
      std::sort(own.boxes.begin(), own.boxes.end());
    }
  }

  std::int64_t ratio(const Vec3d& coarse, const Vec3d& fine) const {
    std::int64_t whole = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (flat(axis)) continue;
      const double exact = coarse[axis] / fine[axis], rounded = std::round(exact);
      if (!(rounded >= 2) || rounded > 1024 || std::abs(exact / rounded - 1) > kAlike || (whole != 0 && static_cast<double>(whole) != rounded))
        throw Error(ErrorCode::unsupported, name_ + ": its cells are refined by " + std::to_string(exact) + " along " + "xyz"[axis] + "; expected a whole number of 2 or more, the same along all axes");
      whole = static_cast<std::int64_t>(rounded);
    }
    return whole;
  }

  void place_boxes() {
    const LevelLattice::Level& coarsest = out_.levels.front();
    out_.origin = boxes_[coarsest.boxes.front()].origin;
    for (const std::size_t box : coarsest.boxes)
      for (int axis = 0; axis < 3; ++axis) out_.origin[axis] = std::min(out_.origin[axis], boxes_[box].origin[axis]);
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      const LevelLattice::Level& own = out_.levels[out_.level_of[b]];
      CellRange& range = out_.cells.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<std::size_t>(axis);
        if (flat(axis)) {
          if (boxes_[b].origin[axis] != out_.origin[axis]) broken(called(b) + " does not lie in the plane of " + called(coarsest.boxes.front()));
          range.upper[a] = 1;
          continue;
        }
        const double spacing = coarsest.spacing[axis] * static_cast<double>(own.unit) / static_cast<double>(coarsest.unit);
        const double exact = (boxes_[b].origin[axis] - out_.origin[axis]) / spacing, whole = std::round(exact);
        const double end = std::abs(whole) + static_cast<double>(boxes_[b].cells[a]);
        if (!(end * static_cast<double>(own.unit) < kMostPlaces)) broken(called(b) + " lies too far from the others for cells so small");
        if (std::abs(exact - whole) > kOffLattice) broken(called(b) + " begins inside a cell of its own level");
        range.lower[a] = static_cast<std::int64_t>(whole);
        range.upper[a] = range.lower[a] + boxes_[b].cells[a];
      }
      if (out_.level_of[b] > 0) check_aligned(b, out_.levels[out_.level_of[b] - 1].ratio);
    }
  }

  void check_aligned(std::size_t box, std::int64_t ratio) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (!flat(static_cast<int>(axis)) && (out_.cells[box].lower[axis] % ratio != 0 || out_.cells[box].upper[axis] % ratio != 0))
        broken(called(box) + " begins or ends inside a cell of the next coarser level");
  }

  void refuse_overlap(std::size_t level) const {
    for (const std::size_t box : out_.levels[level].boxes)
      out_.levels[level].tree.for_each_meeting(out_.cells[box], [&](std::size_t other, const CellRange&) {
        if (other != box) broken(called(std::min(box, other)) + " and " + called(std::max(box, other)) + " are of one level and overlap");
      });
  }

  /// A box's cells in cells of a coarser level; what is begun counts.
  CellRange in_coarser(std::size_t box, std::size_t level) const {
    CellRange range = out_.cells[box];
    const std::int64_t ratio = out_.levels[level].unit / out_.levels[out_.level_of[box]].unit;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (flat(static_cast<int>(axis))) continue;
      range.lower[axis] = divided_down(range.lower[axis], ratio);
      range.upper[axis] = divided_down(range.upper[axis] - 1, ratio) + 1;
    }
    return range;
  }

  std::int64_t common_cells(const CellRange& range, std::size_t level) const {
    std::int64_t count = 0;
    out_.levels[level].tree.for_each_meeting(range, [&](std::size_t, const CellRange& other) { count += intersection(range, other).count(); });
    return count;
  }

  /// Cells of the next coarser level that the box covers: all that lie under it, or none if no coarser level has any there.
  std::int64_t covered_by(std::size_t box) const {
    const std::size_t level = out_.level_of[box];
    if (level == 0) return 0;
    const CellRange under = in_coarser(box, level - 1);
    const std::int64_t covered = common_cells(under, level - 1);
    if (covered == under.count()) return covered;
    for (std::size_t coarser = 0; coarser < level; ++coarser)
      if (common_cells(in_coarser(box, coarser), coarser) > 0) broken(called(box) + " lies only in part on the next coarser level");
    return 0;
  }

  const std::vector<LevelBox>& boxes_;
  const std::string& name_;
  LevelLattice out_;
};

}  // namespace

Vec3d LevelLattice::position(const LatticePlace& place) const {
  Vec3d at = origin;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (axis != flat_axis) at[axis] += static_cast<double>(place[a]) / static_cast<double>(levels.front().unit) * levels.front().spacing[axis];
    if (axes[a].empty()) continue;
    const double number = std::clamp(at[axis], 0.0, static_cast<double>(axes[a].size() - 1));
    const auto below = std::min(static_cast<std::size_t>(number), axes[a].size() - 1), above = std::min(below + 1, axes[a].size() - 1);
    at[axis] = std::lerp(axes[a][below], axes[a][above], number - static_cast<double>(below));
  }
  return at;
}

LevelLattice lattice_of(const LevelBoxes& levels, const std::string& name) { return LatticeMaker(levels, name).run(); }

}  // namespace isostrata
