#include "data/dataset/dataset_bytes.h"

#include <variant>

#include "data/values/source_mapping.h"

namespace isostrata {
namespace {

template <class... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

std::uint64_t span_bytes(const PointSpan& points) {
  return std::visit([](auto span) { return static_cast<std::uint64_t>(span.size_bytes()); }, points);
}

}  // namespace

std::uint64_t dataset_bytes(const Dataset& dataset) {
  std::uint64_t bytes = dataset.grid.hidden_cells.size_bytes();
  std::visit(Overloaded{[](const UniformGrid&) {},
                        [&](const RectilinearGrid& grid) {
                          for (const auto& axis : grid.axes) bytes += axis.size() * sizeof(double);
                        },
                        [&](const CurvilinearGrid& grid) { bytes += span_bytes(grid.points); },
                        [&](const UnstructuredGrid& grid) {
                          bytes += span_bytes(grid.points) + grid.types.size_bytes() + grid.offsets.size_bytes() +
                                   grid.connectivity.size_bytes();
                        }},
             dataset.grid.shape);
  const auto own_bytes = [](auto values) { return is_in_source(values.data()) ? 0 : static_cast<std::uint64_t>(values.size_bytes()); };
  for (const PointArray& array : dataset.arrays)
    bytes += std::visit(own_bytes, array.values) + (array.cells ? std::visit(own_bytes, array.cells->values) : 0);
  return bytes;
}

}  // namespace isostrata
