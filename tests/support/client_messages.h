// What clients say, as tests need it.
#pragma once

#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <string>

#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {

/// Looks at the origin from (x, 0, z).
inline v1::ClientMessage camera_at(double x, double z = 9) {
  v1::ClientMessage message;
  v1::Camera& camera = *message.mutable_set_camera()->mutable_camera();
  camera.mutable_eye()->set_x(x);
  camera.mutable_eye()->set_z(z);
  camera.mutable_at();
  camera.mutable_up()->set_y(1);
  camera.set_fov_deg(30);
  return message;
}

/// A failure if the text is none.
inline v1::ClientMessage message_of(const std::string& json) {
  v1::ClientMessage message;
  const auto done = google::protobuf::util::JsonStringToMessage(json, &message);
  EXPECT_TRUE(done.ok()) << json << ": " << done.ToString();
  return message;
}

}  // namespace isostrata
