// Where to stand so that what the layers show is seen.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/derived/proxy_grid.h"
#include "engine/first/layer_choice.h"
#include "scene/camera.h"

namespace isostrata {

struct UpChoice {
  Vec3d up{0, 0, 1};
  std::string reason;
};

/// An object that is cut off by one face of its box stands on it; of a CT head the skull's ring is up; else z, or y where the box
/// lies in the plane z.
UpChoice choose_up(const ProxyGrid& proxy, const LayersChoice& layers, const FieldHints& hints);

struct ViewChoice {
  Vec3d direction{0, 0, 1};  // from what is looked at to the eye
  Vec3d up{0, 1, 0};
  std::vector<Vec3d> outline;  // world: points that a picture must hold, the farthest ones in many directions
  std::string reason;
};

/// The best of 24 views by how much of each layer is seen, how deep it is, and how far the inner layer lies before the outer
/// (after P.-P. Vazquez and others, "Viewpoint Selection using Viewpoint Entropy", 2001, with samples in place of faces). whole:
/// the picture must hold the whole domain.
ViewChoice choose_view(const ProxyGrid& proxy, const LayersChoice& layers, const UpChoice& up, bool whole);

/// As near as may be with all of the outline in the picture, with a margin. fov in degrees.
Camera camera_on(const ViewChoice& view, double aspect);

}  // namespace isostrata
