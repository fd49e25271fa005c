#include <algorithm>

#include "planish/core/counted.h"
#include "planish/core/formatted.h"
#include "planish/core/number_text.h"
#include "planish/core/visible_text.h"
#include "planish/job/point_input.h"
#include "planish/job/report.h"
#include "planish/job/text.h"
#include "planish/pipeline/option_table.h"
#include "planish/pipeline/option_words.h"

namespace planish {
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

std::string output_line(const WrittenOutput& output, std::size_t path_width) {
  std::string line = output_name(output.path);
  line.resize(std::max(line.size(), path_width), ' ');
  line += "  " + byte_size(output.bytes) + ", ";
  if (output.kind == OutputKind::Cage) return line + "control cage";
  if (output.step) {
    const StepFigures& step = *output.step;
    line += counted(step.faces, "B-spline face");
    if (step.solids > 0) line += ", " + counted(step.solids, "solid");
    if (step.open_shells > 0) line += ", " + counted(step.open_shells, "open shell");
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
  return line + ", " +
         (output.quads > 0 ? counted(output.quads, "quad") : counted(output.triangles, "triangle"));
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

}  // namespace

namespace {

bool has_level_by_density(const JobReport& report) {
  return std::ranges::any_of(report.outputs, [](const WrittenOutput& output) {
    return output.kind == OutputKind::Surface && output.fineness.by_density;
  });
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
  return text + dense_meshes_line(report) + output_lines(report);
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
  text += density_line(report) + output_lines(report);
  text.pop_back();
  return text;
}

}  // namespace planish
