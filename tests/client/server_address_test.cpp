// A server's printed URL, taken apart.
#include "source/server_address.h"

#include <gtest/gtest.h>

#include <string>

namespace isostrata::client {
namespace {

ServerAddress parsed(const std::string& url, const std::string& token = "") {
  Options options;
  options.url = url;
  options.token = token;
  return parse_address(options);
}

struct Example {
  const char *url, *host, *connect_to, *port, *base_path, *token;
};

TEST(ServerAddress, IsTakenApartAsItIsPrinted) {
  for (const Example& e : {
           Example{"http://127.0.0.1:8080/?token=abc_-1", "127.0.0.1", "127.0.0.1", "8080", "/", "abc_-1"},
           Example{"http://host", "host", "host", "80", "/", ""},
           Example{"https://host", "host", "host", "443", "/", ""},
           Example{"https://host/prefix?x=1&token=a%2Bb%20c&y", "host", "host", "443", "/prefix/", "a+b c"},
           Example{"http://host:1?token=t#token=u", "host", "host", "1", "/", "t"},
           Example{"http://host/a/b/#part", "host", "host", "80", "/a/b/", ""},
           Example{"http://[::1]:65535/?token=t", "[::1]", "::1", "65535", "/", "t"},
           Example{"https://[fe80::2]", "[fe80::2]", "fe80::2", "443", "/", ""},
       }) {
    const ServerAddress a = parsed(e.url);
    EXPECT_EQ(a.tls, std::string(e.url).starts_with("https")) << e.url;
    EXPECT_EQ(a.host, e.host) << e.url;
    EXPECT_EQ(a.connect_to, e.connect_to) << e.url;
    EXPECT_EQ(a.port, e.port) << e.url;
    EXPECT_EQ(a.base_path, e.base_path) << e.url;
    EXPECT_EQ(a.token, e.token) << e.url;
  }
}

TEST(ServerAddress, TheTokenInTheAddressComesFirst) {
  EXPECT_EQ(parsed("http://h/", "apart").token, "apart");
  EXPECT_EQ(parsed("http://h/?token=within", "apart").token, "within");
}

TEST(ServerAddress, WhatIsNoneIsRefusedWithoutItsToken) {
  for (const char* url : {"",
                          "nonsense",
                          "ftp://x/",
                          "HTTP//x",
                          "http:/x",
                          "http://",
                          "http:///p",
                          "http://:80/",
                          "http://h:port/",
                          "http://h:/",
                          "http://h:65536/",
                          "http://h:-1/",
                          "http://[::1/",
                          "http://[]/",
                          "http://[::1]x/",
                          "http://a b/",
                          "http://h/\n",
                          "http://u@h/",
                          "http://h\x80/",
                          "http://h/?token=secret%",
                          "http://h/?token=secret%2",
                          "http://h/?token=secret%zz"}) {
    try {
      parsed(url);
      ADD_FAILURE() << "taken: " << url;
    } catch (const ClientError& error) {
      EXPECT_EQ(error.code(), "bad_url");
      EXPECT_EQ(std::string(error.what()).find("secret"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace isostrata::client
