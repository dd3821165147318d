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
#include "extraction/mesh/keyed_lists.h"
#include "extraction/mesh/list_pool.h"
#include "extraction/mesh/memory_budget.h"
#include "extraction/unstructured/cell_clusters.h"
#include "extraction/unstructured/sorted_tetrahedron.h"

namespace isostrata {
namespace {

constexpr std::int64_t kPerTask = 1 << 13;
constexpr std::uint32_t kNone = ~std::uint32_t{0};

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
    number_points();
    sort_vertices();
    if (repeats_points_.load()) return nullptr;
    number_edges();
    list_blocks();
    find_open_faces();
    return std::move(out_);
  }

 private:
  const std::int64_t* ids_of(std::size_t t) const { return shape_.connectivity.data() + shape_.offsets[out_->cells[t]]; }

  /// Where the grid ends depends on no array, for all of these cells take part. Every tetrahedron tells its faces to the first of their edges, by their
  /// third vertices: what only one has told is open.
  void find_open_faces() {
    rank_ = {};
    struct Face {
      std::uint32_t third;
      std::uint32_t of;  // 4 times the tetrahedron, and the place of the vertex that the face does not have, in the order of ids
    };
    std::array<std::uint8_t, 4> face_without{};  // vertex of the cell -> face of the cell
    const auto& faces = topology(CellType::tetrahedron).faces;
    for (std::size_t f = 0; f < faces.size(); ++f)
      face_without[static_cast<std::size_t>(6 - faces[f].vertex[0] - faces[f].vertex[1] - faces[f].vertex[2])] = static_cast<std::uint8_t>(f);
    try {
      const auto told = list_by_key<Face>(static_cast<std::int64_t>(out_->edge_count()), static_cast<std::int64_t>(out_->count()), kPerTask,
                                          "the faces of the grid", max_bytes_, [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                            task_.check();
                                            for (std::int64_t t = begin; t < end; ++t)
                                              for (const Side& side : kSides)
                                                emit(out_->edges[t][side.edge], Face{vertices_[t][side.third], static_cast<std::uint32_t>(4 * t + side.missing)});
                                          });
      out_->open_faces.resize(out_->count());
      std::fill(out_->open_faces.begin(), out_->open_faces.end(), std::uint8_t{0});
      each(told.keys(), [&](std::size_t edge) {
        const std::span<const Face> about = told.of(static_cast<std::int64_t>(edge));
        for (const Face& face : about) {
          if (std::any_of(about.begin(), about.end(), [&](const Face& other) { return other.third == face.third && other.of != face.of; })) continue;
          const std::size_t t = face.of / 4;
          const unsigned vertex = out_->turns[t] >> 2 * (face.of % 4) & 3u;
          std::atomic_ref(out_->open_faces[t]).fetch_or(static_cast<std::uint8_t>(1u << face_without[vertex]), std::memory_order_relaxed);
        }
      });
    } catch (const Error& error) {
      if (error.code() != ErrorCode::too_large) throw;  // each extraction finds out for its own cells
    }
    vertices_ = {};
  }

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

  void number_points() {
    rank_.resize(static_cast<std::size_t>(grid_.point_count()));
    std::fill(rank_.begin(), rank_.end(), kNone);
    for (std::size_t t = 0; t < out_->count(); ++t) {
      const std::int64_t* const ids = ids_of(t);
      for (int v = 0; v < 4; ++v) {
        std::uint32_t& rank = rank_[static_cast<std::size_t>(ids[v])];
        if (rank != kNone) continue;
        rank = static_cast<std::uint32_t>(out_->ids.size());
        out_->ids.push_back(static_cast<std::uint32_t>(ids[v]));
      }
      if (t % (1 << 16) == 0) task_.check();
    }
    std::visit(
        [&](auto points) {
          auto& to = out_->positions.emplace<Buffer<std::remove_cv_t<typename decltype(points)::value_type>>>();
          to.resize(out_->point_count());
          for (std::size_t p = 0; p < to.size(); ++p) to[p] = points[out_->ids[p]];
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
      vertices_[t][i] = rank_[static_cast<std::size_t>(ids[vertex[i]])];
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

  /// Every tetrahedron tells the lower end of each of its edges of the other one: the lists without their repeats are the edges.
  void number_edges() {
    const auto count = static_cast<std::int64_t>(out_->count()), points = static_cast<std::int64_t>(out_->point_count());
    auto told = list_by_key<std::uint32_t>(points, count, kPerTask, "the edges of the grid", max_bytes_,
                                           [&](std::int64_t begin, std::int64_t end, const auto& emit) {
                                             task_.check();
                                             for (std::int64_t t = begin; t < end; ++t) {
                                               const auto& v = vertices_[t];
                                               for (const auto& [a, b] : kEnds) emit(v[a], v[b]);
                                             }
                                           });
    std::vector<std::uint32_t> first(static_cast<std::size_t>(points) + 1);
    each(points, [&](std::size_t a) {
      const auto list = told.of(static_cast<std::int64_t>(a));
      std::sort(list.begin(), list.end());
      first[a] = static_cast<std::uint32_t>(std::unique(list.begin(), list.end()) - list.begin());
    });
    out_->ends.resize(running_sum(first));
    out_->first_edge.assign(first.begin(), first.end());
    each(points, [&](std::size_t a) {
      std::copy_n(told.of(static_cast<std::int64_t>(a)).begin(), first[a + 1] - first[a], out_->ends.begin() + first[a]);
    });
    out_->begins.resize(out_->edge_count());
    each(points, [&](std::size_t a) {
      std::fill(out_->begins.begin() + first[a], out_->begins.begin() + first[a + 1],
                static_cast<std::uint8_t>(a % OrderedTetrahedra::kPointBlock));
    });
    out_->edges.resize(out_->count());
    each(count, [&](std::size_t t) {
      const auto& v = vertices_[t];
      for (std::size_t e = 0; e < 6; ++e) {
        const std::uint32_t a = v[kEnds[e][0]], b = v[kEnds[e][1]];
        const auto at = std::lower_bound(out_->ends.begin() + first[a], out_->ends.begin() + first[a + 1], b);
        out_->edges[t][e] = static_cast<std::uint32_t>(at - out_->ends.begin());
      }
    });
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
      std::vector<std::uint32_t> listed_in(out_->point_count(), kNone), place(out_->point_count()), list;
      for (auto b = static_cast<std::size_t>(begin); b < static_cast<std::size_t>(end); ++b) {
        list.clear();
        BlockCorners corners;
        for (std::size_t t = b * kBlock; t < std::min(out_->count(), (b + 1) * kBlock); ++t)
          for (std::size_t v = 0; v < 4; ++v) {
            const std::uint32_t point = vertices_[t][v];
            if (listed_in[point] != b) {
              listed_in[point] = static_cast<std::uint32_t>(b);
              place[point] = static_cast<std::uint32_t>(list.size());
              list.push_back(point);
            }
            corners.of[v][t % kBlock] = static_cast<std::uint8_t>(place[point]);
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
  void each(std::int64_t count, const Visit& visit) {
    parallel_for(count, kPerTask, [&](std::int64_t begin, std::int64_t end) {
      task_.check();
      for (std::int64_t i = begin; i < end; ++i) visit(static_cast<std::size_t>(i));
    });
  }

  static constexpr std::array<std::array<std::uint8_t, 2>, 6> kEnds = kSortedEdges;
  struct Side {
    std::uint8_t edge, third, missing;  // a face: the first of its edges in kEnds, and vertices in the order of ids
  };
  static constexpr std::array<Side, 4> kSides{{{0, 2, 3}, {0, 3, 2}, {1, 3, 1}, {3, 3, 0}}};

  const Grid& grid_;
  const UnstructuredGrid& shape_;
  const std::uint64_t max_bytes_;
  const Task& task_;
  std::shared_ptr<OrderedTetrahedra> out_ = std::make_shared<OrderedTetrahedra>();
  Buffer<std::uint32_t> rank_;                     // [grid points]
  Buffer<std::array<std::uint32_t, 4>> vertices_;  // [nt] points, by global id
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
  // 32 bytes a cell for the faces as they are told, with the rest of what is kept; about 7 edges for 6 tetrahedra.
  return static_cast<std::uint64_t>(grid.cell_count()) * (38 + 16 + 32 + 8) + static_cast<std::uint64_t>(grid.point_count()) * 48;
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
