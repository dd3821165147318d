#pragma once
#include <string>

// Absolute paths of this build, compiled in one place (places.cpp), so that the compiler cache serves every clone.
namespace isostrata::places {
std::string source();      // the root of the repository
std::string binaries();    // the programs of this build
}  // namespace isostrata::places
