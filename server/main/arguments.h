// Arguments that several commands share.
#pragma once

#include <CLI/CLI.hpp>
#include <boost/json/value.hpp>
#include <memory>
#include <string>
#include <string_view>

#include "base/task.h"
#include "data/dataset/dataset.h"
#include "extraction/mesh/interval_mesh.h"
#include "scene/style.h"

namespace isostrata {

struct IntervalArgument {
  Interval interval;
  IntervalStyle style;  // defaults where the text says nothing; color from default_interval_color(index)
  std::string name;     // for the legend
  bool has_color = false, has_opacity = false, has_priority = false;  // in the text
};

/// "LOWER:UPPER" and any of: color=#rrggbb|map:NAME, opacity=X|A..B, priority=N; surface=lower|upper|both|domain|all or some of
/// them joined by +, surface-color=#rrggbb, surface-opacity=X, specular=X, shininess=X, silhouette=X, texture=stripes|NAME,
/// repeat=X; name=TEXT (for the legend). A look of the surface without surface= means both. Throws invalid_argument saying which part of which text.
IntervalArgument parse_interval(std::string_view text, std::size_t index);

/// A Task that shows a progress line on standard error if that is a terminal, and is cancelled by SIGINT and SIGTERM.
/// One per process.
Task& command_task();

/// Adds FILE, which must be said. Every "." on the way of a path is left out: to readers it would be the mark of a root (data/files/beneath.h).
void add_file_option(CLI::App& command, std::string& file, const std::string& help);

/// Adds --region and --stride, which open_argument obeys from then on.
void add_region_options(CLI::App& command);
struct Region;  // data/parts/region.h
const Region& region_of_arguments();

/// FILE of a command: analytic data or a path; the part of it that --region and --stride say.
std::shared_ptr<const Dataset> open_argument(const std::string& file, int step = 0);

/// A line on standard error if no value of the array lies in the interval: what is made of it is empty.
void warn_if_outside(const Interval& interval, const PointArray& array);

/// One JSON document and a newline on standard output.
void print_json(const boost::json::value& document);

}  // namespace isostrata
