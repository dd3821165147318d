// One layer in numbers, for whoever asks.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/vec.h"
#include "scene/scene.h"

namespace isostrata {

/// Means are over the solid: each part counts by its volume, of a flat grid by its area.
struct LayerStatistics {
  std::string array;
  bool flat = false;       // areas stand in place of volumes
  double volume = 0;
  Vec3d centroid;          // of the solid, in the dataset's space; of nothing: the origin
  std::int64_t pieces = 0;  // that do not touch each other, not in a point either
  double largest = 0;      // the volume of the largest
  double valued = 0;       // the volume in which the array has finite values; those that follow are said of it, if it is not 0
  double lower = 0, upper = 0, mean = 0, standard_deviation = 0;
};

/// Answered by LayerStatisticsReady or RequestFailed.
struct LayerStatisticsRequest {
  std::uint64_t session = 0;  // SessionKey
  std::uint64_t request = 0;  // RequestId
  Scene scene;
  std::uint32_t interval = 0;  // its id
  std::string array;           // empty: the scene's
};

struct LayerStatisticsReady {
  std::uint64_t session = 0;
  std::uint64_t request = 0;
  std::uint64_t revision = 0;  // of the scene that was measured
  std::uint32_t interval = 0;
  LayerStatistics of;
};

}  // namespace isostrata
