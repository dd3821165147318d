#include "rendering/picture/body_shading.h"

#include <cmath>

#include "base/parallel.h"
#include "base/vec.h"

namespace isostrata {
namespace {

/// f of the header. towards_eye: of any length. 1 if the normal is zero.
double body_shade(Vec3f normal, Vec3d towards_eye, double strength) {
  const Vec3d n{double{normal.x}, double{normal.y}, double{normal.z}};
  const double size = std::sqrt(dot(n, n) * dot(towards_eye, towards_eye));
  const double c = std::abs(dot(n, towards_eye)) / size;
  return c < 1 ? 1 - strength * (1 - c) : 1;  // false for NaN
}

}  // namespace

Buffer<float> body_shades(const DrawInput& input) {
  const std::size_t np = input.mesh->positions.size();
  const Camera& camera = input.camera;
  const Vec3d backwards = camera.eye - camera.at;
  Buffer<float> shades(np);
  parallel_for(static_cast<std::int64_t>(np), 8192, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
      const Vec3d towards_eye = camera.orthographic ? backwards : camera.eye - input.mesh->positions[i];
      shades[i] = static_cast<float>(body_shade((*input.body_normals)[i], towards_eye, input.body_shading));
    }
  });
  return shades;
}

}  // namespace isostrata
