// The server and the worker take their own rights away before they hear from anybody. SECURITY.md has the table of what is left.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace isostrata {

/// What a process may still reach. Names of nothing are passed over.
struct ReachablePlaces {
  std::vector<std::filesystem::path> read;   // files, and folders with all below them
  std::vector<std::filesystem::path> names;  // folders whose entries may be listed, and not read
  std::vector<std::filesystem::path> write;  // folders in which files and folders may be made, changed and removed
};

/// For the process that draws: its reach, and what it needs of the system to load drivers and libraries, talk to GPUs and start isostrata-import,
/// which inherits all of it. No socket is opened, nobody is connected to, no other program is started. For the thread that calls and
/// those that it starts, so call it before there are any.
///
/// Returns what holds, for people: "Landlock 6 and seccomp"; empty if nothing does, since --sandbox is off or the kernel has neither. Throws
/// unavailable if --sandbox is require and something is missing.
std::string confine_worker(const ReachablePlaces& reach);

/// For the process that listens: its reach, and of the system what says how much memory there is. It starts no program and makes no
/// process, no file becomes executable memory, no socket is opened but pairs, nobody is connected to; every system call that a server does not
/// use fails with ENOSYS. As above otherwise. What it listens on must be open.
std::string confine_server(const ReachablePlaces& reach);

/// What a server reads that was started with these files, folders, patterns and names of analytic data: each folder; of a file or a pattern the folder
/// that it lies in, and of a link also where it leads; but of a home directory, and of what lies above one, the entries that are not hidden
/// and are there now.
ReachablePlaces reach_of_sources(const std::vector<std::string>& sources);

}  // namespace isostrata
