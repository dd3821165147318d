#include "extraction/strict/strict_cell.h"

#include <algorithm>
#include <utility>

#include "extraction/cells/cell_geometry.h"

namespace isostrata {

std::optional<CellFix> StrictCells::fix(std::int64_t run, StrictSummary& done) const {
  const auto r = static_cast<std::size_t>(run);
  const bool is_last = r + 1 == mesh_.cell_runs.size();
  const Tetrahedra old{mesh_.cell_runs[r].first_tetrahedron,
                       is_last ? mesh_.tetrahedra.size() : mesh_.cell_runs[r + 1].first_tetrahedron};
  // Most cells have no tetrahedron with a negative volume: the cell's tolerance is not looked up for them.
  bool suspect = false;
  for (std::size_t t = old.first; t < old.last && !suspect; ++t) suspect = volume_of(mesh_.tetrahedra[t]) < 0;
  if (!suspect) return std::nullopt;
  const CellGeometry cell = read_cell(mesh_.cell_runs[r].cell);
  Parts parts;
  bool turned = false;
  for (std::size_t t = old.first; t < old.last; ++t) {
    Part& part = parts[mesh_.tetrahedron_interval[t]];
    part.tetrahedra.push_back(mesh_.tetrahedra[t]);
    part.turned = part.turned || volume_of(mesh_.tetrahedra[t]) < -cell.tolerance;
    turned = turned || part.turned;
  }
  if (!turned) return std::nullopt;
  ++done.turned_cells;

  const auto first_new = static_cast<std::uint32_t>(mesh_.positions.size());
  std::map<std::uint16_t, PulledRegion> pulled;
  bool stuck = false;
  const std::map<std::uint32_t, unsigned> faces = faces_of_points(cell, old);
  for (const auto& [interval, part] : parts) {
    if (!part.turned) continue;
    auto region =
        cell.sign == 0 ? std::nullopt : pull_region(part.tetrahedra, mesh_.positions.data(), faces, cell.tolerance, first_new);
    if (region)
      pulled[interval] = std::move(*region);
    else
      stuck = true;
  }
  CellFix fix;
  fix.run = run;
  fix.ids = cell.ids;
  fix.vertices = cell.count;
  bool changed = false, star = false, centred = false;
  std::vector<StarCell::Facet> facets;
  if (stuck)
    for (const std::vector<std::uint16_t>& chain : chains_of(parts)) {
      const bool all_pulled =
          std::none_of(chain.begin(), chain.end(), [&](auto i) { return parts[i].turned && !pulled.count(i); });
      if (!all_pulled && cut_around_a_point(cell, old, chain, parts, fix, facets)) star = changed = true;
    }
  for (auto& [interval, region] : pulled) {
    Part& part = parts[interval];
    if (part.star) continue;
    const auto shift = static_cast<std::uint32_t>(fix.new_points.size());
    for (TetrahedronPoints& t : region.tetrahedra)
      for (std::uint32_t& p : t)
        if (p >= first_new) p += shift;
    for (const Vec3d& position : region.inner) {
      fix.new_points.push_back(point_at(cell, position));
      const IsoRule& own = rules_.rules()[interval];
      fix.new_points.back().value = std::clamp(fix.new_points.back().value, own.lower, own.upper);
      centred = true;
    }
    part.tetrahedra = std::move(region.tetrahedra);
    part.turned = false;
    changed = true;
  }
  const bool left = std::any_of(parts.begin(), parts.end(), [](const auto& part) { return part.second.turned; });
  ++(left ? done.tangled_cells : star ? done.star_cells : centred ? done.centred_cells : done.pulled_cells);
  if (!changed) return std::nullopt;
  for (const auto& [interval, part] : parts) {
    fix.tetrahedra.insert(fix.tetrahedra.end(), part.tetrahedra.begin(), part.tetrahedra.end());
    fix.intervals.insert(fix.intervals.end(), part.tetrahedra.size(), interval);
  }
  if (facets_) find_facets(old, parts, facets, fix);
  return fix;
}

CellGeometry StrictCells::read_cell(std::int64_t cell) const {
  CellGeometry out;
  out.count = grid_.cell_points(cell, out.ids);
  out.topology = &topology(grid_.cell_type(cell));
  for (int v = 0; v < out.count; ++v) {
    out.positions[v] = grid_.point(out.ids[v]);
    out.values[v] = array_.at(static_cast<std::size_t>(out.ids[v]));
  }
  const CellHandedness hand = cell_handedness(*out.topology, std::span(out.positions).first(static_cast<std::size_t>(out.count)));
  out.tolerance = hand.tolerance;
  out.sign = hand.sign;
  return out;
}

double StrictCells::volume_of(const TetrahedronPoints& t) const {
  const auto& x = mesh_.positions;
  return orient3d(x[t[0]], x[t[1]], x[t[2]], x[t[3]]) / 6;
}

/// Which of the cell's faces hold each point of its tetrahedra.
std::map<std::uint32_t, unsigned> StrictCells::faces_of_points(const CellGeometry& cell, Tetrahedra old) const {
  std::map<std::uint32_t, unsigned> out;
  for (std::size_t t = old.first; t < old.last; ++t)
    for (const std::uint32_t p : mesh_.tetrahedra[t]) {
      const auto [at, is_new] = out.try_emplace(p, 0u);
      if (!is_new) continue;
      const std::int64_t a = mesh_.origins[p].a(), b = mesh_.origins[p].b();
      for (std::size_t f = 0; f < cell.topology->faces.size(); ++f) {
        const CellFace& face = cell.topology->faces[f];
        bool has_a = false, has_b = false;
        for (int i = 0; i < face.size; ++i) {
          has_a = has_a || cell.ids[face.vertex[i]] == a;
          has_b = has_b || cell.ids[face.vertex[i]] == b;
        }
        if (has_a && has_b) at->second |= 1u << f;
      }
    }
  return out;
}

/// The cell's intervals in groups that do not overlap within themselves, each by increasing lower end.
std::vector<std::vector<std::uint16_t>> StrictCells::chains_of(const Parts& parts) const {
  std::vector<std::uint16_t> order;
  for (const auto& [interval, part] : parts) order.push_back(interval);
  const auto rules = rules_.rules();
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return rules[a].lower < rules[b].lower; });
  std::vector<std::vector<std::uint16_t>> chains;
  for (const std::uint16_t interval : order) {
    const auto fits = [&](const auto& chain) { return rules[chain.back()].upper <= rules[interval].lower; };
    auto chain = std::find_if(chains.begin(), chains.end(), fits);
    if (chain == chains.end()) chain = chains.emplace(chains.end());
    chain->push_back(interval);
  }
  return chains;
}

/// Replaces the parts of a chain; adds its new points to the fix and its isosurfaces, in the fix's numbers, to facets.
bool StrictCells::cut_around_a_point(const CellGeometry& cell, Tetrahedra old, std::span<const std::uint16_t> chain, Parts& parts,
                                     CellFix& fix, std::vector<StarCell::Facet>& facets) const {
  const std::optional<StarCell> star = star_cell(cell, rules_, chain);
  if (!star) return false;
  std::vector<std::optional<std::uint32_t>> number(star->points.size());
  std::vector<CellPoint> added;
  for (const auto& tetrahedron : star->tetrahedra)
    for (const std::uint32_t p : tetrahedron.points) {
      if (number[p]) continue;
      const CellPoint& point = star->points[p];
      if (point.a < 0) {
        number[p] = static_cast<std::uint32_t>(mesh_.positions.size() + fix.new_points.size() + added.size());
        added.push_back(point);
      } else {
        number[p] = find_point(cell, point, old);
        if (!number[p]) return false;  // only in a cell so collapsed that the tables have nothing there
      }
    }
  for (const std::uint16_t interval : chain) {
    parts[interval].tetrahedra.clear();
    parts[interval].turned = false;
    parts[interval].star = true;
  }
  for (const auto& t : star->tetrahedra)
    parts[t.interval].tetrahedra.push_back(
        {number[t.points[0]].value(), number[t.points[1]].value(), number[t.points[2]].value(), number[t.points[3]].value()});
  for (StarCell::Facet facet : star->facets) {
    for (std::uint32_t& p : facet.points) p = number[p].value();
    facets.push_back(facet);
  }
  fix.new_points.insert(fix.new_points.end(), added.begin(), added.end());
  return true;
}

/// The number of a point on the cell's edges, among the points of its old tetrahedra.
std::optional<std::uint32_t> StrictCells::find_point(const CellGeometry& cell, const CellPoint& point, Tetrahedra old) const {
  const std::int64_t a = std::min(cell.ids[point.a], cell.ids[point.b]), b = std::max(cell.ids[point.a], cell.ids[point.b]);
  for (std::size_t t = old.first; t < old.last; ++t)
    for (const std::uint32_t p : mesh_.tetrahedra[t]) {
      const PointOrigin& origin = mesh_.origins[p];
      if (origin.a() == a && origin.b() == b && (a == b || mesh_.values[p] == point.value)) return p;
    }
  return std::nullopt;
}

/// The cell's boundary facets: the old ones but for isosurfaces that are new, with the tetrahedra that have them now.
void StrictCells::find_facets(Tetrahedra old, const Parts& parts, std::span<const StarCell::Facet> on_isosurfaces,
                              CellFix& fix) const {
  struct Wanted {
    std::array<std::uint32_t, 3> points;
    std::uint16_t interval;
    FacetLabel label;
  };
  std::vector<Wanted> wanted;
  auto facet = std::lower_bound(mesh_.facets.begin(), mesh_.facets.end(), old.first,
                                [](const BoundaryFacet& f, std::size_t t) { return f.tetrahedron < t; });
  for (; facet != mesh_.facets.end() && facet->tetrahedron < old.last; ++facet)
    if (facet->label == FacetLabel::domain || !parts.at(facet->interval).star)
      wanted.push_back({facet->points, facet->interval, facet->label});
  for (const StarCell::Facet& f : on_isosurfaces) wanted.push_back({f.points, f.interval, f.label});

  for (std::size_t t = 0; t < fix.tetrahedra.size(); ++t)
    for (const auto& v : kTetrahedronFacets) {
      const std::array<std::uint32_t, 3> own{fix.tetrahedra[t][v[0]], fix.tetrahedra[t][v[1]], fix.tetrahedra[t][v[2]]};
      for (const Wanted& w : wanted)
        if (w.interval == fix.intervals[t] && std::is_permutation(own.begin(), own.end(), w.points.begin()))
          fix.facets.push_back({own, static_cast<std::uint32_t>(t), w.interval, w.label});
    }
}

}  // namespace isostrata
