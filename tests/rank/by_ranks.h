// The same command by one process and by ranks, and how far two pictures are apart.
#pragma once

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "support/run_isostrata.h"

namespace isostrata::testing {

/// As root OpenMPI wants to be asked twice; nothing of this reaches anybody who is not.
inline std::string launcher_environment() {
  return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_vader_single_copy_mechanism=none";
}
/// The same for servers, which this process starts.
inline void set_mpi_environment() {
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 1);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 1);
  setenv("OMPI_MCA_btl_vader_single_copy_mechanism", "none", 1);
}
inline std::string launcher(int ranks) { return "mpirun --oversubscribe -n " + std::to_string(ranks); }

/// Samples as they are composited: display values, premultiplied.
struct Samples {
  int width = 0, height = 0;
  std::vector<float> rgba, depth;
};

inline Samples read_exr(const std::filesystem::path& path) {
  const auto in = OIIO::ImageInput::open(path.string());
  if (!in) throw std::runtime_error(path.string() + ": " + OIIO::geterror());
  const auto& spec = in->spec();
  Samples out{spec.width, spec.height, {}, {}};
  std::vector<float> all(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
  in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, all.data());
  for (std::size_t p = 0; p < all.size(); p += static_cast<std::size_t>(spec.nchannels)) {
    const float alpha = all[p + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      const float linear = alpha > 0 ? all[p + c] / alpha : 0;
      out.rgba.push_back(alpha * (linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f));
    }
    out.rgba.push_back(alpha);
    if (spec.nchannels > 4) out.depth.push_back(all[p + 4]);
  }
  return out;
}

struct Distance {
  double worst = 0;        // of colour and alpha
  double above = 0;        // the share of pixels with a sample more than 1e-5 off
  double steps = 0;        // the share of samples that are another number of 8 bits
  double worst_depth = 0;  // where both have one
  std::size_t one_sided = 0;
  double brightest = 0;  // of the first picture: a comparison of nothing is none
};

inline Distance distance_of(const Samples& a, const Samples& b) {
  Distance out;
  EXPECT_EQ(a.rgba.size(), b.rgba.size());
  std::size_t above = 0, steps = 0;
  for (std::size_t p = 0; p < std::min(a.rgba.size(), b.rgba.size()); p += 4) {
    double worst = 0;
    for (std::size_t c = 0; c < 4; ++c) {
      worst = std::max(worst, std::abs(double{a.rgba[p + c]} - b.rgba[p + c]));
      steps += std::lround(255 * a.rgba[p + c]) != std::lround(255 * b.rgba[p + c]);
      out.brightest = std::max(out.brightest, double{a.rgba[p + c]});
    }
    above += worst > 1e-5;
    out.worst = std::max(out.worst, worst);
  }
  out.above = static_cast<double>(above) / static_cast<double>(a.rgba.size() / 4);
  out.steps = static_cast<double>(steps) / static_cast<double>(a.rgba.size());
  for (std::size_t p = 0; p < std::min(a.depth.size(), b.depth.size()); ++p) {
    const bool in_a = std::isfinite(a.depth[p]), in_b = std::isfinite(b.depth[p]);
    if (in_a && in_b) out.worst_depth = std::max(out.worst_depth, std::abs(double{a.depth[p]} - b.depth[p]));
    out.one_sided += in_a != in_b;
  }
  return out;
}

inline std::string quoted(const std::filesystem::path& path);

/// Of the file's first array of floats the middle third: "--array NAME --interval LOWER:UPPER".
inline std::string middle_third(const std::filesystem::path& file) {
  const auto info = boost::json::parse(run_isostrata("info " + quoted(file) + " --json").out).as_object();
  const auto& arrays = info.at("arrays").as_array();
  const auto first = std::find_if(arrays.begin(), arrays.end(), [](const auto& of) { return of.as_object().at("type").as_string().starts_with("float"); });
  const auto& array = first->as_object();
  const double lower = array.at("range").as_array()[0].to_number<double>(), upper = array.at("range").as_array()[1].to_number<double>();
  return "--array " + quoted(array.at("name").as_string().c_str()) + " --interval " + std::to_string(lower + (upper - lower) / 3) + ":" + std::to_string(upper - (upper - lower) / 3);
}

inline std::string quoted(const std::filesystem::path& path) { return "'" + path.string() + "'"; }

/// `isostrata render ARGUMENTS`, by one process where ranks is 0.
inline Samples render_exr(const TemporaryFolder& folder, const std::string& arguments, int ranks, const std::string& environment = "") {
  const std::filesystem::path out = folder / ("picture_" + std::to_string(ranks) + ".exr");
  std::filesystem::remove(out);
  const std::string command = "render " + arguments + " --background transparent --out " + quoted(out) + (ranks > 0 ? " --ranks '" + launcher(ranks) + "'" : "");
  const CommandResult run = run_isostrata(command, launcher_environment() + " " + environment);
  if (run.status != 0) throw std::runtime_error(command + ": status " + std::to_string(run.status) + ", " + run.err);
  return read_exr(out);
}

}  // namespace isostrata::testing
