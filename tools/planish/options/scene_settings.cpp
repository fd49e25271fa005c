#include "options/scene_settings.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "options/nearest.h"
#include "options/point_settings.h"
#include "options/refuse.h"
#include "planish/core/visible_text.h"

namespace planish::command {
namespace {

template <class Read>
auto list_of(const Json& json, const std::string& where, const char* wanted, const Read& read) {
  if (!json.is_array())
    refuse(where, std::string("a list of ") + wanted + " is wanted, not " + json.type_name());
  std::vector<decltype(read(json, where))> values;
  for (std::size_t i = 0; i < json.size(); ++i)
    values.push_back(read(json[i], entry_path(where, i)));
  return values;
}

std::vector<int> levels_of(const Json& json, const std::string& where) {
  return checked_levels(list_of(json, where, "levels such as [2]", integer_of), where);
}

std::vector<double> chord_errors_of(const Json& json, const std::string& where) {
  return checked_chord_errors(list_of(json, where, "errors such as [0.001]", number_of), where);
}

std::int32_t vertex_of(const Json& json, const std::string& where) {
  const std::int64_t vertex = integer_of(json, where);
  if (vertex < 0) refuse(where, "a vertex counted from 0 is wanted, not " + std::to_string(vertex));
  return static_cast<std::int32_t>(vertex);
}

}  // namespace

std::vector<std::string_view> scene_keys(SceneObject object) {
  std::vector<std::string_view> solve{"tolerance", "max_iterations", "polish",
                                      "weld",      "crease_edges",   "corner_vertices"};
  std::vector<std::string_view> all = solve;
  all.insert(all.end(), {"levels", "chord_errors", "angle", "tile_vertices", "skirts", "solve"});
  for (const WordSetting& setting : word_settings()) {
    all.push_back(setting.name);
    if (setting.belongs_to_solve) solve.push_back(setting.name);
  }
  for (const PointSetting& setting : point_settings()) all.push_back(setting.name);
  switch (object) {
    case SceneObject::Scene:
      return {"$schema", "version", "defaults", "jobs"};
    case SceneObject::Defaults:
      return all;
    case SceneObject::Job:
      all.insert(all.end(), {"name", "input", "input_format", "sample", "outputs", "source",
                             "report", "page"});
      return all;
    case SceneObject::Solve:
      return solve;
    case SceneObject::Output:
      return {"path", "what", "levels", "chord_errors", "angle"};
    case SceneObject::Sample:
      return {"points", "pattern", "seed", "noise", "outliers"};
  }
  return {};
}

void check_keys(const Json& json, SceneObject kind, const std::string& where) {
  require_object(json, where);
  const std::vector<std::string_view> known = scene_keys(kind);
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(known, key) == known.end())
      refuse(key_path(where, key), "this key is not known" + did_you_mean(key, known));
  }
}

void apply_fineness(const Json& json, const std::string& where, std::vector<int>& levels,
                    AdaptiveChoice& adaptive) {
  const bool is_adaptive = json.contains("chord_errors") || json.contains("angle");
  if (json.contains("levels")) {
    if (is_adaptive) {
      refuse(key_path(where, "levels"),
             "a surface has levels or chord_errors and an angle, not both; leave one of them out");
    }
    levels = levels_of(json["levels"], key_path(where, "levels"));
    adaptive = {};
  }
  if (json.contains("chord_errors"))
    adaptive.chord_errors = chord_errors_of(json["chord_errors"], key_path(where, "chord_errors"));
  if (json.contains("angle")) {
    const std::string path = key_path(where, "angle");
    adaptive.angle = checked_angle(number_of(json["angle"], path), path);
  }
}

// Settings of one object. A key may stand in the object or in its "solve", not in both.
void apply_settings(Settings& settings, std::vector<GivenSetting>& given, const Json& json,
                    const std::string& where) {
  const bool has_solve = json.contains("solve");
  const Json solve = has_solve ? json["solve"] : Json::object();
  const std::string solve_path = key_path(where, "solve");
  if (has_solve) check_keys(solve, SceneObject::Solve, solve_path);

  const auto visit = [&](std::string_view key, const auto& set) {
    const bool here = json.contains(key);
    const bool in_solve = solve.contains(key);
    if (here && in_solve) {
      refuse(key_path(solve_path, key), "stands in " + where + " as well; once is enough");
    }
    if (here) set(json[std::string(key)], key_path(where, key));
    if (in_solve) set(solve[std::string(key)], key_path(solve_path, key));
    note_given(given, json, key, where);
    note_given(given, solve, key, solve_path);
  };
  for (const WordSetting& setting : word_settings()) {
    visit(setting.name, [&](const Json& value, const std::string& path) {
      setting.set(settings, text_of(value, path), path);
    });
  }
  for (const PointSetting& setting : point_settings()) {
    visit(setting.name, [&](const Json& value, const std::string& path) {
      const bool as_number = setting.is_number && value.is_number();
      setting.set(settings.points, as_number ? value.dump() : text_of(value, path), path);
    });
  }
  visit("tolerance", [&](const Json& value, const std::string& path) {
    set_tolerance(settings, number_of(value, path), path);
  });
  visit("weld", [&](const Json& value, const std::string& path) {
    if (!value.is_number())
      refuse(path, std::string("a number is wanted, not ") + value.type_name());
    set_weld(settings, value.get<double>(), path);
  });
  visit("max_iterations", [&](const Json& value, const std::string& path) {
    set_max_iterations(settings, integer_of(value, path), path);
  });
  visit("polish", [&](const Json& value, const std::string& path) {
    set_polish_steps(settings, integer_of(value, path), path);
  });
  visit("tile_vertices", [&](const Json& value, const std::string& path) {
    set_tile_vertices(settings, integer_of(value, path), path);
  });
  visit("skirts", [&](const Json& value, const std::string& path) {
    if (!value.is_boolean())
      refuse(path, std::string("true or false is wanted, not ") + value.type_name());
    settings.skirts = value.get<bool>();
  });
  visit("crease_edges", [&](const Json& value, const std::string& path) {
    settings.crease_edges.clear();
    for_entries(value, path, [&](const Json& edge, const std::string& entry) {
      if (!edge.is_array() || edge.size() != 2) {
        refuse(entry, "two vertices such as [0, 1] are wanted");
      }
      settings.crease_edges.push_back(
          {vertex_of(edge[0], entry_path(entry, 0)), vertex_of(edge[1], entry_path(entry, 1))});
    });
  });
  visit("corner_vertices", [&](const Json& value, const std::string& path) {
    settings.corner_vertices.clear();
    for_entries(value, path, [&](const Json& vertex, const std::string& entry) {
      settings.corner_vertices.push_back({vertex_of(vertex, entry)});
    });
  });
  apply_fineness(json, where, settings.levels, settings.adaptive);
  for (const char* const key : {"levels", "chord_errors", "angle"})
    note_given(given, json, key, where);
}

void note_given(std::vector<GivenSetting>& given, const Json& json, std::string_view key,
                const std::string& where) {
  const auto found = json.find(std::string(key));
  if (found == json.end()) return;
  // Lists of tags may have millions of entries.
  const bool is_long = found->is_structured() && found->size() > 8;
  const std::string value = is_long ? "..." : found->dump();
  given.push_back({std::string(key), key_path(where, key),
                   found->is_string() ? found->get<std::string>() : value});
}

}  // namespace planish::command
