#include "import/imported/place_image.h"

#include <cmath>

namespace isostrata {

void place_image(Block& block, const std::array<std::int64_t, 3>& dims, const std::array<double, 3>& origin,
                 const std::array<std::array<double, 3>, 3>& step, const std::string& name) {
  bool straight = true;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t a = 0; a < 3; ++a) {
      straight = straight && (i == a) == (step[i][a] != 0);
      if (!std::isfinite(step[i][a]) || !std::isfinite(origin[a]))
        throw Error(ErrorCode::bad_data, name + ": a place or a direction in space is not a finite number");
    }
  if (straight) {
    UniformGrid uniform;
    uniform.dims = dims;
    uniform.origin = {origin[0], origin[1], origin[2]};
    uniform.spacing = {step[0][0], step[1][1], step[2][2]};
    block.grid.shape = uniform;
    return;
  }
  for (const auto& one : step)
    if (one == std::array<double, 3>{0, 0, 0}) throw Error(ErrorCode::bad_data, name + ": a space direction of (0,0,0)");
  const auto n = static_cast<std::size_t>(checked_product({dims[0], dims[1], dims[2]}, name));
  auto [storage, points] = allocate<Vec3d>(n);
  std::size_t at = 0;
  for (std::int64_t k = 0; k < dims[2]; ++k)
    for (std::int64_t j = 0; j < dims[1]; ++j)
      for (std::int64_t i = 0; i < dims[0]; ++i, ++at)
        for (std::size_t a = 0; a < 3; ++a)
          points[at][static_cast<int>(a)] = origin[a] + static_cast<double>(i) * step[0][a] + static_cast<double>(j) * step[1][a] +
                                            static_cast<double>(k) * step[2][a];
  block.grid.shape = CurvilinearGrid{dims, std::span<const Vec3d>(points)};
  block.grid.storage = storage;
}

}  // namespace isostrata
