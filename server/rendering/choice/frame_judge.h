// Which of two renderers draws a mesh sooner, told from the frames that are drawn of it anyway.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "extraction/mesh/interval_mesh.h"

namespace isostrata {

/// Each mesh is drawn by the renderer that is taken at first, until one of its frames that is not the first takes long; then twice by the other, whose
/// first frame, which may send or lay out the mesh, does not count either; from then on by the quicker of both. One thread.
class FrameJudge {
 public:
  static constexpr double kLongMs = 12;  // what is drawn in less is not worth a trial

  using Mesh = std::shared_ptr<const IntervalMesh>;

  /// Whether the next frame is the other's.
  bool other_is_next(const Mesh& mesh) {
    const Judged& of = find(mesh);
    if (of.first_ms < kLongMs) return false;  // not known yet, or short
    return of.others < 2 || of.other_ms < of.first_ms;
  }
  void took(const Mesh& mesh, bool other, double ms) {
    Judged& of = find(mesh);
    if (other) {
      if (++of.others > 1) of.other_ms = ms;
    } else if (++of.firsts > 1) {
      of.first_ms = ms;
    }
  }

 private:
  struct Judged {
    std::weak_ptr<const IntervalMesh> mesh;
    int firsts = 0, others = 0;            // frames of each
    double first_ms = 0, other_ms = 0;     // of the last ones
  };
  Judged& find(const Mesh& mesh) {
    std::erase_if(judged_, [](const Judged& of) { return of.mesh.expired(); });
    const auto known = std::find_if(judged_.begin(), judged_.end(), [&](const Judged& of) { return of.mesh.lock() == mesh; });
    return known != judged_.end() ? *known : judged_.emplace_back(Judged{mesh});
  }

  std::vector<Judged> judged_;
};

}  // namespace isostrata
