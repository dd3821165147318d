#include "engine/messages/frame_engine.h"

namespace isostrata {

bool is_software_device(const std::string& device) {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "SWR", "OSMesa", "lavapipe", "Software"})
    if (device.find(name) != std::string::npos) return true;
  return false;
}

bool FrameEngine::device_is_software() const { return facts().device_is_software; }

}  // namespace isostrata
