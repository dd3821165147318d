#include "net/server/server.h"

#include <array>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <csignal>

#include "net/server/connections.h"
#include "net/server/listen.h"
#include "net/server/tls_gate.h"

namespace isostrata {
namespace {

namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using Steady = std::chrono::steady_clock;

constexpr std::array kNotices = {std::chrono::minutes(10), std::chrono::minutes(5), std::chrono::minutes(1)};  // before the end

constexpr std::size_t kMoreConnections = 256;  // than two for each session: pages load over several

// Whoever comes when every place is taken is told so, as far as that goes without waiting for them.
void turn_away(tcp::socket& socket) {
  static constexpr std::string_view kAnswer =
      "HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain\r\nX-Content-Type-Options: nosniff\r\nContent-Length: 52\r\n"
      "Connection: close\r\n\r\n"
      "Too many connections are open; try again in a while\n";
  boost::system::error_code ignored;
  socket.non_blocking(true, ignored);
  socket.write_some(asio::buffer(kAnswer), ignored);
  socket.shutdown(tcp::socket::shutdown_send, ignored);
  socket.close(ignored);
}

bool is_ignored(int signal) {
  struct sigaction now {};
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

std::string bracketed(const std::string& host) {
  return host.find(':') != std::string::npos && !host.starts_with('[') ? "[" + host + "]" : host;
}

SiteOptions site_options(const ServerOptions& options, unsigned short port, std::string& public_host) {
  SiteOptions site;
  site.base_path = parse_base_url(options.base_url, public_host);
  site.web_root = options.web_root;
  site.log = options.log;
  site.access.token = options.token;
  site.access.port = port;
  site.access.base_path = site.base_path;
  site.access.secure = !options.tls_certificate.empty();
  site.access.allowed_hosts = options.allowed_hosts;
  if (!public_host.empty()) site.access.allowed_hosts.push_back(public_host);
  if (options.host != "0.0.0.0" && options.host != "::") site.access.own_hosts.push_back(bracketed(options.host));
  for (auto* list : {&site.access.allowed_hosts, &site.access.own_hosts})
    for (std::string& host : *list)
      for (char& c : host) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return site;
}

std::unique_ptr<TlsGate> make_gate(const ServerOptions& options) {
  if (options.tls_certificate.empty() != options.tls_key.empty())
    throw Error(ErrorCode::invalid_argument, "--tls-cert and --tls-key belong together; one of them is missing");
  if (options.tls_certificate.empty()) return nullptr;
  return std::make_unique<TlsGate>(options.tls_certificate, options.tls_key);
}

SessionsOptions sessions_options(const ServerOptions& options, const FrameEngine& engine) {
  SessionsOptions sessions;
  sessions.max_sessions = options.max_sessions;
  sessions.max_viewers = options.max_viewers;
  sessions.max_viewer_pixels = options.max_viewer_pixels;
  sessions.session_ttl = options.session_ttl;
  sessions.warn = options.warn;
  if (!options.state_dir.empty()) sessions.journal = options.state_dir / "sessions";
  if (options.ends)
    sessions.ends = std::chrono::duration_cast<std::chrono::milliseconds>(options.ends->time_since_epoch()).count();
  sessions.stall_time = options.stall_time;
  sessions.server_name = options.name;
  sessions.device = engine.device();
  sessions.device_is_software = engine.device_is_software();
  sessions.engine = [&engine] { return engine.facts(); };
  sessions.follows_files = options.living != nullptr;
  sessions.catalogue = options.living ? options.living->now() : std::make_shared<Catalogue>(engine.catalogue());
  if (options.living) sessions.watching = options.living->how();
  return sessions;
}

tcp::acceptor listen(asio::io_context& io, const ServerOptions& options) {
  return listen_on_descriptor(io, options.listening >= 0    ? options.listening
                                  : options.socket.empty() ? listening_port(options.host, options.port)
                                                           : listening_socket(options.socket));
}

std::unique_ptr<FrameEngine> make_engine(const ServerOptions& options, FrameEngine::Sink sink) {
  if (options.worker) return std::make_unique<WorkerEngine>(options.engine, *options.worker, std::move(sink));
  return std::make_unique<Engine>(options.engine, std::move(sink));
}

}  // namespace

// Everything but the engine lives on the thread that calls run.
class Server::Impl {
 public:
  explicit Impl(ServerOptions options)
      : options_(std::move(options)),
        connections_{sessions_,
                     site_,
                     Places(kMoreConnections + 2 * options_.max_sessions),
                     options_.hello_timeout,
                     options_.write_timeout,
                     [this] { wake(); },
                     {},
                     options_.messages_per_second},
        tls_(make_gate(options_)),
        io_(1),
        acceptor_(listen(io_, options_)),
        port_(options_.socket.empty() ? acceptor_.local_endpoint().port() : 0),
        site_options_(site_options(options_, port_, public_host_)),
        engine_(make_engine(options_, [this](EngineEvent event) { arrive(std::move(event)); })),
        sessions_(sessions_options(options_, *engine_), [this](EngineRequest request) { engine_->post(std::move(request)); }),
        site_(site_options_, sessions_),
        tick_(io_),
        notice_(io_),
        pulse_(io_) {}

  ~Impl() {
    if (options_.living) options_.living->stop();
    // Most coroutines end here; those that wait for an answer are destroyed with io_.
    connections_.places.close_all();
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    std::error_code gone;
    if (!options_.socket.empty() && options_.listening < 0) std::filesystem::remove(options_.socket, gone);
    tick_.cancel();
    notice_.cancel();
    pulse_.cancel();
    sessions_.end_all();  // what waits for sessions belongs to the site, which goes first
    io_.restart();
    io_.poll();
  }

  unsigned short port() const { return port_; }
  const FrameEngine& engine() const { return *engine_; }
  const Catalogue& catalogue() const { return sessions_.catalogue(); }

  std::string url() const {
    std::string host = bracketed(options_.host);
    if (host == "0.0.0.0" || host == "[::]") host = "127.0.0.1";
    const std::string place = options_.socket.empty() ? host + ":" + std::to_string(port_) : "localhost";
    return (tls_ ? "https://" : "http://") + place + site_options_.base_path +
           (options_.token.empty() ? "" : "?token=" + encode_percent(options_.token));
  }

  void run(bool signals, const std::function<void()>& ready) {
    asio::signal_set signal_set(io_);
    if (signals) {
      signal_set.add(SIGINT);
      signal_set.add(SIGTERM);
      if (!is_ignored(SIGHUP)) signal_set.add(SIGHUP);  // the line to its terminal has ended; under nohup that is nothing to it
      signal_set.async_wait([this](boost::system::error_code error, int number) {
        if (!error) shut_down(number == SIGINT ? "the server was interrupted" : "the server was asked to end");
      });
    }
    asio::co_spawn(io_, accept_all(), asio::detached);
    asio::co_spawn(io_, tick_all(), asio::detached);
    if (options_.ends) asio::co_spawn(io_, give_notice(), asio::detached);
    if (options_.pulse.count() > 0 && options_.alive) asio::co_spawn(io_, say_alive(), asio::detached);
    if (ready) asio::post(io_, ready);
    if (options_.living)
      options_.living->follow([this](std::shared_ptr<const Catalogue> now) {
        asio::post(io_, [this, now = std::move(now), how = options_.living->how()] {
          sessions_.set_catalogue(now, how, Steady::now());
          wake();
        });
      });
    for (;;) {
      try {
        io_.run();
        return;
      } catch (const Error&) {
        throw;  // from `ready`: the server could not be announced
      } catch (const std::exception&) {
        // One handler failed; the others go on.
      }
    }
  }

  void stop(const std::string& reason) {
    asio::post(io_, [this, reason] { shut_down(reason); });
  }

 private:
  // On an engine thread.
  void arrive(EngineEvent event) {
    asio::post(io_, [this, event = std::move(event)] {
      sessions_.on_event(event, Steady::now());
      wake();
    });
  }

  // What is due may have changed.
  void wake() { tick_.cancel(); }

  asio::awaitable<void> tick_all() {
    while (!stopping_) {
      const auto now = Steady::now();
      auto next = now + std::chrono::seconds(1);
      try {
        next = sessions_.tick(now);
      } catch (const std::exception&) {
        // Out of memory for one session's frame: the clock must not stop for the others.
      }
      if (connections_.places.taken() > 0) last_connection_ = now;
      if (options_.idle_timeout.count() > 0 && now - last_connection_ >= options_.idle_timeout) shut_down("nobody is connected");
      boost::system::error_code error;
      tick_.expires_at(next);
      co_await tick_.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
  }

  asio::awaitable<void> accept_all() {
    while (!stopping_) {
      boost::system::error_code error;
      tcp::socket socket(io_);
      co_await acceptor_.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
      if (stopping_) co_return;
      if (error) {
        // Out of descriptors, most likely: the connections that are open go on, and one of them will end.
        asio::steady_timer pause(io_, std::chrono::milliseconds(100));
        co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
        continue;
      }
      if (!connections_.places.make_room()) {
        turn_away(socket);
        continue;
      }
      try {
        std::string address = address_of(socket);
        asio::co_spawn(io_,
                       tls_ ? tls_->serve(std::move(socket), std::move(address), connections_)
                            : serve_connection(std::move(socket), std::move(address), connections_),
                       asio::detached);
      } catch (const std::exception&) {
        // No memory for this one: it is closed, and the next is accepted.
      }
    }
  }

  // A process that is to be ended at a known time says so, more urgently as it comes near. Whoever is late to be told of ten
  // minutes is told at once how many are left.
  asio::awaitable<void> give_notice() {
    for (std::size_t i = 0; i < kNotices.size(); ++i) {
      const auto left = *options_.ends - std::chrono::system_clock::now();
      if (i + 1 < kNotices.size() && left <= kNotices[i + 1]) continue;
      if (left <= std::chrono::seconds(0)) co_return;
      boost::system::error_code error;
      notice_.expires_after(std::chrono::duration_cast<Steady::duration>(left - kNotices[i]));
      co_await notice_.async_wait(asio::redirect_error(asio::use_awaitable, error));
      if (stopping_) co_return;
      sessions_.announce_end("the time of the server's job is over",
                             std::chrono::duration_cast<std::chrono::milliseconds>(options_.ends->time_since_epoch()).count());
    }
  }

  // Also while it ends: whoever listens for a pulse kills what has none.
  asio::awaitable<void> say_alive() {
    for (;;) {
      options_.alive();
      boost::system::error_code error;
      pulse_.expires_after(options_.pulse);
      co_await pulse_.async_wait(asio::redirect_error(asio::use_awaitable, error));
      if (error) co_return;
    }
  }

  void shut_down(const std::string& reason) {
    if (stopping_) return;
    stopping_ = true;
    if (options_.ending) options_.ending(reason);
    boost::system::error_code ignored;
    acceptor_.close(ignored);
    wake();
    notice_.cancel();
    site_.end(reason);
    sessions_.shut_down(reason, Server::kGoodbye);
    asio::co_spawn(io_, end_soon(), asio::detached);
  }

  asio::awaitable<void> end_soon() {
    const auto deadline = Steady::now() + Server::kGoodbye;
    while (Steady::now() + Server::kGoodbye / 2 < deadline && sessions_.viewer_count() > 0) {
      boost::system::error_code error;
      asio::steady_timer pause(io_, std::chrono::milliseconds(20));
      co_await pause.async_wait(asio::redirect_error(asio::use_awaitable, error));
    }
    sessions_.flush_journal(std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Steady::now()));
    io_.stop();
  }

  const ServerOptions options_;
  std::string public_host_;
  Connections connections_;             // outlives io_, whose coroutines still refer to it when they are destroyed
  const std::unique_ptr<TlsGate> tls_;  // null: plain
  asio::io_context io_;
  tcp::acceptor acceptor_;
  const unsigned short port_;
  const SiteOptions site_options_;
  const std::unique_ptr<FrameEngine> engine_;
  Sessions sessions_;
  Site site_;
  asio::steady_timer tick_, notice_, pulse_;
  bool stopping_ = false;
  Steady::time_point last_connection_ = Steady::now();
};

Server::Server(ServerOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Server::~Server() = default;
unsigned short Server::port() const { return impl_->port(); }
std::string Server::url() const { return impl_->url(); }
const FrameEngine& Server::engine() const { return impl_->engine(); }
const Catalogue& Server::catalogue() const { return impl_->catalogue(); }
void Server::run(bool signals, const std::function<void()>& ready) { impl_->run(signals, ready); }
void Server::stop(const std::string& reason) { impl_->stop(reason); }

}  // namespace isostrata
