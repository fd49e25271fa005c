#include "job/job.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "job/forecast.h"
#include "job/job_fit.h"
#include "job/job_input.h"
#include "job/point_input.h"
#include "job/timed.h"
#include "output/job_outputs.h"
#include "planish/mesh/check.h"
#include "report/details.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

void write_report(const Job& job, const JobReport& report, StagedFiles& staged) {
  if (job.report.empty() || job.report == "-") return;
  staged.write(job.report, json_text(to_json(report)));
}

// The job's own page, as text where it is for stdout; its part of a page of all jobs.
std::string write_page(const Job& job, PageJob&& page, JobReport& report, StagedFiles& staged,
                       const JobContext& context) {
  if (!context.wants_page(job)) return "";
  page.report = to_json(report);
  std::string text;
  if (!job.page.empty()) {
    text = make_page({&page, 1}, context.page, std::filesystem::current_path());
    report.page = {job.page, text.size()};
    if (job.page != "-") staged.write(job.page, text);
  }
  if (context.page_jobs != nullptr) context.page_jobs->push_back(std::move(page));
  return text;
}

}  // namespace

std::vector<PlannedStep> steps_of(const Job& job, const std::vector<PlannedOutput>& outputs) {
  // Weights by what the steps take on a goblet; those of a level grow with its points.
  std::vector<PlannedStep> steps{{"read", 2}};
  if (job.sampling || is_point_path(job.input, job.input_format)) {
    if (job.sampling)
      steps.insert(steps.end(), {{"stencils", 1}, {"solve", 1}, {"evaluate", 4}, {"sample", 4}});
    steps.insert(steps.end(),
                 {{"clean", 5}, {"smooth", 0.5}, {"mesh", 40}, {"repair", 2}, {"simplify", 60}});
  }
  steps.insert(steps.end(), {{"stencils", 2}, {"solve", 3}});
  if (chooses_by_measurement(job.settings, outputs))
    steps.insert(steps.end(), {{"stencils", 2}, {"solve", 3}});
  std::vector<Fineness> all;
  for (const PlannedOutput& output : outputs) {
    const bool is_new = std::ranges::find(all, output.fineness) == all.end();
    if (output.kind == OutputKind::Surface && is_new && !info_of(output.format).is_tiles)
      all.push_back(output.fineness);
  }
  for (const Fineness& fineness : all) {
    const double points = std::ldexp(1.0, 2 * fineness.level);
    steps.push_back({"evaluate", points});
    if (fineness.level > 0 &&
        steps.end() == std::ranges::find(steps, "measure", &PlannedStep::name))
      steps.push_back({"measure", 0.4 * points});
    for (const PlannedOutput& output : outputs)
      if (output.kind == OutputKind::Surface && output.fineness == fineness &&
          !info_of(output.format).is_tiles)
        steps.push_back({"write", 0.6 * points});
  }
  for (const PlannedOutput& output : outputs)
    if (info_of(output.format).is_tiles)
      steps.push_back({"write", 2.5 * std::ldexp(1.0, 2 * output.fineness.level)});
  if (!job.page.empty()) steps.push_back({"page", 8});
  return steps;
}

JobReport run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobContext& context) {
  JobReport report;
  report.job = job.name;
  report.input.path = job.input;
  report.arguments = context.arguments;
  report.settings = job.settings;
  report.device = backend.description();
  context.progress.plan(steps_of(job, outputs));
  StagedFiles staged;
  PageJob page{.name = job.name};
  std::vector<std::byte> stdout_bytes;
  timed(report.timing.total, [&] {
    context.progress.update("read", 0);
    JobInput made = timed(report.timing.read, [&] { return read_job_input(job, report, context); });
    timed(report.timing.check, [&] {
      prepare_input(made, outputs, report, context.console);
      if (!made.unprepared) warn_of_unused_settings(job, made, report, context.console);
      const PolygonMesh& mesh = made.input.file.mesh;
      if (!made.prepared) require_usable(mesh, made.input.name);
      require_memory_for(mesh, *made.prepared, job.settings, outputs);
    });
    const bool was_open = made.unprepared.has_value();
    const Fit result = fit_input(made, backend, report, context);
    if (was_open) warn_of_unused_settings(job, made, report, context.console);
    stdout_bytes = staged.naming_targets([&] {
      return write_outputs(
          {job, outputs, backend, context, made, result, report, staged, page.payloads});
    });
  });
  report.host_peak_bytes = peak_host_bytes();
  report.device_bytes = backend.peak_device_bytes();
  context.console.debug(details(report));
  write_report(job, report, staged);
  const std::string page_text = write_page(job, std::move(page), report, staged, context);
  context.console.clear_status();
  check_interrupt();
  if (!stdout_bytes.empty()) {
    write_stdout({reinterpret_cast<const char*>(stdout_bytes.data()), stdout_bytes.size()});
  }
  staged.commit();
  if (job.report == "-") write_stdout(json_text(to_json(report)));
  if (job.page == "-") write_stdout(page_text);
  return report;
}

}  // namespace planish::command
