#include "rendering/gl/gl_objects.h"

#include <initializer_list>
#include <vector>

#include "base/error.h"
#include "rendering/shader_sources.h"

namespace isostrata {
namespace {

GlObject make_shader(const GlFunctions& gl, GLenum stage, const char* shared_source, const char* source,
                     const std::string& defines) {
  GlObject shader(&gl, gl.CreateShader(stage), [](const GlFunctions& f, GLuint name) { f.DeleteShader(name); });
  const char* parts[] = {"#version 450 core\n", defines.c_str(), shaders::layout_h, shared_source, source};
  gl.ShaderSource(shader.name(), 5, parts, nullptr);
  gl.CompileShader(shader.name());
  GLint ok = 0;
  gl.GetShaderiv(shader.name(), GL_COMPILE_STATUS, &ok);
  if (!ok) {
    std::vector<char> log(4096, '\0');
    gl.GetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw Error(ErrorCode::internal, std::string("a shader does not compile: ") + log.data());
  }
  return shader;
}

GlObject link_program(const GlFunctions& gl, std::initializer_list<GLuint> shaders) {
  GlObject program(&gl, gl.CreateProgram(), [](const GlFunctions& f, GLuint n) { f.DeleteProgram(n); });
  for (const GLuint shader : shaders) gl.AttachShader(program.name(), shader);
  gl.LinkProgram(program.name());
  GLint ok = 0;
  gl.GetProgramiv(program.name(), GL_LINK_STATUS, &ok);
  if (!ok) {
    std::vector<char> log(4096, '\0');
    gl.GetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
    throw Error(ErrorCode::internal, std::string("a program does not link: ") + log.data());
  }
  return program;
}

}  // namespace

GlObject make_buffer(const GlFunctions& gl) {
  GLuint name = 0;
  gl.CreateBuffers(1, &name);
  return {&gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteBuffers(1, &n); }};
}

GlObject make_texture(const GlFunctions& gl, GLenum target) {
  GLuint name = 0;
  gl.CreateTextures(target, 1, &name);
  return {&gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteTextures(1, &n); }};
}

GlObject make_framebuffer(const GlFunctions& gl) {
  GLuint name = 0;
  gl.CreateFramebuffers(1, &name);
  return {&gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteFramebuffers(1, &n); }};
}

GlObject make_vertex_array(const GlFunctions& gl) {
  GLuint name = 0;
  gl.CreateVertexArrays(1, &name);
  return {&gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteVertexArrays(1, &n); }};
}

GlObject make_query(const GlFunctions& gl, GLenum target) {
  GLuint name = 0;
  gl.CreateQueries(target, 1, &name);
  return {&gl, name, [](const GlFunctions& f, GLuint n) { f.DeleteQueries(1, &n); }};
}

GlObject make_program(const GlFunctions& gl, const char* vertex_source, const char* fragment_source, const std::string& defines) {
  const GlObject vertex = make_shader(gl, GL_VERTEX_SHADER, "", vertex_source, defines);
  const GlObject fragment = make_shader(gl, GL_FRAGMENT_SHADER, "", fragment_source, defines);
  return link_program(gl, {vertex.name(), fragment.name()});
}

GlObject make_compute_program(const GlFunctions& gl, const char* shared_source, const char* source, const std::string& defines) {
  const GlObject shader = make_shader(gl, GL_COMPUTE_SHADER, shared_source, source, defines);
  return link_program(gl, {shader.name()});
}

GlObject make_texture_2d(const GlFunctions& gl, GLenum format, int width, int height) {
  GlObject texture = make_texture(gl, GL_TEXTURE_2D);
  gl.TextureStorage2D(texture.name(), 1, format, width, height);
  if (const GLenum error = gl.GetError(); error != GL_NO_ERROR)
    throw Error(ErrorCode::too_large,
                "the device has no room for a texture of " + std::to_string(width) + "x" + std::to_string(height));
  gl.TextureParameteri(texture.name(), GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TextureParameteri(texture.name(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  gl.TextureParameteri(texture.name(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TextureParameteri(texture.name(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  return texture;
}

}  // namespace isostrata
