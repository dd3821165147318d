// Our types as Protobuf, and the way back where no rule is involved. The other direction, with its rules, is apply_command.h.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engine/data/catalogue.h"
#include "engine/messages/messages.h"
#include "isostrata/v1/isostrata.pb.h"
#include "scene/scene.h"

namespace isostrata {

v1::State to_wire(const Scene& scene);
v1::Interval to_wire(const SceneInterval& interval);
v1::RangeTerm to_wire(const SceneTerm& term);
v1::Camera to_wire(const Camera& camera);
v1::Rgb to_wire(const Rgb& rgb);
v1::DatasetInfo to_wire(const DatasetFacts& facts);
v1::Histogram to_wire(const HistogramReady& histogram);
v1::IntervalFacts to_wire(const IntervalFacts& interval);
v1::LayerFacts to_wire(const LayersMeasured& measured);
/// Without in_reply_to, which is the connection's own.
v1::ProbeResult to_wire(const ProbeReady& probed);
v1::ProbedCurve to_wire(const CurveReady& probed);
v1::LayerStatistics to_wire(const LayerStatisticsReady& measured);
/// Without frame_id and input_seq, which are the connection's own, and without the payload, which viewers share.
v1::Frame to_wire(const FrameReady& frame);

Vec3d vector_of(const v1::Vec3& wire);
Annotations annotations_of(const v1::Annotations& wanted);

v1::Error wire_error(std::string_view code, std::string message, std::string field = {});
v1::Error wire_error(const RequestFailed& failed);

/// in_reply_to: the seq of the client's message that it answers; 0: none.
v1::ServerMessage error_message(v1::Error error, std::uint64_t in_reply_to = 0);
v1::ServerMessage dataset_message(const DatasetFacts& facts);

}  // namespace isostrata
