// What is drawn beside the volume.
#pragma once

namespace isostrata {

/// What a viewer wants to see of box, axes and legend.
struct Annotations {
  bool axes = false;    // numbered axes on the box's outline, and a triad of directions in the lower left corner
  bool box = false;     // the bounding box's edges
  bool legend = false;  // swatches with the intervals' ranges, and a bar for each colour map
  bool any() const { return axes || box || legend; }
  bool operator==(const Annotations&) const = default;
};

}  // namespace isostrata
