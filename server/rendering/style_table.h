// The intervals' looks on the device.
#pragma once

#include <string>
#include <vector>

#include "rendering/gl_objects.h"
#include "rendering/style.h"

namespace isostrata {

/// A buffer texture with two texels a style and a texture with one colour map a row, as shaders/layout.h says.
class StyleTable {
 public:
  explicit StyleTable(const GlFunctions& gl);

  /// unit_distance in world units; scale: world units of a length of 1 in the shader.
  void set(const std::vector<IntervalStyle>& styles, double unit_distance, double scale);
  /// To the texture units of the tetrahedra's program.
  void bind() const;

 private:
  void set_maps(const std::vector<std::string>& rows);

  const GlFunctions& gl_;
  GlObject buffer_, texture_, maps_;
  std::vector<std::string> rows_;  // the colour maps in maps_
};

}  // namespace isostrata
