#include <algorithm>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>

#include "planish/c/call.h"
#include "planish/c/options.h"
#include "planish/core/nearest.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"

namespace planish::c {
namespace {

// The rows of option_table() that the functions of planish.h heed. The others are refused.
constexpr std::string_view kServed[] = {
    "preset",         "scheme",  "interpolation", "weights",   "solver",     "precision",
    "boundary",       "creases", "repair",        "quads",     "refine",     "up",
    "asset",          "lods",    "textures",      "device",    "tolerance",  "max_iterations",
    "polish",         "within",  "weld",          "step_unit", "step_angle", "step_tolerance",
    "step_face_size", "levels"};
// Of planish.h alone.
constexpr std::string_view kThreads = "threads";

const Option<planish_options>& threads_option() {
  static const Option<planish_options> option =
      whole_option({.name = kThreads, .limits = {0, 4096}}, &planish_options::thread_count);
  return option;
}

FitSettings default_settings() {
  FitSettings settings;
  settings.device = "cpu";
  return settings;
}

// Points and reports have options of their own, of which this interface knows nothing.
[[noreturn]] void refuse_name(std::string_view name) {
  if (const FitOption* option = find_option(option_table(), name)) {
    const bool is_tag = option->kind == OptionKind::Edges || option->kind == OptionKind::Vertices;
    planish::refuse(spelled(name), "this interface does not have it; {}",
                    is_tag ? "planish run does it, and planish_mesh_arrays has it for meshes"
                           : "planish fit does it");
  }
  std::vector<std::string_view> known(std::begin(kServed), std::end(kServed));
  known.push_back(kThreads);
  const std::string nearest = did_you_mean(name, known);
  planish::refuse(spelled(visible(name)), "there is no such option here{}",
                  nearest.empty() ? "; planish fit --help lists what the command has" : nearest);
}

void require_served(std::string_view name) {
  if (name != kThreads && std::ranges::find(kServed, name) == std::end(kServed)) refuse_name(name);
}

// Sets what is given, in the order of the table, as the command does: a preset first.
FitSettings settings_of(const planish_options& options) {
  FitSettings settings = default_settings();
  for (const FitOption& option : option_table())
    if (const auto given = options.given.find(option.name); given != options.given.end())
      read_option(option, settings, given->second, spelled(option.name));
  if (settings.device != "cpu") {
    planish::refuse(spelled("device"), "\"{}\" is not served, all is computed on the CPU; take cpu",
                    visible(settings.device));
  }
  return settings;
}

// A row without a text of its own has that which was given.
std::string text_of(const planish_options& options, std::string_view name) {
  if (name == kThreads) return threads_option().get(options);
  const FitOption& option = fit_option(name);
  if (option.get) return option.get(options.settings);
  const auto given = options.given.find(name);
  return given == options.given.end() ? std::string() : given->second;
}

void set_texts(planish_options& options) {
  for (const std::string_view name : kServed) options.texts[name] = text_of(options, name);
  options.texts[kThreads] = text_of(options, kThreads);
}

}  // namespace

std::string spelled(std::string_view name) { return "options." + std::string(name); }

const planish_options& options_of(const planish_options* given) {
  static const planish_options kDefaults;
  return given != nullptr ? *given : kDefaults;
}

const FitSettings& consistent_settings(const planish_options& options) {
  check_consistent(options.settings, spelled);
  return options.settings;
}

const FitSettings& mesh_settings(const planish_options& options) {
  if (options.settings.creases.split_normals)
    planish::refuse(spelled("creases"), "normals are a file's; take planish_fit_file()");
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

Levels levels_of(const FitSettings& settings) {
  if (settings.levels_by_density) return {};
  std::vector<int> levels = settings.levels;
  if (levels.size() > 1 && settings.lods != LodChoice::Msft) {
    planish::refuse(spelled("levels"),
                    "several are a file each; take one, or {} msft for levels of detail of a glTF",
                    spelled("lods"));
  }
  std::ranges::sort(levels, std::greater());
  return {levels.front(), {levels.begin() + 1, levels.end()}};
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
    require_served(name);
    planish_options next = *options;
    if (name == kThreads) {
      planish::read_option(threads_option(), next, value, spelled(name));
    } else {
      next.given[planish::fit_option(name).name] = value;
      next.settings = settings_of(next);
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
    require_served(name);
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
