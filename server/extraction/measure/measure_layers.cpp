#include "extraction/measure/measure_layers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "extraction/measure/principal_axes.h"

namespace isostrata {
namespace {

constexpr std::int64_t kBlock = 1 << 16;  // elements whose sums are made apart
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// xx, yy, zz, xy, xz, yz.
using Moments = std::array<double, 6>;

void add_square(Moments& moments, Vec3d p, double weight) {
  moments[0] += weight * p.x * p.x, moments[1] += weight * p.y * p.y, moments[2] += weight * p.z * p.z;
  moments[3] += weight * p.x * p.y, moments[4] += weight * p.x * p.z, moments[5] += weight * p.y * p.z;
}

/// Of values less a first one, so that a large offset costs no digits. A simplex with a value that is not finite counts for nothing.
struct ArraySums {
  double min = kInfinity, max = -kInfinity, size = 0, first = 0, second = 0;
};

/// About an origin near the mesh, so that large coordinates cost no digits.
struct Sums {
  std::int64_t elements = 0;
  double size = 0;  // volumes, or areas
  Vec3d first{};
  Moments second{};
  Box3d box;
  std::vector<ArraySums> of;

  void add(const Sums& other) {
    elements += other.elements;
    size += other.size;
    first = first + other.first;
    for (std::size_t i = 0; i < second.size(); ++i) second[i] += other.second[i];
    if (!other.box.empty()) box.include(other.box.lower), box.include(other.box.upper);
    for (std::size_t i = 0; i < of.size(); ++i) {
      of[i].min = std::min(of[i].min, other.of[i].min);
      of[i].max = std::max(of[i].max, other.of[i].max);
      of[i].size += other.of[i].size;
      of[i].first += other.of[i].first;
      of[i].second += other.of[i].second;
    }
  }
};

/// A simplex of n points, of this signed size: integrals of what is linear in it. 1 / (n (n + 1)): of x x^T, from those of products of two barycentric coordinates.
template <std::size_t n>
void add_simplex(Sums& sums, const IntervalMesh& mesh, std::span<const MeshArray> arrays, std::span<const double> offsets, const std::array<std::uint32_t, n>& points,
                 std::uint64_t element, double size, Vec3d origin) {
  constexpr double kShare = 1.0 / (n * (n + 1));
  ++sums.elements;
  sums.size += size;
  Vec3d sum{};
  for (const std::uint32_t point : points) {
    const Vec3d p = mesh.positions[point] - origin;
    sum = sum + p;
    add_square(sums.second, p, size * kShare);
    sums.box.include(mesh.positions[point]);
  }
  add_square(sums.second, sum, size * kShare);
  sums.first = sums.first + sum * (size / n);
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const std::vector<float>& values = arrays[i].values;
    ArraySums& of = sums.of[i];
    double least = kInfinity, most = -kInfinity, total = 0, squares = 0;
    const auto take = [&](float value) {
      least = std::min<double>(least, value);
      most = std::max<double>(most, value);
      const double off = value - offsets[i];
      total += off;
      squares += off * off;
    };
    if (arrays[i].in_cells)
      take(values[element]);
    else
      for (const std::uint32_t point : points) take(values[point]);
    if (!std::isfinite(total)) continue;
    of.min = std::min(of.min, least);
    of.max = std::max(of.max, most);
    of.size += size;
    of.first += arrays[i].in_cells ? size * total : size * total / n;
    of.second += arrays[i].in_cells ? size * squares : size * kShare * (squares + total * total);
  }
}

double area_of(const IntervalMesh& mesh, const std::array<std::uint32_t, 3>& p) {
  return length(cross(mesh.positions[p[1]] - mesh.positions[p[0]], mesh.positions[p[2]] - mesh.positions[p[0]])) / 2;
}

/// add(row, sums) of each element; rows are those that `row_of` says.
class Summing {
 public:
  Summing(const IntervalMesh& mesh, std::span<const MeshArray> arrays, const Components* components) : mesh_(mesh), arrays_(arrays), components_(components) {
    nothing_.of.resize(arrays.size());
    if (!mesh.positions.empty()) origin_ = mesh.positions[0];
    for (const MeshArray& array : arrays) {
      const auto finite = std::find_if(array.values.begin(), array.values.end(), [](float value) { return std::isfinite(value); });
      offsets_.push_back(finite == array.values.end() ? 0.0 : *finite);
    }
  }
  std::span<const double> offsets() const { return offsets_; }
  Vec3d origin() const { return origin_; }
  std::size_t rows() const { return components_ ? components_->interval.size() : mesh_.summaries.size(); }
  std::size_t row_of(std::uint64_t element, std::uint16_t interval) const { return components_ ? components_->of[element] : interval; }

  std::vector<Sums> sums(const Task& task) const {
    const bool flat = mesh_.tetrahedra.empty();
    const auto elements = static_cast<std::int64_t>(flat ? mesh_.facets.size() : mesh_.tetrahedra.size());
    std::vector<Sums> all(rows(), nothing_);
    const auto add = [&](std::int64_t begin, std::int64_t end, std::vector<Sums>& to) {
      if (begin % kBlock == 0) task.check();
      for (std::int64_t i = begin; i < end; ++i) flat ? add_triangle(static_cast<std::uint64_t>(i), to) : add_tetrahedron(static_cast<std::uint64_t>(i), to);
    };
    if (components_) {  // as many as there are, so not once for each block; what a piece has gathered is added when it is a block
      std::vector<Sums> gathered = all;
      for (std::int64_t i = 0; i < elements; ++i) {
        const std::size_t row = components_->of[static_cast<std::size_t>(i)];
        add(i, i + 1, gathered);
        if (gathered[row].elements < kBlock) continue;
        all[row].add(gathered[row]);
        gathered[row] = nothing_;
      }
      for (std::size_t row = 0; row < all.size(); ++row) all[row].add(gathered[row]);
      return all;
    }
    const std::int64_t blocks = (elements + kBlock - 1) / kBlock;
    std::vector<std::vector<Sums>> parts(static_cast<std::size_t>(blocks), all);
    parallel_for(blocks, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t block = begin; block < end; ++block) add(block * kBlock, std::min((block + 1) * kBlock, elements), parts[static_cast<std::size_t>(block)]);
    });
    for (const std::vector<Sums>& part : parts)
      for (std::size_t row = 0; row < all.size(); ++row) all[row].add(part[row]);
    return all;
  }

 private:
  void add_tetrahedron(std::uint64_t i, std::vector<Sums>& to) const {
    const auto& p = mesh_.tetrahedra[i];
    const auto& x = mesh_.positions;
    add_simplex(to[row_of(i, mesh_.tetrahedron_interval[i])], mesh_, arrays_, offsets_, p, i, orient3d(x[p[0]], x[p[1]], x[p[2]], x[p[3]]) / 6, origin_);
  }
  void add_triangle(std::uint64_t i, std::vector<Sums>& to) const {
    const BoundaryFacet& facet = mesh_.facets[i];
    add_simplex(to[row_of(i, facet.interval)], mesh_, arrays_, offsets_, facet.points, i, area_of(mesh_, facet.points), origin_);
  }

  const IntervalMesh& mesh_;
  std::span<const MeshArray> arrays_;
  const Components* components_;
  Vec3d origin_{};
  std::vector<double> offsets_;  // of the arrays
  Sums nothing_;
};

/// [facets] Whether another layer has the same facet. Domain facets have none.
std::vector<bool> touching(const IntervalMesh& mesh, const Task& task) {
  struct Key {
    std::array<std::uint32_t, 3> points;
    std::uint32_t facet;
  };
  std::vector<bool> touches(mesh.facets.size());
  if (mesh.summaries.size() < 2) return touches;
  std::vector<Key> keys;
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    if (mesh.facets[i].label == FacetLabel::domain) continue;
    keys.push_back({mesh.facets[i].points, static_cast<std::uint32_t>(i)});
    std::sort(keys.back().points.begin(), keys.back().points.end());
  }
  task.check();
  std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) { return a.points < b.points; });
  task.check();
  for (std::size_t i = 1; i < keys.size(); ++i)
    if (keys[i].points == keys[i - 1].points && mesh.facets[keys[i].facet].interval != mesh.facets[keys[i - 1].facet].interval)
      touches[keys[i].facet] = touches[keys[i - 1].facet] = true;
  return touches;
}

void add_areas(const IntervalMesh& mesh, const Summing& summing, std::vector<LayerMeasure>& rows, const Task& task) {
  const std::vector<bool> touches = touching(mesh, task);
  for (std::size_t i = 0; i < mesh.facets.size(); ++i) {
    const BoundaryFacet& facet = mesh.facets[i];
    LayerArea& area = rows[summing.row_of(facet.tetrahedron, facet.interval)].area;
    const double size = area_of(mesh, facet.points);
    (facet.label == FacetLabel::lower ? area.lower : facet.label == FacetLabel::upper ? area.upper : area.domain) += size;
    if (touches[i]) area.contact += size;
  }
}

ArrayMeasure measure_of(const ArraySums& of, double offset) {
  if (of.size == 0) return {};
  const double mean = of.first / of.size;
  return {of.min, offset + mean, of.max, offset * of.size + of.first, std::sqrt(std::max(of.second / of.size - mean * mean, 0.0)), of.size};
}

LayerMeasure measure_of(const Sums& sums, std::span<const double> offsets, Vec3d origin, bool flat) {
  LayerMeasure row;
  row.tetrahedra = flat ? 0 : sums.elements;
  (flat ? row.area.domain : row.volume) = sums.size;
  row.bounds = sums.box;
  for (std::size_t i = 0; i < sums.of.size(); ++i) row.of.push_back(measure_of(sums.of[i], offsets[i]));
  if (sums.size == 0) return row;
  const Vec3d centre = sums.first / sums.size;
  row.centroid = origin + centre;
  Moments about = sums.second;
  for (double& moment : about) moment /= sums.size;
  add_square(about, centre, -1);
  row.axes = principal_axes(about);
  return row;
}

}  // namespace

std::vector<LayerMeasure> measure_layers(const IntervalMesh& mesh, std::span<const MeshArray> arrays, const Components* components, const Task& task) {
  const bool flat = mesh.tetrahedra.empty();
  const Summing summing(mesh, arrays, components);
  std::vector<LayerMeasure> rows;
  for (const Sums& sums : summing.sums(task)) {
    rows.push_back(measure_of(sums, summing.offsets(), summing.origin(), flat));
    const std::size_t row = rows.size() - 1;
    rows.back().interval = components ? components->interval[row] : static_cast<std::uint16_t>(row);
    if (components) rows.back().component = static_cast<std::uint32_t>(row);
  }
  if (!flat) add_areas(mesh, summing, rows, task);
  return rows;
}

}  // namespace isostrata
