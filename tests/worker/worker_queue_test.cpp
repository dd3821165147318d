#include "worker/worker_queue.h"

#include <gtest/gtest.h>

#include "worker/requests.h"

namespace isostrata {
namespace {

SceneUpdate scene(SessionKey session, int step) {
  SceneUpdate update;
  update.session = session;
  update.scene.step = step;
  return update;
}
template <class T>
const T* as(const ToWorker& message) {
  const auto* request = std::get_if<EngineRequest>(&message);
  return request ? std::get_if<T>(request) : nullptr;
}

TEST(WorkerQueue, ASceneReplacesOneOfItsSessionThatWaits) {
  WorkerQueue queue;
  for (int step = 0; step < 100; ++step)
    for (const SessionKey session : {1, 2}) EXPECT_FALSE(queue.put(scene(session, step)));
  for (const SessionKey session : {1, 2}) {
    const ToWorker first = queue.take();
    ASSERT_NE(as<SceneUpdate>(first), nullptr);
    EXPECT_EQ(as<SceneUpdate>(first)->session, session);
    EXPECT_EQ(as<SceneUpdate>(first)->scene.step, 99);
  }
  EXPECT_TRUE(queue.empty());
}

TEST(WorkerQueue, WhatEndsARequestThatWaitsTakesItAway) {
  WorkerQueue queue;
  queue.put(frame(1, 10));
  queue.put(frame(1, 11));
  const auto answer = queue.put(CancelRequest{1, 0, 10});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->request, 10u);
  EXPECT_EQ(answer->code, ErrorCode::cancelled);
  EXPECT_FALSE(queue.put(ForgetFrame{1, 11}));
  EXPECT_TRUE(queue.empty());
  EXPECT_FALSE(queue.put(CancelRequest{1, 0, 12})) << "the worker has that one";
  EXPECT_NE(as<CancelRequest>(queue.take()), nullptr);
}

TEST(WorkerQueue, RefusesWhatWouldBeAnsweredOnceItIsFull) {
  WorkerQueue queue;
  for (RequestId number = 1; number <= WorkerQueue::kMost; ++number) ASSERT_FALSE(queue.put(frame(1, number)));
  const auto answer = queue.put(frame(1, WorkerQueue::kMost + 1));
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->code, ErrorCode::unavailable);
  EXPECT_FALSE(queue.put(scene(1, 0))) << "nobody is told of that one";
  queue.begin({});
  EXPECT_TRUE(std::holds_alternative<WorkerSetup>(queue.take()));
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace isostrata
