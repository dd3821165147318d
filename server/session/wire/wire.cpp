#include "session/wire/wire.h"

#include "base/utf8.h"

namespace isostrata {
namespace {

v1::Vec3 to_wire(const Vec3d& v) {
  v1::Vec3 out;
  out.set_x(v.x);
  out.set_y(v.y);
  out.set_z(v.z);
  return out;
}

}  // namespace

v1::Rgb to_wire(const Rgb& rgb) {
  v1::Rgb out;
  out.set_r(rgb[0]);
  out.set_g(rgb[1]);
  out.set_b(rgb[2]);
  return out;
}

v1::Camera to_wire(const Camera& camera) {
  v1::Camera out;
  *out.mutable_eye() = to_wire(camera.eye);
  *out.mutable_at() = to_wire(camera.at);
  *out.mutable_up() = to_wire(camera.up);
  out.set_fov_deg(camera.fov_deg);
  out.set_orthographic(camera.orthographic);
  return out;
}

v1::Surface to_wire(const SurfaceStyle& surface) {
  v1::Surface out;
  out.set_lower(surface.lower);
  out.set_upper(surface.upper);
  out.set_domain(surface.domain);
  if (surface.own_color) *out.mutable_color() = to_wire(surface.color);
  out.set_opacity(surface.opacity);
  out.set_ambient(surface.ambient);
  out.set_diffuse(surface.diffuse);
  out.set_specular(surface.specular);
  out.set_shininess(surface.shininess);
  out.set_silhouette(surface.silhouette);
  out.set_texture(surface.texture);
  out.set_texture_repeat(surface.texture_repeat);
  return out;
}

v1::TransferPoint to_wire(const TransferPoint& point) {
  v1::TransferPoint out;
  out.set_value(point.value);
  *out.mutable_color() = to_wire(point.color);
  out.set_opacity(point.opacity);
  return out;
}

v1::Interval to_wire(const SceneInterval& interval) {
  v1::Interval out;
  out.set_id(interval.id);
  out.set_lower(interval.lower);
  out.set_upper(interval.upper);
  *out.mutable_color() = to_wire(interval.color);
  out.set_color_map(interval.color_map);
  out.set_opacity(interval.opacity);
  out.set_priority(interval.priority);
  out.set_visible(interval.visible);
  out.set_name(interval.name);
  out.set_number(interval.number);
  if (interval.opacity_upper) out.set_opacity_upper(*interval.opacity_upper);
  out.set_own_range(interval.own_range);
  if (interval.surface != SurfaceStyle{}) *out.mutable_surface() = to_wire(interval.surface);
  for (const TransferPoint& point : interval.transfer) *out.mutable_transfer_function()->add_points() = to_wire(point);
  return out;
}

v1::RangeTerm to_wire(const SceneTerm& term) {
  v1::RangeTerm out;
  switch (term.term.op) {
    case RangeOperator::intersect:
      out.set_op(v1::RANGE_OPERATOR_INTERSECT);
      break;
    case RangeOperator::unite:
      out.set_op(v1::RANGE_OPERATOR_UNITE);
      break;
    case RangeOperator::subtract:
      out.set_op(v1::RANGE_OPERATOR_SUBTRACT);
      break;
    case RangeOperator::exclusive_or:
      out.set_op(v1::RANGE_OPERATOR_EXCLUSIVE_OR);
      break;
  }
  out.set_array(term.term.array);
  out.set_lower(term.term.range.lower);
  out.set_upper(term.term.range.upper);
  if (term.color) *out.mutable_color() = to_wire(*term.color);
  out.set_color_map(term.color_map);
  if (term.opacity) out.set_opacity(*term.opacity);
  if (term.priority) out.set_priority(*term.priority);
  out.set_hidden(!term.visible);
  return out;
}

v1::ClipPlane to_wire(const ClipPlane& plane) {
  v1::ClipPlane out;
  *out.mutable_normal() = to_wire(plane.normal);
  out.set_offset(plane.offset);
  return out;
}

v1::ColorRange to_wire(const ColorRange& range) {
  v1::ColorRange out;
  out.set_span(range.span == ColorSpan::own         ? v1::COLOR_SPAN_OWN
               : range.span == ColorSpan::all_steps ? v1::COLOR_SPAN_ALL_STEPS
                                                    : v1::COLOR_SPAN_STEP);
  if (range.span == ColorSpan::own) {
    out.set_lower(range.lower);
    out.set_upper(range.upper);
  }
  out.set_log(range.log);
  return out;
}

v1::State to_wire(const Scene& scene) {
  v1::State out;
  out.set_revision(scene.revision);
  out.set_dataset(scene.dataset);
  out.set_step(scene.step);
  out.set_array(scene.array);
  out.set_color_by(scene.color_by);
  for (const SceneInterval& interval : scene.intervals) *out.add_intervals() = to_wire(interval);
  out.set_mode(scene.mode == SceneMode::prioritized ? v1::RENDER_MODE_PRIORITIZED
               : scene.mode == SceneMode::cycled    ? v1::RENDER_MODE_CYCLED
               : scene.mode == SceneMode::smear     ? v1::RENDER_MODE_SMEAR
                                                    : v1::RENDER_MODE_SORTED);
  out.set_texture(scene.texture);
  out.mutable_cycle()->set_seconds(scene.cycle.seconds);
  out.mutable_cycle()->set_phase(scene.cycle.phase);
  out.mutable_cycle()->set_playing(scene.cycle.playing);
  for (const int step : scene.smear.steps) out.mutable_smear()->add_steps(step);
  for (const double time : scene.smear.times) out.mutable_smear()->add_times(time);
  for (const Rgb& color : scene.smear.colors) *out.mutable_smear()->add_colors() = to_wire(color);
  if (scene.camera) *out.mutable_camera() = to_wire(*scene.camera);
  *out.mutable_background() = to_wire(scene.background);
  out.set_unit_distance(scene.unit_distance);
  for (const ClipPlane& plane : scene.clip_planes) *out.add_clip_planes() = to_wire(plane);
  out.mutable_annotations()->set_axes(scene.annotations.axes);
  out.mutable_annotations()->set_box(scene.annotations.box);
  out.mutable_annotations()->set_legend(scene.annotations.legend);
  *out.mutable_color_range() = to_wire(scene.color_range);
  out.set_occlusion(scene.light.occlusion);
  out.set_depth_fade(scene.light.fade);
  out.set_body_shading(scene.body_shading);
  *out.mutable_axis_scale() = to_wire(scene.axis_scale);
  for (const SceneTerm& term : scene.terms) *out.add_terms() = to_wire(term);
  if (scene.time) out.set_time(*scene.time);
  out.set_values(scene.values == FieldValues::whole ? v1::FIELD_VALUES_WHOLE : v1::FIELD_VALUES_INTERPOLATED);
  out.set_time_mode(scene.time_mode == TimeMode::interpolate ? v1::TIME_MODE_INTERPOLATE
                    : scene.time_mode == TimeMode::spacetime ? v1::TIME_MODE_SPACETIME
                                                             : v1::TIME_MODE_STEP);
  return out;
}

v1::DatasetInfo to_wire(const DatasetFacts& facts) {
  v1::DatasetInfo out;
  out.set_id(facts.id);
  out.set_name(facts.name);
  out.set_grid(facts.grid);
  out.set_points(facts.points);
  out.set_cells(facts.cells);
  for (const auto& [type, count] : facts.cell_types) (*out.mutable_cell_types())[type] = count;
  if (!facts.bounds.empty()) {
    *out.mutable_lower() = to_wire(facts.bounds.lower);
    *out.mutable_upper() = to_wire(facts.bounds.upper);
  }
  for (const Axis& axis : facts.axes) {
    v1::AxisInfo* info = out.add_axes();
    info->set_name(axis.name);
    info->set_unit(axis.unit);
    info->set_downward(axis.downward);
  }
  for (const ArrayFacts& array : facts.arrays) {
    v1::ArrayInfo* info = out.add_arrays();
    info->set_name(array.name);
    info->set_association(array.association);
    info->set_type(array.type);
    info->set_components(array.components);
    info->set_lower(array.lower);
    info->set_upper(array.upper);
    info->set_nan_count(array.nan_count);
    info->set_unit(array.unit);
    if (array.cells) {
      info->set_cell_lower(array.cells->lower);
      info->set_cell_upper(array.cells->upper);
    }
    for (const ValueRange& range : array.steps) {
      info->add_step_lower(range.lower);
      info->add_step_upper(range.upper);
    }
  }
  for (const double time : facts.times) out.add_times(time);
  out.set_missing_range_steps(facts.missing_steps);
  if (facts.first_view.array.empty()) out.set_nothing_to_show(facts.first_view.array_reason);
  for (const std::string& note : facts.notes) out.add_notes(note);
  out.set_on_disk(facts.on_disk == OnDisk::changed ? v1::ON_DISK_CHANGED : facts.on_disk == OnDisk::gone ? v1::ON_DISK_GONE : v1::ON_DISK_UNSPECIFIED);
  return out;
}

v1::Histogram to_wire(const HistogramReady& histogram) {
  v1::Histogram out;
  out.set_dataset(histogram.dataset);
  out.set_step(histogram.step);
  out.set_array(histogram.array);
  out.set_lower(histogram.lower);
  out.set_upper(histogram.upper);
  for (const std::uint64_t count : histogram.counts) out.add_counts(count);
  return out;
}

v1::IntervalFacts to_wire(const IntervalFacts& interval) {
  v1::IntervalFacts out;
  out.set_id(interval.id);
  out.set_active_cells(interval.active_cells);
  out.set_tetrahedra(interval.tetrahedra);
  out.set_volume(interval.volume);
  if (interval.volume_error) out.set_volume_error(*interval.volume_error);
  if (interval.area) out.set_area(*interval.area);
  return out;
}

v1::Frame to_wire(const FrameReady& frame) {
  v1::Frame out;
  out.set_revision(frame.revision);
  out.set_step(frame.step);
  out.set_phase(frame.lossless ? v1::FRAME_PHASE_LOSSLESS : v1::FRAME_PHASE_MOVING);
  out.set_format(frame.jpeg ? "jpeg" : "png");
  if (frame.video) {
    out.set_format(std::string(name_of(frame.video->codec)));
    out.set_stream_id(frame.video->stream);
    out.set_key(frame.video->key);
    if (frame.video->key) out.set_decoder(decoder_string(frame.video->codec, frame.width, frame.height, 30));
  }
  out.set_width(static_cast<std::uint32_t>(frame.width));
  out.set_height(static_cast<std::uint32_t>(frame.height));
  v1::StageTimes& stages = *out.mutable_stages();
  stages.set_extract_ms(frame.stages.extract_ms);
  stages.set_order_ms(frame.stages.order_ms);
  stages.set_draw_ms(frame.stages.draw_ms);
  stages.set_readback_ms(frame.stages.readback_ms);
  stages.set_encode_ms(frame.stages.encode_ms);
  stages.set_total_ms(frame.stages.total_ms);
  v1::FrameFacts& facts = *out.mutable_facts();
  facts.set_device(valid_utf8(frame.device));
  facts.set_order(frame.order);
  facts.set_order_exact(frame.order_exact);
  facts.set_tetrahedra(frame.tetrahedra);
  facts.set_point_stride(static_cast<std::uint32_t>(frame.point_stride));
  if (frame.coarse_error) {
    facts.mutable_coarse_error()->set_largest(frame.coarse_error->largest);
    facts.mutable_coarse_error()->set_mean(frame.coarse_error->mean);
  }
  facts.set_samples(static_cast<std::uint32_t>(frame.samples));
  for (const IntervalFacts& interval : frame.intervals) *facts.add_intervals() = to_wire(interval);
  *out.mutable_camera() = to_wire(frame.camera);
  return out;
}

v1::LayerFacts to_wire(const LayersMeasured& measured) {
  v1::LayerFacts out;
  out.set_revision(measured.revision);
  for (const IntervalFacts& interval : measured.intervals) *out.add_intervals() = to_wire(interval);
  return out;
}

Vec3d vector_of(const v1::Vec3& wire) { return {wire.x(), wire.y(), wire.z()}; }

namespace {

v1::ProbeEnd to_wire(ProbeEnd end) {
  switch (end) {
    case ProbeEnd::lower:
      return v1::PROBE_END_LOWER;
    case ProbeEnd::upper:
      return v1::PROBE_END_UPPER;
    case ProbeEnd::domain:
      return v1::PROBE_END_DOMAIN;
    case ProbeEnd::range:
      return v1::PROBE_END_RANGE;
    case ProbeEnd::cut:
      return v1::PROBE_END_CLIP_PLANE;
    case ProbeEnd::eye:
      return v1::PROBE_END_EYE;
  }
  return v1::PROBE_END_UNSPECIFIED;
}

void add_place(v1::ProbeResult& out, const ProbeFacts& facts) {
  if (facts.cell >= 0) out.set_cell(facts.cell);
  if (facts.point >= 0) out.set_point(facts.point);
  if (!facts.structured) return;
  for (const std::int64_t index : facts.cell_index) out.add_cell_index(index);
  for (const std::int64_t index : facts.point_index) out.add_point_index(index);
}

}  // namespace

v1::ProbeResult to_wire(const ProbeReady& probed) {
  const ProbeFacts& facts = probed.facts;
  v1::ProbeResult out;
  out.set_revision(probed.revision);
  out.set_hit(facts.hit);
  out.set_step(facts.step);
  if (facts.time) out.set_time(*facts.time);
  if (!facts.hit) {
    out.set_miss(valid_utf8(facts.miss));
    return out;
  }
  *out.mutable_position() = to_wire(facts.position);
  out.set_distance(facts.distance);
  out.set_interval(facts.interval);
  if (facts.term >= 0) out.set_term(facts.term);
  out.set_end(to_wire(facts.end));
  add_place(out, facts);
  for (const ProbedArray& array : facts.arrays) {
    v1::ProbedArray& to = *out.add_arrays();
    to.set_name(valid_utf8(array.name));
    if (array.value) to.set_value(*array.value);
    if (array.cell_value) to.set_cell_value(*array.cell_value);
  }
  return out;
}

v1::ProbedCurve to_wire(const CurveReady& probed) {
  const CurveFacts& facts = probed.facts;
  v1::ProbedCurve out;
  out.set_revision(probed.revision);
  out.set_array(valid_utf8(facts.array));
  out.mutable_at()->Assign(facts.at.begin(), facts.at.end());
  out.mutable_value()->Assign(facts.values.begin(), facts.values.end());
  out.set_thinned(facts.thinned);
  for (const ProbedStretch& of : facts.layers) {
    v1::ProbedStretch& to = *out.add_layers();
    to.set_from(of.from);
    to.set_to(of.to);
    to.set_interval(of.interval);
    if (of.term >= 0) to.set_term(of.term);
  }
  out.set_step(facts.step);
  if (facts.time) out.set_time(*facts.time);
  out.set_grids_differ(facts.grids_differ);
  return out;
}

v1::LayerStatistics to_wire(const LayerStatisticsReady& measured) {
  const LayerStatistics& of = measured.of;
  v1::LayerStatistics out;
  out.set_revision(measured.revision);
  out.set_interval(measured.interval);
  out.set_array(valid_utf8(of.array));
  out.set_flat(of.flat);
  out.set_volume(of.volume);
  if (of.volume > 0) *out.mutable_centroid() = to_wire(of.centroid);
  out.set_pieces(of.pieces);
  out.set_largest(of.largest);
  out.set_valued(of.valued);
  if (!(of.valued > 0)) return out;
  out.set_lower(of.lower);
  out.set_upper(of.upper);
  out.set_mean(of.mean);
  out.set_standard_deviation(of.standard_deviation);
  return out;
}

Annotations annotations_of(const v1::Annotations& wanted) { return {wanted.axes(), wanted.box(), wanted.legend()}; }

v1::Error wire_error(std::string_view code, std::string message, std::string field) {
  v1::Error error;
  error.set_code(std::string(code));
  error.set_message(valid_utf8(message));  // names of files and words of drivers are any bytes
  error.set_field(valid_utf8(field));
  return error;
}

v1::Error wire_error(const RequestFailed& failed) { return wire_error(to_string(failed.code), failed.message); }

v1::ServerMessage error_message(v1::Error error, std::uint64_t in_reply_to) {
  v1::ServerMessage message;
  error.set_in_reply_to(in_reply_to);
  *message.mutable_error() = std::move(error);
  return message;
}

v1::ServerMessage dataset_message(const DatasetFacts& facts) {
  v1::ServerMessage message;
  *message.mutable_dataset_info() = to_wire(facts);
  return message;
}

}  // namespace isostrata
