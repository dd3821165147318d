#include "main/unused_cards.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <utility>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

// Where drivers are put beside the system's: Kubernetes and virtual machines of clouds, NixOS, CUDA's compatibility folder.
constexpr const char* kOtherPlaces[] = {"/usr/local/nvidia/share/glvnd/egl_vendor.d", "/usr/local/share/glvnd/egl_vendor.d",
                                        "/run/opengl-driver/share/glvnd/egl_vendor.d", "/opt/nvidia/share/glvnd/egl_vendor.d"};

std::optional<std::string> variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? std::optional<std::string>(value) : std::nullopt;
}

bool is_nvidias(const LoadedLibrary& library) { return library.name.find("libEGL_nvidia") != std::string::npos; }
bool is_mesas(const LoadedLibrary& library) { return library.name.find("libEGL_mesa") != std::string::npos; }

bool draws_with(const std::string& capabilities) {
  std::istringstream words(capabilities);
  for (std::string word; std::getline(words, word, ',');)
    if (word == "all" || word == "graphics") return true;
  return false;
}

/// The nodes that do not open, and what to do.
void add_closed_nodes(const CardFacts& facts, const GraphicsCard& card, std::vector<std::string>& reasons) {
  for (const CardNode& node : card.nodes) {
    if (node.opens) continue;
    const std::string number = std::to_string(node.group);
    const std::string what = node.path + " may not be opened by this user: it belongs to the group " +
                             (node.group_name.empty() ? number : node.group_name + " (" + number + ")");
    reasons.push_back(facts.in_container ? what + ". Start the container with --group-add " + number
                                         : what + ". Add the user to it (usermod -aG), in a service by SupplementaryGroups=, and log in again");
  }
}

std::string why_nvidias_does_not_draw(const CardFacts& facts, const GraphicsCard& card) {
  if (card.divided || (facts.visible && facts.visible->find("MIG-") != std::string::npos))
    return "it is divided into instances (MIG), which compute and do not draw. `nvidia-smi -mig 0` makes it whole again";
  const auto driver = std::find_if(facts.egl.begin(), facts.egl.end(), is_nvidias);
  if (driver == facts.egl.end()) {
    const std::string none = "EGL knows no driver of NVIDIA: no file of GLVND's vendors names libEGL_nvidia.so.0. ";
    if (!facts.nvidia_files.empty()) return none + "One lies elsewhere: set __EGL_VENDOR_LIBRARY_FILENAMES=" + facts.nvidia_files.front();
    if (facts.in_container && !draws_with(facts.capabilities.value_or("compute,utility")))
      return none + "The container has the capabilities " + facts.capabilities.value_or("compute,utility (by default)") +
             ": start it with -e NVIDIA_DRIVER_CAPABILITIES=all";
    return none + "Install the part of the driver that draws (Debian: nvidia-egl-icd; Ubuntu: libnvidia-gl-VERSION of the kernel's driver)";
  }
  if (!driver->ok) return driver->name + " cannot be loaded: " + driver->detail;
  return "its driver was loaded, and no device of it draws: the lines above say why";
}

std::string why_does_not_draw(const CardFacts& facts, const GraphicsCard& card) {
  if (card.nodes.empty())
    return "it has no device file here" + std::string(facts.in_container ? ". Start the container with --gpus all (NVIDIA), or --device /dev/dri (others)"
                                                                         : ": the kernel has no driver for it, or /dev is not the machine's");
  if (card.is_nvidias()) return why_nvidias_does_not_draw(facts, card);
  const auto driver = std::find_if(facts.egl.begin(), facts.egl.end(), is_mesas);
  if (driver == facts.egl.end()) return "EGL knows no driver of Mesa. Install it (Debian: libegl-mesa0 and libgl1-mesa-dri)";
  if (!driver->ok) return driver->name + " cannot be loaded: " + driver->detail;
  return "Mesa was loaded, and no device of it draws: the lines above say why";
}

}  // namespace

CardFacts card_facts(std::vector<LoadedLibrary> egl) {
  CardFacts facts;
  facts.cards = graphics_cards();
  facts.egl = std::move(egl);
  facts.capabilities = variable("NVIDIA_DRIVER_CAPABILITIES");
  facts.visible = variable("NVIDIA_VISIBLE_DEVICES");
  std::error_code error;
  facts.in_container = fs::exists("/.dockerenv", error) || fs::exists("/run/.containerenv", error) || variable("KUBERNETES_SERVICE_HOST") || facts.visible;
  for (const char* folder : kOtherPlaces)
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
      if (it->path().filename().string().find("nvidia") != std::string::npos) facts.nvidia_files.push_back(it->path().string());
  return facts;
}

std::vector<std::string> why_unused(const CardFacts& facts) {
  std::vector<std::string> reasons;
  for (const GraphicsCard& card : facts.cards) {
    std::vector<std::string> of_card;
    add_closed_nodes(facts, card, of_card);
    if (of_card.empty()) of_card.push_back(why_does_not_draw(facts, card));
    const std::string known = description(card), name = card.nodes.empty() ? known : card.nodes.front().path + (known.empty() ? "" : " (" + known + ")");
    for (const std::string& reason : of_card) reasons.push_back(name + ": " + reason);
  }
  return reasons;
}

}  // namespace isostrata
