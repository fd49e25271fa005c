#pragma once

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>

#include "attributes.h"
#include "planish/backend/backend.h"
#include "planish/core/option.h"
#include "planish/core/work_limits.h"
#include "planish/job/job_settings.h"
#include "work.h"

namespace planish::python {

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
