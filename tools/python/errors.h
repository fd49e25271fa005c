#pragma once

#include <string>

namespace planish::python {

/// Makes pybind11 raise planish's errors as the classes of planish/_errors.py. Called once, when
/// the module is loaded.
void register_errors();

/// Throws Error{InvalidArgument}.
[[noreturn]] void refuse(const std::string& message);

}  // namespace planish::python
