#include "rendering/gl/graphics_cards.h"

#include <grp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <fstream>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

namespace isostrata {
namespace {

namespace fs = std::filesystem;

constexpr std::array kMakers = {"0x10de", "0x1002", "0x8086"};  // NVIDIA, AMD, Intel

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) found.push_back(it->path());
  std::sort(found.begin(), found.end());
  return found;
}

std::string word_in(const fs::path& file) {
  std::ifstream in(file);
  std::string word;
  in >> word;
  return word;
}

/// "0000:65:00.0"
bool is_address(const std::string& name) {
  constexpr std::string_view kShape = "xxxx:xx:xx.x";
  return name.size() == kShape.size() && std::equal(name.begin(), name.end(), kShape.begin(), [](char c, char shape) {
           return shape == 'x' ? std::isxdigit(static_cast<unsigned char>(c)) != 0 : c == shape;
         });
}

bool has_digits_after(const std::string& name, std::string_view start) {
  return name.size() > start.size() && name.starts_with(start) &&
         std::all_of(name.begin() + static_cast<std::ptrdiff_t>(start.size()), name.end(), [](char c) { return c >= '0' && c <= '9'; });
}

CardNode node_of(const fs::path& root, const std::string& path) {
  CardNode node{path};
  const fs::path file = root / path.substr(1);
  node.opens = access(file.c_str(), R_OK | W_OK) == 0;
  struct stat of {};
  if (stat(file.c_str(), &of) != 0) return node;
  group entry{}, *found = nullptr;
  std::array<char, 4096> text;
  node.group = of.st_gid;
  if (getgrgid_r(of.st_gid, &entry, text.data(), text.size(), &found) == 0 && found) node.group_name = entry.gr_name;
  return node;
}

/// From the folder of a device in /sys.
void add_sys_facts(const fs::path& device, GraphicsCard& card) {
  const std::string vendor = word_in(device / "vendor"), id = word_in(device / "device");
  if (vendor.size() > 2 && id.size() > 2) card.ids = vendor.substr(2) + ":" + id.substr(2);
  std::error_code error;
  const fs::path driver = fs::read_symlink(device / "driver", error);
  if (!error) card.driver = driver.filename().string();
}

/// From a line "Name: value" of NVIDIA's driver.
void add_nvidia_facts(const fs::path& folder, GraphicsCard& card, std::string& minor) {
  std::ifstream in(folder / "information");
  for (std::string line; std::getline(in, line);) {
    const auto colon = line.find(':');
    const auto from = colon == std::string::npos ? colon : line.find_first_not_of(" \t", colon + 1);
    if (from == std::string::npos) continue;
    const std::string name = line.substr(0, colon), value = line.substr(from, line.find_last_not_of(" \t\r") + 1 - from);
    if (name == "Model") card.model = value;
    if (name == "GPU UUID") card.uuid = value.starts_with("GPU-") ? value.substr(4) : value;
    if (name == "Device Minor") minor = value;
  }
}

bool is_divided(const fs::path& root, const std::string& minor) {
  const auto instances = entries(root / "proc/driver/nvidia/capabilities" / ("gpu" + minor) / "mig");
  return std::any_of(instances.begin(), instances.end(), [](const fs::path& of) { return has_digits_after(of.filename().string(), "gi"); });
}

}  // namespace

std::vector<GraphicsCard> graphics_cards(const fs::path& root) {
  std::map<std::string, GraphicsCard> cards;  // by address, or by device file if that is not known
  const auto card_at = [&](const std::string& address, const std::string& otherwise) -> GraphicsCard& {
    GraphicsCard& card = cards[is_address(address) ? address : otherwise];
    if (is_address(address)) card.address = address;
    return card;
  };
  for (const fs::path& file : entries(root / "dev/dri")) {
    const std::string name = file.filename().string();
    if (!has_digits_after(name, "renderD")) continue;
    std::error_code error;
    const fs::path device = fs::canonical(root / "sys/class/drm" / name / "device", error);
    GraphicsCard& card = card_at(error ? "" : device.filename().string(), name);
    if (!error) add_sys_facts(device, card);
    card.nodes.push_back(node_of(root, "/dev/dri/" + name));
  }
  std::vector<std::string> known_minors;
  for (const fs::path& folder : entries(root / "proc/driver/nvidia/gpus")) {
    GraphicsCard& card = card_at(folder.filename().string(), folder.filename().string());
    add_sys_facts(root / "sys/bus/pci/devices" / folder.filename(), card);
    card.driver = "nvidia";
    std::string minor;
    add_nvidia_facts(folder, card, minor);
    card.divided = is_divided(root, minor);
    known_minors.push_back("nvidia" + minor);
    if (fs::exists(root / "dev" / known_minors.back())) card.nodes.push_back(node_of(root, "/dev/" + known_minors.back()));
  }
  for (const fs::path& file : entries(root / "dev")) {
    const std::string name = file.filename().string();
    if (!has_digits_after(name, "nvidia") || std::find(known_minors.begin(), known_minors.end(), name) != known_minors.end()) continue;
    GraphicsCard& card = card_at("", name);
    card.driver = "nvidia";
    card.nodes.push_back(node_of(root, "/dev/" + name));
  }
  for (const fs::path& device : entries(root / "sys/bus/pci/devices")) {
    const bool draws = word_in(device / "class").starts_with("0x03");
    const std::string maker = draws ? word_in(device / "vendor") : "";
    if (std::find(kMakers.begin(), kMakers.end(), maker) != kMakers.end()) add_sys_facts(device, card_at(device.filename().string(), device.filename().string()));
  }
  std::vector<GraphicsCard> found;
  for (auto& [key, card] : cards) found.push_back(std::move(card));
  return found;
}

bool may_draw_with_card(const fs::path& root) {
  std::error_code ignored;
  if (fs::exists(root / "dev/dxg", ignored)) return true;  // Windows' card, in its Linux
  const auto any = [&](const char* folder, std::initializer_list<std::string_view> names) {
    const std::vector<fs::path> there = entries(root / folder);
    return std::any_of(there.begin(), there.end(), [&](const fs::path& file) {
      const std::string name = file.filename().string();
      return std::any_of(names.begin(), names.end(), [&](std::string_view start) { return name.starts_with(start); });
    });
  };
  return any("dev/dri", {"renderD"}) || any("dev", {"nvidia", "mali", "kgsl"});
}

const GraphicsCard* card_of(const std::vector<GraphicsCard>& cards, const std::string& file, const std::string& uuid) {
  const auto found = std::find_if(cards.begin(), cards.end(), [&](const GraphicsCard& card) {
    return (!uuid.empty() && card.uuid == uuid) ||
           std::any_of(card.nodes.begin(), card.nodes.end(), [&](const CardNode& node) { return node.path == file; });
  });
  return found == cards.end() ? nullptr : &*found;
}

std::string description(const GraphicsCard& card) {
  std::string text;
  const auto add = [&](const std::string& word) {
    if (!word.empty()) text += (text.empty() ? "" : ", ") + word;
  };
  add(card.model);
  add(card.address);
  add(card.ids);
  add(card.driver.empty() ? "" : "driver " + card.driver);
  return text;
}

}  // namespace isostrata
