// One line of `isostrata-peer-bench render`, as a table and as JSON.
#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "base/image.h"
#include "extraction/mesh/interval_mesh.h"
#include "spread.h"

namespace isostrata::peers {

/// How far two pictures are apart, in steps of 8 bits, over the pixels that are not background in one of them.
struct PictureDifference {
  std::int64_t pixels = 0;
  double mean = 0, max = 0;
};

/// Colours only. Both must have one size; the background is what the first pixel of `a` shows.
PictureDifference difference(const Image& a, const Image& b);

struct RenderRow {
  std::string data, mode;  // "constant", "linear"
  Interval interval;
  int size = 0;  // of the square picture
  std::int64_t tetrahedra = 0;
  double fragments_per_tetrahedron = 0, depth_complexity = 0;

  std::string renderer, order;  // ours
  std::string peer;             // empty: ours alone
  Spread ours, theirs;
  PictureDifference apart;
  double aim = 0;            // the ratio wished for; 0: none
  double aim_fps = 0;        // our frames per second wished for
  double aim_fragments = 0;  // our fragments per second wished for

  double ratio() const { return ours.median > 0 ? theirs.median / ours.median : 0; }
  double ratio_of_minima() const { return ours.min > 0 ? theirs.min / ours.min : 0; }  // less of a neighbour's noise
  double fps() const { return ours.median > 0 ? 1000 / ours.median : 0; }
  double tetrahedra_per_second() const { return fps() * static_cast<double>(tetrahedra); }
  double fragments_per_second() const { return tetrahedra_per_second() * fragments_per_tetrahedron; }
};

boost::json::object to_json(const RenderRow& row);
void print_text(const RenderRow& row);

}  // namespace isostrata::peers
