// Small meshes of every kind of cell, for tests: conforming, of a known volume, as text that VTK's readers take.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "support/truncated_cubes.h"
#include "support/vtk_text.h"

namespace isostrata::testing {

struct SampleMesh {
  std::string name;
  VtuText vtu;
  double volume = 0;
};

/// Point arrays "distance" (from a point off the middle), "slope" and "ties" (few whole numbers), and a cell array "cell".
inline void add_sample_arrays(VtuText& vtu, double shift = 0) {
  Vec3d lower = vtu.points.front(), upper = lower;
  for (const Vec3d& p : vtu.points)
    for (int a = 0; a < 3; ++a) lower[a] = std::min(lower[a], p[a]), upper[a] = std::max(upper[a], p[a]);
  std::vector<float> distance;
  std::vector<double> slope;
  std::vector<int> ties, cell;
  for (const Vec3d& p : vtu.points) {
    Vec3d u;  // in [0, 1]: meshes may be flat
    for (int a = 0; a < 3; ++a) u[a] = upper[a] > lower[a] ? (p[a] - lower[a]) / (upper[a] - lower[a]) : 0;
    distance.push_back(static_cast<float>(length(u - Vec3d{0.4 + shift, 0.55, 0.45})));
    slope.push_back(1 + 2 * u.x - 3 * u.y + 0.5 * u.z);
    ties.push_back(static_cast<int>(std::floor(3 * u.x + 2 * u.y * u.y + 2 * u.z)));
  }
  for (std::size_t c = 0; c < vtu.types.size(); ++c) cell.push_back(static_cast<int>(c * 7 % 11));
  vtu.point_array("distance", "Float32", distance);
  vtu.point_array("slope", "Float64", slope);
  vtu.point_array("ties", "UInt8", ties);
  vtu.cell_array("cell", "Int32", cell);
}

/// The points of n x n x n unit cubes, those inside moved by up to `moved`, and who has which number.
class CubeLattice {
 public:
  CubeLattice(VtuText& vtu, int n, double moved, std::uint64_t seed = 1) : vtu_(vtu), n_(n) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> by(-moved, moved);
    for (int k = 0; k <= n; ++k)
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          const bool inside = i > 0 && j > 0 && k > 0 && i < n && j < n && k < n;
          vtu.points.push_back(Vec3d{double(i), double(j), double(k)} + (inside ? Vec3d{by(random), by(random), by(random)} : Vec3d{}));
        }
  }
  /// VTK's eight corners of each cube.
  std::vector<std::array<std::int64_t, 8>> cubes() const {
    std::vector<std::array<std::int64_t, 8>> out;
    for (int k = 0; k < n_; ++k)
      for (int j = 0; j < n_; ++j)
        for (int i = 0; i < n_; ++i)
          out.push_back({at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k), at(i, j, k + 1), at(i + 1, j, k + 1),
                         at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1)});
    return out;
  }
  /// The middle of some points, as a point of its own: the same for the same points.
  std::int64_t middle(std::vector<std::int64_t> of) {
    std::sort(of.begin(), of.end());
    const auto [entry, fresh] = middles_.try_emplace(of, static_cast<std::int64_t>(vtu_.points.size()));
    if (fresh) {
      Vec3d sum{};
      for (const std::int64_t id : of) sum = sum + vtu_.points[static_cast<std::size_t>(id)];
      vtu_.points.push_back((1.0 / static_cast<double>(of.size())) * sum);
    }
    return entry->second;
  }

 private:
  std::int64_t at(int i, int j, int k) const { return i + (n_ + 1) * (j + (n_ + 1) * std::int64_t{k}); }
  VtuText& vtu_;
  int n_;
  std::map<std::vector<std::int64_t>, std::int64_t> middles_;
};

/// H. W. Kuhn's six tetrahedra about a cube's diagonal.
inline std::vector<std::array<std::int64_t, 4>> kuhn_tetrahedra(const std::array<std::int64_t, 8>& cube) {
  std::vector<std::array<std::int64_t, 4>> out;
  for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
    out.push_back({cube[0], cube[a], cube[b], cube[6]});
  return out;
}

/// One mesh of each kind; `n` cubes along each side.
inline std::vector<SampleMesh> sample_meshes(int n = 4) {
  std::vector<SampleMesh> out;
  const double cubes = n * n * n;
  const auto lattice = [&](const std::string& name, double moved, const auto& add_cells) {
    SampleMesh mesh{name, {}, cubes};
    CubeLattice points(mesh.vtu, n, moved);
    std::size_t number = 0;
    for (const auto& cube : points.cubes()) add_cells(mesh.vtu, points, cube, number++);
    out.push_back(std::move(mesh));
  };
  using Cube = std::array<std::int64_t, 8>;
  const auto hexahedron = [](const Cube& c, bool mirrored) {
    std::vector<std::int64_t> ids(c.begin(), c.end());
    if (mirrored) std::rotate(ids.begin(), ids.begin() + 4, ids.end());
    return ids;
  };
  lattice("hexahedra", 0.2, [&](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t) { vtu.add(12, hexahedron(c, false)); });
  lattice("left_handed", 0.2, [&](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t) { vtu.add(12, hexahedron(c, true)); });
  lattice("both_handed", 0.2,
          [&](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t i) { vtu.add(12, hexahedron(c, i % 3 == 0)); });
  lattice("voxels", 0, [](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t) {
    vtu.add(11, {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]});
  });
  lattice("tetrahedra", 0.1, [](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t) {
    for (const auto& t : kuhn_tetrahedra(c)) vtu.add(10, {t.begin(), t.end()});
  });
  lattice("wedges", 0, [](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t) {
    vtu.add(13, {c[0], c[1], c[2], c[4], c[5], c[6]});
    vtu.add(13, {c[0], c[2], c[3], c[4], c[6], c[7]});
  });
  const auto pyramids = [](VtuText& vtu, CubeLattice& points, const Cube& c) {
    const std::int64_t tip = points.middle({c.begin(), c.end()});
    for (const auto& f : std::vector<std::array<std::size_t, 4>>{
             {0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}})
      vtu.add(14, {c[f[0]], c[f[1]], c[f[2]], c[f[3]], tip});
  };
  lattice("pyramids", 0.1, [&](VtuText& vtu, CubeLattice& points, const Cube& c, std::size_t) { pyramids(vtu, points, c); });
  // Columns of wedges, whose triangles meet only each other, among hexahedra and pyramids; and cells that have no volume.
  lattice("mixed", 0, [&](VtuText& vtu, CubeLattice& points, const Cube& c, std::size_t i) {
    const std::size_t side = static_cast<std::size_t>(n), x = i % side, y = i / side % side, z = i / (side * side);
    if ((x + y) % 3 == 0) {
      vtu.add(13, {c[0], c[1], c[2], c[4], c[5], c[6]});
      vtu.add(13, {c[0], c[2], c[3], c[4], c[6], c[7]});
    } else if ((x + z) % 2 == 0) {
      pyramids(vtu, points, c);
    } else {
      vtu.add(12, {c.begin(), c.end()});
    }
    if (i % 5 == 0) vtu.add(3, {c[0], c[6]});
    if (i % 7 == 0) vtu.add(1, {c[0]});
  });
  lattice("quadratic_hexahedra", 0, [](VtuText& vtu, CubeLattice& points, const Cube& c, std::size_t) {
    std::vector<std::int64_t> ids(c.begin(), c.end());
    for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{
             {0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}})
      ids.push_back(points.middle({c[a], c[b]}));
    vtu.add(25, ids);
  });
  lattice("quadratic_tetrahedra", 0, [](VtuText& vtu, CubeLattice& points, const Cube& c, std::size_t) {
    for (const auto& t : kuhn_tetrahedra(c)) {
      std::vector<std::int64_t> ids(t.begin(), t.end());
      for (const auto& [a, b] : std::vector<std::pair<std::size_t, std::size_t>>{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}})
        ids.push_back(points.middle({t[a], t[b]}));
      vtu.add(24, ids);
    }
  });
  // Ten thousand times as wide as high, every other one left-handed.
  lattice("slivers", 0.1, [](VtuText& vtu, CubeLattice&, const Cube& c, std::size_t i) {
    for (const auto& t : kuhn_tetrahedra(c)) vtu.add(10, i % 2 ? std::vector{t[1], t[0], t[2], t[3]} : std::vector{t[0], t[1], t[2], t[3]});
  });
  for (Vec3d& p : out.back().vtu.points) p.z *= 1e-4;
  out.back().volume *= 1e-4;

  SampleMesh prisms{"pentagonal_prisms", {}, 0};  // houses, upright and upside down
  std::map<std::array<int, 3>, std::int64_t> number;
  const auto place = [&](VtuText& vtu, int x, int y, int z, double unit_y) {  // in halves of x, in unit_y, in z
    const auto [entry, fresh] = number.try_emplace({x, y, z}, static_cast<std::int64_t>(vtu.points.size()));
    if (fresh) vtu.points.push_back({0.5 * x, unit_y * y, double(z)});
    return entry->second;
  };
  for (int z = 0; z < 3; ++z)
    for (int house = 0; house < 2 * n; ++house) {
      std::vector<std::array<int, 2>> outline{{0, 0}, {2, 0}, {2, 2}, {1, 3}, {0, 2}};
      if (house % 2) outline = {{1, 3}, {2, 2}, {3, 3}, {3, 5}, {1, 5}};
      std::vector<std::int64_t> ids;
      for (const int top : {0, 1})
        for (const auto& [x, y] : outline) ids.push_back(place(prisms.vtu, x + house / 2 * 2, y, z + top, 0.5));
      prisms.vtu.add(15, ids);
      prisms.volume += 1.25;
    }
  out.push_back(std::move(prisms));

  SampleMesh honeycomb{"hexagonal_prisms", {}, 0};
  number.clear();
  const double h = std::sqrt(0.75);
  for (int z = 0; z < 3; ++z)
    for (int row = 0; row < n; ++row)
      for (int column = 0; column < n; ++column) {
        std::vector<std::int64_t> ids;
        for (const int top : {0, 1})
          for (const auto& [x, y] : std::vector<std::array<int, 2>>{{2, 0}, {1, 1}, {-1, 1}, {-2, 0}, {-1, -1}, {1, -1}})
            ids.push_back(place(honeycomb.vtu, x + 3 * column, y + 2 * row + column % 2, z + top, h));
        honeycomb.vtu.add(16, ids);
        honeycomb.volume += 3 * h;
      }
  out.push_back(std::move(honeycomb));

  const auto truncated = test::truncated_cubes({3, 3, 3}, 21);
  SampleMesh polyhedra{"polyhedra", {}, truncated.volume}, hulls{"convex_point_sets", {}, truncated.volume};
  polyhedra.vtu.points = hulls.vtu.points = truncated.points;
  for (const auto& cell : truncated.cells) {
    polyhedra.vtu.add_polyhedron(cell);
    std::vector<std::int64_t> ids;
    for (const auto& face : cell) ids.insert(ids.end(), face.begin(), face.end());
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    hulls.vtu.add(41, ids);
  }
  out.push_back(std::move(polyhedra));
  out.push_back(std::move(hulls));

  for (SampleMesh& mesh : out) add_sample_arrays(mesh.vtu);
  return out;
}

}  // namespace isostrata::testing
