#include "net/server/tls_gate.h"

#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/ssl.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/asio/write.hpp>
#include <chrono>

namespace isostrata {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using tcp = asio::ip::tcp;

constexpr auto kHandshakeTimeout = std::chrono::seconds(10);
constexpr std::size_t kPieceBytes = 64 << 10;
constexpr int kPairBytes = 64 << 10;  // what the pair itself may hold each way: frames should wait if they can be counted

/// Both ends of one connection; kept alive by the two pumps.
struct Relay {
  ssl::stream<tcp::socket> outside;
  tcp::socket inside;

  void end() {
    boost::system::error_code ignored;
    outside.lowest_layer().close(ignored);
    inside.close(ignored);
  }
};

template <class From, class To>
asio::awaitable<void> pump([[maybe_unused]] std::shared_ptr<Relay> alive, From& from, To& to) {
  std::vector<char> piece(kPieceBytes);
  boost::system::error_code error;
  while (!error) {
    const std::size_t size = co_await from.async_read_some(asio::buffer(piece), asio::redirect_error(asio::use_awaitable, error));
    if (!error)
      co_await asio::async_write(to, asio::buffer(piece.data(), size), asio::redirect_error(asio::use_awaitable, error));
  }
}

asio::awaitable<void> pump_out(std::shared_ptr<Relay> relay) {
  co_await pump(relay, relay->inside, relay->outside);
  // What was written is told to be complete; who does not hear it within a moment is closed all the same.
  boost::system::error_code ignored;
  asio::steady_timer late(relay->inside.get_executor(), std::chrono::seconds(2));
  late.async_wait([relay](boost::system::error_code error) {
    if (!error) relay->end();
  });
  co_await relay->outside.async_shutdown(asio::redirect_error(asio::use_awaitable, ignored));
  late.cancel();
  relay->end();
}

asio::awaitable<void> pump_in(std::shared_ptr<Relay> relay) {
  co_await pump(relay, relay->outside, relay->inside);
  boost::system::error_code ignored;
  relay->inside.shutdown(tcp::socket::shutdown_send, ignored);
}

bool make_pair(tcp::socket& a, tcp::socket& b) {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
  for (const int end : ends) setsockopt(end, SOL_SOCKET, SO_SNDBUF, &kPairBytes, sizeof kPairBytes);
  // To Asio a stream is a stream.
  boost::system::error_code error;
  a.assign(tcp::v4(), ends[0], error);
  if (error) close(ends[0]);
  boost::system::error_code other;
  b.assign(tcp::v4(), ends[1], other);
  if (other) close(ends[1]);
  return !error && !other;
}

}  // namespace

struct TlsGate::Context {
  ssl::context of{ssl::context::tls_server};
};

TlsGate::TlsGate(const std::filesystem::path& certificate, const std::filesystem::path& key)
    : context_(std::make_unique<Context>()) {
  ssl::context& context = context_->of;
  const auto check = [](const boost::system::error_code& error, const std::filesystem::path& path, const char* what) {
    if (error) throw Error(ErrorCode::invalid_argument, path.string() + ": no " + what + " in PEM: " + error.message());
  };
  boost::system::error_code error;
  context.set_options(ssl::context::default_workarounds | ssl::context::no_sslv2 | ssl::context::no_sslv3 |
                          ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1,
                      error);
  // Keys of a session that nobody can make again, and ciphers that are sealed: TLS 1.3 has no others, of TLS 1.2 these.
  if (SSL_CTX_set_cipher_list(context.native_handle(), "ECDHE+AESGCM:ECDHE+CHACHA20") != 1)
    throw Error(ErrorCode::unavailable, "OpenSSL has none of the ciphers that are wanted");
  context.use_certificate_chain_file(certificate.string(), error);
  check(error, certificate, "certificate");
  // No key is asked for at a terminal: a server has none.
  context.set_password_callback([](std::size_t, ssl::context::password_purpose) { return std::string(); }, error);
  context.use_private_key_file(key.string(), ssl::context::pem, error);
  check(error, key, "key without a password, or not that of the certificate,");
}
TlsGate::~TlsGate() = default;

boost::asio::awaitable<void> TlsGate::serve(tcp::socket socket, std::string address, Connections& connections) {
  try {
    const auto executor = socket.get_executor();
    boost::system::error_code error;
    socket.set_option(tcp::no_delay(true), error);
    auto relay = std::make_shared<Relay>(Relay{ssl::stream<tcp::socket>(std::move(socket), context_->of), tcp::socket(executor)});
    tcp::socket served(executor);
    {
      // A handshake takes a place: a crowd of half-open ones makes room like any other.
      const Places::Place place(connections.places, address, [relay] { relay->end(); });
      asio::steady_timer late(executor, kHandshakeTimeout);
      late.async_wait([relay](boost::system::error_code late_error) {
        if (!late_error) relay->end();
      });
      co_await relay->outside.async_handshake(ssl::stream_base::server, asio::redirect_error(asio::use_awaitable, error));
      late.cancel();
    }
    if (error || !make_pair(relay->inside, served)) co_return relay->end();
    asio::co_spawn(executor, pump_out(relay), asio::detached);
    asio::co_spawn(executor, pump_in(relay), asio::detached);
    co_await serve_connection(std::move(served), std::move(address), connections);
  } catch (const std::exception&) {
    // Out of memory in one connection ends that connection.
  }
}

}  // namespace isostrata
