// What can fail in the world throws one Error. It is caught where a command runs and where a connection ends.
#pragma once

#include <stdexcept>
#include <string>

namespace isostrata {

enum class ErrorCode {
  invalid_argument,  // the caller asked for something that has no meaning (lower >= upper, unknown option)
  not_found,         // a file, an array, a session that is not there
  bad_data,          // a file that is truncated, malformed or inconsistent
  unsupported,       // understood, but outside what this version does
  too_large,         // a size above a stated limit or the memory budget
  cancelled,         // the person or program that asked does not want it any more
  unavailable,       // a device or a resource that could not be had
  internal           // a broken invariant: a bug of ours
};

/// The code's name as it appears in JSON and on the wire: "invalid_argument", "not_found", ...
const char* to_string(ErrorCode code);

/// message: what, which, and what was expected: "torus.nrrd: 64x64x64 floats declared, 12 bytes present".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

/// Throws what a system call said: Error(unavailable, "what: No such file or directory").
[[noreturn]] void throw_system_error(const std::string& what, int error_number);

}  // namespace isostrata
