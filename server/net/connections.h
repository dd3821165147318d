// What the connections of one server share. Asio types only, so that few units compile Beast.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>

#include "net/message_budget.h"
#include "net/site.h"
#include "session/sessions.h"

namespace isostrata {

/// Lives on the io thread and outlives every connection.
struct Connections {
  Sessions& sessions;
  Site& site;
  std::size_t max_connections = 256;               // whoever comes when so many are open is turned away
  std::chrono::milliseconds hello_timeout{10000};  // a WebSocket that has not been greeted back by then is closed
  std::chrono::milliseconds write_timeout{10000};  // one that does not take 64 KiB within that time is closed
  /// Called after a message has changed what is due.
  std::function<void()> wake;
  double messages_per_second = MessageBudget::kPerSecond;  // of one WebSocket; more are passed over or read later

  // What follows is kept by the connections themselves.
  std::size_t open = 0;
  std::map<std::size_t, std::function<void()>> closers;  // end a connection at once
  std::size_t last_closer = 0;
};

/// Serves one socket until it ends: HTTP requests, of which one may become a WebSocket. Never throws.
boost::asio::awaitable<void> serve_connection(boost::asio::ip::tcp::socket socket, Connections& connections);

}  // namespace isostrata
