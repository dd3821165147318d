// The system calls that a process which has begun its work is left with. SECURITY.md has the table.
#pragma once

namespace isostrata {

/// All but those that reach other processes, the network or the machine; what drivers call is not known. The others fail with EPERM. Inherited. False
/// where the kernel takes no filter.
bool refuse_calls_of_worker();

/// Those that a server uses; every other fails with ENOSYS, as on a kernel that does not have it. `keeps_kill`: processes are ended by their
/// numbers, where the kernel has no descriptors of them (before 5.3).
bool refuse_calls_of_server(bool keeps_kill);

}  // namespace isostrata
