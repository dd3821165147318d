// Structs that C++ and GLSL share, and what becomes of a context that is lost or full.
#include "rendering/gl/gl_compute.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>

#include "base/error.h"
#include "rendering/gl/layout.h"
#include "support/test_device.h"

namespace isostrata {
namespace {

using testing::test_device;
using ::testing::HasSubstr;

ComputeDevice open_device() { return ComputeDevice(open_context(test_device())); }

struct Member {
  const char* name;  // as the driver calls it
  std::size_t offset;
};

/// Compares the driver's offsets of a struct's members, and the distance between two structs, with C++'s.
void expect_layout(const std::string& type, std::size_t size, const std::vector<Member>& members) {
  ComputeDevice device = open_device();
  const GlFunctions& gl = device.gl();
  std::string sum;
  for (const Member& member : members) sum += " + uint(all_of[i]." + std::string(member.name) + ")";
  const std::string source = "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer In { " + type +
                             " all_of[]; };\nlayout(std430, binding = 1) buffer Out { uint total; };\n"
                             "void main() { uint i = gl_WorkGroupID.x; total = 0u" +
                             sum + "; }\n";
  const GlObject program = make_compute_program(gl, "", source.c_str(), "");
  for (const Member& member : members) {
    const GLuint index =
        gl.GetProgramResourceIndex(program.name(), GL_BUFFER_VARIABLE, ("all_of[0]." + std::string(member.name)).c_str());
    ASSERT_NE(index, GL_INVALID_INDEX) << type << "." << member.name;
    const GLenum properties[] = {GL_OFFSET, GL_TOP_LEVEL_ARRAY_STRIDE};
    GLint values[2] = {-1, -1};
    gl.GetProgramResourceiv(program.name(), GL_BUFFER_VARIABLE, index, 2, properties, 2, nullptr, values);
    EXPECT_EQ(static_cast<std::size_t>(values[0]), member.offset) << type << "." << member.name;
    EXPECT_EQ(static_cast<std::size_t>(values[1]), size) << type;
  }
  EXPECT_EQ(members.size() * sizeof(std::uint32_t), size) << type << ": a member is not named here";
}

#define MEMBER(type, name) \
  { #name, offsetof(shaders::type, name) }

TEST(ComputeLayout, RecordsAndPointsAreTheSameInBothLanguages) {
  expect_layout("CellRecord", sizeof(shaders::CellRecord), {MEMBER(CellRecord, cell), MEMBER(CellRecord, case_interval)});
  expect_layout("MeshPointOrigin", sizeof(shaders::MeshPointOrigin),
                {MEMBER(MeshPointOrigin, point), MEMBER(MeshPointOrigin, slot)});
  expect_layout("IntervalTally", sizeof(shaders::IntervalTally),
                {MEMBER(IntervalTally, records), MEMBER(IntervalTally, tetrahedra)});
}

TEST(ComputeLayout, KeysAndCountersAreTheSameInBothLanguages) {
  expect_layout(
      "IsoRange", sizeof(shaders::IsoRange),
      {MEMBER(IsoRange, lower_high), MEMBER(IsoRange, lower_low), MEMBER(IsoRange, upper_high), MEMBER(IsoRange, upper_low)});
  expect_layout("IsoKeys", sizeof(shaders::IsoKeys),
                {MEMBER(IsoKeys, lower_high), MEMBER(IsoKeys, lower_low), MEMBER(IsoKeys, last_high), MEMBER(IsoKeys, last_low),
                 MEMBER(IsoKeys, reach_high), MEMBER(IsoKeys, reach_low), MEMBER(IsoKeys, interval), MEMBER(IsoKeys, unused)});
  expect_layout(
      "IsoLevel", sizeof(shaders::IsoLevel),
      {MEMBER(IsoLevel, below_high), MEMBER(IsoLevel, below_low), MEMBER(IsoLevel, value_high), MEMBER(IsoLevel, value_low)});
  expect_layout("WorkGroups", sizeof(shaders::WorkGroups),
                {MEMBER(WorkGroups, x), MEMBER(WorkGroups, y), MEMBER(WorkGroups, z), MEMBER(WorkGroups, first)});
  expect_layout(
      "ExtractionCounters", sizeof(shaders::ExtractionCounters),
      {MEMBER(ExtractionCounters, bricks), MEMBER(ExtractionCounters, records), MEMBER(ExtractionCounters, tetrahedra),
       MEMBER(ExtractionCounters, points), MEMBER(ExtractionCounters, active_cells), MEMBER(ExtractionCounters, balance),
       MEMBER(ExtractionCounters, any_absent), MEMBER(ExtractionCounters, unused), MEMBER(ExtractionCounters, tiles)});
  EXPECT_EQ(offsetof(shaders::ExtractionCounters, bricks), COUNT_BRICKS * sizeof(std::uint32_t));
  EXPECT_EQ(offsetof(shaders::ExtractionCounters, records), COUNT_RECORDS * sizeof(std::uint32_t));
  EXPECT_EQ(offsetof(shaders::ExtractionCounters, points), COUNT_POINTS * sizeof(std::uint32_t));
  EXPECT_EQ(offsetof(shaders::ExtractionCounters, tiles), COUNT_TILES * sizeof(std::uint32_t));
}

TEST(ComputeLayout, TheGridsUniformBlockIsTheSameInBothLanguages) {
  ComputeDevice device = open_device();
  const GlFunctions& gl = device.gl();
  const std::vector<Member> members{MEMBER(ExtractionGrid, points_x),
                                    MEMBER(ExtractionGrid, points_y),
                                    MEMBER(ExtractionGrid, points_z),
                                    MEMBER(ExtractionGrid, bricks_x),
                                    MEMBER(ExtractionGrid, bricks_y),
                                    MEMBER(ExtractionGrid, bricks_z),
                                    MEMBER(ExtractionGrid, rules),
                                    MEMBER(ExtractionGrid, isovalues),
                                    MEMBER(ExtractionGrid, brick_capacity),
                                    MEMBER(ExtractionGrid, record_capacity),
                                    MEMBER(ExtractionGrid, tetrahedron_capacity),
                                    MEMBER(ExtractionGrid, point_capacity)};
  EXPECT_EQ(members.size() * sizeof(std::uint32_t), sizeof(shaders::ExtractionGrid));
  const GlObject program = make_compute_program(
      gl, "",
      "layout(local_size_x = 1) in;\nlayout(std140, binding = BLOCK_GRID) uniform GridBlock { ExtractionGrid grid; };\n"
      "layout(std430, binding = 1) buffer Out { ExtractionGrid copied; };\nvoid main() { copied = grid; }\n",
      "");
  for (const Member& member : members) {
    const GLuint index =
        gl.GetProgramResourceIndex(program.name(), GL_UNIFORM, ("GridBlock.grid." + std::string(member.name)).c_str());
    const GLuint plain = index != GL_INVALID_INDEX ? index
                                                   : gl.GetProgramResourceIndex(program.name(), GL_UNIFORM,
                                                                                ("grid." + std::string(member.name)).c_str());
    ASSERT_NE(plain, GL_INVALID_INDEX) << member.name;
    const GLenum property = GL_OFFSET;
    GLint offset = -1;
    gl.GetProgramResourceiv(program.name(), GL_UNIFORM, plain, 1, &property, 1, nullptr, &offset);
    EXPECT_EQ(static_cast<std::size_t>(offset), member.offset) << member.name;
  }
}

TEST(RasterLayout, TheFramesUniformBlockIsTheSameInBothLanguages) {
  ComputeDevice device = open_device();
  const GlFunctions& gl = device.gl();
  const std::vector<Member> members{MEMBER(RasterFrame, view_x),
                                    MEMBER(RasterFrame, view_y),
                                    MEMBER(RasterFrame, view_z),
                                    MEMBER(RasterFrame, screen),
                                    MEMBER(RasterFrame, picture),
                                    MEMBER(RasterFrame, clip_from_pixels),
                                    MEMBER(RasterFrame, ray_from_fragment),
                                    MEMBER(RasterFrame, table),
                                    MEMBER(RasterFrame, counts),
                                    MEMBER(RasterFrame, axis)};
  EXPECT_EQ(members.size() * sizeof(shaders::vec4), sizeof(shaders::RasterFrame)) << "a member is not named here";
  const GlObject program = make_compute_program(
      gl, "",
      "layout(local_size_x = 1) in;\nlayout(std140, binding = BLOCK_FRAME) uniform FrameBlock { RasterFrame frame; };\n"
      "layout(std430, binding = 1) buffer Out { RasterFrame copied; };\n"
      "layout(std430, binding = 2) buffer Corners { FacetCorner corners[]; };\n"
      "void main() { copied = frame; corners[1].normal_texture = frame.view_x; }\n",
      "");
  for (const Member& member : members) {
    const GLuint index = gl.GetProgramResourceIndex(program.name(), GL_UNIFORM, ("frame." + std::string(member.name)).c_str());
    ASSERT_NE(index, GL_INVALID_INDEX) << member.name;
    const GLenum property = GL_OFFSET;
    GLint offset = -1;
    gl.GetProgramResourceiv(program.name(), GL_UNIFORM, index, 1, &property, 1, nullptr, &offset);
    EXPECT_EQ(static_cast<std::size_t>(offset), member.offset) << member.name;
  }
  const GLuint corner = gl.GetProgramResourceIndex(program.name(), GL_BUFFER_VARIABLE, "corners[0].normal_texture");
  ASSERT_NE(corner, GL_INVALID_INDEX);
  const GLenum properties[] = {GL_OFFSET, GL_TOP_LEVEL_ARRAY_STRIDE};
  GLint values[2] = {-1, -1};
  gl.GetProgramResourceiv(program.name(), GL_BUFFER_VARIABLE, corner, 2, properties, 2, nullptr, values);
  EXPECT_EQ(static_cast<std::size_t>(values[0]), offsetof(shaders::FacetCorner, normal_texture));
  EXPECT_EQ(static_cast<std::size_t>(values[1]), sizeof(shaders::FacetCorner));
}

TEST(ComputeDevice, RefusesABufferAboveTheBudgetOrTheDevicesLimitWithTheNumbers) {
  ComputeDevice device = open_device();
  ComputeBuffer small, large;
  device.set_budget(1 << 20);
  device.reserve(small, 1 << 19, "half of it");
  EXPECT_EQ(device.allocated(), 1u << 19);
  try {
    device.reserve(large, (1 << 19) + 1, "more than half");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::too_large);
    EXPECT_THAT(error.what(), HasSubstr("more than half would need 524304 bytes; 524288 of 1048576 are in use"));
  }
  device.free(small);
  EXPECT_EQ(device.allocated(), 0u);
  device.reserve(large, 1 << 20, "all of it");
  device.set_budget(~std::uint64_t{0});
  ComputeBuffer huge;
  EXPECT_THROW(device.reserve(huge, device.largest_buffer() + 1, "too much"), Error);
  EXPECT_EQ(device.allocated(), 1u << 20);
}

// As a driver does after it has reset a device: llvmpipe never does, so its function is replaced.
TEST(ComputeDevice, SaysThatTheDeviceWasLost) {
  auto context = open_context(test_device());
  auto& functions = const_cast<GlFunctions&>(context->gl());
  ComputeDevice device(std::move(context));
  EXPECT_NO_THROW(device.finish(Task()));
  functions.GetGraphicsResetStatus = [] { return static_cast<GLenum>(GL_INNOCENT_CONTEXT_RESET); };
  try {
    device.finish(Task());
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::unavailable);
    EXPECT_THAT(error.what(), HasSubstr("reset"));
  }
}

TEST(ComputeDevice, ReadsWhatWasUploadedPieceByPiece) {
  ComputeDevice device = open_device();
  const Task task;
  std::vector<std::uint32_t> values((20 << 20) / 4), read(values.size() - 3);  // more than one piece
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint32_t>(i * 2654435761u);
  ComputeBuffer buffer;
  device.reserve(buffer, values.size() * 4, "values");
  device.upload(buffer, 0, std::as_bytes(std::span(values)), task);
  device.read(buffer, 12, std::as_writable_bytes(std::span(read)), task);
  EXPECT_TRUE(std::equal(read.begin(), read.end(), values.begin() + 3));
  device.clear(buffer, 16);
  device.read(buffer, 0, std::as_writable_bytes(std::span(read).first(5)), task);
  EXPECT_EQ(std::vector(read.begin(), read.begin() + 5), (std::vector<std::uint32_t>{0, 0, 0, 0, values[4]}));
}

}  // namespace
}  // namespace isostrata
