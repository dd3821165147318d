#include "random/random_grids.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "data/dataset/analytic.h"
#include "data/grids/hull_faces.h"
#include "data/grids/split_polyhedron.h"
#include "support/edge_points_of.h"
#include "support/refined_cubes.h"
#include "support/truncated_cubes.h"
#include "support/voronoi_cells.h"
#include "support/whole_number_hull.h"
#include "tables/lattice_cell.h"

namespace isostrata::random_test {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double uniform(Random& random, double lower, double upper) {
  return std::uniform_real_distribution<double>(lower, upper)(random);
}
std::int64_t below(Random& random, std::int64_t n) { return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n)); }
bool one_in(Random& random, std::int64_t n) { return below(random, n) == 0; }

/// How the values of one input are drawn, so that ties and large numbers occur in numbers.
struct ValueKind {
  int kind = 0;  // 0 real, 1 few integers, 2 large, 3 tiny differences
  explicit ValueKind(Random& random) : kind(static_cast<int>(below(random, 4))) {}
  double draw(Random& random) const {
    switch (kind) {
      case 0:
        return uniform(random, -1, 1);
      case 1:
        return static_cast<double>(below(random, 6));
      case 2:
        return uniform(random, -1, 1) * 1e150;
      default:
        return 1 + static_cast<double>(below(random, 9)) * std::numeric_limits<double>::epsilon();
    }
  }
};

double not_finite(Random& random) { return one_in(random, 2) ? kNaN : one_in(random, 2) ? kInfinity : -kInfinity; }

/// Between the least and the greatest finite value, some ends being values.
std::vector<Interval> random_intervals(const std::vector<double>& values, bool tile, Random& random) {
  double least = kInfinity, most = -kInfinity;
  std::vector<double> finite;
  for (const double v : values) {
    if (!std::isfinite(v)) continue;
    finite.push_back(v);
    least = std::min(least, v);
    most = std::max(most, v);
  }
  if (finite.empty()) return {{0, 1}};
  const auto end = [&] {
    return one_in(random, 2) ? finite[static_cast<std::size_t>(below(random, static_cast<std::int64_t>(finite.size())))]
                             : uniform(random, least, most);
  };
  const std::int64_t count = 1 + below(random, 4);
  std::vector<Interval> out;
  if (tile) {
    std::vector<double> ends{least, most};
    for (std::int64_t i = 1; i < count; ++i) ends.push_back(end());
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    if (ends.size() == 1) ends.push_back(std::nextafter(ends[0], kInfinity));
    out = tiling(ends);
  } else {
    for (std::int64_t i = 0; i < count; ++i) {
      const double a = end(), b = end();
      if (a != b) out.push_back({std::min(a, b), std::max(a, b)});
    }
    if (out.empty()) out.push_back({least, std::nextafter(most, kInfinity)});
  }
  std::shuffle(out.begin(), out.end(), random);
  return out;
}

/// The values in one of the types that hold them, so that every instance of the code runs.
PointArray typed_array(const std::vector<double>& values, const ValueKind& kind, std::string name, Random& random) {
  if (kind.kind == 1 && std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) {
    const auto as = [&]<class T>(T) { return point_array(std::vector<T>(values.begin(), values.end()), name); };
    switch (below(random, 5)) {
      case 0:
        return as(std::uint8_t{});
      case 1:
        return as(std::int16_t{});
      case 2:
        return as(std::uint32_t{});
      case 3:
        return as(std::int64_t{});
      default:
        return as(float{});
    }
  }
  return point_array(values, std::move(name));
}

/// Fills in arrays and intervals.
void add_values(RandomInput& input, std::vector<double> values, const ValueKind& kind, Random& random) {
  input.expectation.tiles = one_in(random, 2);
  input.intervals = random_intervals(values, input.expectation.tiles, random);
  std::vector<double> second(values.size());
  const ValueKind other(random);
  for (double& v : second) v = other.draw(random);
  input.array = typed_array(values, kind, "f", random);
  input.second = typed_array(second, other, "g", random);
}

std::vector<double> draw_values(std::int64_t count, const ValueKind& kind, std::int64_t one_broken_in, Random& random) {
  std::vector<double> values(static_cast<std::size_t>(count));
  for (double& v : values) v = one_broken_in > 0 && one_in(random, one_broken_in) ? not_finite(random) : kind.draw(random);
  return values;
}

Vec3d random_vector(Random& random) { return {uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1)}; }

/// Columns of an affine map, in one of several awkward shapes.
std::array<Vec3d, 3> random_frame(Random& random) {
  std::array<Vec3d, 3> frame{random_vector(random), random_vector(random), random_vector(random)};
  switch (below(random, 8)) {
    case 0:  // sliver
      frame[2] = frame[2] * 1e-7;
      break;
    case 1:  // flat
      frame[2] = frame[0] * 0.5 + frame[1] * 0.25;
      break;
    case 2:  // needle
      frame[1] = frame[1] * 1e-6;
      frame[2] = frame[2] * 1e-6;
      break;
    case 3:  // a unit cell, mirrored or not
      frame = {Vec3d{one_in(random, 2) ? 1.0 : -1.0, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
      break;
    default:
      break;
  }
  return frame;
}

std::vector<Vec3d> model_points(CellType type) {
  std::vector<Vec3d> points;
  for (const LatticePoint& p : lattice_cell(type).vertices)
    points.push_back({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])});
  return points;
}

/// Moves inner points of [0, dims] by up to `most` along each axis.
void move_inner_points(std::vector<Vec3d>& points, const Vec3d& dims, double most, Random& random) {
  for (Vec3d& p : points) {
    bool inner = true;
    for (int axis = 0; axis < 3; ++axis) inner = inner && p[axis] > 1e-9 && p[axis] < dims[axis] - 1e-9;
    if (inner) p = p + random_vector(random) * most;
  }
}

UnstructuredParts renumbered(UnstructuredParts parts, Random& random) {
  const auto numbers = random_numbers(static_cast<std::int64_t>(parts.points.size()), random);
  std::vector<Vec3d> points(parts.points.size());
  for (std::size_t p = 0; p < points.size(); ++p) points[static_cast<std::size_t>(numbers[p])] = parts.points[p];
  parts.points = std::move(points);
  for (std::int64_t& id : parts.connectivity) id = numbers[static_cast<std::size_t>(id)];
  return parts;
}

UnstructuredParts split_polyhedra(const test::PolyhedralMesh& mesh) {
  UnstructuredParts parts;
  parts.points = mesh.points;
  const EdgePoints edge_points = test::edge_points_of(mesh);
  PolyhedronSplit split;
  for (const auto& cell : mesh.cells) {
    split_polyhedron(
        test::faces_of(cell), [&](std::int64_t id) { return parts.points[static_cast<std::size_t>(id)]; }, edge_points, split);
    if (split.kind == SplitKind::open) throw BrokenLaw("a polyhedron is not closed");
    if (split.kind == SplitKind::overlapping) throw BrokenLaw("no point sees all faces of a polyhedron");
    std::size_t at = 0;
    for (const CellType type : split.types) {
      std::vector<std::int64_t> ids;
      for (int v = 0; v < topology(type).vertex_count; ++v, ++at)
        ids.push_back(split.connectivity[at] == kAddedPoint ? static_cast<std::int64_t>(parts.points.size())
                                                            : split.connectivity[at]);
      parts.add(type, ids);
    }
    if (split.kind != SplitKind::whole) parts.points.push_back(split.added);
  }
  return parts;
}

}  // namespace

RandomInput isolated_cells(CellType type, std::int64_t count, bool bent, Random& random) {
  RandomInput input;
  const std::vector<Vec3d> model = model_points(type);
  const auto n = static_cast<std::int64_t>(model.size());
  const auto numbers = random_numbers(count * n, random);
  const ValueKind kind(random);
  UnstructuredParts parts;
  parts.points.resize(static_cast<std::size_t>(count * n));
  std::vector<double> values(parts.points.size());
  const bool some_broken = one_in(random, 2);
  for (std::int64_t c = 0; c < count; ++c) {
    const auto frame = random_frame(random);
    const Vec3d origin = random_vector(random) * (one_in(random, 8) ? 50.0 : 1.0);
    const bool constant = one_in(random, 10);
    const double value = kind.draw(random);
    const bool broken_value = some_broken && one_in(random, 50), broken_point = some_broken && one_in(random, 50);
    const std::int64_t which = below(random, n);
    std::vector<std::int64_t> ids;
    for (std::int64_t v = 0; v < n; ++v) {
      const auto id = numbers[static_cast<std::size_t>(c * n + v)];
      const Vec3d& m = model[static_cast<std::size_t>(v)];
      Vec3d p = origin + frame[0] * m.x + frame[1] * m.y + frame[2] * m.z;
      if (bent) p = p + random_vector(random) * 0.3;
      if (broken_point && v == which) p[static_cast<int>(below(random, 3))] = not_finite(random);
      parts.points[static_cast<std::size_t>(id)] = p;
      values[static_cast<std::size_t>(id)] = broken_value && v == which ? not_finite(random)
                                             : constant                 ? value
                                                                        : kind.draw(random);
      ids.push_back(id);
    }
    parts.add(type, ids);
  }
  input.grid = unstructured_grid(std::move(parts));
  input.expectation.flat_faces = !bent;
  input.expectation.isolated = true;
  input.expectation.scale = 60;
  add_values(input, std::move(values), kind, random);
  return input;
}

RandomInput glued_cells(Random& random) {
  RandomInput input;
  const auto any_type = [&] { return kCellTypes[static_cast<std::size_t>(below(random, 4))]; };
  CellType first = any_type(), second = any_type();
  const CellFace *face = nullptr, *other = nullptr;
  do {
    first = any_type();
    second = any_type();
    const auto any_face = [&](CellType type) {
      const auto faces = topology(type).faces;
      return &faces[static_cast<std::size_t>(below(random, static_cast<std::int64_t>(faces.size())))];
    };
    face = any_face(first);
    other = any_face(second);
  } while (face->size != other->size);

  // The affine map that takes three points of the face to their partners and the second cell's middle to the other side.
  const std::vector<Vec3d> at = model_points(first), local = model_points(second);
  const auto middle = [](const std::vector<Vec3d>& points) {
    Vec3d sum;
    for (const Vec3d& p : points) sum = sum + p;
    return sum / static_cast<double>(points.size());
  };
  const auto size = static_cast<std::size_t>(face->size), turn = static_cast<std::size_t>(below(random, face->size));
  const auto own = [&](std::size_t i) { return static_cast<std::size_t>(other->vertex[(turn + size - i) % size]); };
  const auto theirs = [&](std::size_t i) { return static_cast<std::size_t>(face->vertex[i]); };
  const Vec3d base = local[own(0)], to = at[theirs(0)];
  const Vec3d u = local[own(1)] - base, v = local[own(2)] - base, w = middle(local) - base;
  const Vec3d tu = at[theirs(1)] - to, tv = at[theirs(2)] - to;
  const Vec3d tw = to - middle(at) + tu * uniform(random, -0.3, 0.3) + tv * uniform(random, -0.3, 0.3);
  const double determinant = dot(cross(u, v), w);

  const auto numbers = random_numbers(static_cast<std::int64_t>(at.size() + local.size() - size), random);
  UnstructuredParts parts;
  parts.points.resize(numbers.size());
  std::vector<std::int64_t> ids(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(at.size())),
      glued(local.size(), -1);
  for (std::size_t p = 0; p < at.size(); ++p) parts.points[static_cast<std::size_t>(ids[p])] = at[p];
  for (std::size_t i = 0; i < size; ++i) glued[own(i)] = ids[theirs(i)];
  std::size_t next = at.size();
  for (std::size_t p = 0; p < local.size(); ++p) {
    if (glued[p] < 0) glued[p] = numbers[next++];
    const Vec3d d = local[p] - base;
    parts.points[static_cast<std::size_t>(glued[p])] =
        to + (tu * dot(cross(d, v), w) + tv * dot(cross(u, d), w) + tw * dot(cross(u, v), d)) / determinant;
  }
  parts.add(first, ids);
  parts.add(second, glued);
  input.grid = unstructured_grid(std::move(parts));
  input.expectation.flat_faces = true;
  input.expectation.scale = 8;
  const ValueKind kind(random);
  add_values(input, draw_values(input.grid.point_count(), kind, 100, random), kind, random);
  return input;
}

RandomInput mixed_mesh(Random& random) {
  RandomInput input;
  UnstructuredParts parts;
  double whole = 8;
  switch (below(random, 3)) {
    case 0: {
      const std::array<std::int64_t, 3> cubes{1 + below(random, 3), 1 + below(random, 3), 1 + below(random, 3)};
      test::PolyhedralMesh mesh = test::truncated_cubes(cubes, random());
      whole = mesh.volume;
      move_inner_points(mesh.points, {double(cubes[0]), double(cubes[1]), double(cubes[2])}, 0.05, random);
      parts = split_polyhedra(mesh);
      break;
    }
    default: {
      const std::int64_t n = 5 + below(random, 3);
      const Task task;
      parts = as_parts(make_analytic((one_in(random, 4) ? "tets:" : "mixed:") + std::to_string(n), {}, task)->grid);
      for (Vec3d& p : parts.points) p = p + Vec3d{1, 1, 1};
      move_inner_points(parts.points, {2, 2, 2}, 0.1 / static_cast<double>(n), random);
    }
  }
  input.grid = unstructured_grid(renumbered(std::move(parts), random));
  const bool damaged = one_in(random, 2);  // hidden cells, values that are not finite
  if (damaged) {
    auto hidden = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(input.grid.cell_count()));
    for (auto& h : *hidden) h = one_in(random, 10);
    input.grid.hidden_cells = *hidden;
    input.grid.storage =
        std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(input.grid.storage, hidden);
  }
  input.expectation.scale = 8;
  if (!damaged) input.expectation.whole = whole;  // the boundary is plane: how faces are cut does not matter
  const ValueKind kind(random);
  add_values(input, draw_values(input.grid.point_count(), kind, damaged ? 200 : 0, random), kind, random);
  return input;
}

RandomInput polyhedra(Random& random) {
  test::PolyhedralMesh mesh;
  const auto any_three = [&] { return std::array<std::int64_t, 3>{1 + below(random, 3), 1 + below(random, 3), 1 + below(random, 3)}; };
  const std::int64_t which = below(random, 3);
  bool flat_faces = true;
  if (which == 0) {
    mesh = test::voronoi_cells(any_three(), random());
  } else if (which == 1) {
    flat_faces = one_in(random, 2);
    mesh = test::refined_cubes(any_three(), random(), flat_faces ? 0 : uniform(random, 0, 0.06));
  } else {
    PolyhedronFaces faces;
    for (std::int64_t cell = 0; cell < 20; ++cell) {
      const std::int64_t most = std::int64_t{1} << (1 + below(random, 5));
      std::vector<test::WholePoint> whole(static_cast<std::size_t>(4 + below(random, 16)));
      std::vector<Vec3d> points;
      std::vector<std::int64_t> ids;
      for (test::WholePoint& p : whole) {
        for (std::int64_t& x : p) x = below(random, most + 1);
        points.push_back(Vec3d{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])} /
                         static_cast<double>(most));
        ids.push_back(static_cast<std::int64_t>(mesh.points.size() + ids.size()));
      }
      mesh.points.insert(mesh.points.end(), points.begin(), points.end());
      const double scale = static_cast<double>(most) * static_cast<double>(most) * static_cast<double>(most);
      mesh.volume += static_cast<double>(test::six_hull_volumes(whole)) / (6 * scale);
      hull_faces(points, ids, faces);
      if (faces.size() == 0) continue;
      auto& cycles = mesh.cells.emplace_back();
      for (std::size_t f = 0; f < faces.size(); ++f) cycles.emplace_back(faces.face(f).begin(), faces.face(f).end());
    }
  }
  RandomInput input;
  input.grid = unstructured_grid(renumbered(split_polyhedra(mesh), random));
  input.expectation.flat_faces = flat_faces;
  input.expectation.scale = 8;
  input.expectation.whole = mesh.volume;
  const ValueKind kind(random);
  add_values(input, draw_values(input.grid.point_count(), kind, 0, random), kind, random);
  return input;
}

RandomInput structured_grid(Random& random) {
  RandomInput input;
  std::array<std::int64_t, 3> dims{1 + below(random, 7), 1 + below(random, 7), 1 + below(random, 7)};
  if (std::count(dims.begin(), dims.end(), 1) == 1) std::replace(dims.begin(), dims.end(), 1, 2);  // a flat grid is cut as areas
  const std::int64_t count = dims[0] * dims[1] * dims[2];
  const auto sign = [&] { return one_in(random, 3) ? -1.0 : 1.0; };
  switch (below(random, 3)) {
    case 0:
      input.grid = uniform_grid(dims, random_vector(random), {sign() * 0.5, sign(), sign() * uniform(random, 0.01, 1)});
      input.expectation.flat_faces = true;
      break;
    case 1: {
      RectilinearGrid shape;
      shape.dims = dims;
      for (std::size_t a = 0; a < 3; ++a) {
        const double direction = sign();
        double at = uniform(random, -1, 1);
        for (std::int64_t i = 0; i < dims[a]; ++i, at += direction * uniform(random, 0.01, 1)) shape.axes[a].push_back(at);
      }
      input.grid = {std::move(shape), {}, nullptr};
      input.expectation.flat_faces = true;
      break;
    }
    default: {
      std::vector<Vec3d> points;
      for (std::int64_t p = 0; p < count; ++p) {
        points.push_back({double(p % dims[0]), double(p / dims[0] % dims[1]), double(p / dims[0] / dims[1])});
        points.back() = points.back() + random_vector(random) * 0.2;
        if (one_in(random, 300)) points.back().y = not_finite(random);
      }
      input.grid = curvilinear_grid(dims, std::move(points));
    }
  }
  if (one_in(random, 2)) {
    auto hidden = std::make_shared<std::vector<std::uint8_t>>(static_cast<std::size_t>(input.grid.cell_count()));
    for (auto& h : *hidden) h = one_in(random, 5);
    input.grid.hidden_cells = *hidden;
    input.grid.storage =
        std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(input.grid.storage, hidden);
  }
  input.expectation.scale = 16;
  const ValueKind kind(random);
  add_values(input, draw_values(count, kind, one_in(random, 2) ? 200 : 0, random), kind, random);
  return input;
}

}  // namespace isostrata::random_test
