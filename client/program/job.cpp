#include "job.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "isostrata/options.h"

namespace isostrata::client {

// Each line with what it is, so that what a login shell says by itself is in nobody's way.
const char* const kAskForJob =
    R"(f="${XDG_STATE_HOME:-$HOME/.local/state}/isostrata/jobs/$1"; n=0; )"
    R"(while [ "$n" -lt "$2" ] && squeue --noheader --jobs "$1" --format %T 2>/dev/null | grep -q RUNNING && ! grep -q ssh "$f" 2>/dev/null; )"
    R"(do sleep 1; n=$((n+1)); done; )"
    R"(squeue --noheader --states=all --jobs "$1" --format "%T|%B|%r" 2>&1 | sed "s/^/slurm: /"; sed "s/^/file: /" "$f" 2>/dev/null; true)";

namespace {

std::string_view after(std::string_view text, std::string_view start) {
  const auto at = text.find(start);
  return at == std::string_view::npos ? std::string_view{} : text.substr(at + start.size());
}

std::string_view word(std::string_view text) { return text.substr(0, text.find_first_of(" \r\n")); }

/// The lines of one kind, without its name.
std::vector<std::string_view> lines_of(std::string_view kind, std::string_view printed) {
  std::vector<std::string_view> lines;
  while (!printed.empty()) {
    const std::string_view line = printed.substr(0, printed.find('\n'));
    if (line.starts_with(kind)) lines.push_back(line.substr(kind.size()));
    printed.remove_prefix(std::min(line.size() + 1, printed.size()));
  }
  return lines;
}

}  // namespace

ServingJob read_job(const std::string& job, const std::string& printed) {
  ServingJob found;
  std::string state, reason, said;
  for (const std::string_view line : lines_of("slurm: ", printed)) {
    const auto first = line.find('|'), second = line.find('|', first + 1);
    if (second == std::string_view::npos) {
      said += (said.empty() ? "" : "; ") + std::string(line);
      continue;
    }
    state = line.substr(0, first);
    found.node = line.substr(first + 1, second - first - 1);
    reason = line.substr(second + 1);
  }
  if (state.empty() && said.find("not found") != std::string::npos)
    throw ClientError("no_slurm", "there is no squeue here; --login HOST asks where Slurm is (" + said + ")");
  if (state.empty() && !said.empty() && said.find("Invalid job id") == std::string::npos)
    throw ClientError("no_slurm", "Slurm does not answer: " + said);
  if (state.empty())
    throw ClientError("not_found", "Slurm does not know job " + job + ": it ended some minutes ago, or the number is another one (squeue --me lists yours)");
  if (state == "PENDING" || state == "CONFIGURING" || state.starts_with("REQUEUE"))
    throw ClientError("pending", "job " + job + " waits (" + state + (reason == "None" ? "" : ", " + reason) + "); try again once it runs");
  if (state == "SUSPENDED" || state == "STOPPED") throw ClientError("pending", "job " + job + " stands still (" + state + ")");
  if (state != "RUNNING") throw ClientError("ended", "job " + job + " has ended (" + state + "); its log says more");

  for (const std::string_view line : lines_of("file: ", printed)) {
    for (const std::string_view scheme : {"http://", "https://"})
      if (const auto at = line.find(scheme); at != std::string_view::npos && found.address.empty()) found.address = word(line.substr(at));
    // ssh -L PORT:DESTINATION ...
    if (const auto forward = word(after(line, "ssh -L ")); !forward.empty()) {
      found.port = forward.substr(0, forward.find(':'));
      found.serves = after(forward, ":");
    }
  }
  if (found.address.empty() || found.serves.empty())
    throw ClientError("not_ready", "job " + job + " runs on " + found.node +
                                       " and has written no address yet; its log says why, if it was started by isostrata.sbatch");
  return found;
}

}  // namespace isostrata::client
