#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "commands.h"
#include "devices.h"
#include "job/job.h"
#include "options/scene_file.h"
#include "output/staged_files.h"
#include "page/page_job.h"
#include "planish/core/error.h"
#include "planish/core/output_file.h"
#include "terminal/interrupt.h"
#include "terminal/table.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

struct RunFlags {
  std::string scene, device, page, page_limit;
  std::vector<std::string> names;
  bool force = false, dry_run = false, page_no_times = false;
  MessageFlags messages;
};

constexpr const char* kRunExamples =
    "Examples:\n"
    "  planish run scenes/table1.json\n"
    "  planish run scenes/table1.json --page out/table1.html --force\n"
    "  planish run scenes/table1.json goblet arm --force\n"
    "Exit codes are those of planish fit, and 8 when some jobs failed. scene.schema.json\n"
    "describes the file.\n";

struct PlannedJob {
  Job job;
  std::vector<PlannedOutput> outputs;
  std::size_t device = 0;  ///< position in the list
};

// The jobs as the flags change them.
std::vector<Job> wanted_jobs(const RunFlags& flags) {
  std::vector<Job> jobs = select_jobs(read_scene_file(flags.scene), flags.names);
  if (flags.device.empty()) return jobs;
  for (Job& job : jobs) {
    job.settings.device = flags.device;
    check_consistent(job.settings);
  }
  return jobs;
}

std::vector<PlannedJob> plan_jobs(const RunFlags& flags, std::vector<Job> jobs,
                                  const DeviceList& list) {
  PathClaims claims({.overwrite = flags.force, .create_folders = true});
  claims.add_input(flags.scene);
  for (const Job& job : jobs) {
    claims.add_input(job.input);
    if (!job.source.empty()) claims.add_input(job.source);
  }
  std::vector<PlannedJob> planned;
  for (Job& job : jobs) {
    PlannedJob entry;
    for (const OutputRequest& request : job.outputs) {
      for (PlannedOutput& output : plan_output(request, claims)) {
        entry.outputs.push_back(std::move(output));
      }
    }
    if (job.settings.attributes.any()) require_attribute_formats(entry.outputs);
    if (!job.report.empty()) claims.add_output(job.report, "report of job " + job.name);
    if (!job.page.empty()) claims.add_output(job.page, "page of job " + job.name);
    entry.device = choose_device(list, job.settings);
    entry.job = std::move(job);
    planned.push_back(std::move(entry));
  }
  if (!flags.page.empty()) claims.add_output(flags.page, "--page");
  return planned;
}

// Opened once for all jobs that share a device and a precision.
class OpenBackends {
 public:
  explicit OpenBackends(const std::vector<ListedDevice>& devices) : devices_(devices) {}

  Backend& get(const PlannedJob& job) {
    auto& backend = backends_[{job.device, solve_precision(job.job.settings)}];
    if (!backend) backend = open_backend(devices_[job.device], job.job.settings);
    return *backend;
  }

 private:
  const std::vector<ListedDevice>& devices_;
  std::map<std::pair<std::size_t, Precision>, std::unique_ptr<Backend>> backends_;
};

Table make_table() {
  return Table({{"name", Align::Left},
                {"points", Align::Right},
                {"vertices", Align::Right},
                {"solver", Align::Left},
                {"weights", Align::Left},
                {"iterations", Align::Right},
                {"error", Align::Right},
                {"ms", Align::Right}});
}

// The other schemes have no choice of weights.
std::string weights_text(const Settings& settings) {
  return std::string(settings.scheme == Scheme::DooSabin ? name_of(settings.weights)
                                                         : name_of(settings.scheme));
}

std::vector<std::string> row_of(const JobReport& report) {
  const JobTiming& timing = report.timing;
  const Interpolation& result = report.interpolation;
  return {
      report.job,
      report.reconstruction.is_null()
          ? "-"
          : with_separators(report.reconstruction["points"].get<std::int64_t>()),
      with_separators(report.input.statistics.vertex_count),
      std::string(name_of(report.settings.solver)),
      weights_text(report.settings),
      std::to_string(result.iterations) + (result.converged ? "" : " (not converged)"),
      short_number(result.error.max),
      fixed(timing.check + timing.topology + timing.stencils + timing.upload + timing.solve, 1)};
}

std::vector<std::string> failed_row(const Job& job) {
  return {job.name, "-", "-", std::string(name_of(job.settings.solver)), weights_text(job.settings),
          "failed", "-", "-"};
}

void note_failure(const Job& job, const std::string& message, const JobContext& context) {
  context.console.error(job.name + ": " + message);
  if (context.page_jobs != nullptr)
    context.page_jobs->push_back({.name = job.name, .failure = message});
}

// The report, or nothing for a job that failed; the message has been given then.
std::optional<JobReport> try_job(const PlannedJob& planned, OpenBackends& backends,
                                 const JobContext& context) {
  try {
    return run_job(planned.job, planned.outputs, backends.get(planned), context);
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) throw;
    note_failure(planned.job, error.what(), context);
  } catch (const std::bad_alloc&) {
    note_failure(planned.job, "out of memory", context);
  }
  return std::nullopt;
}

// The page of all jobs.
void write_page(const std::string& path, const JobContext& context) {
  const std::string text =
      make_page(*context.page_jobs, context.page, std::filesystem::current_path());
  if (path == "-") {
    write_stdout(text);
    return;
  }
  StagedFiles staged;
  OutputFile file(staged.stage(path));
  file.write(text);
  file.commit();
  staged.commit();
  context.console.info(path + ": " + byte_size(text.size()) + ", page of " +
                       counted(static_cast<std::int64_t>(context.page_jobs->size()), "job"));
}

ExitCode run_scene(const RunFlags& flags, const std::vector<std::string>& arguments) {
  Console console(flags.messages.level(), flags.messages.color_mode());
  if (!flags.page.empty()) require_page_path(flags.page, "--page");
  std::vector<Job> wanted = wanted_jobs(flags);
  const bool cpu_only = std::ranges::all_of(
      wanted, [](const Job& job) { return scope_of(job.settings) == DeviceScope::CpuOnly; });
  const DeviceList list = list_devices(cpu_only ? DeviceScope::CpuOnly : DeviceScope::All);
  const std::vector<PlannedJob> jobs = plan_jobs(flags, std::move(wanted), list);
  if (flags.dry_run) {
    for (const PlannedJob& planned : jobs) {
      describe_job(planned.job, planned.outputs, list.devices[planned.device].description);
    }
    if (!flags.page.empty()) write_stdout("would write " + flags.page + "  (page of all jobs)\n");
    return ExitCode::Done;
  }
  Progress progress(console, flags.messages.progress_mode());
  std::vector<PageJob> page_jobs;
  const JobContext context{console, progress, arguments,
                           page_options(flags.page_limit, flags.page_no_times),
                           flags.page.empty() ? nullptr : &page_jobs};
  OpenBackends backends(list.devices);
  Table table = make_table();
  std::size_t failed = 0;
  for (const PlannedJob& planned : jobs) {
    const std::optional<JobReport> report = try_job(planned, backends, context);
    table.add_row(report ? row_of(*report) : failed_row(planned.job));
    if (!report || report->exit_code != ExitCode::Done) ++failed;
    if (report) console.debug(summary(*report));
  }
  if (!flags.page.empty()) write_page(flags.page, context);
  if (flags.page != "-")
    write_stdout(table.text() +
                 "points: of a cloud, of which the vertices are a part\n"
                 "error: largest vertex error over the diagonal; ms: check, stencils and solve\n");
  if (failed == 0) return ExitCode::Done;
  console.error(std::to_string(failed) + " of " + counted(jobs.size(), "job") + " failed");
  return ExitCode::JobsFailed;
}

}  // namespace

void add_run_command(CLI::App& app, Invocation& invocation) {
  CLI::App* command = app.add_subcommand("run", "the jobs of a scene file, and a table of them");
  auto flags = std::make_shared<RunFlags>();
  command->add_option("SCENE", flags->scene, "scene file (JSON)")->type_name("")->required();
  command->add_option("JOB", flags->names, "names of jobs; all where none is named")->type_name("");
  add_page_flags(*command, {flags->page, flags->page_limit, flags->page_no_times});
  command->add_option("--device", flags->device, "for all jobs, whatever the scene says")
      ->type_name("auto|cpu|vulkan|INDEX|NAME|UUID");
  command->add_flag("-f,--force", flags->force, "overwrite existing files");
  command->add_flag("--dry-run", flags->dry_run, "check everything and say what would be done");
  flags->messages.add_to(*command, true);
  command->footer(kRunExamples);
  command->callback([flags, &invocation] {
    invocation.action = [flags, &invocation] { return run_scene(*flags, invocation.arguments); };
  });
}

}  // namespace planish::command
