#include "planish/job/fit_file.h"

#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/core/host_scope.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/job.h"
#include "planish/job/text.h"

namespace planish {
namespace {

// The command's word for stdin and stdout, which are the host's here.
void require_file(const std::filesystem::path& path, std::string_view where) {
  if (path == "-") refuse(where, "a file is wanted; one of that name is \"./-\"");
}

Job file_job(const std::filesystem::path& input, const std::filesystem::path& output,
             const FitFileOptions& options) {
  require_file(input, "input");
  require_file(output, "output");
  require_file(options.cage, "cage");
  require_file(options.report, "report");
  Job job;
  job.input = input.string();
  job.name = visible(input.stem());
  job.label = input_name(job.input);
  job.settings = options.settings;
  job.outputs = {surface_request(job.settings, output.string(), "output")};
  if (!options.cage.empty())
    job.outputs.push_back(
        {.path = options.cage.string(), .kind = OutputKind::Cage, .where = "cage"});
  job.report = options.report.string();
  return job;
}

FileFit file_fit(JobResult&& result) {
  FileFit done;
  done.fitted = std::move(result.fitted.front());
  std::vector<Warning>& warnings = done.fitted.warnings;
  if (result.report.meshes.empty()) warnings.clear();  // the report has them
  warnings.insert(warnings.end(), result.report.warnings.begin(), result.report.warnings.end());
  done.further.assign(std::make_move_iterator(result.fitted.begin() + 1),
                      std::make_move_iterator(result.fitted.end()));
  WrittenOutput& written = result.report.outputs.front();
  done.vertex_count = written.vertices;
  done.face_count = written.faces;
  done.byte_count = written.bytes;
  done.step = std::move(written.step);
  return done;
}

}  // namespace

FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  Job job = file_job(input, output, options);
  PathClaims claims({.overwrite = true});
  claims.add_input(input, {}, job.settings.textures);
  const std::vector<PlannedOutput> outputs =
      plan_outputs(job, claims, [](const std::function<void()>& check) { check(); });
  if (!options.report.empty()) claims.add_report(options.report, "report");
  std::unique_ptr<Backend> own;
  if (options.backend == nullptr)
    own = make_cpu_backend({.solve_precision = solve_precision(job.settings)});
  Backend& backend = own ? *own : *options.backend;
  const Callbacks& callbacks = options.callbacks;
  const JobWatch watch{.progress = [&](std::string_view step, double,
                                       double share) { callbacks.report(step, share); },
                       .cancelled = callbacks.cancelled,
                       .warning = [&](const Warning& warning) { callbacks.warn(warning); }};
  const HostScope host(callbacks);
  JobResult result;
  backend.run_on_host([&] { result = run_job(job, outputs, backend, watch); });
  callbacks.report("write", 1);
  return file_fit(std::move(result));
}

}  // namespace planish
