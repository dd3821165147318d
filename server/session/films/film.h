// A film while it is made: each picture is asked of the engine as a frame of a video, and written to the file when it comes.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

#include "session/datasets/engine_door.h"
#include "session/films/film_plan.h"

namespace isostrata {

namespace client {
class WebmWriter;
class WholeFile;
}  // namespace client

/// The engine knows it as a session of its own, which nobody else has: who goes on in the session that it is a film of does not meet it, and takes turns with
/// it. Not thread-safe: lives on the io thread.
class Film : public std::enable_shared_from_this<Film> {
 public:
  static constexpr std::uint64_t kMaxBytes = 1ull << 30;  // of the file

  struct Ports {
    std::function<void(double fraction)> progress;
    /// The last call. The film is in its file, or why it is not: then nothing is left of it.
    std::function<void(std::optional<v1::Error> error, std::uint64_t bytes)> end;
  };
  /// session: a key that no session has. The door must outlive it.
  Film(EngineDoor& engine, SessionKey session, FilmPlan plan, std::filesystem::path file, Ports ports);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// Goes on until the end, or cancel(); lives as long.
  void begin();
  /// No port is called any more, and nothing is left of it.
  void cancel();

 private:
  void ask();
  void take(const EngineEvent& event);
  void write(const FrameReady& frame);
  void end(std::optional<v1::Error> error, std::uint64_t bytes = 0);

  EngineDoor& engine_;
  const SessionKey session_;
  const FilmPlan plan_;
  const std::filesystem::path path_;
  Ports ports_;
  std::unique_ptr<client::WholeFile> file_;
  std::unique_ptr<client::WebmWriter> writer_;
  int picture_ = 0;  // that is asked for
  std::int64_t key_ms_ = 0;
  RequestId request_ = 0;
  bool ended_ = false;
};

}  // namespace isostrata
