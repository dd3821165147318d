#include "import/dataset/join_pieces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "import/dataset/near_points.h"
#include "import/dataset/near_values.h"

namespace isostrata {
namespace {

std::uint64_t mixed(std::uint64_t hash, std::uint64_t next) {
  hash = (hash ^ next) * 0x9e3779b97f4a7c15ull;
  return hash ^ hash >> 29;
}

struct IdsHash {
  std::size_t operator()(const std::vector<std::int64_t>& ids) const {
    std::uint64_t hash = 0;
    for (const std::int64_t id : ids) hash = mixed(hash, static_cast<std::uint64_t>(id));
    return static_cast<std::size_t>(hash);
  }
};

class Joiner {
 public:
  Joiner(Block& block, std::span<const std::int64_t> first_points, std::span<const std::int64_t> first_cells, std::span<const std::int64_t> global_points)
      : block_(block),
        grid_(std::get<UnstructuredGrid>(block.grid.shape)),
        first_points_(first_points),
        first_cells_(first_cells),
        global_points_(global_points),
        stands_for_(static_cast<std::size_t>(block.grid.point_count())),
        ranges_(block.arrays.size()) {
    std::iota(stands_for_.begin(), stands_for_.end(), 0);
  }

  void run(std::vector<std::string>& notes) {
    find_common_points();
    if (joined_ > 0 || !global_points_.empty()) {
      const std::vector<std::int64_t> kept = renumber();
      if (global_points_.empty()) hide_doubled_cells();  // else ghosts were marked, and what the whole has twice it has twice
      leave_out_all_but(kept);
    }
    const std::string pieces = std::to_string(first_points_.size()) + " pieces";
    if (joined_ > 0) notes.push_back(std::to_string(joined_) + " points that " + pieces + " share are one point each");
    if (apart_ > 0)
      notes.push_back(std::to_string(apart_) + " points of " + pieces +
                      " are at the places of others and stay apart, as their values differ");
    if (doubled_ > 0) notes.push_back(std::to_string(doubled_) + " cells hidden that another piece has as well");
  }

 private:
  bool same_values(std::int64_t p, std::int64_t q) {
    for (std::size_t a = 0; a < block_.arrays.size(); ++a) {
      const FileArray& array = block_.arrays[a];
      if (array.on_cells || (array.partial && (no_value(array, p) || no_value(array, q)))) continue;
      const bool same = std::visit(
          [&](auto values) {
            const auto n = static_cast<std::size_t>(array.components);
            const auto of_p = values.subspan(static_cast<std::size_t>(p) * n, n), of_q = values.subspan(static_cast<std::size_t>(q) * n, n);
            if (std::memcmp(of_p.data(), of_q.data(), of_p.size_bytes()) == 0) return true;
            if (ranges_[a].empty()) ranges_[a] = ranges_of(values, n);
            for (std::size_t c = 0; c < n; ++c)
              if (!near_value(of_p[c], of_q[c], ranges_[a][c])) return false;
            return true;
          },
          scalar_span(array.type, array.values));
      if (!same) return false;
    }
    return true;
  }

  bool may_be_one(std::int64_t p, std::int64_t q) const {
    return global_points_.empty() || global_points_[static_cast<std::size_t>(p)] == global_points_[static_cast<std::size_t>(q)];
  }

  /// Of an array that some pieces do not have, if it is NaN in all components.
  static bool no_value(const FileArray& array, std::int64_t p) {
    return std::visit(
        [&](auto values) {
          const auto n = static_cast<std::size_t>(array.components);
          const auto tuple = values.subspan(static_cast<std::size_t>(p) * n, n);
          return std::all_of(tuple.begin(), tuple.end(), [](auto value) { return std::isnan(static_cast<double>(value)); });
        },
        scalar_span(array.type, array.values));
  }

  /// The point that is kept has what the other one knows. Arrays that are partial were made whole here, so they may be written.
  void take_values(std::int64_t kept, std::int64_t from) {
    for (FileArray& array : block_.arrays) {
      if (array.on_cells || !array.partial || !no_value(array, kept)) continue;
      const std::size_t tuple = size_of(array.type) * static_cast<std::size_t>(array.components);
      auto* values = const_cast<std::byte*>(array.values.data());
      std::memcpy(values + static_cast<std::size_t>(kept) * tuple, values + static_cast<std::size_t>(from) * tuple, tuple);
    }
  }

  std::size_t piece_of(std::int64_t p) const {
    return static_cast<std::size_t>(std::upper_bound(first_points_.begin(), first_points_.end(), p) - first_points_.begin()) - 1;
  }

  void find_common_points() {
    const NearPoints near(block_.grid, first_points_);
    std::vector<std::size_t> newest(stands_for_.size());  // of a point that stands for others: the last piece that has it
    for (const std::int64_t p : near.candidates()) {
      const std::size_t piece = newest[static_cast<std::size_t>(p)] = piece_of(p);
      bool met = false;
      const std::int64_t same = near.first(p, [&](std::int64_t other) {
        std::size_t& last = newest[static_cast<std::size_t>(other)];
        if (stands_for_[static_cast<std::size_t>(other)] != other || last == piece || !may_be_one(p, other)) return false;  // two points of one piece are two points
        met = true;
        return same_values(p, other);
      });
      if (same == p) {
        apart_ += met;
        continue;
      }
      stands_for_[static_cast<std::size_t>(p)] = same;
      take_values(same, p);
      newest[static_cast<std::size_t>(same)] = piece;
      ++joined_;
    }
  }

  /// Makes stands_for_ the numbers that points have when only one of each place is left: those that are returned.
  std::vector<std::int64_t> renumber() {
    std::vector<std::int64_t> kept;
    for (std::size_t p = 0; p < stands_for_.size(); ++p)
      if (static_cast<std::size_t>(stands_for_[p]) == p) kept.push_back(static_cast<std::int64_t>(p));
    if (!global_points_.empty())
      std::stable_sort(kept.begin(), kept.end(), [&](std::int64_t p, std::int64_t q) {
        return global_points_[static_cast<std::size_t>(p)] < global_points_[static_cast<std::size_t>(q)];
      });
    std::vector<std::int64_t> number(stands_for_.size());
    for (std::size_t i = 0; i < kept.size(); ++i) number[static_cast<std::size_t>(kept[i])] = static_cast<std::int64_t>(i);
    common_.assign(kept.size(), false);
    for (std::size_t p = 0; p < stands_for_.size(); ++p) {
      const auto first = static_cast<std::size_t>(stands_for_[p]);
      stands_for_[p] = number[first];
      if (first != p) common_[static_cast<std::size_t>(number[first])] = true;
    }
    auto [storage, ids] = allocate<std::int64_t>(grid_.connectivity.size());
    for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = stands_for_[static_cast<std::size_t>(grid_.connectivity[i])];
    grid_.connectivity = ids;
    keep(storage);
    return kept;
  }

  /// Of the cells that have nothing but common points.
  void hide_doubled_cells() {
    std::unordered_map<std::vector<std::int64_t>, std::size_t, IdsHash> piece_of;
    std::vector<std::size_t> doubled;
    std::size_t piece = 0;
    for (std::size_t c = 0; c < grid_.types.size(); ++c) {
      while (piece + 1 < first_cells_.size() && static_cast<std::int64_t>(c) >= first_cells_[piece + 1]) ++piece;
      const auto ids = grid_.connectivity.subspan(static_cast<std::size_t>(grid_.offsets[c]),
                                                  static_cast<std::size_t>(grid_.offsets[c + 1] - grid_.offsets[c]));
      if (block_.grid.hidden(static_cast<std::int64_t>(c)) ||
          !std::all_of(ids.begin(), ids.end(), [&](std::int64_t id) { return common_[static_cast<std::size_t>(id)]; }))
        continue;
      std::vector<std::int64_t> key(ids.begin(), ids.end());
      std::sort(key.begin(), key.end());
      const auto [at, is_first] = piece_of.try_emplace(std::move(key), piece);
      if (!is_first && at->second != piece) doubled.push_back(c);
    }
    doubled_ = static_cast<std::int64_t>(doubled.size());
    if (doubled.empty()) return;
    auto [storage, hidden] = allocate<std::uint8_t>(grid_.types.size());
    for (std::size_t c = 0; c < hidden.size(); ++c) hidden[c] = block_.grid.hidden(static_cast<std::int64_t>(c));
    for (const std::size_t c : doubled) hidden[c] = 1;
    block_.grid.hidden_cells = hidden;
    keep(storage);
  }

  void leave_out_all_but(const std::vector<std::int64_t>& kept) {
    std::visit(
        [&](auto points) {
          using V = std::remove_const_t<typename decltype(points)::element_type>;
          auto [of_points, left] = allocate<V>(kept.size());
          for (std::size_t i = 0; i < kept.size(); ++i) left[i] = points[static_cast<std::size_t>(kept[i])];
          grid_.points = std::span<const V>(left);
          keep(of_points);
        },
        PointSpan(grid_.points));
    for (FileArray& array : block_.arrays) {
      if (array.on_cells) continue;
      const std::size_t tuple = size_of(array.type) * static_cast<std::size_t>(array.components);
      auto [of_values, left] = allocate<std::byte>(kept.size() * tuple);
      for (std::size_t i = 0; i < kept.size(); ++i)
        std::memcpy(left.data() + i * tuple, array.values.data() + static_cast<std::size_t>(kept[i]) * tuple, tuple);
      array.values = left;
      array.storage = of_values;
    }
  }

  template <class Storage>
  void keep(const Storage& storage) {
    block_.grid.storage =
        std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(block_.grid.storage, storage);
  }

  Block& block_;
  UnstructuredGrid& grid_;
  const std::span<const std::int64_t> first_points_, first_cells_, global_points_;
  std::vector<std::int64_t> stands_for_;  // [np] the first of the points that are one with it
  std::vector<std::vector<double>> ranges_;  // of each array's components, once they are asked for
  std::vector<bool> common_;              // of the points that are left: several pieces have it
  std::int64_t joined_ = 0, apart_ = 0, doubled_ = 0;
};

}  // namespace

void join_pieces(Block& block, std::span<const std::int64_t> first_points, std::span<const std::int64_t> first_cells,
                 std::span<const std::int64_t> global_points, std::vector<std::string>& notes) {
  Joiner(block, first_points, first_cells, global_points).run(notes);
}

}  // namespace isostrata
