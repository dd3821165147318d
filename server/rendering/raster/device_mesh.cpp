#include "rendering/raster/device_mesh.h"

#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "rendering/raster/raster_frame.h"

namespace isostrata {

DeviceMesh::DeviceMesh(const GlFunctions& gl) : gl_(gl) {
  GLint64 allowed = 0;
  gl_.GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &allowed);
  largest_buffer_ = std::min<std::uint64_t>(static_cast<std::uint64_t>(std::max<GLint64>(allowed, 0)), 2ull << 30);
}

bool DeviceMesh::put(GlObject& buffer, std::uint64_t bytes, const void* data) {
  buffer = {};
  if (bytes > largest_buffer_) return false;
  buffer = make_buffer(gl_);
  const std::uint32_t nothing[4] = {0, 0, 0, 0};
  gl_.NamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(std::max<std::uint64_t>(bytes, sizeof nothing)),
                         bytes < sizeof nothing ? nothing : data, 0);
  if (gl_.GetError() == GL_NO_ERROR) return true;
  buffer = {};
  return false;
}

bool DeviceMesh::set_mesh(const DrawInput& input, double scale) {
  const Vec3d center = device_center(input);
  if (mesh_.is(input.mesh) && colors_.is(input.color_values) && mesh_center_ == center && mesh_scale_ == scale) return mesh_fits_;
  mesh_.set(input.mesh);
  colors_.set(input.color_values);
  mesh_center_ = center;
  mesh_scale_ = scale;
  mesh_fits_ = false;
  for (GlObject* old : {&points_, &cells_, &intervals_}) *old = GlObject{};

  const IntervalMesh& mesh = *input.mesh;
  const std::size_t np = mesh.positions.size(), nt = mesh.tetrahedra.size();
  if (16 * np > largest_buffer_ || 16 * nt > largest_buffer_) return false;
  const std::vector<float>* colors = input.color_values && input.color_values->size() == np ? input.color_values.get() : nullptr;
  {
    std::vector<shaders::vec4> points(np);
    parallel_for(static_cast<std::int64_t>(np), 16384, [&](std::int64_t begin, std::int64_t end) {
      for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
        const Vec3d p = (mesh.positions[i] - center) / scale;
        points[i] = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z), colors ? (*colors)[i] : 0.0f};
      }
    });
    if (!put(points_, 16 * np, points.data())) return false;
  }
  std::vector<std::uint16_t> intervals(mesh.tetrahedron_interval.begin(), mesh.tetrahedron_interval.end());
  intervals.resize((nt + 1) / 2 * 2 + 8);  // read two at a time
  mesh_fits_ = put(cells_, 16 * nt, mesh.tetrahedra.data()) && put(intervals_, 2 * intervals.size(), intervals.data());
  if (!mesh_fits_)
    for (GlObject* half : {&points_, &cells_, &intervals_}) *half = GlObject{};
  return mesh_fits_;
}

void DeviceMesh::set_facets(const DrawInput& input, double scale) {
  const Vec3d center = device_center(input);
  if (facets_mesh_.is(input.mesh) && facets_colors_.is(input.color_values) && facets_textures_.is(input.texture_values) &&
      facets_normals_.is(input.normals) && facets_center_ == center && facets_scale_ == scale)
    return;
  facets_mesh_.forget();
  facets_ = sort_facets(*input.mesh);
  const std::vector<shaders::FacetCorner> corners = facet_corners(input, facets_, center, scale);
  std::vector<std::uint32_t> cells;  // uvec2 a facet
  cells.reserve(2 * facets_.facets.size());
  for (const std::uint32_t f : facets_.facets) {
    const BoundaryFacet& facet = input.mesh->facets[f];
    cells.push_back(facet.tetrahedron);
    cells.push_back(std::uint32_t{facet.interval} * 4 + static_cast<std::uint32_t>(facet.label));
  }
  if (!put(corners_, sizeof(shaders::FacetCorner) * corners.size(), corners.data()) ||
      !put(facet_of_, 4 * facets_.first_of.size(), facets_.first_of.data()) || !put(facet_cells_, 4 * cells.size(), cells.data()))
    throw Error(ErrorCode::too_large, "the device has no room for " + std::to_string(facets_.facets.size()) +
                                          " boundary facets: narrow the intervals, leave the surfaces out or draw with native");
  facets_mesh_.set(input.mesh);
  facets_colors_.set(input.color_values);
  facets_textures_.set(input.texture_values);
  facets_normals_.set(input.normals);
  facets_center_ = center;
  facets_scale_ = scale;
}

bool DeviceMesh::set_shades(std::span<const float> shades) { return put(shades_, shades.size_bytes(), shades.data()); }

void DeviceMesh::give_back() {
  mesh_.forget();
  facets_mesh_.forget();
  facets_ = {};
  for (GlObject* of : {&points_, &cells_, &intervals_, &shades_, &corners_, &facet_of_, &facet_cells_}) *of = GlObject{};
}

void DeviceMesh::bind() const {
  const auto bind = [&](GLuint binding, const GlObject& buffer) {
    if (buffer) gl_.BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer.name());
  };
  bind(BUFFER_MESH_POINTS, points_);
  bind(BUFFER_MESH_CELLS, cells_);
  bind(BUFFER_INTERVALS, intervals_);
  bind(BUFFER_SHADES, shades_);
  bind(BUFFER_FACETS, corners_);
  bind(BUFFER_FACET_OF, facet_of_);
  bind(BUFFER_FACET_CELLS, facet_cells_);
}

}  // namespace isostrata
