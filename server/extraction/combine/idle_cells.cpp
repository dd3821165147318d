#include "extraction/combine/idle_cells.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "data/values/check_values.h"

namespace isostrata {
namespace {

/// What is known of the values of some points with regard to one range, as bits: OR over the points gives what they span.
enum : std::uint8_t { kReaches = 1, kBegins = 2, kLeaves = 4 };

/// kReaches: not below; kBegins: not above; kLeaves: not strictly inside, or without value.
std::uint8_t bits_of(double value, const Interval& range) {
  const bool finite = std::isfinite(value);
  const bool reaches = finite & (value >= range.lower), begins = finite & (value <= range.upper);
  const bool strictly = finite & (value > range.lower) & (value < range.upper);
  return static_cast<std::uint8_t>((reaches ? kReaches : 0) | (begins ? kBegins : 0) | (strictly ? 0 : kLeaves));
}

/// Calls visit(cell, bits) for all cells, those of one block on one thread.
template <class Visit>
void visit_cells(const Grid& grid, const PointArray& array, const Interval& range, const Task& task, const Visit& visit) {
  std::visit(
      [&](auto values) {
        if (grid.structured()) {
          const auto dims = grid.dims();
          const std::int64_t ni = dims[0], nj = dims[1], ci = ni - 1, cj = nj - 1;
          parallel_for(cj * (dims[2] - 1), std::max<std::int64_t>(1, 65536 / ni), [&](std::int64_t begin, std::int64_t end) {
            task.check();
            std::vector<std::uint8_t> column(ni);  // over the four rows around a row of cells
            for (std::int64_t r = begin; r < end; ++r) {
              const std::int64_t first = ni * (r % cj + nj * (r / cj));
              for (std::int64_t i = 0; i < ni; ++i) {
                const std::int64_t p = first + i;
                column[i] = bits_of(static_cast<double>(values[p]), range) | bits_of(static_cast<double>(values[p + ni]), range) |
                            bits_of(static_cast<double>(values[p + ni * nj]), range) |
                            bits_of(static_cast<double>(values[p + ni * nj + ni]), range);
              }
              for (std::int64_t i = 0; i < ci; ++i) visit(r * ci + i, column[i] | column[i + 1]);
            }
          });
        } else {
          const auto& shape = std::get<UnstructuredGrid>(grid.shape);
          parallel_for(grid.cell_count(), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
            task.check();
            for (std::int64_t cell = begin; cell < end; ++cell) {
              unsigned bits = 0;
              for (std::int64_t v = shape.offsets[cell]; v < shape.offsets[cell + 1]; ++v)
                bits |= bits_of(static_cast<double>(values[shape.connectivity[v]]), range);
              visit(cell, bits);
            }
          });
        }
      },
      array.values);
}

}  // namespace

std::vector<std::uint8_t> find_idle_cells(const Grid& grid, const PointArray& array, std::span<const Interval> intervals,
                                          std::span<const ArrayTerm> terms, const Task& task) {
  check_values(array, grid.point_count());
  for (const ArrayTerm& term : terms) check_values(*term.array, grid.point_count());
  task.report(0.0, "searching");
  std::vector<std::uint8_t> may(grid.cell_count());  // hold a part of the region
  // More intervals than a few are taken as one that spans them: only what is looked at in vain grows.
  Interval span{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const Interval& interval : intervals) span = {std::min(span.lower, interval.lower), std::max(span.upper, interval.upper)};
  constexpr std::size_t kFew = 8;
  const std::span<const Interval> looked = intervals.size() <= kFew ? intervals : std::span<const Interval>(&span, 1);
  for (const Interval& interval : looked)
    visit_cells(grid, array, interval, task, [&](std::int64_t cell, unsigned bits) {
      if ((bits & kReaches) && (bits & kBegins)) may[cell] = 1;
    });
  for (const ArrayTerm& term : terms)
    visit_cells(grid, *term.array, term.range, task, [&](std::int64_t cell, unsigned bits) {
      may[cell] = may_be_combined(term.op, may[cell] != 0, (bits & kReaches) && (bits & kBegins), !(bits & kLeaves));
    });
  parallel_for(grid.cell_count(), 1 << 18, [&](std::int64_t begin, std::int64_t end) {
    task.check();
    for (std::int64_t cell = begin; cell < end; ++cell) may[cell] = !may[cell] || grid.hidden(cell);
  });
  return may;
}

}  // namespace isostrata
