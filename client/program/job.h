// What Slurm and deploy/slurm/isostrata.sbatch say of a job that serves.
#pragma once

#include <atomic>
#include <string>

namespace isostrata::client {

/// A job that serves.
struct ServingJob {
  std::string node;     // where it runs, as Slurm names it
  std::string serves;   // as ssh's -L takes it: "127.0.0.1:PORT", or the path of a socket
  std::string port;     // of the address that the server printed
  std::string address;  // that address, with its token
};

/// The one command, for a POSIX shell, that prints what `read_job` reads. $1 is the job, $2 for how many seconds it waits for one that runs and does not serve
/// yet. In one line and without single quotes, since it goes through ssh, and the shell there may be any.
extern const char* const kAskForJob;

/// Reads what that command printed. Throws ClientError whose message says what of the job: "pending", "ended", "not_found", "not_ready" (it runs, and
/// wrote no address), "no_slurm".
ServingJob read_job(const std::string& job, const std::string& printed);

}  // namespace isostrata::client
