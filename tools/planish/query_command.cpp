#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.h"
#include "devices.h"
#include "job/input_path.h"
#include "job/job_fit.h"
#include "job/job_input.h"
#include "options/input_list.h"
#include "options/refuse.h"
#include "options/word_flags.h"
#include "output/answers_ply.h"
#include "output/output_plan.h"
#include "output/staged_files.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_points.h"
#include "planish/limit/surface_queries.h"
#include "planish/mesh/check.h"
#include "report/report.h"
#include "terminal/faults.h"
#include "terminal/interrupt.h"

namespace planish::command {
namespace {

struct QueryFlags {
  std::string input, points, direction, output = "-";
  SettingWords words;  // by name of the setting
  bool force = false;
  MessageFlags messages;
};

// What shapes the surface, of all that fit takes.
bool shapes_surface(const WordSetting& setting) {
  static constexpr std::string_view kNames[] = {"preset",   "interpolation", "weights",
                                                "boundary", "creases",       "repair"};
  return std::ranges::find(kNames, setting.name) != std::end(kNames);
}

Settings settings_of_query(const QueryFlags& flags) {
  Settings settings;
  settings.device = "cpu";
  apply_words(flags.words, word_settings(), settings);
  if (settings.scheme != Scheme::DooSabin) refuse("--preset", "only Doo-Sabin surfaces answer");
  return settings;
}

glm::dvec3 parse_direction(const std::string& text) {
  const auto fail = [&] {
    refuse("--rays", "\"" + visible(text) + "\" is no direction such as 0,0,-1");
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
  if (!(glm::length(direction) > 0) || !std::isfinite(glm::length(direction))) fail();
  return direction;
}

nlohmann::ordered_json point_json(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

nlohmann::ordered_json place_json(const SurfaceParameter& at) {
  return {{"face", at.face}, {"u", at.u}, {"v", at.v}};
}

nlohmann::ordered_json closest_answers(const SurfaceQueries& queries,
                                       std::span<const glm::dvec3> points) {
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  nlohmann::ordered_json answers = nlohmann::ordered_json::array();
  for (const ClosestPoint& found : closest) {
    const PointCurvature curvature = queries.surface().evaluate(found.at).curvature();
    nlohmann::ordered_json answer = {{"distance", found.distance},
                                     {"position", point_json(found.position)},
                                     {"normal", point_json(found.normal)},
                                     {"at", place_json(found.at)}};
    answer["mean_curvature"] =
        curvature.is_known ? nlohmann::ordered_json(curvature.mean) : nullptr;
    answer["gaussian_curvature"] =
        curvature.is_known ? nlohmann::ordered_json(curvature.gaussian) : nullptr;
    answers.push_back(std::move(answer));
  }
  return answers;
}

nlohmann::ordered_json ray_answers(const SurfaceQueries& queries,
                                   std::span<const glm::dvec3> points,
                                   const glm::dvec3& direction) {
  nlohmann::ordered_json answers = nlohmann::ordered_json::array();
  for (const glm::dvec3& point : points) {
    const auto hit = queries.first_hit({point, direction});
    if (!hit) {
      answers.push_back(nullptr);
      continue;
    }
    answers.push_back({{"t", hit->t},
                       {"position", point_json(hit->position)},
                       {"normal", point_json(hit->normal)},
                       {"at", place_json(hit->at)}});
  }
  return answers;
}

std::string closest_ply(const SurfaceQueries& queries, std::span<const glm::dvec3> points) {
  std::vector<ClosestPoint> closest(points.size());
  queries.closest(points, closest);
  std::vector<PlyAnswer> answers;
  answers.reserve(closest.size());
  for (const ClosestPoint& found : closest)
    answers.push_back(
        {found.position, found.normal, found.distance, found.at.face, found.at.u, found.at.v});
  return answers_ply(answers, "distance");
}

std::string rays_ply(const SurfaceQueries& queries, std::span<const glm::dvec3> points,
                     const glm::dvec3& direction) {
  std::vector<PlyAnswer> answers;
  for (const glm::dvec3& point : points) {
    PlyAnswer answer{.position = point};
    if (const auto hit = queries.first_hit({point, direction}))
      answer = {hit->position, hit->normal, hit->t, hit->at.face, hit->at.u, hit->at.v};
    answers.push_back(answer);
  }
  return answers_ply(answers, "t");
}

bool wants_ply(const QueryFlags& flags) {
  return std::filesystem::path(flags.output).extension() == ".ply";
}

nlohmann::ordered_json to_json(const QueryFlags& flags, const JobInput& made,
                               const SurfaceQueries& queries, std::span<const glm::dvec3> points) {
  const PolygonMesh& mesh = made.input.file.mesh;
  nlohmann::ordered_json json;
  json["schema"] = "planish.query/1";
  json["input"] = {{"path", made.input.name}, {"sha256", made.input.sha256}};
  // What `at` counts: faces that were cut for the fit are the mesh's, not the file's.
  json["mesh"] = {{"vertices", mesh.vertex_count()}, {"faces", mesh.face_count()}};
  json["points"] = visible(flags.points);
  if (flags.direction.empty()) {
    json["closest"] = closest_answers(queries, points);
  } else {
    json["rays"] = ray_answers(queries, points, parse_direction(flags.direction));
  }
  return json;
}

std::string answers_text(const QueryFlags& flags, const JobInput& made,
                         const SurfaceQueries& queries, std::span<const glm::dvec3> points) {
  if (!wants_ply(flags)) return json_text(to_json(flags, made, queries, points));
  return flags.direction.empty() ? closest_ply(queries, points)
                                 : rays_ply(queries, points, parse_direction(flags.direction));
}

void write_answers(const QueryFlags& flags, const std::string& text) {
  if (flags.output == "-") {
    write_stdout(text);
    return;
  }
  StagedFiles staged;
  staged.write(flags.output, text);
  check_interrupt();
  staged.commit();
}

std::vector<glm::dvec3> read_questions(const std::string& path) {
  PointCloud cloud = read_points(std::filesystem::path(path));
  if (cloud.missing_count > 0) {
    throw Error(
        ErrorCode::UnreadableInput,
        visible(path) + ": " + std::to_string(cloud.missing_count) +
            " of its points are not finite, and there is one answer a point; leave them out");
  }
  for (glm::dvec3& point : cloud.points) point += cloud.origin;
  return std::move(cloud.points);
}

ExitCode run_query(const QueryFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  Job job;
  job.input = flags.input;
  job.name = job_name_of(flags.input);
  Faults faults;
  faults.note([&] { require_input(flags.input, {}); });
  faults.note([&] { require_input(flags.points, {}); });
  faults.note([&] { job.settings = settings_of_query(flags); });
  if (!flags.direction.empty()) faults.note([&] { (void)parse_direction(flags.direction); });
  PathClaims claims({.overwrite = flags.force});
  claims.add_input(flags.input);
  claims.add_input(flags.points);
  faults.note([&] {
    const std::filesystem::path output(flags.output);
    if (output != "-" && output.extension() != ".json" && !wants_ply(flags))
      refuse("-o", visible(output) + ": answers are written as .json or .ply");
    claims.add_output(output, "-o");
  });
  faults.throw_if_any();

  Progress all(console, flags.messages.progress_mode());
  JobProgress progress(all, job.name);
  const JobContext context{console, progress, arguments, {}};
  JobReport report;
  report.settings = job.settings;
  JobInput made = read_job_input(job, report, context);
  prepare_input(made, {}, report, console);
  const PolygonMesh& mesh = made.input.file.mesh;
  if (!made.prepared) require_usable(mesh, made.input.name);
  const auto backend =
      open_backend(list_devices(DeviceScope::CpuOnly).devices.front(), job.settings);
  const Fit fitted = fit_input(made, *backend, report, context);
  const std::vector<glm::dvec3> points = read_questions(flags.points);
  const LimitSurface surface(fitted_surface(
      mesh, fitted, {.weights = job.settings.weights, .sharp = job.settings.sharp()}));
  const std::string answers = answers_text(flags, made, SurfaceQueries(surface), points);
  all.finish();
  write_answers(flags, answers);
  return report.exit_code;
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
  for (const WordSetting& setting : word_settings()) {
    if (shapes_surface(setting)) add_word_flag(*command, flags->words, setting, "Surface");
  }
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
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_query(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
