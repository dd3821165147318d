#include "main/unused_cards.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>

namespace isostrata {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

const LoadedLibrary kEgl{"libEGL.so.1", true, "/lib/libEGL.so.1"}, kMesa{"50_mesa.json: libEGL_mesa.so.0", true, "/lib/libEGL_mesa.so.0"},
    kNvidia{"10_nvidia.json: libEGL_nvidia.so.0", true, "/lib/libEGL_nvidia.so.0"};

GraphicsCard h100() {
  GraphicsCard card{"0000:01:00.0", "10de:2330", "nvidia", "NVIDIA H100 80GB HBM3"};
  card.nodes = {{"/dev/nvidia0", true, 0, "root"}};
  return card;
}
GraphicsCard radeon(bool opens = true) {
  GraphicsCard card{"0000:65:00.0", "1002:73bf", "amdgpu"};
  card.nodes = {{"/dev/dri/renderD128", opens, 104, "render"}};
  return card;
}
CardFacts facts_of(GraphicsCard card, std::vector<LoadedLibrary> egl = {kEgl, kMesa}) {
  CardFacts facts;
  facts.cards = {std::move(card)};
  facts.egl = std::move(egl);
  return facts;
}
CardFacts in_container(CardFacts facts) {
  facts.in_container = true;
  return facts;
}
/// The one reason.
std::string why(const CardFacts& facts) {
  const std::vector<std::string> reasons = why_unused(facts);
  EXPECT_EQ(reasons.size(), 1u);
  return reasons.empty() ? "" : reasons.front();
}

TEST(UnusedCards, NothingIsSaidWithoutACard) { EXPECT_TRUE(why_unused(CardFacts{}).empty()); }

TEST(UnusedCards, EachIsNamedWithModelAndAddress) {
  CardFacts facts = facts_of(h100());
  facts.cards.push_back(radeon());
  EXPECT_THAT(why_unused(facts), ElementsAre(StartsWith("/dev/nvidia0 (NVIDIA H100 80GB HBM3, 0000:01:00.0, 10de:2330, driver nvidia): "),
                                             StartsWith("/dev/dri/renderD128 (0000:65:00.0, 1002:73bf, driver amdgpu): ")));
}

TEST(UnusedCards, ADriverOfNvidiaThatEglDoesNotKnowIsFoundElsewhere) {
  CardFacts facts = facts_of(h100());
  EXPECT_THAT(why(facts), AllOf(HasSubstr("no file of GLVND's vendors names libEGL_nvidia.so.0"), HasSubstr("Install the part of the driver that draws")));
  facts.nvidia_files = {"/usr/local/nvidia/share/glvnd/egl_vendor.d/10_nvidia.json"};
  EXPECT_THAT(why(facts), HasSubstr("set __EGL_VENDOR_LIBRARY_FILENAMES=/usr/local/nvidia/share/glvnd/egl_vendor.d/10_nvidia.json"));
  facts.egl.push_back(kNvidia);
  EXPECT_THAT(why(facts), Not(HasSubstr("__EGL_VENDOR")));
}

TEST(UnusedCards, AContainerWithoutTheCapabilityToDrawIsTold) {
  CardFacts facts = in_container(facts_of(h100()));
  EXPECT_THAT(why(facts), AllOf(HasSubstr("compute,utility (by default)"), HasSubstr("NVIDIA_DRIVER_CAPABILITIES=all")));
  facts.capabilities = "compute,video";
  EXPECT_THAT(why(facts), HasSubstr("has the capabilities compute,video: "));
  for (const char* enough : {"all", "utility,graphics"}) {
    facts.capabilities = enough;
    EXPECT_THAT(why(facts), HasSubstr("Install the part of the driver that draws")) << enough;
  }
}

TEST(UnusedCards, ADriverThatDoesNotLoadIsToldWithItsReason) {
  const LoadedLibrary broken{"10_nvidia.json: libEGL_nvidia.so.0", false, "libEGL_nvidia.so.0: cannot open shared object file"};
  EXPECT_THAT(why(facts_of(h100(), {kEgl, kMesa, broken})), HasSubstr("cannot be loaded: libEGL_nvidia.so.0: cannot open shared object file"));
}

TEST(UnusedCards, ADividedCardDoesNotDraw) {
  GraphicsCard divided = h100();
  divided.divided = true;
  EXPECT_THAT(why(facts_of(divided, {kEgl, kNvidia})), HasSubstr("(MIG)"));
  CardFacts facts = facts_of(h100(), {kEgl, kNvidia});
  EXPECT_THAT(why(facts), Not(HasSubstr("MIG")));
  facts.visible = "MIG-41b35014-745f-5042-8bda-8429ba1c5c93";
  EXPECT_THAT(why(facts), HasSubstr("(MIG)"));
}

TEST(UnusedCards, ANodeOfAGroupThatTheUserIsNotIn) {
  EXPECT_THAT(why(facts_of(radeon(false))), AllOf(HasSubstr("belongs to the group render (104)"), HasSubstr("usermod -aG")));
  EXPECT_THAT(why(in_container(facts_of(radeon(false)))), HasSubstr("--group-add 104"));
}

TEST(UnusedCards, MesaThatIsMissingOrHasNoDeviceForIt) {
  EXPECT_THAT(why(facts_of(radeon(), {kEgl})), HasSubstr("libegl-mesa0"));
  EXPECT_THAT(why(facts_of(radeon())), HasSubstr("the lines above say why"));
}

TEST(UnusedCards, ACardWithoutADeviceFile) {
  GraphicsCard card = h100();
  card.nodes.clear();
  card.driver.clear();
  EXPECT_THAT(why(facts_of(card)), AllOf(StartsWith("NVIDIA H100 80GB HBM3, 0000:01:00.0"), HasSubstr("no device file here"), Not(HasSubstr("--gpus"))));
  EXPECT_THAT(why(in_container(facts_of(card))), HasSubstr("--gpus all"));
}

}  // namespace
}  // namespace isostrata
