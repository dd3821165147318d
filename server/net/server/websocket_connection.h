// One WebSocket: reads commands, writes messages and frames. Only the two units that know Beast include this.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>

#include "net/server/connections.h"
#include "net/server/prefixed_stream.h"

namespace isostrata {

/// Accepts the upgrade, which the site has welcomed, and serves until either side ends it. Bounds: one write in flight, control
/// before frames, at most 8 MiB waiting; a write that does not end within 10 s, or no Hello within 10 s, closes the socket. Never
/// throws.
boost::asio::awaitable<void> serve_websocket(PrefixedStream stream,
                                             boost::beast::http::request<boost::beast::http::string_body> request,
                                             Connections& connections, Places::Place& place, Sessions::Admission admission);

}  // namespace isostrata
