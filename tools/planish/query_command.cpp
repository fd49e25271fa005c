#include "query_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "commands.h"
#include "devices.h"
#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/job/input.h"
#include "planish/job/job_input.h"
#include "planish/job/job_text.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/job/staged_files.h"
#include "planish/pipeline/option_table.h"
#include "planish/queries/surface_queries.h"
#include "terminal.h"

namespace planish::command {
namespace {

constexpr std::size_t kAnswersAtOnce = 8192;
constexpr std::size_t kTextGrain = 256;  // answers that a thread writes out at once

template <class Number>
void append(std::string& text, Number number) {
  using Bits = std::conditional_t<sizeof(Number) == 8, std::uint64_t, std::uint32_t>;
  const Bits bits = std::bit_cast<Bits>(number);
  for (std::size_t i = 0; i < sizeof(Number); ++i)
    text.push_back(static_cast<char>(bits >> (8 * i) & 0xff));
}

void append_ply(std::string& text, const QueryAnswer& answer) {
  for (int d = 0; d < 3; ++d) append(text, answer.position[d]);
  for (int d = 0; d < 3; ++d) append(text, static_cast<float>(answer.normal[d]));
  append(text, answer.distance);
  append(text, answer.at.face);
  append(text, answer.at.u);
  append(text, answer.at.v);
}

nlohmann::ordered_json point_json(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

nlohmann::ordered_json answer_json(const QueryAnswer& answer, std::string_view distance_name) {
  if (answer.at.face < 0) return nullptr;
  nlohmann::ordered_json json;
  json[std::string(distance_name)] = answer.distance;
  json["position"] = point_json(answer.position);
  json["normal"] = point_json(answer.normal);
  json["at"] = {{"face", answer.at.face}, {"u", answer.at.u}, {"v", answer.at.v}};
  if (distance_name == "t") return json;
  const PointCurvature& curvature = answer.curvature;
  json["mean_curvature"] = curvature.is_known ? nlohmann::ordered_json(curvature.mean) : nullptr;
  json["gaussian_curvature"] =
      curvature.is_known ? nlohmann::ordered_json(curvature.gaussian) : nullptr;
  return json;
}

// As an entry of a list in an object, with the line's end before it.
void append_json(std::string& text, const nlohmann::ordered_json& json) {
  text += "\n    ";
  for (const char c : json.dump(2)) {
    text += c;
    if (c == '\n') text += "    ";
  }
}

// Some answers at a time; write(text, answer) makes the text of one, on any thread.
template <class Write>
void for_answers(std::span<const glm::dvec3> points, const Answer& answer, const Write& write,
                 const TakeBytes& take) {
  std::vector<QueryAnswer> answers;
  std::vector<std::string> texts;
  for (std::size_t first = 0; first < points.size(); first += kAnswersAtOnce) {
    const auto some = points.subspan(first, std::min(kAnswersAtOnce, points.size() - first));
    answers.assign(some.size(), {});
    answer(some, answers);
    texts.resize((some.size() + kTextGrain - 1) / kTextGrain);
    parallel_each(texts.size(), 1, [&](std::size_t t) {
      texts[t].clear();
      const std::size_t last = std::min(some.size(), (t + 1) * kTextGrain);
      for (std::size_t i = t * kTextGrain; i < last; ++i) write(texts[t], answers[i], first + i);
    });
    for (const std::string& text : texts) take(text);
  }
}

}  // namespace

void answers_ply(std::span<const glm::dvec3> points, const Answer& answer,
                 std::string_view distance_name, const TakeBytes& take) {
  std::string text =
      formatted("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.size());
  for (const char* const name : {"x", "y", "z"})
    text += "property double " + std::string(name) + "\n";
  for (const char* const name : {"nx", "ny", "nz"})
    text += "property float " + std::string(name) + "\n";
  text += "property double " + std::string(distance_name) +
          "\nproperty int face\nproperty double u\nproperty double v\nend_header\n";
  take(text);
  for_answers(
      points, answer,
      [](std::string& bytes, const QueryAnswer& of, std::size_t) { append_ply(bytes, of); }, take);
}

void answers_json(const nlohmann::ordered_json& head, std::string_view list,
                  std::span<const glm::dvec3> points, const Answer& answer,
                  std::string_view distance_name, const TakeBytes& take) {
  nlohmann::ordered_json whole = head;
  whole[std::string(list)] = nlohmann::ordered_json::array();
  const std::string text = json_text(whole);
  constexpr std::string_view kEnd = "]\n}\n";
  take(std::string_view(text).substr(0, text.size() - kEnd.size()));
  for_answers(
      points, answer,
      [&](std::string& json, const QueryAnswer& of, std::size_t index) {
        if (index > 0) json += ',';
        append_json(json, answer_json(of, distance_name));
      },
      take);
  if (!points.empty()) take("\n  ");
  take(kEnd);
}

namespace {

constexpr std::size_t kAnswerGrain = 16;

}  // namespace

glm::dvec3 parse_direction(const std::string& text) {
  const auto fail = [&] {
    refuse("--rays", in_double_quotes(text) + " is no direction such as 0,0,-1");
  };
  glm::dvec3 direction(0.0);
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int d = 0; d < 3; ++d) {
    const auto [next, error] = std::from_chars(at, end, direction[d]);
    if (error != std::errc() || next == (d < 2 ? end : nullptr)) fail();
    if (d < 2 ? *next != ',' : next != end) fail();
    at = next + 1;
  }
  const double length = safe_length(direction);
  if (!(length > 0) || !std::isfinite(length)) fail();
  return direction;
}

std::vector<glm::dvec3> questions_of(PointCloud cloud, const std::string& path) {
  if (cloud.missing_count > 0) {
    throw Error(
        ErrorCode::UnreadableInput,
        formatted(
            "{}: {} of its points are not finite, and there is one answer a point; leave them out",
            visible(path), cloud.missing_count));
  }
  for (glm::dvec3& point : cloud.points) point += cloud.origin;
  return std::move(cloud.points);
}

void answer_closest(const SurfaceQueries& queries, std::span<const glm::dvec3> points,
                    bool with_curvature, std::span<QueryAnswer> answers) {
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  parallel_for(points.size(), kAnswerGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const ClosestPoint& found = closest[i];
      answers[i] = {found.position, found.normal, found.distance, found.at, {}};
      if (with_curvature) answers[i].curvature = queries.surface().evaluate(found.at).curvature();
    }
  });
}

void answer_rays(const SurfaceQueries& queries, const glm::dvec3& direction,
                 std::span<const glm::dvec3> points, std::span<QueryAnswer> answers) {
  parallel_for(points.size(), kAnswerGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      answers[i].position = points[i];
      if (const auto hit = queries.first_hit({points[i], direction}))
        answers[i] = {hit->position, hit->normal, hit->t, hit->at, {}};
    }
  });
}

namespace {

struct QueryFlags {
  std::string input, points, direction, output = "-";
  OptionTexts options;
  bool force = false;
  MessageFlags messages;
};

// What shapes a Doo-Sabin surface.
bool shapes_surface(const FitOption& option) {
  return option.name == "preset" || (option.stage == OptionStage::Shape && option.name != "scheme");
}

Settings settings_of_query(const QueryFlags& flags) {
  Settings settings;
  settings.device = "cpu";
  apply_flags<FitSettings>(flags.options, option_table(), settings);
  return settings;
}

bool wants_ply(const QueryFlags& flags) { return path_of(flags.output).extension() == ".ply"; }

nlohmann::ordered_json head_json(const QueryFlags& flags, const JobInput& made) {
  const PolygonMesh& mesh = made.fitted.mesh;
  nlohmann::ordered_json json;
  json["schema"] = "planish.query/1";
  json["input"] = {{"path", made.input.name}, {"sha256", made.input.sha256}};
  // What `at` counts: faces that were cut for the fit are the mesh's, not the file's.
  json["mesh"] = {{"vertices", mesh.vertex_count()}, {"faces", mesh.face_count()}};
  json["points"] = visible(flags.points);
  return json;
}

void make_answers(const QueryFlags& flags, const JobInput& made, const SurfaceQueries& queries,
                  std::span<const glm::dvec3> points, const TakeBytes& take) {
  const bool are_rays = !flags.direction.empty(), is_ply = wants_ply(flags);
  const glm::dvec3 direction = are_rays ? parse_direction(flags.direction) : glm::dvec3(0.0);
  const auto answer = [&](std::span<const glm::dvec3> some, std::span<QueryAnswer> answers) {
    check_interrupt();
    if (are_rays)
      answer_rays(queries, direction, some, answers);
    else
      answer_closest(queries, some, !is_ply, answers);
  };
  const char* const distance = are_rays ? "t" : "distance";
  if (is_ply)
    answers_ply(points, answer, distance, take);
  else
    answers_json(head_json(flags, made), are_rays ? "rays" : "closest", points, answer, distance,
                 take);
}

void write_answers(const QueryFlags& flags, const std::function<void(const TakeBytes&)>& make) {
  if (flags.output == "-") return make(write_stdout);
  StagedFiles staged(flags.force);
  const std::filesystem::path path = staged.stage(path_of(flags.output));
  staged.naming_targets([&] {
    OutputFile file(path);
    make([&](std::string_view bytes) { file.write(bytes); });
    file.commit();
  });
  check_interrupt();
  staged.commit();
}

std::vector<glm::dvec3> read_questions(const std::string& path, Console& console) {
  PointCloud cloud = read_points(path_of(path));
  for (const Warning& warning : cloud.warnings) console.warning(warning.message);
  return questions_of(std::move(cloud), path);
}

ExitCode run_query(const QueryFlags& flags) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  Job job;
  job.input = flags.input;
  job.name = job_name_of(flags.input);
  job.label = input_name(flags.input);
  job.mesher = require_counted_mesher;
  Faults faults;
  faults.note([&] { require_input(flags.input, {}); });
  faults.note([&] { require_input(flags.points, {}); });
  faults.note([&] { job.settings = settings_of_query(flags); });
  if (!flags.direction.empty()) faults.note([&] { (void)parse_direction(flags.direction); });
  PathClaims claims({.overwrite = flags.force});
  claims.add_input(path_of(flags.input), {}, job.settings.textures);
  claims.add_input(path_of(flags.points));
  faults.note([&] {
    const std::filesystem::path output = path_of(flags.output);
    if (output != "-" && output.extension() != ".json" && !wants_ply(flags))
      refuse("-o", visible(output) + ": answers are written as .json or .ply");
    claims.add_output(output, "-o");
  });
  faults.throw_if_any();
  // Before the fit, which a slip in them would be the waste of.
  const std::vector<glm::dvec3> points = read_questions(flags.points, console);

  Progress all(console, flags.messages.progress_mode());
  JobDisplay display(all, job.name);
  const JobWatch watch = watch_of(console, display);
  JobProgress progress(watch.progress);
  const JobContext context{watch, progress};
  JobReport report;
  report.label = job.label;
  report.settings = job.settings;
  const InputFile file = load_job_input(job, report, context);
  JobInput made = read_job_input(job, file, report, context);
  ReadyFit ready = prepare_input(made, report, context);
  const auto backend =
      open_backend(list_devices(DeviceScope::CpuOnly).devices.front(), job.settings);
  fit_input(made, std::move(ready), *backend, {}, report, context);
  const LimitSurface surface(
      fitted_surface(made.fitted.mesh, made.fitted.fit, made.fitted.evaluate_options()));
  const SurfaceQueries queries(surface);
  all.finish();
  write_answers(flags,
                [&](const TakeBytes& take) { make_answers(flags, made, queries, points, take); });
  return exit_code_of(report);
}

}  // namespace

void add_query_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand(
      "query", "closest points on the smooth surface of a mesh, or where rays meet it");
  auto flags = std::make_shared<QueryFlags>();
  command->add_option("INPUT", flags->input, "mesh or points, as fit takes them")
      ->type_name("INPUT")
      ->required();
  const auto option = [&](const char* name, auto& target, const std::string& help,
                          const std::string& type, const char* group) {
    return command->add_option(name, target, help)->type_name(type)->group(group);
  };
  option("--points", flags->points,
         "what to ask for, one answer a point (" + extensions_of(FormatUse::ReadPoints) + ")",
         "FILE", "Question")
      ->required();
  option("--rays", flags->direction,
         "not the closest point, but what a ray from each point along X,Y,Z meets first", "X,Y,Z",
         "Question");
  option("-o,--output", flags->output, "JSON, or a .ply of answers [JSON on stdout]", "FILE",
         "Files");
  command->add_flag("-f,--force", flags->force, "overwrite an existing file")->group("Files");
  for (const FitOption& shape : option_table())
    if (shapes_surface(shape)) add_option_flag(*command, flags->options, shape, "Surface");
  add_option_flag(*command, flags->options, fit_option("textures"), "Files");
  flags->messages.add_to(*command, true);
  invocation.texts["query"] = {
      .examples = {"planish query bunny.obj --points probes.xyz",
                   "planish query bunny.obj --points probes.ply --rays 0,0,-1 -o hits.json",
                   "planish query bunny.obj --points scan.ply -o distances.ply"},
      .first_flags = {},
      .notes =
          "Exact to rounding, on the limit surface itself. `at` names a face of the fitted mesh "
          "and (u, v) on it, as OpenSubdiv's Bfr::Parameterization has them. A ray that meets "
          "nothing has the answer null, in a .ply the face -1 at the point asked for."};
  command->callback(
      [flags, &invocation] { invocation.action = [flags] { return run_query(*flags); }; });
}

}  // namespace planish::command
