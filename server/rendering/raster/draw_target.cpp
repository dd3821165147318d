#include "rendering/raster/draw_target.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "base/error.h"
#include "rendering/gl/layout.h"
#include "rendering/shader_sources.h"

namespace isostrata {

DrawTarget::DrawTarget(const GlFunctions& gl)
    : gl_(gl),
      resolve_program_(make_program(gl, shaders::resolve_vert, shaders::resolve_frag, "")),
      vertex_array_(make_vertex_array(gl)) {}

void DrawTarget::give_back() {
  width_ = height_ = 0;
  for (GlObject* old : {&color_, &nearest_, &mean_, &bytes_, &accumulate_, &resolve_}) *old = GlObject{};
}

void DrawTarget::make(int width, int height, bool nearest, bool mean) {
  give_back();  // until all of it is made
  color_ = make_texture_2d(gl_, GL_RGBA32F, width, height);
  bytes_ = make_texture_2d(gl_, GL_RGBA8, width, height);
  accumulate_ = make_framebuffer(gl_);
  gl_.NamedFramebufferTexture(accumulate_.name(), GL_COLOR_ATTACHMENT0, color_.name(), 0);
  const auto attach = [&](GlObject& to, GLenum attachment) {
    to = make_texture_2d(gl_, GL_R32F, width, height);
    gl_.NamedFramebufferTexture(accumulate_.name(), attachment, to.name(), 0);
  };
  if (nearest) attach(nearest_, GL_COLOR_ATTACHMENT1);
  if (mean) attach(mean_, GL_COLOR_ATTACHMENT2);
  const GLenum attachments[] = {GL_COLOR_ATTACHMENT0, static_cast<GLenum>(nearest ? GL_COLOR_ATTACHMENT1 : GL_NONE), static_cast<GLenum>(mean ? GL_COLOR_ATTACHMENT2 : GL_NONE)};
  gl_.NamedFramebufferDrawBuffers(accumulate_.name(), 3, attachments);
  resolve_ = make_framebuffer(gl_);
  gl_.NamedFramebufferTexture(resolve_.name(), GL_COLOR_ATTACHMENT0, bytes_.name(), 0);
  for (const GLuint framebuffer : {accumulate_.name(), resolve_.name()})
    if (gl_.CheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
      throw Error(ErrorCode::unavailable,
                  "the device cannot draw to a float target of " + std::to_string(width) + "x" + std::to_string(height));
  width_ = width;
  height_ = height;
}

void DrawTarget::begin(const Tile& tile, bool nearest, bool mean) {
  if (width_ != tile.width || height_ != tile.height || static_cast<bool>(nearest_) != nearest || static_cast<bool>(mean_) != mean)
    make(tile.width, tile.height, nearest, mean);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, accumulate_.name());
  const float zero[4] = {0, 0, 0, 0};
  gl_.ClearNamedFramebufferfv(accumulate_.name(), GL_COLOR, 0, zero);
  if (nearest) gl_.ClearNamedFramebufferfv(accumulate_.name(), GL_COLOR, 1, zero);
  if (mean) gl_.ClearNamedFramebufferfv(accumulate_.name(), GL_COLOR, 2, zero);
}

void DrawTarget::resolve(const Rgb& background, bool transparent) {
  const GLuint program = resolve_program_.name();
  gl_.BindFramebuffer(GL_FRAMEBUFFER, resolve_.name());
  gl_.Viewport(0, 0, width_, height_);
  gl_.UseProgram(program);
  gl_.ProgramUniform4f(program, UNIFORM_BACKGROUND, background[0], background[1], background[2], transparent ? 1.0f : 0.0f);
  gl_.ProgramUniform2f(program, UNIFORM_SIZE, static_cast<float>(width_), static_cast<float>(height_));
  gl_.BindTextureUnit(UNIT_ACCUMULATED, color_.name());
  gl_.BindVertexArray(vertex_array_.name());
  gl_.DrawArrays(GL_TRIANGLES, 0, 3);
}

void DrawTarget::read(const Tile& tile, Image& image) const {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, resolve_.name());
  const auto top_row = static_cast<std::size_t>(image.height - tile.y - tile.height);
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, image.width);
  gl_.ReadPixels(0, 0, tile.width, tile.height, GL_RGBA, GL_UNSIGNED_BYTE,
                 &image.rgba[4 * (top_row * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(tile.x))]);
  gl_.PixelStorei(GL_PACK_ROW_LENGTH, 0);
}

void DrawTarget::read(const Tile& tile, const std::function<double(double)>& depth_of, double scale, FloatImage& image) const {
  const auto width = static_cast<std::size_t>(tile.width);
  std::vector<float> rows(4 * width * static_cast<std::size_t>(tile.height));
  const auto picture_row = [&](int y) {  // GL's rows go up, ours down
    return static_cast<std::size_t>(image.height - 1 - tile.y - y) * static_cast<std::size_t>(image.width) +
           static_cast<std::size_t>(tile.x);
  };
  gl_.BindFramebuffer(GL_FRAMEBUFFER, accumulate_.name());
  gl_.NamedFramebufferReadBuffer(accumulate_.name(), GL_COLOR_ATTACHMENT0);
  gl_.ReadPixels(0, 0, tile.width, tile.height, GL_RGBA, GL_FLOAT, rows.data());
  for (int y = 0; y < tile.height; ++y)
    std::copy_n(&rows[4 * width * static_cast<std::size_t>(y)], 4 * width, &image.rgba[4 * picture_row(y)]);
  const auto read_depths = [&](GLenum attachment, std::vector<float>& to, const auto& depth) {
    gl_.NamedFramebufferReadBuffer(accumulate_.name(), attachment);
    gl_.ReadPixels(0, 0, tile.width, tile.height, GL_RED, GL_FLOAT, rows.data());
    for (int y = 0; y < tile.height; ++y)
      for (std::size_t x = 0; x < width; ++x) to[picture_row(y) + x] = depth(rows[width * static_cast<std::size_t>(y) + x]);
  };
  if (nearest_)
    read_depths(GL_COLOR_ATTACHMENT1, image.depth, [&](float q) {
      return q > 0 ? static_cast<float>(depth_of(static_cast<double>(q))) : std::numeric_limits<float>::infinity();
    });
  if (mean_) read_depths(GL_COLOR_ATTACHMENT2, image.mean_depth, [&](float depth) { return static_cast<float>(depth * scale); });
}

}  // namespace isostrata
