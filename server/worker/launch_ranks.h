// A worker that is a parallel job. The server starts this process where it would start a worker; this process starts the launcher (mpirun,
// srun), which starts the ranks, and hands the server's socket and board to the first of them. It ends as the job does, and the job ends with it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "worker/run_worker.h"

namespace isostrata {

/// Starts `launcher... program worker --socket PATH` and waits for its end. PATH is a Unix socket in $TMPDIR, on which the first rank, which must
/// run on this machine, is given its descriptors. Whatever ends the job ends this process in the same way; a job that ends before its
/// first rank has come is told to the server as a worker that cannot begin. Returns the exit status.
int launch_ranks(const WorkerArguments& arguments, std::vector<std::string> launcher, const std::filesystem::path& program);

/// Has srun end the whole job when one rank ends badly, as mpirun does: the others would wait for it without end. A user's own
/// SLURM_KILL_BAD_EXIT stays. Before a launcher is started.
void end_job_with_any_rank();

/// By the first rank: what launch_ranks hands over. Throws unavailable.
WorkerArguments take_worker_descriptors(const std::filesystem::path& socket);

}  // namespace isostrata
