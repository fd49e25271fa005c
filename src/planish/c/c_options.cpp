#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "planish/c/handles.h"
#include "planish/core/guards.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish::c {
namespace {

// The one thing that the library keeps between calls: C has no other place for a message.
struct LastError {
  std::string message;
  std::int64_t element = -1;
};

thread_local LastError last_error;

planish_status status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return PLANISH_INVALID_ARGUMENT;
    case ErrorCode::UnreadableInput:
      return PLANISH_UNREADABLE_INPUT;
    case ErrorCode::UnusableMesh:
      return PLANISH_UNUSABLE_MESH;
    case ErrorCode::NoDevice:
    case ErrorCode::DeviceLost:
    case ErrorCode::OutOfMemory:
      return PLANISH_NO_MEMORY;
    case ErrorCode::UnwritableOutput:
      return PLANISH_UNWRITABLE_OUTPUT;
    case ErrorCode::Cancelled:
      return PLANISH_CANCELLED;
  }
  return PLANISH_INTERNAL_ERROR;
}

}  // namespace

void note(const char* message, std::int64_t element) noexcept {
  try {
    last_error = {message, element};
  } catch (...) {  // no memory for the message
    last_error.message.clear();
    last_error.element = -1;
  }
}

planish_status note_exception() noexcept {
  const Failure failure = current_failure("out of memory; take a lower level or a smaller mesh");
  note(failure.message, failure.element);
  return failure.code ? status_of(*failure.code) : PLANISH_INTERNAL_ERROR;
}

void run_on(int thread_count, const std::function<void()>& work) {
  if (thread_count == 0) {
    work();
    return;
  }
  oneapi::tbb::task_arena arena(thread_count);
  arena.execute(work);
}

void refuse(const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); }

void require_list(const std::int32_t* values, std::size_t count, const char* name,
                  const char* count_name) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (count > 0) require(values, name);
  if (count > kMost)
    refuse(formatted("{} is {}, more than 2^31 - 1; name fewer at once", count_name, count));
}

void give_warning(std::span<const Warning> warnings, const char* of, std::size_t index,
                  const char** code, const char** message) {
  if (index >= warnings.size())
    refuse(formatted("index is {}; the {} has {} warnings", index, of, warnings.size()));
  if (code != nullptr) *code = warnings[index].code.c_str();
  if (message != nullptr) *message = warnings[index].message.c_str();
}

}  // namespace planish::c

const char* planish_version(void) { return PLANISH_VERSION; }

const char* planish_last_error(void) { return planish::c::last_error.message.c_str(); }

int64_t planish_last_error_element(void) { return planish::c::last_error.element; }

namespace planish::c {
namespace {

// Files of planish_fit_file() besides its input and output, as jobs of scene files name them.
constexpr std::array<std::string_view, 4> kFiles{"cage", "page", "report", "source"};

bool is_file(std::string_view name) { return std::ranges::find(kFiles, name) != kFiles.end(); }

const std::vector<Option<planish_options>>& own_options() {
  constexpr double kMost = 9007199254740992;  // whole numbers of a double
  const auto most_of = [](std::string_view name, auto member) {
    return whole_option({.name = name, .limits = {0, kMost}}, &planish_options::limits, member);
  };
  static const std::vector<Option<planish_options>> options{
      whole_option({.name = "threads", .limits = {0, 4096}}, &planish_options::thread_count),
      most_of("memory_limit", &WorkLimits::memory_bytes),
      most_of("point_limit", &WorkLimits::points),
      most_of("output_limit", &WorkLimits::output_bytes),
      number_option({.name = "time_limit", .limits = {0, kMost}}, &planish_options::limits,
                    &WorkLimits::cpu_seconds)};
  return options;
}

// Null: the name is none of them.
const Option<planish_options>* find_own(std::string_view name) {
  const auto found = std::ranges::find(own_options(), name, &Option<planish_options>::name);
  return found == own_options().end() ? nullptr : &*found;
}

Settings default_settings() {
  Settings settings;
  settings.device = "cpu";
  return settings;
}

// Tags have no text: they name vertices.
bool is_served(const OptionInfo& option) {
  return option.kind != OptionKind::Edges && option.kind != OptionKind::Vertices;
}

// Of all that can be set but what is of planish.h alone.
template <class Visit>
void for_options(const Visit& visit) {
  for (const FitOption& option : option_table())
    if (is_served(option)) visit(option);
  for (const PointOption& option : point_option_table()) visit(option);
}

[[noreturn]] void refuse_name(std::string_view name) {
  if (find_setting(name) != nullptr)
    planish::refuse(spelled(name),
                    "this interface does not have it; planish run does it, and "
                    "planish_mesh_arrays has it for meshes");
  std::vector<std::string_view> known;
  for (const Option<planish_options>& option : own_options()) known.push_back(option.name);
  known.insert(known.end(), kFiles.begin(), kFiles.end());
  for_options([&](const OptionInfo& option) { known.push_back(option.name); });
  const std::string nearest = did_you_mean(name, known);
  planish::refuse(spelled(visible(name)), "there is no such option here{}",
                  nearest.empty() ? "; planish fit --help lists what the command has" : nearest);
}

// The row; null for what is of planish.h alone.
const OptionInfo* require_served(std::string_view name) {
  if (find_own(name) != nullptr || is_file(name)) return nullptr;
  const OptionInfo* const option = find_setting(name);
  if (option == nullptr || !is_served(*option)) refuse_name(name);
  return option;
}

Settings given_settings(const planish_options& options) {
  Settings settings = default_settings();
  apply_settings(std::vector<NamedSetting>(options.given.begin(), options.given.end()), settings,
                 spelled);
  if (settings.device != "cpu") {
    planish::refuse(spelled("device"), "\"{}\" is not served, all is computed on the CPU; take cpu",
                    visible(settings.device));
  }
  return settings;
}

// A row without a text of its own has that which was given.
template <class Target>
std::string text_of(const planish_options& options, const Option<Target>& option,
                    const Target& target) {
  if (option.get) return option.get(target);
  const auto given = options.given.find(option.name);
  return given == options.given.end() ? std::string() : given->second;
}

void set_texts(planish_options& options) {
  for (const FitOption& option : option_table())
    if (is_served(option))
      options.texts[option.name] = text_of<FitSettings>(options, option, options.settings);
  for (const PointOption& option : point_option_table())
    options.texts[option.name] = text_of(options, option, options.settings.points);
  for (const Option<planish_options>& option : own_options())
    options.texts[option.name] = option.get(options);
  for (const std::string_view name : kFiles) options.texts[name] = options.file(name);
}

}  // namespace

std::string spelled(std::string_view name) { return "options." + std::string(name); }

const planish_options& options_of(const planish_options* given) {
  static const planish_options kDefaults;
  return given != nullptr ? *given : kDefaults;
}

const Settings& consistent_settings(const planish_options& options) {
  check_consistent(options.settings, spelled);
  return options.settings;
}

const Settings& mesh_settings(const planish_options& options) {
  if (options.settings.creases.split_normals)
    planish::refuse(spelled("creases"), "normals are a file's; take planish_fit_file()");
  for (const auto& [name, text] : options.given)
    if (is_of_inputs(*find_setting(name)))
      planish::refuse(spelled(name), "is of files and points; take planish_fit_file()");
  for (const auto& [name, path] : options.files)
    planish::refuse(spelled(name), "is of planish_fit_file()");
  return consistent_settings(options);
}

// An exception out of progress() ends the work, as whatever a callback throws.
Callbacks callbacks_of(const planish_options& options) {
  Callbacks callbacks;
  if (options.progress != nullptr) {
    callbacks.progress = [progress = options.progress, user = options.progress_user](
                             std::string_view step, double fraction) {
      if (progress(user, std::string(step).c_str(), fraction) != 0)
        throw Error(ErrorCode::Cancelled, "cancelled");
    };
  }
  if (options.warning != nullptr) {
    callbacks.warning = [warn = options.warning,
                         user = options.warning_user](const Warning& warning) {
      warn(user, warning.code.c_str(), warning.message.c_str());
    };
  }
  return callbacks;
}

}  // namespace planish::c

using namespace planish::c;

planish_options::planish_options() : settings(default_settings()) { set_texts(*this); }

planish_status planish_options_create(planish_options** options) {
  return call([&] {
    require(options, "options");
    *options = std::make_unique<planish_options>().release();
    return PLANISH_OK;
  });
}

planish_status planish_options_set(planish_options* options, const char* name, const char* value) {
  return call([&] {
    require(options, "options");
    require(name, "name");
    require(value, "value");
    const planish::OptionInfo* const option = require_served(name);
    planish_options next = *options;
    if (is_file(name)) {
      next.files[*std::ranges::find(kFiles, std::string_view(name))] = value;
    } else if (option == nullptr) {
      planish::read_option(*find_own(name), next, value, spelled(name));
    } else {
      next.given[option->name] = value;
      next.settings = given_settings(next);
    }
    set_texts(next);
    *options = std::move(next);
    return PLANISH_OK;
  });
}

planish_status planish_options_get(const planish_options* options, const char* name,
                                   const char** value) {
  return call([&] {
    require(options, "options");
    require(name, "name");
    require(value, "value");
    (void)require_served(name);
    *value = options->texts.at(name).c_str();
    return PLANISH_OK;
  });
}

void planish_options_on_progress(planish_options* options,
                                 int (*progress)(void* user, const char* step, double fraction),
                                 void* user) {
  if (options == nullptr) return;
  options->progress = progress;
  options->progress_user = user;
}

void planish_options_on_warning(planish_options* options,
                                void (*warning)(void* user, const char* code, const char* message),
                                void* user) {
  if (options == nullptr) return;
  options->warning = warning;
  options->warning_user = user;
}

planish_status planish_options_set_sharp(planish_options* options, const int32_t* edges,
                                         size_t edge_count, const int32_t* corners,
                                         size_t corner_count) {
  return call([&] {
    require(options, "options");
    require_list(edges, edge_count, "edges", "edge_count");
    require_list(corners, corner_count, "corners", "corner_count");
    std::optional<planish::FoundCreases> sharp;
    if (edges != nullptr || corners != nullptr) {
      sharp.emplace();
      for (size_t i = 0; i < edge_count; ++i)
        sharp->edges.push_back({edges[2 * i], edges[2 * i + 1]});
      sharp->corners.assign(corners, corners + corner_count);
    }
    options->sharp = std::move(sharp);
    return PLANISH_OK;
  });
}

void planish_options_free(planish_options* options) { delete options; }
