#include "data/grids/same_grid.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>

#include "base/parallel.h"

namespace isostrata {
namespace {

bool same_bytes(std::span<const std::byte> a, std::span<const std::byte> b) {
  if (a.size() != b.size()) return false;
  if (a.data() == b.data() || a.empty()) return true;
  constexpr std::int64_t kBlock = 1 << 20;
  const auto size = static_cast<std::int64_t>(a.size());
  std::atomic<bool> same{true};
  parallel_for((size + kBlock - 1) / kBlock, 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t block = begin; block < end && same.load(std::memory_order_relaxed); ++block) {
      const auto from = static_cast<std::size_t>(block * kBlock), count = static_cast<std::size_t>(std::min(kBlock, size - block * kBlock));
      if (std::memcmp(a.data() + from, b.data() + from, count) != 0) same = false;
    }
  });
  return same;
}

template <class T>
bool same(std::span<const T> a, std::span<const T> b) {
  return same_bytes(std::as_bytes(a), std::as_bytes(b));
}

bool same(const PointSpan& a, const PointSpan& b) {
  if (a.index() != b.index()) return false;
  return std::visit([&](auto points) { return same(points, std::get<decltype(points)>(b)); }, a);
}

bool same(const UniformGrid& a, const UniformGrid& b) { return a.dims == b.dims && a.origin == b.origin && a.spacing == b.spacing; }
bool same(const RectilinearGrid& a, const RectilinearGrid& b) { return a.dims == b.dims && a.axes == b.axes; }
bool same(const CurvilinearGrid& a, const CurvilinearGrid& b) { return a.dims == b.dims && same(a.points, b.points); }
bool same(const UnstructuredGrid& a, const UnstructuredGrid& b) {
  return same(a.types, b.types) && same(a.offsets, b.offsets) && same(a.connectivity, b.connectivity) && same(a.points, b.points);
}

}  // namespace

bool same_grid(const Grid& a, const Grid& b) {
  if (a.shape.index() != b.shape.index() || !same(a.hidden_cells, b.hidden_cells)) return false;
  return std::visit([&](const auto& shape) { return same(shape, std::get<std::decay_t<decltype(shape)>>(b.shape)); }, a.shape);
}

}  // namespace isostrata
