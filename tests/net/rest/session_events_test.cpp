// What happens in a session as server-sent events, over real sockets.
#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>

#include "net/answers.h"
#include "net/rest/session_events.h"
#include "net/running_server.h"

namespace isostrata {
namespace {

namespace json = boost::json;

/// One who listens, event by event.
class Listening {
 public:
  Listening(const RunningServer& server, const std::string& session) : socket_(server.port()) {
    socket_.send("GET /api/v1/sessions/" + session + "/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer " +
                 RunningServer::kToken + "\r\n\r\n");
    while (text_.find("\r\n\r\n") == std::string::npos && read()) {
    }
    head = text_.substr(0, text_.find("\r\n\r\n"));
    text_.erase(0, head.size() + 4);
  }

  struct Event {
    std::string name;
    json::value data;
  };
  /// Its name is empty if the server has ended the connection, or nothing came in time.
  Event next() {
    std::size_t end;
    while ((end = text_.find("\n\n")) == std::string::npos)
      if (!read()) return {};
    const std::string event = text_.substr(0, end);
    text_.erase(0, end + 2);
    if (event.starts_with(":")) return next();
    const auto data = event.find("\ndata: ");
    EXPECT_TRUE(event.starts_with("event: ") && data != std::string::npos) << event;
    return {event.substr(7, data - 7), json::parse(event.substr(data + 7))};
  }
  /// The next of this name.
  Event next(const std::string& name) {
    for (;;) {
      Event event = next();
      if (event.name == name || event.name.empty()) return event;
    }
  }

  std::string head;

 private:
  bool read() {
    const std::string more = socket_.read_piece();
    text_ += more;
    return !more.empty();
  }
  RawSocket socket_;
  std::string text_;
};

class SessionEventsTest : public ::testing::Test {
 protected:
  std::string ask(const std::string& method, const std::string& path, const std::string& body = "") {
    return server_.ask(method, "/api/v1" + path, body);
  }
  std::string new_session() {
    return std::string(json::parse(text_of(ask("POST", "/sessions", R"({"dataset":"torus-12"})"))).at("id").as_string());
  }
  std::string state_of(const std::string& session) { return text_of(ask("GET", "/sessions/" + session + "/state")); }

  RunningServer server_;
};

TEST_F(SessionEventsTest, AListenerWhoMergesWhatItHearsHasTheState) {
  const std::string session = new_session(), path = "/sessions/" + session;
  Listening listening(server_, session);
  EXPECT_TRUE(has(listening.head, "200 OK")) << listening.head;
  EXPECT_TRUE(has(listening.head, "text/event-stream"));
  const auto first = listening.next();
  ASSERT_EQ(first.name, "state");
  json::object state = first.data.at("state").as_object();
  EXPECT_EQ(json::value(state), json::parse(state_of(session)));
  const auto merge_next = [&](const std::string& member) {
    const auto change = listening.next("change");
    ASSERT_EQ(change.name, "change");
    for (const auto& [name, value] : change.data.at("changed").as_object())
      if (value.is_null())
        state.erase(name);
      else
        state[name] = value;
    EXPECT_TRUE(change.data.at("changed").as_object().contains(member)) << json::serialize(change.data);
    EXPECT_LE(change.data.at("changed").as_object().size(), 3u) << "what has not changed is not told";
    EXPECT_EQ(json::value(state), json::parse(state_of(session)));
    EXPECT_EQ(std::to_string(change.data.at("revision").to_number<std::uint64_t>()), state.at("revision").as_string());
  };
  ask("PUT", path + "/view", R"({"view":"+x"})");
  merge_next("camera");
  ask("PUT", path + "/intervals", R"({"intervals":[{"lower":0.1,"upper":0.2}]})");
  merge_next("intervals");
  ask("PUT", path + "/clip-planes", R"({"clipPlanes":[{"normal":{"x":1},"offset":0.5}]})");
  merge_next("clipPlanes");
}

TEST_F(SessionEventsTest, WhoComesAndGoesAndWhatWorkBeginsAndEndsIsTold) {
  const std::string session = new_session();
  Listening listening(server_, session);
  EXPECT_EQ(listening.next("participants").data.at("participants").as_array().size(), 0u);
  {
    auto options = server_.client_options();
    options.session = session;
    options.name = "a-visitor";
    client::Client visitor(options);
    const auto came = listening.next("participants");
    ASSERT_EQ(came.data.at("participants").as_array().size(), 1u);
    EXPECT_EQ(came.data.at("participants").at(0).at("client").as_string(), "a-visitor");
    visitor.move_interval(visitor.state().intervals(0).id(), 0.25, 0.5);
    const auto moved = listening.next("change");
    EXPECT_EQ(moved.data.at("changed").at("intervals").at(0).at("lower").to_number<double>(), 0.25)
        << "a WebSocket's changes, too";
  }
  EXPECT_EQ(listening.next("participants").data.at("participants").as_array().size(), 0u);
  const auto id = json::parse(text_of(ask("POST", "/sessions/" + session + "/exports", R"({"format":"vtu"})"))).at("id");
  std::vector<std::string> statuses;
  while (statuses.empty() || statuses.back() == "running") {
    const auto event = listening.next("operation");
    ASSERT_EQ(event.name, "operation");
    if (event.data.at("id") == id) statuses.emplace_back(event.data.at("status").as_string());
  }
  EXPECT_EQ(statuses, (std::vector<std::string>{"running", "done"}));
  ask("DELETE", "/sessions/" + session);
  EXPECT_EQ(listening.next("ended").name, "ended");
  EXPECT_EQ(listening.next().name, "") << "nothing comes after it";
}

TEST_F(SessionEventsTest, WhoReadsLateReadsOneChangeForMany) {
  const std::string session = new_session();
  Listening slow(server_, session);
  ASSERT_EQ(slow.next("participants").name, "participants");
  auto options = server_.client_options();
  options.session = session;
  options.width = 0;
  client::Client mover(options);
  // Many times what 64 events and the kernel's buffers hold; nobody is cut off for it, since they are not written down.
  mover.set_intervals(std::vector<v1::Interval>(32, client::interval(0.1, 0.9)));
  const auto moved = mover.state().intervals(0).id();
  for (int i = 0; i < 1500; ++i) mover.move_interval(moved, 0.0001 * i, 0.9);
  mover.set_view("+y");
  const std::uint64_t newest = mover.state().revision();
  int changes = 0;
  for (std::uint64_t revision = 0; revision < newest; ++changes) {
    const auto change = slow.next("change");
    ASSERT_EQ(change.name, "change") << "after " << changes;
    revision = change.data.at("revision").to_number<std::uint64_t>();
  }
  EXPECT_LT(changes, 1500);
}

TEST_F(SessionEventsTest, PlacesAreBoundedAndFreeAgainWhenSomebodyGoes) {
  const std::string session = new_session();
  std::vector<std::unique_ptr<Listening>> all;
  for (std::size_t i = 0; i < SessionEvents::kMostListeners; ++i) all.push_back(std::make_unique<Listening>(server_, session));
  EXPECT_EQ(status_of(Listening(server_, session).head), 503);
  all.pop_back();
  // Who has gone is noticed when there is something to tell.
  int status = 503;
  for (int i = 0; i < 500 && status == 503; ++i) {
    ask("PUT", "/sessions/" + session + "/view", i % 2 ? R"({"view":"+x"})" : R"({"view":"+y"})");
    status = status_of(Listening(server_, session).head);
  }
  EXPECT_EQ(status, 200);
  EXPECT_EQ(status_of(Listening(server_, "0123456789abcdef").head), 404);
}

}  // namespace
}  // namespace isostrata
