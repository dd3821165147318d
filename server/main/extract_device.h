// `extract --device`: where interval volumes are extracted.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "extraction/layers/extract_layers.h"

namespace isostrata {

struct ExtractDevice {
  std::string wanted = "cpu";  // cpu, auto, or a device as make_renderer takes it
  std::string used = "cpu";    // what extracted, once it has: "cpu" or the device's name
};

/// Adds --device. `device` must outlive the command.
void add_device_option(CLI::App& command, ExtractDevice& device);

/// What extract_layers calls. cpu: nothing, so extract_intervals. A named device: extracts there or throws. auto: a GPU where
/// there is one; what it cannot do, and everything if there is none, is done by extract_intervals, with a word on standard
/// error for what a GPU refused. `device` must outlive what is returned.
Extractor device_extractor(ExtractDevice& device);

}  // namespace isostrata
