// A polyhedral mesh that tests can make: a lattice of cubes with their corners cut off, and what fills the corners.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "support/polyhedral_mesh.h"

namespace isostrata::test {

/// Unit cubes (i,j,k) below `cubes`: where one has a corner cut off, all that meet there have, at `depth` of their edges; the
/// corners are octahedra inside, and less of them on the boundary. Octagons, triangles, and at random whole
/// quadrilaterals too: only some corners are cut. Points are numbered at random.
inline PolyhedralMesh truncated_cubes(std::array<std::int64_t, 3> cubes, std::uint64_t seed, double depth = 1.0 / 3) {
  using Corner = std::array<std::int64_t, 3>;
  std::mt19937_64 random(seed);
  PolyhedralMesh mesh;
  std::map<Corner, bool> cut;
  for (std::int64_t k = 0; k <= cubes[2]; ++k)
    for (std::int64_t j = 0; j <= cubes[1]; ++j)
      for (std::int64_t i = 0; i <= cubes[0]; ++i) {
        const bool inside = i > 0 && j > 0 && k > 0 && i < cubes[0] && j < cubes[1] && k < cubes[2];
        cut[{i, j, k}] = inside && random() % 4 != 0;
      }
  // Points are named by six times their position where the depth is a third.
  const auto place = [&](std::int64_t six) {
    const double corner = std::round(static_cast<double>(six) / 6);
    return corner + (static_cast<double>(six) - 6 * corner) / 2 * depth;
  };
  std::map<Corner, std::int64_t> number;
  const auto point = [&](const Corner& six) {
    const auto [entry, fresh] = number.try_emplace(six, static_cast<std::int64_t>(mesh.points.size()));
    if (fresh)
      mesh.points.push_back({place(six[0]), place(six[1]), place(six[2])});
    return entry->second;
  };
  const auto towards = [](const Corner& from, const Corner& to) {
    return Corner{6 * from[0] + 2 * (to[0] - from[0]), 6 * from[1] + 2 * (to[1] - from[1]), 6 * from[2] + 2 * (to[2] - from[2])};
  };
  for (std::int64_t k = 0; k < cubes[2]; ++k)
    for (std::int64_t j = 0; j < cubes[1]; ++j)
      for (std::int64_t i = 0; i < cubes[0]; ++i) {
        std::vector<std::vector<std::int64_t>> cell;
        std::array<Corner, 8> corners{};
        for (std::size_t v = 0; v < 8; ++v)
          corners[v] = {i + kHexahedronCorners[v][0], j + kHexahedronCorners[v][1], k + kHexahedronCorners[v][2]};
        for (const CellFace& face : topology(CellType::hexahedron).faces) {
          std::vector<std::int64_t> cycle;
          for (std::size_t s = 0; s < 4; ++s) {
            const Corner& at = corners[static_cast<std::size_t>(face.vertex[s])];
            const Corner& before = corners[static_cast<std::size_t>(face.vertex[(s + 3) % 4])];
            const Corner& after = corners[static_cast<std::size_t>(face.vertex[(s + 1) % 4])];
            if (!cut[at]) {
              cycle.push_back(point({6 * at[0], 6 * at[1], 6 * at[2]}));
              continue;
            }
            cycle.push_back(point(towards(at, before)));
            cycle.push_back(point(towards(at, after)));
          }
          cell.push_back(cycle);
        }
        for (std::size_t v = 0; v < 8; ++v) {
          if (!cut[corners[v]]) continue;
          std::vector<std::int64_t> triangle;
          for (const auto& [a, b] : topology(CellType::hexahedron).edges)
            if (static_cast<std::size_t>(a) == v || static_cast<std::size_t>(b) == v)
              triangle.push_back(
                  point(towards(corners[v], corners[static_cast<std::size_t>(static_cast<std::size_t>(a) == v ? b : a)])));
          cell.push_back(triangle);
        }
        mesh.cells.push_back(std::move(cell));
      }
  for (const auto& [corner, is_cut] : cut) {
    if (!is_cut) continue;
    std::array<std::int64_t, 6> tip{};
    for (std::size_t a = 0; a < 6; ++a) {
      Corner to = corner;
      to[a / 2] += a % 2 ? 1 : -1;
      tip[a] = point(towards(corner, to));
    }
    std::vector<std::vector<std::int64_t>> octahedron;
    for (const std::size_t x : {0, 1})
      for (const std::size_t y : {2, 3})
        for (const std::size_t z : {4, 5}) octahedron.push_back({tip[x], tip[y], tip[z]});
    mesh.cells.push_back(std::move(octahedron));
  }
  number_at_random(mesh, random);
  mesh.volume = static_cast<double>(cubes[0] * cubes[1] * cubes[2]);
  return mesh;
}

}  // namespace isostrata::test
