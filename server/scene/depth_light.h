// What a picture's depth adds to its light.
#pragma once

namespace isostrata {

struct DepthLight {
  double occlusion = 0;  // in [0, 1]: how dark hollows become, and what lies close behind an edge
  double fade = 0;       // in [0, 1]: how far what is far away fades into the background

  bool any() const { return occlusion > 0 || fade > 0; }
  bool operator==(const DepthLight&) const = default;
};

}  // namespace isostrata
