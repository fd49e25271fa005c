#include "planish/job/fit_file.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "planish/backend/cpu_backend.h"
#include "planish/core/host_scope.h"
#include "planish/core/refuse.h"
#include "planish/core/visible_text.h"
#include "planish/job/job_outputs.h"
#include "planish/job/text.h"
#include "planish/surface/evaluate.h"

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
  require_file(options.page, "page");
  require_file(options.source, "source");
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
  job.page = options.page.string();
  job.source = options.source.string();
  job.digests = is_reported(job);
  job.limits = options.limits;
  job.overwrites = true;
  return job;
}

// Of the callbacks, which must outlive it.
JobWatch watch_of(const Callbacks& callbacks) {
  return {.progress = [&](std::string_view step, double,
                          double share) { callbacks.report(step, share); },
          .cancelled = callbacks.cancelled,
          .warning = [&](const Warning& warning) { callbacks.warn(warning); }};
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

WrittenOutput write_fitted_surface(const std::filesystem::path& path, const FittedMesh& fitted,
                                   Backend& backend, const SurfaceFileOptions& options) {
  require_file(path, "path");
  std::ranges::for_each(options.settings.levels, require_level);
  Job job;
  job.name = options.name;
  job.input = "-";  // no file, whose stem would be the name
  job.settings = options.settings;
  job.settings.scheme = fitted.options.scheme;
  job.settings.tolerance = fitted.options.tolerance;
  job.outputs = {surface_request(job.settings, path.string(), "path")};
  job.digests = job.measures = false;
  PathClaims claims({.overwrite = true});
  if (options.inputs != nullptr) claims.add_inputs(*options.inputs);
  const HostScope host(options.callbacks);
  std::vector<WrittenOutput> written;
  backend.run_on_host([&] {
    written = write_fitted(fitted, std::move(job), claims, backend, watch_of(options.callbacks));
  });
  options.callbacks.report("write", 1);
  return std::move(written.front());
}

FileFit fit_file(const std::filesystem::path& input, const std::filesystem::path& output,
                 const FitFileOptions& options) {
  std::unique_ptr<Backend> own;
  if (options.backend == nullptr)
    own = make_cpu_backend({.solve_precision = solve_precision(options.settings)});
  Backend& backend = own ? *own : *options.backend;
  const Callbacks& callbacks = options.callbacks;
  JobResult result = run(file_job(input, output, options), backend, watch_of(callbacks));
  callbacks.report("write", 1);
  return file_fit(std::move(result));
}

}  // namespace planish
