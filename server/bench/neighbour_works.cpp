#include "bench/neighbour_works.h"

#include <boost/json.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <thread>

#include "base/error.h"
#include "bench/plain_socket.h"
#include "bench/turning_camera.h"

namespace isostrata {
namespace {

namespace json = boost::json;
using std::chrono::milliseconds;
using Stop = std::atomic<bool>;

constexpr const char *kVolume = "torus-96", *kSeries = "cylinder-64x64x32x6", *kLargest = "torus-256";

const Stop kNever{false};

bool get(const HeavySession& of, const std::string& path, const Stop& stop) {
  return plain_request(of.port, of.token, "GET", "/api/v1/sessions/" + of.id + path, "", stop).status == 200;
}

void set_layers(const HeavySession& of, const json::array& layers, json::object more = {}) {
  more["intervals"] = layers;
  of.ask("PATCH", "/state", json::serialize(more));
}

json::array layers(int count, double lower, double upper, const char* color_map, double opacity) {
  json::array all;
  for (int i = 0; i < count; ++i)
    all.push_back(json::object{{"lower", lower + (upper - lower) * i / count},
                               {"upper", lower + (upper - lower) * (i + 1) / count},
                               {"colorMap", color_map},
                               {"opacity", opacity},
                               {"visible", true}});
  return all;
}

NeighbourWork still(const std::string& name, const std::string& query) {
  return {name, kVolume, true, [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "viridis", 0.3)); },
          [query](const HeavySession& of, const Stop& stop) { return get(of, "/image?" + query, stop); }};
}

/// A page of the session that acknowledges what it gets.
class Page {
 public:
  Page(const HeavySession& of, const std::string& token, const std::string& resume, std::uint32_t width, std::uint32_t height)
      : socket_(of.port, token) {
    v1::ClientMessage hello, viewport;
    hello.mutable_hello()->set_protocol_major(1);
    hello.mutable_hello()->add_still_formats("png");
    hello.mutable_hello()->add_moving_formats("jpeg");
    hello.mutable_hello()->set_resume_token(resume);
    viewport.mutable_viewport()->set_width(width);
    viewport.mutable_viewport()->set_height(height);
    socket_.add(hello);
    socket_.add(viewport);
    socket_.flush(1000);
  }
  void add(const v1::ClientMessage& message) { socket_.add(message); }
  void read() {
    while (socket_.receive(1 << 16, 0)) {
    }
    while (const auto bytes = socket_.next()) {
      v1::ServerMessage message;
      if (bytes->empty() || !message.ParseFromString(*bytes) || !message.has_frame() || message.frame().frame_id() == 0) continue;
      v1::ClientMessage ack;
      ack.mutable_frame_ack()->set_frame_id(message.frame().frame_id());
      socket_.add(ack);
    }
    socket_.flush();
  }
  bool open() const { return socket_.open(); }

 private:
  PlainSocket socket_;
};

std::string resume_token(const HeavySession& of) {
  return std::string(json::parse(of.ask("GET", "")).as_object().at("resumeToken").as_string());
}

/// Pages of the session, of which the first one's `act` is done 20 times a second.
bool with_pages(std::vector<std::unique_ptr<Page>> pages, const std::function<void(Page&, int)>& act, const Stop& stop) {
  bool all_open = true;
  for (const auto& page : pages) all_open = all_open && page->open();
  for (int step = 0; !stop; ++step) {
    if (step % 10 == 0) act(*pages.front(), step / 10);
    for (const auto& page : pages) page->read();
    std::this_thread::sleep_for(milliseconds(5));
  }
  return all_open;
}

void turn(Page& page, int step) { page.add(turning_camera(5, 0.02 * step)); }

std::string guest_token(const HeavySession& of) {
  const std::string made = of.ask("POST", "/invitations", R"({"role":"ROLE_VIEWER","seconds":600})");
  return std::string(json::parse(made).as_object().at("token").as_string());
}

NeighbourWork many_viewers() {
  return {"32 viewers of 32 sizes", kVolume, false,
          [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "viridis", 0.3)); },
          [](const HeavySession& of, const Stop& stop) {
            std::vector<std::unique_ptr<Page>> pages;
            const std::string resume = resume_token(of);
            for (std::uint32_t i = 0; i < 32; ++i)
              pages.push_back(std::make_unique<Page>(of, of.token, resume, 400 + 20 * i, 300 + 15 * i));
            return with_pages(std::move(pages), turn, stop);
          }};
}

NeighbourWork guest(const std::string& name, bool stills) {
  return {name, kVolume, false, [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "viridis", 0.3)); },
          [stills](const HeavySession& of, const Stop& stop) {
            std::vector<std::unique_ptr<Page>> pages;
            pages.push_back(std::make_unique<Page>(of, of.token, resume_token(of), 640, 480));
            pages.push_back(std::make_unique<Page>(of, guest_token(of), "", stills ? 640 : 8192, stills ? 480 : 8192));
            Page& guest = *pages.back();
            return with_pages(
                std::move(pages),
                [&guest, stills](Page& page, int step) {
                  turn(page, step);
                  if (!stills) return;
                  v1::ClientMessage wanted;
                  wanted.mutable_request_still()->set_width(4096);
                  wanted.mutable_request_still()->set_height(4096);
                  guest.add(wanted);
                },
                stop);
          }};
}

/// Each of `threads` asks for the same, again and again or once, and reads it or does not.
NeighbourWork requests(const std::string& name, const std::string& dataset, int threads, int times, const std::string& path, bool reads) {
  return {name, dataset, reads, [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "viridis", 0.3)); },
          [=](const HeavySession& of, const Stop& stop) {
            std::atomic<bool> all{true};
            std::vector<std::thread> asking;
            for (int i = 0; i < threads; ++i)
              asking.emplace_back([&] {
                for (int n = 0; n < times && !stop; ++n) {
                  const int status =
                      plain_request(of.port, of.token, "GET", "/api/v1/sessions/" + of.id + path, "", stop, reads).status;
                  if (reads && status != 200) all = false;
                }
              });
            for (std::thread& thread : asking) thread.join();
            return all.load();
          }};
}

/// An export or a film, to its end.
bool make_file(const HeavySession& of, const Stop& stop, const std::string& kind, const std::string& body) {
  const json::value begun = json::parse(of.ask("POST", kind, body));
  const std::string operation = "/operations/" + std::string(begun.as_object().at("id").as_string());
  std::string status = "running";
  while (status == "running" && !stop) {
    std::this_thread::sleep_for(milliseconds(20));
    status = std::string(json::parse(of.ask("GET", operation)).as_object().at("status").as_string());
  }
  of.ask("DELETE", operation);
  while (stop && status == "running") {  // it is being cancelled
    std::this_thread::sleep_for(milliseconds(20));
    status = std::string(json::parse(of.ask("GET", operation)).as_object().at("status").as_string());
  }
  return status == "done";
}

// Names that are not numbers, which would make one series of them.
constexpr int kSlowFiles = 26 * 26;
std::string slow_name(int i) { return std::string("slow-") + static_cast<char>('a' + i / 26) + static_cast<char>('a' + i % 26); }

/// A million numbers as text, which take a reader about a second, under so many names that none is opened twice.
void write_slow_files(const std::filesystem::path& folder) {
  constexpr int kSize = 100;
  std::filesystem::create_directories(folder);
  const std::filesystem::path first = folder / (slow_name(0) + ".vtk");
  std::ofstream out(first);
  out << "# vtk DataFile Version 3.0\nslow\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS " << kSize << ' ' << kSize << ' ' << kSize
      << "\nORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA " << kSize * kSize * kSize << "\nSCALARS f float 1\nLOOKUP_TABLE default\n";
  for (int i = 0; i < kSize * kSize * kSize; ++i) out << static_cast<float>(i % 977) / 7 << '\n';
  if (!out.flush()) throw Error(ErrorCode::unavailable, first.string() + ": cannot be written");
  for (int i = 1; i < kSlowFiles; ++i) std::filesystem::create_hard_link(first, folder / (slow_name(i) + ".vtk"));
}

/// Each of six others opens a file that nobody has opened yet.
bool open_slow_files(const HeavySession& of, const Stop& stop) {
  static std::atomic<int> opened{0};
  std::atomic<bool> all{true};
  std::vector<std::thread> opening;
  for (int i = 0; i < 6; ++i)
    opening.emplace_back([&, name = slow_name(opened++ % kSlowFiles)] {
      const PlainAnswer found = plain_request(of.port, of.token, "GET", "/api/v1/datasets?search=" + name, "", stop);
      if (found.status != 200) return void(all = false);
      const json::value id = json::parse(found.body).as_object().at("datasets").as_array().at(0).at("id");
      const PlainAnswer made = plain_request(of.port, of.token, "POST", "/api/v1/sessions", json::serialize(json::object{{"dataset", id}}), stop);
      if (made.status != 201) return void(all = false);
      const HeavySession session{of.port, of.token, std::string(json::parse(made.body).as_object().at("id").as_string())};
      session.ask("DELETE", "");
    });
  for (std::thread& thread : opening) thread.join();
  return all;
}

}  // namespace

std::string HeavySession::ask(const std::string& method, const std::string& path, const std::string& body) const {
  const PlainAnswer answer = plain_request(port, token, method, "/api/v1/sessions" + (id.empty() ? "" : "/" + id) + path, body, kNever);
  if (answer.status < 200 || answer.status >= 300)
    throw Error(ErrorCode::unavailable, method + " sessions" + path + ": " + std::to_string(answer.status) + " " + answer.body.substr(0, 300));
  return answer.body;
}

std::vector<std::string> neighbour_data(const std::filesystem::path& folder) {
  write_slow_files(folder);
  return {"torus:16", "torus:96", "cylinder:64x64x32x6", "torus:256", folder.string()};
}

std::vector<NeighbourWork> neighbour_works() {
  std::vector<NeighbourWork> all;
  all.push_back(still("still 1920x1080", "width=1920&height=1080"));
  all.push_back(still("still 4096x4096", "width=4096&height=4096"));
  all.push_back(still("still 8192x8192", "width=8192&height=8192"));
  all.push_back(still("EXR still 4096x4096", "width=4096&height=4096&format=exr"));
  all.push_back({"256 mapped intervals", kVolume, true,
                 [](const HeavySession& of) { set_layers(of, layers(256, 0, 0.7, "viridis", 0.02)); },
                 [](const HeavySession& of, const Stop& stop) { return get(of, "/image?width=384&height=384", stop); }});
  all.push_back({"space-time", kSeries, true, [](const HeavySession&) {},
                 [](const HeavySession& of, const Stop& stop) {
                   for (int i = 0; i < 3 && !stop; ++i) {
                     static std::atomic<int> asked{0};
                     const double time = 0.05 + 0.007 * (asked++ % 40) + 0.4 * i;
                     set_layers(of, layers(2, 0.95, 1.05, "", 0.4), {{"time", time}, {"timeMode", "TIME_MODE_SPACETIME"}});
                     if (!get(of, "/image?width=64&height=64", stop)) return false;
                   }
                   return true;
                 }});
  all.push_back({"16 terms", kSeries, true, [](const HeavySession&) {},
                 [](const HeavySession& of, const Stop& stop) {
                   static std::atomic<int> asked{0};
                   json::array terms;
                   const char* const arrays[] = {"Energy", "Density"};
                   for (int i = 0; i < 16; ++i)
                     terms.push_back(json::object{{"op", i % 2 ? "RANGE_OPERATOR_UNITE" : "RANGE_OPERATOR_EXCLUSIVE_OR"},
                                                  {"array", arrays[i % 2]},
                                                  {"lower", 0.90 + 0.011 * i + 1e-5 * asked++},
                                                  {"upper", 0.96 + 0.012 * i}});
                   set_layers(of, layers(2, 0.95, 1.05, "", 0.4), {{"terms", terms}});
                   return get(of, "/image?width=64&height=64", stop);
                 }});
  all.push_back({"export", kLargest, true, [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "", 0.3)); },
                 [](const HeavySession& of, const Stop& stop) { return make_file(of, stop, "/exports", R"({"format":"vtu"})"); }});
  all.push_back({"a film of a turn", kLargest, true, [](const HeavySession& of) { set_layers(of, layers(2, 0.1, 0.3, "", 0.3)); },
                 [](const HeavySession& of, const Stop& stop) { return make_file(of, stop, "/films", R"({"turnDeg":360,"seconds":1})"); }});
  all.push_back(requests("histograms", kLargest, 4, 25, "/histogram?bins=4096", true));
  all.push_back(many_viewers());
  all.push_back(guest("a guest's viewport of 8192x8192", false));
  all.push_back(guest("a guest's stills", true));
  all.push_back({"openings of slow files", kVolume, true, [](const HeavySession&) {}, open_slow_files});
  all.push_back(requests("60 unread pictures", kVolume, 60, 1, "/image?width=1920&height=1080", false));
  all.push_back({"a drag on the largest data", kLargest, false, [](const HeavySession& of) { set_layers(of, layers(1, 0.1, 0.3, "", 0.3)); },
                 [](const HeavySession& of, const Stop& stop) {
                   const auto id = json::parse(of.ask("GET", "/intervals")).as_object().at("intervals").at(0).at("id").to_number<std::uint32_t>();
                   std::vector<std::unique_ptr<Page>> pages;
                   pages.push_back(std::make_unique<Page>(of, of.token, resume_token(of), 640, 480));
                   return with_pages(
                       std::move(pages),
                       [id](Page& page, int step) {
                         v1::ClientMessage moved;
                         moved.mutable_patch_interval()->set_id(id);
                         moved.mutable_patch_interval()->set_lower(0.1 + 0.05 * std::sin(0.1 * step));
                         page.add(moved);
                       },
                       stop);
                 }});
  return all;
}

}  // namespace isostrata
