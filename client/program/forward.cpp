#include "forward.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>

#include "isostrata/rest.h"

namespace isostrata::client {

int free_port(int wanted, bool strict) {
  for (const int port : {wanted, 0}) {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    const int reuse = 1;  // as ssh does it: what remains of a line that ended is in nobody's way
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &reuse, sizeof reuse);
    const bool bound = bind(socket, reinterpret_cast<sockaddr*>(&address), size) == 0 && listen(socket, 1) == 0 &&
                       getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0;
    close(socket);
    if (bound) return ntohs(address.sin_port);
    if (strict) throw ClientError("unavailable", "port " + std::to_string(port) + " of this machine is taken");
  }
  throw ClientError("unavailable", "no port of this machine is free");
}

std::string address_here(const std::string& address, int port) {
  const auto place = address.find("://") + 3;
  return address.substr(0, place) + "127.0.0.1:" + std::to_string(port) + address.substr(address.find('/', place));
}

bool answers(Options options) {
  options.timeout = std::chrono::seconds(5);
  try {
    http_get(options, "healthz");
  } catch (const ClientError& error) {
    // Its certificate, if it has one, is of another name: the browser asks about that.
    return error.code() == "tls" || error.code() == "cancelled";
  }
  return true;
}

}  // namespace isostrata::client
