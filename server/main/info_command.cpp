#include <algorithm>
#include <boost/json.hpp>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>

#include "base/utf8.h"
#include "data/derived/series_ranges.h"
#include "data/files/list_folder.h"
#include "data/files/recognise.h"
#include "main/arguments.h"
#include "main/commands.h"
#include "main/sandbox_option.h"

namespace isostrata {
namespace {

namespace json = boost::json;

const char* to_string(Association association) { return association == Association::point ? "point" : "cell_averaged"; }

std::int64_t hidden_cells(const Grid& grid) {
  return std::count_if(grid.hidden_cells.begin(), grid.hidden_cells.end(), [](std::uint8_t hidden) { return hidden != 0; });
}

/// null if there is no finite value: JSON has no NaN.
json::value range_json(const ValueRange& range) {
  if (range.empty()) return nullptr;
  return json::array{range.lower, range.upper};
}

/// Of the dataset's step, and of all others if that is wanted; notes say which could not be read.
SeriesRanges read_ranges(const Dataset& dataset, const std::string& file, bool all_steps, std::vector<std::string>& notes) {
  SeriesRanges ranges(dataset);
  while (all_steps && !ranges.complete()) {
    const int step = ranges.next();
    try {
      ranges.add(*open_argument(file, step));
    } catch (const Error& error) {
      if (error.code() == ErrorCode::cancelled) throw;
      notes.push_back("step " + std::to_string(step) + " is left out of the ranges: " + error.what());
    }
    ranges.skip(step);  // also where it turns out to be another one
  }
  if (const auto boxes = ranges.note_of_boxes()) notes.push_back(*boxes);
  return ranges;
}

json::object describe(const Dataset& dataset, const SeriesRanges& ranges, const std::vector<std::string>& notes) {
  json::object out;
  out["name"] = dataset.name;
  out["grid"] = dataset.grid.kind_name();
  if (dataset.grid.structured()) {
    const auto d = dataset.grid.dims();
    out["dims"] = json::array{d[0], d[1], d[2]};
  }
  out["points"] = dataset.grid.point_count();
  out["cells"] = dataset.grid.cell_count();
  out["hidden_cells"] = hidden_cells(dataset.grid);
  json::object types;
  for (const auto& [name, count] : dataset.cell_types) types[name] = count;
  out["cell_types"] = std::move(types);
  const Box3d& box = dataset.bounds;
  out["bounds"] = box.empty()
                      ? json::value(nullptr)
                      : json::value(json::array{json::array{box.lower.x, box.upper.x}, json::array{box.lower.y, box.upper.y},
                                                json::array{box.lower.z, box.upper.z}});
  json::array axes;
  for (const Axis& axis : dataset.axes) axes.push_back(json::object{{"name", axis.name}, {"unit", axis.unit}, {"downward", axis.downward}});
  out["axes"] = std::move(axes);
  json::array arrays;
  for (std::size_t i = 0; i < dataset.arrays.size(); ++i) {
    const PointArray& array = dataset.arrays[i];
    const ArrayRanges& of_steps = ranges.arrays()[i];
    json::array step_ranges;
    for (const ValueRange& range : of_steps.steps) step_ranges.push_back(range_json(range));
    arrays.push_back(json::object{{"name", array.name},
                                  {"association", to_string(array.association)},
                                  {"type", to_string(array.type)},
                                  {"components", array.components},
                                  {"component", array.component},
                                  {"unit", array.unit},
                                  {"range", range_json(of_steps.all)},
                                  {"step_range", range_json({array.lower, array.upper})},
                                  {"step_ranges", std::move(step_ranges)},
                                  {"nan_count", array.nan_count}});
    if (array.cells) {
      arrays.back().as_object()["cell_type"] = to_string(array.cells->type);
      arrays.back().as_object()["cell_range"] = range_json({array.cells->lower, array.cells->upper});
    }
  }
  out["arrays"] = std::move(arrays);
  out["times"] = json::array(dataset.times.begin(), dataset.times.end());
  out["step"] = dataset.step;
  out["range_steps"] = ranges.known_steps();
  out["notes"] = json::array(notes.begin(), notes.end());
  return out;
}

void print_text(const Dataset& dataset, const SeriesRanges& ranges, const std::vector<std::string>& notes) {
  std::printf("%s\n", dataset.name.c_str());
  std::printf("  grid    %s", dataset.grid.kind_name());
  if (dataset.grid.structured()) {
    const auto d = dataset.grid.dims();
    std::printf(", %lld x %lld x %lld points", static_cast<long long>(d[0]), static_cast<long long>(d[1]),
                static_cast<long long>(d[2]));
  }
  std::printf("\n  points  %lld\n  cells   %lld", static_cast<long long>(dataset.grid.point_count()),
              static_cast<long long>(dataset.grid.cell_count()));
  for (const auto& [name, count] : dataset.cell_types) std::printf(", %s %lld", name.c_str(), static_cast<long long>(count));
  if (const auto hidden = hidden_cells(dataset.grid)) std::printf(", of which %lld hidden", static_cast<long long>(hidden));
  const Box3d& box = dataset.bounds;
  if (!box.empty())
    std::printf("\n  bounds  x [%g, %g]  y [%g, %g]  z [%g, %g]", box.lower.x, box.upper.x, box.lower.y, box.upper.y, box.lower.z,
                box.upper.z);
  if (std::any_of(dataset.axes.begin(), dataset.axes.end(), [](const Axis& axis) { return !axis.name.empty() || !axis.unit.empty(); }))
    for (int axis = 0; axis < 3; ++axis) {
      const Axis& of = dataset.axes[static_cast<std::size_t>(axis)];
      const std::string name = std::string(1, "xyz"[axis]) + (of.name.empty() ? "" : " " + of.name);
      std::printf("%s%s%s", axis == 0 ? "\n  axes    " : ", ", name_with_unit(name, of.unit).c_str(), of.downward ? " downward" : "");
    }
  if (dataset.times.size() > 1)
    std::printf("\n  times   %zu steps from %.12g to %.12g; this is step %d", dataset.times.size(), dataset.times.front(),
                dataset.times.back(), dataset.step);
  else
    std::printf("\n  times   %.12g", dataset.times.front());
  std::printf("\n  arrays  %zu", dataset.arrays.size());
  if (ranges.known_steps() > 1)
    std::printf(", with their ranges over %s%d steps", ranges.complete() ? "all " : "", ranges.known_steps());
  else if (!ranges.complete())
    std::printf(", with their ranges at this step");
  std::printf("\n");
  for (std::size_t i = 0; i < dataset.arrays.size(); ++i) {
    const PointArray& array = dataset.arrays[i];
    const ValueRange all = ranges.arrays()[i].all, here{array.lower, array.upper};
    std::printf("    %-28s %-8s", name_with_unit(array.name, array.unit).c_str(), to_string(array.type));
    if (all.empty())
      std::printf(" no finite value");
    else
      std::printf(" [%g, %g]", all.lower, all.upper);
    if (!all.empty() && here.empty())
      std::printf("  no finite value at this step");
    else if (here != all && !here.empty())
      std::printf("  [%g, %g] at this step", here.lower, here.upper);
    if (array.component == "magnitude") std::printf("  magnitude of %d components", array.components);
    if (array.association == Association::cell_averaged) std::printf("  averaged from cells");
    if (array.cells && array.cells->lower <= array.cells->upper)
      std::printf(" of %s [%g, %g]", to_string(array.cells->type), array.cells->lower, array.cells->upper);
    if (array.nan_count > 0) std::printf("  %lld not finite", static_cast<long long>(array.nan_count));
    std::printf("\n");
  }
  for (const std::string& note : notes) std::printf("  note    %s\n", note.c_str());
}

/// A folder of several data sets, not one that is a data set itself.
bool is_listed(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return false;
  try {
    recognise(path);
    return false;
  } catch (const Error& failure) {
    if (failure.code() != ErrorCode::bad_data) throw;
    return true;
  }
}

json::object describe(const std::string& folder, const FolderListing& listing) {
  json::array datasets, passed_over;
  for (const FolderEntry& entry : listing.entries)
    datasets.push_back(json::object{{"name", entry.name},
                                    {"kind", std::string(format_of(entry.kind).name)},
                                    {"bytes", entry.bytes},
                                    {"changed_unix_ms", entry.changed},
                                    {"files", entry.files}});
  for (const PassedOver& passed : listing.passed_over)
    passed_over.push_back(json::object{
        {"reason", passed.reason}, {"files", passed.files}, {"examples", json::array(passed.examples.begin(), passed.examples.end())}});
  return {{"folder", folder}, {"datasets", std::move(datasets)}, {"passed_over", std::move(passed_over)}, {"cut_off", listing.cut_off}};
}

std::string byte_text(std::uint64_t bytes) {
  const char* const units[] = {"B", "kB", "MB", "GB", "TB"};
  double value = static_cast<double>(bytes);
  std::size_t unit = 0;
  for (; value >= 1000 && unit + 1 < std::size(units); ++unit) value /= 1000;
  char text[32];
  std::snprintf(text, sizeof text, unit == 0 ? "%.0f %s" : "%.1f %s", value, units[unit]);
  return text;
}

void print_text(const std::string& folder, const FolderListing& listing) {
  std::printf("%s\n", folder.c_str());
  for (const FolderEntry& entry : listing.entries) {
    std::printf("  %-40s %-18s %s", valid_utf8(entry.name).c_str(), std::string(format_of(entry.kind).name).c_str(), byte_text(entry.bytes).c_str());
    if (entry.files > 1) std::printf(", %d files", entry.files);
    std::printf("\n");
  }
  std::int64_t passed_files = 0;
  for (const PassedOver& passed : listing.passed_over) passed_files += passed.files;
  std::printf("  %zu data sets%s, %lld files passed over\n", listing.entries.size(), listing.cut_off ? " and more than are looked at" : "",
              static_cast<long long>(passed_files));
  for (const PassedOver& passed : listing.passed_over) {
    std::printf("    %5lld  %s:", static_cast<long long>(passed.files), passed.reason.c_str());
    for (const std::string& example : passed.examples) std::printf(" %s", valid_utf8(example).c_str());
    std::printf("%s\n", passed.files > static_cast<std::int64_t>(passed.examples.size()) ? " ..." : "");
  }
}

struct InfoArguments {
  std::string file;
  int step = 0;
  bool this_step = false;
  bool as_json = false;
};

}  // namespace

void add_info_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("info", "Says what is in a file: grid, points, cells by type, arrays, time steps; of a folder, what can be opened and what was passed over");
  const auto arguments = std::make_shared<InfoArguments>();
  add_file_option(*command, arguments->file, "A file, a series such as 'plume_*.vtu', a folder, or analytic data such as torus:64");
  add_region_options(*command);
  command->add_option("--step", arguments->step, "The time step to look at, from 0");
  command->add_flag("--this-step", arguments->this_step,
                    "Reads no other step: the arrays' ranges are those of this one, not of all");
  command->add_flag("--json", arguments->as_json, "One JSON document on standard output");
  add_sandbox_option(*command);
  command->callback([arguments] {
    if (is_listed(arguments->file)) {
      const FolderListing listing = list_folder(arguments->file);
      return arguments->as_json ? print_json(describe(arguments->file, listing)) : print_text(arguments->file, listing);
    }
    const auto dataset = open_argument(arguments->file, arguments->step);
    std::vector<std::string> notes = dataset->notes;
    const SeriesRanges ranges = read_ranges(*dataset, arguments->file, !arguments->this_step, notes);
    if (arguments->as_json)
      print_json(describe(*dataset, ranges, notes));
    else
      print_text(*dataset, ranges, notes);
  });
}

}  // namespace isostrata
