#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "commands.h"
#include "job/batch.h"
#include "job/describe_job.h"
#include "options/page_flags.h"
#include "options/scene_file.h"
#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/job/report.h"
#include "terminal/faults.h"

namespace planish::command {
namespace {

struct RunFlags {
  std::string scene, device, report, page, page_limit;
  std::vector<std::string> names;
  bool force = false, dry_run = false, json = false, page_no_times = false;
  MessageFlags messages;

  /// Where the report of all jobs goes; empty: nowhere.
  [[nodiscard]] std::string report_path() const { return json ? "-" : report; }
};

// A mesh in the place of a scene.
void require_scene(const std::string& path) {
  const auto format = format_of(path);
  if (!format || info_of(*format).is_tiles) return;
  const std::filesystem::path stem = std::filesystem::path(path).stem();
  throw Error(ErrorCode::InvalidArgument,
              formatted("{}: is no scene file; did you mean: planish fit {} -o {}.glb",
                        visible(path), visible(path), visible(stem)));
}

// The jobs as the flags change them.
std::vector<PlannedJob> wanted_jobs(const RunFlags& flags) {
  require_scene(flags.scene);
  std::vector<PlannedJob> planned;
  for (Job& job : select_jobs(read_scene_file(flags.scene), flags.names)) {
    if (!flags.device.empty()) {
      job.settings.device = flags.device;
      check_consistent(job.settings);
    }
    planned.push_back({.job = std::move(job), .outputs = {}});
  }
  return planned;
}

void claim_files(const RunFlags& flags, std::vector<PlannedJob>& jobs, PathClaims& claims) {
  Faults faults;
  claims.add_input(flags.scene);
  for (const PlannedJob& planned : jobs) {
    const FileReach reach = planned.job.settings.textures;
    claims.add_input(planned.job.input, planned.job.input_format, reach);
    if (!planned.job.source.empty()) claims.add_input(planned.job.source, {}, reach);
  }
  for (PlannedJob& planned : jobs) {
    const Job& job = planned.job;
    claim_outputs(planned, claims, faults);
    if (!job.report.empty())
      faults.note([&] { claims.add_report(job.report, "report of job " + job.name); });
    if (!job.page.empty())
      faults.note([&] { claims.add_page(job.page, "page of job " + job.name); });
  }
  if (flags.json && !flags.report.empty())
    faults.note(
        [] { throw Error(ErrorCode::InvalidArgument, "--json is --report -; give one of them"); });
  if (!flags.report_path().empty())
    faults.note([&] { claims.add_report(flags.report_path(), "--report"); });
  if (!flags.page.empty()) {
    faults.note([&] { claims.add_page(flags.page, "--page"); });
  }
  faults.throw_if_any();
}

ExitCode run_scene(const RunFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode(), flags.messages.form());
  std::vector<PlannedJob> jobs = wanted_jobs(flags);
  PathClaims claims({.overwrite = flags.force,
                     .create_folders = true,
                     .only_note = flags.dry_run,
                     .stdout_is_terminal = stdout_is_terminal()});
  claim_files(flags, jobs, claims);
  const PageOptions page = page_options(flags.page_limit, flags.page_no_times);
  const DeviceList devices = settle_devices(jobs);
  if (flags.dry_run)
    return describe_jobs(jobs, devices, claims,
                         {flags.report_path(), flags.page, page.limit_bytes});
  auto outcomes = run_batch(jobs, devices, console,
                            {.workers = 1,
                             .progress = flags.messages.progress_mode(),
                             .arguments = arguments,
                             .page = page,
                             .wants_page = !flags.page.empty(),
                             .wants_report = !flags.report_path().empty()});
  if (!flags.page.empty()) write_batch_page(flags.page, outcomes, page, console, flags.force);
  const std::string report = flags.report_path();
  if (!report.empty())
    write_batch_report(report, batch_json(jobs, outcomes, arguments), flags.force);
  if (report == "-" || flags.page == "-") {
    console.info(batch_table(jobs, outcomes));
  } else if (console.level() >= LogLevel::Info) {
    write_text(batch_table(jobs, outcomes));
  }
  const ExitCode exit_code = exit_code_of(outcomes);
  if (exit_code != ExitCode::Done) console.error(failed_jobs_text(outcomes));
  return exit_code;
}

}  // namespace

void add_run_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand("run", "the jobs of a scene file, and a table of them");
  auto flags = std::make_shared<RunFlags>();
  const char* group = "Jobs";
  command->add_option("SCENE", flags->scene, "scene file (JSON)")->type_name("SCENE")->required();
  command->add_option("JOB", flags->names, "names of jobs; all where none is named")
      ->type_name("[JOB...]");
  command->add_option("--device", flags->device, "for all jobs, whatever the scene says")
      ->type_name("auto|cpu|vulkan|INDEX|NAME|UUID")
      ->group(group);
  command->add_option("--report", flags->report, "one JSON report of all jobs; - for stdout")
      ->type_name("FILE")
      ->group(group);
  add_page_flags(*command, {flags->page, flags->page_limit, flags->page_no_times});
  command->add_flag("--json", flags->json, "the same as --report -")->group(group);
  command->add_flag("-f,--force", flags->force, "overwrite existing files")->group(group);
  command
      ->add_flag("--dry-run", flags->dry_run,
                 "check everything, and say what would be written, how large, in what memory and "
                 "time")
      ->group(group);
  flags->messages.add_to(*command, true);
  invocation.texts["run"] = {
      .examples = {"planish run scenes/table1.json",
                   "planish run scenes/table1.json --page out/table1.html --force",
                   "planish run scenes/table1.json goblet arm --force"},
      .first_flags = {},
      .notes =
          "scene.schema.json, installed with planish, describes the file.\n"
          "Exit codes are those of planish fit, and 8 when some jobs failed: the others are "
          "done."};
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_scene(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
