// VTK's ways to draw tetrahedra, off screen, in an EGL context without a surface.
#pragma once

#include <memory>
#include <string>

#include "base/image.h"
#include "rendering/picture/renderer.h"

namespace isostrata::peers {

enum class VtkMapper { projected_tetrahedra, bunyk_ray_cast, zsweep };

/// "projected tetrahedra", "Bunyk ray cast", "ZSweep".
const char* name_of(VtkMapper mapper);

/// The picture of one mesh, its style and its size, from changing cameras. Lives on one thread. Points and tetrahedra are copied
/// once; the mappers keep what they derive from them between frames. Every frame has all its pixels (VTK would lower the
/// resolution of a slow one) and is read back as 8 bits.
class VtkVolume {
 public:
  /// The first of input.styles is everybody's. Throws unavailable if there is no EGL surfaceless context.
  VtkVolume(VtkMapper mapper, const DrawInput& input, int threads);
  ~VtkVolume();

  Image draw(const Camera& camera);
  const std::string& device() const;

 private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

}  // namespace isostrata::peers
