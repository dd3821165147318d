// One line of the comparison, as a table and as JSON.
#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "extraction/mesh/interval_mesh.h"
#include "peak_memory.h"
#include "spread.h"

namespace isostrata::peers {

struct Row {
  std::string data, array;
  Interval interval;
  std::int64_t cells = 0, active_cells = 0, tetrahedra = 0;

  std::string peer;     // "table clip x2", ...
  std::string setting;  // what of ours was timed, and how
  Spread ours, theirs;
  Spread kept;     // ours again, with what earlier extractions of the same field left
  double aim = 0;  // the ratio wished for; 0: none

  double our_volume = 0, peer_volume = 0;  // 0 if not compared
  std::int64_t peer_cells = 0;

  PeakMemory our_memory, peer_memory;      // peak_bytes 0: not measured
  std::uint64_t peer_bytes_estimated = 0;  // if it does not fit in this machine
  double memory_aim = 0;                   // peer / ours wished for; 0: none
  std::string note;

  double ratio() const { return ours.median > 0 ? theirs.median / ours.median : 0; }
  double ratio_kept() const { return kept.median > 0 ? theirs.median / kept.median : 0; }
  double ratio_of_minima() const { return ours.min > 0 ? theirs.min / ours.min : 0; }  // less of a neighbour's noise
  /// |ours - theirs| / theirs; 0 if not compared.
  double volume_difference() const;
  /// Peer's peak / ours, 0 if one is unknown.
  double memory_ratio() const;
};

boost::json::object to_json(const Row& row);
void print_text(const std::vector<Row>& rows);

}  // namespace isostrata::peers
