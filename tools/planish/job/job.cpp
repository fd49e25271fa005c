#include "job/job.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "job/asset_job.h"
#include "job/forecast.h"
#include "job/job_fit.h"
#include "job/job_input.h"
#include "job/point_input.h"
#include "job/timed.h"
#include "output/job_outputs.h"
#include "output/output_levels.h"
#include "planish/core/json.h"
#include "planish/files/read_file.h"
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

// By the head of a PLY file, which holds either; by the format of others.
bool may_be_points(const Job& job) {
  if (is_point_path(job.input, job.input_format)) return true;
  if (job.input == "-" || job.input_format.value_or(FileFormat::Ply) != FileFormat::Ply)
    return false;
  // What a pipe gives comes once.
  constexpr std::uint64_t kHead = std::uint64_t{1} << 16;
  const NamedFile head = read_named_start(job.input, job.input, FileReach::Anywhere, kHead);
  std::string_view text(reinterpret_cast<const char*>(head.bytes.data()), head.bytes.size());
  text = text.substr(0, text.find("\nend_header"));
  return text.starts_with("ply") && text.find("\nelement face") == std::string_view::npos;
}

}  // namespace

std::vector<PlannedStep> steps_of(const Job& job, const std::vector<PlannedOutput>& outputs) {
  // Weights by what the steps take; those of a level grow with its points.
  std::vector<PlannedStep> steps{{"read", 2}};
  if (job.sampling) steps.push_back({"sample", 4});
  const bool brings_points = job.sampling || may_be_points(job);
  if (brings_points) steps.push_back({"points", 80});
  if (!job.source.empty()) steps.push_back({"read", 2});
  steps.push_back({"check", 1});
  steps.push_back({"fit", 8});
  std::vector<Fineness> all;
  for (const PlannedOutput& output : outputs) {
    const bool is_new = std::ranges::find(all, output.fineness) == all.end();
    if (output.kind == OutputKind::Surface && is_new && output.coarser.empty() &&
        info_of(output.format).has_fineness())
      all.push_back(output.fineness);
  }
  for (const Fineness& fineness : all) {
    const double points = std::ldexp(1.0, 2 * fineness.level);
    steps.push_back({"level", points});
    for (const PlannedOutput& output : outputs)
      if (output.kind == OutputKind::Surface && output.fineness == fineness &&
          output.coarser.empty() && info_of(output.format).has_fineness())
        steps.push_back({"write", 0.6 * points});
  }
  for (const PlannedOutput& output : outputs) {
    if (output.coarser.empty()) continue;
    double points = 0;
    for (const Fineness& fineness : output.finenesses()) {
      steps.push_back({"level", std::ldexp(1.0, 2 * fineness.level)});
      points += steps.back().weight;
    }
    steps.push_back({"write", 0.6 * points});
  }
  for (const PlannedOutput& output : outputs)
    if (info_of(output.format).is_tiles)
      steps.push_back({"write", 2.5 * std::ldexp(1.0, 2 * output.fineness.level)});
  for (const PlannedOutput& output : outputs)
    if (info_of(output.format).is_brep) steps.push_back({"faces", 60});
  if (job.settings.scheme == Scheme::DooSabin) {
    if (brings_points) steps.push_back({"distances", 10});
    if (!job.source.empty()) steps.push_back({"distances", 10});
  }
  if (!job.page.empty()) steps.push_back({"page", 8});
  return steps;
}

JobReport run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobContext& context) {
  JobReport report;
  report.job = job.name;
  report.label = job.label;
  report.input.path = job.input;
  report.arguments = context.arguments;
  report.settings = job.settings;
  report.device = backend.description();
  context.progress.plan(steps_of(job, outputs));
  StagedFiles staged(job.overwrites);
  PageJob page{.name = job.name};
  std::vector<std::byte> stdout_bytes;
  timed(report.timing.total, [&] {
    const InputFile file =
        timed(report.timing.read, [&] { return load_job_input(job, report, context); });
    if (const auto asset = kept_asset(job, outputs, file, report, context)) {
      stdout_bytes = staged.naming_targets([&] {
        return run_asset({job, outputs, backend, context, file, *asset, report, staged});
      });
      warn_of_size(report, asset->byte_count(), context.console);
      return;
    }
    JobInput made =
        timed(report.timing.read, [&] { return read_job_input(job, file, report, context); });
    std::optional<ReadyFit> cage;
    ReadyFit ready = timed(report.timing.check, [&] {
      ReadyFit prepared = prepare_input(made, report, context);
      cage = take_cage(prepared, outputs, context.wants_page(job));
      report.method = prepared.fitted.options.method;
      if (!prepared.chooses_method) warn_of_unused_settings(job, made, report, context.console);
      const MeshNeed need{&prepared, nullptr};
      require_memory_for({&need, 1}, job.settings, outputs);
      return prepared;
    });
    const bool was_open = ready.chooses_method;
    fit_input(made, std::move(ready), backend, job.moves, report, context);
    if (cage) fit_cage(made, *std::move(cage), backend, job.moves, report, context);
    if (was_open) warn_of_unused_settings(job, made, report, context.console);
    const std::vector<PlannedOutput> written = settled(outputs, made.fitted.density.level());
    stdout_bytes = staged.naming_targets([&] {
      return write_outputs({job, written, backend, context, made, report, staged, page});
    });
    // A .gltf's numbers are beside it.
    if (file.format != FileFormat::Gltf) warn_of_size(report, file.bytes.size(), context.console);
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
