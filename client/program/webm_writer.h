// A WebM file of one VP9 track: the part of Matroska (RFC 9559, on EBML, RFC 8794) that players need, cues for seeking included.
// Debian's libwebm reads only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "whole_file.h"
#include "yuv444.h"

namespace isostrata::client {

/// Frames are gathered into clusters, each beginning with a key frame if it can.
class WebmWriter {
 public:
  /// Writes the head. The file outlives this.
  WebmWriter(WholeFile& file, int width, int height, double fps, Matrix matrix);
  /// Frames in the order of their times.
  void add(std::string_view frame, std::int64_t time_ms, bool key);
  /// Writes cues and what the head did not know yet.
  void finish(std::int64_t duration_ms);

 private:
  struct Cue {
    std::int64_t time_ms;
    std::uint64_t cluster;  // from the beginning of the segment's content
  };
  void end_cluster();

  WholeFile& file_;
  std::uint64_t segment_ = 0;       // where its content begins
  std::uint64_t segment_size_ = 0;  // where its size is written, 8 bytes
  std::uint64_t seek_ = 0;          // where the cues' position is written, 8 bytes
  std::uint64_t duration_ = 0;      // where the duration is written, 8 bytes
  std::vector<Cue> cues_;
  std::string blocks_;  // of the open cluster
  std::int64_t cluster_ms_ = 0;
  bool cluster_has_key_ = false;
};

}  // namespace isostrata::client
