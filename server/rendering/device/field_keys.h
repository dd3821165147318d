// Values as unsigned keys of the same order, and intervals as keys: what compute shaders compare in place of doubles, exactly.
//
// A point's class is (f >= lower) + (f >= above) with f promoted to double (iso_rules.h). Integers of up to 32 bits become keys
// by adding an offset, floats by turning the bits of negative numbers over (-0 first becomes 0): then f >= bound is key >=
// first_key(bound), where first_key is the key of the smallest value that is not below the bound. Integers of 64 bits are
// promoted to double first, as the CPU does.
#pragma once

#include <cstdint>
#include <vector>

#include "data/values/array.h"
#include "extraction/cells/iso_rules.h"
#include "rendering/gl/layout.h"

namespace isostrata {

/// How the device holds values of a type.
struct KeyFormat {
  int bytes = 4;  // of a value: 1, 2, 4, 8
  bool is_signed = false;
  bool is_float = false;
  bool promoted = false;  // to double, before they are sent
};

KeyFormat key_format(ScalarType type);

/// The key of a value of the format: the slow, obvious twin of the shaders' key_of, for tests.
std::uint64_t key_of(const KeyFormat& format, double value);

/// The smallest key that is not below the bound; up to one past the largest key of the format.
std::uint64_t first_key(const KeyFormat& format, double bound);

/// The intervals of a request in keys. Intervals that no value of the type can make active are left out.
struct KeyedRules {
  std::vector<shaders::IsoKeys> rules;    // by lower end
  std::vector<shaders::IsoLevel> levels;  // [isovalues]
};
KeyedRules keyed_rules(const KeyFormat& format, const IsoRules& rules);

}  // namespace isostrata
