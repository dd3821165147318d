// Which OpenGL devices there are. A driver may end the process that loads it, so they are tried in another one.
#pragma once

#include <string_view>
#include <vector>

#include "rendering/picture/renderer.h"

namespace isostrata {

/// What open_context("auto") goes by, found out once in a process: EGL's devices up to the first that is hardware, EGL surfaceless, and OSMesa if EGL
/// gave nothing. A process that has loaded EGL before tries them itself. Any thread.
const std::vector<DeviceAttempt>& automatic_attempts();
/// The one of those that is taken: the first hardware, else the first that works; null: none does.
const DeviceAttempt* automatic_device();

/// A device as open_context takes it, tried as above.
DeviceAttempt probe_device(std::string_view device);

}  // namespace isostrata
