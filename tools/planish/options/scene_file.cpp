#include "options/scene_file.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <set>

#include "job/input.h"
#include "job/point_input.h"
#include "options/json_lines.h"
#include "options/nearest.h"
#include "options/point_settings.h"
#include "options/refuse.h"
#include "options/scene_values.h"
#include "options/strict_json.h"
#include "page/page_job.h"
#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_file.h"

namespace planish::command {
namespace {

void check_keys(const Json& json, SceneObject kind, const std::string& where) {
  require_object(json, where);
  const std::vector<std::string_view> known = scene_keys(kind);
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(known, key) == known.end())
      refuse(key_path(where, key), "this key is not known" + did_you_mean(key, known));
  }
}

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

// What says how fine a surface is takes the place of what said so before.
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

template <class Visit>
void for_entries(const Json& json, const std::string& where, const Visit& visit) {
  if (!json.is_array()) refuse(where, std::string("a list is wanted, not ") + json.type_name());
  for (std::size_t i = 0; i < json.size(); ++i) visit(json[i], entry_path(where, i));
}

std::int32_t vertex_of(const Json& json, const std::string& where) {
  const std::int64_t vertex = integer_of(json, where);
  if (vertex < 0) refuse(where, "a vertex counted from 0 is wanted, not " + std::to_string(vertex));
  return static_cast<std::int32_t>(vertex);
}

// Settings of one object. A key may stand in the object or in its "solve", not in both.
void apply_settings(Settings& settings, const Json& json, const std::string& where) {
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
}

Sampling sampling_of(const Json& json, const std::string& where) {
  constexpr std::int64_t kMostPoints = 10'000'000;
  constexpr std::array<std::string_view, 2> kPatterns{"poisson-disk", "uniform"};
  check_keys(json, SceneObject::Sample, where);
  Sampling sampling;
  if (!json.contains("points")) refuse(where, "has no \"points\"");
  const auto path = [&](std::string_view key) { return key_path(where, key); };
  sampling.points = count_of(json["points"], path("points"), 4, kMostPoints);
  if (json.contains("pattern")) {
    const std::string& pattern = text_of(json["pattern"], path("pattern"));
    sampling.poisson_disk = pattern == kPatterns[0];
    if (std::ranges::find(kPatterns, pattern) == kPatterns.end())
      refuse(path("pattern"), "\"" + visible(pattern) + "\" is not one of poisson-disk, uniform" +
                                  did_you_mean(pattern, kPatterns));
  }
  if (json.contains("seed"))
    sampling.seed = static_cast<std::uint32_t>(count_of(json["seed"], path("seed"), 0, INT32_MAX));
  if (json.contains("noise")) sampling.noise = fraction_of(json["noise"], path("noise"));
  if (json.contains("outliers"))
    sampling.outliers = fraction_of(json["outliers"], path("outliers"));
  return sampling;
}

class JobParser {
 public:
  JobParser(const Settings& defaults, std::filesystem::path folder)
      : defaults_(defaults), folder_(std::move(folder)) {}

  Job parse(const Json& json, const std::string& where) const {
    check_keys(json, SceneObject::Job, where);
    Job job;
    job.settings = defaults_;
    apply_settings(job.settings, json, where);
    check_consistent_at(job.settings, where);
    if (!json.contains("input")) refuse(where, "has no \"input\"");
    job.input = path_of(json["input"], key_path(where, "input"));
    job.name = std::filesystem::path(job.input).stem().string();
    if (json.contains("name")) job.name = text_of(json["name"], key_path(where, "name"));
    job.name = visible(job.name);
    if (job.name.empty()) refuse(key_path(where, "name"), "is empty");
    if (json.contains("input_format")) {
      const std::string path = key_path(where, "input_format");
      job.input_format = parse_input_format(text_of(json["input_format"], path), path);
    }
    if (is_point_path(job.input, job.input_format)) (void)require_mesher();
    if (json.contains("source")) job.source = path_of(json["source"], key_path(where, "source"));
    if (json.contains("sample")) {
      const std::string path = key_path(where, "sample");
      if (is_point_path(job.input, job.input_format))
        refuse(path, "the input holds points already");
      job.sampling = sampling_of(json["sample"], path);
    }
    if (json.contains("outputs")) parse_outputs(job, json["outputs"], key_path(where, "outputs"));
    if (json.contains("report")) job.report = path_of(json["report"], key_path(where, "report"));
    if (json.contains("page")) {
      job.page = path_of(json["page"], key_path(where, "page"));
      require_page_path(job.page, key_path(where, "page"));
    }
    return job;
  }

 private:
  static void check_consistent_at(const Settings& settings, const std::string& where) {
    try {
      check_consistent(settings);
    } catch (const Error& error) {
      refuse(where, error.what());
    }
  }

  std::string path_of(const Json& json, const std::string& where) const {
    const std::string& text = text_of(json, where);
    if (text.empty()) refuse(where, "is empty");
    if (text == "-") refuse(where, "a file is wanted; a scene does not use stdin or stdout");
    // Tables and messages show the path as it was written where the folder is the current one.
    return folder_.empty() ? text : (folder_ / text).lexically_normal().string();
  }

  void parse_outputs(Job& job, const Json& json, const std::string& where) const {
    for_entries(json, where, [&](const Json& output, const std::string& entry) {
      job.outputs.push_back(parse_output(output, entry, job.settings));
    });
  }

  OutputRequest parse_output(const Json& json, const std::string& where,
                             const Settings& settings) const {
    check_keys(json, SceneObject::Output, where);
    OutputRequest request;
    request.where = where;
    if (!json.contains("path")) refuse(where, "has no \"path\"");
    request.path = path_of(json["path"], key_path(where, "path"));
    if (json.contains("what")) {
      const std::string path = key_path(where, "what");
      const std::string& what = text_of(json["what"], path);
      constexpr std::array<std::string_view, 2> kKinds{"surface", "cage"};
      if (what == kKinds[1]) request.kind = OutputKind::Cage;
      if (std::ranges::find(kKinds, what) == kKinds.end()) {
        refuse(path, "\"" + visible(what) + "\" is not one of surface, cage" +
                         did_you_mean(what, kKinds));
      }
    }
    const bool cage = request.kind == OutputKind::Cage;
    if (cage) {
      for (const char* const key : {"levels", "chord_errors", "angle"})
        if (json.contains(key)) refuse(key_path(where, key), "a cage has no levels");
      return request;
    }
    request.levels = settings.levels;
    request.adaptive = settings.adaptive;
    apply_fineness(json, where, request.levels, request.adaptive);
    if (request.adaptive.any() && settings.scheme != Scheme::DooSabin)
      refuse(where, "only Doo-Sabin surfaces have chord errors and angles; take levels");
    return request;
  }

  Settings defaults_;
  std::filesystem::path folder_;
};

// "a, b and c", but not hundreds of them.
std::string listed(const std::vector<std::string_view>& names) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i == 0 ? "" : ", ") + std::string(names[i]);
  return names.size() > kMost ? text + ", and " + std::to_string(names.size() - kMost) + " more"
                              : text;
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

namespace {

std::vector<Job> jobs_of(const Json& scene, const std::string& name,
                         const std::filesystem::path& folder) {
  check_keys(scene, SceneObject::Scene, name);
  if (!scene.contains("version")) refuse(name, "has no \"version\"; this planish reads version 1");
  if (scene["version"] != Json(1)) {
    refuse(key_path(name, "version"),
           scene["version"].dump().substr(0, 40) + " is not known; this planish reads version 1");
  }
  if (!scene.contains("jobs")) refuse(name, "has no \"jobs\"");
  Settings defaults;
  if (scene.contains("defaults")) {
    const std::string where = key_path(name, "defaults");
    check_keys(scene["defaults"], SceneObject::Defaults, where);
    apply_settings(defaults, scene["defaults"], where);
  }
  const Json& list = scene["jobs"];
  const std::string where = key_path(name, "jobs");
  if (list.is_array() && list.empty()) refuse(where, "is empty");
  const JobParser parser(defaults, folder);
  std::vector<Job> jobs;
  std::set<std::string> names;
  for_entries(list, where, [&](const Json& json, const std::string& entry) {
    jobs.push_back(parser.parse(json, entry));
    if (!names.insert(jobs.back().name).second) {
      refuse(key_path(entry, "name"), "\"" + jobs.back().name + "\" is the name of an earlier job");
    }
  });
  return jobs;
}

// "scene.json: jobs[0].name: ..." with the line of that key, or of the nearest above it.
std::string with_line(const std::string& message, const std::string& name, std::string_view text) {
  const std::string head = name + ": ";
  if (!message.starts_with(head)) return message;
  std::string path = message.substr(head.size(), message.find(": ", head.size()) - head.size());
  const auto lines = lines_of_json(text);
  while (!path.empty()) {
    const auto found = lines.find(path);
    if (found != lines.end())
      return name + ":" + std::to_string(found->second) + ": " + message.substr(head.size());
    const std::size_t cut = path.find_last_of(".[");
    path.resize(cut == std::string::npos ? 0 : cut);
  }
  return message;
}

}  // namespace

std::vector<Job> parse_scene(std::string_view text, const std::string& name,
                             const std::filesystem::path& folder) {
  const Json scene = parse_json(text, name);
  try {
    return jobs_of(scene, name, folder);
  } catch (const Error& error) {
    throw Error(error.code(), with_line(error.what(), name, text), error.element());
  }
}

std::vector<Job> read_scene_file(const std::filesystem::path& path) {
  RawVector<std::byte> bytes;
  try {
    bytes = read_file(path);
  } catch (const Error& error) {
    throw Error(ErrorCode::InvalidArgument, error.what());
  }
  return parse_scene({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, visible(path),
                     path.parent_path());
}

std::vector<Job> select_jobs(std::vector<Job> jobs, const std::vector<std::string>& names) {
  if (names.empty()) return jobs;
  std::vector<std::string_view> known;
  known.reserve(jobs.size());
  for (const Job& job : jobs) known.push_back(job.name);
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) == known.end())
      refuse("the scene has no job \"" + visible(name) + "\"",
             "it has " + listed(known) + did_you_mean(name, known));
  }
  std::erase_if(jobs,
                [&](const Job& job) { return std::ranges::find(names, job.name) == names.end(); });
  return jobs;
}

}  // namespace planish::command
