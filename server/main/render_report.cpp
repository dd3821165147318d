#include "main/render_report.h"

#include <cstddef>
#include <cstdio>
#include <string>
#include <utility>

#include "main/json_number.h"

namespace isostrata {
namespace {

boost::json::array intervals_json(const RenderReport& report) {
  boost::json::array intervals;
  for (std::size_t i = 0; i < report.input.styles.size(); ++i) {
    const IntervalSummary& summary = report.extracted.summaries()[i];
    const IntervalStyle& style = report.input.styles[i];
    const bool part = i < report.scene.intervals.size() && report.scene.intervals[i].whole;  // of a logarithm: all as one
    if (part && i > 0 && report.scene.intervals[i].id == report.scene.intervals[i - 1].id) {
      boost::json::object& before = intervals.back().as_object();
      before["upper"] = summary.interval.upper;
      before["tetrahedra"] = before["tetrahedra"].as_int64() + summary.tetrahedra;
      if (style.opacity_upper) before["opacity_upper"] = *style.opacity_upper;
      continue;
    }
    const std::string& map = part ? report.scene.intervals[i].color_map : style.color_map;
    intervals.push_back(boost::json::object{
        {"lower", json_number(summary.interval.lower)},
        {"upper", json_number(summary.interval.upper)},
        {"tetrahedra", summary.tetrahedra},
        {"color", map.empty() ? format_rgb(style.color) : "map:" + map},
        {"opacity", style.opacity},
        {"priority", style.priority},
    });
    boost::json::object& about = intervals.back().as_object();
    if (style.opacity_upper) about["opacity_upper"] = *style.opacity_upper;
    if (style.surface.drawn()) {
      boost::json::array ends;
      for (const auto& [drawn, name] : {std::pair{style.surface.lower, "lower"}, std::pair{style.surface.upper, "upper"},
                                        std::pair{style.surface.domain, "domain"}})
        if (drawn) ends.push_back(name);
      about["surface"] = std::move(ends);
    }
  }
  return intervals;
}

}  // namespace

boost::json::object to_json(const RenderReport& report) {
  const auto vector = [](Vec3d v) { return boost::json::array{v.x, v.y, v.z}; };
  boost::json::object stages;  // of the last picture
  for (const StageTime& stage : report.facts.stages) stages[stage.name] = stage.ms;
  return {{"out", report.out},
          {"array", report.extracted.array},
          {"step", report.scene.step},
          {"size", boost::json::array{report.input.width, report.input.height}},
          {"renderer", report.facts.renderer},
          {"device", report.facts.device},
          {"order", report.facts.order},
          {"order_exact", report.facts.order_exact},
          {"tetrahedra", report.facts.tetrahedra},
          {"stages_ms", std::move(stages)},
          {"intervals", intervals_json(report)},
          {"camera", boost::json::object{{"eye", vector(report.input.camera.eye)},
                                         {"at", vector(report.input.camera.at)},
                                         {"up", vector(report.input.camera.up)},
                                         {"fov", report.input.camera.fov_deg}}},
          {"ms", boost::json::object{{"load", report.ms.load},
                                     {"extract", report.ms.extract},
                                     {"device", report.ms.device},
                                     {"order", report.facts.order_ms},
                                     {"draw", report.facts.draw_ms},
                                     {"readback", report.facts.readback_ms},
                                     {"write", report.ms.write},
                                     {"total", report.ms.total}}}};
}

void print_text(const RenderReport& report) {
  std::printf("%s: %dx%d, %lld tetrahedra, order: %s\n", report.out.c_str(), report.input.width, report.input.height, static_cast<long long>(report.facts.tetrahedra), report.facts.order.c_str());
  std::printf("drawn by %s\n", report.facts.device.c_str());
  std::printf("load %.1f ms, extract %.1f ms, device %.1f ms, order %.1f ms, draw %.1f ms, readback %.1f ms, write %.1f ms\n",
              report.ms.load, report.ms.extract, report.ms.device, report.facts.order_ms, report.facts.draw_ms, report.facts.readback_ms, report.ms.write);
}

}  // namespace isostrata
