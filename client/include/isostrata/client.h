// A thin client of an Isostrata server: connect, change what is shown, receive state and frames. Messages are those of the
// protocol (isostrata/v1/isostrata.pb.h, whose comments say what each field means); isostrata/scene.h writes the longer ones in
// one expression. Nothing of the server is needed.
//
//   isostrata::client::Client client({.url = "http://127.0.0.1:8080/?token=..."});
//   client.open_dataset("torus:64");
//   client.set_intervals({isostrata::client::interval(0.1, 0.2, {.color = "#ff8000"})});
//   const auto frame = client.lossless_frame();             // PNG bytes in frame.payload()
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "isostrata/frames.h"
#include "isostrata/image.h"
#include "isostrata/options.h"
#include "isostrata/rest.h"
#include "isostrata/scene.h"

namespace isostrata::client {

/// A frame and its pixels.
struct ShownFrame {
  v1::Frame frame;
  Picture picture;
};

/// One connection to one session, which others may look at and change too: state() follows them while something here waits for
/// the server. Commands return when the server has done them and state() shows it; they throw ClientError with the server's code
/// where it refused, and then nothing has changed. Not thread-safe: everything happens on the caller's thread, inside the calls.
///
/// A connection that is lost is made again inside the next call, to the same session, for Options.reconnect_for: what a call
/// waits for it goes on to wait for, commands are done once, and the numbers that send() gives and frames name go on. What cannot
/// be had after that is a ClientError: "closed", "session_lost", "interrupted".
class Client {
 public:
  /// Connects, says Hello and waits for Welcome. Throws ClientError.
  explicit Client(const Options& options);
  ~Client();
  Client(Client&&) noexcept;
  Client& operator=(Client&&) noexcept;

  // ---- what the server has told ----------------------------------------------------------------------------------------------

  /// Its datasets are kept current: files that came later are among them.
  const v1::Welcome& welcome() const;
  /// The newest that has been received.
  const v1::State& state() const;
  /// Of state().dataset(); empty if none is open.
  const v1::DatasetInfo& dataset() const;

  // ---- data: what is open, its arrays, its time
  // --------------------------------------------------------------------------------

  /// By id or by name. Waits until it is open. Of a structured grid a part can be opened, which is a dataset of its own: its points
  /// region, "FIRST:LAST,FIRST:LAST,FIRST:LAST", of which every stride-th, "N" or "NX,NY,NZ", is taken.
  void open_dataset(const std::string& dataset, const std::string& region = "", const std::string& stride = "");
  /// The array that intervals are cut from; they keep their place in its range.
  void select_array(const std::string& array);
  /// The array that colour maps and ramps run over.
  void color_by(const std::string& array);
  /// The array that surfaces' textures run over.
  void texture_by(const std::string& array);
  /// Whether values of the array are interpolated, or whole: FieldValues in the protocol.
  void set_values(v1::FieldValues values);
  void set_step(int step);
  /// A time between the first step's and the last one's, and what it means between two steps.
  void set_time(double time, v1::TimeMode mode = v1::TIME_MODE_UNSPECIFIED);
  /// Of the finite values of the array at the state's step. bins: 1..4096.
  v1::Histogram histogram(const std::string& array, int bins = 256);

  // ---- the layers
  // --------------------------------------------------------------------------------------------------------------

  /// Replaces all. Those with an id that exists keep it, those without one get a new one.
  void set_intervals(const std::vector<v1::Interval>& intervals);
  /// Adds one above all others; its id.
  std::uint32_t add_interval(v1::Interval interval);
  void move_interval(std::uint32_t id, double lower, double upper);
  /// Changes the fields that are present.
  void patch_interval(const v1::PatchInterval& patch);
  void remove_interval(std::uint32_t id);
  /// The interval of this id. Throws ClientError "not_found".
  const v1::Interval& interval_of(std::uint32_t id) const;
  /// All ids, the highest priority first.
  void reorder_priorities(const std::vector<std::uint32_t>& ids);
  /// Ranges of other arrays, combined with the intervals from left to right; none: the intervals alone.
  void set_combination(const std::vector<v1::RangeTerm>& terms);
  /// Replaces all intervals by one that looks as the points say, from the first one's value to the last one's.
  void set_transfer_function(const std::vector<v1::TransferPoint>& points);
  /// The same for one interval, whose ends become those of the points; none: it looks as it did without.
  void set_transfer_function(std::uint32_t id, const std::vector<v1::TransferPoint>& points);
  /// What each interval holds (cells, tetrahedra, the solid's volume) and how far that is from the interpolated field's.
  v1::LayerFacts layer_facts();
  /// What lies at a place of the newest state's picture, from (0, 0), its upper left corner, to (1, 1): position, layer, cell and the values of all arrays.
  /// width, height: the picture's, since how far the camera sees to the sides depends on them.
  v1::ProbeResult probe(double x, double y, int width = 800, int height = 600);
  /// One layer in numbers, by its id: volume, centroid, pieces, and the mean, deviation and extremes of an array (none: the session's) in it.
  v1::LayerStatistics layer_statistics(std::uint32_t interval, const std::string& array = "");
  /// The values of an array (none: the session's) along a line between two points in the dataset's space, at the newest state's step or time.
  v1::ProbedCurve probe_line(const std::array<double, 3>& from, const std::array<double, 3>& to, const std::string& array = "");
  /// At a point over all steps, each of which is read.
  v1::ProbedCurve probe_steps(const std::array<double, 3>& at, const std::string& array = "");

  // ---- how it looks
  // ------------------------------------------------------------------------------------------------------------

  void set_mode(v1::RenderMode mode);
  void set_background(const v1::Rgb& color);
  /// The thickness that opacities are meant for, in world units; 0: the default.
  void set_unit_distance(double world);
  /// What the picture's depth adds to its light, each in [0, 1]: how dark hollows are, how far what is far away fades.
  void set_light(double occlusion, double depth_fade);
  /// How far the layers' interiors are shaded along the gradient of the array, in [0, 1].
  void set_body_shading(double strength);
  /// How many times as long each axis is drawn: vertical exaggeration. The camera goes along.
  void set_axis_scale(const v1::Vec3& scale);
  /// The values that colour maps begin and end at, and whether colours run with the logarithm.
  void set_color_range(const v1::ColorRange& range);
  /// Of v1::RENDER_MODE_CYCLED; changes what is present.
  void set_cycle(const v1::SetCycle& cycle);
  /// Of v1::RENDER_MODE_SMEAR: the steps in the order they are painted, and their colours.
  void set_smear(const std::vector<int>& steps, const std::vector<v1::Rgb>& colors = {});
  void set_smear_times(const std::vector<double>& times, const std::vector<v1::Rgb>& colors = {});
  /// What is kept by all of them is shown; none: nothing is cut away.
  void set_clip_planes(const std::vector<v1::ClipPlane>& planes);
  void set_annotations(bool axes, bool box, bool legend);
  void set_camera(const v1::Camera& camera);
  /// "reset": as when the dataset was opened; "+x", "-x", "+y", "-y", "+z" or "-z": the whole dataset from that side, in this
  /// connection's viewport.
  void set_view(const std::string& view);

  // ---- pictures
  // ----------------------------------------------------------------------------------------------------------------

  /// In pixels. Nothing is sent to a hidden viewport or to one of width 0.
  void set_viewport(int width, int height, bool hidden = false);
  /// Between true and false frames are moving ones, lossy and quick, even where they stand still for a moment.
  void set_interaction(bool active);
  /// The next frame, or nothing after the timeout. Errors that the server reports meanwhile are thrown.
  std::optional<v1::Frame> next_frame(std::chrono::milliseconds timeout);
  /// The next frame as pixels, or nothing after the timeout. The frame's payload has been taken. Streams of video whose beginning
  /// was missed, and whose decoder fails, are begun anew.
  std::optional<ShownFrame> next_picture(FrameDecoder& decoder, std::chrono::milliseconds timeout);
  /// The same for a frame that receive() or next_frame() gave; nothing if it completes no picture.
  std::optional<Picture> decode_frame(FrameDecoder& decoder, const v1::Frame& frame);
  /// The next lossless frame (PNG) of at least the newest revision known here, in the viewport's size. Not with
  /// Options.lossless_bands.
  v1::Frame lossless_frame();
  /// A picture of any size as a file's bytes; format "png", "jpeg" and what else the server knows. The viewport is as it was.
  std::string still(int width, int height, const std::string& format = "png");

  /// The layers as a mesh file, written as it comes: "vtu" (tetrahedra), "ply" or "stl" (their boundary, or the named parts of
  /// it: "lower", "upper", "domain"). The server's progress is told; a stop takes its work with it.
  void export_mesh(std::ostream& to, const std::string& format, const std::vector<std::string>& facets = {});

  // ---- the whole state, as one JSON document
  // ------------------------------------------------------------------------------------

  /// The State in Protobuf's canonical JSON: what REST's state, the page's saved file and restore() take.
  std::string save_state() const;
  /// Opens its dataset and shows what it says.
  void restore_state(const std::string& json);

  // ---- operations
  // --------------------------------------------------------------------------------------------------------------

  /// Asks the server to give up the operation that a Progress named. Does not wait.
  void cancel(std::uint64_t operation);

  // ---- the wire
  // ----------------------------------------------------------------------------------------------------------------

  /// Sends a message; its seq is filled in and returned. Does not wait for an answer, but while more than 1 MiB waits to be written,
  /// for Options.timeout at most (ClientError "timeout").
  std::uint64_t send(v1::ClientMessage message);
  /// The next message of the server, or nothing after the timeout. Frames have been acknowledged. Throws ClientError "closed".
  std::optional<v1::ServerMessage> receive(std::chrono::milliseconds timeout);
  /// Sends and waits until the server has surely done it or refused it.
  void command(v1::ClientMessage message);
  /// Ends the connection; the session lives on for a while. So does the destructor.
  void close();

 private:
  void note_decoded(std::uint64_t frame, double ms);

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace isostrata::client
