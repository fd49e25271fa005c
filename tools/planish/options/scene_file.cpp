#include "options/scene_file.h"
#include "job/sample_surface.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "options/json_lines.h"
#include "options/scene_moves.h"
#include "options/scene_settings.h"
#include "options/scene_values.h"
#include "options/strict_json.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/nearest.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_file.h"
#include "planish/job/input.h"
#include "planish/job/point_input.h"

namespace planish::command {
namespace {

Sampling sampling_of(const Json& json, const std::string& where) {
  constexpr std::int64_t kMostPoints = 10'000'000;
  constexpr std::array<std::string_view, 2> kPatterns{"poisson-disk", "uniform"};
  check_keys(json, SceneObject::Sample, where);
  Sampling sampling;
  sampling.draw = sample_surface;
  if (!json.contains("points")) refuse(where, "has no \"points\"");
  const auto path = [&](std::string_view key) { return key_path(where, key); };
  sampling.points = count_of(json["points"], path("points"), 4, kMostPoints);
  if (json.contains("pattern")) {
    const std::string_view pattern = text_of(json["pattern"], path("pattern"));
    sampling.poisson_disk = pattern == kPatterns[0];
    if (std::ranges::find(kPatterns, pattern) == kPatterns.end())
      refuse(path("pattern"), "\"{}\" is not one of poisson-disk, uniform{}", visible(pattern),
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
  JobParser(const Settings& defaults, std::vector<GivenSetting> given, std::filesystem::path folder)
      : defaults_(defaults), given_(std::move(given)), folder_(std::move(folder)) {}

  Job parse(const Json& json, const std::string& where) const {
    check_keys(json, SceneObject::Job, where);
    Job job;
    job.settings = defaults_;
    job.given = given_;
    apply_settings(job.settings, job.given, json, where);
    for (const char* const key : {"sample", "moves", "source", "page"})
      note_given(job.given, json, key, where);
    check_consistent_at(job.settings, where);
    if (!json.contains("input")) refuse(where, "has no \"input\"");
    job.input = path_of(json["input"], key_path(where, "input"));
    job.name = std::filesystem::path(job.input).stem().string();
    if (json.contains("name")) job.name = text_of(json["name"], key_path(where, "name"));
    job.label = job.name = visible(job.name);
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
    if (json.contains("moves")) {
      const std::string path = key_path(where, "moves");
      job.moves = moves_of(json["moves"], path);
      if (job.sampling || is_point_path(job.input, job.input_format))
        refuse(path, "are of vertices of a mesh; the input holds points");
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
        refuse(path, "\"{}\" is not one of surface, cage{}", visible(what),
               did_you_mean(what, kKinds));
      }
    }
    const bool cage = request.kind == OutputKind::Cage;
    if (cage) {
      for (const char* const key : {"levels", "chord_errors", "angle"})
        if (json.contains(key)) refuse(key_path(where, key), "a cage has no levels");
      return request;
    }
    FitSettings fineness = settings;
    apply_fineness(json, where, fineness);
    request.levels = fineness.levels;
    request.by_density = fineness.levels_by_density;
    request.adaptive = fineness.adaptive;
    request.lods_in_one = settings.lods == LodChoice::Msft;
    if (request.adaptive.any() && settings.scheme != Scheme::DooSabin)
      refuse(where, "only Doo-Sabin surfaces have chord errors and angles; take levels");
    return request;
  }

  Settings defaults_;
  std::vector<GivenSetting> given_;
  std::filesystem::path folder_;
};

// "a, b and c", but not hundreds of them.
std::string listed(const std::vector<std::string_view>& names) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), kMost); ++i)
    text += (i == 0 ? "" : ", ") + std::string(names[i]);
  return names.size() > kMost ? formatted("{}, and {} more", text, names.size() - kMost) : text;
}

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
  std::vector<GivenSetting> given;
  if (scene.contains("defaults")) {
    const std::string where = key_path(name, "defaults");
    check_keys(scene["defaults"], SceneObject::Defaults, where);
    apply_settings(defaults, given, scene["defaults"], where);
  }
  const Json& list = scene["jobs"];
  const std::string where = key_path(name, "jobs");
  if (list.is_array() && list.empty()) refuse(where, "is empty");
  const JobParser parser(defaults, std::move(given), folder);
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
std::string with_line(const std::string& message, const std::string& name,
                      const std::map<std::string, int>& lines) {
  const std::string head = name + ": ";
  if (!message.starts_with(head)) return message;
  std::string path = message.substr(head.size(), message.find(": ", head.size()) - head.size());
  while (!path.empty()) {
    const auto found = lines.find(path);
    if (found != lines.end())
      return formatted("{}:{}: {}", name, found->second, message.substr(head.size()));
    const std::size_t cut = path.find_last_of(".[");
    path.resize(cut == std::string::npos ? 0 : cut);
  }
  return message;
}

}  // namespace

std::vector<Job> parse_scene(std::string_view text, const std::string& name,
                             const std::filesystem::path& folder) {
  const Json scene = parse_json(text, name);
  const std::map<std::string, int> lines = lines_of_json(text);
  try {
    std::vector<Job> jobs = jobs_of(scene, name, folder);
    for (Job& job : jobs) {
      for (GivenSetting& given : job.given) given.where = with_line(given.where, name, lines);
      for (SceneMove& move : job.moves) move.where = with_line(move.where, name, lines);
    }
    return jobs;
  } catch (const Error& error) {
    throw Error(error.code(), with_line(error.what(), name, lines), error.element());
  }
}

std::string read_scene_text(const std::filesystem::path& path) {
  try {
    const RawVector<std::byte> bytes = read_file(path);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  } catch (const Error& error) {
    throw Error(ErrorCode::InvalidArgument, error.what());
  }
}

std::vector<Job> read_scene_file(const std::filesystem::path& path) {
  return parse_scene(read_scene_text(path), visible(path), path.parent_path());
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
