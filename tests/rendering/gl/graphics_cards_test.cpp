#include "rendering/gl/graphics_cards.h"

#include <gtest/gtest.h>

#include <fstream>

#include "support/temporary_folder.h"

namespace isostrata {
namespace {

namespace fs = std::filesystem;
using isostrata::testing::TemporaryFolder;

/// Files as the kernel has them, in a folder.
class GraphicsCards : public ::testing::Test {
 protected:
  void write(const std::string& file, const std::string& text = "") {
    fs::create_directories((folder_ / file).parent_path());
    std::ofstream(folder_ / file) << text;
  }
  void pci_device(const std::string& address, const std::string& kind, const std::string& vendor, const std::string& device, const std::string& driver) {
    const std::string at = "sys/bus/pci/devices/" + address + "/";
    write(at + "class", kind + "\n");
    write(at + "vendor", vendor + "\n");
    write(at + "device", device + "\n");
    if (!driver.empty()) fs::create_symlink("../../drivers/" + driver, folder_ / (at + "driver"));
  }
  void render_node(const std::string& name, const std::string& address) {
    write("dev/dri/" + name);
    fs::create_directories(folder_ / ("sys/class/drm/" + name));
    fs::create_symlink("../../../bus/pci/devices/" + address, folder_ / ("sys/class/drm/" + name + "/device"));
  }
  std::vector<GraphicsCard> cards() { return graphics_cards(folder_.path()); }

  TemporaryFolder folder_;
};

TEST_F(GraphicsCards, AreNoneOnAMachineWithout) {
  EXPECT_TRUE(cards().empty());
  pci_device("0000:00:03.0", "0x020000", "0x8086", "0x100e", "e1000");  // a network card
  pci_device("0000:03:00.0", "0x030000", "0x1a03", "0x2000", "ast");    // what a server shows its console with
  write("dev/nvidiactl");
  write("dev/dri/card0");
  EXPECT_TRUE(cards().empty());
}

TEST_F(GraphicsCards, WithoutADeviceFileNoneDraws) {
  EXPECT_FALSE(may_draw_with_card(folder_.path()));
  write("dev/null");
  write("dev/dri/card0");  // what a server shows its console with
  EXPECT_FALSE(may_draw_with_card(folder_.path()));
  for (const char* file : {"dev/dri/renderD128", "dev/nvidia0", "dev/nvidiactl", "dev/dxg", "dev/mali0", "dev/kgsl-3d0"}) {
    write(file);
    EXPECT_TRUE(may_draw_with_card(folder_.path())) << file;
    fs::remove(folder_ / file);
  }
  EXPECT_FALSE(may_draw_with_card(folder_.path()));
}

TEST_F(GraphicsCards, AreKnownByTheirRenderNode) {
  pci_device("0000:65:00.0", "0x030000", "0x1002", "0x73bf", "amdgpu");
  render_node("renderD128", "0000:65:00.0");
  const auto found = cards();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(description(found[0]), "0000:65:00.0, 1002:73bf, driver amdgpu");
  ASSERT_EQ(found[0].nodes.size(), 1u);
  EXPECT_EQ(found[0].nodes[0].path, "/dev/dri/renderD128");
  EXPECT_TRUE(found[0].nodes[0].opens);
  EXPECT_FALSE(found[0].is_nvidias());
  EXPECT_EQ(card_of(found, "/dev/dri/renderD128", ""), &found[0]);
  EXPECT_EQ(card_of(found, "/dev/dri/renderD129", ""), nullptr);
  EXPECT_EQ(card_of(found, "", ""), nullptr);
}

TEST_F(GraphicsCards, OfNvidiaHaveModelAndUuidAndAreOneCardWithTheirRenderNode) {
  pci_device("0000:01:00.0", "0x030200", "0x10de", "0x2330", "nvidia");
  pci_device("0000:02:00.0", "0x030200", "0x10de", "0x2330", "nvidia");
  const auto information = [](const char* minor, const char* uuid) {
    return "Model: \t\t NVIDIA H100 80GB HBM3\nIRQ:   \t\t 30\nGPU UUID: \t GPU-" + std::string(uuid) + "\nDevice Minor: \t " + minor + "\n";
  };
  write("proc/driver/nvidia/gpus/0000:01:00.0/information", information("0", "12345678-9abc-def0-1234-56789abcdef0"));
  write("proc/driver/nvidia/gpus/0000:02:00.0/information", information("1", "22345678-9abc-def0-1234-56789abcdef0"));
  write("proc/driver/nvidia/capabilities/gpu0/mig/config");
  write("proc/driver/nvidia/capabilities/gpu1/mig/gi7/access");
  render_node("renderD128", "0000:01:00.0");
  write("dev/nvidia0");
  write("dev/nvidia1");
  const auto found = cards();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(description(found[0]), "NVIDIA H100 80GB HBM3, 0000:01:00.0, 10de:2330, driver nvidia");
  ASSERT_EQ(found[0].nodes.size(), 2u);
  EXPECT_EQ(found[0].nodes[1].path, "/dev/nvidia0");
  EXPECT_FALSE(found[0].divided);
  EXPECT_TRUE(found[1].divided);
  EXPECT_EQ(card_of(found, "", "22345678-9abc-def0-1234-56789abcdef0"), &found[1]);
}

TEST_F(GraphicsCards, WithoutADeviceFileAreTold) {
  pci_device("0000:01:00.0", "0x030200", "0x10de", "0x2330", "");
  const auto found = cards();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].nodes.empty());
  EXPECT_TRUE(found[0].is_nvidias());
}

TEST_F(GraphicsCards, OfNvidiaAreKnownByTheirFileWhereNothingElseTells) {
  write("dev/nvidia0");
  const auto found = cards();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].is_nvidias());
  EXPECT_EQ(found[0].nodes.at(0).path, "/dev/nvidia0");
}

}  // namespace
}  // namespace isostrata
