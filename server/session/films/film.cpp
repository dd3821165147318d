#include "session/films/film.h"

#include <exception>
#include <string_view>
#include <utility>
#include <variant>

#include "session/wire/wire.h"
#include "webm_writer.h"
#include "whole_file.h"

namespace isostrata {
namespace {

constexpr StreamId kStream = 1;
constexpr int kQuantizer = 20;
constexpr std::int64_t kKeyMs = 2000;  // from one frame that players may jump to, to the next

}  // namespace

Film::Film(EngineDoor& engine, SessionKey session, FilmPlan plan, std::filesystem::path file, Ports ports)
    : engine_(engine), session_(session), plan_(std::move(plan)), path_(std::move(file)), ports_(std::move(ports)) {}

Film::~Film() = default;

void Film::begin() { ask(); }

// The scene, and a frame that waits until it is extracted.
void Film::ask() {
  engine_.post(SceneUpdate{session_, plan_.scene_of(picture_)});
  FrameRequest request{session_, 0, plan_.width, plan_.height, true};
  request.samples = plan_.samples;
  request.annotations = plan_.annotations;
  const std::int64_t begins = plan_.begins_ms(picture_);
  const bool key = picture_ == 0 || begins - key_ms_ >= kKeyMs;
  if (key) key_ms_ = begins;
  request.video = VideoOrder{.codec = Codec::vp9_444, .stream = kStream, .key = key, .quantizer = kQuantizer};
  request_ = engine_.ask(std::move(request), [self = shared_from_this()](const EngineEvent& event, TimePoint) { self->take(event); });
}

void Film::take(const EngineEvent& event) {
  if (const auto* failed = std::get_if<RequestFailed>(&event)) return end(wire_error(*failed));
  const auto* frame = std::get_if<FrameReady>(&event);
  if (!frame) return;
  request_ = 0;
  try {
    write(*frame);
    if (picture_ < plan_.pictures) {
      ports_.progress(static_cast<double>(picture_) / plan_.pictures);
      if (!ended_) ask();
      return;
    }
    writer_->finish(plan_.begins_ms(plan_.pictures));
    const std::uint64_t bytes = file_->size();
    file_->finish();
    end(std::nullopt, bytes);
  } catch (const Error& error) {
    end(wire_error(to_string(error.code()), error.what()));
  } catch (const std::exception&) {  // its text has the file's place on the server
    end(wire_error("unavailable", "the film's file could not be written: the server's temporary folder may be full"));
  }
}

void Film::write(const FrameReady& frame) {
  if (!frame.video || !frame.bytes) throw Error(ErrorCode::internal, "a picture of the film came without video");
  if (!file_) {
    file_ = std::make_unique<client::WholeFile>(path_.string());
    writer_ = std::make_unique<client::WebmWriter>(*file_, plan_.width, plan_.height, plan_.pictures / plan_.seconds, client::Matrix::bt601);
  }
  const Bytes& bytes = *frame.bytes;
  writer_->add({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, plan_.begins_ms(picture_), frame.video->key);
  if (file_->size() > kMaxBytes)
    throw Error(ErrorCode::too_large, "the film has grown beyond " + std::to_string(kMaxBytes >> 20) + " MB at picture " + std::to_string(picture_ + 1) +
                                          " of " + std::to_string(plan_.pictures) + "; make it smaller or shorter");
  ++picture_;
}

void Film::end(std::optional<v1::Error> error, std::uint64_t bytes) {
  const auto self = shared_from_this();
  cancel();
  ports_.end(std::move(error), bytes);
}

void Film::cancel() {
  if (std::exchange(ended_, true)) return;
  const auto self = shared_from_this();  // the engine's listener may be all that holds it
  if (request_) engine_.forget(std::exchange(request_, 0));
  engine_.post(CloseSession{session_});
  writer_.reset();
  file_.reset();
}

}  // namespace isostrata
