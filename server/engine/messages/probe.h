// What is asked at a place of the picture, along a line, and over the steps, and what is there.
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
  std::optional<double> value;       // as the layers are drawn: interpolated, or of the whole cell; nothing if a value there is not finite
  std::optional<double> cell_value;  // of an array that the file has on cells: that of the cell
};

/// The first that is seen along a ray.
struct ProbeFacts {
  bool hit = false;
  std::string miss;  // why not
  Vec3d position;
  double distance = 0;         // from the eye, in world units; with parallel rays from the plane through it
  std::uint32_t interval = 0;  // its id; 0: what a term has brought in
  int term = -1;               // that term, if there is no interval
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

/// A stretch of a line that lies in a layer that is shown.
struct ProbedStretch {
  double from = 0, to = 0;     // distances
  std::uint32_t interval = 0;  // as ProbeFacts
  int term = -1;
};

/// The values of an array along a line, or at a place over all steps. Between two neighbours the value runs straight.
struct CurveFacts {
  std::string array;
  std::vector<double> at;      // [n] rising: the distance from the line's first point in the dataset's space, or the steps
  std::vector<double> values;  // [n] NaN: there is none; along a line that begins a gap. Where two lie at one distance, the value jumps
  bool thinned = false;        // a line's samples were more; what is left keeps the least and the greatest of each small stretch
  std::vector<ProbedStretch> layers;  // of a line, by layer and distance
  int step = 0;                       // of a line
  std::optional<double> time;         // in place of the step
  bool grids_differ = false;          // over the steps: the grid is not the same at all of them
};

/// Answered by CurveReady or RequestFailed.
struct CurveRequest {
  std::uint64_t session = 0;  // SessionKey
  std::uint64_t request = 0;  // RequestId
  Scene scene;
  std::string array;        // empty: the scene's
  Vec3d from;               // in the dataset's space
  std::optional<Vec3d> to;  // none: at `from`, over all steps
};

struct CurveReady {
  std::uint64_t session = 0;
  std::uint64_t request = 0;
  std::uint64_t revision = 0;  // of the scene that was probed
  CurveFacts facts;
};

}  // namespace isostrata
