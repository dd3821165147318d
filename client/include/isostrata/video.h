// VP9 4:4:4 by libvpx: frames in motion at a third of JPEG's bytes. A target of its own, isostrata::video, so that the library
// itself needs no libvpx:
//
//   Client client({.url = url, .moving_formats = video_formats()});
//   FrameDecoder decoder(video_decoder);
//   while (auto shown = client.next_picture(decoder, std::chrono::seconds(1))) show(shown->picture);
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "isostrata/frames.h"

namespace isostrata::client {

/// The formats of frames in motion that can be decoded with it, the best first: for Options.moving_formats.
std::vector<std::string> video_formats();

/// A VideoDecoders: of "vp9-444", null for others.
std::unique_ptr<VideoDecoder> video_decoder(const std::string& format);

}  // namespace isostrata::client
