#include "rendering/compute/tile_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/compute/tile_layout.h"
#include "rendering/picture/body_shading.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

constexpr std::int64_t kGrain = 16384;

/// A float array that comes with some inputs only. Returns whether it is there.
template <class T>
bool set_array(ComputeDevice& device, const std::shared_ptr<const std::vector<T>>& array,
               std::weak_ptr<const std::vector<T>>& source, ComputeBuffer& buffer, const char* what) {
  if (!array || array->empty()) return false;
  if (source.lock() == array) return true;
  source.reset();
  device.reserve(buffer, array->size() * sizeof(T), what);
  device.upload(buffer, 0, std::as_bytes(std::span(*array)), Task());
  source = array;
  return true;
}

}  // namespace

void TileMesh::set_place(const DrawInput& input) {
  mesh_.reset();
  layers_.reset();
  middle_ = input.bounds.empty() ? Vec3d{} : input.bounds.center();
  scale_ = input.bounds.diagonal() > 0 ? input.bounds.diagonal() : 1.0;
}

void TileMesh::set_mesh(const DrawInput& input) {
  const IntervalMesh& mesh = *input.mesh;
  set_place(input);
  if (mesh.tetrahedra.size() >= std::numeric_limits<std::uint32_t>::max() / 2)
    throw Error(ErrorCode::too_large,
                std::to_string(mesh.tetrahedra.size()) + " tetrahedra are more than renderer compute counts: draw with native");
  tetrahedra_ = static_cast<std::uint32_t>(mesh.tetrahedra.size());
  grid_ = nullptr;

  std::vector<Vec3f> positions(mesh.positions.size());
  parallel_for(static_cast<std::int64_t>(positions.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Vec3d p = (mesh.positions[i] - middle_) / scale_;
      positions[i] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
    }
  });
  std::vector<std::uint32_t> infos(mesh.tetrahedra.size());
  parallel_for(static_cast<std::int64_t>(infos.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<std::size_t>(begin); t < static_cast<std::size_t>(end); ++t) {
      Vec3d p[4];
      for (std::size_t v = 0; v < 4; ++v) {
        const Vec3f q = positions[mesh.tetrahedra[t][v]];
        p[v] = {q.x, q.y, q.z};
      }
      double longest = 0;
      for (int a = 0; a < 3; ++a)
        for (int b = a + 1; b < 4; ++b) longest = std::max(longest, dot(p[a] - p[b], p[a] - p[b]));
      const double volumes = orient3d(p[0], p[1], p[2], p[3]);
      infos[t] = mesh.tetrahedron_interval[t];
      if (volumes < 0) infos[t] |= TILE_INFO_TURNED;
      if (!(std::abs(volumes) > TILE_FLAT * longest * std::sqrt(longest))) infos[t] |= TILE_INFO_FLAT;
    }
  });
  for (const BoundaryFacet& facet : mesh.facets) {
    const auto& corners = mesh.tetrahedra[facet.tetrahedron];
    for (std::uint32_t v = 0; v < 4; ++v)
      if (std::find(facet.points.begin(), facet.points.end(), corners[v]) == facet.points.end())
        infos[facet.tetrahedron] |= (static_cast<std::uint32_t>(facet.label) + 1) << (TILE_INFO_LABELS + 2 * v);
  }
  of_interval_.assign(mesh.summaries.size(), 0);
  for (const std::uint32_t info : infos)
    if (!(info & TILE_INFO_FLAT)) ++of_interval_[info & TILE_INFO_INTERVAL];

  const Task task;
  device_.reserve(positions_, positions.size() * sizeof(Vec3f), "the mesh's points");
  device_.upload(positions_, 0, std::as_bytes(std::span(positions)), task);
  device_.reserve(corners_, mesh.tetrahedra.size() * 16, "the mesh's tetrahedra");
  device_.upload(corners_, 0, std::as_bytes(std::span(mesh.tetrahedra)), task);
  device_.reserve(infos_, infos.size() * 4, "what is known of the tetrahedra");
  device_.upload(infos_, 0, std::as_bytes(std::span(infos)), task);
  mesh_ = input.mesh;
}

// Which cell each tetrahedron lies in, where cells have indices.
void TileMesh::set_runs(const Grid* grid, const IntervalMesh& mesh) {
  std::vector<std::uint32_t> runs;
  if (grid && grid->rectilinear() && !mesh.cell_runs.empty()) {
    runs.resize(mesh.tetrahedra.size() + 2 * mesh.cell_runs.size());
    const auto dims = grid->dims();
    const std::int64_t nx = std::max<std::int64_t>(1, dims[0] - 1), ny = std::max<std::int64_t>(1, dims[1] - 1);
    parallel_for(static_cast<std::int64_t>(mesh.cell_runs.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto r = static_cast<std::size_t>(begin); r < static_cast<std::size_t>(end); ++r) {
        const std::size_t last = r + 1 < mesh.cell_runs.size() ? mesh.cell_runs[r + 1].first_tetrahedron : mesh.tetrahedra.size();
        for (std::size_t t = mesh.cell_runs[r].first_tetrahedron; t < last; ++t) runs[t] = static_cast<std::uint32_t>(r);
        const std::int64_t cell = mesh.cell_runs[r].cell, i = cell % nx, j = cell / nx % ny, k = cell / (nx * ny);
        runs[mesh.tetrahedra.size() + 2 * r] = static_cast<std::uint32_t>(i) | static_cast<std::uint32_t>(j) << 16;
        runs[mesh.tetrahedra.size() + 2 * r + 1] = static_cast<std::uint32_t>(k);
      }
    });
  }
  device_.reserve(runs_, runs.size() * 4, "the tetrahedra's cells");
  device_.upload(runs_, 0, std::as_bytes(std::span(runs)), Task());
  grid_ = grid;
}

void TileMesh::set_layers(const DrawInput& input) {
  const LayerBricks& layers = *input.bricks;
  set_place(input);
  const Task task;
  if (!extractor_) extractor_.emplace(device_);
  if (field_of_.lock() != layers.dataset() || field_ != &layers.array()) {
    field_of_.reset();
    extractor_->load(layers.grid(), layers.array(), 0, task);
    field_of_ = layers.dataset();
    field_ = &layers.array();
  }
  const GlCounts counts = extractor_->extract(layers.intervals(), GlExtent::tetrahedra, task);
  tetrahedra_ = static_cast<std::uint32_t>(counts.tetrahedra);
  of_interval_.clear();
  for (const GlIntervalCount& of : counts.intervals) of_interval_.push_back(of.tetrahedra);
  adopt(*extractor_);
  values_source_.reset();
  has_values_ = true;
  has_normals_ = has_texture_ = false;
  layers_ = input.bricks;
}

void TileMesh::adopt(const GlExtractor& made) {
  const GlCounts& counts = made.counts();
  device_.reserve(positions_, static_cast<std::uint64_t>(counts.points) * sizeof(Vec3f), "the mesh's points");
  device_.reserve(values_, static_cast<std::uint64_t>(counts.points) * 4, "the color-by array");
  device_.reserve(infos_, tetrahedra_ * 4ull, "what is known of the tetrahedra");
  device_.reserve(runs_, (tetrahedra_ + 2 * static_cast<std::uint64_t>(counts.records)) * 4, "the tetrahedra's cells");
  const Vec3d away = middle_ - made.field()->anchor;
  const auto run = [&](const char* defines, std::int64_t items) {
    const GLuint program =
        device_.program(shaders::adopt_layers_comp, "#define BYTES_PER_VALUE 4\n" + std::string(shaders::tile_layout_h) + defines);
    device_.gl().ProgramUniform1ui(program, UNIFORM_COUNT, static_cast<std::uint32_t>(items));
    device_.gl().ProgramUniform1ui(program, TILE_UNIFORM_TETRAHEDRA, tetrahedra_);
    device_.gl().ProgramUniform4f(program, TILE_UNIFORM_PLACE, static_cast<float>(away.x), static_cast<float>(away.y), static_cast<float>(away.z),
                                  static_cast<float>(1 / scale_));
    const auto groups = static_cast<std::uint32_t>((items + TILE_GROUP - 1) / TILE_GROUP);
    for (std::uint32_t first = 0; first < groups; first += std::min(device_.groups_a_dispatch(), groups - first)) {
      device_.gl().ProgramUniform1ui(program, UNIFORM_FIRST, first);
      device_.dispatch(program, std::min(device_.groups_a_dispatch(), groups - first), Task());
    }
    device_.barrier();
  };
  device_.bind(BUFFER_POSITIONS, made.positions());
  device_.bind(TILE_POSITIONS, positions_);
  device_.bind(TILE_VALUES, values_);
  run("#define POINTS\n", counts.points);
  device_.bind(BUFFER_RECORDS, made.records());
  device_.bind(BUFFER_FIRST, made.first_tetrahedron());
  device_.bind(TILE_TETRAHEDRA, made.tetrahedra());
  device_.bind(TILE_INFO, infos_);
  device_.bind(TILE_RUNS, runs_);
  run("", counts.records);
}

void TileMesh::set(const DrawInput& input) {
  const double scale = input.bounds.diagonal() > 0 ? input.bounds.diagonal() : 1.0;
  const Vec3d middle = input.bounds.empty() ? Vec3d{} : input.bounds.center();
  const bool placed = scale == scale_ && middle == middle_;
  has_shades_ = false;
  if (input.bricks) {
    if (layers_.lock() != input.bricks || !placed) set_layers(input);
    return;
  }
  const bool known = mesh_.lock() == input.mesh && placed;
  if (!known) set_mesh(input);
  if (!known || grid_ != input.grid) set_runs(input.grid, *input.mesh);
  has_values_ = set_array(device_, input.color_values, values_source_, values_, "the color-by array");
  has_normals_ = set_array(device_, input.normals, normals_source_, normals_, "the normals");
  has_texture_ = set_array(device_, input.texture_values, texture_source_, texture_, "the texture's array");
  if (shades_bodies(input)) set_shades(input);
}

// They change with the camera.
void TileMesh::set_shades(const DrawInput& input) {
  if (!device_.binds(TILE_SHADES))
    throw Error(ErrorCode::too_large, "renderer compute shades bodies with " + std::to_string(TILE_SHADES + 1) +
                                          " storage buffers, and this device has fewer: draw with native");
  const Buffer<float> shades = body_shades(input);
  device_.reserve(shades_, std::max<std::size_t>(shades.size(), 1) * 4, "the points' shades");
  device_.upload(shades_, 0, std::as_bytes(std::span(shades)), Task());
  has_shades_ = true;
}

void TileMesh::give_back() {
  mesh_.reset();
  layers_.reset();
  field_of_.reset();
  extractor_.reset();
  values_source_.reset();
  normals_source_.reset();
  texture_source_.reset();
  for (ComputeBuffer* of : {&positions_, &corners_, &infos_, &runs_, &values_, &normals_, &texture_, &shades_}) device_.free(*of);
}

void TileMesh::bind() const {
  device_.bind(TILE_POSITIONS, positions_);
  device_.bind(TILE_TETRAHEDRA, layers_.expired() ? corners_ : extractor_->tetrahedra());
  device_.bind(TILE_INFO, infos_);
  device_.bind(TILE_RUNS, runs_);
}

void TileMesh::bind_arrays() const {
  if (has_values_) device_.bind(TILE_VALUES, values_);
  if (has_normals_) device_.bind(TILE_NORMALS, normals_);
  if (has_texture_) device_.bind(TILE_TEXTURE, texture_);
  if (has_shades_) device_.bind(TILE_SHADES, shades_);
}

}  // namespace isostrata
