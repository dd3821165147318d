// Commands that answer in JSON.
#pragma once

#include <gtest/gtest.h>

#include <boost/json.hpp>
#include <string>

#include "support/run_isostrata.h"

namespace isostrata::testing {

/// What the program prints; null and a failure if it does not exit with 0.
inline boost::json::value json_of(const std::string& arguments, const std::string& program = "isostrata") {
  const CommandResult result = run_program(program, arguments + " --json");
  EXPECT_EQ(result.status, 0) << arguments << ": " << result.err;
  return result.status == 0 ? boost::json::parse(result.out) : boost::json::value();
}

inline double number(const boost::json::value& value) { return value.to_number<double>(); }

inline boost::json::value extract_json(const std::string& arguments) { return json_of("extract " + arguments); }

/// Of all intervals that `extract` tells.
inline double signed_volume(const boost::json::value& document) {
  double sum = 0;
  for (const auto& interval : document.at("intervals").as_array()) sum += number(interval.at("signed_volume"));
  return sum;
}

}  // namespace isostrata::testing
