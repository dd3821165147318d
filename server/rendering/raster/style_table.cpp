#include "rendering/raster/style_table.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "rendering/gl/layout.h"

namespace isostrata {
namespace {

constexpr double kLargestExtinction = 1e30;  // keeps extinction times length from being infinity times zero
constexpr int kMapSamples = 1024;            // enough that every built-in table's own samples are met within 1/1000 of the range
constexpr int kMapTexels = 1 << 24;
constexpr int kTableLengths = 256, kTableScalars = 256;
constexpr std::size_t kMostTables = 256;  // 128 MB of half floats

template <class Items, class Item>
std::size_t index_in(Items& items, const Item& item) {
  const auto found = std::find(items.begin(), items.end(), item);
  if (found != items.end()) return static_cast<std::size_t>(found - items.begin());
  items.push_back(item);
  return items.size() - 1;
}

}  // namespace

StyleTable::StyleTable(const GlFunctions& gl) : gl_(gl), texture_(make_texture(gl, GL_TEXTURE_BUFFER)) {}

void StyleTable::set(const std::vector<IntervalStyle>& styles, double unit_distance, double scale, bool tables) {
  std::vector<std::string> rows;
  std::vector<TableKey> keys;
  std::vector<float> texels;  // [styles][STYLE_TEXELS][4]
  const auto add = [&](double a, double b, double c, double d) {
    for (const double v : {a, b, c, d}) texels.push_back(static_cast<float>(v));
  };
  for (const IntervalStyle& style : styles) {
    const auto sigma = [&](double opacity) { return std::min(extinction(opacity, unit_distance) * scale, kLargestExtinction); };
    const double sigma0 = sigma(style.opacity), sigma1 = sigma(style.opacity_upper.value_or(style.opacity));
    add(style.color[0], style.color[1], style.color[2], sigma0);
    const double row = style.color_map.empty() ? -1.0 : static_cast<double>(index_in(rows, style.color_map));
    const double range = style.color_upper - style.color_lower;  // an empty range shows the map's first colour
    const double factor = range != 0 ? 1 / range : 0;
    add(row, factor, -style.color_lower * factor, sigma1);

    const SurfaceStyle& surface = style.surface;
    add(surface.color[0], surface.color[1], surface.color[2], surface.own_color ? 1 : 0);
    add(surface.opacity, surface.ambient, surface.diffuse, surface.specular);
    double texture = TEXTURE_NONE;
    if (surface.drawn() && !surface.texture.empty())
      texture = surface.texture == "stripes" ? TEXTURE_STRIPES : static_cast<double>(index_in(rows, surface.texture));
    const double layer = tables && !style.constant()
                             ? static_cast<double>(index_in(keys, TableKey{style.color_map, style.color, {sigma0, sigma1}}))
                             : -1.0;
    add(surface.shininess, surface.silhouette, texture, layer);
    const double period = surface.texture_upper - surface.texture_lower;  // an empty range shows the texture's beginning
    const double repeat = period != 0 ? surface.texture_repeat / period : 0;
    add(repeat, -surface.texture_lower * repeat, 0, 0);
  }
  if (texels.empty()) texels.assign(4 * STYLE_TEXELS, 0.0f);
  GLint most = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (texels.size() / 4 > static_cast<std::size_t>(most))
    throw Error(ErrorCode::too_large, std::to_string(styles.size()) + " intervals: the device's style table holds " +
                                          std::to_string(most / STYLE_TEXELS));
  buffer_ = make_buffer(gl_);
  gl_.NamedBufferStorage(buffer_.name(), static_cast<GLsizeiptr>(texels.size() * sizeof(float)), texels.data(), 0);
  gl_.TextureBuffer(texture_.name(), GL_RGBA32F, buffer_.name());
  if (!rows.empty() && rows != rows_) set_maps(rows);
  if (!keys.empty() && (keys != keys_ || table_unit_ != unit_distance / scale)) set_tables(keys, unit_distance / scale);
}

void StyleTable::set_maps(const std::vector<std::string>& rows) {
  rows_.clear();
  GLint tallest = 0;
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &tallest);
  if (rows.size() > static_cast<std::size_t>(tallest))
    throw Error(ErrorCode::too_large,
                std::to_string(rows.size()) + " colour maps: the device holds " + std::to_string(tallest) + " at a time");
  // Fewer samples each where there are thousands of maps.
  const int samples = std::clamp(kMapTexels / static_cast<int>(rows.size()), 256, kMapSamples);
  maps_ = make_texture_2d(gl_, GL_RGBA32F, samples, static_cast<int>(rows.size()));
  gl_.TextureParameteri(maps_.name(), GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl_.TextureParameteri(maps_.name(), GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  std::vector<float> line(4 * static_cast<std::size_t>(samples), 1.0f);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    const auto& map = color_map(rows[row]);
    for (int i = 0; i < samples; ++i) {
      const Rgb rgb = sample(map, static_cast<float>(i) / static_cast<float>(samples - 1));
      std::copy(rgb.begin(), rgb.end(), &line[4 * static_cast<std::size_t>(i)]);
    }
    gl_.TextureSubImage2D(maps_.name(), 0, 0, static_cast<GLint>(row), samples, 1, GL_RGBA, GL_FLOAT, line.data());
  }
  rows_ = rows;
}

// Constant colour and extinction at the mean of the values where the ray enters and leaves (section 4 of the paper).
void StyleTable::set_tables(const std::vector<TableKey>& keys, double unit) {
  keys_.clear();
  if (keys.size() > kMostTables)
    throw Error(ErrorCode::too_large, std::to_string(keys.size()) +
                                          " different transfer functions need a 2D table each; there is "
                                          "room for " +
                                          std::to_string(kMostTables) + ": use the exact integral");
  tables_ = make_texture(gl_, GL_TEXTURE_2D_ARRAY);
  gl_.TextureStorage3D(tables_.name(), 1, GL_RGBA16F, kTableLengths, kTableScalars, static_cast<GLsizei>(keys.size()));
  if (gl_.GetError() != GL_NO_ERROR)
    throw Error(ErrorCode::too_large, "the device has no room for " + std::to_string(keys.size()) + " 2D tables");
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T}) gl_.TextureParameteri(tables_.name(), wrap, GL_CLAMP_TO_EDGE);
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    gl_.TextureParameteri(tables_.name(), filter, GL_LINEAR);
  std::vector<float> texels(4 * kTableLengths * kTableScalars);
  for (std::size_t layer = 0; layer < keys.size(); ++layer) {
    const TableKey& key = keys[layer];
    float* out = texels.data();
    for (int s = 0; s < kTableScalars; ++s) {
      const double u = static_cast<double>(s) / (kTableScalars - 1);
      const Rgb rgb = key.map.empty() ? key.color : sample(color_map(key.map), static_cast<float>(u));
      const double sigma = std::lerp(key.extinction[0], key.extinction[1], u);
      for (int l = 0; l < kTableLengths; ++l) {
        const double share = static_cast<double>(l) / (kTableLengths - 1);
        const double alpha = share < 1 ? -std::expm1(-sigma * unit * share / (1 - share)) : sigma > 0 ? 1.0 : 0.0;
        for (const float channel : rgb) *out++ = static_cast<float>(channel * alpha);
        *out++ = static_cast<float>(alpha);
      }
    }
    gl_.TextureSubImage3D(tables_.name(), 0, 0, 0, static_cast<GLint>(layer), kTableLengths, kTableScalars, 1, GL_RGBA, GL_FLOAT,
                          texels.data());
  }
  keys_ = keys;
  table_unit_ = unit;
}

void StyleTable::bind() const {
  gl_.BindTextureUnit(UNIT_STYLES, texture_.name());
  if (maps_) gl_.BindTextureUnit(UNIT_MAPS, maps_.name());
  if (tables_) gl_.BindTextureUnit(UNIT_TABLES, tables_.name());
}

}  // namespace isostrata
