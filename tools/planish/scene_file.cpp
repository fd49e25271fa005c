#include "scene_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/read_file.h"
#include "planish/job/input.h"
#include "planish/job/job_settings.h"

namespace planish::command {
namespace {

// Refuses what the parser itself lets pass: deep nesting, which is copied and taken down
// recursively later, and keys that stand twice, of which the first would be ignored.
class StrictParse {
 public:
  explicit StrictParse(std::string name) : name_(std::move(name)) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    constexpr int kDeepest = 16;  // a scene needs 5
    if (depth > kDeepest) refuse(name_, "is nested too deeply to be a scene");
    if (event == Json::parse_event_t::object_start) keys_.emplace_back();
    if (event == Json::parse_event_t::object_end) keys_.pop_back();
    if (event == Json::parse_event_t::key) {
      const std::string& key = parsed.get_ref<const std::string&>();
      if (!keys_.back().insert(key).second) {
        refuse(name_, "the key \"" + visible(key) + "\" stands twice in an object");
      }
    }
    return true;
  }

 private:
  std::string name_;
  std::vector<std::set<std::string>> keys_;  // of the objects that are open
};

[[noreturn]] void refuse_at(std::size_t byte, std::string_view text, const std::string& name) {
  const std::string_view before = text.substr(0, std::min(byte, text.size()));
  const auto line = std::ranges::count(before, '\n') + 1;
  refuse(formatted("{}:{}", name, line), "no valid JSON here");
}

// Text as JSON, without what the parser itself lets pass: deep nesting and keys that stand twice.
// Throws Error{InvalidArgument}: `name:line: what`.
Json parse_json(std::string_view text, const std::string& name) {
  StrictParse strict(name);
  const auto check = [&](int depth, Json::parse_event_t event, Json& parsed) {
    return strict(depth, event, parsed);
  };
  // The parser takes a zero byte for the end, and looks at nothing behind it.
  if (const std::size_t zero = text.find('\0'); zero != std::string_view::npos)
    refuse_at(zero, text, name);
  try {
    return Json::parse(text, check);
  } catch (const Json::parse_error& error) {
    refuse_at(error.byte, text, name);
  } catch (const Json::exception& error) {
    refuse(name, std::string("no valid JSON: ") + error.what());
  }
}

// Walks over text that the parser has accepted.
class Walk {
 public:
  explicit Walk(std::string_view text) : text_(text) {}

  std::map<std::string, int> lines() {
    while (at_ < text_.size()) step();
    return std::move(lines_);
  }

 private:
  struct Level {
    bool is_list;
    std::string path;
    int index = 0;
    bool wants_key = true;
  };

  void step() {
    const char c = text_[at_];
    if (c == '\n') ++line_;
    if (c == '"') return take_text();
    if (c == '{' || c == '[') {
      note_entry();
      levels_.push_back({c == '[', path_});
    } else if (c == '}' || c == ']') {
      levels_.pop_back();
    } else if (c == ',') {
      if (levels_.back().is_list) ++levels_.back().index;
      levels_.back().wants_key = true;
    } else if (c == ':') {
      levels_.back().wants_key = false;
    } else if (c != ' ' && c != '\t' && c != '\r' && c != '\n') {
      note_entry();
    }
    ++at_;
  }

  void take_text() {
    const std::size_t begin = at_ + 1;
    for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_)
      if (text_[at_] == '\\') ++at_;
    const std::string_view content = text_.substr(begin, at_ - begin);
    ++at_;
    const bool is_key = !levels_.empty() && !levels_.back().is_list && levels_.back().wants_key;
    if (!is_key) return note_entry();
    const std::string& above = levels_.back().path;
    path_ = (above.empty() ? "" : above + ".") + std::string(content);
    lines_.emplace(path_, line_);
  }

  // A value in a list has a path of its own.
  void note_entry() {
    if (levels_.empty() || !levels_.back().is_list) return;
    path_ = levels_.back().path + "[" + std::to_string(levels_.back().index) + "]";
    lines_.emplace(path_, line_);
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::string path_;  // of the key or entry last met
  std::vector<Level> levels_;
  std::map<std::string, int> lines_;
};

// The line, from 1, on which each key and each entry of a list stands in valid JSON text, by its
// path: "jobs[0].outputs[1].path".
std::map<std::string, int> lines_of_json(std::string_view text) { return Walk(text).lines(); }

// So many numbers: a point, or a row of a matrix.
std::vector<double> numbers_of(const Json& json, const std::string& where, std::size_t count) {
  if (!json.is_array() || json.size() != count) refuse(where, "{} numbers are wanted", count);
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i)
    numbers.push_back(number_of(json[i], entry_path(where, i)));
  return numbers;
}

glm::dvec3 point_of(const Json& json, const std::string& where) {
  const std::vector<double> numbers = numbers_of(json, where, 3);
  return {numbers[0], numbers[1], numbers[2]};
}

glm::dmat4 affine_map(const Json& json, const std::string& where) {
  if (!json.is_array() || json.size() != 3)
    refuse(where, "three rows of four numbers are wanted, the fourth of each what is added");
  glm::dmat4 map(1.0);
  for (int r = 0; r < 3; ++r) {
    const auto row = static_cast<std::size_t>(r);
    const std::vector<double> numbers = numbers_of(json[row], entry_path(where, row), 4);
    for (int c = 0; c < 4; ++c) map[c][r] = numbers[c];
  }
  return map;
}

SceneMove move_of(const Json& json, const std::string& where) {
  check_keys(json, SceneObject::Move, where);
  const auto path = [&](const char* key) { return key_path(where, key); };
  SceneMove move;
  move.where = where;
  if (json.contains("undo")) {
    if (json.size() > 1) refuse(where, "\"undo\" stands by itself");
    move.undo = count_of(json["undo"], path("undo"), 1, INT32_MAX);
    return move;
  }
  if (!json.contains("vertices")) refuse(where, "has no \"vertices\"");
  for_entries(
      json["vertices"], path("vertices"), [&](const Json& vertex, const std::string& entry) {
        move.vertices.push_back(static_cast<std::int32_t>(count_of(vertex, entry, 0, INT32_MAX)));
      });
  if (json.contains("to") + json.contains("by") + json.contains("matrix") != 1)
    refuse(where, "one of \"to\", \"by\" and \"matrix\" is wanted");
  if (json.contains("to")) {
    if (json.contains("radius"))
      refuse(path("radius"), "goes with \"by\" or \"matrix\", which say where others move to");
    for_entries(json["to"], path("to"), [&](const Json& point, const std::string& entry) {
      move.to.push_back(point_of(point, entry));
    });
    if (move.to.size() != move.vertices.size())
      refuse(path("to"), "{} positions stand there, and {} vertices", move.to.size(),
             move.vertices.size());
  }
  if (json.contains("by")) move.map[3] = glm::dvec4(point_of(json["by"], path("by")), 1.0);
  if (json.contains("matrix")) move.map = affine_map(json["matrix"], path("matrix"));
  if (json.contains("radius")) {
    move.radius = number_of(json["radius"], path("radius"));
    if (!(move.radius > 0)) refuse(path("radius"), "a length above 0 is wanted");
  }
  return move;
}

// The "moves" of a job. Throws Error{InvalidArgument}: where, what is wanted, what is.
std::vector<SceneMove> moves_of(const Json& json, const std::string& where) {
  if (json.is_array() && json.empty()) refuse(where, "is empty");
  std::vector<SceneMove> moves;
  for_entries(json, where, [&](const Json& move, const std::string& entry) {
    moves.push_back(move_of(move, entry));
  });
  return moves;
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
    for (const char* const key : {"moves", "source", "page"})
      note_given(job.given, json, key, where);
    check_consistent_at(job.settings, where);
    if (!json.contains("input")) refuse(where, "has no \"input\"");
    job.input = path_of(json["input"], key_path(where, "input"));
    job.name = utf8(planish::path_of(job.input).stem());
    if (json.contains("name")) job.name = text_of(json["name"], key_path(where, "name"));
    job.label = job.name = visible(job.name);
    if (job.name.empty()) refuse(key_path(where, "name"), "is empty");
    if (json.contains("input_format")) {
      const std::string path = key_path(where, "input_format");
      job.input_format = parse_input_format(text_of(json["input_format"], path), path);
    }
    if (is_point_path(job.input, job.input_format)) (void)require_mesher();
    if (json.contains("source")) job.source = path_of(json["source"], key_path(where, "source"));
    if (json.contains("moves")) {
      const std::string path = key_path(where, "moves");
      job.moves = moves_of(json["moves"], path);
      if (is_point_path(job.input, job.input_format))
        refuse(path, "are of vertices of a mesh; the input holds points");
    }
    if (json.contains("outputs")) parse_outputs(job, json["outputs"], key_path(where, "outputs"));
    if (json.contains("report")) job.report = path_of(json["report"], key_path(where, "report"));
    if (json.contains("page")) {
      job.page = path_of(json["page"], key_path(where, "page"));
      require_page_path(planish::path_of(job.page), key_path(where, "page"));
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
    return folder_.empty() ? text : utf8((folder_ / planish::path_of(text)).lexically_normal());
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
      for (const FitOption& option : option_table())
        if (option.stage == OptionStage::Fineness && json.contains(option.name))
          refuse(key_path(where, option.name), "a cage has no levels");
      return request;
    }
    FitSettings fineness = settings;
    apply_fineness(json, where, fineness);
    request.levels = fineness.levels;
    request.by_density = fineness.levels_by_density;
    request.adaptive = fineness.adaptive;
    request.lods_in_one = settings.lods == LodChoice::Msft;
    if (request.adaptive.any() && settings.scheme != Scheme::DooSabin)
      refuse(where, "only Doo-Sabin surfaces come in other than levels; take levels instead of {}",
             request.adaptive.kinds()[0]);
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
