#include "support/places.h"

namespace isostrata::places {
std::string source() { return ISOSTRATA_SOURCE_DIR; }
std::string binaries() { return ISOSTRATA_BIN_DIR; }
}  // namespace isostrata::places
