// The C++ client and isostrata-client over https and wss, with a certificate that signs itself.
#include <gtest/gtest.h>

#include <thread>

#include "clients/code_of.h"
#include "isostrata/client.h"
#include "support/served.h"

namespace isostrata::testing {
namespace {

using client::Client;
using client::ClientError;

class Tls : public ::testing::Test {
 protected:
  // For localhost and not for its address: a name that is not in it can be tried, too.
  std::vector<std::string> certified() {
    const Ended made =
        run_to_end({"/usr/bin/openssl", "req", "-x509", "-newkey", "ed25519", "-nodes", "-days", "2", "-keyout", path("key.pem"),
                    "-out", path("certificate.pem"), "-subj", "/CN=localhost", "-addext", "subjectAltName=DNS:localhost"});
    EXPECT_EQ(made.status, 0) << made.err;
    folder_.write("token", "the-same-token-in-every-life\n");
    return {"torus:12",   "--token-file",          path("token"), "--state-dir",  path("state"),
            "--tls-cert", path("certificate.pem"), "--tls-key",   path("key.pem")};
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// As the server's address says it, or by name.
  std::string by_name() const {
    std::string url = server_.url();
    return url.replace(url.find("127.0.0.1"), 9, "localhost");
  }
  client::Options trusting() const {
    client::Options options{.url = by_name(), .width = 64, .height = 48};
    options.ca_file = path("certificate.pem");
    return options;
  }

  TemporaryFolder folder_;
  Served server_{certified()};
};

TEST_F(Tls, ASelfSignedCertificateIsTrustedWhereItIsNamed) {
  SERVED_OR_SKIP(server_);
  ASSERT_EQ(server_.url().substr(0, 8), "https://");
  Client client(trusting());
  client.open_dataset("torus:12");
  client.set_intervals({client::interval(0.1, 0.3)});
  const v1::Frame frame = client.lossless_frame();
  EXPECT_EQ(client.still(64, 48), frame.payload()) << "REST goes the same way";
}

TEST_F(Tls, WhatIsNotTrustedIsRefusedWithTheReason) {
  SERVED_OR_SKIP(server_);
  client::Options stranger{.url = by_name(), .width = 0};
  try {
    Client client(stranger);
    FAIL() << "a certificate that nobody vouches for was taken";
  } catch (const ClientError& error) {
    EXPECT_EQ(error.code(), "tls");
    EXPECT_NE(std::string(error.what()).find("self-signed certificate"), std::string::npos) << error.what();
  }
  EXPECT_EQ(code_of([&] { client::http_get(stranger, "api/v1/sessions"); }), "tls");
  client::Options other_name = trusting();
  other_name.url = server_.url();
  EXPECT_EQ(code_of([&] { Client client(other_name); }), "tls") << "the certificate is of another name";
  other_name.insecure = true;
  EXPECT_EQ(code_of([&] { Client client(other_name); }), "");
  client::Options no_file = trusting();
  no_file.ca_file = path("nosuch.pem");
  EXPECT_EQ(code_of([&] { Client client(no_file); }), "bad_argument");
  client::Options plain = trusting();
  plain.url.replace(0, 5, "http");
  plain.reconnect_for = std::chrono::milliseconds(0);
  EXPECT_EQ(code_of([&] { Client client(plain); }), "connection");
}

TEST_F(Tls, ALostConnectionIsMadeAgain) {
  SERVED_OR_SKIP(server_);
  Client client(trusting());
  client.open_dataset("torus:12");
  const auto id = client.state().intervals(0).id();
  std::thread again([&] { server_.restart(); });
  for (int i = 0; i < 50; ++i) client.move_interval(id, 0.01 * i / 50, 0.7);
  again.join();
  client.move_interval(id, 0.25, 0.75);
  EXPECT_EQ(client.interval_of(id).lower(), 0.25);
  EXPECT_EQ(client.still(64, 48), client.lossless_frame().payload());
}

TEST_F(Tls, TheProgramTakesTheSameOptions) {
  SERVED_OR_SKIP(server_);
  const std::string program = Served::program("isostrata-client");
  EXPECT_EQ(run_to_end({program, by_name(), "--ca-file", path("certificate.pem"), "info"}).status, 0);
  EXPECT_EQ(run_to_end({program, server_.url(), "--insecure", "info"}).status, 0);
  const Ended refused = run_to_end({program, by_name(), "info"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.err.find("its certificate is not trusted"), std::string::npos) << refused.err;
}

}  // namespace
}  // namespace isostrata::testing
