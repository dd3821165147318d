// The client's verbs, each one message of the protocol.
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <chrono>

#include "isostrata/client.h"

namespace isostrata::client {
namespace {

v1::ClientMessage smear_of(const std::vector<v1::Rgb>& colors) {
  v1::ClientMessage message;
  message.mutable_set_smear()->mutable_smear()->mutable_colors()->Add(colors.begin(), colors.end());
  return message;
}

}  // namespace

void Client::select_array(const std::string& array) {
  v1::ClientMessage message;
  message.mutable_select_arrays()->set_array(array);
  command(std::move(message));
}

void Client::color_by(const std::string& array) {
  v1::ClientMessage message;
  message.mutable_select_arrays()->set_color_by(array);
  command(std::move(message));
}

void Client::texture_by(const std::string& array) {
  v1::ClientMessage message;
  message.mutable_select_arrays()->set_texture(array);
  command(std::move(message));
}

void Client::set_values(v1::FieldValues values) {
  v1::ClientMessage message;
  message.mutable_select_arrays()->set_values(values);
  command(std::move(message));
}

void Client::set_step(int step) {
  v1::ClientMessage message;
  message.mutable_set_time_step()->set_step(step);
  command(std::move(message));
}

void Client::set_time(double time, v1::TimeMode mode) {
  v1::ClientMessage message;
  message.mutable_set_time()->set_time(time);
  message.mutable_set_time()->set_mode(mode);
  command(std::move(message));
}

void Client::set_intervals(const std::vector<v1::Interval>& intervals) {
  v1::ClientMessage message;
  message.mutable_set_intervals()->mutable_intervals()->Add(intervals.begin(), intervals.end());
  command(std::move(message));
}

std::uint32_t Client::add_interval(v1::Interval interval) {
  v1::ClientMessage message;
  auto& intervals = *message.mutable_set_intervals()->mutable_intervals();
  intervals = state().intervals();
  std::uint32_t newest = 0;
  for (const v1::Interval& other : intervals) {
    newest = std::max(newest, other.id());
    if (other.priority() >= interval.priority() && other.priority() < INT32_MAX) interval.set_priority(other.priority() + 1);
  }
  interval.set_id(0);
  *intervals.Add() = std::move(interval);
  command(std::move(message));
  // Ids only grow, and new intervals stand last.
  if (state().intervals().empty() || state().intervals().rbegin()->id() <= newest)
    throw ClientError("not_found", "the new interval has been removed already by somebody else");
  return state().intervals().rbegin()->id();
}

void Client::move_interval(std::uint32_t id, double lower, double upper) {
  v1::PatchInterval patch;
  patch.set_id(id);
  patch.set_lower(lower);
  patch.set_upper(upper);
  patch_interval(patch);
}

void Client::patch_interval(const v1::PatchInterval& patch) {
  v1::ClientMessage message;
  *message.mutable_patch_interval() = patch;
  command(std::move(message));
}

void Client::remove_interval(std::uint32_t id) {
  v1::ClientMessage message;
  message.mutable_remove_interval()->set_id(id);
  command(std::move(message));
}

const v1::Interval& Client::interval_of(std::uint32_t id) const {
  for (const v1::Interval& interval : state().intervals())
    if (interval.id() == id) return interval;
  throw ClientError("not_found", "interval " + std::to_string(id) + " is not in this session", "id");
}

void Client::reorder_priorities(const std::vector<std::uint32_t>& ids) {
  v1::ClientMessage message;
  message.mutable_reorder_priorities()->mutable_ids()->Add(ids.begin(), ids.end());
  command(std::move(message));
}

void Client::set_combination(const std::vector<v1::RangeTerm>& terms) {
  v1::ClientMessage message;
  message.mutable_set_combination()->mutable_terms()->Add(terms.begin(), terms.end());
  command(std::move(message));
}

void Client::set_transfer_function(const std::vector<v1::TransferPoint>& points) {
  v1::ClientMessage message;
  message.mutable_set_transfer_function()->mutable_points()->Add(points.begin(), points.end());
  command(std::move(message));
}

void Client::set_transfer_function(std::uint32_t id, const std::vector<v1::TransferPoint>& points) {
  v1::PatchInterval patch;
  patch.set_id(id);
  patch.mutable_transfer_function()->mutable_points()->Add(points.begin(), points.end());
  patch_interval(patch);
}

void Client::set_mode(v1::RenderMode mode) {
  v1::ClientMessage message;
  message.mutable_set_appearance()->set_mode(mode);
  command(std::move(message));
}

void Client::set_background(const v1::Rgb& color) {
  v1::ClientMessage message;
  *message.mutable_set_appearance()->mutable_background() = color;
  command(std::move(message));
}

void Client::set_unit_distance(double world) {
  v1::ClientMessage message;
  message.mutable_set_appearance()->set_unit_distance(world);
  command(std::move(message));
}

void Client::set_light(double occlusion, double depth_fade) {
  v1::ClientMessage message;
  message.mutable_set_appearance()->set_occlusion(occlusion);
  message.mutable_set_appearance()->set_depth_fade(depth_fade);
  command(std::move(message));
}

void Client::set_axis_scale(const v1::Vec3& scale) {
  v1::ClientMessage message;
  *message.mutable_set_appearance()->mutable_axis_scale() = scale;
  command(std::move(message));
}

void Client::set_body_shading(double strength) {
  v1::ClientMessage message;
  message.mutable_set_appearance()->set_body_shading(strength);
  command(std::move(message));
}

void Client::set_color_range(const v1::ColorRange& range) {
  v1::ClientMessage message;
  *message.mutable_set_appearance()->mutable_color_range() = range;
  command(std::move(message));
}

void Client::set_cycle(const v1::SetCycle& cycle) {
  v1::ClientMessage message;
  *message.mutable_set_cycle() = cycle;
  command(std::move(message));
}

void Client::set_smear(const std::vector<int>& steps, const std::vector<v1::Rgb>& colors) {
  v1::ClientMessage message = smear_of(colors);
  message.mutable_set_smear()->mutable_smear()->mutable_steps()->Add(steps.begin(), steps.end());
  command(std::move(message));
}

void Client::set_smear_times(const std::vector<double>& times, const std::vector<v1::Rgb>& colors) {
  v1::ClientMessage message = smear_of(colors);
  message.mutable_set_smear()->mutable_smear()->mutable_times()->Add(times.begin(), times.end());
  command(std::move(message));
}

void Client::set_clip_planes(const std::vector<v1::ClipPlane>& planes) {
  v1::ClientMessage message;
  message.mutable_set_clip_planes()->mutable_clip_planes()->Add(planes.begin(), planes.end());
  command(std::move(message));
}

void Client::set_annotations(bool axes, bool box, bool legend) {
  v1::ClientMessage message;
  v1::Annotations& annotations = *message.mutable_set_annotations()->mutable_annotations();
  annotations.set_axes(axes);
  annotations.set_box(box);
  annotations.set_legend(legend);
  command(std::move(message));
}

void Client::set_camera(const v1::Camera& camera) {
  v1::ClientMessage message;
  *message.mutable_set_camera()->mutable_camera() = camera;
  command(std::move(message));
}

void Client::set_view(const std::string& view) {
  v1::ClientMessage message;
  message.mutable_set_view()->set_view(view);
  command(std::move(message));
}

void Client::set_viewport(int width, int height, bool hidden) {
  v1::ClientMessage message;
  v1::Viewport& viewport = *message.mutable_viewport();
  viewport.set_width(static_cast<std::uint32_t>(std::max(width, 0)));
  viewport.set_height(static_cast<std::uint32_t>(std::max(height, 0)));
  viewport.set_hidden(hidden);
  command(std::move(message));
}

void Client::set_interaction(bool active) {
  v1::ClientMessage message;
  message.mutable_interaction()->set_active(active);
  send(std::move(message));
}

std::optional<v1::Frame> Client::next_frame(std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left = deadline - std::chrono::steady_clock::now();
    auto message = receive(std::max(std::chrono::milliseconds(0), std::chrono::ceil<std::chrono::milliseconds>(left)));
    if (!message) return std::nullopt;
    if (message->has_error()) throw ClientError(message->error().code(), message->error().message(), message->error().field());
    if (message->has_frame()) return std::move(*message->mutable_frame());
  }
}

std::optional<ShownFrame> Client::next_picture(FrameDecoder& decoder, std::chrono::milliseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    const auto left = deadline - std::chrono::steady_clock::now();
    auto frame = next_frame(std::max(std::chrono::milliseconds(0), std::chrono::ceil<std::chrono::milliseconds>(left)));
    if (!frame) return std::nullopt;
    if (auto picture = decode_frame(decoder, *frame)) {
      frame->clear_payload();
      return ShownFrame{std::move(*frame), std::move(*picture)};
    }
  }
}

std::optional<Picture> Client::decode_frame(FrameDecoder& decoder, const v1::Frame& frame) {
  std::optional<Picture> picture;
  const auto begun = std::chrono::steady_clock::now();
  try {
    picture = decoder.decode(frame);
    if (frame.phase() == v1::FRAME_PHASE_MOVING)
      note_decoded(frame.frame_id(), std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count());
  } catch (const ClientError&) {
    if (!decoder.needs_stream()) throw;
  }
  if (decoder.needs_stream()) {
    v1::ClientMessage failed;
    failed.mutable_decoder_failed()->set_stream_id(frame.stream_id());
    failed.mutable_decoder_failed()->set_again(true);
    send(std::move(failed));
  }
  return picture;
}

std::string Client::save_state() const {
  google::protobuf::util::JsonPrintOptions print;
  print.always_print_primitive_fields = true;
  print.add_whitespace = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(state(), &text, print).ok())
    throw ClientError("protocol", "the state cannot be written as JSON");
  return text;
}

void Client::cancel(std::uint64_t operation) {
  v1::ClientMessage message;
  message.mutable_cancel()->set_operation(operation);
  send(std::move(message));
}

}  // namespace isostrata::client
