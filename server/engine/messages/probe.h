// What is asked at a place of the picture, and what is there.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/vec.h"
#include "scene/scene.h"

namespace isostrata {

/// What the ray comes through where it enters a layer.
enum class ProbeEnd {
  lower,   // where f = lower
  upper,   // where f = upper
  domain,  // where the grid ends
  range,   // the end of another array's range, with which the layers are combined
  cut,     // a clip plane
  eye      // none: the eye is inside
};

struct ProbedArray {
  std::string name;
  std::optional<double> value;       // as the layers are drawn: interpolated, or of the whole cell; nothing where a value there is not finite
  std::optional<double> cell_value;  // of an array that the file has on cells: that of the cell
};

/// The first that is seen along a ray.
struct ProbeFacts {
  bool hit = false;
  std::string miss;  // why not
  Vec3d position;
  double distance = 0;         // from the eye, in world units; with parallel rays from the plane through it
  std::uint32_t interval = 0;  // its id; 0: what a term has brought in
  int term = -1;               // that term, where there is no interval
  ProbeEnd end = ProbeEnd::domain;
  std::int64_t cell = -1, point = -1;  // the cell that begins there (-1: not found), and the nearest of its points
  bool structured = false;
  std::array<std::int64_t, 3> cell_index{}, point_index{};  // of a structured grid
  int step = 0;                // that is shown there: of a smear the layer's own
  std::optional<double> time;  // in place of the step
  std::vector<ProbedArray> arrays;  // the scene's array, then the one that colours run over, then the others as the dataset has them
};

/// A pixel's size matters to nobody: the place is a point, (0, 0) the upper left corner of a picture as wide and high as said, (1, 1) the lower right one.
/// Answered by ProbeReady or RequestFailed.
struct ProbeRequest {
  std::uint64_t session = 0;  // SessionKey
  std::uint64_t request = 0;  // RequestId
  Scene scene;
  double x = 0.5, y = 0.5;
  int width = 800, height = 600;
};

struct ProbeReady {
  std::uint64_t session = 0;
  std::uint64_t request = 0;
  std::uint64_t revision = 0;  // of the scene that was probed
  ProbeFacts facts;
};

}  // namespace isostrata
