// What an HTTP answer says, taken out of its bytes.
#pragma once

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

namespace isostrata {

/// Empty if it has no header of that name.
inline std::string header_of(const std::string& response, const std::string& name) {
  const auto at = response.find("\r\n" + name + ": ");
  if (at == std::string::npos) return {};
  const auto begin = at + name.size() + 4;
  return response.substr(begin, response.find('\r', begin) - begin);
}

/// Empty if the answer has no end of its head.
inline std::string text_of(const std::string& response) {
  const auto at = response.find("\r\n\r\n");
  return at == std::string::npos ? "" : response.substr(at + 4);
}

/// Null and a failure if it is not JSON.
inline boost::json::value body_of(const std::string& response) {
  boost::system::error_code error;
  boost::json::value value = boost::json::parse(text_of(response), error);
  EXPECT_FALSE(error) << response;
  return value;
}

}  // namespace isostrata
