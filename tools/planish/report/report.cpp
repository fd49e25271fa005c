#include "report/report.h"

#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "build_info.h"
#include "planish/core/version.h"

namespace planish::command {
namespace {

using OrderedJson = nlohmann::ordered_json;

// Infinite and NaN errors have no JSON number; they become null.
OrderedJson norms_json(const ErrorNorms& norms) { return {{"max", norms.max}, {"rms", norms.rms}}; }

OrderedJson input_json(const InputFacts& input) {
  OrderedJson json;
  json["path"] = input.path;
  json["sha256"] = input.sha256;
  json["format"] = input.format;
  json["vertices"] = input.statistics.vertex_count;
  json["faces"] = input.statistics.face_count;
  json["face_sizes"] = histogram_json(input.statistics.face_size_counts);
  json["boundary_loops"] = input.statistics.boundary_loop_count;
  json["components"] = input.statistics.component_count;
  json["genus"] = input.statistics.genus;
  json["sharp_edges"] = input.sharp_edges;
  json["corners"] = input.corners;
  json["folded_edges"] = {{"count", input.folded_edges}, {"area", input.folded_edge_area}};
  json["welded"] = input.welded;
  json["dropped"] = input.dropped;
  json["separated_edges"] = input.separated_edges;
  json["changed_faces"] = input.changed_faces;
  json["file_vertices"] = input.file_vertices;
  json["file_faces"] = input.file_faces;
  return json;
}

OrderedJson choice_json(const std::optional<MethodChoice>& choice) {
  if (!choice) return nullptr;
  const auto figures = [](const std::optional<SurfaceQuality>& quality) -> OrderedJson {
    if (!quality) return nullptr;
    return {{"folded_area_elsewhere", quality->folded_area_elsewhere},
            {"rms_normal_deviation", quality->rms_normal_deviation}};
  };
  return {{"reason", choice->reason},
          {"progressive", figures(choice->progressive)},
          {"fair", figures(choice->fair)}};
}

OrderedJson solve_json(const JobReport& report) {
  const Interpolation& result = report.interpolation;
  const bool iterates = report.method == InterpolationMethod::Progressive;
  OrderedJson json;
  json["method"] = name_of(report.method);
  json["choice"] = choice_json(report.choice);
  json["scheme"] = name_of(report.settings.scheme);
  const bool has_weights = report.settings.scheme == Scheme::DooSabin;
  json["weights"] = has_weights ? OrderedJson(name_of(report.settings.weights)) : OrderedJson();
  json["solver"] = iterates ? OrderedJson(name_of(report.settings.solver)) : OrderedJson();
  json["boundary"] = name_of(report.settings.boundary);
  json["creases"] = name_of(report.settings.creases);
  json["repair"] = name_of(report.settings.repair);
  json["weld"] = report.settings.weld ? OrderedJson(*report.settings.weld) : OrderedJson();
  json["tolerance"] = report.settings.tolerance;
  json["converged"] = result.converged;
  json["stop_reason"] = planish::name_of(result.stop_reason);
  json["iterations"] = result.iterations;
  json["spectral_bound"] = iterates ? OrderedJson(report.spectral_bound) : OrderedJson();
  json["error"] = norms_json(result.error);
  json["error"]["worst_vertex"] = result.worst_vertex;
  json["history"] = OrderedJson::array();
  for (std::size_t i = 0; i < result.history.size(); ++i) {
    OrderedJson entry{{"iteration", i}};
    entry.update(norms_json(result.history[i]));
    json["history"].push_back(entry);
  }
  json["fair"] = nullptr;
  if (report.fair) {
    json["fair"] = {{"polish", report.settings.polish_steps},
                    {"shrunk_vertices", report.fair->shrunk_vertices},
                    {"reversed_vertices", report.fair->reversed_vertices},
                    {"cured_vertices", report.fair->cured_vertices},
                    {"smoothed_vertices", report.smoothed_vertices.size()},
                    {"flagged_edges", report.fair->flagged_edges},
                    {"flagged_faces", report.fair->flagged_faces}};
  }
  return json;
}

OrderedJson surface_json(const JobReport& report) {
  if (!report.surface) return nullptr;
  const MeasuredSurface& surface = *report.surface;
  OrderedJson json;
  json["level"] = surface.level;
  json["reference"] = surface.reference.empty() ? "input" : surface.reference;
  json["folded_area"] = surface.quality.folded_area;
  json["folded_area_elsewhere"] = surface.quality.folded_area_elsewhere;
  json["rms_normal_deviation"] = surface.quality.rms_normal_deviation;
  json["max_normal_deviation"] = surface.quality.max_normal_deviation;
  json["bending"] = surface.quality.bending;
  json["sheet_gap"] = surface.sheet_gap ? OrderedJson(*surface.sheet_gap) : OrderedJson();
  if (surface.source_distances) {
    json["max_source_distance"] = surface.source_distances->max;
    json["rms_source_distance"] = surface.source_distances->rms;
  }
  if (surface.distances_from_source) {
    json["max_distance_from_source"] = surface.distances_from_source->max;
    json["rms_distance_from_source"] = surface.distances_from_source->rms;
  }
  if (report.point_distances) {
    json["max_point_distance"] = report.point_distances->max;
    json["rms_point_distance"] = report.point_distances->rms;
  }
  return json;
}

OrderedJson outputs_json(const std::vector<WrittenOutput>& outputs) {
  OrderedJson json = OrderedJson::array();
  for (const WrittenOutput& output : outputs) {
    OrderedJson entry;
    entry["path"] = output.path;
    entry["what"] = output.kind == OutputKind::Cage ? "cage" : "surface";
    entry["bytes"] = output.bytes;
    entry["sha256"] = output.sha256;
    const bool has_level = output.kind == OutputKind::Surface && !output.fineness.is_adaptive();
    entry["level"] = has_level ? OrderedJson(output.fineness.level) : OrderedJson();
    if (output.fineness.chord_error > 0) entry["chord_error"] = output.fineness.chord_error;
    if (output.fineness.angle > 0) entry["angle"] = output.fineness.angle;
    entry["vertices"] = output.vertices;
    entry["quads"] = output.quads;
    entry["triangles"] = output.triangles;
    entry["as_written_error"] = output.as_written_error;
    for (const WrittenTiles& level : output.tile_levels) {
      entry["tiles"].push_back({{"level", level.level},
                                {"tiles", level.tiles},
                                {"bytes", level.bytes},
                                {"vertices", level.vertices},
                                {"triangles", level.triangles},
                                {"geometric_error", level.geometric_error}});
    }
    json.push_back(entry);
  }
  return json;
}

OrderedJson timing_json(const JobTiming& timing) {
  return {{"read", timing.read},         {"check", timing.check},
          {"topology", timing.topology}, {"stencils", timing.stencils},
          {"upload", timing.upload},     {"solve", timing.solve},
          {"choose", timing.choose},     {"evaluate", timing.evaluate},
          {"write", timing.write},       {"total", timing.total}};
}

OrderedJson warnings_json(const std::vector<Warning>& warnings) {
  OrderedJson json = OrderedJson::array();
  for (const Warning& warning : warnings) {
    json.push_back({{"code", warning.code},
                    {"message", warning.message},
                    {"count", warning.count},
                    {"first", warning.first}});
  }
  return json;
}

}  // namespace

OrderedJson histogram_json(const std::vector<std::int64_t>& counts) {
  OrderedJson json = OrderedJson::object();
  for (std::size_t n = 0; n < counts.size(); ++n) {
    if (counts[n] != 0) json[std::to_string(n)] = counts[n];
  }
  return json;
}

std::string json_text(const OrderedJson& value) {
  return value.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

OrderedJson to_json(const JobReport& report) {
  const DeviceDescription& device = report.device;
  OrderedJson json;
  json["schema"] = "planish.report/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", kGitRevision}};
  json["argv"] = report.arguments;
  json["job"] = report.job;
  json["exit_code"] = static_cast<int>(report.exit_code);
  json["input"] = input_json(report.input);
  if (!report.reconstruction.is_null()) json["reconstruction"] = report.reconstruction;
  json["device"] = {{"kind", device.kind},
                    {"name", device.name},
                    {"uuid", device.uuid},
                    {"driver", device.driver},
                    {"api", device.api}};
  json["solve"] = solve_json(report);
  json["surface"] = surface_json(report);
  json["outputs"] = outputs_json(report.outputs);
  json["timing_ms"] = timing_json(report.timing);
  json["memory"] = {{"host_peak_bytes", report.host_peak_bytes},
                    {"device_bytes", report.device_bytes}};
  json["warnings"] = warnings_json(report.warnings);
  return json;
}

std::uint64_t peak_host_bytes() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

}  // namespace planish::command
