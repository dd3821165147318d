// What can be said of why a worker ended.
#pragma once

#include <string>
#include <vector>

#include "engine/messages/activity.h"

namespace isostrata {

/// What its threads were at: "drawing and extracting".
std::string stages_of(const std::vector<ActivityFacts>& at);

/// How many processes of this one's control group the kernel has killed because memory was missing so far, as far as it says.
long killed_for_memory();

}  // namespace isostrata
