#include "planish/job/report.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "planish/brep/analytic_faces.h"
#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/job/build_info.h"
#include "planish/job/input.h"
#include "planish/job/job_text.h"
#include "planish/pipeline/fit_report.h"
#include "planish/pipeline/option_table.h"

namespace planish {
namespace {

std::string printed(const char* format, double value) {
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

}  // namespace

std::string duration(double milliseconds) {
  if (milliseconds >= 1000) return printed("%.2f s", milliseconds / 1000);
  return printed(milliseconds >= 10 ? "%.0f ms" : "%.1f ms", milliseconds);
}

std::string rough_duration(double seconds) {
  const double unit = seconds < 100 ? 1 : 60;
  const double least = seconds / unit / 3;
  return (least < 1 ? "under " : printed("%.0f to ", least)) +
         printed(unit > 1 ? "%.0f min" : "%.0f s", std::max(1.0, std::ceil(3 * seconds / unit)));
}

std::string input_name(std::string_view path) { return path == "-" ? "stdin" : visible(path); }

std::string output_name(std::string_view path) { return path == "-" ? "stdout" : visible(path); }

std::string named_message(std::string_view name, const std::string& message) {
  if (name.empty() || message.starts_with(std::string(name) + ":")) return message;
  return std::string(name) + ": " + message;
}

std::string plain_utf8(std::string_view text) {
  const std::string plain = without_controls(text, '?');
  std::string out;
  for (std::string_view rest = plain; !rest.empty();) {
    const std::size_t length = utf8_length(rest);
    out += length == 0 ? std::string_view("?") : rest.substr(0, length);
    rest.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

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

OrderedJson analytic_json(const StepFigures& step) {
  if (step.analytic_parts + step.mixed_parts + step.freeform_parts == 0) return nullptr;
  OrderedJson json{{"parts", step.analytic_parts},
                   {"mixed_parts", step.mixed_parts},
                   {"freeform_parts", step.freeform_parts}};
  for (std::size_t k = 0; k < kAnalyticKinds; ++k)
    json["faces"][std::string(name_of(static_cast<AnalyticKind>(k)))] = step.analytic[k];
  json["radii"] = step.radii;
  json["largest_distance"] = step.analytic_distance;
  if (!step.freeform_reason.empty()) json["freeform_reason"] = step.freeform_reason;
  return json;
}

OrderedJson step_json(const StepFigures& step) {
  return {{"unit", word_of(kStepUnitWords, step.unit)},
          {"faces", step.faces},
          {"edges", step.edges},
          {"vertices", step.vertices},
          {"control_points", step.control_points},
          {"planes", step.planes},
          {"analytic", analytic_json(step)},
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

// What was asked for and what came of it, of the next figures where there is a target.
void add_target(const DecimationTarget& target,
                std::vector<DecimationFigures>::const_iterator& figures, OrderedJson& json) {
  if (!target.any()) return;
  OrderedJson& made = json["decimated"];
  if (target.triangles > 0) made["faces"] = target.triangles;
  if (target.edge_length > 0) made["edge_length"] = target.edge_length;
  if (target.distance > 0) made["distance"] = target.distance;
  made["max_distance"] = figures->max;
  made["rms_distance"] = figures->rms;
  made["measured_from"] = figures->places;
  made["finer_triangles"] = figures->finer;
  made["mean_edge_length"] = figures->mean_edge_length;
  ++figures;
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
    auto figures = output.decimated.begin();
    add_target(output.fineness.target, figures, entry);
    for (const Fineness& coarser : output.coarser) {
      OrderedJson& one = entry["coarser"].emplace_back();
      if (!coarser.is_adaptive()) one["level"] = coarser.level;
      if (coarser.chord_error > 0) one["chord_error"] = coarser.chord_error;
      add_target(coarser.target, figures, one);
    }
    entry["vertices"] = output.vertices;
    entry["quads"] = output.quads;
    entry["triangles"] = output.triangles;
    entry["as_written_error"] = output.as_written_error;
    if (output.kind == OutputKind::Cage) {
      entry["scheme"] = name_of(output.scheme);
      entry["creases"] = output.creases;
    }
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
  OrderedJson json{{"mesh", report.mesh_number},
                   {"name", report.mesh_name},
                   {"lost_joint_weight", report.lost_joint_weight}};
  for (const PartSetting& one : report.part_settings)
    json["set"].push_back({{"part", one.who()}, {"option", one.option}, {"value", one.value}});
  return json;
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

namespace {

std::string shape_of(const MeshStatistics& statistics) {
  std::string shape = statistics.boundary_loop_count == 0
                          ? "closed"
                          : "open, " + counted(statistics.boundary_loop_count, "boundary loop");
  if (statistics.component_count != 1) {
    shape += ", " + counted(statistics.component_count, "component");
  }
  return formatted("{}, genus {}", shape, statistics.genus);
}

std::string timing_line(const JobTiming& timing) {
  std::string line = duration(timing.total) + " (";
  const char* separator = "";
  for (const auto& [name, step] : kTimedSteps) {
    if (timing.*step < 0.05) continue;
    line += separator + std::string(name) + " " + duration(timing.*step);
    separator = ", ";
  }
  return line + ")";
}

// Rounding noise of flat surfaces is nothing to read.
std::string angle_text(double degrees) {
  constexpr double kNoise = 1e-6;
  return degrees < kNoise ? "0" : short_number(degrees);
}

// "14 faces (3 planes, 9 cylinders, 2 tori)".
std::string faces_text(const StepFigures& step) {
  if (step.analytic_parts + step.mixed_parts == 0) return counted(step.faces, "B-spline face");
  std::string kinds;
  std::int64_t others = step.faces;
  for (std::size_t k = 0; k < kAnalyticKinds; ++k) {
    if (step.analytic[k] == 0) continue;
    const auto kind = static_cast<AnalyticKind>(k);
    kinds += kinds.empty() ? "" : ", ";
    kinds += kind == AnalyticKind::Torus && step.analytic[k] != 1
                 ? formatted("{} tori", step.analytic[k])
                 : counted(step.analytic[k], std::string(name_of(kind)));
    others -= step.analytic[k];
  }
  if (others > 0) kinds += ", " + counted(others, "B-spline face");
  return counted(step.faces, "face") + " (" + kinds + ")";
}

std::string output_line(const WrittenOutput& output, std::size_t path_width) {
  std::string line = output_name(output.path);
  line.resize(std::max(line.size(), path_width), ' ');
  line += "  " + byte_size(output.bytes) + ", ";
  if (output.kind == OutputKind::Cage) {
    if (output.scheme == Scheme::DooSabin) return line + "control cage";
    return formatted("{}{} control cage, {}, within {} of the vertices", line,
                     name_of(output.scheme), counted(output.creases, "crease edge"),
                     short_number(output.as_written_error));
  }
  if (output.step) {
    const StepFigures& step = *output.step;
    line += faces_text(step);
    if (step.solids > 0) line += ", " + counted(step.solids, "solid");
    if (step.open_shells > 0) line += ", " + counted(step.open_shells, "open shell");
    if (output.as_written_error > kExactTolerance)
      line += formatted(", within {} of the diagonal of its vertices",
                        short_number(output.as_written_error));
    return formatted("{}, {} degrees at edges, in {}", line, angle_text(step.max_angle),
                     word_of(kStepUnitWords, step.unit));
  }
  if (!output.tile_levels.empty()) {
    std::int64_t tiles = 0;
    for (const WrittenTiles& level : output.tile_levels) tiles += level.tiles;
    line += counted(tiles, "tile") + ", to ";
  }
  line +=
      finenesses_text(output.fineness, output.coarser) + ", " + counted(output.vertices, "vertex");
  if (output.fineness.level == 0) return line + ", " + counted(output.faces, "face");
  line += ", " + (output.quads > 0 ? counted(output.quads, "quad")
                                   : counted(output.triangles, "triangle"));
  for (std::size_t i = 0; i < output.decimated.size(); ++i)
    line += (i == 0 ? ", within " : ", ") + short_number(output.decimated[i].max);
  return output.decimated.empty() ? line : line + " of the diagonal";
}

std::string method_line(const JobReport& report) {
  const Interpolation& result = report.fit.interpolation;
  const std::string weights =
      subdivision_text(report.settings.scheme, report.settings.weights) + ")";
  std::string line;
  if (report.fit.fair) {
    line = "  method      fair (" + counted(report.settings.polish_steps, "polish step") + ", " +
           weights + ", " + counted(report.fit.fair->shrunk_vertices, "vertex") + " drawn in";
  } else {
    line = formatted("  iterations  {} ({}, {}", result.iterations, name_of(report.settings.solver),
                     weights);
  }
  if (!result.converged) {
    line += ", not converged: " + std::string(planish::name_of(result.stop_reason));
  }
  return line;
}

std::string chosen_lines(const JobReport& report) {
  std::string text;
  const auto add = [&](const std::string& reason) {
    if (!reason.empty())
      text += (text.empty() ? "  chosen      " : "              ") + reason + "\n";
  };
  if (!report.fit.choice) return text;
  add(report.fit.choice->reason);
  add(report.fit.choice->faces_reason);
  return text;
}

std::string input_folds_line(const InputFacts& input) {
  if (input.folded_edges == 0) return "";
  return formatted(
      "  folds       {} of the input {} by more than 120 degrees, beside {} of its area\n",
      counted(input.folded_edges, "edge"), input.folded_edges == 1 ? "turns" : "turn",
      percent(input.folded_edge_area));
}

std::string mending_lines(const JobReport& report) {
  std::string text;
  if (report.settings.weld)
    text += formatted("  welded      {} to others within {} of the diagonal\n",
                      counted(report.input.welded, "vertex"), short_number(*report.settings.weld));
  if (report.fit.separated_edges == 0) return text;
  text += "  sheets      separated along " + counted(report.fit.separated_edges, "edge");
  if (report.surface && report.surface->sheet_gap)
    text += ", at most " + short_number(*report.surface->sheet_gap) + " of the diagonal apart";
  return text + "\n";
}

std::string folds_text(const SurfaceQuality& quality) {
  std::string folds = percent(quality.folded_area) + " folded";
  if (quality.folded_area_elsewhere < quality.folded_area) {
    folds += " (" + percent(quality.folded_area_elsewhere) + " where the input is not)";
  }
  return folds;
}

// Names the level where no file has it.
std::string normals_text(const JobReport& report) {
  const MeasuredSurface& surface = *report.surface;
  const bool is_written = std::ranges::any_of(report.outputs, [&](const WrittenOutput& output) {
    return output.kind == OutputKind::Surface && !output.step && !output.fineness.is_adaptive() &&
           output.fineness.level == surface.level;
  });
  return formatted("normals off by {} degrees rms from {}{}",
                   angle_text(surface.quality.rms_normal_deviation),
                   surface.reference.empty() ? "the input's faces" : surface.reference,
                   is_written ? "" : formatted(" at level {}", surface.level));
}

// What was taken and why, and how good it is.
std::string surface_line(const JobReport& report) {
  const Interpolation& result = report.fit.interpolation;
  std::string text = "  surface     ";
  if (report.fit.choice && !report.fit.choice->reason.empty()) {
    text += report.fit.choice->reason;
  } else if (report.settings.scheme != Scheme::DooSabin) {
    text += word_of(kSchemeWords, report.settings.scheme);
  } else {
    text += word_of(kMethodWords, report.fit.method);
  }
  // Why the mesh's own faces stayed is for who reads the whole report.
  if (report.fit.choice && report.fit.choice->has_other_faces())
    text += "; " + report.fit.choice->faces_reason;
  if (!result.converged) text += "; not converged: the error is " + short_number(result.error.max);
  if (!report.surface) return text + "\n";
  if (report.surface->quality.folded_area >= kSoundFoldedArea)
    text += "; " + folds_text(report.surface->quality);
  return formatted("{}; {}\n", text, normals_text(report));
}

std::string moved_line(const JobReport& report) {
  if (!report.moved) return "";
  return formatted("  moved       {} in {}, by up to {} of the diagonal\n",
                   counted(report.moved->vertices, "vertex"), counted(report.moved->moves, "move"),
                   short_number(report.moved->farthest));
}

std::string within_line(const JobReport& report) {
  return report.fit.within ? "  within      " + within_text(*report.fit.within) + "\n" : "";
}

}  // namespace

std::string counts_text(std::int64_t file_vertices, std::int64_t file_faces, std::int64_t vertices,
                        std::int64_t faces, std::int64_t joined, std::int64_t added) {
  std::string text = counted(file_vertices, "vertex");
  if (added > 0)
    return formatted("{}, {}; with {} added {}", text, counted(file_faces, "face"),
                     counted(added, "vertex"), counted(faces, "face"));
  if (vertices != file_vertices)
    text += ", " + with_separators(vertices) +
            (vertices > file_vertices ? " after separating sheets" : " after mending");
  text += ", " + counted(file_faces, "face");
  const std::int64_t mended = faces + joined;
  if (mended != file_faces) text += ", " + with_separators(mended) + " after mending";
  if (joined > 0) text += ", " + with_separators(faces) + " with triangles joined";
  return text;
}

namespace {

// How it was computed.
std::string computing_lines(const JobReport& report) {
  std::string text = formatted("  device      {}, {}\n{}\n", report.device.kind, report.device.name,
                               method_line(report));
  text += chosen_lines(report);
  text += within_line(report) + "  max error   " +
          short_number(report.fit.interpolation.error.max) + " of the diagonal (tolerance " +
          short_number(report.settings.tolerance) + ")\n";
  if (report.surface)
    text += formatted("  surface     {}, {}\n", folds_text(report.surface->quality),
                      normals_text(report));
  return formatted("{}  time        {}\n", text, timing_line(report.timing));
}

std::string output_lines(const JobReport& report) {
  std::size_t path_width = 0;
  for (const WrittenOutput& output : report.outputs)
    path_width = std::max(path_width, output_name(output.path).size());
  const char* label = "  wrote       ";
  std::string text;
  for (const WrittenOutput& output : report.outputs) {
    text += label + output_line(output, path_width) + "\n";
    label = "              ";
  }
  if (!report.page.path.empty())
    text += formatted("{}{}  {}, page\n", label, output_name(report.page.path),
                      byte_size(report.page.bytes));
  return text;
}

bool has_level_by_density(const JobReport& report) {
  return std::ranges::any_of(report.outputs, [](const WrittenOutput& output) {
    return output.kind == OutputKind::Surface && output.fineness.by_density;
  });
}

// What held for which meshes.
std::string set_lines(const std::vector<PartSetting>& settings, std::span<const JobReport> meshes) {
  std::string text;
  for (const PartSetting& one : settings) {
    const auto count = std::ranges::count_if(meshes, [&](const JobReport& mesh) {
      return std::ranges::find(mesh.part_settings, one) != mesh.part_settings.end();
    });
    text += formatted("{}{}: {} {} for {}\n", text.empty() ? "  set         " : "              ",
                      one.who(), one.option, one.value, counted(count, "mesh"));
  }
  return text;
}

std::string density_line(const JobReport& report) {
  if (!has_level_by_density(report) || report.fit.density.level() == 2) return "";
  if (report.fit.density.is_refined)
    return "  level       1, by added vertices as fine as 2 without (--levels 2 is finer)\n";
  return formatted(
      "  level       {}: the mesh is dense, faces of {} of its area turn by less than {} degrees "
      "(--levels 2 is finer)\n",
      report.fit.density.level(), percent(report.fit.density.even_share),
      short_number(kEvenDegrees));
}

// Of an asset.
std::string dense_meshes_line(const JobReport& report) {
  const auto dense = std::ranges::count_if(
      report.meshes, [](const JobReport& mesh) { return mesh.fit.density.is_dense(); });
  if (!has_level_by_density(report) || dense == 0) return "";
  return formatted("  level       1 of {}, which {} (--levels 2 is finer)\n",
                   counted(dense, "mesh"), dense == 1 ? "is dense" : "are dense");
}

}  // namespace

std::string within_text(const WithinFit& within) {
  std::string text = short_number(within.within) + " of the diagonal";
  if (within.noise) text += " (the noise is " + short_number(*within.noise) + ")";
  if (within.exact && !(within.distance.max > 0))
    return text +
           " changes nothing: of the surfaces that were tried the one through the vertices "
           "bends least, or the others fold more";
  return formatted("{}: vertices are left by {} rms, {} by all of it; bending {} to {}", text,
                   short_number(within.distance.rms), with_separators(within.at_bound),
                   short_number(within.exact ? within.exact->bending : within.bending_before),
                   short_number(within.left ? within.left->bending : within.bending_after));
}

namespace {

// "9 fair, 6 progressive; 4 with edges kept sharp; 12 with triangles joined to quads".
std::string choices_text(const std::vector<JobReport>& meshes) {
  const auto count_of = [&](const auto& is_of) { return std::ranges::count_if(meshes, is_of); };
  const auto fair =
      count_of([](const JobReport& mesh) { return mesh.fit.method == InterpolationMethod::Fair; });
  const auto creased = count_of([](const JobReport& mesh) {
    return mesh.fit.found_edges > 0 || mesh.settings.creases.split_normals;
  });
  const auto joined = count_of([](const JobReport& mesh) { return mesh.fit.joined > 0; });
  const std::int64_t progressive = std::ssize(meshes) - fair;
  std::string text;
  if (fair > 0) text += with_separators(fair) + " fair";
  if (progressive > 0)
    text += (text.empty() ? "" : ", ") + with_separators(progressive) + " progressive";
  if (creased > 0) text += formatted("; {} with edges kept sharp", with_separators(creased));
  if (joined > 0) text += formatted("; {} with triangles joined to quads", with_separators(joined));
  return text;
}

// How many meshes have which, and the worst figures of all.
std::string asset_summary(const JobReport& report, bool is_full) {
  const JobReport *folded = nullptr, *off = nullptr;
  for (const JobReport& mesh : report.meshes) {
    if (!mesh.surface) continue;
    const SurfaceQuality& quality = mesh.surface->quality;
    if (quality.folded_area >= kSoundFoldedArea &&
        (folded == nullptr || quality.folded_area > folded->surface->quality.folded_area))
      folded = &mesh;
    if (off == nullptr || quality.rms_normal_deviation > off->surface->quality.rms_normal_deviation)
      off = &mesh;
  }
  const std::int64_t count = std::ssize(report.meshes);
  std::string text =
      formatted("{}: {}, {}, {}, {}\n  surfaces    ", input_name(report.input.path),
                counted(count, "mesh"), counted(report.input.file_vertices, "vertex"),
                counted(report.input.file_faces, "face"), duration(report.timing.total));
  text += choices_text(report.meshes);
  if (folded != nullptr)
    text += formatted("; {} of {}", folds_text(folded->surface->quality), folded->mesh_name);
  if (off != nullptr)
    text += formatted("; normals off by up to {} degrees rms ({})",
                      angle_text(off->surface->quality.rms_normal_deviation), off->mesh_name);
  text += "\n";
  for (const JobReport& mesh : report.meshes)
    if (is_full)
      text +=
          formatted("  {}: {}\n{}", mesh.mesh_name,
                    counts_text(mesh.input.file_vertices, mesh.input.file_faces,
                                mesh.input.statistics.vertex_count,
                                mesh.input.statistics.face_count, mesh.fit.joined, mesh.fit.added),
                    surface_line(mesh));
  return text + set_lines(report.settings.parts, report.meshes) + dense_meshes_line(report) +
         output_lines(report);
}

}  // namespace

std::string summary(const JobReport& report, bool is_full) {
  if (!report.meshes.empty()) {
    std::string all = asset_summary(report, is_full);
    all.pop_back();
    return all;
  }
  const MeshStatistics& statistics = report.input.statistics;
  std::string text = formatted(
      "{}: {} ({}){}\n", input_name(report.input.path),
      counts_text(report.input.file_vertices, report.input.file_faces, statistics.vertex_count,
                  statistics.face_count, report.fit.joined, report.fit.added),
      shape_of(statistics), is_full ? "" : ", " + duration(report.timing.total));
  text += mending_lines(report);
  text += input_folds_line(report.input);
  if (report.points) text += points_text(*report.points);
  if (report.point_distances)
    text += "  points      farthest " + short_number(report.point_distances->max) + ", rms " +
            short_number(report.point_distances->rms) + " of the diagonal from the surface\n";
  text += moved_line(report);
  text += is_full ? computing_lines(report) : within_line(report) + surface_line(report);
  text +=
      set_lines(report.settings.parts, {&report, 1}) + density_line(report) + output_lines(report);
  text.pop_back();
  return text;
}

namespace {

std::string line(const char* label, const std::string& value) {
  std::string text = std::string("  ") + label;
  text.resize(14, ' ');
  return text + value + "\n";
}

std::string errors_text(const std::vector<ErrorNorms>& history) {
  constexpr std::size_t kShown = 24;
  std::string text;
  for (std::size_t i = 0; i < history.size() && i < kShown; ++i)
    text += (i == 0 ? "" : ", ") + short_number(history[i].max);
  return history.size() > kShown ? text + ", ... (the report has all)" : text;
}

}  // namespace

std::string details(const JobReport& report) {
  if (!report.meshes.empty()) {
    std::string all;
    for (const JobReport& mesh : report.meshes)
      all += (all.empty() ? "" : "\n") + mesh.mesh_name + " of " + details(mesh);
    return all;
  }
  std::string text = report.job + ", in detail:\n";
  text += line("threads", std::to_string(oneapi::tbb::this_task_arena::max_concurrency()));
  if (report.fit.fair) {
    text += line("drawn in", formatted("{}, {} turned back, {} cured of folds",
                                       counted(report.fit.fair->shrunk_vertices, "vertex"),
                                       counted(report.fit.fair->reversed_vertices, "vertex"),
                                       with_separators(report.fit.fair->cured_vertices)));
    if (report.fit.fair->least_polygon)
      text += line("least polygon",
                   short_number(*report.fit.fair->least_polygon) + " of its vertex' shortest edge");
    text += line("flagged", counted(report.fit.fair->flagged_edges, "edge") + ", " +
                                counted(report.fit.fair->flagged_faces, "face"));
  } else {
    text += line("bound", short_number(report.fit.spectral_bound) + " (least eigenvalue of B)");
  }
  text += line("errors", errors_text(report.fit.interpolation.history));
  if (report.host_peak_bytes > 0)  // of a mesh of several only the job has it
    text += line("memory", byte_size(report.host_peak_bytes) + " at most" +
                               (report.device_bytes > 0
                                    ? ", " + byte_size(report.device_bytes) + " on the device"
                                    : ""));
  text.pop_back();
  return text;
}

std::string next_step(const JobReport& report) {
  const bool has_page = !report.page.path.empty() && report.page.path != "-";
  if (has_page) return "next: open " + visible(report.page.path) + " in a browser";
  for (const WrittenOutput& output : report.outputs) {
    if (output.path == "-") continue;
    const std::string path = visible(output.path);
    if (output.kind == OutputKind::Cage) {
      const auto format = format_of(path_of(output.path));
      // Of those that are read with what they say of how they were made.
      if (!format || info_of(*format).is_gltf || !serves(*format, FormatUse::ReadMesh)) continue;
      return formatted("next: planish verify {} {}", path, visible(report.input.path));
    }
    return "next: open " + path + ", or see it in a browser: planish fit ... --page out.html";
  }
  return "next: see it in a browser: planish fit ... --page out.html";
}

}  // namespace planish
