#include "bench/shaped_link.h"

#include <gtest/gtest.h>

#include "net/running_server.h"

namespace isostrata {
namespace {

using std::chrono::milliseconds;
using Steady = std::chrono::steady_clock;

/// The page that says how to build the page, through the link; it is some hundred bytes.
std::string get(unsigned short port, const std::string& target = "/healthz") {
  RawSocket socket(port);
  socket.send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " +
              RunningServer::kToken + "\r\n\r\n");
  return socket.read_all();
}

/// Without the lines that name the moment.
std::string body(const std::string& response) { return response.substr(response.find("\r\n\r\n")); }

TEST(ShapedLink, CarriesWhatTheServerSaysByteForByte) {
  RunningServer server;
  const ShapedLink link(server.port(), {milliseconds(2), 50e6});
  const std::string target = "/api/v1/openapi.json";
  EXPECT_EQ(status_of(get(link.port(), target)), 200);
  EXPECT_EQ(body(get(link.port(), target)), body(get(server.port(), target)));
}

TEST(ShapedLink, IsNeverFasterThanItsDelayAndItsRate) {
  RunningServer server;
  server.control->noise = true;
  ShapedLink link(server.port(), {milliseconds(30), 0});
  auto start = Steady::now();
  EXPECT_EQ(status_of(get(link.port())), 200);
  EXPECT_GE(Steady::now() - start, milliseconds(30));

  auto options = server.client_options();
  options.url.replace(options.url.find(std::to_string(server.port())), std::to_string(server.port()).size(),
                      std::to_string(link.port()));
  client::Client client(options);
  client.open_dataset("torus-12");
  link.reshape({milliseconds(0), 1e6});
  start = Steady::now();
  const auto bits = 8.0 * static_cast<double>(client.lossless_frame().payload().size());
  ASSERT_GT(bits, 8 * 8000) << "noise does not compress";
  EXPECT_GE(std::chrono::duration<double>(Steady::now() - start).count(), 0.9 * bits / 1e6);
}

TEST(ShapedLink, EndsTheFarSideWhenTheNearOneGoes) {
  RunningServer server;
  const ShapedLink link(server.port(), {milliseconds(1), 0});
  {
    RawSocket socket(link.port());
    ASSERT_EQ(status_of(socket.open_websocket(std::string("/ws?token=") + RunningServer::kToken)), 101);
  }
  const auto end = Steady::now() + std::chrono::seconds(10);
  while (!has(get(server.port()), "\"viewers\":0") && Steady::now() < end) std::this_thread::sleep_for(milliseconds(5));
  EXPECT_TRUE(has(get(server.port()), "\"viewers\":0"));
}

}  // namespace
}  // namespace isostrata
