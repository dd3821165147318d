#include "extraction/combine/combined_normals.h"

#include "base/parallel.h"
#include "extraction/surfaces/gradient_normals.h"

namespace isostrata {

void append_directions(const Grid& grid, std::span<const PointArray* const> arrays, const IntervalMesh& mesh,
                       std::vector<Buffer<double>>& fields, const Task& task) {
  const std::size_t np = mesh.positions.size();
  for (const PointArray* array : arrays) {
    const std::vector<Vec3f> normals = gradient_normals(grid, *array, mesh, task, NormalsAt::all_points);
    for (int axis = 0; axis < 3; ++axis) {
      Buffer<double>& field = fields.emplace_back(np);
      parallel_for(static_cast<std::int64_t>(np), 1 << 15, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t p = begin; p < end; ++p) field[p] = static_cast<double>(normals[p][axis]);
      });
    }
  }
}

namespace {

Vec3f unit_direction(std::span<const Buffer<double>> directions, std::size_t point) {
  const Vec3d n{directions[0][point], directions[1][point], directions[2][point]};
  const double size = length(n);
  if (!(size > 0)) return {};  // NaN, too
  return {static_cast<float>(n.x / size), static_cast<float>(n.y / size), static_cast<float>(n.z / size)};
}

}  // namespace

std::vector<Vec3f> unit_directions(std::span<const Buffer<double>> directions) {
  std::vector<Vec3f> normals(directions[0].size());
  parallel_for(static_cast<std::int64_t>(normals.size()), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) normals[p] = unit_direction(directions, p);
  });
  return normals;
}

std::vector<Vec3f> surface_normals(const IntervalMesh& mesh, std::span<const int> array_of_range,
                                   std::span<const Buffer<double>> directions) {
  constexpr int kNone = -1, kSeveral = -2;
  std::vector<int> array_at(mesh.positions.size(), kNone);
  for (const BoundaryFacet& facet : mesh.facets) {
    if (facet.label == FacetLabel::domain) continue;
    const int array = array_of_range[facet.range];
    for (const std::uint32_t p : facet.points)
      if (array_at[p] != array) array_at[p] = array_at[p] == kNone ? array : kSeveral;
  }
  std::vector<Vec3f> normals(array_at.size());
  parallel_for(static_cast<std::int64_t>(normals.size()), 1 << 14, [&](std::int64_t begin, std::int64_t end) {
    for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p)
      if (array_at[p] >= 0) normals[p] = unit_direction(directions.subspan(static_cast<std::size_t>(3 * array_at[p]), 3), p);
  });
  return normals;
}

}  // namespace isostrata
