// A mesh and its facets on the device, kept from frame to frame by the identity of what they were made of.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "rendering/gl/gl_objects.h"
#include "rendering/picture/renderer.h"
#include "rendering/raster/surface_facets.h"

namespace isostrata {

/// Whether something shared is still the same object. Keeps nothing alive, and is not fooled by an address used again.
template <class T>
class Identity {
 public:
  bool is(const std::shared_ptr<const T>& other) const {
    return known_ && !was_.owner_before(other) && !other.owner_before(was_) && address_ == other.get();
  }
  void set(const std::shared_ptr<const T>& to) {
    was_ = to;
    address_ = to.get();
    known_ = true;
  }
  void forget() { known_ = false; }

 private:
  std::weak_ptr<const T> was_;
  const T* address_ = nullptr;
  bool known_ = false;
};

class DeviceMesh {
 public:
  /// The context is current in every call.
  explicit DeviceMesh(const GlFunctions& gl);

  /// Puts the points, tetrahedra and intervals there, or keeps them. False if the device has no room: then nothing is there,
  /// and the same mesh is not tried again.
  bool set_mesh(const DrawInput& input, double scale);
  /// Puts the facets there, or keeps them. Throws too_large.
  void set_facets(const DrawInput& input, double scale);
  /// One for each point of that mesh, of this frame. False if the device has no room.
  bool set_shades(std::span<const float> shades);
  /// As if nothing had been set.
  void give_back();

  /// To the storage buffers' bindings that drawing and projection use, whichever of the two was set.
  void bind() const;
  /// Of the mesh given to set_facets.
  const SurfaceFacets& facets() const { return facets_; }
  std::uint64_t largest_buffer() const { return largest_buffer_; }

 private:
  /// Makes an immutable buffer. False if the device has no room.
  bool put(GlObject& buffer, std::uint64_t bytes, const void* data);

  const GlFunctions& gl_;
  std::uint64_t largest_buffer_ = 0;

  Identity<IntervalMesh> mesh_;
  Identity<std::vector<float>> colors_;
  Vec3d mesh_center_;
  double mesh_scale_ = 0;
  bool mesh_fits_ = false;
  GlObject points_, cells_, intervals_, shades_;

  Identity<IntervalMesh> facets_mesh_;
  Identity<std::vector<float>> facets_colors_, facets_textures_;
  Identity<std::vector<Vec3f>> facets_normals_;
  Vec3d facets_center_;
  double facets_scale_ = 0;
  SurfaceFacets facets_;
  GlObject corners_, facet_of_, facet_cells_;
};

}  // namespace isostrata
