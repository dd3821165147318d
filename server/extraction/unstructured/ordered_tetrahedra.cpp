#include "extraction/unstructured/ordered_tetrahedra.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <string>
#include <type_traits>

#include "base/finite.h"
#include "base/parallel.h"
#include "extraction/cells/cell_geometry.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/unstructured/cell_clusters.h"
#include "extraction/unstructured/number_edges.h"
#include "extraction/unstructured/small_table.h"

namespace isostrata {
namespace {

constexpr std::int64_t kPerTask = 1 << 13;
constexpr std::uint32_t kUnranked = ~std::uint32_t{0};

template <class T>
std::uint64_t bytes_in(const Buffer<T>& buffer) {
  return buffer.size() * sizeof(T);
}

class Maker {
 public:
  Maker(const Grid& grid, std::uint64_t max_bytes, const Task& task)
      : grid_(grid), shape_(std::get<UnstructuredGrid>(grid.shape)), max_bytes_(max_bytes), task_(task) {}

  std::shared_ptr<const OrderedTetrahedra> make() {
    order_cells();
    sort_vertices();
    if (repeats_points_.load()) return nullptr;
    number_points();
    list_blocks();
    take_edges(number_edges(vertices_, out_->point_count(), task_));
    return std::move(out_);
  }

 private:
  const std::int64_t* ids_of(std::size_t t) const { return shape_.connectivity.data() + shape_.offsets[out_->cells[t]]; }

  void order_cells() {
    const CellClusters clusters(grid_, max_bytes_, task_);
    std::atomic<bool> finite{true};
    parallel_for(grid_.point_count(), kPerTask, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t p = begin; p < end; ++p)
        if (!is_finite(grid_.point(p))) finite.store(false, std::memory_order_relaxed);
    });
    out_->cells.reserve(static_cast<std::size_t>(grid_.cell_count()));
    for (std::int64_t c = 0; c < clusters.count(); ++c)
      for (const std::uint32_t cell : clusters.cells(c)) {
        if (grid_.hidden(cell)) continue;
        if (finite.load(std::memory_order_relaxed)) {
          out_->cells.push_back(cell);
          continue;
        }
        const std::int64_t* const ids = shape_.connectivity.data() + shape_.offsets[cell];
        if (std::all_of(ids, ids + 4, [&](std::int64_t id) { return is_finite(grid_.point(id)); })) out_->cells.push_back(cell);
      }
    task_.check();
  }

  /// In the order in which the cells name them first. vertices_ then has these numbers.
  void number_points() {
    Buffer<std::uint32_t> rank(static_cast<std::size_t>(grid_.point_count()));
    std::fill(rank.begin(), rank.end(), kUnranked);
    for (std::size_t t = 0; t < out_->count(); ++t) {
      std::array<std::uint32_t, 4> of_cell;
      for (std::size_t i = 0; i < 4; ++i) of_cell[out_->turns[t] >> 2 * i & 3u] = vertices_[t][i];
      for (const std::uint32_t id : of_cell) {
        if (rank[id] != kUnranked) continue;
        rank[id] = static_cast<std::uint32_t>(out_->ids.size());
        out_->ids.push_back(id);
      }
      for (std::uint32_t& vertex : vertices_[t]) vertex = rank[vertex];
      if (t % (1 << 16) == 0) task_.check();
    }
    std::visit(
        [&](auto points) {
          auto& to = out_->positions.emplace<Buffer<std::remove_cv_t<typename decltype(points)::value_type>>>();
          to.resize(out_->point_count());
          each(to.size(), [&](std::size_t p) { to[p] = points[out_->ids[p]]; });
        },
        shape_.points);
  }

  void sort_vertices() {
    vertices_.resize(out_->count());
    out_->turns.resize(out_->count());
    std::atomic<bool> flat{false};
    parallel_for(static_cast<std::int64_t>(out_->count()), kPerTask, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) sort_one(t, flat);
    });
    out_->some_are_flat = flat.load();
  }

  void sort_one(std::size_t t, std::atomic<bool>& flat) {
    const std::int64_t* const ids = ids_of(t);
    std::array<int, 4> vertex{0, 1, 2, 3};
    std::sort(vertex.begin(), vertex.end(), [&](int a, int b) { return ids[a] < ids[b]; });
    bool odd = false;
    unsigned turn = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) odd ^= vertex[j] > vertex[i];
      turn |= static_cast<unsigned>(vertex[i]) << 2 * i;
      vertices_[t][i] = static_cast<std::uint32_t>(ids[vertex[i]]);
      if (i > 0 && ids[vertex[i]] == ids[vertex[i - 1]]) repeats_points_.store(true, std::memory_order_relaxed);
    }
    std::array<Vec3d, 4> p;
    for (int v = 0; v < 4; ++v) p[v] = grid_.point(ids[v]);
    const int sign = cell_handedness(topology(CellType::tetrahedron), p).sign;
    if ((sign < 0) != odd) turn |= TetrahedronTurn::kSwapped;
    if (sign < 0) turn |= TetrahedronTurn::kNegative;
    if (sign == 0) {
      turn |= TetrahedronTurn::kFlat;
      flat.store(true, std::memory_order_relaxed);
    }
    out_->turns[t] = static_cast<std::uint16_t>(turn);
  }

  void take_edges(NumberedEdges made) {
    vertices_ = {};
    out_->begins.resize(made.ends.size());
    each(out_->point_count(), [&](std::size_t a) {
      std::fill(out_->begins.begin() + made.first[a], out_->begins.begin() + made.first[a + 1],
                static_cast<std::uint8_t>(a % OrderedTetrahedra::kPointBlock));
    });
    std::array<std::uint8_t, 4> face_without{};  // vertex of the cell -> face of the cell
    const auto& faces = topology(CellType::tetrahedron).faces;
    for (std::size_t f = 0; f < faces.size(); ++f)
      face_without[static_cast<std::size_t>(6 - faces[f].vertex[0] - faces[f].vertex[1] - faces[f].vertex[2])] = static_cast<std::uint8_t>(f);
    each(out_->count(), [&](std::size_t t) {
      unsigned open = 0;
      for (std::size_t i = 0; i < 4; ++i)
        if (made.open[t] >> i & 1) open |= 1u << face_without[out_->turns[t] >> 2 * i & 3u];
      made.open[t] = static_cast<std::uint8_t>(open);
    });
    out_->first_edge = std::move(made.first);
    out_->ends = std::move(made.ends);
    out_->edges = std::move(made.edges);
    out_->open_faces = std::move(made.open);
  }

  /// Names the vertices by their places among the points of their blocks.
  void list_blocks() {
    constexpr std::size_t kBlock = OrderedTetrahedra::kBlock;
    const std::size_t blocks = (out_->count() + kBlock - 1) / kBlock;
    out_->corners.resize(blocks);
    ListPool<std::uint32_t> pool;
    std::vector<std::span<const std::uint32_t>> lists(blocks);
    parallel_for(static_cast<std::int64_t>(blocks), 1 << 12, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      SmallTable places;
      std::vector<std::uint32_t> list;
      for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
        list.clear();
        places.start(4 * kBlock);
        BlockCorners corners;
        for (std::size_t t = b * kBlock; t < std::min(out_->count(), (b + 1) * kBlock); ++t)
          for (std::size_t v = 0; v < 4; ++v) {
            const std::uint32_t point = vertices_[t][v];
            SmallTable::Entry& place = places.at(point);
            if (place.key == SmallTable::kFree) {
              place = {point, static_cast<std::uint32_t>(list.size())};
              list.push_back(point);
            }
            corners.of[v][t % kBlock] = static_cast<std::uint8_t>(place.value);
          }
        out_->corners[b] = corners;
        lists[b] = pool.keep(list);
      }
    });
    out_->first_in_block.push_back(0);
    for (const auto& list : lists)
      out_->first_in_block.push_back(out_->first_in_block.back() + static_cast<std::uint32_t>(list.size()));
    out_->block_points.resize(out_->first_in_block.back());
    for (std::size_t b = 0; b < blocks; ++b)
      std::copy(lists[b].begin(), lists[b].end(), out_->block_points.begin() + out_->first_in_block[b]);
  }

  template <class Visit>
  void each(std::size_t count, const Visit& visit) {
    parallel_for(static_cast<std::int64_t>(count), kPerTask, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t i = begin; i < end; ++i) visit(static_cast<std::size_t>(i));
    });
  }

  const Grid& grid_;
  const UnstructuredGrid& shape_;
  const std::uint64_t max_bytes_;
  const Task& task_;
  std::shared_ptr<OrderedTetrahedra> out_ = std::make_shared<OrderedTetrahedra>();
  Buffer<std::array<std::uint32_t, 4>> vertices_;  // [nt] points of the grid, then of out_, by global id
  std::atomic<bool> repeats_points_{false};
};

template <class T>
std::shared_ptr<const OrderedArray> order_values(const OrderedTetrahedra& tetrahedra, std::span<const T> values,
                                                 const Task& task) {
  constexpr std::size_t kBlock = OrderedTetrahedra::kBlock, kPointBlock = OrderedTetrahedra::kPointBlock;
  auto made = std::make_shared<OrderedArray>(OrderedValues<T>{});
  OrderedValues<T>& out = std::get<OrderedValues<T>>(*made);
  const std::size_t np = tetrahedra.point_count();
  const auto each = [&](std::size_t count, std::int64_t grain, const auto& visit) {
    parallel_for(static_cast<std::int64_t>(count), grain, [&](std::int64_t begin, std::int64_t end) {
      task.check();
      for (std::int64_t i = begin; i < end; ++i) visit(static_cast<std::size_t>(i));
    });
  };
  out.of_points.resize(np);
  std::atomic<bool> finite{true};
  each(np, kPerTask, [&](std::size_t p) {
    const T value = values[tetrahedra.ids[p]];
    out.of_points[p] = value;
    if constexpr (std::is_floating_point_v<T>)
      if (!std::isfinite(value)) finite.store(false, std::memory_order_relaxed);
  });
  if (!finite.load()) return nullptr;
  const std::size_t blocks = tetrahedra.blocks(), point_blocks = (np + kPointBlock - 1) / kPointBlock;
  out.least.resize(blocks);
  out.most.resize(blocks);
  each(blocks, kPerTask / kBlock, [&](std::size_t b) {
    const std::span<const std::uint32_t> points = tetrahedra.points_of_block(b);
    T least = out.of_points[points[0]], most = least;
    for (const std::uint32_t p : points) {
      least = std::min(least, out.of_points[p]);
      most = std::max(most, out.of_points[p]);
    }
    out.least[b] = least;
    out.most[b] = most;
  });
  out.least_about.resize(point_blocks);
  out.most_about.resize(point_blocks);
  each(point_blocks, kPerTask / kPointBlock, [&](std::size_t b) {
    const std::size_t end = std::min(np, (b + 1) * kPointBlock);
    T least = out.of_points[b * kPointBlock], most = least;
    const auto include = [&](std::size_t p) {
      least = std::min(least, out.of_points[p]);
      most = std::max(most, out.of_points[p]);
    };
    for (std::size_t p = b * kPointBlock; p < end; ++p) include(p);
    for (std::uint32_t e = tetrahedra.first_edge[b * kPointBlock]; e < tetrahedra.first_edge[end]; ++e)
      include(tetrahedra.ends[e]);
    out.least_about[b] = least;
    out.most_about[b] = most;
  });
  return made;
}

}  // namespace

std::shared_ptr<const OrderedTetrahedra> OrderedTetrahedra::make(const Grid& grid, std::uint64_t max_bytes, const Task& task) {
  const auto* shape = std::get_if<UnstructuredGrid>(&grid.shape);
  constexpr auto kTetrahedron = static_cast<std::uint8_t>(CellType::tetrahedron);
  constexpr std::int64_t kMost = std::numeric_limits<std::uint32_t>::max() / 6;  // its edges are counted in 32 bits, too
  if (!shape || grid.cell_count() > kMost || grid.point_count() > kMost ||
      !std::all_of(shape->types.begin(), shape->types.end(), [](std::uint8_t type) { return type == kTetrahedron; }))
    return nullptr;
  check_budget("the order of " + std::to_string(grid.cell_count()) + " tetrahedra", foreseen_bytes(grid), max_bytes);
  return Maker(grid, max_bytes, task).make();
}

std::uint64_t OrderedTetrahedra::foreseen_bytes(const Grid& grid) {
  // Beside what is kept the vertices and the corners by point; about 7 edges for 6 tetrahedra.
  return static_cast<std::uint64_t>(grid.cell_count()) * (38 + 16 + 12 + 12) + static_cast<std::uint64_t>(grid.point_count()) * 48;
}

std::uint64_t OrderedTetrahedra::bytes() const {
  return bytes_in(first_in_block) + bytes_in(block_points) + bytes_in(corners) + bytes_in(edges) + bytes_in(cells) +
         bytes_in(turns) + bytes_in(open_faces) + bytes_in(ids) + bytes_in(first_edge) + bytes_in(ends) + bytes_in(begins) +
         std::visit([](const auto& of) { return bytes_in(of); }, positions);
}

std::shared_ptr<const OrderedArray> order_values(const OrderedTetrahedra& tetrahedra, const PointArray& array, const Task& task) {
  return std::visit([&](auto values) { return order_values(tetrahedra, values, task); }, array.values);
}

std::uint64_t bytes_of(const OrderedArray& array) {
  return std::visit(
      [](const auto& of) {
        return bytes_in(of.of_points) + bytes_in(of.least) + bytes_in(of.most) + bytes_in(of.least_about) +
               bytes_in(of.most_about);
      },
      array);
}

}  // namespace isostrata
