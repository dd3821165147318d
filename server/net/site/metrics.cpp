#include "net/site/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <fstream>

namespace isostrata {
namespace {

const prometheus::Histogram::BucketBoundaries kSeconds = {0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 60};

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double all = 0, resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// A method that no route has is a client's own word.
std::string known_method(const std::string& method) {
  for (const char* known : {"GET", "HEAD", "OPTIONS", "POST", "PUT", "PATCH", "DELETE"})
    if (method == known) return method;
  return "other";
}

std::size_t bytes_of(const FrameReady& frame) {
  std::size_t bytes = frame.bytes ? frame.bytes->size() : 0;
  if (frame.bands)
    for (const PngBand& band : *frame.bands) bytes += band.bytes.size();
  return bytes;
}

std::string format_of(const FrameReady& frame) {
  if (frame.video) return std::string(name_of(frame.video->codec));
  if (!frame.bytes) return "png";  // in bands
  const auto& b = *frame.bytes;
  const auto begins = [&](std::string_view magic) {
    return b.size() >= magic.size() && std::equal(magic.begin(), magic.end(), b.begin(),
                                                  [](char m, std::uint8_t v) { return static_cast<std::uint8_t>(m) == v; });
  };
  if (begins("\x89PNG")) return "png";
  if (begins("\xff\xd8")) return "jpeg";
  if (begins("RIFF")) return "webp";
  if (begins("\x76\x2f\x31\x01")) return "exr";
  return "video";
}

}  // namespace

struct Metrics::Families {
  prometheus::Registry registry;
  prometheus::Family<prometheus::Counter>& frames;
  prometheus::Family<prometheus::Counter>& frame_bytes;
  prometheus::Family<prometheus::Counter>& frame_pixels;
  prometheus::Family<prometheus::Histogram>& stages;
  prometheus::Family<prometheus::Counter>& engine_errors;
  prometheus::Family<prometheus::Counter>& websocket_errors;
  prometheus::Family<prometheus::Counter>& requests;
  prometheus::Family<prometheus::Histogram>& request_seconds;
  prometheus::Counter& response_bytes;
  prometheus::Counter& websocket_bytes;
  prometheus::Counter& sessions_begun;
  prometheus::Counter& sessions_ended;
  prometheus::Gauge& sessions;
  prometheus::Gauge& viewers;
  prometheus::Gauge& connections;
  prometheus::Gauge& operations;
  prometheus::Gauge& worker_deaths;
  prometheus::Gauge& resident;

  prometheus::Family<prometheus::Counter>& counters(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  prometheus::Gauge& gauge(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry).Add({});
  }
  prometheus::Family<prometheus::Histogram>& histograms(const char* name, const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
  }

  Families()
      : frames(counters("isostrata_frames_total", "Frames and pictures drawn and encoded")),
        frame_bytes(counters("isostrata_frame_bytes_total", "Encoded bytes of frames and pictures")),
        frame_pixels(counters("isostrata_frame_pixels_total", "Pixels of frames and pictures")),
        stages(histograms("isostrata_stage_seconds", "Time of a frame's stages")),
        engine_errors(counters("isostrata_engine_errors_total", "Requests that the engine could not meet")),
        websocket_errors(counters("isostrata_websocket_errors_total", "Errors sent over WebSockets")),
        requests(counters("isostrata_http_requests_total", "HTTP requests answered")),
        request_seconds(histograms("isostrata_http_request_seconds", "Time until an HTTP answer was there")),
        response_bytes(
            counters("isostrata_http_response_bytes_total", "Bytes of HTTP bodies, files and events left out").Add({})),
        websocket_bytes(counters("isostrata_websocket_sent_bytes_total", "Bytes of WebSocket messages sent").Add({})),
        sessions_begun(counters("isostrata_sessions_begun_total", "Sessions that began").Add({})),
        sessions_ended(counters("isostrata_sessions_ended_total", "Sessions that ended").Add({})),
        sessions(gauge("isostrata_sessions", "Sessions that live")),
        viewers(gauge("isostrata_viewers", "Open WebSockets")),
        connections(gauge("isostrata_connections", "Open connections")),
        operations(gauge("isostrata_operations_running", "Long work that runs")),
        worker_deaths(gauge("isostrata_worker_deaths", "Processes that drew, and died or hung")),
        resident(gauge("process_resident_memory_bytes", "Resident memory")) {}
};

Metrics::Metrics(const std::string& server, const std::string& device) : families_(std::make_unique<Families>()) {
  prometheus::BuildGauge()
      .Name("isostrata_info")
      .Help("Version and device; always 1")
      .Register(families_->registry)
      .Add({{"server", server}, {"device", device}})
      .Set(1);
  const auto now = std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  families_->gauge("process_start_time_seconds", "When the server began, in seconds since 1970").Set(now);
}
Metrics::~Metrics() = default;

void Metrics::http_answered(const std::string& method, const std::string& route, int status, double seconds, std::size_t bytes) {
  Families& f = *families_;
  const std::string of = route.empty() ? "none" : route;
  f.requests.Add({{"method", known_method(method)}, {"route", of}, {"status", std::to_string(status)}}).Increment();
  f.request_seconds.Add({{"route", of}}, kSeconds).Observe(seconds);
  f.response_bytes.Increment(static_cast<double>(bytes));
}

void Metrics::websocket_sent(std::size_t bytes) { families_->websocket_bytes.Increment(static_cast<double>(bytes)); }
void Metrics::websocket_error(const std::string& code) { families_->websocket_errors.Add({{"code", code}}).Increment(); }
void Metrics::session_began(const Session&) { families_->sessions_begun.Increment(); }
void Metrics::session_ended(const Session&) { families_->sessions_ended.Increment(); }

void Metrics::engine_event(const Session*, const EngineEvent& event) {
  Families& f = *families_;
  if (const auto* failed = std::get_if<RequestFailed>(&event)) {
    f.engine_errors.Add({{"code", to_string(failed->code)}}).Increment();
  } else if (const auto* frame = std::get_if<FrameReady>(&event)) {
    const prometheus::Labels labels{{"phase", frame->lossless ? "still" : "moving"}, {"format", format_of(*frame)}};
    f.frames.Add(labels).Increment();
    f.frame_pixels.Add(labels).Increment(static_cast<double>(frame->width) * frame->height);
    f.frame_bytes.Add(labels).Increment(static_cast<double>(bytes_of(*frame)));
    const StageTimes& ms = frame->stages;
    const std::array<std::pair<const char*, double>, 6> stages = {{{"extract", ms.extract_ms},
                                                                   {"order", ms.order_ms},
                                                                   {"draw", ms.draw_ms},
                                                                   {"readback", ms.readback_ms},
                                                                   {"encode", ms.encode_ms},
                                                                   {"total", ms.total_ms}}};
    for (const auto& [stage, time_ms] : stages) f.stages.Add({{"stage", stage}}, kSeconds).Observe(time_ms / 1000);
  }
}

std::string Metrics::text(const MetricsGauges& gauges) {
  Families& f = *families_;
  f.sessions.Set(static_cast<double>(gauges.sessions));
  f.viewers.Set(static_cast<double>(gauges.viewers));
  f.connections.Set(static_cast<double>(gauges.connections));
  f.operations.Set(static_cast<double>(gauges.operations));
  f.worker_deaths.Set(static_cast<double>(gauges.worker_deaths));
  f.resident.Set(resident_bytes());
  return prometheus::TextSerializer().Serialize(f.registry.Collect());
}

}  // namespace isostrata
