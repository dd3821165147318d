// A camera that flies through keyframes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata::client {

struct Keyframe {
  double time_s = 0;  // of the film
  v1::Camera camera;
  std::optional<double> data_time;  // that is shown, in the dataset's units
};

/// Positions looked at run on cubic curves through the keyframes (E. Catmull and R. Rom, "A class of local interpolating
/// splines", 1974), distances on such curves of their logarithms, orientations on spherical quadrangle curves (K. Shoemake,
/// "Quaternion calculus and fast animation", 1987), angles of view and data times on lines. At a keyframe's time the camera is
/// the keyframe's.
class CameraPath {
 public:
  /// At least two keyframes, times rising. Throws ClientError "bad_argument".
  explicit CameraPath(std::vector<Keyframe> keyframes, std::optional<double> fps = {});

  /// {"fps":30,"keyframes":[{"time":0,"camera":{"eye":[x,y,z],"at":[x,y,z],"up":[x,y,z],"fov":deg,"orthographic":false},"data_time":t},
  /// ...]} Cameras may also be written as a saved state's ({"eye":{"x":...},"fovDeg":...}). What a keyframe leaves out is as in
  /// the one before it; before the first it is `start`. `name` stands in errors. Throws ClientError "bad_argument".
  static CameraPath from_json(const std::string& text, const std::string& name, const v1::Camera& start);

  double duration_s() const { return keyframes_.back().time_s - keyframes_.front().time_s; }
  /// That the file asks for.
  std::optional<double> fps() const { return fps_; }
  /// `time_s` counts from the first keyframe; beyond the ends it is the end.
  v1::Camera camera_at(double time_s) const;
  std::optional<double> data_time_at(double time_s) const;

 private:
  std::size_t segment_of(double time_s, double& u) const;

  std::vector<Keyframe> keyframes_;
  std::optional<double> fps_;
};

}  // namespace isostrata::client
