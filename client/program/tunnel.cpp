// tunnel: the way to a server that runs as a job of Slurm.
#include <chrono>
#include <cstdio>
#include <thread>

#include "arguments.h"
#include "child.h"
#include "forward.h"
#include "job.h"

namespace isostrata::client {
namespace {

struct TunnelArguments {
  std::string job;
  std::string login;  // where Slurm is asked, and through which the node is reached; empty: here
  int port = 0;       // of this machine; 0: the server's own if it is free
};

ServingJob find_job(const Options& options, const TunnelArguments& arguments) {
  const std::string seconds = std::to_string(options.timeout.count() / 1000);
  // With the PATH of a login: Slurm is often in no other. By bash, for which the files of a login are written; other shells stop in them.
  std::vector<std::string> command{"sh", "-c", kAskForJob, "sh", arguments.job, seconds};
  if (!arguments.login.empty())
    command = {"ssh", "--", arguments.login, "bash -lc '" + std::string(kAskForJob) + "' sh " + arguments.job + " " + seconds};
  Child asked(command, true);
  const std::string printed = asked.out(options.stop);
  if (const int status = asked.wait(); status != 0)
    throw ClientError("connection", status == 127 ? "there is no program '" + command[0] + "' here"
                                                  : "ssh to " + arguments.login + " failed with status " + std::to_string(status));
  return read_job(arguments.job, printed);
}

/// "USER@", where --login names one: nodes know the same users.
std::string user_of(const std::string& login) { return login.substr(0, login.find('@') == std::string::npos ? 0 : login.find('@') + 1); }

void tunnel(const Options& options, const TunnelArguments& arguments) {
  if (arguments.job.empty() || arguments.job.find_first_not_of("0123456789") != std::string::npos)
    throw ClientError("bad_argument", "JOB '" + arguments.job + "': expected the number that sbatch printed");
  const ServingJob job = find_job(options, arguments);
  // Taken before ssh is started, so that nobody else is taken for the server.
  const int port = arguments.port ? free_port(arguments.port, true) : free_port(std::atoi(job.port.c_str()), false);
  std::vector<std::string> command{"ssh", "-N", "-o", "ExitOnForwardFailure=yes", "-o", "ServerAliveInterval=30",
                                   "-L", "127.0.0.1:" + std::to_string(port) + ":" + job.serves};
  if (!arguments.login.empty()) command.insert(command.end(), {"-J", arguments.login});
  command.insert(command.end(), {"--", user_of(arguments.login) + job.node});
  Child line(command, false);

  const auto stopped = [&] { return options.stop && *options.stop; };
  const auto ended = [&](const std::string& when) {
    const int status = *line.status();
    return ClientError("connection", status == 127 ? "there is no program 'ssh' here"
                                                   : "ssh to " + job.node + " " + when + " with status " + std::to_string(status));
  };
  Options here = options;
  here.url = address_here(job.address, port);
  for (const auto last = std::chrono::steady_clock::now() + options.timeout; !answers(here);) {
    if (line.status()) throw ended("failed");
    if (std::chrono::steady_clock::now() > last)
      throw ClientError("timeout", "nobody answers at " + job.serves + " of " + job.node + "; the log of job " + arguments.job + " says more");
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  if (stopped()) return;
  if (line.status()) throw ended("failed");
  std::printf("Job %s serves on %s. The way there is open until Ctrl-C.\n\nOpen  %s\n\n", arguments.job.c_str(), job.node.c_str(), here.url.c_str());
  std::fflush(stdout);
  while (!stopped() && !line.status()) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  if (!stopped()) throw ended("ended");
}

}  // namespace

void add_tunnel(CLI::App& app, Options& options) {
  CLI::App* command = app.add_subcommand(
      "tunnel", "Opens the way to a server that runs as a job of Slurm (isostrata.sbatch), prints the page's address, and stays until Ctrl-C. Needs no URL");
  const auto arguments = std::make_shared<TunnelArguments>();
  command->add_option("job", arguments->job, "The number that sbatch printed")->required()->type_name("JOB");
  command->add_option("--login", arguments->login, "The cluster's login node, from a machine that has no Slurm")->type_name("[USER@]HOST");
  command->add_option("--port", arguments->port, "Port of this machine; by default the server's own, or another one if that is taken")->check(CLI::Range(1, 65535));
  command->callback([&options, arguments] { tunnel(options, *arguments); });
}

}  // namespace isostrata::client
