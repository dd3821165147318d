// The intervals' looks on the device.
#pragma once

#include <string>
#include <vector>

#include "rendering/gl/gl_objects.h"
#include "scene/style.h"

namespace isostrata {

/// A buffer texture with STYLE_TEXELS texels a style, a texture with one colour map a row, and the 2D tables of
/// Integral::table2d, as shaders/layout.h says.
class StyleTable {
 public:
  explicit StyleTable(const GlFunctions& gl);

  /// unit_distance in world units; scale: world units of a length of 1 in the shader; tables: also make the 2D tables, whose
  /// lengths l are at l / (l + unit distance). Throws too_large.
  void set(const std::vector<IntervalStyle>& styles, double unit_distance, double scale, bool tables);
  /// To the texture units of the tetrahedra's program.
  void bind() const;

 private:
  /// Styles that share a table differ in nothing that light depends on.
  struct TableKey {
    std::string map;
    Rgb color;
    double extinction[2];
    bool operator==(const TableKey&) const = default;
  };
  void set_maps(const std::vector<std::string>& rows);
  void set_tables(const std::vector<TableKey>& keys, double unit);

  const GlFunctions& gl_;
  GlObject buffer_, texture_, maps_, tables_;
  std::vector<std::string> rows_;  // the colour maps in maps_
  std::vector<TableKey> keys_;     // of tables_
  double table_unit_ = 0;
};

}  // namespace isostrata
