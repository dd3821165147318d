// The system calls that readers of files need.
#pragma once

namespace isostrata {

/// From now on every other call fails with ENOSYS, as on a kernel that does not have it, so that libraries take their older way.
/// False if the kernel takes no filter.
bool allow_only_reading_calls();

}  // namespace isostrata
