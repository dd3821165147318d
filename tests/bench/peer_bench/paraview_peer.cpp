#include "paraview_peer.h"

#include <sys/wait.h>
#include <unistd.h>

#include <boost/json.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "base/error.h"

namespace isostrata::peers {
namespace {

namespace fs = std::filesystem;

/// A file that goes away with its owner.
struct TemporaryRaw {
  fs::path path = fs::temp_directory_path() / ("isostrata-peer-bench-" + std::to_string(getpid()) + ".raw");
  ~TemporaryRaw() {
    std::error_code ignored;
    fs::remove(path, ignored);
  }
};

std::string in_quotes(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

bool paraview_found() {
  const char* path = std::getenv("PATH");
  std::string rest = path ? path : "";
  while (!rest.empty()) {
    const auto colon = rest.find(':');
    if (access((rest.substr(0, colon) + "/pvpython").c_str(), X_OK) == 0) return true;
    rest = colon == std::string::npos ? "" : rest.substr(colon + 1);
  }
  return false;
}

ParaviewRun run_paraview(const std::string& script, const Workload& workload, int threads) {
  const auto* grid = std::get_if<UniformGrid>(&workload.dataset->grid.shape);
  if (!grid) throw Error(ErrorCode::unsupported, workload.dataset->name + ": expected a uniform grid");
  const TemporaryRaw raw;
  {
    std::ofstream out(raw.path, std::ios::binary);
    std::visit([&](auto values) { out.write(reinterpret_cast<const char*>(values.data()), values.size_bytes()); },
               workload.values().values);
    if (!out.flush()) throw Error(ErrorCode::unavailable, raw.path.string() + ": cannot be written");
  }
  const boost::json::object job{{"raw", raw.path.string()},
                                {"type", to_string(workload.values().type)},
                                {"array", workload.array},
                                {"dims", boost::json::array{grid->dims[0], grid->dims[1], grid->dims[2]}},
                                {"origin", boost::json::array{grid->origin.x, grid->origin.y, grid->origin.z}},
                                {"spacing", boost::json::array{grid->spacing.x, grid->spacing.y, grid->spacing.z}},
                                {"interval", boost::json::array{workload.interval.lower, workload.interval.upper}},
                                {"repeat", 3}};
  const std::string command = "VTK_SMP_MAX_THREADS=" + std::to_string(threads) + " pvpython " + in_quotes(script) + " " +
                              in_quotes(boost::json::serialize(job));
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) throw Error(ErrorCode::unavailable, "pvpython cannot be started");
  std::string text;
  char block[4096];
  for (std::size_t got; (got = std::fread(block, 1, sizeof block, pipe)) > 0;) text.append(block, got);
  const int status = pclose(pipe);
  const auto begin = text.rfind("\n{");  // what ParaView itself prints may stand before it
  boost::system::error_code bad;
  const boost::json::value answer = boost::json::parse(begin == std::string::npos ? text : text.substr(begin + 1), bad);
  if (status != 0 || bad || !answer.is_object())
    throw Error(ErrorCode::unavailable, script + ": pvpython ended with status " + std::to_string(status));
  ParaviewRun run;
  run.version = "ParaView " + std::string(answer.at("version").as_string());
  for (const auto& ms : answer.at("ms").as_array()) run.samples.push_back({ms.to_number<double>(), 0});
  run.cells = answer.at("cells").to_number<std::int64_t>();
  run.peak_bytes = answer.at("peak_bytes").to_number<std::uint64_t>();
  return run;
}

}  // namespace isostrata::peers
