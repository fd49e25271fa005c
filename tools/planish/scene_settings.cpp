#include <algorithm>
#include <cmath>
#include <cstdint>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"
#include "scene_file.h"

namespace planish::command {

void require_object(const Json& json, const std::string& where) {
  if (!json.is_object()) refuse(where, std::string("an object is wanted, not ") + json.type_name());
}

const std::string& text_of(const Json& json, const std::string& where) {
  if (!json.is_string()) refuse(where, std::string("a text is wanted, not ") + json.type_name());
  return json.get_ref<const std::string&>();
}

std::int64_t integer_of(const Json& json, const std::string& where) {
  const bool too_large = json.is_number_unsigned() && json.get<std::uint64_t>() > INT32_MAX;
  if (!json.is_number_integer() || too_large) {
    refuse(where, "a whole number is wanted, not " + json.dump().substr(0, 40));
  }
  return json.get<std::int64_t>();
}

std::string key_path(const std::string& where, std::string_view key) {
  // "scene.json" is followed by ": ", everything deeper by '.'.
  const bool top = where.find(": ") == std::string::npos;
  return where + (top ? ": " : ".") + visible(key);
}

std::string entry_path(const std::string& where, std::size_t index) {
  return formatted("{}[{}]", where, index);
}

void for_entries(const Json& json, const std::string& where,
                 const std::function<void(const Json&, const std::string&)>& visit) {
  if (!json.is_array()) refuse(where, std::string("a list is wanted, not ") + json.type_name());
  for (std::size_t i = 0; i < json.size(); ++i) visit(json[i], entry_path(where, i));
}

double number_of(const Json& json, const std::string& where) {
  if (!json.is_number()) refuse(where, std::string("a number is wanted, not ") + json.type_name());
  return json.get<double>();
}

std::int64_t count_of(const Json& json, const std::string& where, std::int64_t least,
                      std::int64_t most) {
  const std::int64_t number = integer_of(json, where);
  if (number < least || number > most)
    refuse(where, "{} is not from {} to {}", number, least, most);
  return number;
}

namespace {

// What is no option: how jobs and outputs are put together.
constexpr const char* kFrame = R"({
"$schema": "https://json-schema.org/draft/2020-12/schema",
"title": "planish scene file, version 1",
"description": "Jobs for `planish run`. A setting may stand in an object or in its \"solve\", not in both.",
"type": "object", "additionalProperties": false, "required": ["version", "jobs"],
"properties": {
  "$schema": {"description": "for editors", "type": "string", "examples": ["scene.schema.json"]},
  "version": {"const": 1, "examples": [1]},
  "defaults": {"$ref": "#/$defs/settings"},
  "jobs": {"type": "array", "minItems": 1, "items": {"$ref": "#/$defs/job"},
    "examples": [[{"input": "goblet.obj"}]]}},
"$defs": {
  "settings": {"type": "object", "additionalProperties": false, "properties": {},
    "examples": [{"tolerance": 1e-6}]},
  "solve": {"type": "object", "additionalProperties": false, "properties": {},
    "examples": [{"solver": "plain"}]},
  "job": {"type": "object", "additionalProperties": false, "required": ["input"], "properties": {
    "name": {"description": "in tables and messages; the input's name without extension where missing",
      "type": "string", "minLength": 1, "examples": ["goblet"]},
    "input": {"description": "mesh file, relative to this file",
      "type": "string", "minLength": 1, "examples": ["goblet.obj"]},
    "input_format": {"description": "against the extension", "enum": [], "examples": ["obj"]},
    "outputs": {"description": "files to write", "type": "array", "items": {"$ref": "#/$defs/output"},
      "examples": [[{"path": "goblet.glb"}]]},
    "moves": {"description": "vertices that move after the fit, one move after another; only what they reach is solved again, and outputs, report and page are of the moved surface",
      "type": "array", "minItems": 1, "items": {"$ref": "#/$defs/move"},
      "examples": [[{"vertices": [17], "by": [0, 0, 0.1]}]]},
    "source": {"description": "mesh that the report compares the surface with, not the input; relative to this file",
      "type": "string", "minLength": 1, "examples": ["scan.ply"]},
    "report": {"description": "JSON report, relative to this file",
      "type": "string", "minLength": 1, "examples": ["goblet.json"]},
    "page": {"description": "HTML page to look at, relative to this file",
      "type": "string", "minLength": 1, "pattern": "\\.html?$", "examples": ["goblet.html"]}}},
  "output": {"type": "object", "additionalProperties": false, "required": ["path"], "properties": {
    "path": {"description": "relative to this file; ", "type": "string", "minLength": 1,
      "examples": ["out/goblet.glb"]},
    "what": {"description": "the surface, or its control cage", "enum": ["surface", "cage"],
      "default": "surface", "examples": ["surface"]}}},
  "move": {
    "description": "one of to, by and matrix goes with vertices",
    "type": "object", "additionalProperties": false,
    "examples": [{"vertices": [17], "by": [0, 0, 0.1], "radius": 0.5}], "properties": {
    "vertices": {"description": "of the input, from 0", "type": "array",
      "items": {"type": "integer", "minimum": 0, "maximum": 2147483647}, "examples": [[17, 18]]},
    "to": {"description": "a position for each vertex, in the mesh's unit", "type": "array",
      "items": {"$ref": "#/$defs/point"}, "examples": [[[0, 0, 1], [1, 0, 1]]]},
    "by": {"$ref": "#/$defs/point"},
    "matrix": {"description": "an affine map: three rows of four numbers, the fourth of each what is added",
      "type": "array", "minItems": 3, "maxItems": 3,
      "items": {"type": "array", "minItems": 4, "maxItems": 4, "items": {"type": "number"}},
      "examples": [[[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.1]]]},
    "radius": {"description": "with by and matrix: vertices within this length along edges move along, ever less",
      "type": "number", "exclusiveMinimum": 0, "examples": [0.5]},
    "undo": {"description": "by itself: takes back so many moves", "type": "integer", "minimum": 1,
      "maximum": 2147483647, "examples": [1]}}},
  "point": {"description": "x, y, z in the mesh's unit", "type": "array", "minItems": 3, "maxItems": 3,
    "items": {"type": "number"}, "examples": [[0, 0, 0.1]]}}
})";

Json words_of(const OptionInfo& option) {
  Json words = Json::array();
  for (const std::string_view word : option.words) words.push_back(word);
  return words;
}

Json limit_json(double limit) {
  return std::trunc(limit) == limit ? Json(static_cast<std::int64_t>(limit)) : Json(limit);
}

Json number_json(const OptionInfo& option, const char* type) {
  const OptionLimits& limits = option.limits;
  return {{"type", type},
          {limits.above_least ? "exclusiveMinimum" : "minimum", limit_json(limits.least)},
          {limits.below_most ? "exclusiveMaximum" : "maximum", limit_json(limits.most)}};
}

Json list_json(const Json& items) { return {{"type", "array"}, {"items", items}}; }

Json several_json(const Json& items) {
  Json json = list_json(items);
  json["minItems"] = 1;
  json["uniqueItems"] = true;
  return json;
}

Json list_or_word_json(const OptionInfo& option, const Json& list) {
  if (option.word.empty()) return list;
  return {{"anyOf", {list, {{"const", option.word}}}}};
}

Json text_json(const OptionInfo& option) {
  if (option.pattern.empty()) return {{"type", "string"}, {"minLength", 1}};
  return {{"type", "string"}, {"pattern", option.pattern}};
}

Json words_json(const OptionInfo& option) {
  std::string any;
  for (const std::string_view word : option.words)
    any += (any.empty() ? "(" : "|") + std::string(word);
  any += ")";
  return {{"type", "string"}, {"pattern", "^" + any + "(," + any + ")*$"}};
}

Json type_json(const OptionInfo& option) {
  const Json vertex = {{"type", "integer"}, {"minimum", 0}};
  switch (option.kind) {
    case OptionKind::Word:
      return {{"enum", words_of(option)}};
    case OptionKind::Words:
      return words_json(option);
    case OptionKind::Text:
      return text_json(option);
    case OptionKind::TextOrNumber:
      return {{"type", {"string", "number"}}};
    case OptionKind::Whole:
      return number_json(option, "integer");
    case OptionKind::Number:
      return number_json(option, "number");
    case OptionKind::Switch:
      return {{"type", "boolean"}};
    case OptionKind::Wholes:
      return list_or_word_json(option, several_json(number_json(option, "integer")));
    case OptionKind::Numbers:
      return several_json(number_json(option, "number"));
    case OptionKind::Vertices:
      return list_json(vertex);
    case OptionKind::Edges: {
      Json edge = list_json(vertex);
      edge["minItems"] = edge["maxItems"] = 2;
      return list_json(edge);
    }
  }
  return {};
}

}  // namespace

Json value_json(const OptionInfo& option, std::string_view text) {
  switch (option.kind) {
    case OptionKind::Word:
    case OptionKind::Words:
    case OptionKind::Text:
    case OptionKind::TextOrNumber:
      return text;
    case OptionKind::Wholes:
    case OptionKind::Numbers:
      if (!option.word.empty() && text == option.word) return text;
      return Json::parse("[" + std::string(text) + "]");
    default:
      return Json::parse(text);
  }
}

namespace {

Json description_of(const OptionInfo& option) {
  const bool is_of_points = option.stage == OptionStage::Points;
  Json json = {{"description", (is_of_points ? "points only: " : "") + std::string(option.help)}};
  json.update(type_json(option));
  if (!option.initial.empty()) json["default"] = value_json(option, option.initial);
  const std::string_view example = !option.example.empty()   ? option.example
                                   : !option.initial.empty() ? option.initial
                                                             : option.words.front();
  json["examples"] = Json::array({value_json(option, example)});
  return json;
}

// May stand in the object itself or in its "solve".
bool belongs_to_solve(const OptionInfo& option) {
  return option.stage == OptionStage::Shape || option.stage == OptionStage::Solve;
}

Json make_schema() {
  Json schema = Json::parse(kFrame);
  Json& defs = schema["$defs"];
  const auto properties = [&](const char* object) -> Json& { return defs[object]["properties"]; };
  const auto add = [&](const OptionInfo& option) {
    const std::string name(option.name);
    const Json reference = {{"$ref", "#/$defs/settings/properties/" + name}};
    properties("settings")[name] = description_of(option);
    properties("job")[name] = reference;
    if (belongs_to_solve(option)) properties("solve")[name] = reference;
    if (option.stage == OptionStage::Fineness) properties("output")[name] = reference;
  };
  for (const FitOption& option : option_table()) add(option);
  for (const PointOption& option : point_option_table()) add(option);
  for (const char* const object : {"settings", "job"})
    properties(object)["solve"] = {{"$ref", "#/$defs/solve"}};
  for (const FormatInfo& info : formats())
    if (serves(info.format, FormatUse::Read))
      properties("job")["input_format"]["enum"].push_back(info.name);
  const auto name_extensions = [&](const char* key, const std::string& text) {
    std::string& description = properties("output")[key]["description"].get_ref<std::string&>();
    description += text;
  };
  name_extensions("path", extensions_of(FormatUse::WriteSurface));
  name_extensions("what", " (" + extensions_of(FormatUse::WriteCage) + ")");
  return schema;
}

const Json& scene_schema() {
  static const Json schema = make_schema();
  return schema;
}

}  // namespace

std::string scene_schema_text() { return json_text(scene_schema()); }

std::vector<std::string_view> scene_keys(SceneObject object) {
  const char* const names[] = {"", "settings", "job", "solve", "output", "move"};
  const Json& schema = scene_schema();
  const Json& described =
      object == SceneObject::Scene ? schema : schema["$defs"][names[static_cast<int>(object)]];
  std::vector<std::string_view> keys;
  for (const auto& [key, value] : described["properties"].items()) keys.push_back(key);
  return keys;
}

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
  // What is said here takes the place of what was said outside.
  std::string_view first;
  for (const FitOption& option : option_table()) {
    if (option.stage != OptionStage::Fineness || !json.contains(option.name)) continue;
    const bool is_beside = option.name == "angle" && first == "chord_errors";
    if (!first.empty() && !is_beside)
      refuse(key_path(where, first), "a surface has {} or {}, not both; leave one of them out",
             first, option.name);
    if (first.empty()) {
      first = option.name;
      AdaptiveChoice outside = std::exchange(settings.adaptive, {});
      if (first == "angle") settings.adaptive.chord_errors = std::move(outside.chord_errors);
      if (first == "chord_errors") settings.adaptive.angle = outside.angle;
    }
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
