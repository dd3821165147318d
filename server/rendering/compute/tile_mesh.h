// An interval mesh and its point arrays on the device, kept from frame to frame: the CPU's, or made on the device from the layers' field.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "extraction/bricks/layer_bricks.h"
#include "rendering/device/gl_extractor.h"
#include "rendering/gl/gl_compute.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

class TileMesh {
 public:
  explicit TileMesh(ComputeDevice& device) : device_(device) {}

  /// Uploads what has changed since the last call, by the pointers' identity; of layers without a mesh (DrawInput::bricks) the field, once, whose
  /// mesh is then made there. Throws too_large.
  void set(const DrawInput& input);
  /// As if nothing had been set.
  void give_back();

  Vec3d middle() const { return middle_; }
  double scale() const { return scale_; }  // world units of a length of 1 on the device
  std::uint32_t tetrahedra() const { return tetrahedra_; }
  /// Of an interval, those of no volume left out.
  std::int64_t tetrahedra_of(std::size_t interval) const { return of_interval_[interval]; }
  /// To the bindings that all programs share.
  void bind() const;
  void bind_arrays() const;

  bool has_values() const { return has_values_; }
  bool has_normals() const { return has_normals_; }
  bool has_texture() const { return has_texture_; }
  bool has_shades() const { return has_shades_; }

 private:
  void set_mesh(const DrawInput& input);
  void set_runs(const Grid* grid, const IntervalMesh& mesh);
  void set_place(const DrawInput& input);
  void set_layers(const DrawInput& input);
  void set_shades(const DrawInput& input);
  void adopt(const GlExtractor& made);

  ComputeDevice& device_;
  std::weak_ptr<const IntervalMesh> mesh_;
  std::weak_ptr<const std::vector<float>> values_source_, texture_source_;
  std::weak_ptr<const std::vector<Vec3f>> normals_source_;
  const Grid* grid_ = nullptr;
  std::optional<GlExtractor> extractor_;  // once layers came without a mesh
  std::weak_ptr<const Dataset> field_of_;  // what extractor_ has loaded: an array of that
  const PointArray* field_ = nullptr;
  std::weak_ptr<const LayerBricks> layers_;  // what the buffers were made of, in place of mesh_
  Vec3d middle_;
  double scale_ = 0;
  std::uint32_t tetrahedra_ = 0;
  std::vector<std::int64_t> of_interval_;
  bool has_values_ = false, has_normals_ = false, has_texture_ = false, has_shades_ = false;
  ComputeBuffer positions_, corners_, infos_, runs_, values_, normals_, texture_, shades_;
};

}  // namespace isostrata
