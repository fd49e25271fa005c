#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish::python {

/// What a Python caller gives: functions, or None.
struct PythonCallbacks {
  pybind11::object progress = pybind11::none();   ///< progress(step, fraction)
  pybind11::object cancelled = pybind11::none();  ///< cancelled() -> bool
};

/// Runs `work` without Python's lock but for its callbacks, on this thread, which takes the lock
/// every 20 ms to see to signals and to `cancelled`; work of the library then stops within about 10
/// ms more. Throws what `work` throws, Error{Cancelled}, and what Python raised: KeyboardInterrupt,
/// or an exception of a function that was given. `threads`: as CpuBackendOptions has them.
void run_released(const PythonCallbacks& python, const std::function<void(const Callbacks&)>& work,
                  int threads = 0);

/// `callbacks` whose warnings go to `warnings`: given to warn() once Python's lock is held again.
[[nodiscard]] Callbacks collecting(Callbacks callbacks, std::vector<Warning>& warnings);

}  // namespace planish::python
