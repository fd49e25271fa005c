#include "planish/job/job.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/platform/machine.h"
#include "planish/core/words.h"
#include "planish/job/fit_file.h"
#include "planish/job/forecast.h"
#include "planish/job/input.h"
#include "planish/job/job_input.h"
#include "planish/job/job_outputs.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/job/page/sheet.h"
#include "planish/job/staged_files.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"

namespace planish {

// A step comes again for every level: one that starts anew is the next of its name.
void JobProgress::advance() {
  if (steps_.empty()) {
    share_ = fraction_;
    return;
  }
  const auto from = steps_.begin() + static_cast<std::ptrdiff_t>(std::min(place_, steps_.size()));
  const auto found = std::ranges::find(from, steps_.end(), step_, &PlannedStep::name);
  if (found != steps_.end()) place_ = static_cast<std::size_t>(found - steps_.begin());
  if (place_ >= steps_.size()) return;
  double before = 0, all = 0;
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    if (i < place_) before += steps_[i].weight;
    all += steps_[i].weight;
  }
  const double share = (before + fraction_ * steps_[place_].weight) / all;
  share_ = std::clamp(share, share_, 1.0);
}

void JobProgress::update(std::string_view step, double fraction) {
  const double sane =
      std::lerp(begin_, end_, std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0.0);
  const bool is_planned = place_ < steps_.size() && steps_[place_].name == step;
  if (is_planned && step == step_ && sane < fraction_) ++place_;
  step_ = step;
  fraction_ = sane;
  advance();
  if (visit_) visit_(step_, fraction_, share_);
}

namespace {

void write_report(const Job& job, const JobReport& report, StagedFiles& staged) {
  if (job.report.empty() || job.report == "-") return;
  staged.write(path_of(job.report), report_json(report));
}

// The job's own page, as text where it is for stdout.
std::string write_page(const Job& job, JobReport& report, StagedFiles& staged, JobPage* page) {
  if (page != nullptr) page->take(report);
  if (job.page.empty()) return "";
  std::string text = page->text();
  report.page = {job.page, text.size()};
  if (job.page != "-") staged.write(path_of(job.page), text);
  return text;
}

// Weights by what the steps take; those of a level grow with its points.
void add_steps_of(const std::vector<PlannedOutput>& outputs, std::vector<PlannedStep>& steps) {
  for (const Fineness& fineness : finenesses_of(outputs)) {
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
}

// The steps that the job will tell of.
std::vector<PlannedStep> steps_of(const Job& job, const std::vector<PlannedOutput>& outputs) {
  std::vector<PlannedStep> steps{{"read", 2}};
  const bool brings_points = may_be_points(job);
  if (brings_points) steps.push_back({"points", 80});
  if (!job.source.empty()) steps.push_back({"read", 2});
  steps.push_back({"check", 1});
  steps.push_back({"fit", 8});
  add_steps_of(outputs, steps);
  if (job.settings.scheme == Scheme::DooSabin) {
    if (brings_points) steps.push_back({"distances", 10});
    if (!job.source.empty()) steps.push_back({"distances", 10});
  }
  if (!job.page.empty()) steps.push_back({"page", 8});
  return steps;
}

}  // namespace

OutputRequest surface_request(const Settings& settings, std::string path, std::string where) {
  return {.path = std::move(path),
          .levels = settings.levels,
          .by_density = settings.levels_by_density,
          .adaptive = settings.adaptive,
          .where = std::move(where),
          .lods_in_one = settings.lods == LodChoice::Msft};
}

std::vector<PlannedOutput> plan_outputs(
    Job& job, PathClaims& claims, const std::function<void(const std::function<void()>&)>& note) {
  std::vector<PlannedOutput> outputs;
  const Settings& settings = job.settings;
  job.overwrites = claims.overwrites();
  note([&] { settle_bake(job); });
  for (const OutputRequest& request : job.outputs)
    note([&] { std::ranges::move(plan_output(request, claims), std::back_inserter(outputs)); });
  if (settings.bake > 0) note([&] { require_bakeable(outputs); });
  note([&] { require_tileable(outputs, settings); });
  note([&] { require_step_surfaces(outputs, settings); });
  if (settings.attributes.any()) note([&] { require_attribute_formats(outputs); });
  if (settings.compression != GltfCompression::None) note([&] { require_compressible(outputs); });
  return outputs;
}

JobResult run_job(const Job& job, const std::vector<PlannedOutput>& outputs, Backend& backend,
                  const JobWatch& watch) {
  JobProgress progress(watch.progress);
  JobPage own_page(job.page_options);
  JobPage* const page = watch.page != nullptr ? watch.page : job.page.empty() ? nullptr : &own_page;
  const JobContext context{watch, progress, page};
  JobResult result;
  JobReport& report = result.report;
  report.job = job.name;
  report.label = job.label;
  report.input.path = job.input;
  report.arguments = job.arguments;
  report.settings = job.settings;
  report.device = backend.description();
  context.progress.plan(steps_of(job, outputs));
  StagedFiles staged(job.overwrites);
  std::vector<std::byte> stdout_bytes;
  timed(report.timing.total, [&] {
    const InputFile file =
        timed(report.timing.read, [&] { return load_job_input(job, report, context); });
    if (const auto asset = kept_asset(job, outputs, file, report, context)) {
      AssetResult made = staged.naming_targets([&] {
        return run_asset({job, outputs, backend, context, file, *asset, report, staged});
      });
      stdout_bytes = std::move(made.stdout_bytes);
      result.fitted = std::move(made.fitted);
      warn_of_size(report, asset->byte_count(), context);
      return;
    }
    JobInput made =
        timed(report.timing.read, [&] { return read_job_input(job, file, report, context); });
    std::optional<ReadyFit> cage;
    ReadyFit ready = timed(report.timing.check, [&] {
      ReadyFit prepared = prepare_input(made, report, context);
      cage = take_cage(prepared, job.settings, outputs, context.wants_page());
      report.fit.method = prepared.input.options.method;
      if (!prepared.chooses_method) warn_of_unused_settings(job, made, report, context);
      const MeshNeed need{&prepared, nullptr};
      require_memory_for({&need, 1}, job.settings, outputs);
      return prepared;
    });
    const bool was_open = ready.chooses_method;
    fit_input(made, std::move(ready), backend, job.moves, report, context);
    if (cage) fit_cage(made, *std::move(cage), backend, job.moves, report, context);
    if (has_cage(outputs)) fit_cage_in_scheme(made, backend, report, context);
    if (was_open) warn_of_unused_settings(job, made, report, context);
    const std::vector<PlannedOutput> written = settled(outputs, {made.fitted.density.level()});
    stdout_bytes = staged.naming_targets([&] {
      return write_outputs({job, written, backend, context, made, made.fitted, report, staged});
    });
    // A .gltf's numbers are beside it.
    if (file.format != FileFormat::Gltf) warn_of_size(report, file.bytes.size(), context);
    result.fitted.push_back(std::move(made.fitted));
  });
  report.host_peak_bytes = platform::peak_memory();
  report.device_bytes = backend.peak_device_bytes();
  if (watch.details) watch.details(details(report));
  write_report(job, report, staged);
  const std::string page_text = write_page(job, report, staged, page);
  check_stop();
  const auto write = [&](std::string_view bytes) {
    if (watch.write) watch.write(bytes);
  };
  if (LimitScope* const limits = LimitScope::current()) limits->add_output(stdout_bytes.size());
  if (!stdout_bytes.empty())
    write({reinterpret_cast<const char*>(stdout_bytes.data()), stdout_bytes.size()});
  staged.commit();
  if (job.report == "-") write(report_json(report));
  if (job.page == "-") write(page_text);
  return result;
}

std::vector<WrittenOutput> write_fitted(const FittedMesh& fitted, Job job, PathClaims& claims,
                                        Backend& backend, const JobWatch& watch) {
  const std::vector<PlannedOutput> outputs =
      settled(plan_outputs(job, claims, [](const std::function<void()>& check) { check(); }),
              {fitted.density.level()});
  require_asset_for_lods(outputs);
  JobProgress progress(watch.progress);
  std::vector<PlannedStep> steps;
  add_steps_of(outputs, steps);
  progress.plan(std::move(steps));
  const JobContext context{watch, progress};
  JobReport report;
  report.label = job.label;
  report.settings = job.settings;
  report.fit = fitted.figures();
  report.input.statistics = statistics(*fitted.fit.prepared);
  StagedFiles staged(job.overwrites);
  const JobInput made;
  (void)staged.naming_targets([&] {
    return write_outputs({job, outputs, backend, context, made, fitted, report, staged});
  });
  check_stop();
  staged.commit();
  return std::move(report.outputs);
}

JobResult run(Job job, Backend& backend, const JobWatch& watch) {
  PathClaims claims({.overwrite = job.overwrites, .create_folders = job.makes_folders});
  const FileReach reach = job.settings.textures;
  if (job.input != "-") claims.add_input(path_of(job.input), job.input_format, reach);
  if (!job.source.empty()) claims.add_input(path_of(job.source), {}, reach);
  const std::vector<PlannedOutput> outputs =
      plan_outputs(job, claims, [](const std::function<void()>& check) { check(); });
  if (!job.report.empty()) claims.add_report(path_of(job.report), "report");
  if (!job.page.empty()) claims.add_page(path_of(job.page), "page");
  const Callbacks host{.cancelled = watch.cancelled};
  const HostScope scope(host);
  const LimitScope limits(job.limits);
  JobResult result;
  try {
    backend.run_on_host([&] { result = run_job(job, outputs, backend, watch); });
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled || !limits.is_time_over()) throw;
    throw Error(ErrorCode::Cancelled,
                named_message(job.label, formatted("took the {} s of processor time that it may; "
                                                   "take a coarser level or allow more",
                                                   short_number(job.limits.cpu_seconds))));
  }
  return result;
}

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
  job.input = utf8(input);
  job.name = visible(input.stem());
  job.label = input_name(job.input);
  job.settings = options.settings;
  job.outputs = {surface_request(job.settings, utf8(output), "output")};
  if (!options.cage.empty())
    job.outputs.push_back({.path = utf8(options.cage), .kind = OutputKind::Cage, .where = "cage"});
  job.report = utf8(options.report);
  job.page = utf8(options.page);
  job.source = utf8(options.source);
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
  // The files are there, so nothing may fail for want of memory: all is moved.
  WrittenOutput& written = result.report.outputs.front();
  FileFit done{.fitted = std::move(result.fitted.front()),
               .vertex_count = written.vertices,
               .face_count = written.faces,
               .byte_count = written.bytes,
               .step = std::move(written.step)};
  std::vector<Warning>& warnings = done.fitted.warnings;
  if (result.report.meshes.empty()) {  // the report has those of its one mesh
    warnings = std::move(result.report.warnings);
  } else {
    warnings.insert(warnings.end(), std::make_move_iterator(result.report.warnings.begin()),
                    std::make_move_iterator(result.report.warnings.end()));
  }
  result.fitted.erase(result.fitted.begin());
  done.further = std::move(result.fitted);
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
  job.outputs = {surface_request(job.settings, utf8(path), "path")};
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

namespace {

// What is wrong with names is said before any work.
void claim_files(std::span<const std::filesystem::path> inputs, const std::vector<Job>& jobs,
                 const FitFilesOptions& options) {
  PathClaims claims({.overwrite = true, .create_folders = true});
  for (const std::filesystem::path& input : inputs)
    claims.add_input(input, {}, options.settings.textures);
  for (const Job& job : jobs) {
    claims.add_output(job.outputs.front().path, "folder");
    if (!job.page.empty()) claims.add_page(job.page, "pages");
  }
  if (!options.pages.empty()) claims.add_page(options.pages / "index.html", "pages");
}

// The message where it failed.
std::string fit_one_of(const Job& job, Backend& backend, const Callbacks& callbacks,
                       SheetRow& row) {
  JobPage page(job.page_options);
  JobWatch watch = watch_of(callbacks);
  if (!job.page.empty()) watch.page = &page;
  try {
    row = sheet_row(run(job, backend, watch).report);
    row.given = page.small_pictures().given;
    row.surface = page.small_pictures().surface;
    return {};
  } catch (const std::exception&) {
    const Failure failure = current_failure("out of memory; take a lower level or a smaller mesh");
    if (!failure.code || failure.code == ErrorCode::Cancelled) throw;
    return failure.message;
  }
}

}  // namespace

std::vector<std::string> fit_files(std::span<const std::filesystem::path> inputs,
                                   const std::filesystem::path& folder,
                                   const FitFilesOptions& options) {
  std::unique_ptr<Backend> own;
  if (options.backend == nullptr)
    own = make_cpu_backend({.solve_precision = solve_precision(options.settings)});
  Backend& backend = own ? *own : *options.backend;
  std::vector<Job> jobs;
  for (const std::filesystem::path& input : inputs) {
    const std::string stem = utf8(input.stem());
    FitFileOptions one{.settings = options.settings, .limits = options.limits};
    if (!options.pages.empty()) one.page = options.pages / path_of(stem + ".html");
    jobs.push_back(file_job(input, folder / path_of(stem + "." + options.extension), one));
    jobs.back().makes_folders = true;
    jobs.back().page_options.times = options.page_times;
    jobs.back().page_options.small_width = kSmallWidth;
  }
  claim_files(inputs, jobs, options);
  std::vector<std::string> failures;
  std::vector<SheetRow> rows;
  const double count = std::max(1.0, static_cast<double>(jobs.size()));
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto done = static_cast<double>(i);
    SheetRow row;
    failures.push_back(fit_one_of(
        jobs[i], backend, share_of(options.callbacks, done / count, (done + 1) / count), row));
    row.name = jobs[i].name;
    row.failure = relative_to(std::filesystem::current_path(), failures.back());
    row.page = utf8(inputs[i].stem()) + ".html";
    if (!options.pages.empty()) rows.push_back(std::move(row));
  }
  if (!options.pages.empty()) {
    StagedFiles staged(true);
    staged.write(options.pages / "index.html", make_sheet(rows, options.page_times));
    staged.commit();
  }
  options.callbacks.report("write", 1);
  return failures;
}

}  // namespace planish
