#pragma once

#include <pybind11/pybind11.h>

#include <functional>

#include "planish/core/callbacks.h"

namespace planish::python {

/// What a Python caller gives: functions, or None.
struct PythonCallbacks {
  pybind11::object progress = pybind11::none();   ///< progress(step, fraction)
  pybind11::object cancelled = pybind11::none();  ///< cancelled() -> bool
};

/// Runs `work` on a thread of its own while this one, without Python's lock but for looking every
/// 20 ms, sees to signals and to `cancelled`; work of the library then stops within about 10 ms
/// more. Throws what `work` throws, Error{Cancelled}, and what Python raised: KeyboardInterrupt, or
/// an exception of a function that was given.
void run_released(const PythonCallbacks& python, const std::function<void(const Callbacks&)>& work);

}  // namespace planish::python
