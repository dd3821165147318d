// Everything that passes between viewers and the engine: plain data by value and shared immutable bytes, never a shared object,
// so that the engine can move to a process of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/error.h"
#include "data/derived/coarse_error.h"
#include "data/values/statistics.h"
#include "encoding/codec.h"
#include "encoding/encode_image.h"
#include "encoding/encode_still.h"
#include "engine/data/catalogue.h"
#include "engine/data/dataset_facts.h"
#include "engine/messages/exported_mesh.h"
#include "engine/messages/layer_statistics.h"
#include "engine/messages/probe.h"
#include "extraction/files/write_mesh.h"
#include "scene/scene.h"

namespace isostrata {

using SessionKey = std::uint64_t;  // of one scene; never used again
using RequestId = std::uint64_t;   // chosen by the asker, unique in the process
using StreamId = std::uint64_t;    // of video; chosen by the asker, unique in its session, never used again

// ---- to the engine -----------------------------------------------------------------------------------------------------------

/// Loads the dataset and answers DatasetReady or RequestFailed. It does not change the session's scene.
struct OpenRequest {
  SessionKey session = 0;
  RequestId request = 0;
  std::string dataset;  // id of the catalogue
  // The arrays' ranges are those of all steps, for which each step is read once, one after the other and beside all other work.
  // Else they are those of the steps that were read so far.
  bool all_ranges = false;
};

/// The newest scene of a session; replaces the one before. Extraction begins at once.
struct SceneUpdate {
  SessionKey session = 0;
  Scene scene;
};

/// A frame as the next one of a video stream. The stream begins with its first order; that frame, and the first of another size,
/// is a key frame. Every frame of a stream must reach its viewer, in order. Until its encoder is open, pictures by themselves come in place of it: JPEG,
/// without FrameReady::video.
struct VideoOrder {
  Codec codec = Codec::vp9_444;
  StreamId stream = 0;
  int bitrate_kbps = 8000;  // at 30 frames a second: EncodeOrder (encoding/encoder.h)
  bool key = false;         // for somebody who has none of the frames before
  std::optional<int> quantizer;  // of a film, whose frames are lossless ones as far as drawing goes: EncodeOrder. Nothing comes in place of its frames
};

/// One picture of the session's newest scene, taken as late as possible. Every request is answered once: FrameReady or
/// RequestFailed. While intervals are being extracted, a moving frame shows the last ones that are ready; a lossless one waits
/// for the newest.
struct FrameRequest {
  SessionKey session = 0;
  RequestId request = 0;
  int width = 800, height = 600;
  bool lossless = false;
  bool jpeg = true;  // the bytes' format; lossless frames may be asked for as JPEG too (REST)
  int jpeg_quality = 90;
  std::optional<VideoOrder> video;  // a moving frame as video, or a film's; `jpeg` is then not looked at
  std::size_t band_bytes = 0;  // a lossless frame as PNG in pieces of so many bytes; 0: in one
  bool until_newer = false;    // given up, as `cancelled`, once the session has a newer scene: a picture at rest, in the way of a hand that moves again
  std::optional<StillFormat> still;  // a script's picture in this format; `jpeg` and its quality are then not looked at
  std::optional<Annotations> annotations;  // in place of the scene's
  int samples = 1;  // each way, of a lossless frame: a pixel is the mean of samples x samples rays
  bool transparent = false;  // a still without the background, with alpha in its place
  int coarse = 0;  // level of a moving frame of every n-th point (coarse_levels.h), if that is at hand; moved layers are made so for it. 0: all points
};

struct HistogramRequest {
  SessionKey session = 0;
  RequestId request = 0;
  std::string dataset;
  int step = 0;
  std::string array;
  int bins = 256;
  ValueRange least;  // that the bins span at least; else the array's own at that step
  FieldValues values = FieldValues::interpolated;  // whole: of an array that was averaged from cells, those of the cells
};

/// Answered by StatisticsReady or RequestFailed.
struct StatisticsRequest {
  SessionKey session = 0;
  RequestId request = 0;
  std::string dataset;
  int step = 0;
  std::string array;
};

/// Extracts the scene's layers and writes them to a file by the ending of its name (extraction/files/write_mesh.h), one export after
/// the other; the file is complete or not there. Answered by ExportReady or RequestFailed.
struct ExportRequest {
  SessionKey session = 0;
  RequestId request = 0;
  Scene scene;
  std::string path;  // of the server's own choice, never a client's
  WriteOptions options;
};

/// A small picture of what is shown of the dataset first (engine/thumbnail.h), made behind all other work, one after the other. Answered by ThumbnailReady or
/// RequestFailed.
struct ThumbnailRequest {
  SessionKey session = 0;  // of none
  RequestId request = 0;
  std::string dataset;
};

/// What the scene's layers hold, and how sure that is. Answered by LayersMeasured or RequestFailed.
struct MeasureRequest {
  SessionKey session = 0;
  RequestId request = 0;
  Scene scene;
};

// ProbeRequest, answered by ProbeReady, and CurveRequest, answered by CurveReady: probe.h. LayerStatisticsRequest, answered by LayerStatisticsReady: layer_statistics.h.

/// Ends an operation, by the number that OperationProgress gave it or by the request it works for; unknown ones are ignored.
struct CancelRequest {
  SessionKey session = 0;
  std::uint64_t operation = 0;
  RequestId request = 0;
  bool superseded = false;  // what it worked for is not wanted any more; else somebody ends it
};

/// Forgets the frame request if it has not begun (its viewer is gone).
struct ForgetFrame {
  SessionKey session = 0;
  RequestId request = 0;
};

/// Nobody looks at the session any more: if no picture of it is waited for, what is extracted for it is let go, and is extracted again for the next one.
struct RestScene {
  SessionKey session = 0;
};

struct CloseSession {
  SessionKey session = 0;
};

/// Entries that requests may name from now on, under their version_id (catalogue.h): new ones, and ones that have changed. None is forgotten.
struct CatalogueUpdate {
  SessionKey session = 0;  // of none
  std::vector<CatalogueEntry> entries;
};

/// Forgets the stream's encoder. Frames of it that are still being drawn are answered RequestFailed.
struct CloseStream {
  SessionKey session = 0;
  StreamId stream = 0;
};

using EngineRequest = std::variant<OpenRequest, SceneUpdate, FrameRequest, HistogramRequest, CancelRequest, ForgetFrame,
                                   RestScene, CloseSession, StatisticsRequest, ExportRequest, CloseStream, MeasureRequest, CatalogueUpdate, ThumbnailRequest, ProbeRequest, CurveRequest, LayerStatisticsRequest>;

// ---- from the engine ---------------------------------------------------------------------------------------------------------

/// At most ten a second for one operation, and none for what is done within a tenth of a second.
struct OperationProgress {
  SessionKey session = 0;
  std::uint64_t operation = 0;
  std::string stage;
  double fraction = 0;
  RequestId works_for = 0;  // the request; 0: a scene's extraction
};

/// Follows the last OperationProgress of an operation.
struct OperationDone {
  SessionKey session = 0;
  std::uint64_t operation = 0;
  bool cancelled = false;
  RequestId works_for = 0;
  bool superseded = false;  // cancelled by nobody's word: something newer, or a new start of the same, has taken its place
};

struct DatasetReady {
  SessionKey session = 0;
  RequestId request = 0;
  DatasetFacts facts;
};

struct HistogramReady {
  SessionKey session = 0;
  RequestId request = 0;
  std::string dataset;
  int step = 0;
  std::string array;
  double lower = 0, upper = 0;
  std::vector<std::uint64_t> counts;
};

struct StatisticsReady {
  SessionKey session = 0;
  RequestId request = 0;
  std::string dataset;
  int step = 0;
  std::string array;
  Statistics statistics;
};

struct ExportReady {
  SessionKey session = 0;
  RequestId request = 0;
  ExportedMesh mesh;
};

/// The drawing of a requested frame begins: the next one may be asked for.
struct FrameStarted {
  SessionKey session = 0;
  RequestId request = 0;
  std::uint64_t revision = 0;  // of the scene that it shows
};

struct IntervalFacts {
  std::uint32_t id = 0;
  std::int64_t active_cells = 0;
  std::int64_t tetrahedra = 0;
  double volume = 0;                   // of the solid
  std::optional<double> volume_error;  // as volume_errors() has it; nothing if it is not defined, or not asked for
  std::optional<double> area;          // of a flat grid, in place of a volume
};

struct StageTimes {
  double extract_ms = 0, order_ms = 0, draw_ms = 0, readback_ms = 0, encode_ms = 0;
  double total_ms = 0;  // from taking the scene to having the bytes
};

struct VideoFacts {
  Codec codec = Codec::vp9_444;
  StreamId stream = 0;
  bool key = false;
};

struct FrameReady {
  SessionKey session = 0;
  RequestId request = 0;
  std::uint64_t revision = 0;  // the newest revision that the picture contains wholly
  int step = 0;
  bool lossless = false;
  bool jpeg = true;
  std::optional<VideoFacts> video;  // a frame of this stream; else a picture by itself
  int width = 0, height = 0;
  Camera camera;  // that it was drawn with
  StageTimes stages;
  std::string device;
  std::string order;
  bool order_exact = false;
  std::int64_t tetrahedra = 0;
  int samples = 1;       // each way, as they were asked for
  int point_stride = 1;  // more: of every n-th point along each axis: a first picture of a large grid, or a moving frame; one of all points follows
  std::optional<CoarseError> coarse_error;  // of the array that is cut, once it is known: how far its values at those points are from the whole's
  bool coarse_at_hand = false;  // moving frames of every n-th point can be had, as this one is if point_stride says so
  bool layers_may_be_coarse = false;  // so can those of a hand that moves the layers, as soon as it does
  std::vector<IntervalFacts> intervals;
  std::shared_ptr<const Bytes> bytes;                 // null if there are bands
  std::shared_ptr<const std::vector<PngBand>> bands;  // if they were asked for: the whole picture, from the top
};

struct LayersMeasured {
  SessionKey session = 0;
  RequestId request = 0;
  std::uint64_t revision = 0;  // of the scene that was measured
  std::vector<IntervalFacts> intervals;
};

struct ThumbnailReady {
  SessionKey session = 0;
  RequestId request = 0;
  std::shared_ptr<const Bytes> png;
};

/// Answers any request that could not be met. A scene whose extraction failed answers the frame requests that waited for it.
struct RequestFailed {
  SessionKey session = 0;
  RequestId request = 0;  // 0: the scene's extraction
  std::uint64_t revision = 0;
  ErrorCode code = ErrorCode::internal;
  std::string message;
  bool encoder_failed = false;  // the picture was drawn; its video codec failed and will again
};

using EngineEvent = std::variant<OperationProgress, OperationDone, DatasetReady, HistogramReady, FrameStarted, FrameReady,
                                 RequestFailed, StatisticsReady, ExportReady, LayersMeasured, ThumbnailReady, ProbeReady, CurveReady, LayerStatisticsReady>;

/// The session that a request or an event is about.
template <class... Messages>
SessionKey session_of(const std::variant<Messages...>& message) {
  return std::visit([](const auto& of) { return of.session; }, message);
}
/// The number of the request; 0 if it is about none.
template <class... Messages>
RequestId request_of(const std::variant<Messages...>& message) {
  return std::visit(
      [](const auto& of) -> RequestId {
        if constexpr (requires { of.request; })
          return of.request;
        else
          return 0;
      },
      message);
}

}  // namespace isostrata
