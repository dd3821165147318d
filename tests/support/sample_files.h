// Small files of every kind of grid and cell that tests write for themselves, each of a known volume.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "support/plot3d_file.h"
#include "support/sample_meshes.h"
#include "support/temporary_folder.h"

namespace isostrata::testing {

struct SampleFile {
  std::filesystem::path path;
  double volume = 0;  // of the cells that are not hidden
  int steps = 1;
};

/// "distance" and "ties" at whole points, "cell" in cells, of a grid of points along each side.
struct SampleGridArrays {
  std::string points, cells;
};
inline SampleGridArrays sample_grid_arrays(std::array<int, 3> dims, double shift = 0) {
  std::vector<float> distance;
  std::vector<int> ties, cell;
  const auto of = [&](int i, int a) { return double(i) / (dims[static_cast<std::size_t>(a)] - 1); };
  for (int k = 0; k < dims[2]; ++k)
    for (int j = 0; j < dims[1]; ++j)
      for (int i = 0; i < dims[0]; ++i) {
        distance.push_back(static_cast<float>(length(Vec3d{of(i, 0) - 0.4 - shift, of(j, 1) - 0.55, of(k, 2) - 0.45})));
        ties.push_back((3 * i + 5 * j + 2 * k) % 4 * 85);
      }
  for (int c = 0; c < (dims[0] - 1) * (dims[1] - 1) * (dims[2] - 1); ++c) cell.push_back(c * 7 % 11);
  return {data_array("distance", "Float32", distance) + data_array("ties", "UInt8", ties), data_array("cell", "Int32", cell)};
}

/// Flow variables of a place: density, momentum, energy.
inline const std::vector<std::function<double(const Vec3d&)>>& sample_flow() {
  static const std::vector<std::function<double(const Vec3d&)>> fields{
      [](const Vec3d& p) { return 1 + 0.5 * std::sin(p.x + 2 * p.y) * std::cos(0.7 * p.z); }, [](const Vec3d& p) { return p.y; },
      [](const Vec3d& p) { return -p.x; }, [](const Vec3d& p) { return 0.25 * p.z; },
      [](const Vec3d& p) { return 2 + length(p - Vec3d{1, 2, 1}); }};
  return fields;
}

/// Two blocks, bytes as Fortran on another machine writes them: half of a ring of 12 x 3 x 4 cells, whose faces are plane, and a
/// box of 3 x 3 x 4 beside it, whose last point is blanked and with it one cell.
inline SampleFile write_sample_plot3d(const TemporaryFolder& folder) {
  const double pi = std::acos(-1.0);
  Plot3dPart ring = plot3d_part(
      {13, 4, 5},
      [&](int i, int j, int k) {
        const double radius = 1 + j, angle = pi * i / 12;
        return Vec3d{radius * std::cos(angle), radius * std::sin(angle), double(k)};
      },
      sample_flow());
  Plot3dPart box = plot3d_part({4, 4, 5}, [](int i, int j, int k) { return Vec3d{1.0 + j, i - 3.0, double(k)}; }, sample_flow());
  ring.blanking.assign(ring.points.size(), 1);
  box.blanking.assign(box.points.size(), 1);
  box.blanking.back() = 0;
  const Plot3dDialect dialect{.big = true, .doubles = true, .multi = true, .blanking = true, .marker = 4};
  folder.write("flow.q", plot3d_solution(dialect, {ring, box}));
  return {folder.write("flow.xyz", plot3d_grid(dialect, {ring, box})), 12 * 0.5 * (16 - 1) * std::sin(pi / 12) * 4 + 36 - 1};
}

/// All of them.
inline std::vector<SampleFile> write_sample_files(const TemporaryFolder& folder) {
  std::vector<SampleFile> out;
  for (const SampleMesh& mesh : sample_meshes()) out.push_back({folder.write(mesh.name + ".vtu", mesh.vtu.text()), mesh.volume});

  const std::array<int, 3> dims{6, 5, 7};
  const SampleGridArrays arrays = sample_grid_arrays(dims);
  constexpr double kCells = 5 * 4 * 6;
  out.push_back({folder.write("uniform.vti", vti_text({-2, 3, 0}, dims, arrays.points, arrays.cells)), kCells});
  out.push_back({folder.write("rectilinear.vtr", vtr_text({{{0, 1, 1.5, 4, 4.25, 5}, {3, 2, 0, -1, -1.5}, {0, 1, 2, 4, 8, 16, 17}}},
                                                          arrays.points, arrays.cells)),
                 5 * 4.5 * 17});
  std::vector<Vec3d> bent;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> by(-0.2, 0.2);
  for (int k = 0; k < dims[2]; ++k)
    for (int j = 0; j < dims[1]; ++j)
      for (int i = 0; i < dims[0]; ++i) {
        const bool inside = i > 0 && j > 0 && k > 0 && i < dims[0] - 1 && j < dims[1] - 1 && k < dims[2] - 1;
        bent.push_back(Vec3d{double(i), double(j), double(k)} + (inside ? Vec3d{by(random), by(random), by(random)} : Vec3d{}));
      }
  out.push_back({folder.write("curvilinear.vts", vts_text(dims, bent, arrays.points, arrays.cells)), kCells});
  std::vector<int> ghosts(static_cast<std::size_t>(kCells));
  int hidden = 0;
  for (std::size_t c = 0; c < ghosts.size(); c += 9) ghosts[c] = 32, ++hidden;
  out.push_back({folder.write("blanked.vti", vti_text({0, 0, 0}, dims, arrays.points,
                                                      arrays.cells + data_array("vtkGhostType", "UInt8", ghosts))),
                 kCells - hidden});
  out.push_back(write_sample_plot3d(folder));

  std::vector<std::pair<double, std::string>> still, moving;
  for (int step = 0; step < 3; ++step) {
    const std::string name = "still_" + std::to_string(step) + ".vti";
    const SampleGridArrays then = sample_grid_arrays(dims, 0.1 * step);
    folder.write(name, vti_text({0, 0, 0}, dims, then.points, then.cells));
    still.emplace_back(0.5 * step, name);
  }
  out.push_back({folder.write("still.pvd", pvd_text(still)), kCells, 3});
  for (int step = 0; step < 3; ++step) {
    SampleMesh mesh{"moving_" + std::to_string(step) + ".vtu", {}, 27};
    const CubeLattice lattice(mesh.vtu, 3, 0.1, 7 + static_cast<std::uint64_t>(step));  // the points inside go elsewhere
    for (const auto& cube : lattice.cubes())
      for (const auto& t : kuhn_tetrahedra(cube)) mesh.vtu.add(10, {t.begin(), t.end()});
    add_sample_arrays(mesh.vtu);
    folder.write(mesh.name, mesh.vtu.text());
    moving.emplace_back(10.0 + step, mesh.name);
  }
  out.push_back({folder.write("moving.pvd", pvd_text(moving)), 27, 3});
  return out;
}

}  // namespace isostrata::testing
