// Mesa has had no OSMesa since 25.1: where a release does not bring it, the tests of it see what is said in its place.
#pragma once

#include <dlfcn.h>

namespace isostrata::testing {

inline bool osmesa_is_installed() { return dlopen("libOSMesa.so.8", RTLD_LAZY) || dlopen("libOSMesa.so.6", RTLD_LAZY); }

}  // namespace isostrata::testing
