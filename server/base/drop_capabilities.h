// What root may do more than others, given away.
#pragma once

#include <cstdint>

namespace isostrata {

/// This thread keeps, of the capabilities that it may use, those of the mask (1u << CAP_...), which are then in effect. None is inherited.
void drop_capabilities_but(std::uint32_t mask);

}  // namespace isostrata
