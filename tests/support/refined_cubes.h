// A polyhedral mesh that tests can make: a lattice of cubes of which some are refined, as snappyHexMesh of OpenFOAM makes them.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "support/polyhedral_mesh.h"

namespace isostrata::test {

/// Unit cubes (i,j,k) below `cubes`, each whole or, one in four, eight of half the size. A whole one beside a refined one has four
/// small faces there, and points in the middle of its edges: corners of its faces in line with two others. Points inside the box are
/// moved by up to `moved` along each axis: then faces are not plane, and those corners are a little off the line.
inline PolyhedralMesh refined_cubes(std::array<std::int64_t, 3> cubes, std::uint64_t seed, double moved = 0) {
  using Place = std::array<std::int64_t, 3>;  // in half edges
  std::mt19937_64 random(seed);
  std::map<Place, bool> refined;
  for (std::int64_t k = 0; k < cubes[2]; ++k)
    for (std::int64_t j = 0; j < cubes[1]; ++j)
      for (std::int64_t i = 0; i < cubes[0]; ++i) refined[{i, j, k}] = random() % 4 == 0;
  const auto is_refined = [&](const Place& cube) {
    const auto found = refined.find(cube);
    return found != refined.end() && found->second;
  };
  // A place is a point if it is a cube's corner, or belongs to a refined cube.
  const auto is_point = [&](const Place& place) {
    if (place[0] % 2 == 0 && place[1] % 2 == 0 && place[2] % 2 == 0) return true;
    for (std::int64_t c = 0; c < 8; ++c) {
      Place cube{};
      for (std::size_t a = 0; a < 3; ++a) cube[a] = (place[a] + 1) / 2 - (c >> a & 1);
      bool touches = true;
      for (std::size_t a = 0; a < 3; ++a) touches = touches && place[a] >= 2 * cube[a] && place[a] <= 2 * cube[a] + 2;
      if (touches && is_refined(cube)) return true;
    }
    return false;
  };
  PolyhedralMesh mesh;
  std::map<Place, std::int64_t> number;
  const auto point = [&](const Place& place) {
    const auto [entry, fresh] = number.try_emplace(place, static_cast<std::int64_t>(mesh.points.size()));
    if (fresh)
      mesh.points.push_back(Vec3d{static_cast<double>(place[0]), static_cast<double>(place[1]), static_cast<double>(place[2])} * 0.5);
    return entry->second;
  };
  /// The corners of a face of a box, and the points in the middle of its edges.
  const auto outline = [&](const Place& first, std::int64_t size, const CellFace& face) {
    std::vector<std::int64_t> cycle;
    for (std::size_t v = 0; v < 4; ++v) {
      const auto& from = kHexahedronCorners[static_cast<std::size_t>(face.vertex[v])];
      const auto& to = kHexahedronCorners[static_cast<std::size_t>(face.vertex[(v + 1) % 4])];
      Place corner{}, middle{};
      for (std::size_t a = 0; a < 3; ++a) {
        corner[a] = first[a] + size * from[a];
        middle[a] = first[a] + size * (from[a] + to[a]) / 2;
      }
      cycle.push_back(point(corner));
      if (size == 2 && is_point(middle)) cycle.push_back(point(middle));
    }
    return cycle;
  };
  for (const auto& [cube, parts] : refined) {
    for (std::int64_t c = 0; c < (parts ? 8 : 1); ++c) {
      auto& cell = mesh.cells.emplace_back();
      const std::int64_t size = parts ? 1 : 2;
      const Place first{2 * cube[0] + (c & 1), 2 * cube[1] + (c >> 1 & 1), 2 * cube[2] + (c >> 2)};
      for (const CellFace& face : topology(CellType::hexahedron).faces) {
        Place beyond = cube, low{1, 1, 1}, high{};
        for (const int v : face.vertex)
          for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], kHexahedronCorners[static_cast<std::size_t>(v)][a]);
            high[a] = std::max(high[a], kHexahedronCorners[static_cast<std::size_t>(v)][a]);
          }
        std::size_t axis = 0;
        while (low[axis] != high[axis]) ++axis;
        beyond[axis] += low[axis] ? 1 : -1;
        if (parts || !is_refined(beyond)) {
          cell.push_back(outline(first, size, face));
          continue;
        }
        for (std::int64_t quarter = 0; quarter < 4; ++quarter) {
          Place part = first;
          part[axis] += low[axis];  // the small box behind the quarter
          part[(axis + 1) % 3] += quarter & 1;
          part[(axis + 2) % 3] += quarter >> 1;
          cell.push_back(outline(part, 1, face));
        }
      }
    }
  }
  std::uniform_real_distribution<double> by(-moved, moved);
  for (Vec3d& p : mesh.points) {
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && p[a] > 0 && p[a] < static_cast<double>(cubes[static_cast<std::size_t>(a)]);
    if (inside) p = p + Vec3d{by(random), by(random), by(random)};
  }
  number_at_random(mesh, random);
  mesh.volume = static_cast<double>(cubes[0] * cubes[1] * cubes[2]);
  return mesh;
}

}  // namespace isostrata::test
