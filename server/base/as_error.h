// What was thrown, as the Error that it is told as.
#pragma once

#include <exception>

#include "base/error.h"

namespace isostrata {

/// An Error as it is; out of memory is too_large; everything else is internal, with what it says. Precondition: not null. Any thread.
Error as_error(const std::exception_ptr& failure);

}  // namespace isostrata
