#pragma once

#include <span>
#include <string>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"

namespace planish::python {

/// NoDevice of a program; planish.MissingProgram.
class MissingProgram : public Error {
 public:
  explicit MissingProgram(const std::string& message) : Error(ErrorCode::NoDevice, message) {}
};

/// Makes pybind11 raise planish's errors as the classes of planish/_errors.py. Called once, when
/// the module is loaded.
void register_errors();

/// Throws Error{InvalidArgument}.
[[noreturn]] void refuse(const std::string& message);

/// As Python's own UserWarnings; where these are errors, the first is raised.
void warn(std::span<const Warning> warnings);

}  // namespace planish::python
