// Which intervals are drawn together.
#pragma once

#include <cstdint>
#include <vector>

#include "rendering/order/visibility_order.h"
#include "rendering/picture/renderer.h"

namespace isostrata {

/// The order for the whole picture. RenderMode::sorted: one group of all visible intervals. RenderMode::prioritized: one group
/// for each priority, lower ones first, each painted over those before it (section 4.1.3 of the paper); a group of a single
/// constant colour needs no order inside, any other is sorted inside.
VisibilityOrder order_groups(const DrawInput& input);

}  // namespace isostrata
