// A TCP stream whose first bytes were read together with what came before them.
#pragma once

#include <boost/asio/async_result.hpp>
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <cstddef>
#include <string>
#include <utility>

namespace isostrata {

/// Reads `first`, then the stream; writes to the stream. What Beast's WebSocket needs of a stream, and no more.
class PrefixedStream {
 public:
  using next_layer_type = boost::beast::tcp_stream;
  using executor_type = next_layer_type::executor_type;

  PrefixedStream(next_layer_type stream, std::string first) : stream_(std::move(stream)), first_(std::move(first)) {}

  executor_type get_executor() noexcept { return stream_.get_executor(); }
  next_layer_type& next_layer() noexcept { return stream_; }
  const next_layer_type& next_layer() const noexcept { return stream_; }

  template <class Buffers, class Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& to) {
          if (at_ == first_.size()) return void(stream_.async_read_some(to, std::move(handler)));
          const std::size_t copied = boost::asio::buffer_copy(to, boost::asio::buffer(first_.data() + at_, first_.size() - at_));
          at_ += copied;
          boost::asio::post(get_executor(),
                            boost::beast::bind_front_handler(std::move(handler), boost::system::error_code(), copied));
        },
        token, buffers);
  }
  template <class Buffers, class Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return stream_.async_write_some(buffers, std::forward<Token>(token));
  }

  /// Beast finds it when a WebSocket is closed.
  template <class Handler>
  friend void async_teardown(boost::beast::role_type role, PrefixedStream& stream, Handler&& handler) {
    async_teardown(role, stream.stream_, std::forward<Handler>(handler));
  }

 private:
  next_layer_type stream_;
  std::string first_;
  std::size_t at_ = 0;
};

}  // namespace isostrata
