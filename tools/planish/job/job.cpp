#include "job/job.h"

#include <nlohmann/json.hpp>

#include "job/job_fit.h"
#include "job/job_input.h"
#include "job/timed.h"
#include "output/job_outputs.h"
#include "planish/core/output_file.h"
#include "terminal/interrupt.h"
#include "terminal/text.h"

namespace planish::command {
namespace {

void write_report(const Job& job, const JobReport& report, StagedFiles& staged) {
  if (job.report.empty() || job.report == "-") return;
  OutputFile file(staged.stage(job.report));
  file.write(json_text(to_json(report)));
  file.commit();
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
    if (job.page != "-") {
      OutputFile file(staged.stage(job.page));
      file.write(text);
      file.commit();
    }
  }
  if (context.page_jobs != nullptr) context.page_jobs->push_back(std::move(page));
  return text;
}

}  // namespace

JobReport run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobContext& context) {
  JobReport report;
  report.job = job.name;
  report.arguments = context.arguments;
  report.settings = job.settings;
  report.device = backend.description();
  context.progress.begin_job(job.name);
  StagedFiles staged;
  PageJob page{.name = job.name};
  std::vector<std::byte> stdout_bytes;
  timed(report.timing.total, [&] {
    context.progress.update("read", 0);
    JobInput made = timed(report.timing.read, [&] { return read_job_input(job, report, context); });
    timed(report.timing.check, [&] { prepare_input(made, report, context.console); });
    const Fit result = fit_input(made, backend, report, context);
    stdout_bytes = write_outputs(
        {job, outputs, backend, context, made, result, report, staged, page.payloads});
  });
  report.host_peak_bytes = peak_host_bytes();
  report.device_bytes = backend.peak_device_bytes();
  write_report(job, report, staged);
  const std::string page_text = write_page(job, std::move(page), report, staged, context);
  context.progress.finish();
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
