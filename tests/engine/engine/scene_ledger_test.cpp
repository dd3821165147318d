#include "engine/engine/scene_ledger.h"

#include <gtest/gtest.h>

namespace isostrata {
namespace {

const auto kAll = [](SessionKey) { return true; };

TEST(SceneLedger, TheLongestUnseenGoFirstAndNoMoreThanMust) {
  SceneLedger ledger;
  for (SessionKey s = 1; s <= 4; ++s) {
    ledger.see(s);
    ledger.hold(s, 100);
  }
  ledger.see(1);
  EXPECT_EQ(ledger.bytes(), 400u);
  EXPECT_EQ(ledger.too_many(400, kAll), std::vector<SessionKey>{});
  EXPECT_EQ(ledger.too_many(250, kAll), (std::vector<SessionKey>{2, 3}));
}

TEST(SceneLedger, ThoseThatNobodyHasEverSeenGoFirstAndAllOfThem) {
  SceneLedger ledger;
  ledger.see(2);
  for (SessionKey s = 1; s <= 4; ++s) ledger.hold(s, 100);
  EXPECT_EQ(ledger.too_many(100, kAll), (std::vector<SessionKey>{1, 3, 4}));
}

TEST(SceneLedger, WhatIsInUseStaysAndWhatHoldsNothingIsNotNamed) {
  SceneLedger ledger;
  for (SessionKey s = 1; s <= 3; ++s) {
    ledger.see(s);
    ledger.hold(s, 100);
  }
  ledger.hold(2, 0);
  EXPECT_EQ(ledger.too_many(0, [](SessionKey s) { return s != 1; }), std::vector<SessionKey>{3});
}

TEST(SceneLedger, AnotherSceneReplacesTheOneBeforeAndASessionThatEndsHoldsNothing) {
  SceneLedger ledger;
  ledger.hold(1, 100);
  ledger.hold(1, 30);
  ledger.hold(2, 5);
  EXPECT_EQ(ledger.bytes(), 35u);
  ledger.forget(1);
  ledger.forget(7);
  EXPECT_EQ(ledger.bytes(), 5u);
  EXPECT_EQ(ledger.bytes_of(1), 0u);
}

}  // namespace
}  // namespace isostrata
