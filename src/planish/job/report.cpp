#include "planish/job/report_json.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/job/build_info.h"
#include "planish/pipeline/fit_report.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/option_words.h"

namespace planish {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson input_json(const InputFacts& input, const FitFigures& fit) {
  OrderedJson json{{"path", input.path}, {"sha256", input.sha256}, {"format", input.format}};
  const OrderedJson mesh =
      input_json(fit, input.statistics, input.folded_edges, input.folded_edge_area);
  for (const auto& [key, value] : mesh.items()) {
    json[key] = value;
    if (key != "welded") continue;
    json[key] = input.welded;  // by readers, too
    json["dropped"] = input.dropped;
  }
  json["file_vertices"] = input.file_vertices;
  json["file_faces"] = input.file_faces;
  return json;
}

OrderedJson surface_json(const JobReport& report) {
  if (!report.surface) return nullptr;
  const MeasuredSurface& surface = *report.surface;
  OrderedJson json = quality_json(surface.quality, surface.level);
  if (!surface.reference.empty()) json["reference"] = surface.reference;
  json["sheet_gap"] = surface.sheet_gap ? OrderedJson(*surface.sheet_gap) : OrderedJson();
  if (surface.texture_slide) {
    const TextureSlide& slide = *surface.texture_slide;
    json["texture_slide"] = {{"largest", slide.largest},
                             {"rms", slide.rms},
                             {"largest_distance", slide.largest_distance},
                             {"rms_distance", slide.rms_distance}};
  }
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

OrderedJson spot_json(const Brep::Spot& spot) {
  if (spot.face < 0) return nullptr;
  const auto& p = spot.position;
  return {{"position", {p.x, p.y, p.z}}, {"face", spot.face}};
}

OrderedJson step_json(const StepFigures& step) {
  return {{"unit", word_of(kStepUnitWords, step.unit)},
          {"faces", step.faces},
          {"edges", step.edges},
          {"vertices", step.vertices},
          {"control_points", step.control_points},
          {"planes", step.planes},
          {"solids", step.solids},
          {"voids", step.voids},
          {"open_shells", step.open_shells},
          {"extraordinary", step.extraordinary},
          {"deepest", step.deepest},
          {"max_angle", step.max_angle},
          {"max_angle_at", spot_json(step.max_angle_at)},
          {"max_deviation", step.max_deviation},
          {"max_deviation_at", spot_json(step.max_deviation_at)},
          {"keeps_limits", step.keeps_limits},
          {"valid", step.check.is_valid()},
          {"largest_gap", step.check.largest_gap}};
}

OrderedJson bake_json(const WrittenOutput& output) {
  OrderedJson json{{"size", output.bake_size}, {"maps", OrderedJson::array()}};
  for (const WrittenMap& map : output.maps) {
    OrderedJson& entry = json["maps"].emplace_back();
    if (!map.mesh.empty()) entry["mesh"] = map.mesh;
    entry["material"] = map.material;
    entry["bytes"] = map.bytes;
    entry["covered"] = map.covered;
    entry["overlapped"] = map.overlapped;
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
    const bool has_level =
        output.kind == OutputKind::Surface && !output.fineness.is_adaptive() && !output.step;
    entry["level"] = has_level ? OrderedJson(output.fineness.level) : OrderedJson();
    if (output.fineness.chord_error > 0) entry["chord_error"] = output.fineness.chord_error;
    if (output.fineness.angle > 0) entry["angle"] = output.fineness.angle;
    for (const Fineness& coarser : output.coarser)
      entry["coarser"].push_back(coarser.is_adaptive()
                                     ? OrderedJson{{"chord_error", coarser.chord_error}}
                                     : OrderedJson{{"level", coarser.level}});
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
    if (output.step) entry["step"] = step_json(*output.step);
    if (output.bake_size > 0) entry["bake"] = bake_json(output);
    json.push_back(entry);
  }
  return json;
}

OrderedJson timing_json(const JobTiming& timing) {
  OrderedJson json;
  for (const auto& [name, step] : kTimedSteps) json[name] = timing.*step;
  json["total"] = timing.total;
  return json;
}

OrderedJson device_json(const DeviceDescription& device) {
  return {{"kind", device.kind},
          {"name", device.name},
          {"uuid", device.uuid},
          {"driver", device.driver},
          {"api", device.api}};
}

// Of a mesh of an asset.
OrderedJson asset_json(const JobReport& report) {
  return {{"mesh", report.mesh_number},
          {"name", report.mesh_name},
          {"lost_joint_weight", report.lost_joint_weight}};
}

// What was fitted, and how good it is.
void add_fit(const JobReport& report, OrderedJson& json) {
  json["solve"] = solve_json(report.fit);
  if (report.moved) {
    json["moved"] = {{"moves", report.moved->moves},
                     {"vertices", report.moved->vertices},
                     {"farthest", report.moved->farthest}};
  }
  json["surface"] = surface_json(report);
  if (report.fit.density.is_dense())
    json["density"] = {{"vertices", report.fit.density.vertex_count},
                       {"even_area", report.fit.density.even_share},
                       {"level", report.fit.density.level()}};
}

OrderedJson meshes_json(const std::vector<JobReport>& meshes) {
  OrderedJson json = OrderedJson::array();
  for (const JobReport& mesh : meshes) {
    OrderedJson& entry = json.emplace_back();
    entry["asset"] = asset_json(mesh);
    entry["input"] = input_json(mesh.input, mesh.fit);
    add_fit(mesh, entry);
    entry["warnings"] = warnings_json(mesh.warnings);
  }
  return json;
}

OrderedJson asset_input_json(const InputFacts& input) {
  return {{"path", input.path},
          {"sha256", input.sha256},
          {"format", input.format},
          {"file_vertices", input.file_vertices},
          {"file_faces", input.file_faces}};
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

OrderedJson to_json(const PointFacts& points) {
  const ReconstructionFigures& result = points.mesh;
  const MeshStatistics& facts = result.statistics;
  const auto faces_of = [&](std::size_t corners) {
    return facts.face_size_counts.size() > corners ? facts.face_size_counts[corners] : 0;
  };
  OrderedJson json;
  json["points"] = points.points;
  json["missing"] = points.missing;
  json["duplicates"] = result.duplicate_count;
  json["outliers"] = result.outlier_count;
  json["used"] = points.used;
  json["origin"] = {points.origin.x, points.origin.y, points.origin.z};
  json["diagonal"] = result.diagonal;
  json["spacing"] = result.spacing;
  json["noise"] = result.noise < 0 ? OrderedJson() : OrderedJson(result.noise);
  json["smooth"] = result.smooth_rounds;
  json["tolerance"] = result.tolerance;
  json["vertices"] = facts.vertex_count;
  json["faces"] = facts.face_count;
  json["quads"] = faces_of(4);
  json["triangles"] = faces_of(3);
  json["components"] = facts.component_count;
  json["components_dropped"] = result.dropped_component_count;
  json["genus"] = facts.genus;
  json["boundary_loops"] = facts.boundary_loop_count;
  json["loops_filled"] = result.filled_loop_count;
  json["points_left_out"] = result.strayed_count;
  json["thinned"] = result.sample_count == 0 ? 0 : points.used - result.sample_count;
  json["inserted"] = result.inserted_count;
  json["meshings"] = result.meshing_count;
  json["max_point_distance"] = result.distances.max / result.diagonal;
  json["rms_point_distance"] = result.distances.rms / result.diagonal;
  json["valence_histogram"] = histogram_json(facts.valence_counts);
  const ReconstructTiming& timing = result.timing;
  json["timing_ms"] = {{"clean", timing.clean},       {"smooth", timing.smooth},
                       {"mesh", timing.mesh},         {"repair", timing.repair},
                       {"simplify", timing.simplify}, {"measure", timing.measure}};
  if (!points.sampled) return json;
  const Sampling& sampling = *points.sampled;
  json["sampled"] = {{"points", sampling.points},
                     {"pattern", sampling.poisson_disk ? "poisson-disk" : "uniform"},
                     {"seed", sampling.seed},
                     {"noise", sampling.noise},
                     {"outliers", sampling.outliers}};
  return json;
}

OrderedJson to_json(const JobReport& report) {
  const bool is_one = report.meshes.empty();
  OrderedJson json;
  json["schema"] = "planish.report/1";
  json["tool"] = {{"name", "planish"}, {"version", PLANISH_VERSION}, {"git", git_revision()}};
  json["argv"] = report.arguments;
  json["job"] = report.job;
  json["exit_code"] = report.falls_short ? kFallsShortCode : 0;
  json["input"] = is_one ? input_json(report.input, report.fit) : asset_input_json(report.input);
  if (report.points) json["reconstruction"] = to_json(*report.points);
  if (is_one && report.mesh_number >= 0) json["asset"] = asset_json(report);
  json["device"] = device_json(report.device);
  if (is_one) {
    add_fit(report, json);
  } else {
    json["meshes"] = meshes_json(report.meshes);
  }
  json["outputs"] = outputs_json(report.outputs);
  json["timing_ms"] = timing_json(report.timing);
  json["memory"] = {{"host_peak_bytes", report.host_peak_bytes},
                    {"device_bytes", report.device_bytes}};
  json["warnings"] = warnings_json(report.warnings);
  return json;
}

std::string report_json(const JobReport& report) { return json_text(to_json(report)); }

std::uint64_t peak_host_bytes() {
#ifdef __linux__
  // What getrusage() says begins with the memory of who started the process.
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word && word != "VmHWM:") {
  }
  if (std::uint64_t kibibytes = 0; status >> kibibytes) return 1024 * kibibytes;
#endif
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) return 0;
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;  // Linux counts in KiB
}

}  // namespace planish
