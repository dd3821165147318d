#include "extraction/measure/section.h"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "base/parallel.h"

namespace isostrata {
namespace {

constexpr std::int64_t kGrain = 1 << 14;
constexpr std::uint64_t kLookEvery = 1u << 20;

class SectionMaker {
 public:
  SectionMaker(const IntervalMesh& mesh, std::span<const MeshArray> carried, const Plane& plane, const Task& task) : mesh_(mesh), carried_(carried), normal_(normalized(plane.normal)), task_(task) {
    distance_.resize(mesh.positions.size());
    parallel_for(static_cast<std::int64_t>(distance_.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (auto p = static_cast<std::size_t>(begin); p < static_cast<std::size_t>(end); ++p) distance_[p] = dot(normal_, mesh_.positions[p] - plane.point);
    });
    for (const MeshArray& array : carried) out_.carried.push_back({array.name, {}, array.in_cells});
    for (const IntervalSummary& summary : mesh.summaries) {
      IntervalSummary row;
      row.interval = summary.interval;
      row.term = summary.term;
      out_.mesh.summaries.push_back(row);
    }
    out_.mesh.cells = mesh.cells;
  }

  Section run() {
    for (std::uint64_t t = 0; t < mesh_.tetrahedra.size(); ++t) {
      if (t % kLookEvery == 0) task_.check();
      if (outline(mesh_.tetrahedra[t])) add_polygon(t);
    }
    for (const BoundaryFacet& facet : mesh_.facets)
      if (outline(facet.points)) add_edge(facet.interval, outline_[0], outline_[1]);
    std::sort(edges_.begin(), edges_.end());
    for (std::size_t first = 0, last = 0; first < edges_.size(); first = last) {
      while (last < edges_.size() && edges_[last] == edges_[first]) ++last;
      out_.unmatched_edges += (last - first) % 2;
    }
    return std::move(out_);
  }

 private:
  /// Where the plane meets the mesh's edge, or the end of it that lies on the plane.
  std::uint32_t point_on(std::uint32_t below, std::uint32_t above) {
    const bool at_end = distance_[above] == 0;
    const std::uint32_t a = at_end ? above : std::min(below, above), b = at_end ? above : std::max(below, above);
    const auto [entry, fresh] = numbers_.try_emplace(std::uint64_t{a} << 32 | b, static_cast<std::uint32_t>(positions_.size()));
    if (!fresh) return entry->second;
    const double weight = at_end ? 0 : distance_[a] / (distance_[a] - distance_[b]);
    positions_.push_back(lerp(mesh_.positions[a], mesh_.positions[b], weight));
    if (!mesh_.values.empty()) values_.push_back(std::lerp(mesh_.values[a], mesh_.values[b], weight));
    for (std::size_t i = 0; i < carried_.size(); ++i)
      if (!carried_[i].in_cells) out_.carried[i].values.push_back(static_cast<float>(std::lerp<double>(carried_[i].values[a], carried_[i].values[b], weight)));
    return entry->second;
  }

  /// What the plane cuts out of a tetrahedron or a triangle, into outline_; false if that is nothing.
  template <std::size_t n>
  bool outline(const std::array<std::uint32_t, n>& corners) {
    std::array<std::uint32_t, n> below{}, above{};
    std::size_t b = 0, a = 0;
    for (const std::uint32_t corner : corners) (distance_[corner] < 0 ? below[b++] : above[a++]) = corner;
    if (b == 0 || a == 0) return false;
    outline_.clear();
    if (b == 2 && a == 2)
      outline_ = {point_on(below[0], above[0]), point_on(below[0], above[1]), point_on(below[1], above[1]), point_on(below[1], above[0])};
    else
      for (std::size_t i = 0; i < b; ++i)
        for (std::size_t j = 0; j < a; ++j) outline_.push_back(point_on(below[i], above[j]));
    outline_.erase(std::unique(outline_.begin(), outline_.end()), outline_.end());
    while (outline_.size() > 1 && outline_.back() == outline_.front()) outline_.pop_back();
    return outline_.size() >= n - 1;
  }

  void add_edge(std::uint16_t interval, std::uint32_t a, std::uint32_t b) { edges_.push_back({interval, std::min(a, b), std::max(a, b)}); }

  void add_polygon(std::uint64_t t) {
    const std::uint16_t interval = mesh_.tetrahedron_interval[t];
    Vec3d area{};
    for (std::size_t i = 1; i + 1 < outline_.size(); ++i) area = area + twice_area(outline_[0], outline_[i], outline_[i + 1]);
    const auto& corners = mesh_.tetrahedra[t];
    const bool turned = orient3d(mesh_.positions[corners[0]], mesh_.positions[corners[1]], mesh_.positions[corners[2]], mesh_.positions[corners[3]]) < 0;
    if ((dot(area, normal_) < 0) != turned) std::reverse(outline_.begin(), outline_.end());
    for (std::size_t i = 0; i < outline_.size(); ++i) add_edge(interval, outline_[i], outline_[(i + 1) % outline_.size()]);
    std::rotate(outline_.begin(), std::min_element(outline_.begin(), outline_.end()), outline_.end());
    IntervalSummary& row = out_.mesh.summaries[interval];
    for (std::size_t i = 1; i + 1 < outline_.size(); ++i) {
      facets_.push_back({{outline_[0], outline_[i], outline_[i + 1]}, static_cast<std::uint32_t>(facets_.size()), interval, FacetLabel::domain, interval});
      ++row.triangles;
      row.area += dot(normal_, twice_area(outline_[0], outline_[i], outline_[i + 1])) / 2;
      for (std::size_t k = 0; k < carried_.size(); ++k)
        if (carried_[k].in_cells) out_.carried[k].values.push_back(carried_[k].values[t]);
    }
  }

  Vec3d twice_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const { return cross(positions_[b] - positions_[a], positions_[c] - positions_[a]); }

  const IntervalMesh& mesh_;
  std::span<const MeshArray> carried_;
  const Vec3d normal_;
  const Task& task_;
  std::vector<double> distance_;  // [np] from the plane
  std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
  std::vector<std::uint32_t> outline_;
  std::vector<std::array<std::uint32_t, 3>> edges_;  // interval, and two points
  Section out_;
  Buffer<Vec3d>& positions_ = out_.mesh.positions;
  Buffer<double>& values_ = out_.mesh.values;
  Buffer<BoundaryFacet>& facets_ = out_.mesh.facets;
};

}  // namespace

Section section_of(const IntervalMesh& mesh, std::span<const MeshArray> carried, const Plane& plane, const Task& task) { return SectionMaker(mesh, carried, plane, task).run(); }

}  // namespace isostrata
