// The pictures that servers send, as pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace isostrata::client {

/// A decoded picture, 8 bits a channel, row 0 at the top.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;  // [height][width][3]
};

/// JPEG, or PNG of 8-bit RGB or RGBA without interlacing, which is what servers send. Throws ClientError "bad_image".
Picture decode(const std::string& bytes);

}  // namespace isostrata::client
