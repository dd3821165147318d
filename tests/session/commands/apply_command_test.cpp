#include "session/commands/apply_command.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "session/wire/limits.h"
#include "session/wire/wire.h"
#include "support/client_messages.h"
#include "support/fin_facts.h"

namespace isostrata {
namespace {

class ApplyCommand : public ::testing::Test {
 protected:
  ApplyCommand() { open_in_scene(state_, facts_); }

  CommandOutcome apply(const std::string& json) { return apply_command(state_, message_of(json), {&facts_}); }

  DatasetFacts facts_ = fin_facts();
  SceneState state_;
};

TEST_F(ApplyCommand, OpeningShowsTheFirstViewAsItIs) {
  facts_.first_view.step = 1;
  facts_.first_view.layers[1].surface.upper = true;
  facts_.first_view.layers[1].name = "skin";
  open_in_scene(state_, facts_, 1.5);
  const Scene& scene = state_.scene;
  EXPECT_EQ(scene.array, "Density");
  EXPECT_EQ(scene.step, 1);
  ASSERT_EQ(scene.intervals.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const FirstLayer& layer = facts_.first_view.layers[i];
    EXPECT_EQ(scene.intervals[i].lower, layer.lower);
    EXPECT_EQ(scene.intervals[i].upper, layer.upper);
    EXPECT_EQ(scene.intervals[i].color, layer.color);
    EXPECT_EQ(scene.intervals[i].opacity, layer.opacity);
    EXPECT_EQ(scene.intervals[i].surface, layer.surface);
    EXPECT_EQ(scene.intervals[i].name, layer.name);
  }
  EXPECT_EQ(scene.camera, facts_.first_view.camera(1));
}

TEST_F(ApplyCommand, OfADatasetWithNothingToShowTheWholeBoxIsSeen) {
  facts_.first_view = {};
  open_in_scene(state_, facts_, 1);
  EXPECT_EQ(state_.scene.array, "Empty");
  EXPECT_TRUE(state_.scene.intervals.empty());
  EXPECT_EQ(state_.scene.camera, view_of(facts_.bounds, "reset", 1));
}

TEST_F(ApplyCommand, LayersThatReachToTheEndsReachToThoseThatBecomeKnown) {
  for (ArrayFacts& array : facts_.arrays)
    if (array.name == "Density") array.lower = -1, array.upper = 9;
  EXPECT_TRUE(show_first_layers(state_, facts_));
  EXPECT_EQ(state_.scene.intervals.front().lower, -1);
  EXPECT_EQ(state_.scene.intervals.back().upper, 9);
  EXPECT_EQ(state_.scene.intervals[1].lower, 2);
  EXPECT_FALSE(show_first_layers(state_, facts_));
}

TEST_F(ApplyCommand, WholeValuesAreOfOneArrayAtAStepAndEndWithTheArray) {
  ASSERT_FALSE(apply(R"({"selectArrays":{"values":"FIELD_VALUES_WHOLE"}})").error);
  EXPECT_EQ(state_.scene.values, FieldValues::whole);
  SceneState other;
  open_in_scene(other, facts_);
  EXPECT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.values, FieldValues::whole);
  const std::string combined = R"({"setCombination":{"terms":[{"op":"RANGE_OPERATOR_UNITE","array":"Energy","lower":0,"upper":1}]}})";
  for (const std::string& refused : {combined, std::string(R"({"setTime":{"time":0,"mode":"TIME_MODE_INTERPOLATE"}})")}) {
    const CommandOutcome outcome = apply(refused);
    ASSERT_TRUE(outcome.error) << refused;
    EXPECT_EQ(outcome.error->code(), "unsupported");
    EXPECT_EQ(outcome.error->field(), "values");
  }
  EXPECT_EQ(state_.scene.terms.size(), 0u);
  EXPECT_TRUE(apply(R"({"selectArrays":{"values":9}})").error);
  ASSERT_FALSE(apply(R"({"selectArrays":{"array":"Energy"}})").error);
  EXPECT_EQ(state_.scene.values, FieldValues::interpolated) << "another array is interpolated";
  ASSERT_FALSE(apply(R"({"selectArrays":{"array":"Density","values":"FIELD_VALUES_WHOLE"}})").error);
  EXPECT_EQ(state_.scene.values, FieldValues::whole);
  ASSERT_FALSE(apply(R"({"selectArrays":{"values":"FIELD_VALUES_INTERPOLATED"}})").error);
  ASSERT_FALSE(apply(combined).error);
  EXPECT_TRUE(apply(R"({"selectArrays":{"values":"FIELD_VALUES_WHOLE"}})").error) << "beside terms";
}

TEST(AskedDataset, IsThePartThatTheMessageAsksFor) {
  const auto id_of = [](const std::string& id, const std::string& region, const std::string& stride) {
    v1::OpenDataset wanted;
    wanted.set_id(id);
    wanted.set_region(region);
    wanted.set_stride(stride);
    std::optional<v1::Error> error;
    const std::string asked = asked_dataset(wanted, error);
    return error ? "refused " + error->field() : asked;
  };
  EXPECT_EQ(id_of("fin", "", ""), "fin");
  EXPECT_EQ(id_of("fin", "0:31,:,5:", "2"), "fin@:31,:,5:*2");
  EXPECT_EQ(id_of("fin", "", "1,2,4"), "fin@:,:,:*1,2,4");
  EXPECT_EQ(id_of("fin", ":,:,:", "1"), "fin") << "of everything";
  EXPECT_EQ(id_of("fin@:9,:,:", ":3,:,:", ""), "fin@:3,:,:") << "in place of another part";
  EXPECT_EQ(id_of("fin", "3", ""), "refused region");
  EXPECT_EQ(id_of("fin", "", "0"), "refused stride");
}

TEST_F(ApplyCommand, ClipPlanesAreReplacedTogetherAndGoWithTheDataset) {
  const std::string two =
      R"({"setClipPlanes":{"clipPlanes":[{"normal":{"x":1},"offset":0.5},{"normal":{"y":-2,"z":1},"offset":-3}]}})";
  EXPECT_TRUE(apply(two).changed);
  ASSERT_EQ(state_.scene.clip_planes.size(), 2u);
  EXPECT_EQ(state_.scene.clip_planes[1].normal, (Vec3d{0, -2, 1}));
  EXPECT_EQ(state_.scene.clip_planes[1].offset, -3);
  EXPECT_FALSE(apply(two).changed);
  for (const char* wrong : {R"({"setClipPlanes":{"clipPlanes":[{"offset":1}]}})",
                            R"({"setClipPlanes":{"clipPlanes":[{"normal":{"x":1},"offset":"NaN"}]}})",
                            R"({"setClipPlanes":{"clipPlanes":[{"normal":{"x":"Infinity"}}]}})"}) {
    const CommandOutcome outcome = apply(wrong);
    ASSERT_TRUE(outcome.error) << wrong;
    EXPECT_NE(outcome.error->field().find("clip_planes[0]."), std::string::npos);
  }
  v1::ClientMessage many;
  for (int i = 0; i < 33; ++i) many.mutable_set_clip_planes()->add_clip_planes()->mutable_normal()->set_x(1);
  EXPECT_EQ(apply_command(state_, many, {&facts_}).error->code(), "too_large");
  ASSERT_EQ(state_.scene.clip_planes.size(), 2u);
  SceneState other;
  open_in_scene(other, facts_);
  EXPECT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.clip_planes, state_.scene.clip_planes);
  open_in_scene(state_, facts_);
  EXPECT_TRUE(state_.scene.clip_planes.empty());
}

TEST_F(ApplyCommand, ALayerKeepsItsNumberAndItsColourWhenAnotherIsDeletedAndANewOneTakesTheFreeOnes) {
  const auto numbers = [&] {
    std::vector<std::uint32_t> all;
    for (const SceneInterval& interval : state_.scene.intervals) all.push_back(interval.number);
    return all;
  };
  using Numbers = std::vector<std::uint32_t>;
  EXPECT_EQ(numbers(), (Numbers{1, 2, 3, 4}));
  const Rgb first = state_.scene.intervals[0].color, second = state_.scene.intervals[1].color;
  ASSERT_FALSE(apply(R"({"removeInterval":{"id":)" + std::to_string(state_.scene.intervals[0].id) + "}}").error);
  EXPECT_EQ(numbers(), (Numbers{2, 3, 4}));
  // A script that names only what it knows of them.
  std::string list;
  for (const SceneInterval& interval : state_.scene.intervals)
    list += R"({"id":)" + std::to_string(interval.id) + R"(,"lower":1,"upper":2},)";
  ASSERT_FALSE(apply(R"({"setIntervals":{"intervals":[)" + list + R"({"lower":3,"upper":4},{"lower":4,"upper":5}]}})").error);
  EXPECT_EQ(numbers(), (Numbers{2, 3, 4, 1, 5}));
  EXPECT_EQ(state_.scene.intervals[0].color, second);
  EXPECT_EQ(state_.scene.intervals[3].color, first);
  std::set<Rgb> colors;
  for (const SceneInterval& interval : state_.scene.intervals) colors.insert(interval.color);
  EXPECT_EQ(colors.size(), 5u);
  // A copy of a layer is another one.
  ASSERT_FALSE(apply(R"({"setIntervals":{"intervals":[{"lower":1,"upper":2,"number":7},{"lower":1,"upper":2,"number":7}]}})").error);
  EXPECT_EQ(numbers(), (Numbers{7, 1}));
  SceneState other;
  open_in_scene(other, facts_);
  ASSERT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.intervals[0].number, 7u);
  EXPECT_EQ(other.scene.intervals[1].number, 1u);
}

TEST_F(ApplyCommand, LightIsOffUntilSomebodyTurnsItOnAndGoesAlongWithAState) {
  EXPECT_EQ(state_.scene.light, DepthLight{});
  EXPECT_TRUE(apply(R"({"setAppearance":{"occlusion":0.75}})").changed);
  EXPECT_TRUE(apply(R"({"setAppearance":{"depthFade":0.25}})").changed);
  EXPECT_EQ(state_.scene.light, (DepthLight{0.75, 0.25}));
  EXPECT_EQ(state_.scene.body_shading, 0);
  EXPECT_TRUE(apply(R"({"setAppearance":{"bodyShading":0.5}})").changed);
  EXPECT_EQ(state_.scene.body_shading, 0.5);
  EXPECT_FALSE(apply(R"({"setAppearance":{"unitDistance":0}})").changed);
  SceneState other;
  open_in_scene(other, facts_);
  ASSERT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.light, state_.scene.light);
  EXPECT_EQ(other.scene.body_shading, 0.5);
  EXPECT_TRUE(apply(R"({"setAppearance":{"occlusion":0,"depthFade":0}})").changed);
  EXPECT_EQ(state_.scene.light, DepthLight{});
}

TEST_F(ApplyCommand, TheCameraGoesAlongWithTheScaleOfAxes) {
  const Camera before = *state_.scene.camera;
  const Vec3d looks_at = before.at, direction = normalized(before.eye - before.at);
  const double share = length(before.eye - before.at) / facts_.bounds.diagonal();
  ASSERT_TRUE(apply(R"({"setAppearance":{"axisScale":{"x":1,"y":3,"z":0.5}}})").changed);
  const Vec3d factors{1, 3, 0.5};
  const Camera& camera = *state_.scene.camera;
  EXPECT_EQ(state_.scene.axis_scale, factors);
  EXPECT_NEAR(length(camera.at - scaled(looks_at, factors)), 0, 1e-12);
  EXPECT_NEAR(length(normalized(camera.eye - camera.at) - direction), 0, 1e-12);
  EXPECT_NEAR(length(camera.eye - camera.at) / scaled(facts_.bounds, factors).diagonal(), share, 1e-12);
  const Camera of_this = camera;

  ASSERT_FALSE(apply(R"({"setView":{"view":"+x"}})").error);
  EXPECT_EQ(*state_.scene.camera, view_of(scaled(facts_.bounds, factors), "+x", 1));
  ASSERT_FALSE(apply(R"({"setView":{"view":"reset"}})").error);
  EXPECT_NEAR(length(state_.scene.camera->eye - of_this.eye), 0, 1e-9) << "as if it had been scaled from the beginning";

  SceneState other;
  open_in_scene(other, facts_);
  ASSERT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.axis_scale, factors);
  EXPECT_EQ(other.scene.camera, state_.scene.camera);
  v1::State of_before = to_wire(state_.scene);  // of the time without
  of_before.clear_axis_scale();
  ASSERT_FALSE(apply_state(other, of_before, {&facts_}).error);
  EXPECT_EQ(other.scene.axis_scale, kUnscaled);
  EXPECT_EQ(other.scene.camera, state_.scene.camera) << "the camera that it says";
}

TEST_F(ApplyCommand, AFirstViewMayScaleAxes) {
  facts_.first_view.axis_scale = {1, 1, 0.01};
  open_in_scene(state_, facts_, 1);
  EXPECT_EQ(state_.scene.axis_scale, (Vec3d{1, 1, 0.01}));
  EXPECT_EQ(*state_.scene.camera, facts_.first_view.camera(1));
  ASSERT_FALSE(apply(R"({"setAppearance":{"axisScale":{"x":1,"y":1,"z":1}}})").error);
  ASSERT_FALSE(apply(R"({"setView":{"view":"reset"}})").error);
  EXPECT_EQ(state_.scene.axis_scale, kUnscaled) << "a view does not change it";
}

TEST_F(ApplyCommand, TheRangeOfColoursIsTheStepsAllStepsOrOnesOwn) {
  EXPECT_EQ(state_.scene.color_range, ColorRange{});
  EXPECT_TRUE(apply(R"({"setAppearance":{"colorRange":{"span":"COLOR_SPAN_ALL_STEPS","log":true}}})").changed);
  EXPECT_EQ(state_.scene.color_range, (ColorRange{ColorSpan::all_steps, 0, 1, true}));
  EXPECT_TRUE(apply(R"({"setAppearance":{"colorRange":{"span":"COLOR_SPAN_OWN","lower":0.5,"upper":4}}})").changed);
  EXPECT_EQ(state_.scene.color_range, (ColorRange{ColorSpan::own, 0.5, 4, false}));
  EXPECT_FALSE(apply(R"({"setAppearance":{"unitDistance":0}})").changed);
  for (const auto& [range, field] : {std::pair<std::string, std::string>{R"("span":"COLOR_SPAN_OWN","lower":4,"upper":4)", "color_range.lower"},
                                     {R"("span":"COLOR_SPAN_OWN","lower":"NaN","upper":4)", "color_range.lower"},
                                     {R"("span":"COLOR_SPAN_OWN","lower":1,"upper":"Infinity")", "color_range.upper"},
                                     {R"("span":"COLOR_SPAN_OWN","lower":0,"upper":4,"log":true)", "color_range.lower"},
                                     {R"("span":77)", "color_range.span"}}) {
    const CommandOutcome outcome = apply(R"({"setAppearance":{"colorRange":{)" + range + "}}}");
    ASSERT_TRUE(outcome.error) << range;
    EXPECT_EQ(outcome.error->field(), field) << range;
  }
  SceneState other;
  open_in_scene(other, facts_);
  ASSERT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.color_range, state_.scene.color_range);
  // Numbers of one array mean nothing for another one.
  EXPECT_FALSE(apply(R"({"selectArrays":{"array":"Density"}})").changed);
  EXPECT_EQ(state_.scene.color_range.span, ColorSpan::own);
  EXPECT_TRUE(apply(R"({"selectArrays":{"colorBy":"Energy"}})").changed);
  EXPECT_EQ(state_.scene.color_range, ColorRange{});
}

TEST_F(ApplyCommand, ACycleFlashesThreeTimesASecondAtMostAndAFasterOneThatWasKeptIsSlowedDown) {
  for (const double seconds : {0.02, 0.1, 0.33}) {
    const CommandOutcome outcome = apply(R"({"setCycle":{"seconds":)" + std::to_string(seconds) + "}}");
    ASSERT_TRUE(outcome.error) << seconds;
    EXPECT_EQ(outcome.error->field(), "seconds");
  }
  EXPECT_TRUE(apply(R"({"setCycle":{"seconds":0.34}})").changed);
  v1::State kept = to_wire(state_.scene);
  kept.mutable_cycle()->set_seconds(0.05);
  SceneState restored;
  ASSERT_FALSE(restore_state(restored, kept, 0, {&facts_}));
  EXPECT_EQ(restored.scene.cycle.seconds, kMinCycleSeconds);
}

TEST_F(ApplyCommand, AnnotationsProjectionAndNamesComeBackFromTheWire) {
  EXPECT_TRUE(apply(R"({"setAnnotations":{"annotations":{"box":true,"legend":true}}})").changed);
  const std::uint32_t id = state_.scene.intervals[0].id;
  EXPECT_TRUE(apply(R"({"patchInterval":{"id":)" + std::to_string(id) + R"(,"name":"shock"}})").changed);
  EXPECT_TRUE(apply(R"({"setCamera":{"camera":{"eye":{"z":9},"at":{},"up":{"y":1},"fovDeg":30,"orthographic":true}}})").changed);
  SceneState other;
  open_in_scene(other, facts_);
  EXPECT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.annotations, (Annotations{false, true, true}));
  EXPECT_EQ(other.scene.intervals[0].name, "shock");
  EXPECT_TRUE(other.scene.camera->orthographic);
  EXPECT_TRUE(apply(R"({"setAnnotations":{}})").changed);
  EXPECT_FALSE(state_.scene.annotations.any());
}

TEST_F(ApplyCommand, AViewShowsTheWholeDatasetInANarrowViewportAndKeepsTheProjection) {
  v1::ClientMessage message = message_of(R"({"setView":{"view":"+x"}})");
  state_.scene.camera->orthographic = true;
  EXPECT_FALSE(apply_command(state_, message, {&facts_, 0.25}).error);
  EXPECT_EQ(*state_.scene.camera, view_of(facts_.bounds, "+x", 0.25, true));
}

TEST_F(ApplyCommand, AnAcceptedChangeMakesOneRevisionAndNoChangeMakesNone) {
  const auto before = state_.scene.revision;
  EXPECT_TRUE(apply(R"({"patchInterval":{"id":1,"lower":0.5}})").changed);
  EXPECT_EQ(state_.scene.revision, before + 1);
  EXPECT_EQ(state_.scene.intervals[0].lower, 0.5);
  const auto again = apply(R"({"patchInterval":{"id":1,"lower":0.5}})");
  EXPECT_FALSE(again.error || again.changed);
  EXPECT_EQ(state_.scene.revision, before + 1);
}

struct Refusal {
  const char* json;
  const char* code;
  const char* field;
};

class Refusals : public ApplyCommand, public ::testing::WithParamInterface<Refusal> {};

TEST_P(Refusals, NameCodeAndFieldAndChangeNothing) {
  const v1::State before = to_wire(state_.scene);
  const CommandOutcome outcome = apply(GetParam().json);
  ASSERT_TRUE(outcome.error) << GetParam().json;
  EXPECT_EQ(outcome.error->code(), GetParam().code) << outcome.error->message();
  EXPECT_EQ(outcome.error->field(), GetParam().field) << outcome.error->message();
  EXPECT_FALSE(outcome.error->message().empty());
  EXPECT_FALSE(outcome.changed);
  EXPECT_EQ(to_wire(state_.scene).SerializeAsString(), before.SerializeAsString());
}

INSTANTIATE_TEST_SUITE_P(
    Table, Refusals,
    ::testing::Values(
        Refusal{R"({"patchInterval":{"id":1,"lower":3,"upper":3}})", "invalid_argument", "lower"},
        Refusal{R"({"patchInterval":{"id":1,"lower":5}})", "invalid_argument", "lower"},
        Refusal{R"({"patchInterval":{"id":1,"upper":"NaN"}})", "invalid_argument", "upper"},
        Refusal{R"({"patchInterval":{"id":1,"lower":"Infinity"}})", "invalid_argument", "lower"},
        Refusal{R"({"patchInterval":{"id":1,"opacity":1.01}})", "invalid_argument", "opacity"},
        Refusal{R"({"patchInterval":{"id":1,"opacity":"NaN"}})", "invalid_argument", "opacity"},
        Refusal{R"({"patchInterval":{"id":1,"color":{"r":2}}})", "invalid_argument", "color.r"},
        Refusal{R"({"patchInterval":{"id":1,"colorMap":"nosuch"}})", "not_found", "color_map"},
        Refusal{R"({"patchInterval":{"id":99,"lower":1}})", "not_found", "id"},
        Refusal{R"({"removeInterval":{"id":99}})", "not_found", "id"},
        Refusal{R"({"setIntervals":{"intervals":[{"lower":1,"upper":2},{"lower":2,"upper":1}]}})", "invalid_argument",
                "intervals[1].lower"},
        Refusal{R"({"setIntervals":{"intervals":[{"id":77,"lower":1,"upper":2}]}})", "not_found", "intervals[0].id"},
        Refusal{R"({"setIntervals":{"intervals":[{"id":1,"lower":1,"upper":2},{"id":1,"lower":3,"upper":4}]}})",
                "invalid_argument", "intervals[1].id"},
        Refusal{R"({"reorderPriorities":{"ids":[1,2,3]}})", "invalid_argument", "ids"},
        Refusal{R"({"reorderPriorities":{"ids":[1,2,3,3]}})", "invalid_argument", "ids"},
        Refusal{R"({"reorderPriorities":{"ids":[1,2,3,9]}})", "not_found", "id"},
        Refusal{R"({"selectArrays":{"array":"Nosuch"}})", "not_found", "array"},
        Refusal{R"({"selectArrays":{"colorBy":"Nosuch"}})", "not_found", "color_by"},
        Refusal{R"({"setTimeStep":{"step":3}})", "not_found", "step"},
        Refusal{R"({"setTimeStep":{"step":-1}})", "not_found", "step"},
        Refusal{R"({"setView":{"view":"sideways"}})", "invalid_argument", "view"},
        Refusal{R"({"setCamera":{}})", "invalid_argument", "camera"},
        Refusal{R"({"setCamera":{"camera":{"eye":{"x":1},"at":{"x":1},"up":{"y":1},"fovDeg":30}}})", "invalid_argument",
                "camera"},
        Refusal{R"({"setCamera":{"camera":{"eye":{"z":5},"at":{},"up":{"z":1},"fovDeg":30}}})", "invalid_argument", "camera"},
        Refusal{R"({"setCamera":{"camera":{"eye":{"z":5},"at":{},"up":{"y":1},"fovDeg":180}}})", "invalid_argument", "camera"},
        Refusal{R"({"setCamera":{"camera":{"eye":{"z":"Infinity"},"at":{},"up":{"y":1},"fovDeg":30}}})", "invalid_argument",
                "camera.eye.z"},
        Refusal{R"({"setAppearance":{"mode":9}})", "unsupported", "mode"},
        Refusal{R"({"setAppearance":{"background":{"g":-0.1}}})", "invalid_argument", "background.g"},
        Refusal{R"({"setAppearance":{"unitDistance":-1}})", "invalid_argument", "unit_distance"},
        Refusal{R"({"setAppearance":{"occlusion":1.5}})", "invalid_argument", "occlusion"},
        Refusal{R"({"setAppearance":{"occlusion":"NaN"}})", "invalid_argument", "occlusion"},
        Refusal{R"({"setAppearance":{"depthFade":-0.5}})", "invalid_argument", "depth_fade"},
        Refusal{R"({"setAppearance":{"depthFade":"Infinity"}})", "invalid_argument", "depth_fade"},
        Refusal{R"({"setAppearance":{"axisScale":{"x":1,"y":1}}})", "invalid_argument", "axis_scale"},
        Refusal{R"({"setAppearance":{"axisScale":{"x":1,"y":-1,"z":1}}})", "invalid_argument", "axis_scale"},
        Refusal{R"({"setAppearance":{"axisScale":{"x":1,"y":"NaN","z":1}}})", "invalid_argument", "axis_scale"},
        Refusal{R"({"setAppearance":{"axisScale":{"x":1,"y":1,"z":1e13}}})", "invalid_argument", "axis_scale"},
        Refusal{R"({"setAppearance":{"bodyShading":1.01}})", "invalid_argument", "body_shading"},
        Refusal{R"({"setAppearance":{"bodyShading":"NaN"}})", "invalid_argument", "body_shading"},
        Refusal{R"({"setTime":{"time":2.001}})", "invalid_argument", "time"},
        Refusal{R"({"setTime":{"time":-0.001}})", "invalid_argument", "time"},
        Refusal{R"({"setTime":{"time":"NaN"}})", "invalid_argument", "time"},
        Refusal{R"({"setTime":{"time":1,"mode":9}})", "unsupported", "mode"},
        Refusal{R"({"setCombination":{"terms":[{"array":"Energy","lower":1,"upper":2}]}})", "invalid_argument", "terms[0].op"},
        Refusal{R"({"setCombination":{"terms":[{"op":1,"array":"Nosuch","lower":1,"upper":2}]}})", "not_found", "terms[0].array"},
        Refusal{R"({"setCombination":{"terms":[{"op":1,"array":"Energy","lower":1,"upper":2},
                                               {"op":2,"array":"Energy","lower":2,"upper":2}]}})",
                "invalid_argument", "terms[1].lower"},
        Refusal{R"({"setCombination":{"terms":[{"op":2,"array":"Energy","lower":1,"upper":2,"opacity":2}]}})", "invalid_argument",
                "terms[0].opacity"},
        Refusal{R"({"setCombination":{"terms":[{"op":2,"array":"Energy","lower":1,"upper":2,"colorMap":"nosuch"}]}})",
                "not_found", "terms[0].color_map"}));

TEST_F(ApplyCommand, ATermSaysHowWhatItBringsInLooksOrLeavesItOpen) {
  ASSERT_FALSE(apply(R"({"setCombination":{"terms":[
      {"op":"RANGE_OPERATOR_SUBTRACT","array":"Energy","lower":-50,"upper":0},
      {"op":"RANGE_OPERATOR_UNITE","array":"Energy","lower":100,"upper":200,"color":{"g":1},"opacity":0.25,"priority":3,"hidden":true}]}})")
                   .error);
  const auto& terms = state_.scene.terms;
  ASSERT_EQ(terms.size(), 2u);
  EXPECT_EQ(terms[0].term, (RangeTerm{RangeOperator::subtract, "Energy", {-50, 0}}));
  EXPECT_FALSE(terms[0].color || terms[0].opacity || terms[0].priority);
  EXPECT_TRUE(terms[0].visible);
  EXPECT_EQ(terms[1].term.op, RangeOperator::unite);
  EXPECT_EQ(terms[1].color, (Rgb{0, 1, 0}));
  EXPECT_EQ(terms[1].opacity, 0.25);
  EXPECT_EQ(terms[1].priority, 3);
  EXPECT_FALSE(terms[1].visible);
  ASSERT_FALSE(apply(R"({"setCombination":{}})").error);
  EXPECT_TRUE(state_.scene.terms.empty());
}

TEST_F(ApplyCommand, TakesAsManyTermsAsItSaysAndNotOneMore) {
  v1::ClientMessage message;
  for (int i = 0; i < kMaxTerms; ++i) {
    auto* term = message.mutable_set_combination()->add_terms();
    term->set_op(v1::RANGE_OPERATOR_INTERSECT);
    term->set_array("Energy");
    term->set_upper(1 + i);
  }
  EXPECT_FALSE(apply_command(state_, message, {&facts_}).error);
  *message.mutable_set_combination()->add_terms() = message.set_combination().terms(0);
  EXPECT_EQ(apply_command(state_, message, {&facts_}).error->code(), "too_large");
}

TEST_F(ApplyCommand, ATimeHoldsUntilAStepIsChosen) {
  ASSERT_FALSE(apply(R"({"setTime":{"time":1.25,"mode":"TIME_MODE_SPACETIME"}})").error);
  EXPECT_EQ(state_.scene.time, 1.25);
  EXPECT_EQ(state_.scene.time_mode, TimeMode::spacetime);
  ASSERT_FALSE(apply(R"({"setTime":{"mode":"TIME_MODE_INTERPOLATE"}})").error);
  EXPECT_EQ(state_.scene.time, 1.25) << "only the mode was given";
  EXPECT_EQ(state_.scene.time_mode, TimeMode::interpolate);
  ASSERT_FALSE(apply(R"({"setTimeStep":{"step":2}})").error);
  EXPECT_FALSE(state_.scene.time.has_value());
  EXPECT_EQ(state_.scene.step, 2);
}

TEST_F(ApplyCommand, TakesAsManyIntervalsAsItSaysAndNotOneMore) {
  v1::ClientMessage message;
  for (int i = 0; i < kMaxIntervals; ++i) {
    auto* interval = message.mutable_set_intervals()->add_intervals();
    interval->set_lower(i);
    interval->set_upper(i + 1);
  }
  EXPECT_FALSE(apply_command(state_, message, {&facts_}).error);
  EXPECT_EQ(state_.scene.intervals.size(), static_cast<std::size_t>(kMaxIntervals));
  *message.mutable_set_intervals()->add_intervals() = message.set_intervals().intervals(0);
  EXPECT_EQ(apply_command(state_, message, {&facts_}).error->code(), "too_large");
}

TEST_F(ApplyCommand, AnIdIsNeverUsedAgain) {
  std::set<std::uint32_t> seen;
  for (const auto& interval : state_.scene.intervals) seen.insert(interval.id);
  for (int round = 0; round < 10; ++round) {
    ASSERT_FALSE(apply(R"({"setIntervals":{"intervals":[{"lower":1,"upper":2}]}})").error);
    EXPECT_TRUE(seen.insert(state_.scene.intervals[0].id).second);
    ASSERT_FALSE(apply("{\"removeInterval\":{\"id\":" + std::to_string(state_.scene.intervals[0].id) + "}}").error);
  }
}

TEST_F(ApplyCommand, ReorderingGivesTheFirstTheHighestPriority) {
  ASSERT_FALSE(apply(R"({"reorderPriorities":{"ids":[2,4,1,3]}})").error);
  std::vector<int> priorities;
  for (const auto& interval : state_.scene.intervals) priorities.push_back(interval.priority);
  EXPECT_EQ(priorities, (std::vector<int>{1, 3, 0, 2}));
}

TEST_F(ApplyCommand, AnotherArrayKeepsTheLayersPlacesInItsRange) {
  ASSERT_FALSE(apply(R"({"selectArrays":{"array":"Energy"}})").error);
  EXPECT_EQ(state_.scene.intervals.front().lower, -100);
  EXPECT_EQ(state_.scene.intervals.back().upper, 300);
  EXPECT_DOUBLE_EQ(state_.scene.intervals[1].lower, 0);
}

TEST_F(ApplyCommand, AWholeStateIsOneChangeOrNone) {
  v1::State wanted = to_wire(state_.scene);
  wanted.set_step(2);
  wanted.mutable_intervals(0)->set_opacity(0.7);
  const auto revision = state_.scene.revision;
  ASSERT_FALSE(apply_state(state_, wanted, {&facts_}).error);
  EXPECT_EQ(state_.scene.revision, revision + 1);
  const std::string before = to_wire(state_.scene).SerializeAsString();
  wanted.set_step(1);
  wanted.mutable_camera()->set_fov_deg(0);
  ASSERT_TRUE(apply_state(state_, wanted, {&facts_}).error);
  EXPECT_EQ(to_wire(state_.scene).SerializeAsString(), before);
}

TEST_F(ApplyCommand, ItsOwnStateIsTakenBackAsItIs) {
  ASSERT_FALSE(apply(R"({"setAppearance":{"mode":"RENDER_MODE_PRIORITIZED","background":{"r":0.25},"unitDistance":0.5,"occlusion":0.3,"depthFade":0.2,"bodyShading":0.6,"axisScale":{"x":2,"y":1,"z":0.3}}})").error);
  ASSERT_FALSE(apply(R"({"setCombination":{"terms":[{"op":4,"array":"Energy","lower":1,"upper":2,"color":{"b":1}},
                                                    {"op":3,"array":"Density","lower":1,"upper":2,"colorMap":"viridis"}]}})")
                   .error);
  ASSERT_FALSE(apply(R"({"setTime":{"time":0.5,"mode":3}})").error);
  const auto outcome = apply_state(state_, to_wire(state_.scene), {&facts_});
  EXPECT_FALSE(outcome.error);
  EXPECT_FALSE(outcome.changed);
}

TEST_F(ApplyCommand, AStateBringsAnotherSessionToTheSameLayers) {
  ASSERT_FALSE(apply(R"({"setCombination":{"terms":[{"op":2,"array":"Energy","lower":1,"upper":2}]}})").error);
  ASSERT_FALSE(apply(R"({"setTime":{"time":0.5,"mode":2}})").error);
  SceneState other;
  open_in_scene(other, facts_);
  ASSERT_FALSE(apply_state(other, to_wire(state_.scene), {&facts_}).error);
  EXPECT_EQ(other.scene.terms, state_.scene.terms);
  EXPECT_EQ(other.scene.time, 0.5);
  EXPECT_EQ(other.scene.time_mode, TimeMode::interpolate);

  v1::State plain = to_wire(other.scene);
  plain.clear_time();
  plain.clear_terms();
  ASSERT_FALSE(apply_state(other, plain, {&facts_}).error);
  EXPECT_FALSE(other.scene.time.has_value());
  EXPECT_TRUE(other.scene.terms.empty());
}

TEST(ApplyCommandWithoutDataset, SaysThatNoneIsOpen) {
  SceneState state;
  v1::ClientMessage message;
  message.mutable_remove_interval()->set_id(1);
  EXPECT_EQ(apply_command(state, message, {}).error->code(), "not_found");
}

TEST(CheckSize, TakesOneToTheLargestSideAndBoundsThePixels) {
  EXPECT_FALSE(check_size(1, 1));
  EXPECT_FALSE(check_size(kMaxSide, 1));
  EXPECT_EQ(check_size(0, 1)->field(), "width");
  EXPECT_EQ(check_size(1, kMaxSide + 1)->field(), "height");
  EXPECT_EQ(check_size(kMaxSide, kMaxSide)->code(), "too_large");
}

// ---- random messages: whatever comes, the scene stays one that can be drawn
// -----------------------------------------------------

double wild(std::mt19937_64& random) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::array<double, 14> special = {0, -0.0, 1, -1, 0.5, 2, kInfinity, -kInfinity, NAN, 1e308, -1e308, 5e-324, 8, 300};
  if (random() % 3 == 0) return std::uniform_real_distribution<double>(-10, 310)(random);
  return special[random() % special.size()];
}

// Fills every kind of field, following the message's own description, so that new fields are tried too.
void scramble(google::protobuf::Message& message, std::mt19937_64& random, int depth) {
  using Field = google::protobuf::FieldDescriptor;
  const auto* reflection = message.GetReflection();
  const auto* descriptor = message.GetDescriptor();
  for (int i = 0; i < descriptor->field_count(); ++i) {
    const Field* field = descriptor->field(i);
    if (random() % 3 == 0) continue;
    if (field->is_repeated()) {
      for (std::uint64_t n = random() % 5; n > 0; --n) {
        if (field->cpp_type() == Field::CPPTYPE_MESSAGE) scramble(*reflection->AddMessage(&message, field), random, depth + 1);
        if (field->cpp_type() == Field::CPPTYPE_UINT32)
          reflection->AddUInt32(&message, field, static_cast<std::uint32_t>(random() % 7));
      }
      continue;
    }
    switch (field->cpp_type()) {
      case Field::CPPTYPE_DOUBLE:
        reflection->SetDouble(&message, field, wild(random));
        break;
      case Field::CPPTYPE_FLOAT:
        reflection->SetFloat(&message, field, static_cast<float>(wild(random)));
        break;
      case Field::CPPTYPE_UINT32:
        reflection->SetUInt32(&message, field, static_cast<std::uint32_t>(random() % 7));
        break;
      case Field::CPPTYPE_INT32:
        reflection->SetInt32(&message, field, static_cast<std::int32_t>(random() % 9) - 4);
        break;
      case Field::CPPTYPE_BOOL:
        reflection->SetBool(&message, field, random() % 2 == 0);
        break;
      case Field::CPPTYPE_ENUM:
        reflection->SetEnumValue(&message, field, static_cast<int>(random() % 5));
        break;
      case Field::CPPTYPE_STRING: {
        const std::array<std::string, 8> texts = {
            "", "Density", "Energy", "viridis", "+x", "reset", std::string(3000, 'x'), "\xf0\x9f\xa6\x80"};
        reflection->SetString(&message, field, texts[random() % texts.size()]);
        break;
      }
      case Field::CPPTYPE_MESSAGE:
        scramble(*reflection->MutableMessage(&message, field), random, depth + 1);
        break;
      default:
        break;
    }
  }
}

void expect_drawable(const Scene& scene, const DatasetFacts& dataset, const std::string& trace) {
  ASSERT_NE(dataset.find_array(scene.array), nullptr) << trace;
  ASSERT_TRUE(scene.color_by.empty() || dataset.find_array(scene.color_by)) << trace;
  ASSERT_LT(static_cast<std::size_t>(scene.step), dataset.times.size()) << trace;
  ASSERT_LE(scene.intervals.size(), static_cast<std::size_t>(kMaxIntervals)) << trace;
  std::set<std::uint32_t> ids;
  for (const SceneInterval& i : scene.intervals) {
    ASSERT_LT(i.lower, i.upper) << trace;  // an end may be open
    ASSERT_TRUE(i.opacity >= 0 && i.opacity <= 1) << trace;
    for (const float c : i.color) ASSERT_TRUE(c >= 0 && c <= 1) << trace;
    ASSERT_TRUE(i.id != 0 && ids.insert(i.id).second) << trace;
  }
  for (const SceneTerm& t : scene.terms) {
    ASSERT_NE(dataset.find_array(t.term.array), nullptr) << trace;
    ASSERT_LT(t.term.range.lower, t.term.range.upper) << trace;  // likewise
    ASSERT_TRUE(!t.opacity || (*t.opacity >= 0 && *t.opacity <= 1)) << trace;
  }
  ASSERT_TRUE(!scene.time || (*scene.time >= dataset.times.front() && *scene.time <= dataset.times.back())) << trace;
  ASSERT_TRUE(scene.camera) << trace;
  ASSERT_NO_THROW(check(*scene.camera)) << trace;
  ASSERT_TRUE(std::isfinite(scene.unit_distance) && scene.unit_distance >= 0) << trace;
}

TEST(ApplyCommandRandom, NoMessageLeavesASceneThatCannotBeDrawn) {
  const auto seed = static_cast<std::uint64_t>(::testing::UnitTest::GetInstance()->random_seed()) + 20040101;
  std::mt19937_64 random(seed);
  const DatasetFacts dataset = fin_facts();
  SceneState state;
  open_in_scene(state, dataset);
  int accepted = 0;
  for (int n = 0; n < 20000; ++n) {
    v1::ClientMessage message;
    // One field of the oneof, scrambled.
    const auto* descriptor = v1::ClientMessage::descriptor()->oneof_decl(0);
    const auto* field = descriptor->field(static_cast<int>(random() % static_cast<std::uint64_t>(descriptor->field_count())));
    scramble(*message.GetReflection()->MutableMessage(&message, field), random, 0);
    const std::uint64_t revision = state.scene.revision;
    const CommandOutcome outcome = apply_command(state, message, {&dataset});
    const std::string trace =
        "seed " + std::to_string(seed) + ", message " + std::to_string(n) + ": " + message.ShortDebugString();
    ASSERT_EQ(outcome.error.has_value() && outcome.changed, false) << trace;
    ASSERT_EQ(state.scene.revision, revision + (outcome.changed ? 1 : 0)) << trace;
    accepted += outcome.changed;
    expect_drawable(state.scene, dataset, trace);
    if (::testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(accepted, 100) << "seed " << seed << ": the messages were too wild to test anything";
}

}  // namespace
}  // namespace isostrata
