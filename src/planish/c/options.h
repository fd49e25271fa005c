#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "planish/c/planish.h"
#include "planish/core/callbacks.h"
#include "planish/core/work_limits.h"
#include "planish/job/job_settings.h"
#include "planish/pipeline/found_creases.h"

// What the handle of planish_options_create() holds. Its name is C's, so it stands in no namespace.

struct planish_options {
  planish::Settings settings;
  std::map<std::string_view, std::string> given;  ///< texts, by names of the tables
  std::map<std::string_view, std::string> texts;  ///< for planish_options_get(), of all names
  int thread_count = 0;
  planish::WorkLimits limits;
  int (*progress)(void* user, const char* step, double fraction) = nullptr;
  void* progress_user = nullptr;
  void (*warning)(void* user, const char* code, const char* message) = nullptr;
  void* warning_user = nullptr;
  std::map<std::string_view, std::string> files;  ///< of planish_fit_file(): paths, by "report"...
  std::optional<planish::FoundCreases> sharp;     ///< for planish_verify(); empty: is looked for

  planish_options();
  /// The path that is set by that name; empty: none.
  [[nodiscard]] std::string file(std::string_view name) const {
    const auto found = files.find(name);
    return found == files.end() ? std::string() : found->second;
  }
};

namespace planish::c {

/// "options.weights": how messages call an option.
[[nodiscard]] std::string spelled(std::string_view name);

/// Those, or the defaults for NULL.
[[nodiscard]] const planish_options& options_of(const planish_options* given);

/// All settings, which do not contradict each other. Throws as check_consistent().
[[nodiscard]] const Settings& consistent_settings(const planish_options& options);
/// The same, of a mesh that is no file. Throws where something is set that is of files alone.
[[nodiscard]] const Settings& mesh_settings(const planish_options& options);

/// The caller's functions. Another result of progress() than 0 throws Error{Cancelled}.
[[nodiscard]] Callbacks callbacks_of(const planish_options& options);

}  // namespace planish::c
