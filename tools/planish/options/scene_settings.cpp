#include "options/scene_settings.h"

#include <algorithm>

#include "planish/core/json.h"
#include "planish/core/nearest.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish::command {
namespace {

template <class Value, class Read>
std::vector<Value> list_of(const OptionInfo& option, const Json& json, const std::string& where,
                           const Read& read) {
  if (!json.is_array()) {
    refuse(where, "a list of {}s such as [{}] is wanted, not {}", option.entry, option.example,
           json.type_name());
  }
  std::vector<Value> values;
  for (std::size_t i = 0; i < json.size(); ++i)
    values.push_back(read(json[i], entry_path(where, i)));
  return values;
}

std::int64_t vertex_of(const Json& json, const std::string& where) {
  const std::int64_t vertex = integer_of(json, where);
  if (vertex < 0) refuse(where, "a vertex counted from 0 is wanted, not {}", vertex);
  return vertex;
}

std::vector<std::int64_t> tagged_edges(const Json& json, const std::string& where) {
  std::vector<std::int64_t> vertices;
  for_entries(json, where, [&](const Json& edge, const std::string& entry) {
    if (!edge.is_array() || edge.size() != 2)
      refuse(entry, "two vertices such as [0, 1] are wanted");
    for (std::size_t i = 0; i < 2; ++i)
      vertices.push_back(vertex_of(edge[i], entry_path(entry, i)));
  });
  return vertices;
}

// Calls set(value): its text may be one that was made here.
template <class Set>
void with_value(const OptionInfo& option, const Json& json, const std::string& where,
                const Set& set) {
  OptionValue value;
  std::string number;
  switch (option.kind) {
    case OptionKind::Word:
    case OptionKind::Words:
    case OptionKind::Text:
      value.text = text_of(json, where);
      break;
    case OptionKind::TextOrNumber:
      if (json.is_number()) number = json.dump();
      value.text = json.is_number() ? std::string_view(number) : text_of(json, where);
      break;
    case OptionKind::Whole:
      value.whole = integer_of(json, where);
      break;
    case OptionKind::Number:
      value.number = number_of(json, where);
      break;
    case OptionKind::Switch:
      if (!json.is_boolean())
        refuse(where, std::string("true or false is wanted, not ") + json.type_name());
      value.is_on = json.get<bool>();
      break;
    case OptionKind::Wholes:
      if (json.is_string() && json.get_ref<const std::string&>() == option.word) {
        value.text = option.word;
        break;
      }
      value.wholes = list_of<std::int64_t>(option, json, where, integer_of);
      break;
    case OptionKind::Numbers:
      value.numbers = list_of<double>(option, json, where, number_of);
      break;
    case OptionKind::Vertices:
      for_entries(json, where, [&](const Json& vertex, const std::string& entry) {
        value.wholes.push_back(vertex_of(vertex, entry));
      });
      break;
    case OptionKind::Edges:
      value.wholes = tagged_edges(json, where);
      break;
  }
  set(value);
}

}  // namespace

void check_keys(const Json& json, SceneObject kind, const std::string& where) {
  require_object(json, where);
  const std::vector<std::string_view> known = scene_keys(kind);
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(known, key) == known.end())
      refuse(key_path(where, key), "this key is not known" + did_you_mean(key, known));
  }
}

void apply_fineness(const Json& json, const std::string& where, FitSettings& settings) {
  if (json.contains("levels")) {
    if (json.contains("chord_errors") || json.contains("angle")) {
      refuse(key_path(where, "levels"),
             "a surface has levels or chord_errors and an angle, not both; leave one of them out");
    }
    settings.adaptive = {};
  }
  for (const FitOption& option : option_table()) {
    if (option.stage != OptionStage::Fineness || !json.contains(option.name)) continue;
    const std::string path = key_path(where, option.name);
    with_value(option, json[std::string(option.name)], path,
               [&](const OptionValue& value) { set_option(option, settings, value, path); });
  }
}

// Settings of one object. A key may stand in the object or in its "solve", not in both.
void apply_settings(Settings& settings, std::vector<GivenSetting>& given, const Json& json,
                    const std::string& where) {
  const bool has_solve = json.contains("solve");
  const Json solve = has_solve ? json["solve"] : Json::object();
  const std::string solve_path = key_path(where, "solve");
  if (has_solve) check_keys(solve, SceneObject::Solve, solve_path);

  const auto visit = [&](const auto& option, auto& target) {
    const std::string_view key = option.name;
    const bool here = json.contains(key);
    const bool in_solve = solve.contains(key);
    if (here && in_solve)
      refuse(key_path(solve_path, key), "stands in " + where + " as well; once is enough");
    note_given(given, json, key, where);
    note_given(given, solve, key, solve_path);
    if (!here && !in_solve) return;
    const std::string path = key_path(in_solve ? solve_path : where, key);
    with_value(option, (in_solve ? solve : json)[std::string(key)], path,
               [&](const OptionValue& value) { set_option(option, target, value, path); });
  };
  for (const FitOption& option : option_table())
    if (option.stage != OptionStage::Fineness) visit(option, static_cast<FitSettings&>(settings));
  for (const PointOption& option : point_option_table()) visit(option, settings.points);
  apply_fineness(json, where, settings);
  for (const FitOption& option : option_table())
    if (option.stage == OptionStage::Fineness) note_given(given, json, option.name, where);
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
