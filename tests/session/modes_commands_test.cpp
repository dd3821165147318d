// The commands of the paper's modes: surfaces, cycles, smears, transfer functions.
#include <gtest/gtest.h>

#include "session/commands/apply_command.h"
#include "session/wire/limits.h"
#include "session/wire/wire.h"
#include "support/client_messages.h"
#include "support/fin_facts.h"

namespace isostrata {
namespace {

class ModesCommands : public ::testing::Test {
 protected:
  ModesCommands() {
    facts_.id = facts_.name = "fin";
    facts_.bounds.include({-1, -1, -1});
    facts_.bounds.include({1, 2, 3});
    facts_.arrays = {{"Density", "point", "float32", 1, 0, 8, 0}, {"Energy", "point", "float64", 1, -100, 300, 0}};
    facts_.first_view = first_view_of("Density", {{0, 2}, {2, 4}, {4, 8}}, facts_.bounds);
    facts_.times = {0, 1, 2};
    open_in_scene(state_, facts_);
  }
  CommandOutcome apply(const std::string& json) { return apply_command(state_, message_of(json), {&facts_}); }
  void expect_refused(const std::string& json, const std::string& code, const std::string& field) {
    const std::string before = to_wire(state_.scene).SerializeAsString();
    const CommandOutcome outcome = apply(json);
    ASSERT_TRUE(outcome.error) << json;
    EXPECT_EQ(outcome.error->code(), code) << json << ": " << outcome.error->message();
    EXPECT_EQ(outcome.error->field(), field) << json << ": " << outcome.error->message();
    EXPECT_EQ(to_wire(state_.scene).SerializeAsString(), before) << json;
  }

  DatasetFacts facts_;
  SceneState state_;
};

TEST_F(ModesCommands, ASurfaceIsPatchedAsAWholeAndAbsentNumbersHaveTheirDefaults) {
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":2,"surface":{"upper":true,"silhouette":0.5,"color":{"r":1},"texture":"stripes",
                         "textureRepeat":12}}})")
                   .error);
  SurfaceStyle expected;
  expected.upper = expected.own_color = true;
  expected.color = {1, 0, 0};
  expected.silhouette = 0.5;
  expected.texture = "stripes";
  expected.texture_repeat = 12;
  EXPECT_EQ(state_.scene.intervals[1].surface, expected);
  EXPECT_EQ(state_.scene.intervals[0].surface, SurfaceStyle{});
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":2,"surface":{}}})").error);
  EXPECT_FALSE(state_.scene.intervals[1].surface.drawn());
}

TEST_F(ModesCommands, AnOpacityThatRunsComesAndGoes) {
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":1,"opacityUpper":0.75,"ownRange":true,"colorMap":"#ff0000-#0000ff"}})").error);
  EXPECT_EQ(state_.scene.intervals[0].opacity_upper, 0.75);
  EXPECT_TRUE(state_.scene.intervals[0].own_range);
  EXPECT_EQ(state_.scene.intervals[0].color_map, "#ff0000-#0000ff");
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":1,"clearOpacityUpper":true}})").error);
  EXPECT_FALSE(state_.scene.intervals[0].opacity_upper);
}

TEST_F(ModesCommands, ATransferFunctionReplacesTheIntervalsByOneThatKeepsItsPoints) {
  const auto newest = state_.last_interval_id;
  ASSERT_FALSE(apply(R"({"selectArrays":{"colorBy":"Energy"}})").error);
  ASSERT_FALSE(apply(R"({"setTransferFunction":{"points":[{"value":1,"color":{"r":1},"opacity":0},
                         {"value":2,"color":{"b":1},"opacity":0.5},{"value":5,"color":{"b":1},"opacity":0.5}]}})")
                   .error);
  ASSERT_EQ(state_.scene.intervals.size(), 1u);
  const SceneInterval& interval = state_.scene.intervals[0];
  EXPECT_EQ(interval.id, newest + 1);
  EXPECT_EQ(interval.lower, 1);
  EXPECT_EQ(interval.upper, 5);
  EXPECT_EQ(interval.transfer, (std::vector<TransferPoint>{{1, {1, 0, 0}, 0}, {2, {0, 0, 1}, 0.5}, {5, {0, 0, 1}, 0.5}}));
  EXPECT_EQ(state_.scene.color_by, "") << "colours follow the array";
}

constexpr const char* kTwoPoints = R"("transferFunction":{"points":[{"value":1,"color":{"r":1},"opacity":0.25},
                                      {"value":3,"color":{"b":1},"opacity":0.5}]})";

TEST_F(ModesCommands, AnIntervalsTransferFunctionBringsItsEndsAndMovesWithThem) {
  ASSERT_FALSE(apply(R"({"selectArrays":{"colorBy":"Energy"}})").error);
  const SceneInterval before = state_.scene.intervals[1];
  ASSERT_FALSE(apply(std::string(R"({"patchInterval":{"id":2,"lower":7,"upper":8,)") + kTwoPoints + "}}").error);
  const auto interval = [&]() -> const SceneInterval& { return state_.scene.intervals[1]; };  // another one after each command
  EXPECT_EQ(interval().lower, 1);
  EXPECT_EQ(interval().upper, 3);
  EXPECT_EQ(state_.scene.color_by, "");
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":2,"upper":5}})").error);
  EXPECT_EQ(interval().transfer, (std::vector<TransferPoint>{{1, {1, 0, 0}, 0.25}, {5, {0, 0, 1}, 0.5}}));
  ASSERT_FALSE(apply(R"({"selectArrays":{"array":"Energy"}})").error);  // [0, 8] is then [-100, 300]
  EXPECT_EQ(interval().transfer.front().value, -50);
  EXPECT_EQ(interval().transfer.back().value, 150);
  EXPECT_EQ(state_.scene.color_by, "");
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":2,"transferFunction":{}}})").error);
  EXPECT_TRUE(interval().transfer.empty());
  EXPECT_EQ(interval().color, before.color);
  EXPECT_EQ(interval().opacity, before.opacity);
}

TEST_F(ModesCommands, ColoursOfAnotherArrayAndTransferFunctionsExcludeEachOther) {
  ASSERT_FALSE(apply(std::string(R"({"patchInterval":{"id":1,)") + kTwoPoints + "}}").error);
  expect_refused(R"({"selectArrays":{"colorBy":"Energy"}})", "unsupported", "color_by");
  EXPECT_FALSE(apply(R"({"selectArrays":{"colorBy":"Density"}})").error);
  ASSERT_FALSE(apply(R"({"removeInterval":{"id":1}})").error);
  EXPECT_FALSE(apply(R"({"selectArrays":{"colorBy":"Energy"}})").error);
}

TEST_F(ModesCommands, AWrongTransferFunctionNamesItsPointAndChangesNothing) {
  const auto refused = [&](const std::string& points, const char* code, const char* field) {
    expect_refused(R"({"patchInterval":{"id":1,"transferFunction":{"points":[)" + points + "]}}}", code, field);
  };
  refused(R"({"value":1,"opacity":1})", "invalid_argument", "transfer_function.points");
  refused(R"({"value":1,"opacity":1},{"value":1,"opacity":1})", "invalid_argument", "transfer_function.points");
  refused(R"({"value":2,"opacity":1},{"value":1,"opacity":1})", "invalid_argument", "transfer_function.points");
  refused(R"({"value":1},{"value":"NaN"})", "invalid_argument", "transfer_function.points[1].value");
  refused(R"({"value":1},{"value":"Infinity"})", "invalid_argument", "transfer_function.points[1].value");
  refused(R"({"value":1},{"value":2,"opacity":-0.1})", "invalid_argument", "transfer_function.points[1].opacity");
  refused(R"({"value":1,"color":{"g":2}},{"value":2})", "invalid_argument", "transfer_function.points[0].color.g");
  expect_refused(R"({"setIntervals":{"intervals":[{"transferFunction":{"points":[{"value":1}]}}]}})", "invalid_argument",
                 "intervals[0].transfer_function.points");
  // Each has few enough, all together have not.
  std::string intervals;
  for (int i = 0; i < 3; ++i) {
    std::string points;
    for (int k = 0; k < kMaxTransferPoints / 2; ++k) points += (k ? "," : "") + (R"({"value":)" + std::to_string(k) + "}");
    intervals += (i ? "," : "") + (R"({"transferFunction":{"points":[)" + points + "]}}");
  }
  expect_refused(R"({"setIntervals":{"intervals":[)" + intervals + "]}}", "too_large", "points");
  EXPECT_FALSE(apply(R"({"patchInterval":{"id":1,"transferFunction":{"points":[{"value":1},{"value":2}]}}})").error)
      << "a function may be wholly transparent for a while";
}

TEST_F(ModesCommands, WhatIsOutOfRangeNamesItsFieldAndChangesNothing) {
  expect_refused(R"({"patchInterval":{"id":1,"surface":{"opacity":2}}})", "invalid_argument", "surface.opacity");
  expect_refused(R"({"patchInterval":{"id":1,"surface":{"silhouette":"NaN"}}})", "invalid_argument", "surface.silhouette");
  expect_refused(R"({"patchInterval":{"id":1,"surface":{"shininess":0}}})", "invalid_argument", "surface.shininess");
  expect_refused(R"({"patchInterval":{"id":1,"surface":{"texture":"wallpaper"}}})", "not_found", "surface.texture");
  expect_refused(R"({"patchInterval":{"id":1,"surface":{"textureRepeat":0}}})", "invalid_argument", "surface.texture_repeat");
  expect_refused(R"({"patchInterval":{"id":1,"opacityUpper":-1}})", "invalid_argument", "opacity_upper");
  expect_refused(R"({"patchInterval":{"id":1,"colorMap":"#ff0000-blue"}})", "not_found", "color_map");
  expect_refused(R"({"setIntervals":{"intervals":[{"lower":0,"upper":1,"surface":{"specular":5}}]}})", "invalid_argument",
                 "intervals[0].surface.specular");
  expect_refused(R"({"setAppearance":{"mode":9}})", "unsupported", "mode");
  expect_refused(R"({"setCycle":{"seconds":0}})", "invalid_argument", "seconds");
  expect_refused(R"({"setCycle":{"phase":"NaN"}})", "invalid_argument", "phase");
  expect_refused(R"({"setSmear":{"smear":{"steps":[0,3]}}})", "not_found", "steps[1]");
  expect_refused(R"({"setSmear":{"smear":{"times":[0,2.25]}}})", "invalid_argument", "times[1]");
  expect_refused(R"({"setSmear":{"smear":{"times":["NaN"]}}})", "invalid_argument", "times[0]");
  expect_refused(R"({"setSmear":{"smear":{"times":[1],"steps":[1]}}})", "invalid_argument", "times");
  expect_refused(R"({"setSmear":{"smear":{"colors":[{"r":7}]}}})", "invalid_argument", "colors[0].r");
  expect_refused(R"({"selectArrays":{"texture":"none"}})", "not_found", "texture");
  expect_refused(R"({"setTransferFunction":{"points":[{"value":1,"opacity":1}]}})", "invalid_argument", "points");
  expect_refused(R"({"setTransferFunction":{"points":[{"value":1,"opacity":1},{"value":2,"opacity":3}]}})", "invalid_argument",
                 "points[1].opacity");
  std::string many;
  for (int i = 0; i <= kMaxSmearSteps; ++i) many += i ? ",0" : "0";
  expect_refused(R"({"setSmear":{"smear":{"steps":[)" + many + "]}}}", "too_large", "steps");
  many.clear();
  for (int i = 0; i < kMaxTransferPoints + 5; ++i)
    many += (i ? "," : "") + std::string(R"({"value":)") + std::to_string(i) + R"(,"opacity":1})";
  expect_refused(R"({"setTransferFunction":{"points":[)" + many + "]}}", "too_large", "points");
}

TEST_F(ModesCommands, AWholeStateComesBackAsItWas) {
  for (const char* json :
       {R"({"setAppearance":{"mode":"RENDER_MODE_SMEAR"}})",
        R"({"setSmear":{"smear":{"steps":[2,0],"colors":[{"g":1}]}}})",
        R"({"setCycle":{"seconds":0.5,"phase":1,"playing":false}})", R"({"selectArrays":{"texture":"Energy"}})",
        R"({"patchInterval":{"id":1,"opacityUpper":0.9,"ownRange":true,"surface":{"domain":true,"opacity":0.25}}})",
        R"({"patchInterval":{"id":2,"transferFunction":{"points":[{"value":1,"color":{"r":1}},{"value":3,"opacity":0.5}]}}})"})
    ASSERT_FALSE(apply(json).error) << json;
  const v1::State saved = to_wire(state_.scene);
  SceneState other;
  open_in_scene(other, facts_);
  const CommandOutcome outcome = apply_state(other, saved, {&facts_});
  ASSERT_FALSE(outcome.error) << outcome.error->message();
  EXPECT_EQ(other.scene.mode, SceneMode::smear);
  EXPECT_EQ(other.scene.smear, state_.scene.smear);
  EXPECT_EQ(other.scene.cycle, state_.scene.cycle);
  EXPECT_EQ(other.scene.texture, "Energy");
  EXPECT_EQ(other.scene.intervals[0].surface, state_.scene.intervals[0].surface);
  EXPECT_EQ(other.scene.intervals[0].opacity_upper, 0.9);
  EXPECT_TRUE(other.scene.intervals[0].own_range);
  EXPECT_EQ(other.scene.intervals[1].transfer, state_.scene.intervals[1].transfer);
  SceneState kept;
  ASSERT_FALSE(restore_state(kept, saved, state_.last_interval_id, {&facts_}));
  EXPECT_EQ(kept.scene.intervals, state_.scene.intervals);
}

TEST_F(ModesCommands, ASmearEndsWithADatasetOfOneStepAndOtherModesStay) {
  for (const char* mode : {"SMEAR", "PRIORITIZED"})
    for (const std::vector<double>& times : {std::vector<double>{0, 1}, std::vector<double>{0}}) {
      ASSERT_FALSE(apply(std::string(R"({"setAppearance":{"mode":"RENDER_MODE_)") + mode + R"("}})").error);
      const SceneMode chosen = state_.scene.mode;
      DatasetFacts other = facts_;
      other.times = times;
      open_in_scene(state_, other);
      EXPECT_EQ(state_.scene.mode, chosen == SceneMode::smear && times.size() < 2 ? SceneMode::sorted : chosen) << mode << times.size();
    }
}

TEST_F(ModesCommands, ACycleGoesRoundTheVisibleIntervals) {
  EXPECT_FALSE(advance_cycle(state_, 1)) << "another mode";
  ASSERT_FALSE(apply(R"({"setAppearance":{"mode":"RENDER_MODE_CYCLED"}})").error);
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":2,"visible":false}})").error);
  const auto revision = state_.scene.revision;
  EXPECT_TRUE(advance_cycle(state_, 1));
  EXPECT_EQ(state_.scene.cycle.phase, 1);
  EXPECT_EQ(state_.scene.revision, revision + 1);
  EXPECT_TRUE(advance_cycle(state_, 5));
  EXPECT_EQ(state_.scene.cycle.phase, 0);
  ASSERT_FALSE(apply(R"({"patchInterval":{"id":3,"visible":false}})").error);
  EXPECT_FALSE(advance_cycle(state_, 1)) << "only one is left";
}

}  // namespace
}  // namespace isostrata
