// What `isostrata render` prints of what it has drawn.
#pragma once

#include <boost/json.hpp>
#include <string>

#include "engine/picture/extracted_scene.h"
#include "rendering/picture/renderer.h"
#include "scene/scene.h"

namespace isostrata {

struct RenderTiming {
  double load = 0, extract = 0, device = 0, write = 0, total = 0;  // ms; drawing and writing take turns
};

/// Of the last picture; times are of all.
struct RenderReport {
  const std::string& out;
  const Scene& scene;
  const ExtractedScene& extracted;
  const DrawInput& input;
  const DrawFacts& facts;
  const RenderTiming& ms;
};
boost::json::object to_json(const RenderReport& report);
void print_text(const RenderReport& report);

}  // namespace isostrata
