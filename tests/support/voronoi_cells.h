// A polyhedral mesh that tests can make: the Voronoi cells of random points in a box. Convex cells of some 14 faces and 24 points,
// with faces of three to ten and more corners, and edges of every length.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <vector>

#include "support/polyhedral_mesh.h"

namespace isostrata::test {

/// One site in each cube of a lattice of unit cubes, moved by up to `jitter` / 2. A cell is the box cut by the planes half way to
/// the other sites. A point is known by the four planes that it lies in, so that neighbours name it alike however it is rounded.
inline PolyhedralMesh voronoi_cells(std::array<std::int64_t, 3> cubes, std::uint64_t seed, double jitter = 0.9) {
  using Name = std::array<std::int64_t, 4>;  // increasing: sites, and walls of the box as -1 to -6
  struct Corner {
    Name name;
    Vec3d at;
  };
  using Polygon = std::vector<Corner>;  // counter-clockwise seen from outside
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> moved(-jitter / 2, jitter / 2);
  const Vec3d box{static_cast<double>(cubes[0]), static_cast<double>(cubes[1]), static_cast<double>(cubes[2])};
  std::vector<Vec3d> sites;
  for (std::int64_t k = 0; k < cubes[2]; ++k)
    for (std::int64_t j = 0; j < cubes[1]; ++j)
      for (std::int64_t i = 0; i < cubes[0]; ++i) {
        const Vec3d middle{static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5, static_cast<double>(k) + 0.5};
        sites.push_back(middle + Vec3d{moved(random), moved(random), moved(random)});
      }
  const auto named = [](Name name) {
    std::sort(name.begin(), name.end());
    return name;
  };
  PolyhedralMesh mesh;
  std::map<Name, std::int64_t> number;
  for (std::int64_t own = 0; own < static_cast<std::int64_t>(sites.size()); ++own) {
    const Vec3d site = sites[static_cast<std::size_t>(own)];
    std::map<std::int64_t, Polygon> faces;  // by the plane that they lie in
    for (const CellFace& face : topology(CellType::hexahedron).faces) {
      Polygon polygon;
      std::array<bool, 3> low{true, true, true}, high{true, true, true};
      for (const int v : face.vertex) {
        const auto& c = kHexahedronCorners[static_cast<std::size_t>(v)];
        Corner& corner = polygon.emplace_back();
        corner.name[3] = own;
        for (std::size_t a = 0; a < 3; ++a) {
          corner.at[static_cast<int>(a)] = c[a] ? box[static_cast<int>(a)] : 0;
          corner.name[a] = -1 - static_cast<std::int64_t>(2 * a) - c[a];
          low[a] = low[a] && c[a] == 0;
          high[a] = high[a] && c[a] == 1;
        }
        corner.name = named(corner.name);
      }
      for (std::size_t a = 0; a < 3; ++a)
        if (low[a] || high[a]) faces[-1 - static_cast<std::int64_t>(2 * a) - high[a]] = polygon;
    }
    for (std::int64_t other = 0; other < static_cast<std::int64_t>(sites.size()); ++other) {
      if (other == own) continue;
      const Vec3d normal = sites[static_cast<std::size_t>(other)] - site;
      const double offset = dot(normal, (sites[static_cast<std::size_t>(other)] + site) * 0.5);
      std::map<Name, std::array<Corner, 2>> sides;  // of the new face, by where they begin
      for (auto& [plane, polygon] : faces) {
        Polygon kept;
        Corner leaves{}, enters{};
        bool cut = false;
        for (std::size_t i = 0; i < polygon.size(); ++i) {
          const Corner &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
          const double da = dot(normal, a.at) - offset, db = dot(normal, b.at) - offset;
          if (da <= 0) kept.push_back(a);
          if ((da <= 0) == (db <= 0)) continue;
          Name name{other, other, other, other};  // the three planes of the edge, and the new one
          std::set_intersection(a.name.begin(), a.name.end(), b.name.begin(), b.name.end(), name.begin());
          const Corner crossing{named(name), a.at + (b.at - a.at) * (da / (da - db))};
          kept.push_back(crossing);
          (da <= 0 ? leaves : enters) = crossing;
          cut = true;
        }
        polygon = kept;
        if (cut) sides[enters.name] = {enters, leaves};
      }
      std::erase_if(faces, [](const auto& entry) { return entry.second.empty(); });
      if (sides.empty()) continue;
      Polygon& face = faces[other];
      for (Name at = sides.begin()->first; face.size() < sides.size(); at = sides.at(at)[1].name) face.push_back(sides.at(at)[0]);
    }
    std::vector<std::vector<std::int64_t>>& cell = mesh.cells.emplace_back();
    for (const auto& [plane, polygon] : faces) {
      std::vector<std::int64_t>& cycle = cell.emplace_back();
      for (const Corner& corner : polygon) {
        const auto [entry, fresh] = number.try_emplace(corner.name, static_cast<std::int64_t>(mesh.points.size()));
        if (fresh) mesh.points.push_back(corner.at);
        cycle.push_back(entry->second);
      }
    }
  }
  number_at_random(mesh, random);
  mesh.volume = box.x * box.y * box.z;
  return mesh;
}

}  // namespace isostrata::test
