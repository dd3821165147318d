// Which TLS a server speaks, asked by OpenSSL's own client suite by suite.
#include <gtest/gtest.h>
#include <openssl/ssl.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "net/running_server.h"

namespace isostrata {
namespace {

using Context = std::unique_ptr<SSL_CTX, decltype(&SSL_CTX_free)>;

/// A client that would take anything, of these versions.
Context client_of(int least, int most) {
  Context context(SSL_CTX_new(TLS_client_method()), SSL_CTX_free);
  SSL_CTX_set_security_level(context.get(), 0);
  SSL_CTX_set_min_proto_version(context.get(), least);
  SSL_CTX_set_max_proto_version(context.get(), most);
  return context;
}

/// The suite that both agree on; empty if there is none.
std::string agreed(SSL_CTX* context, unsigned short port) {
  const int line = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(port);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(connect(line, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  const std::unique_ptr<SSL, decltype(&SSL_free)> tls(SSL_new(context), SSL_free);
  SSL_set_fd(tls.get(), line);
  const std::string suite = SSL_connect(tls.get()) == 1 ? SSL_get_cipher_name(tls.get()) : "";
  close(line);
  return suite;
}

std::vector<const SSL_CIPHER*> suites_of_tls_1_2() {
  const Context context = client_of(TLS1_2_VERSION, TLS1_2_VERSION);
  SSL_CTX_set_cipher_list(context.get(), "ALL:eNULL");
  std::vector<const SSL_CIPHER*> all;
  const STACK_OF(SSL_CIPHER)* known = SSL_CTX_get_ciphers(context.get());
  for (int i = 0; i < sk_SSL_CIPHER_num(known); ++i)
    if (std::string(SSL_CIPHER_get_version(sk_SSL_CIPHER_value(known, i))) != "TLSv1.3") all.push_back(sk_SSL_CIPHER_value(known, i));
  return all;
}

class TlsSuites : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string key = (folder_ / "key.pem").string(), certificate = (folder_ / "certificate.pem").string();
    const std::string make = "/usr/bin/openssl req -x509 -newkey " + std::string(GetParam()) + " -nodes -days 2 -subj /CN=localhost -keyout '" + key + "' -out '" +
                             certificate + "' 2>/dev/null";
    ASSERT_EQ(std::system(make.c_str()), 0);
    ServerOptions options;
    options.tls_key = key;
    options.tls_certificate = certificate;
    server_ = std::make_unique<RunningServer>(std::move(options));
  }
  const testing::TemporaryFolder folder_;
  std::unique_ptr<RunningServer> server_;
};

// Whoever keeps what passed and gets the key later cannot read it; and nothing that is sealed and encrypted apart.
TEST_P(TlsSuites, AreThoseWithForwardSecrecyAndNoOthers) {
  int taken = 0, refused_of_this_key = 0;
  for (const SSL_CIPHER* suite : suites_of_tls_1_2()) {
    const std::string name = SSL_CIPHER_get_name(suite);
    const Context context = client_of(TLS1_2_VERSION, TLS1_2_VERSION);
    ASSERT_EQ(SSL_CTX_set_cipher_list(context.get(), name.c_str()), 1) << name;
    const std::string suite_agreed = agreed(context.get(), server_->port());
    const bool good = SSL_CIPHER_get_kx_nid(suite) == NID_kx_ecdhe && SSL_CIPHER_is_aead(suite);
    EXPECT_TRUE(suite_agreed.empty() || good) << name;
    taken += !suite_agreed.empty();
    const int key = SSL_CIPHER_get_auth_nid(suite);
    const bool of_this_key = key == (std::string(GetParam()).starts_with("rsa") ? NID_auth_rsa : NID_auth_ecdsa);
    if (good && of_this_key && name.find("CCM") == std::string::npos && name.find("ARIA") == std::string::npos) {
      EXPECT_EQ(suite_agreed, name);
    }
    refused_of_this_key += of_this_key && suite_agreed.empty();
  }
  EXPECT_GE(taken, 3) << "AES of two lengths, and ChaCha20";
  EXPECT_GE(refused_of_this_key, 3) << "the client knows suites that the server could speak and does not";
}

TEST_P(TlsSuites, OlderVersionsAreRefusedAndTheNewestIsTaken) {
  for (const int version : {TLS1_VERSION, TLS1_1_VERSION}) {
    const Context old = client_of(version, version);
    SSL_CTX_set_cipher_list(old.get(), "ALL:@SECLEVEL=0");
    EXPECT_EQ(agreed(old.get(), server_->port()), "") << version;
  }
  EXPECT_TRUE(agreed(client_of(TLS1_2_VERSION, TLS1_3_VERSION).get(), server_->port()).starts_with("TLS_"));
}

INSTANTIATE_TEST_SUITE_P(Keys, TlsSuites, ::testing::Values("rsa:2048", "ec -pkeyopt ec_paramgen_curve:P-256"),
                         [](const auto& of) { return std::string(of.param).starts_with("rsa") ? "Rsa" : "Ecdsa"; });

}  // namespace
}  // namespace isostrata
