#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "planish/c/call.h"
#include "planish/c/options.h"
#include "planish/core/nearest.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

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
    planish::FoundCreases sharp;
    for (size_t i = 0; i < edge_count; ++i) sharp.edges.push_back({edges[2 * i], edges[2 * i + 1]});
    sharp.corners.assign(corners, corners + corner_count);
    options->sharp.reset();
    if (edges != nullptr || corners != nullptr) options->sharp = std::move(sharp);
    return PLANISH_OK;
  });
}

void planish_options_free(planish_options* options) { delete options; }
