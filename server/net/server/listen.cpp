#include "net/server/listen.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/descriptor.h"
#include "base/error.h"

namespace isostrata {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;

}  // namespace

int listening_port(const std::string& host, unsigned short port) {
  asio::io_context io;
  boost::system::error_code error;
  tcp::resolver resolver(io);
  const auto found = resolver.resolve(host, std::to_string(port), tcp::resolver::passive, error);
  if (error || found.empty()) throw Error(ErrorCode::invalid_argument, "--host " + host + ": not an address of this machine");
  const tcp::endpoint endpoint = found.begin()->endpoint();
  tcp::acceptor acceptor(io);
  acceptor.open(endpoint.protocol(), error);
  if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(128, error);
  if (error)
    throw Error(ErrorCode::unavailable, "cannot listen on " + host + ":" + std::to_string(port) + ": " + error.message() +
                                            (error == asio::error::address_in_use ? "; --port 0 picks a free one" : ""));
  return acceptor.release();
}

int listening_socket(const std::filesystem::path& path) {
  const auto failed = [&](const std::string& why) {
    return Error(ErrorCode::unavailable, "cannot listen on the socket " + path.string() + ": " + why);
  };
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  const std::string text = path.string();
  if (text.size() >= sizeof name.sun_path)
    throw failed("its path has " + std::to_string(text.size()) + " bytes; expected at most " +
                 std::to_string(sizeof name.sun_path - 1));
  std::memcpy(name.sun_path, text.c_str(), text.size());
  const auto* address = reinterpret_cast<const sockaddr*>(&name);

  struct stat there {};
  if (lstat(text.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) throw failed("something that is not a socket is there");
    const Descriptor probe{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
    if (connect(probe.get(), address, sizeof name) == 0) throw failed("another server answers there");
    if (errno != ECONNREFUSED || unlink(text.c_str()) != 0) throw failed(std::strerror(errno));
  }
  Descriptor listening{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  // Nobody can connect before listen, so there is no moment in which others may.
  if (listening.get() < 0 || bind(listening.get(), address, sizeof name) != 0 || chmod(text.c_str(), 0600) != 0 ||
      ::listen(listening.get(), 128) != 0)
    throw failed(std::strerror(errno));
  return listening.release();
}

tcp::acceptor listen_on_descriptor(asio::io_context& io, int descriptor) {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  getsockname(descriptor, reinterpret_cast<sockaddr*>(&bound), &size);
  tcp::acceptor acceptor(io);
  boost::system::error_code error;
  acceptor.assign(bound.ss_family == AF_INET6 ? tcp::v6() : tcp::v4(), descriptor, error);
  if (error) throw Error(ErrorCode::unavailable, "cannot listen on descriptor " + std::to_string(descriptor) + ": " + error.message());
  return acceptor;
}

}  // namespace isostrata
