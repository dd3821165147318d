// What the connections of one server share. Asio types only, so that few units compile Beast.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

#include "net/http/message_budget.h"
#include "net/http/places.h"
#include "net/http/wrong_tokens.h"
#include "net/site/site.h"
#include "session/sessions/sessions.h"

namespace isostrata {

/// Lives on the io thread and outlives every connection.
struct Connections {
  Sessions& sessions;
  Site& site;
  Places places{256};
  std::chrono::milliseconds hello_timeout{10000};  // a WebSocket that has not been greeted back by then is closed
  std::chrono::milliseconds write_timeout{10000};  // one that does not take 64 KiB within that time is closed
  /// Called after a message has changed what is due.
  std::function<void()> wake;
  WrongTokens wrong_tokens{};
  double messages_per_second = MessageBudget::kPerSecond;  // of one WebSocket; more are passed over or read later
  std::size_t unread_bytes = 0;  // of HTTP answers that are being sent
};

/// Serves one socket until it ends: HTTP requests, of which one may become a WebSocket. address: of who is at its other end. Never
/// throws.
boost::asio::awaitable<void> serve_connection(boost::asio::ip::tcp::socket socket, std::string address, Connections& connections);

/// The address at a socket's other end, without the port; empty if it is gone already.
std::string address_of(const boost::asio::ip::tcp::socket& socket);

}  // namespace isostrata
