#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <fstream>
#include <memory>

#include "base/error.h"
#include "base/parallel.h"
#include "base/program_file.h"
#include "base/simd_level.h"
#include "data/open/sandbox.h"
#include "encoding/encode_image.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/egl_drivers.h"
#include "main/unused_cards.h"
#include "main/worker_probe.h"
#include "rendering/device/gl_extraction_mesh.h"
#include "rendering/gl/gl_probe.h"
#include "rendering/picture/renderer.h"

namespace isostrata {
namespace {

struct Importer {
  std::string path;
  bool found = false;
};

struct Findings {
  std::vector<DeviceAttempt> attempts;
  LoadedLibrary c_library;
  std::vector<LoadedLibrary> egl;
  std::vector<GraphicsCard> cards;
  std::vector<std::string> unused;  // cards that are here and do not draw, with the reason
  std::string device;         // what auto takes; empty if nothing can draw
  std::string device_detail;  // or why nothing can
  bool software = false;
  std::string trial;    // how raster and compute compare there; empty if no trial was held
  std::string compute;  // why extraction does not work on the device; empty if it does
  WorkerProbe worker;
  std::vector<CodecProbe> codecs;
  Importer importer;
  SandboxSupport sandbox;
  int cores = 0;
  std::int64_t memory_bytes = 0, memory_limit_bytes = 0;  // 0: unknown, no limit
};

Importer find_importer() {
  const auto path = program_file().parent_path() / "isostrata-import";
  return {path.string(), access(path.c_str(), X_OK) == 0};
}

/// The memory that this process's control group may use; 0 if there is no limit.
std::int64_t control_group_limit() {
  for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    std::ifstream in(file);
    std::int64_t bytes = 0;
    if (in >> bytes && bytes > 0 && bytes < (1ll << 60)) return bytes;
  }
  return 0;
}

/// Throws unavailable if it cannot draw; another process tries it, since its driver may end that.
void check_device(const std::string& device) {
  if (const DeviceAttempt attempt = probe_device(device); !attempt.ok) throw Error(ErrorCode::unavailable, attempt.name + ": " + attempt.detail);
}

Findings examine(const std::string& device, bool trial) {
  Findings findings;
  findings.attempts = probe_devices();
  findings.c_library = c_library();
  findings.egl = egl_libraries();
  const CardFacts cards = card_facts(findings.egl);
  findings.cards = cards.cards;
  const bool hardware = std::any_of(findings.attempts.begin(), findings.attempts.end(), [](const DeviceAttempt& of) { return of.ok && !of.software; });
  if (!hardware) findings.unused = why_unused(cards);
  try {
    if (device != "auto" && device != "native") check_device(device);
    const std::unique_ptr<Renderer> renderer = make_renderer({"auto", device, trial});
    findings.device = renderer->device();
    findings.trial = renderer_trial_report();
    for (const DeviceAttempt& attempt : findings.attempts)
      if (attempt.ok && attempt.detail.starts_with(findings.device)) findings.software = attempt.software;
  } catch (const Error& error) {
    findings.device_detail = error.what();
  }
  findings.compute = findings.device.empty() ? "no device" : check_gl_extraction(device);
  if (findings.device.empty())
    findings.worker.detail = "no device";
  else
    findings.worker = probe_worker({"auto", device});
  findings.codecs = probe_codecs();
  findings.importer = find_importer();
  findings.sandbox = sandbox_support();
  findings.cores = thread_count();
  findings.memory_bytes = static_cast<std::int64_t>(sysconf(_SC_PHYS_PAGES)) * sysconf(_SC_PAGESIZE);
  findings.memory_limit_bytes = control_group_limit();
  return findings;
}

boost::json::object to_json(const LoadedLibrary& library) {
  return {{"name", library.name}, {"ok", library.ok}, {"detail", library.detail}};
}

boost::json::object to_json(const GraphicsCard& card) {
  boost::json::array nodes;
  for (const CardNode& node : card.nodes) nodes.push_back(boost::json::object{{"path", node.path}, {"opens", node.opens}, {"group", node.group_name}});
  return {{"address", card.address}, {"ids", card.ids}, {"driver", card.driver}, {"model", card.model}, {"nodes", std::move(nodes)}};
}

boost::json::object to_json(const Findings& findings) {
  boost::json::array devices, codecs;
  for (const DeviceAttempt& a : findings.attempts)
    devices.push_back(boost::json::object{{"name", a.name}, {"ok", a.ok}, {"software", a.software}, {"detail", a.detail}});
  for (const CodecProbe& codec : findings.codecs)
    codecs.push_back(boost::json::object{{"name", codec.name}, {"ok", codec.ok}, {"detail", codec.detail}});
  boost::json::object out{
      {"version", ISOSTRATA_VERSION}, {"can_draw", !findings.device.empty()}, {"devices", std::move(devices)}};
  out["c_library"] = to_json(findings.c_library);
  boost::json::array egl;
  for (const LoadedLibrary& library : findings.egl) egl.push_back(to_json(library));
  out["egl"] = std::move(egl);
  boost::json::array cards, unused;
  for (const GraphicsCard& card : findings.cards) cards.push_back(to_json(card));
  for (const std::string& reason : findings.unused) unused.push_back(boost::json::string(reason));
  out["cards"] = std::move(cards);
  out["unused_cards"] = std::move(unused);
  if (findings.device.empty()) {
    out["device"] = nullptr;
    out["reason"] = findings.device_detail;
  } else {
    out["device"] = findings.device;
    out["software"] = findings.software;
  }
  if (findings.trial.empty())
    out["renderer_trial"] = nullptr;
  else
    out["renderer_trial"] = findings.trial;
  out["compute_extraction"] = boost::json::object{{"ok", findings.compute.empty()},
                                                  {"detail", findings.compute.empty() ? findings.device : findings.compute}};
  const WorkerProbe& worker = findings.worker;
  out["worker"] = boost::json::object{{"ok", worker.ok},
                                      {"device", worker.device},
                                      {"detail", worker.detail},
                                      {"shut_in", worker.shut_in},
                                      {"start_ms", worker.start_ms},
                                      {"frame_ms", worker.frame_ms},
                                      {"replace_ms", worker.replace_ms}};
  out["codecs"] = std::move(codecs);
  boost::json::array levels;
  for (const std::string& level : simd_levels()) levels.push_back(boost::json::string(level));
  out["simd"] = boost::json::object{{"used", simd_level()}, {"available", std::move(levels)}};
  out["importer"] = boost::json::object{{"found", findings.importer.found}, {"path", findings.importer.path}};
  const std::string missing = missing_of(findings.sandbox);
  out["sandbox"] = boost::json::object{{"ok", missing.empty()},
                                       {"used", to_string(sandbox())},
                                       {"landlock", findings.sandbox.landlock},
                                       {"landlock_truncate", findings.sandbox.landlock >= 3},
                                       {"seccomp", findings.sandbox.seccomp},
                                       {"missing", missing}};
  out["limits"] = boost::json::object{
      {"cores", findings.cores}, {"memory_bytes", findings.memory_bytes}, {"memory_limit_bytes", findings.memory_limit_bytes}};
  return out;
}

void print_sandbox(const SandboxSupport& support) {
  const std::string missing = missing_of(support);
  std::printf("\nsandbox of the importer, the server and the process that draws (--sandbox %s)\n  %-5s ", to_string(sandbox()), missing.empty() ? "ok" : "no");
  if (missing.empty())
    std::printf("Landlock %d%s, and seccomp\n", support.landlock,
                support.landlock < 3 ? " (Linux 6.2 would also keep it from cutting files short by name, which seccomp does here)" : "");
  else
    std::printf("this machine lacks %s\n", missing.c_str());
  if (!missing.empty()) std::printf("        serve wants all of it if --host is not a loopback address\n");
}

void print_libraries(const Findings& findings) {
  std::printf("\nEGL, and what it is loaded with\n  ok    %s: %s\n", findings.c_library.name.c_str(), findings.c_library.detail.c_str());
  for (const LoadedLibrary& library : findings.egl)
    std::printf("  %-5s %s: %s\n", library.ok ? "ok" : "no", library.name.c_str(), library.detail.c_str());
}

void print_text(const Findings& findings) {
  std::printf("isostrata " ISOSTRATA_VERSION "\n\ndevices\n");
  for (const DeviceAttempt& a : findings.attempts)
    std::printf("  %-5s %s: %s\n", a.ok ? "ok" : "no", a.name.c_str(), a.detail.c_str());
  if (findings.device.empty())
    std::printf("  nothing can draw\n");
  else
    std::printf("  used: %s\n", findings.device.c_str());
  if (!findings.trial.empty()) std::printf("  renderer %s\n", findings.trial.c_str());
  for (const std::string& reason : findings.unused) std::printf("  a graphics card is here and does not draw: %s\n", reason.c_str());
  if (findings.software) std::printf("  *** SOFTWARE rendering: pictures are right, but slow; no GPU is used ***\n");
  print_libraries(findings);
  std::printf("\nextraction in OpenGL compute (extract --device)\n  %-5s %s\n", findings.compute.empty() ? "ok" : "no",
              findings.compute.empty() ? "equals the CPU's on a small field" : findings.compute.c_str());
  const WorkerProbe& worker = findings.worker;
  std::printf("\nprocess that draws\n  %-5s %s\n", worker.ok ? "ok" : "no", worker.detail.c_str());
  if (worker.ok)
    std::printf("        kept to its own files by %s\n", worker.shut_in.empty() ? "nothing" : worker.shut_in.c_str());
  if (worker.ok)
    std::printf("        on %s; started in %.0f ms, first frame after %.0f ms, replaced in %.0f ms\n", worker.device.c_str(),
                worker.start_ms, worker.frame_ms, worker.replace_ms);
  std::printf("\nvector instructions (--simd)\n  used: %s; this machine has", simd_level().c_str());
  for (const std::string& level : simd_levels()) std::printf(" %s", level.c_str());
  std::printf("\n\ncodecs\n");
  for (const CodecProbe& codec : findings.codecs)
    std::printf("  %-5s %s: %s\n", codec.ok ? "ok" : "no", codec.name.c_str(), codec.detail.c_str());
  std::printf("\nimporter\n  %-5s %s\n", findings.importer.found ? "ok" : "no", findings.importer.path.c_str());
  if (!findings.importer.found) std::printf("        only analytic data can be opened without it\n");
  print_sandbox(findings.sandbox);
  constexpr double kGiB = 1024.0 * 1024 * 1024;
  std::printf("\nlimits\n  %d cores, %.1f GiB of memory", findings.cores, static_cast<double>(findings.memory_bytes) / kGiB);
  if (findings.memory_limit_bytes > 0)
    std::printf(", limited to %.1f GiB", static_cast<double>(findings.memory_limit_bytes) / kGiB);
  std::printf("\n");
}

}  // namespace

void add_doctor_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("doctor", "Says which devices were tried, why each failed, and what will be used");
  auto device = std::make_shared<std::string>("auto");
  auto json = std::make_shared<bool>(false), trial = std::make_shared<bool>(false);
  command->add_option("--device", *device, "auto, egl:INDEX, egl:UUID, surfaceless or osmesa")->capture_default_str();
  command->add_flag("--json", *json, "Print one JSON document");
  command->add_flag("--trial", *trial, "Hold the trial of the renderers raster and compute on a software device, too");
  command->callback([device, json, trial] {
    const Findings findings = examine(*device, *trial);
    if (*json)
      print_json(to_json(findings));
    else
      print_text(findings);
    std::fflush(stdout);
    if (findings.device.empty()) throw Error(ErrorCode::unavailable, findings.device_detail);
  });
}

}  // namespace isostrata
