#include "rendering/style_table.h"

#include <algorithm>

#include "rendering/shaders/layout.h"

namespace isostrata {
namespace {

constexpr double kLargestExtinction = 1e30;  // keeps extinction times length from being infinity times zero
constexpr int kMapSamples = 1024;            // enough that every built-in table's own samples are met within 1/1000 of the range

}  // namespace

StyleTable::StyleTable(const GlFunctions& gl) : gl_(gl), texture_(make_texture(gl, GL_TEXTURE_BUFFER)) {}

void StyleTable::set(const std::vector<IntervalStyle>& styles, double unit_distance, double scale) {
  std::vector<std::string> rows;
  std::vector<float> texels;  // [styles][2][4]
  for (const IntervalStyle& style : styles) {
    const double sigma = std::min(extinction(style.opacity, unit_distance) * scale, kLargestExtinction);
    texels.insert(texels.end(), {style.color[0], style.color[1], style.color[2], static_cast<float>(sigma)});
    if (style.color_map.empty()) {
      texels.insert(texels.end(), {-1, 0, 0, 0});
      continue;
    }
    auto row = std::find(rows.begin(), rows.end(), style.color_map);
    if (row == rows.end()) row = rows.insert(rows.end(), style.color_map);
    const double range = style.color_upper - style.color_lower;  // an empty range shows the map's first colour
    const double factor = range != 0 ? 1 / range : 0;
    texels.insert(texels.end(), {static_cast<float>(row - rows.begin()), static_cast<float>(factor),
                                 static_cast<float>(-style.color_lower * factor), 0});
  }
  if (texels.empty()) texels.assign(8, 0.0f);
  buffer_ = make_buffer(gl_);
  gl_.NamedBufferStorage(buffer_.name(), static_cast<GLsizeiptr>(texels.size() * sizeof(float)), texels.data(), 0);
  gl_.TextureBuffer(texture_.name(), GL_RGBA32F, buffer_.name());
  if (!rows.empty() && rows != rows_) set_maps(rows);
}

void StyleTable::set_maps(const std::vector<std::string>& rows) {
  maps_ = make_texture_2d(gl_, GL_RGBA32F, kMapSamples, static_cast<int>(rows.size()));
  gl_.TextureParameteri(maps_.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TextureParameteri(maps_.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  std::vector<float> line(4 * kMapSamples, 1.0f);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (int i = 0; i < kMapSamples; ++i) {
      const Rgb rgb = sample(color_map(rows[row]), static_cast<float>(i) / (kMapSamples - 1));
      std::copy(rgb.begin(), rgb.end(), &line[4 * static_cast<std::size_t>(i)]);
    }
    gl_.TextureSubImage2D(maps_.name(), 0, 0, static_cast<GLint>(row), kMapSamples, 1, GL_RGBA, GL_FLOAT, line.data());
  }
  rows_ = rows;
}

void StyleTable::bind() const {
  gl_.BindTextureUnit(UNIT_STYLES, texture_.name());
  if (maps_) gl_.BindTextureUnit(UNIT_MAPS, maps_.name());
}

}  // namespace isostrata
