// The protocol's messages in one expression each. What is left out has the server's default; nothing here is checked but the form
// of colours: the server judges, and says which field is wrong.
//
//   client.set_intervals({interval(0.1, 0.2, {.color = "#ff8000", .opacity = 0.8}), interval(0.3, 0.5, {.color_map =
//   "viridis"})});
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

using Vec3 = std::array<double, 3>;

/// "#rrggbb". Throws ClientError "bad_argument".
v1::Rgb rgb(const std::string& text);
v1::Vec3 vec3(const Vec3& xyz);

/// The looks of a boundary surface. Absent numbers have the defaults that the protocol names.
struct SurfaceLook {
  bool lower = true, upper = true, domain = false;  // which parts of the boundary
  std::string color = "";                           // "#rrggbb"; empty: the interval's
  std::optional<double> opacity = {}, ambient = {}, diffuse = {}, specular = {}, shininess = {};
  double silhouette = 0;
  std::string texture = "";  // "stripes" or a colour map; empty: none
  std::optional<double> texture_repeat = {};
};
v1::Surface surface(const SurfaceLook& look = {});

struct IntervalLook {
  std::string color = "";      // "#rrggbb"; empty: the server chooses by the interval's place
  std::string color_map = "";  // by name, over the color_by array; empty: the colour
  double opacity = 0.5;        // of a layer one unit distance thick, in [0, 1]
  std::optional<double> opacity_upper = {};
  bool own_range = false;
  int priority = 0;
  bool visible = true;
  std::string name = "";
  std::optional<SurfaceLook> surface = {};
};
/// The layer lower <= f <= upper. Its id is 0: the server gives it one.
v1::Interval interval(double lower, double upper, const IntervalLook& look = {});

/// One step of a combination: `op` of v1::RANGE_OPERATOR_INTERSECT, _UNITE, _SUBTRACT, _EXCLUSIVE_OR.
v1::RangeTerm range_term(v1::RangeOperator op, const std::string& array, double lower, double upper);
v1::TransferPoint transfer_point(double value, const std::string& color, double opacity);
/// Keeps what has dot(normal, position) >= offset.
v1::ClipPlane clip_plane(const Vec3& normal, double offset);

v1::Camera camera(const Vec3& eye, const Vec3& at, const Vec3& up, double fov_deg = 30, bool orthographic = false);
/// The camera turned about its `at`: to the right about its up direction by azimuth, then upwards by elevation. In degrees.
v1::Camera turned(const v1::Camera& camera, double azimuth_deg, double elevation_deg);
/// The camera nearer to its `at`: 2 shows everything twice as large.
v1::Camera zoomed(const v1::Camera& camera, double factor);

}  // namespace isostrata::client
