#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "commands.h"
#include "devices.h"
#include "job/answers.h"
#include "job/questions.h"
#include "memory/large_arrays.h"
#include "options/input_list.h"
#include "options/option_flags.h"
#include "planish/core/json.h"
#include "planish/core/output_file.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/files/read_points.h"
#include "planish/job/input_path.h"
#include "planish/job/job_fit.h"
#include "planish/job/job_input.h"
#include "planish/job/output_plan.h"
#include "planish/job/report.h"
#include "planish/job/staged_files.h"
#include "planish/job/text.h"
#include "planish/limit/surface_queries.h"
#include "planish/pipeline/option_table.h"
#include "terminal/faults.h"
#include "terminal/interrupt.h"
#include "terminal/watch.h"

namespace planish::command {
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

bool wants_ply(const QueryFlags& flags) {
  return std::filesystem::path(flags.output).extension() == ".ply";
}

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
  const std::filesystem::path path = staged.stage(flags.output);
  staged.naming_targets([&] {
    OutputFile file(path);
    make([&](std::string_view bytes) { file.write(bytes); });
    file.commit();
  });
  check_interrupt();
  staged.commit();
}

std::vector<glm::dvec3> read_questions(const std::string& path, Console& console) {
  PointCloud cloud = read_points(std::filesystem::path(path));
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
  claims.add_input(flags.input, {}, job.settings.textures);
  claims.add_input(flags.points);
  faults.note([&] {
    const std::filesystem::path output(flags.output);
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
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_query(*flags); };
  });
}

}  // namespace planish::command
