#pragma once

#include <pybind11/pybind11.h>

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arrays.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/option.h"
#include "planish/job/job_settings.h"
#include "planish/solve/backend.h"

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

/// What fit() takes behind the mesh.
struct FitArguments {
  Settings settings;
  int threads = 0;
  WorkLimits limits;  ///< of fit_file()
  PythonCallbacks callbacks;
  MeshArguments mesh;

  [[nodiscard]] std::unique_ptr<Backend> make_backend() const;
};

/// Takes what it knows out of the keywords. Throws Error{InvalidArgument} for values, and TypeError
/// for keywords that remain.
[[nodiscard]] FitArguments fit_arguments(pybind11::kwargs keywords, const char* function);

/// Takes what write() knows, of a file of one level where that is given. Throws as fit_arguments().
[[nodiscard]] Settings write_arguments(pybind11::kwargs keywords, std::optional<int> level);

/// What read() is told of files that its own names. Throws as fit_arguments().
[[nodiscard]] FileReach reach_argument(const std::string& textures);

/// What such keywords mean, see keywords.h, for docstrings.
[[nodiscard]] std::string keywords_text(bool (*is_wanted)(const OptionInfo&));
/// The same of fit_file(), beside the fit's.
[[nodiscard]] std::string file_keywords();
/// What the fit's keywords mean, for docstrings.
[[nodiscard]] std::string fit_keywords();

}  // namespace planish::python
