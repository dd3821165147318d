// A series over REST: what is known of its ranges, all of them if that is asked for, and the reading as an operation.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <thread>

#include "net/running_server.h"

namespace isostrata {
namespace {

namespace json = boost::json;

class RestSeries : public ::testing::Test {
 protected:
  static ServerOptions with_series() {
    ServerOptions options;
    options.engine.catalogue = Catalogue::from_sources({"cylinder:8x8x4x6", "cylinder:96x96x48x200"});
    return options;
  }
  json::value get(const std::string& path, int status = 200) {
    const std::string response = server_.ask("GET", "/api/v1" + path);
    EXPECT_EQ(status_of(response), status) << response;
    return json::parse(response.substr(response.find("\r\n\r\n") + 4));
  }
  std::string id(std::size_t which) { return std::string(get("/datasets").at("datasets").at(which).at("id").as_string()); }

  RunningServer server_{with_series()};
};

TEST_F(RestSeries, HasTheRangesThatAreKnownOrAllOfThem) {
  const std::string path = "/datasets/" + id(0);
  EXPECT_EQ(get(path).at("missingRangeSteps"), 1);  // the first view has looked at five of six
  get(path + "?ranges=some", 400);
  EXPECT_EQ(get(path + "/arrays?ranges=all").at("arrays").at(0).at("stepLower").as_array().size(), 6u);
  const json::value whole = get(path);
  EXPECT_EQ(whole.at("missingRangeSteps"), 0);
  const json::object& density = whole.at("arrays").at(0).as_object();
  double lower = INFINITY, upper = -INFINITY;
  for (const json::value& value : density.at("stepLower").as_array()) lower = std::min(lower, value.to_number<double>());
  for (const json::value& value : density.at("stepUpper").as_array()) upper = std::max(upper, value.to_number<double>());
  EXPECT_EQ(density.at("lower").to_number<double>(), lower);
  EXPECT_EQ(density.at("upper").to_number<double>(), upper);
  for (const char* step : {"0", "5"}) {
    const json::value histogram = get(path + "/histogram?array=Density&bins=4&step=" + step);
    EXPECT_EQ(histogram.at("lower").to_number<double>(), lower) << step;
    EXPECT_EQ(histogram.at("upper").to_number<double>(), upper) << step;
  }
}

TEST_F(RestSeries, IsReadAsAnOperationOfTheSessionThatCanBeCancelled) {
  const std::string created = server_.ask("POST", "/api/v1/sessions", "{\"dataset\":\"" + id(1) + "\"}");
  const std::string session = "/sessions/" + std::string(json::parse(created.substr(created.find("\r\n\r\n") + 4)).at("id").as_string());
  std::string operation;
  for (int i = 0; i < 1000 && operation.empty(); ++i) {
    const json::value known = get(session + "/operations");
    for (const json::value& of : known.at("operations").as_array())
      if (of.at("kind").as_string() == "ranges") operation = std::string(of.at("id").as_string());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_FALSE(operation.empty());
  EXPECT_EQ(status_of(server_.ask("DELETE", "/api/v1" + session + "/operations/" + operation)), 202);
  const std::string events = server_.ask("GET", "/api/v1" + session + "/operations/" + operation + "/events");
  EXPECT_TRUE(has(events, "event: cancelled")) << events;
}

}  // namespace
}  // namespace isostrata
