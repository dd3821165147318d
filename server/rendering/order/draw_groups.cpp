#include "rendering/order/draw_groups.h"

#include <algorithm>
#include <map>

#include "rendering/picture/body_shading.h"

namespace isostrata {
namespace {

VisibilityOrder order_group(const DrawInput& input, const std::vector<std::size_t>& members) {
  std::vector<std::uint8_t> drawn(input.styles.size(), 0), one_color(input.styles.size(), 0);
  bool same_color = true;
  for (const std::size_t i : members) {
    drawn[i] = 1;
    // A surface has a place among them, and of shaded ones each is of a colour of its own.
    one_color[i] = input.styles[i].constant() && !input.styles[i].surface.drawn() && !shades_bodies(input);
    same_color = same_color && one_color[i] && input.styles[i].color == input.styles[members[0]].color;
  }
  const OrderRequest request{drawn, one_color};
  return same_color ? mesh_order(*input.mesh, request)
                    : visibility_order(input.grid, *input.mesh, request, input.camera,
                                       input.window.width > 0 ? input.window.width : input.width,
                                       input.window.width > 0 ? input.window.height : input.height);
}

}  // namespace

VisibilityOrder order_groups(const DrawInput& input) {
  std::map<int, std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < input.styles.size(); ++i)
    if (input.styles[i].drawn()) groups[input.mode == RenderMode::prioritized ? input.styles[i].priority : 0].push_back(i);

  VisibilityOrder all{{}, "none needed", true};
  for (const auto& [priority, members] : groups) {
    VisibilityOrder group = order_group(input, members);
    all.exact = all.exact && group.exact;
    if (all.method == "none needed" || !group.exact) all.method = group.method;
    const std::size_t before = all.tetrahedra.size();
    if (before == 0) {
      all.tetrahedra = std::move(group.tetrahedra);
      continue;
    }
    all.tetrahedra.resize(before + group.tetrahedra.size());
    std::copy(group.tetrahedra.begin(), group.tetrahedra.end(), all.tetrahedra.begin() + static_cast<std::ptrdiff_t>(before));
  }
  if (input.mode == RenderMode::prioritized)
    all.method = all.method == "none needed" ? "priority (none needed)" : "priority, then " + all.method;
  return all;
}

}  // namespace isostrata
