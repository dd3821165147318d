// The graphics cards that the kernel tells of, whether or not a driver of OpenGL takes them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace isostrata {

/// A device file of a card: "/dev/dri/renderD128", "/dev/nvidia0".
struct CardNode {
  std::string path;
  bool opens = false;  // this process may read and write it
  unsigned group = 0;      // that it belongs to
  std::string group_name = "";
};

/// What is not known is empty.
struct GraphicsCard {
  std::string address = "";  // on the PCI bus: "0000:65:00.0"
  std::string ids = "";      // vendor and device: "10de:2330"
  std::string driver = "";   // of the kernel: "nvidia", "amdgpu"
  std::string model = "";    // NVIDIA's: "NVIDIA H100 80GB HBM3"
  std::string uuid = "";     // NVIDIA's: 8-4-4-4-12 hexadecimal digits
  bool divided = false;      // NVIDIA's: into instances (MIG)
  std::vector<CardNode> nodes = {};

  bool is_nvidias() const { return driver == "nvidia" || (driver.empty() && ids.starts_with("10de:")); }
};

/// By their addresses: those with a render node, those of NVIDIA's driver, and those of NVIDIA, AMD and Intel on the PCI bus that have no device file
/// here. root: of the files that the kernel tells it by (/dev, /sys, /proc). Any thread.
std::vector<GraphicsCard> graphics_cards(const std::filesystem::path& root = "/");

/// Whether there is a device file by which a card may draw, of any driver that we know of. Where there is none, OpenGL is software, and nobody need load it
/// to find out. Any thread.
bool may_draw_with_card(const std::filesystem::path& root = "/");

/// The one that a device of EGL is: by its device file, or its UUID; null: not known.
const GraphicsCard* card_of(const std::vector<GraphicsCard>& cards, const std::string& file, const std::string& uuid);

/// "NVIDIA H100 80GB HBM3, 0000:01:00.0, 10de:2330, driver nvidia"
std::string description(const GraphicsCard& card);

}  // namespace isostrata
