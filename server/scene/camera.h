// Where the viewer stands, in world space: the dataset's, as it is drawn (axis_scale.h). Angles in degrees.
#pragma once

#include <string_view>

#include "base/vec.h"

namespace isostrata {

struct Camera {
  Vec3d eye{0, 0, 1};
  Vec3d at{0, 0, 0};
  Vec3d up{0, 1, 0};
  double fov_deg = 30;        // full vertical angle of view
  bool orthographic = false;  // parallel rays; what is as far away as `at` is as large as in perspective

  bool operator==(const Camera&) const = default;
};

/// Half of what is seen vertically, in world units, at the distance of `at`: what an orthographic camera sees everywhere.
double half_height(const Camera& camera);

/// Throws invalid_argument if eye == at, up is parallel to the view, fov is not in (0, 180), or a number is not finite.
void check(const Camera& camera);

/// Looks at the whole box from a named side: "reset" (a three-quarter view), "+x", "-x", "+y", "-y", "+z", "-z". aspect: the
/// picture's width over its height; from a tall narrow one the box is farther away, so that its width shows too. The sphere about the box fits, or,
/// from an end of a long box, the box itself. From the four sides z is up.
Camera view_of(const Box3d& bounds, std::string_view side, double aspect = 1, bool orthographic = false);

/// Right-handed, looking down -z.
Mat4d view_from_world(const Camera& camera);

/// "eye=x,y,z;at=x,y,z;up=x,y,z;fov=deg;projection=perspective|orthographic", every part optional over `base`, or a view name
/// that view_of knows, alone or as its first part ("+x;projection=orthographic"). Throws invalid_argument naming the part.
Camera parse_camera(std::string_view text, const Camera& base, const Box3d& bounds, double aspect = 1);

}  // namespace isostrata
