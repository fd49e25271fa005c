#include "job/describe_job.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <algorithm>
#include <list>

#include "memory/large_arrays.h"
#include "planish/core/error.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/write_polygons.h"
#include "planish/job/asset_job.h"
#include "planish/job/forecast.h"
#include "planish/job/input.h"
#include "planish/job/job_input.h"
#include "planish/job/point_input.h"
#include "planish/job/text.h"
#include "planish/pipeline/option_words.h"

namespace planish::command {
namespace {

std::string write_line(const std::filesystem::path& path, const std::string& what,
                       const PathClaims& claims) {
  const std::string refusal = claims.refusal(path);
  if (!refusal.empty()) return "  would refuse " + refusal + "\n";
  return formatted("  would write  {}{}\n", output_name(path.native()), what);
}

std::string file_text(const OutputForecast& file, std::string_view faces,
                      GltfCompression compression) {
  if (file.vertices == 0) return "";
  std::string text =
      formatted(", {}, {}", counted(file.vertices, "vertex"), counted(file.faces, faces));
  if (!file.bytes) return text;
  const bool is_known = compression == GltfCompression::None;
  return text + (is_known ? ", about " : ", at most about ") + byte_size(*file.bytes);
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

// The files beside an output of about so many bytes: a .gltf's buffers; that of an OBJ is written
// for materials only.
std::string companion_lines(const PlannedOutput& output, std::uint64_t bytes,
                            const PolygonMesh& mesh, GltfCompression compression,
                            const PathClaims& claims) {
  const std::filesystem::path beside = companion_of(output.path, output.format);
  if (output.to_stdout || beside.empty()) return {};
  const bool is_gltf = info_of(output.format).is_gltf;
  if (!is_gltf && materials_of(mesh.groups).empty() && claims.refusal(beside).empty()) return {};
  std::string text = write_line(beside, is_gltf ? "  (its numbers)" : "  (its materials)", claims);
  if (!is_gltf || compression != GltfCompression::None) return text;
  const std::size_t count = gltf_buffer_count(bytes);
  for (std::size_t i = 1; i < count; ++i)
    text += write_line(gltf_buffer_path(output.path, i), "  (further numbers)", claims);
  return text;
}

// `input`: its format.
std::string outputs_text(const PlannedJob& planned, FileFormat input, const PolygonMesh& mesh,
                         const Forecast& forecast, const PathClaims& claims) {
  const GltfCompression compression = planned.job.settings.compression;
  std::string text;
  for (std::size_t i = 0; i < planned.outputs.size(); ++i) {
    const PlannedOutput& output = planned.outputs[i];
    const OutputForecast& file = forecast.outputs[i];
    const bool is_cage = output.kind == OutputKind::Cage;
    const std::string what =
        info_of(output.format).is_brep
            ? formatted("  (at least {}, in {})", counted(file.faces, "B-spline face"),
                        word_of(kStepUnitWords,
                                settled_unit(planned.job.settings.step.unit, name_of(input))))
            : formatted(
                  "  ({}{})",
                  is_cage ? "control cage" : finenesses_text(output.fineness, output.coarser),
                  file_text(file, faces_of(output, planned.job.settings.scheme), compression));
    text += write_line(output.path, what, claims);
    text += companion_lines(output, file.bytes.value_or(0), mesh, compression, claims);
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
  (void)take_cage(ready, planned.outputs, !planned.job.page.empty());
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
  const FittedMesh& fitted = expected_fit(ready).fitted;
  const PolygonMesh& mesh = fitted.mesh;
  const MeshNeed need{&ready, nullptr};
  const Forecast forecast = forecast_of({&need, 1}, settings, planned.outputs, page_bytes);
  require_memory_for({&need, 1}, settings, planned.outputs);
  std::string text = formatted(
      "would fit {}: {}\n{}  solve        {}, {}{}, tolerance {}\n", name,
      counts_text(vertices, faces, mesh.vertex_count(), mesh.face_count(), fitted.paired_count,
                  std::ssize(fitted.added_vertices)),
      device_line(device), solve_text(settings, ready.chooses_method),
      ready.paired && !ready.is_plainly_halved ? "triangles joined to quads where that is better, "
      : ready.refined                          ? "vertices added where that is better, "
                                               : "",
      subdivision_text(settings.scheme, settings.weights), short_number(settings.tolerance));
  PlannedJob shown = planned;
  shown.outputs = settled(planned.outputs, fitted.density.level());
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
  std::vector<MeshNeed> needs;
  for (const Part& part : parts) {
    needs.push_back({&part.ready, &part.mesh.vertices});
    finest = std::max(finest, expected_fit(part.ready).fitted.density.level());
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
  shown.outputs = settled(planned.outputs, finest);
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
    if (!planned.job.report.empty()) text += write_line(planned.job.report, "  (report)", claims);
    if (!planned.job.page.empty()) text += write_line(planned.job.page, "  (page)", claims);
    write_text(text);
  }
  const char* of_all = jobs.size() > 1 ? " of all jobs)" : ")";
  if (!files.report.empty())
    write_text(write_line(files.report, std::string("  (report") + of_all, claims));
  if (!files.page.empty())
    write_text(write_line(files.page, std::string("  (page") + of_all, claims));
  if (claims.any_refused()) exit_code = ExitCode::UnwritableOutput;  // before any work
  write_text(
      formatted("would end with exit code {}{}", static_cast<int>(exit_code),
                exit_code == ExitCode::Done ? ", or 5 if the solve does not converge\n" : "\n"));
  return exit_code;
}

}  // namespace planish::command
