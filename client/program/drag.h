// What a person sees who drags: inputs go out at the rate of a display, frames come back, and each is timed.
//
// An input's latency is the time from sending it to having decoded the first frame that contains it (Frame.input_seq), taken over
// every input that was sent while frames were coming: those that a newer one overtook count too, and have waited longest.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "isostrata/client.h"

namespace isostrata::client {

struct DragArguments {
  bool camera = false;  // turn the camera; else drag the first interval's upper end
  double seconds = 5;
  double inputs_per_second = 60;
  double degrees_per_input = 1.5;  // of the camera
  int viewers = 0;                 // more connections to the session that take every frame and acknowledge it
  int silent = 0;                  // and that never read
};

/// One frame as it arrived. Times in ms of the machine's steady clock.
struct DraggedFrame {
  double decoded_at_ms = 0;
  double input_at_ms = 0;  // when the newest input that it shows was sent
  double bytes = 0;
  double decode_ms = 0, extract_ms = 0, draw_ms = 0, encode_ms = 0;
  int width = 0, height = 0;
  std::string format;
  std::string forecasts;  // "jpeg 12.3 vp9-444 20.1": what the server expected of each, ms
};

struct InputLatency {
  double sent_at_ms = 0, latency_ms = 0;
};

struct Dragged {
  double began_at_ms = 0, seconds = 0;
  std::size_t inputs = 0;
  std::vector<InputLatency> latency;
  std::vector<DraggedFrame> frames;        // while inputs went out
  std::vector<double> viewers_latency_ms;  // of every frame of every other viewer, to its arrival
  std::size_t viewers_frames = 0;
  std::int64_t tetrahedra = 0;
  std::string device;
  // Afterwards, from the last input to the lossless frame of it, decoded.
  double rest_to_settled_ms = 0;  // 0: none came before the lossless one
  double rest_to_lossless_ms = 0;
  double lossless_bytes = 0;
  Picture lossless;
};

/// Drags, then rests until the lossless frame has come. The camera comes back to where it was. Throws ClientError.
Dragged drag(Client& client, const Options& options, const DragArguments& arguments);

}  // namespace isostrata::client
