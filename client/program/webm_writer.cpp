#include "webm_writer.h"

#include <bit>
#include <cmath>

namespace isostrata::client {
namespace {

constexpr std::int64_t kMaxClusterMs = 30000;  // a block's time is 16 bits, signed
constexpr std::size_t kMaxClusterBytes = 8u << 20;

std::string number(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = bytes - 1; i >= 0; --i) out += static_cast<char>(value >> (8 * i));
  return out;
}
std::string whole(std::uint64_t value) {
  int bytes = 1;
  while (bytes < 8 && value >> (8 * bytes)) ++bytes;
  return number(value, bytes);
}
std::string real(double value) { return number(std::bit_cast<std::uint64_t>(value), 8); }

// An id is written as the standards print it. A size is 8 bytes: 1 in the first and the value in the others.
std::string id(std::uint32_t value) { return whole(value); }
std::string size(std::uint64_t value) { return number(value | 1ull << 56, 8); }
std::string element(std::uint32_t which, std::string_view content) {
  return id(which) + size(content.size()) + std::string(content);
}

}  // namespace

WebmWriter::WebmWriter(WholeFile& file, int width, int height, double fps, Matrix matrix) : file_(file) {
  file_.write(element(0x1A45DFA3, element(0x4286, whole(1)) +      // EBMLVersion
                                      element(0x42F7, whole(1)) +  // EBMLReadVersion
                                      element(0x42F2, whole(4)) +  // EBMLMaxIDLength
                                      element(0x42F3, whole(8)) +  // EBMLMaxSizeLength
                                      element(0x4282, "webm") + element(0x4287, whole(4)) + element(0x4285, whole(2))));
  file_.write(id(0x18538067));  // Segment
  segment_size_ = file_.size();
  file_.write(size(0));
  segment_ = file_.size();

  const std::string seek = element(0x53AB, id(0x1C53BB6B));  // Cues
  file_.write(id(0x114D9B74) + size(2 + 8 + seek.size() + 2 + 8 + 8) + id(0x4DBB) + size(seek.size() + 2 + 8 + 8) + seek +
              id(0x53AC) + size(8));
  seek_ = file_.size();
  file_.write(number(0, 8));

  const std::string facts = element(0x2AD7B1, whole(1000000)) +  // a tick is a millisecond
                            element(0x4D80, "isostrata") + element(0x5741, "isostrata");
  file_.write(id(0x1549A966) + size(facts.size() + 2 + 8 + 8) + facts + id(0x4489) + size(8));
  duration_ = file_.size();
  file_.write(number(0, 8));

  const std::string color = element(0x55B1, whole(matrix == Matrix::bt601 ? 6 : 1)) + element(0x55BA, whole(1)) + element(0x55BB, whole(1)) +  // as BT.709
                            element(0x55B9, whole(1)) +                             // the range of studios
                            element(0x55B3, whole(0)) + element(0x55B4, whole(0));  // 4:4:4
  const std::string video = element(0xB0, whole(static_cast<std::uint64_t>(width))) +
                            element(0xBA, whole(static_cast<std::uint64_t>(height))) + element(0x9A, whole(2)) +
                            element(0x55B0, color);
  file_.write(element(
      0x1654AE6B,
      element(0xAE, element(0xD7, whole(1)) + element(0x73C5, whole(1)) + element(0x83, whole(1)) + element(0x9C, whole(0)) +
                        element(0x86, "V_VP9") + element(0x23E383, whole(static_cast<std::uint64_t>(std::llround(1e9 / fps)))) +
                        element(0xE0, video))));
}

void WebmWriter::add(std::string_view frame, std::int64_t time_ms, bool key) {
  if (!blocks_.empty() && (key || time_ms - cluster_ms_ > kMaxClusterMs || blocks_.size() > kMaxClusterBytes)) end_cluster();
  if (blocks_.empty()) {
    cluster_ms_ = time_ms;
    cluster_has_key_ = key;
  }
  const auto in_cluster = static_cast<std::uint64_t>(time_ms - cluster_ms_);
  blocks_ += id(0xA3) + size(4 + frame.size()) + "\x81" + number(in_cluster, 2) + static_cast<char>(key ? 0x80 : 0);
  blocks_ += frame;
}

void WebmWriter::end_cluster() {
  if (cluster_has_key_) cues_.push_back({cluster_ms_, file_.size() - segment_});
  const std::string time = element(0xE7, whole(static_cast<std::uint64_t>(cluster_ms_)));
  file_.write(id(0x1F43B675) + size(time.size() + blocks_.size()) + time);
  file_.write(blocks_);
  blocks_.clear();
}

void WebmWriter::finish(std::int64_t duration_ms) {
  if (!blocks_.empty()) end_cluster();
  std::string points;
  for (const Cue& cue : cues_)
    points += element(0xBB, element(0xB3, whole(static_cast<std::uint64_t>(cue.time_ms))) +
                                element(0xB7, element(0xF7, whole(1)) + element(0xF1, whole(cue.cluster))));
  const std::uint64_t cues = file_.size() - segment_;
  file_.write(element(0x1C53BB6B, points));
  file_.patch(seek_, number(cues, 8));
  file_.patch(duration_, real(static_cast<double>(duration_ms)));
  file_.patch(segment_size_, size(file_.size() - segment_));
}

}  // namespace isostrata::client
