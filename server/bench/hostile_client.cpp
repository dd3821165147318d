#include "bench/hostile_client.h"

#include <pthread.h>
#include <time.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "base/error.h"
#include "bench/plain_socket.h"
#include "bench/turning_camera.h"
#include "isostrata/v1/isostrata.pb.h"

namespace isostrata {
namespace {

using Steady = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr int kFloodEachMs = 10;  // messages
constexpr int kPoliteEveryMs = 16;
constexpr int kVanishEveryMs = 20;
constexpr int kMalformedEveryMs = 500;

}  // namespace

const std::vector<std::string>& hostile_manners() {
  static const std::vector<std::string> names{"polite", "flood", "flood-hidden", "reader", "vanish", "garbage"};
  return names;
}

class HostileClient::Impl {
 public:
  Impl(unsigned short port, std::string token, std::string dataset, const std::string& manners)
      : port_(port), token_(std::move(token)), dataset_(std::move(dataset)), manners_(manners) {
    if (std::find(hostile_manners().begin(), hostile_manners().end(), manners) == hostile_manners().end())
      throw Error(ErrorCode::invalid_argument, "no client has the manners '" + manners + "'");
    if (!begin()) throw Error(ErrorCode::unavailable, "the server does not take a second client");
    thread_ = std::thread([this] { misbehave(); });
  }
  ~Impl() {
    stop_ = true;
    thread_.join();
  }

  double cpu_seconds() {
    clockid_t clock{};
    timespec used{};
    if (pthread_getcpuclockid(thread_.native_handle(), &clock) != 0 || clock_gettime(clock, &used) != 0) return 0;
    return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
  }

  std::atomic<std::uint64_t> messages_{0}, connections_{0};

 private:
  std::unique_ptr<PlainSocket> connect() const { return std::make_unique<PlainSocket>(port_, token_, manners_ == "reader" ? 4096 : 0); }

  /// Hello, the dataset, and the viewport last, since whoever shows one at first gets the server's first dataset.
  bool begin() {
    socket_ = connect();
    ++connections_;
    v1::ClientMessage hello, open, viewport;
    hello.mutable_hello()->set_protocol_major(1);
    hello.mutable_hello()->add_moving_formats("jpeg");
    open.mutable_open_dataset()->set_id(dataset_);
    viewport.mutable_viewport()->set_width(160);
    viewport.mutable_viewport()->set_height(120);
    viewport.mutable_viewport()->set_hidden(manners_ == "flood-hidden");
    socket_->add(hello);
    socket_->add(open);
    socket_->add(viewport);
    return socket_->flush(1000);
  }

  /// Reads what has come; frames are acknowledged, as a client that wants to see more does.
  void read() {
    while (socket_->receive(65536, 0)) {
    }
    while (const auto bytes = socket_->next()) {
      v1::ServerMessage message;
      if (bytes->empty() || !message.ParseFromString(*bytes) || !message.has_frame()) continue;
      v1::ClientMessage ack;
      ack.mutable_frame_ack()->set_frame_id(message.frame().frame_id());
      socket_->add(ack);
    }
  }

  void turn(int times) {
    for (int i = 0; i < times; ++i) socket_->add(turning_camera(6, angle_ += 0.001));
    messages_ += static_cast<std::uint64_t>(times);
  }

  void send_nonsense(int times) {
    for (int i = 0; i < times; ++i) {
      v1::ClientMessage message;
      if (i % 3 == 0)
        message.mutable_set_view()->set_view("no such view");
      else if (i % 3 == 1)
        message.mutable_patch_interval()->set_id(4000000000u);
      else
        message.mutable_viewport()->set_width(4000000000u);
      socket_->add(message);
    }
    messages_ += static_cast<std::uint64_t>(times);
  }

  // A step every millisecond; the server may be slower, and then the bytes wait in the socket, as they would for anyone.
  void misbehave() {
    constexpr std::size_t kMostWaiting = 1 << 16;
    std::uint64_t step = 0;
    for (auto next = Steady::now(); !stop_; next += milliseconds(1), ++step) {
      next = std::max(next, Steady::now() - milliseconds(20));  // what was missed is not made up for in one burst
      std::this_thread::sleep_until(next);
      const auto every = [&](int ms) { return step % static_cast<std::uint64_t>(ms) == 0; };
      if (manners_ == "reader") {
        if (every(1000)) socket_->receive(1, 0);
        if (every(50) && socket_->open()) turn(1);
      } else if (manners_ == "vanish") {
        if (every(kVanishEveryMs)) begin();
        continue;
      } else if (manners_ == "polite") {
        read();
        if (every(kPoliteEveryMs)) turn(1);
      } else {
        read();
        if (socket_->waiting() < kMostWaiting) manners_ == "garbage" ? send_nonsense(kFloodEachMs) : turn(kFloodEachMs);
        if (manners_ == "garbage" && every(kMalformedEveryMs)) socket_->add_bytes("\xff\xff\xff\xffnot a message");
      }
      if (!socket_->flush() && every(100)) begin();  // cut off: it comes again
    }
  }

  const unsigned short port_;
  const std::string token_, dataset_, manners_;
  std::unique_ptr<PlainSocket> socket_;
  double angle_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

HostileClient::HostileClient(unsigned short port, std::string token, std::string dataset, const std::string& manners)
    : impl_(std::make_unique<Impl>(port, std::move(token), std::move(dataset), manners)) {}
HostileClient::~HostileClient() = default;
std::uint64_t HostileClient::messages() const { return impl_->messages_; }
std::uint64_t HostileClient::connections() const { return impl_->connections_; }
double HostileClient::cpu_seconds() const { return impl_->cpu_seconds(); }

}  // namespace isostrata
