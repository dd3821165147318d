// The tile algorithm in OpenGL 4.5 compute shaders: one part of a picture of tetrahedra.
//
// Dispatches, in their order; shaders/tile_layout.h names the buffers:
//   tile_cover COUNT   tetrahedra -> how many tiles of 16 x 16 pixels each may cover
//   tile_scan          -> sums of all before, and the number of pairs
//   tile_cover FILL    -> pairs of key (tile, group, place in the order) and tetrahedron
//   tile_sort          COUNT, tile_scan, SCATTER for each 4 bits of the keys: a stable radix sort
//   tile_ranges        -> each tile's pairs and how many batches they make; tile_scan
//   tile_blend         in slices: batches -> (colour, what is let through) of each pixel; tile_blend.comp has the method
//   tile_merge         -> each tile's batches over one another, to 8 bits or floats
// Counts stay on the device: what follows them is dispatched indirectly. Buffers have room for what the last part needed and a
// quarter more; a part that needs more counts it, draws nothing, and is drawn again.
//
// Sources: rays against four planes instead of projected triangles: M. Weiler et al., "Hardware-Based Ray Casting for Tetrahedral
// Meshes", 2003; tiles sorted by one radix sort: B. Kerbl et al., "3D Gaussian Splatting for Real-Time Radiance Field Rendering",
// 2023; batches merged because over is associative: T. Porter, T. Duff, "Compositing Digital Images", 1984.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "rendering/compute/tile_layout.h"
#include "rendering/compute/tile_mesh.h"
#include "rendering/compute/tile_order.h"
#include "rendering/compute/tile_styles.h"
#include "rendering/gl/gl_compute.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// A part of the picture, pixels counted from its upper left.
struct TilePart {
  int x = 0, y = 0, width = 0, height = 0;
};

/// What all parts of a picture share.
struct TilePicture {
  const DrawInput* input = nullptr;
  const TileMesh* mesh = nullptr;
  const TileStyles* styles = nullptr;
  const TileOrder* order = nullptr;
};

/// What became of a part.
struct TileDrawn {
  bool too_many = false;  // more pairs than fit into a buffer of the device: draw it in smaller parts
  std::int64_t fragments = 0;
  std::int64_t late = 0;  // fragments that came after one that they lie before
};

class TilePipeline {
 public:
  explicit TilePipeline(ComputeDevice& device);

  /// Uploads what all parts share. Throws too_large.
  void begin(const TilePicture& picture);
  /// Draws a part and reads it back into the picture. Throws too_large, unavailable.
  TileDrawn draw(const TilePicture& picture, const TilePart& part, Image* bytes, FloatImage* floats);
  /// Nothing but the programs is kept, and nothing is known of what pictures need.
  void give_back();
  /// The longest side of a part.
  int largest_part() const { return largest_part_; }

  /// Since begin(), by stage: on a GPU by its own clock.
  const std::vector<StageTime>& stages() const { return stages_; }
  double readback_ms() const { return readback_ms_; }

 private:
  struct Programs;
  std::uint32_t most_batches() const { return static_cast<std::uint32_t>(device_.largest_buffer() / (TILE_GROUP * 16)); }
  GLuint program(const char* source, const std::string& defines);
  shaders::TileFrame frame_of(const TilePicture& picture, const TilePart& part) const;
  std::string blend_defines(const TilePicture& picture) const;
  void dispatch(GLuint program, std::uint64_t groups);
  void dispatch_indirect(GLuint program, std::uint32_t row);
  void blend(GLuint program);
  void plan_slices();
  void scan(const ComputeBuffer& elements, std::uint32_t count, std::uint32_t total);
  void sort(std::uint32_t bits);
  void run(const TilePicture& picture, std::uint32_t key_bits);
  void read(const TilePart& part, Image* bytes, FloatImage* floats, std::array<std::uint32_t, TILE_COUNTER_WORDS>& counters);

  void start_clock();
  void mark(const char* stage);
  void stop_clock();

  ComputeDevice& device_;
  const GlFunctions& gl_;
  int largest_part_ = 0;
  std::uint32_t most_pairs_ = 0, pair_room_ = 0, batch_room_ = 0, batch_size_ = 0, slices_ = 1;
  std::map<std::pair<const char*, std::string>, GlObject> programs_;
  ComputeBuffer frame_, counters_, styles_, clip_planes_, order_, sums_, partials_, pairs_, sorted_, groups_, ranges_, batches_,
      light_, nearest_, picture_, depth_;
  shaders::TileFrame current_{};

  struct Mark {
    const char* stage;
    GlObject query;
  };
  std::vector<Mark> marks_;
  std::vector<GlObject> spare_queries_;
  double last_ms_ = 0;
  std::vector<StageTime> stages_;
  double readback_ms_ = 0;
};

}  // namespace isostrata
