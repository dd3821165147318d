// What a number, a name, an array of a command must be. Each check returns what it was given if that is good, and else refuses the
// whole command; `field` is the name that the sender is told.
#pragma once

#include <string>

#include "engine/data/dataset_facts.h"
#include "scene/scene.h"
#include "session/commands/apply_command.h"
#include "session/wire/limits.h"

namespace isostrata {

/// A refusal on its way out of nested checks; apply_command makes an answer of it.
struct Refused {
  v1::Error error;
};
[[noreturn]] void refuse(const char* code, std::string message, std::string field);

std::string number_text(double value);  // with at most nine digits

double finite(double value, const std::string& field, double limit = kMaxMagnitude);
double unit(double value, const std::string& field);  // in [0, 1]
double within(double value, double lower, double upper, const std::string& field);
const std::string& name(const std::string& text, const std::string& field);  // of at most kMaxNameBytes
Rgb rgb_of(const v1::Rgb& rgb, const std::string& field);
std::string color_map_of(const std::string& map, const std::string& field);  // empty, or one that there is
/// lower < upper, either of them finite or open by an infinite end. `field` is what stands before "lower" and "upper".
void check_ends(double lower, double upper, const std::string& field);

const DatasetFacts& opened(const CommandContext& context);  // refuses if nothing is open
const ArrayFacts& array_of(const std::string& array, const CommandContext& context, const char* field);

}  // namespace isostrata
