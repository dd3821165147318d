// Why a graphics card that is here does not draw.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "main/egl_drivers.h"
#include "rendering/gl/graphics_cards.h"

namespace isostrata {

/// What decides whether EGL finds a card.
struct CardFacts {
  std::vector<GraphicsCard> cards;
  std::vector<LoadedLibrary> egl;                 // as egl_libraries() gives them
  std::vector<std::string> nvidia_files;          // that name NVIDIA's driver and lie where GLVND does not look
  std::optional<std::string> capabilities;        // $NVIDIA_DRIVER_CAPABILITIES
  std::optional<std::string> visible;             // $NVIDIA_VISIBLE_DEVICES
  bool in_container = false;
};

/// Of this machine and process.
CardFacts card_facts(std::vector<LoadedLibrary> egl);

/// Sentences that say of each card why it does not draw and what to do, for a machine on which no hardware has been opened; none: there is no card.
std::vector<std::string> why_unused(const CardFacts& facts);

}  // namespace isostrata
