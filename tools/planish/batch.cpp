#include "batch.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <iterator>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/write_polygons.h"
#include "planish/job/build_info.h"
#include "planish/job/forecast.h"
#include "planish/job/input.h"
#include "planish/job/job_input.h"
#include "planish/job/job_outputs.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/job/page/sheet.h"
#include "planish/job/staged_files.h"
#include "planish/pipeline/option_table.h"
#include "terminal.h"

namespace planish::command {
namespace {

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

JobOutcome failed(const PlannedJob& planned, Console& console, ExitCode exit_code,
                  const std::string& message) {
  console.error(named_message(planned.job.label, message));
  return {.report = {},
          .exit_code = exit_code,
          .message = message,
          .page_jobs = {{.name = planned.job.name, .failure = message}},
          .pictures = {}};
}

JobOutcome try_job(const PlannedJob& planned, OpenBackends& backends, Console& console,
                   JobDisplay& display, const BatchOptions& options) {
  try {
    Job job = planned.job;
    job.page_options = options.page;
    job.page_options.small_width = options.wants_sheet ? kSmallWidth : 0;
    JobPage page(job.page_options);
    const bool shows = options.wants_page || options.wants_sheet;
    job.digests = options.wants_report || options.wants_page || is_reported(job);
    job.arguments = options.arguments;
    job.mesher = require_counted_mesher;
    JobReport report = run_job(job, planned.outputs, backends.get(planned),
                               watch_of(console, display, shows ? &page : nullptr))
                           .report;
    console.clear_status();
    console.debug(summary(report, true));
    JobOutcome outcome{.report = {},
                       .exit_code = exit_code_of(report),
                       .message = {},
                       .page_jobs = {},
                       .pictures = page.small_pictures()};
    if (options.wants_page) outcome.page_jobs = std::move(page).jobs();
    outcome.report = std::move(report);
    return outcome;
  } catch (const std::exception&) {
    const Failure failure = job_failure();
    if (!failure.code || failure.code == ErrorCode::Cancelled) throw;
    return failed(planned, console, exit_code_of(*failure.code), failure.message);
  }
}

// The other schemes have no choice of weights.
std::string weights_text(const Settings& settings) {
  return std::string(settings.scheme == Scheme::DooSabin ? name_of(settings.weights)
                                                         : name_of(settings.scheme));
}

std::string fit_time(const JobTiming& timing) {
  return fixed(timing.check + timing.topology + timing.stencils + timing.upload + timing.solve, 1);
}

// Of a glTF that stays an asset: the largest error of its meshes.
std::vector<std::string> row_of_asset(const JobReport& report) {
  double error = 0;
  for (const JobReport& mesh : report.meshes)
    error = std::max(error, mesh.fit.interpolation.error.max);
  return {report.job,
          "-",
          with_separators(report.input.file_vertices),
          counted(std::ssize(report.meshes), "mesh"),
          weights_text(report.settings),
          "-",
          short_number(error),
          fit_time(report.timing),
          fixed(report.timing.total, 1)};
}

std::vector<std::string> row_of(const JobReport& report) {
  if (!report.meshes.empty()) return row_of_asset(report);
  const Interpolation& result = report.fit.interpolation;
  return {report.job,
          report.points ? with_separators(report.points->points) : "-",
          with_separators(report.input.statistics.vertex_count),
          report.fit.fair ? "fair" : std::string(name_of(report.settings.solver)),
          weights_text(report.settings),
          (report.fit.fair ? "-" : std::to_string(result.iterations)) +
              (result.converged ? "" : " (not converged)"),
          short_number(result.error.max),
          fit_time(report.timing),
          fixed(report.timing.total, 1)};
}

std::vector<std::string> failed_row(const Job& job) {
  return {job.name, "-", "-", "-", weights_text(job.settings), "failed", "-", "-", "-"};
}

}  // namespace

void claim_outputs(PlannedJob& planned, PathClaims& claims, Faults& faults) {
  planned.outputs = plan_outputs(planned.job, claims,
                                 [&](const std::function<void()>& check) { faults.note(check); });
}

DeviceList settle_devices(std::vector<PlannedJob>& jobs) {
  DeviceScope scope = DeviceScope::CpuOnly;
  for (const PlannedJob& planned : jobs) scope = std::max(scope, scope_of(planned.job.settings));
  DeviceList list = list_devices(scope);
  for (PlannedJob& planned : jobs) planned.device = choose_device(list, planned.job.settings);
  return list;
}

std::vector<JobOutcome> run_batch(const std::vector<PlannedJob>& jobs, const DeviceList& devices,
                                  Console& console, const BatchOptions& options) {
  std::vector<JobOutcome> outcomes(jobs.size());
  Progress progress(console, options.progress, {}, static_cast<int>(jobs.size()));
  std::atomic<std::size_t> next = 0;
  std::exception_ptr thrown;
  std::mutex mutex;
  const auto work = [&] {
    const StopScope scope(interrupt_flag());
    OpenBackends backends(devices.devices);
    try {
      for (std::size_t i = next++; i < jobs.size(); i = next++) {
        JobDisplay display(progress, jobs[i].job.name, static_cast<int>(i) + 1);
        outcomes[i] = try_job(jobs[i], backends, console, display, options);
      }
    } catch (...) {
      next = jobs.size();
      const std::scoped_lock lock(mutex);
      if (!thrown) thrown = std::current_exception();
    }
  };
  const auto workers =
      kHasThreads ? std::min<std::size_t>(static_cast<std::size_t>(options.workers), jobs.size())
                  : 1;
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < workers; ++i) threads.emplace_back(work);
    work();
  }
  progress.finish();
  if (thrown) std::rethrow_exception(thrown);
  return outcomes;
}

ExitCode exit_code_of(const std::vector<JobOutcome>& outcomes) {
  const bool all_done = std::ranges::all_of(
      outcomes, [](const JobOutcome& outcome) { return outcome.exit_code == ExitCode::Done; });
  return all_done ? ExitCode::Done : ExitCode::JobsFailed;
}

std::string batch_table(const std::vector<PlannedJob>& jobs,
                        const std::vector<JobOutcome>& outcomes) {
  Table table({{"name", Align::Left},
               {"points", Align::Right},
               {"vertices", Align::Right},
               {"solver", Align::Left},
               {"weights", Align::Left},
               {"iterations", Align::Right},
               {"error", Align::Right},
               {"fit ms", Align::Right},
               {"all ms", Align::Right}});
  for (std::size_t i = 0; i < jobs.size(); ++i)
    table.add_row(outcomes[i].report ? row_of(*outcomes[i].report) : failed_row(jobs[i].job));
  return table.text() +
         "points: of a cloud, of which the vertices are a part\n"
         "error: largest vertex error over the diagonal; fit ms: check, stencils and solve; all "
         "ms: reading, evaluating and writing, too\n";
}

namespace {

std::vector<std::string> file_row(const JobReport& report, std::string name) {
  const SheetRow row = sheet_row(report);
  return {std::move(name),
          with_separators(row.vertices),
          row.converged ? row.method : "not converged",
          with_separators(row.creases),
          with_separators(row.joined),
          row.is_measured ? fixed(row.normals, 1) : "-",
          row.is_measured ? percent(row.folded) : "-",
          with_separators(row.warnings),
          duration(row.milliseconds)};
}

// Names of files as far as a line has room for them.
std::string short_name(const std::string& name) {
  constexpr std::size_t kMost = 24;
  return name.size() <= kMost ? name : plain_utf8(name.substr(0, kMost - 3)) + "...";
}

}  // namespace

std::string files_table(const std::vector<PlannedJob>& jobs,
                        const std::vector<JobOutcome>& outcomes) {
  Table table({{"name", Align::Left},
               {"vertices", Align::Right},
               {"method", Align::Left},
               {"creases", Align::Right},
               {"joined", Align::Right},
               {"normals", Align::Right},
               {"folded", Align::Right},
               {"warnings", Align::Right},
               {"time", Align::Right}});
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const std::string name = short_name(jobs[i].job.name);
    table.add_row(outcomes[i].report ? file_row(*outcomes[i].report, name)
                                     : std::vector<std::string>{name, "-", "failed", "-", "-", "-",
                                                                "-", "-", "-"});
  }
  return table.text() +
         "creases: edges kept sharp; joined: pairs of triangles that became quads; normals: "
         "degrees rms off\nthe input's faces; folded: of the area; of a file's meshes the sums, "
         "and "
         "the worst\n";
}

namespace {

// All but pages and pictures.
std::vector<SheetRow> sheet_rows(const std::vector<PlannedJob>& jobs,
                                 const std::vector<JobOutcome>& outcomes) {
  std::vector<SheetRow> rows;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const JobOutcome& outcome = outcomes[i];
    SheetRow& row = rows.emplace_back(outcome.report ? sheet_row(*outcome.report) : SheetRow());
    row.name = jobs[i].job.name;
    row.failure = relative_to(std::filesystem::current_path(), outcome.message);
  }
  return rows;
}

}  // namespace

std::string failed_jobs_text(const std::vector<JobOutcome>& outcomes) {
  const auto failed = std::ranges::count_if(
      outcomes, [](const JobOutcome& outcome) { return outcome.exit_code != ExitCode::Done; });
  return formatted("{} of {} failed", failed,
                   counted(static_cast<std::int64_t>(outcomes.size()), "job"));
}

void write_batch_report(const std::string& path, const nlohmann::ordered_json& json,
                        bool overwrites) {
  if (path == "-") return write_stdout(json_text(json));
  StagedFiles staged(overwrites);
  staged.write(path_of(path), json_text(json));
  staged.commit();
}

void write_batch_page(const std::string& path, std::vector<JobOutcome>& outcomes,
                      const PageOptions& options, Console& console, bool overwrites) {
  std::vector<PageJob> page_jobs;
  for (JobOutcome& outcome : outcomes)
    std::ranges::move(outcome.page_jobs, std::back_inserter(page_jobs));
  const std::string all = counted(std::ssize(outcomes), "job");
  const bool has_meshes = page_jobs.size() > outcomes.size();
  const std::string text = make_page(page_jobs, options, std::filesystem::current_path(), all,
                                     has_meshes ? "mesh" : "job");
  if (path == "-") return write_stdout(text);
  StagedFiles staged(overwrites);
  staged.write(path_of(path), text);
  staged.commit();
  console.info(formatted("{}: {}, page of {}", visible(path), byte_size(text.size()), all));
}

void write_batch_sheet(const std::string& path, const std::vector<PlannedJob>& jobs,
                       std::vector<JobOutcome>& outcomes, const PageOptions& options,
                       Console& console, bool overwrites, std::string_view kind) {
  std::vector<SheetRow> rows = sheet_rows(jobs, outcomes);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    JobOutcome& outcome = outcomes[i];
    SheetRow& row = rows[i];
    row.page =
        utf8(absolute(path_of(jobs[i].job.page))
                 .lexically_normal()
                 .lexically_relative(absolute(path_of(path)).parent_path().lexically_normal()));
    row.given = std::move(outcome.pictures.given);
    row.surface = std::move(outcome.pictures.surface);
  }
  const std::string all = counted(std::ssize(rows), kind);
  const std::string text = make_sheet(rows, options.times, kind);
  StagedFiles staged(overwrites);
  staged.write(path_of(path), text);
  staged.commit();
  console.info(
      formatted("{}: {}, contact sheet of {}", visible(path), byte_size(text.size()), all));
}

nlohmann::ordered_json batch_json(const std::vector<PlannedJob>& jobs,
                                  const std::vector<JobOutcome>& outcomes,
                                  const std::vector<std::string>& arguments) {
  nlohmann::ordered_json json;
  json["schema"] = "planish.batch/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", git_revision()}};
  json["argv"] = arguments;
  json["exit_code"] = static_cast<int>(exit_code_of(outcomes));
  json["jobs"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    if (outcomes[i].report) {
      json["jobs"].push_back(to_json(*outcomes[i].report));
    } else {
      json["jobs"].push_back({{"job", jobs[i].job.name},
                              {"exit_code", static_cast<int>(outcomes[i].exit_code)},
                              {"input", {{"path", jobs[i].job.input}}},
                              {"error", outcomes[i].message}});
    }
  }
  json["worst_first"] = nlohmann::ordered_json::array();
  for (const std::size_t i : worst_first(sheet_rows(jobs, outcomes)))
    json["worst_first"].push_back(jobs[i].job.name);
  return json;
}

namespace {

std::string write_line(const std::filesystem::path& path, const std::string& what,
                       const PathClaims& claims) {
  const std::string refusal = claims.refusal(path);
  if (!refusal.empty()) return "  would refuse " + refusal + "\n";
  return formatted("  would write  {}{}\n", output_name(utf8(path)), what);
}

std::string file_text(const OutputForecast& file, std::string_view faces) {
  if (file.vertices == 0) return "";
  return formatted(", {}, {}", counted(file.vertices, "vertex"), counted(file.faces, faces));
}

std::string_view faces_of(const PlannedOutput& output, Scheme scheme) {
  const bool is_cage = output.kind == OutputKind::Cage;
  if (is_cage || output.fineness.level == 0) return "face";
  return scheme == Scheme::Loop ? "triangle" : "quad";
}

std::string device_line(const DeviceDescription& device) {
  return formatted("  device       {}, {}\n", device.kind, device.name);
}

std::string memory_text(std::uint64_t need) {
  if (need == 0) return "known once there is a mesh";
  const auto budget = array_budget();
  if (!budget || need <= budget->bytes) return "at most about " + byte_size(need);
  return formatted("{}, and at most about {} in a temporary file in {}, which has {} free",
                   byte_size(budget->bytes), byte_size(need - budget->bytes),
                   visible(budget->folder), byte_size(budget->free_bytes));
}

std::string needs_text(const Forecast& forecast) {
  return formatted("  memory       {}\n  time         {}\n", memory_text(forecast.peak_bytes),
                   rough_duration(forecast.seconds));
}

// How large the mesh of points will be is not known before it is made.
std::string describe_points(const PlannedJob& planned, const PointInput& input,
                            const DeviceDescription& device, const PathClaims& claims,
                            std::uint64_t page_bytes) {
  std::string text =
      formatted("would reconstruct and fit {}: {}\n{}", input.name,
                counted(std::ssize(input.cloud.points), "point"), device_line(device));
  for (const PlannedOutput& output : planned.outputs) text += write_line(output.path, "", claims);
  return text + needs_text(forecast_of_points(input.cloud, planned.job.settings, planned.outputs,
                                              page_bytes));
}

// The file beside an output; that of an OBJ is written for materials only.
std::string companion_line(const PlannedOutput& output, const PolygonMesh& mesh,
                           const PathClaims& claims) {
  const std::filesystem::path beside = companion_of(output.path, output.format);
  if (output.to_stdout || beside.empty()) return {};
  const bool is_gltf = info_of(output.format).is_gltf;
  if (!is_gltf && materials_of(mesh.groups).empty() && claims.refusal(beside).empty()) return {};
  return write_line(beside, is_gltf ? "  (its numbers)" : "  (its materials)", claims);
}

// `input`: its format.
std::string outputs_text(const PlannedJob& planned, FileFormat input, const PolygonMesh& mesh,
                         const Forecast& forecast, const PathClaims& claims) {
  std::string text;
  for (std::size_t i = 0; i < planned.outputs.size(); ++i) {
    const PlannedOutput& output = planned.outputs[i];
    const OutputForecast& file = forecast.outputs[i];
    const bool is_cage = output.kind == OutputKind::Cage;
    const std::string what =
        info_of(output.format).is_brep
            ? formatted("  (faces, in {})",
                        word_of(kStepUnitWords,
                                settled_unit(planned.job.settings.step.unit, name_of(input))))
            : formatted("  ({}{})",
                        is_cage ? "control cage" : finenesses_text(output.fineness, output.coarser),
                        file_text(file, faces_of(output, planned.job.settings.scheme)));
    text += write_line(output.path, what, claims);
    text += companion_line(output, mesh, claims);
  }
  return text;
}

std::string solve_text(const Settings& settings, bool is_open) {
  if (settings.interpolation == InterpolationChoice::Fair) return "fair";
  const std::string solver(name_of(settings.solver));
  return is_open ? solver + ", or fair where that is better" : solver;
}

// As it will be fitted, as far as that is known before it is measured.
ReadyFit expected_ready(const PlannedJob& planned, Input input) {
  const Settings& settings = planned.job.settings;
  MeshFitOptions options = mesh_fit_options(settings);
  if (!options.method && !chooses_by_measurement(settings))
    options.method = InterpolationMethod::Progressive;
  ReadyFit ready = prepare_mesh(std::move(input), options, settings);
  (void)take_cage(ready, planned.job.settings, planned.outputs, !planned.job.page.empty());
  prepare_refined(ready);
  return ready;
}

std::string describe_mesh(const PlannedJob& planned, Input input, const DeviceDescription& device,
                          const PathClaims& claims, std::uint64_t page_bytes) {
  const Settings& settings = planned.job.settings;
  const std::string name = input.name;
  const FileFormat format = input.file.format;
  const std::int64_t vertices = input.file.mesh.vertex_count();
  const std::int64_t faces = input.file.mesh.face_count();
  const ReadyFit ready = expected_ready(planned, std::move(input));
  const MeshToFit& expected = expected_fit(ready).input;
  const PolygonMesh& mesh = expected.mesh;
  const MeshNeed need{&ready, nullptr};
  const Forecast forecast = forecast_of({&need, 1}, settings, planned.outputs, page_bytes);
  require_memory_for({&need, 1}, settings, planned.outputs);
  std::string text = formatted(
      "would fit {}: {}\n{}  solve        {}, {}{}, tolerance {}\n", name,
      counts_text(vertices, faces, mesh.vertex_count(), mesh.face_count(), expected.paired_count,
                  std::ssize(expected.added_vertices)),
      device_line(device), solve_text(settings, ready.chooses_method),
      ready.paired && !ready.is_plainly_halved ? "triangles joined to quads where that is better, "
      : ready.refined                          ? "vertices added where that is better, "
                                               : "",
      subdivision_text(settings.scheme, settings.weights), short_number(settings.tolerance));
  PlannedJob shown = planned;
  shown.outputs = settled(planned.outputs, {expected.density.level()});
  text += outputs_text(shown, format, mesh, forecast, claims);
  return text + needs_text(forecast);
}

std::string describe_asset(const PlannedJob& planned, const InputFile& file, const GltfAsset& asset,
                           const DeviceDescription& device, const PathClaims& claims) {
  struct Part {
    AssetMesh mesh;
    ReadyFit ready;
  };
  std::int64_t vertices = 0, faces = 0;
  int finest = 1;
  std::list<Part> parts;
  for (const std::int64_t number : asset.surfaces()) {
    Part& part = parts.emplace_back();
    const bool is_usable = try_mesh(
        asset, number, [](const Warning&) {},
        [&] {
          part.mesh = asset.read(number);
          vertices += part.mesh.file.mesh.vertex_count();
          faces += part.mesh.file.mesh.face_count();
          part.ready = expected_ready(
              planned, {.name = file.name, .file = std::move(part.mesh.file), .sha256 = {}});
        });
    if (!is_usable) parts.pop_back();
  }
  require_any(asset, parts.size());
  require_parts(asset, planned.job.settings, planned.outputs);
  std::vector<MeshNeed> needs;
  for (const Part& part : parts) {
    needs.push_back({&part.ready, &part.mesh.vertices});
    finest = std::max(finest, expected_fit(part.ready).input.density.level());
  }
  const Forecast forecast =
      forecast_of(needs, planned.job.settings, planned.outputs, 0, asset.byte_count());
  require_memory_for(needs, planned.job.settings, planned.outputs);
  const auto kept = asset.surfaces().size() - parts.size();
  std::string text = formatted(
      "would fit {}: {}{}, {}, {}\n{}  solve        {}, for each mesh\n", file.name,
      counted(std::ssize(asset.surfaces()), "mesh"),
      kept > 0 ? " (" + with_separators(static_cast<std::int64_t>(kept)) + " would stay as it is)"
               : "",
      counted(vertices, "vertex"), counted(faces, "face"), device_line(device),
      solve_text(planned.job.settings, chooses_by_measurement(planned.job.settings)));
  PlannedJob shown = planned;
  shown.outputs = settled(planned.outputs, {finest});
  text += outputs_text(shown, file.format, {}, forecast, claims);
  return text + needs_text(forecast);
}

std::string describe(const PlannedJob& planned, const DeviceDescription& device,
                     const PathClaims& claims, std::uint64_t page_bytes) {
  InputFile file = load_input(planned.job.input, planned.job.input_format);
  file.split_normals_crease = planned.job.settings.creases.split_normals;
  file.is_strict = planned.job.settings.repair == RepairChoice::None;
  file.reach = planned.job.settings.textures;
  if (holds_points_only(file.format))
    return describe_points(planned, points_of(file), device, claims, page_bytes);
  if (!reason_to_merge(planned.job, planned.outputs))
    if (const auto asset = asset_of(file.for_reader(), file.format))
      return describe_asset(planned, file, *asset, device, claims);
  require_asset_for_lods(planned.outputs);
  Input input = mesh_of(file);
  if (const auto cloud = points_of(input)) {
    (void)require_mesher();
    return describe_points(planned, *cloud, device, claims, page_bytes);
  }
  return describe_mesh(planned, std::move(input), device, claims, page_bytes);
}

}  // namespace

ExitCode describe_jobs(const std::vector<PlannedJob>& jobs, const DeviceList& devices,
                       const PathClaims& claims, const BatchFiles& files) {
  ExitCode exit_code = ExitCode::Done;
  for (const PlannedJob& planned : jobs) {
    std::string text;
    try {
      const bool has_page = !planned.job.page.empty() || !files.page.empty();
      text = describe(planned, devices.devices[planned.device].description, claims,
                      has_page ? files.page_bytes : 0);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Cancelled) throw;
      text = "would fail on " + named_message(planned.job.label, error.what()) + "\n";
      exit_code = jobs.size() > 1 ? ExitCode::JobsFailed : exit_code_of(error.code());
    }
    if (!planned.job.report.empty())
      text += write_line(path_of(planned.job.report), "  (report)", claims);
    if (!planned.job.page.empty())
      text += write_line(path_of(planned.job.page), "  (page)", claims);
    write_text(text);
  }
  const char* of_all = jobs.size() > 1 ? " of all jobs)" : ")";
  if (!files.report.empty())
    write_text(write_line(path_of(files.report), std::string("  (report") + of_all, claims));
  if (!files.page.empty())
    write_text(write_line(path_of(files.page), std::string("  (page") + of_all, claims));
  if (claims.any_refused()) exit_code = ExitCode::UnwritableOutput;  // before any work
  write_text(
      formatted("would end with exit code {}{}", static_cast<int>(exit_code),
                exit_code == ExitCode::Done ? ", or 5 if the solve does not converge\n" : "\n"));
  return exit_code;
}

}  // namespace planish::command
