#include "bench/shaped_link.h"

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <cstddef>
#include <deque>
#include <thread>
#include <vector>

#include "base/error.h"

namespace isostrata {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using Steady = std::chrono::steady_clock;

constexpr std::size_t kSegmentBytes = 1448;            // of Ethernet
constexpr std::size_t kQueueBytes = 2 << 20;           // what the bottleneck holds before it stops reading
constexpr auto kGrain = std::chrono::milliseconds(1);  // waits shorter than a timer's own error are saved up

/// One direction of one connection. Three coroutines: what is read waits in the queue, passes the bottleneck, waits out the
/// delay, is written.
struct Direction {
  Direction(asio::io_context& io, std::shared_ptr<tcp::socket> source, std::shared_ptr<tcp::socket> sink, const LinkShape& at)
      : from(std::move(source)), to(std::move(sink)), shape(at), queued(io), passed(io), room(io), pace(io) {
    for (asio::steady_timer* timer : {&queued, &passed, &room}) timer->expires_at(Steady::time_point::max());
  }

  struct Segment {
    std::vector<char> bytes;   // none: the sender has ended
    Steady::time_point due{};  // at the far end
  };

  void end() {
    ended = true;
    boost::system::error_code ignored;
    from->close(ignored);
    to->close(ignored);
    for (asio::steady_timer* timer : {&queued, &passed, &room, &pace}) timer->cancel();
  }

  std::shared_ptr<tcp::socket> from, to;
  const LinkShape& shape;
  asio::steady_timer queued, passed, room, pace;  // the first three: something is in the queue, on the wire, taken from the queue
  std::deque<Segment> queue, wire;
  std::size_t queue_bytes = 0;
  bool ended = false;
};

asio::awaitable<void> wait(asio::steady_timer& timer) {
  boost::system::error_code error;
  co_await timer.async_wait(asio::redirect_error(asio::use_awaitable, error));
}

asio::awaitable<void> read_in(std::shared_ptr<Direction> d) {
  std::array<char, 64 << 10> buffer;
  boost::system::error_code error;
  while (!d->ended) {
    const std::size_t n =
        co_await d->from->async_read_some(asio::buffer(buffer), asio::redirect_error(asio::use_awaitable, error));
    if (error) {
      // The end travels behind what was said before it.
      d->queue.emplace_back();
      d->queued.cancel();
      co_return;
    }
    for (std::size_t at = 0; at < n; at += kSegmentBytes)
      d->queue.push_back({{buffer.begin() + static_cast<std::ptrdiff_t>(at),
                           buffer.begin() + static_cast<std::ptrdiff_t>(std::min(at + kSegmentBytes, n))}});
    d->queue_bytes += n;
    d->queued.cancel();
    while (!d->ended && d->queue_bytes > kQueueBytes) co_await wait(d->room);
  }
}

asio::awaitable<void> pass(std::shared_ptr<Direction> d) {
  Steady::time_point free_at = Steady::now();  // when the bottleneck has passed all before
  while (!d->ended) {
    if (d->queue.empty()) {
      co_await wait(d->queued);
      continue;
    }
    Direction::Segment segment = std::move(d->queue.front());
    d->queue.pop_front();
    d->queue_bytes -= segment.bytes.size();
    d->room.cancel();
    // What was saved up by waiting in whole grains is still owed: time runs on from free_at, not from now.
    free_at = std::max(free_at, Steady::now() - 2 * kGrain);
    if (d->shape.bits_per_second > 0)
      free_at += std::chrono::duration_cast<Steady::duration>(
          std::chrono::duration<double>(8.0 * static_cast<double>(segment.bytes.size()) / d->shape.bits_per_second));
    if (free_at > Steady::now() + kGrain) {
      d->pace.expires_at(free_at);
      co_await wait(d->pace);
    }
    segment.due = std::max(free_at, Steady::now()) + d->shape.round_trip / 2;
    const bool last = segment.bytes.empty();
    d->wire.push_back(std::move(segment));
    d->passed.cancel();
    if (last) co_return;
  }
}

asio::awaitable<void> hand_on(std::shared_ptr<Direction> d) {
  asio::steady_timer arrival(d->pace.get_executor());
  boost::system::error_code error;
  while (!d->ended) {
    if (d->wire.empty()) {
      co_await wait(d->passed);
      continue;
    }
    if (d->wire.front().due > Steady::now()) {
      arrival.expires_at(d->wire.front().due);
      co_await wait(arrival);
    }
    const auto now = Steady::now();
    std::vector<char> bytes;
    bool last = false;
    for (; !d->wire.empty() && d->wire.front().due <= now; d->wire.pop_front()) {
      bytes.insert(bytes.end(), d->wire.front().bytes.begin(), d->wire.front().bytes.end());
      last = d->wire.front().bytes.empty();
    }
    co_await asio::async_write(*d->to, asio::buffer(bytes), asio::redirect_error(asio::use_awaitable, error));
    if (error) co_return d->end();
    if (last) {
      d->to->shutdown(tcp::socket::shutdown_send, error);
      co_return;
    }
  }
}

}  // namespace

class ShapedLink::Impl {
 public:
  Impl(unsigned short target_port, const LinkShape& shape) : shape_(shape), acceptor_(io_), target_port_(target_port) {
    boost::system::error_code error;
    const tcp::endpoint any(asio::ip::address_v4::loopback(), 0);
    acceptor_.open(any.protocol(), error);
    if (!error) acceptor_.bind(any, error);
    if (!error) acceptor_.listen(128, error);
    if (error) throw Error(ErrorCode::unavailable, "the shaped link cannot listen: " + error.message());
    port_ = acceptor_.local_endpoint().port();
    asio::co_spawn(io_, accept_all(), asio::detached);
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Impl() {
    io_.stop();
    thread_.join();
  }

  unsigned short port() const { return port_; }
  void reshape(const LinkShape& shape) {
    asio::post(io_, [this, shape] { shape_ = shape; });
  }

 private:
  asio::awaitable<void> accept_all() {
    boost::system::error_code error;
    for (;;) {
      auto near = std::make_shared<tcp::socket>(io_), far = std::make_shared<tcp::socket>(io_);
      co_await acceptor_.async_accept(*near, asio::redirect_error(asio::use_awaitable, error));
      if (error) co_return;
      co_await far->async_connect({asio::ip::address_v4::loopback(), target_port_},
                                  asio::redirect_error(asio::use_awaitable, error));
      if (error) continue;
      near->set_option(tcp::no_delay(true), error);
      far->set_option(tcp::no_delay(true), error);
      for (const auto& direction :
           {std::make_shared<Direction>(io_, near, far, shape_), std::make_shared<Direction>(io_, far, near, shape_)}) {
        asio::co_spawn(io_, read_in(direction), asio::detached);
        asio::co_spawn(io_, pass(direction), asio::detached);
        asio::co_spawn(io_, hand_on(direction), asio::detached);
      }
    }
  }

  LinkShape shape_;  // read and changed on thread_ only
  asio::io_context io_{1};
  tcp::acceptor acceptor_;
  const unsigned short target_port_;
  unsigned short port_ = 0;
  std::thread thread_;
};

ShapedLink::ShapedLink(unsigned short target_port, const LinkShape& shape) : impl_(std::make_unique<Impl>(target_port, shape)) {}
ShapedLink::~ShapedLink() = default;
unsigned short ShapedLink::port() const { return impl_->port(); }
void ShapedLink::reshape(const LinkShape& shape) { impl_->reshape(shape); }

}  // namespace isostrata
