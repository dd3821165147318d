// A cycle of intervals as a viewer sees it: the server's clock, the viewer's pace.
#include <gtest/gtest.h>

#include <set>

#include "net/running_server.h"

namespace isostrata {
namespace {

using client::Client;

v1::ClientMessage cycled() {
  v1::ClientMessage message;
  message.mutable_set_appearance()->set_mode(v1::RENDER_MODE_CYCLED);
  return message;
}
v1::ClientMessage play(bool playing, double seconds) {
  v1::ClientMessage message;
  message.mutable_set_cycle()->set_playing(playing);
  message.mutable_set_cycle()->set_seconds(seconds);
  return message;
}

TEST(Cycle, PlaysByItselfAndStandsStillWhenPaused) {
  RunningServer server;
  Client client(server.client_options());
  client.open_dataset("torus-12");
  ASSERT_GE(client.state().intervals_size(), 2);
  client.send(play(true, 1.0 / 3));
  client.send(cycled());
  std::set<double> phases;
  std::set<std::uint64_t> frames;
  for (int i = 0; i < 400 && (phases.size() < static_cast<std::size_t>(client.state().intervals_size()) || frames.size() < 3);
       ++i)
    if (const auto message = client.receive(std::chrono::milliseconds(50))) {
      if (message->has_frame()) frames.insert(message->frame().revision());
      if (client.state().mode() == v1::RENDER_MODE_CYCLED) phases.insert(client.state().cycle().phase());
    }
  EXPECT_EQ(phases.size(), static_cast<std::size_t>(client.state().intervals_size()));
  EXPECT_GE(frames.size(), 3u);

  client.send(play(false, 1.0 / 3));
  for (int i = 0; i < 100 && client.state().cycle().playing(); ++i) client.receive(std::chrono::milliseconds(50));
  ASSERT_FALSE(client.state().cycle().playing());
  const auto revision = client.state().revision();
  for (int i = 0; i < 14; ++i) client.receive(std::chrono::milliseconds(50));
  EXPECT_EQ(client.state().revision(), revision);
}

}  // namespace
}  // namespace isostrata
