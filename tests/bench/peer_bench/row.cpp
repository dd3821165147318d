#include "row.h"

#include <boost/json.hpp>
#include <cmath>
#include <cstdio>

namespace isostrata::peers {
namespace {

boost::json::value to_json(const Spread& spread) {
  if (spread.runs == 0) return nullptr;
  return boost::json::object{
      {"runs", spread.runs}, {"min", spread.min}, {"median", spread.median}, {"max", spread.max}, {"cpu", spread.cpu_median}};
}

std::string milliseconds(const Spread& spread) {
  char text[80] = "-";
  if (spread.runs == 1) std::snprintf(text, sizeof text, "%.1f", spread.median);
  if (spread.runs > 1) std::snprintf(text, sizeof text, "%.1f / %.1f / %.1f", spread.min, spread.median, spread.max);
  return text;
}

double mebibytes(std::uint64_t bytes) { return static_cast<double>(bytes) / 1048576.0; }

}  // namespace

double Row::volume_difference() const {
  return our_volume > 0 && peer_volume > 0 ? std::abs(our_volume - peer_volume) / peer_volume : 0;
}

double Row::memory_ratio() const {
  const std::uint64_t theirs_bytes = peer_memory.peak_bytes > 0 ? peer_memory.peak_bytes : peer_bytes_estimated;
  return our_memory.peak_bytes > 0 ? static_cast<double>(theirs_bytes) / static_cast<double>(our_memory.peak_bytes) : 0;
}

boost::json::object to_json(const Row& row) {
  boost::json::object out{{"data", row.data},
                          {"array", row.array},
                          {"interval", boost::json::array{row.interval.lower, row.interval.upper}},
                          {"cells", row.cells},
                          {"active_cells", row.active_cells},
                          {"tetrahedra", row.tetrahedra},
                          {"peer", row.peer},
                          {"setting", row.setting}};
  if (row.ours.runs > 0) {
    out["ours_ms"] = row.ours.median;
    out["ours"] = to_json(row.ours);
  }
  if (row.theirs.runs > 0) {
    out["peer_ms"] = row.theirs.median;
    out["theirs"] = to_json(row.theirs);
  }
  if (row.ours.runs > 0 && row.theirs.runs > 0) {
    out["ratio"] = row.ratio();
    out["ratio_of_minima"] = row.ratio_of_minima();
  }
  if (row.kept.runs > 0) {
    out["ours_kept"] = to_json(row.kept);
    if (row.theirs.runs > 0) out["ratio_kept"] = row.ratio_kept();
  }
  if (row.aim > 0) out["aim"] = row.aim;
  if (row.peer_cells > 0) out["peer_cells"] = row.peer_cells;
  if (row.our_volume > 0) out["our_volume"] = row.our_volume;
  if (row.peer_volume > 0) {
    out["peer_volume"] = row.peer_volume;
    out["volume_difference"] = row.volume_difference();
  }
  if (row.our_memory.peak_bytes > 0) {
    out["our_bytes"] = row.our_memory.peak_bytes;
    out["data_bytes"] = row.our_memory.data_bytes;
  }
  if (row.peer_memory.peak_bytes > 0) out["peer_bytes"] = row.peer_memory.peak_bytes;
  if (row.peer_bytes_estimated > 0) out["peer_bytes_estimated"] = row.peer_bytes_estimated;
  if (row.memory_ratio() > 0) out["memory_ratio"] = row.memory_ratio();
  if (row.memory_aim > 0) out["memory_aim"] = row.memory_aim;
  if (!row.note.empty()) out["note"] = row.note;
  return out;
}

void print_text(const std::vector<Row>& rows) {
  for (const Row& row : rows) {
    std::printf("%s, %s %.6g:%.6g: %lld of %lld cells", row.data.c_str(), row.array.c_str(), row.interval.lower,
                row.interval.upper, static_cast<long long>(row.active_cells), static_cast<long long>(row.cells));
    if (row.tetrahedra > 0) std::printf(", %lld tetrahedra", static_cast<long long>(row.tetrahedra));
    std::printf("\n  %-44s %s ms (%s)\n", "ours", milliseconds(row.ours).c_str(), row.setting.c_str());
    if (row.kept.runs > 0) {
      std::printf("  %-44s %s ms", "ours, index kept", milliseconds(row.kept).c_str());
      if (row.theirs.runs > 0) std::printf(": ratio %.4g", row.ratio_kept());
      std::printf("\n");
    }
    std::printf("  %-44s %s ms", row.peer.c_str(), milliseconds(row.theirs).c_str());
    if (row.theirs.runs > 0 && row.ours.runs > 0)
      std::printf(": ratio %.4g (of minima %.4g)", row.ratio(), row.ratio_of_minima());
    if (row.aim > 0) std::printf(", aim %.4g", row.aim);
    if (row.peer_cells > 0) std::printf("; %lld cells", static_cast<long long>(row.peer_cells));
    if (row.peer_volume > 0) std::printf("; volumes differ by %.1e", row.volume_difference());
    std::printf("\n");
    if (row.our_memory.peak_bytes > 0) {
      std::printf("  peak memory: ours %.0f MiB (data %.0f MiB)", mebibytes(row.our_memory.peak_bytes),
                  mebibytes(row.our_memory.data_bytes));
      if (row.peer_memory.peak_bytes > 0) std::printf(", peer %.0f MiB", mebibytes(row.peer_memory.peak_bytes));
      if (row.peer_bytes_estimated > 0) std::printf(", peer about %.0f MiB", mebibytes(row.peer_bytes_estimated));
      if (row.memory_ratio() > 0) std::printf(": ratio %.3g", row.memory_ratio());
      if (row.memory_aim > 0) std::printf(", aim %.3g", row.memory_aim);
      std::printf("\n");
    }
    if (!row.note.empty()) std::printf("  %s\n", row.note.c_str());
  }
}

}  // namespace isostrata::peers
