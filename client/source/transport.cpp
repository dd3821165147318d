#include "transport.h"

#include <openssl/err.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <boost/asio/connect.hpp>
#include <boost/asio/local/stream_protocol.hpp>

namespace isostrata::client {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using Error = boost::system::error_code;

std::string where(const ServerAddress& address) {
  return address.unix_path.empty() ? address.host + ":" + address.port : address.unix_path;
}

/// To Asio a stream is a stream. A local socket connects at once or not at all.
void connect_local(asio::ip::tcp::socket& socket, const std::string& path, Error& error) {
  using asio::local::stream_protocol;
  stream_protocol::endpoint end;
  try {
    end = stream_protocol::endpoint(path);
  } catch (const boost::system::system_error& wrong) {
    error = wrong.code();  // its path is too long
    return;
  }
  stream_protocol::socket local(socket.get_executor());
  local.connect(end, error);
  if (error) return;
  const int descriptor = local.release(error);
  if (!error) socket.assign(asio::ip::tcp::v4(), descriptor, error);
}

}  // namespace

void run_until(asio::io_context& io, const bool& done, const Options& options, Steady::time_point deadline,
               const std::string& late) {
  while (!done) {
    if (options.stop && *options.stop) throw ClientError("cancelled", "stopped");
    const auto now = Steady::now();
    if (now >= deadline) throw ClientError("timeout", late);
    io.restart();
    io.run_one_for(std::min<Steady::duration>(deadline - now, kStopPeriod));
  }
}

void Transport::finish(const bool& done, const Options& options, Steady::time_point deadline, const std::string& late) {
  try {
    run_until(io_, done, options, deadline, late);
  } catch (...) {
    close();
    while (!done && io_.run_one() > 0) {
    }
    throw;
  }
}

void Transport::connect(const ServerAddress& address, const Options& options, Steady::time_point deadline) {
  Error error;
  if (!address.unix_path.empty()) {
    connect_local(socket_, address.unix_path, error);
    if (error) throw ClientError("connection", where(address) + ": " + error.message());
    return;
  }
  asio::ip::tcp::resolver resolver(io_);
  const auto found = resolver.resolve(address.connect_to, address.port, error);
  if (error) throw ClientError("connection", where(address) + ": " + error.message());
  bool done = false;
  asio::async_connect(socket_, found, [&](Error e, const auto&) { error = e, done = true; });
  finish(done, options, deadline, where(address) + ": no connection in time");
  if (error) throw ClientError("connection", where(address) + ": " + error.message());
  socket_.set_option(asio::ip::tcp::no_delay(true), error);
  if (address.tls) shake_hands(address, options, deadline);
}

// The names in the certificate are judged by OpenSSL itself, whose words for what is wrong with one are known.
void Transport::shake_hands(const ServerAddress& address, const Options& options, Steady::time_point deadline) {
  context_.emplace(ssl::context::tls_client);
  Error error;
  context_->set_options(
      ssl::context::default_workarounds | ssl::context::no_sslv3 | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1, error);
  if (!options.ca_file.empty()) {
    context_->load_verify_file(options.ca_file, error);
    if (error) throw ClientError("bad_argument", options.ca_file + ": no certificates in PEM: " + error.message());
  } else {
    context_->set_default_verify_paths(error);
  }
  context_->set_verify_mode(options.insecure ? ssl::verify_none : ssl::verify_peer, error);
  tls_.emplace(socket_, *context_);
  SSL* const handle = tls_->native_handle();
  // An address is not a name: it is looked for among the certificate's addresses, and servers are not asked for it by name.
  Error not_an_address;
  asio::ip::make_address(address.connect_to, not_an_address);
  if (not_an_address) {
    SSL_set_tlsext_host_name(handle, address.connect_to.c_str());
    SSL_set1_host(handle, address.connect_to.c_str());
  } else {
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(handle), address.connect_to.c_str());
  }
  bool done = false;
  tls_->async_handshake(ssl::stream_base::client, [&](Error e) { error = e, done = true; });
  finish(done, options, deadline, where(address) + ": no TLS handshake in time");
  if (!error) return;
  if (const long verdict = SSL_get_verify_result(handle); verdict != X509_V_OK && !options.insecure)
    throw ClientError("tls", where(address) + ": its certificate is not trusted: " + X509_verify_cert_error_string(verdict) +
                                 (options.ca_file.empty() ? "; a CA file may say whom to trust" : ""));
  // A server that goes away in the middle is one that is not there; any other answer is not TLS.
  const bool gone = error.category() == asio::error::get_system_category() || error == asio::error::eof ||
                    error == ssl::error::stream_truncated;
  throw ClientError(gone ? "connection" : "tls", where(address) + ": no TLS: " + error.message());
}

}  // namespace isostrata::client
