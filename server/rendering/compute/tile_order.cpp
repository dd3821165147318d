#include "rendering/compute/tile_order.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "base/error.h"
#include "rendering/compute/tile_layout.h"
#include "rendering/order/draw_groups.h"

namespace isostrata {
namespace {

/// The index along an axis of the cell that holds x, clamped into the grid; coordinates rise or fall.
template <class Coordinate>
std::int64_t cell_along(double x, std::int64_t points, Coordinate coordinate) {
  if (points < 2) return 0;
  const bool rising = coordinate(points - 1) > coordinate(0);
  std::int64_t low = 0, high = points - 1;  // x is past point low, or low is 0; x is before point high, or high is the last
  while (high - low > 1) {
    const std::int64_t middle = (low + high) / 2;
    const bool past = rising ? x >= coordinate(middle) : x <= coordinate(middle);
    (past ? low : high) = middle;
  }
  return low;
}

/// The eye's cell. With parallel rays the eye is infinitely far away, so that it is one at a corner of the grid.
std::array<std::uint32_t, 3> eye_cell(const Grid& grid, const Camera& camera) {
  std::array<std::uint32_t, 3> cell{};
  const auto dims = grid.dims();
  const Vec3d back = camera.eye - camera.at;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const double infinite = std::numeric_limits<double>::infinity() * (back[axis] < 0 ? -1 : 1);
    const double x = camera.orthographic ? infinite : camera.eye[axis];
    const auto coordinate = [&](std::int64_t i) {
      if (const auto* uniform = std::get_if<UniformGrid>(&grid.shape))
        return uniform->origin[axis] + static_cast<double>(i) * uniform->spacing[axis];
      return std::get<RectilinearGrid>(grid.shape).axes[a][static_cast<std::size_t>(i)];
    };
    cell[a] = static_cast<std::uint32_t>(cell_along(x, dims[a], coordinate));
  }
  return cell;
}

}  // namespace

TileOrder tile_order(const DrawInput& input, const TileStyles& styles, std::uint32_t key_bits) {
  const std::string groups = input.mode == RenderMode::prioritized ? "priority, then " : "";
  const auto group_bits = static_cast<std::uint32_t>(std::bit_width(styles.groups - 1));
  TileOrder order;
  if (!styles.any_order && group_bits <= key_bits) {
    order.kind = TILE_ORDER_NONE;
    order.method = groups.empty() ? "none needed" : "priority (none needed)";
    return order;
  }
  if (input.grid && input.grid->rectilinear() && (input.bricks || !input.mesh->cell_runs.empty())) {
    std::int64_t longest = 0;
    bool counted = true;  // in 16 bits
    for (const std::int64_t points : input.grid->dims()) {
      longest += std::max<std::int64_t>(0, points - 2);
      counted = counted && points <= 65536;
    }
    const auto depth_bits = static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(longest)));
    if (counted && depth_bits + group_bits <= key_bits) {
      order.kind = TILE_ORDER_INDEX;
      order.eye_cell = eye_cell(*input.grid, input.camera);
      order.depth_bits = depth_bits;
      order.method = groups + "index distance";
      return order;
    }
  }
  if (input.bricks)
    throw Error(ErrorCode::too_large, "picture: the order of its cells is longer than the device's keys: extract on the CPU");
  VisibilityOrder sorted = order_groups(input);
  order.kind = TILE_ORDER_LIST;
  std::reverse(sorted.tetrahedra.begin(), sorted.tetrahedra.end());
  order.list = std::move(sorted.tetrahedra);
  order.list_exact = sorted.exact;
  order.method = sorted.method;
  return order;
}

}  // namespace isostrata
