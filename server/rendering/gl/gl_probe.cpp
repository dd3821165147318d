#include "rendering/gl/gl_probe.h"

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/error.h"
#include "base/run_in_child.h"
#include "rendering/gl/gl_ways.h"

namespace isostrata {
namespace {

constexpr std::chrono::seconds kLimit{30};  // drivers of several GPUs that nobody uses take seconds
constexpr const char* kList = "EGL devices";

// What the child says of each thing that it tries: its name and how it is asked for before, and then how it went; each word ends with a zero byte.
constexpr const char* kNothing = "-";
constexpr const char* kFailed = "failed";
constexpr const char* kSoftware = "software";
constexpr const char* kHardware = "hardware";
constexpr std::size_t kWordsBefore = 2, kWords = 4;

/// Tries what is wanted, in order, but for what is known already, and says so.
class Attempts {
 public:
  Attempts(std::vector<DeviceAttempt> known, const Say& say) : known_(std::move(known)), say_(say) {}

  void try_all(bool list_all) {
    for (const EglDevice& device : egl_devices_once()) {
      if (device.software && !list_all) continue;
      attempt(device.name, "egl:" + std::to_string(device.index), device.software, [&] { return open_egl(device); });
      if (found_hardware() && !list_all) return;
    }
    attempt("EGL surfaceless", "surfaceless", false, open_surfaceless);
    const bool egl_works = std::any_of(known_.begin(), known_.end(), [](const DeviceAttempt& of) { return of.ok; });
    if (!egl_works) attempt("OSMesa", "osmesa", false, open_osmesa);
  }
  void attempt(const std::string& name, const std::string& device, bool software, const std::function<std::unique_ptr<GlContext>()>& open) {
    if (is_known(name)) return;
    begin(name, device);
    DeviceAttempt record{name, false, "", software, device};
    try {
      const std::unique_ptr<GlContext> context = open();
      record.ok = true;
      record.software = software || context->software();
      record.detail = context->device();
      if (!context->uuid().empty()) record.detail += ", UUID " + context->uuid();
    } catch (const Error& error) {
      record.detail = error.what();
    }
    end(!record.ok ? kFailed : record.software ? kSoftware : kHardware, record.detail);
    known_.push_back(std::move(record));
  }

 private:
  std::vector<EglDevice> egl_devices_once() {
    if (is_known(kList)) return {};  // their driver has ended a process, or there are none
    begin(kList, "");
    std::vector<DeviceAttempt> why_not;
    std::vector<EglDevice> devices = egl_devices(why_not);
    end(why_not.empty() ? kNothing : kFailed, why_not.empty() ? "" : why_not.front().detail);
    return devices;
  }
  bool is_known(const std::string& name) const {
    return std::any_of(known_.begin(), known_.end(), [&](const DeviceAttempt& of) { return of.name == name; });
  }
  bool found_hardware() const {
    return std::any_of(known_.begin(), known_.end(), [](const DeviceAttempt& of) { return of.ok && !of.software; });
  }
  void begin(const std::string& name, const std::string& device) { say_(name + '\0' + device + '\0'); }
  void end(const std::string& how, const std::string& detail) { say_(how + '\0' + detail + '\0'); }

  std::vector<DeviceAttempt> known_;
  const Say& say_;
};

/// Adds what was said. Returns what was begun and not ended: its name and how it is asked for; empty: nothing.
std::vector<std::string> add_said(const std::string& said, std::vector<DeviceAttempt>& attempts) {
  std::vector<std::string> words;
  std::size_t at = 0;
  for (std::size_t end; (end = said.find('\0', at)) != std::string::npos; at = end + 1) {
    words.push_back(said.substr(at, end - at));
    if (words.size() < kWords) continue;
    if (words[2] != kNothing) attempts.push_back({words[0], words[2] != kFailed, words[3], words[2] == kSoftware, words[1]});
    words.clear();
  }
  if (words.size() < kWordsBefore) words.clear();
  return words;
}

/// By `try_them`, in children: one whose driver ends its process is known to the next.
std::vector<DeviceAttempt> probe(const std::function<void(Attempts&)>& try_them) {
  std::vector<DeviceAttempt> attempts;
  for (;;) {
    const auto work = [&](const Say& say) {
      Attempts here(attempts, say);
      try_them(here);
    };
    ChildRun run;
    if (egl_is_loaded())
      work([&](std::string_view text) { run.said += text; });
    else
      run = run_in_child(work, kLimit);
    const std::vector<std::string> begun = add_said(run.said, attempts);
    if (run.ended.empty()) return attempts;
    if (begun.empty()) {
      attempts.push_back({"OpenGL", false, "no process could try it: " + run.ended, false, ""});
      return attempts;
    }
    attempts.push_back({begun[0], false, "the driver ended the process that tried it: " + run.ended, false, begun[1]});
  }
}

}  // namespace

std::vector<DeviceAttempt> probe_devices() {
  return probe([](Attempts& attempts) { attempts.try_all(true); });
}

const std::vector<DeviceAttempt>& automatic_attempts() {
  static const std::vector<DeviceAttempt> attempts = probe([](Attempts& of) { of.try_all(false); });
  return attempts;
}

const DeviceAttempt* automatic_device() {
  const std::vector<DeviceAttempt>& attempts = automatic_attempts();
  const auto first = [&](auto fits) {
    const auto found = std::find_if(attempts.begin(), attempts.end(), [&](const DeviceAttempt& of) { return of.ok && fits(of); });
    return found == attempts.end() ? nullptr : &*found;
  };
  const DeviceAttempt* hardware = first([](const DeviceAttempt& of) { return !of.software; });
  return hardware ? hardware : first([](const DeviceAttempt&) { return true; });
}

DeviceAttempt probe_device(std::string_view device) {
  const std::string name = "device " + std::string(device);
  return probe([&](Attempts& attempts) { attempts.attempt(name, std::string(device), false, [&] { return open_context(device); }); }).front();
}

}  // namespace isostrata
