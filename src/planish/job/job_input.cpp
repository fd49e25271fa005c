#include "planish/job/job_input.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/words.h"
#include "planish/edit/editor.h"
#include "planish/files/formats.h"
#include "planish/files/read_file.h"
#include "planish/job/input.h"
#include "planish/job/job_settings.h"
#include "planish/job/job_text.h"
#include "planish/job/report.h"
#include "planish/mesh/check.h"
#include "planish/pipeline/cage_in_scheme.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_report.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"
#include "planish/reconstruct/point_options.h"

namespace planish {

void add_warning(JobReport& report, const JobContext& context, const Warning& warning) {
  const auto same = [&](const Warning& other) {
    return other.code == warning.code && other.message == warning.message;
  };
  // Every level of a surface meets the same places.
  if (std::ranges::any_of(report.warnings, same)) return;
  report.warnings.push_back(warning);
  // A promise that is not kept, as a tolerance that is not reached.
  if (warning.code == kAngleNotKept) report.falls_short = true;
  if (report.is_told_with_others || !context.watch.warning) return;
  Warning told = warning;
  told.message = named_message(report.label, warning.message);
  context.watch.warning(told);
}

Callbacks callbacks_for(JobReport& report, const JobContext& context) {
  Callbacks callbacks;
  callbacks.progress = [&context](std::string_view step, double fraction) {
    context.progress.update(step, fraction);
  };
  callbacks.warning = [&report, &context](const Warning& warning) {
    add_warning(report, context, warning);
  };
  callbacks.cancelled = context.watch.cancelled;
  return callbacks;
}

namespace {

void reconstruct_points(const PointInput& cloud, const Mesher& mesher, bool keeps_scan,
                        JobInput& made, JobReport& report, const Callbacks& callbacks) {
  ReconstructOptions options = report.settings.points;
  options.keeps_scan = keeps_scan;
  options.callbacks = callbacks;
  options.pair_quads = report.settings.quads != QuadChoice::Off &&
                       report.settings.scheme != Scheme::Loop;  // which is of triangles only
  Reconstruction result = reconstruct_input(cloud, mesher, options);
  report.points = facts_of(cloud, result);
  for (const std::int32_t point : result.used_points)
    made.points.push_back(cloud.cloud.origin + cloud.cloud.points[point]);
  made.input.file.mesh = std::move(result.mesh);
  made.scan = std::move(result.scan);
}

Input read_source(const std::string& path, FileReach reach, const Callbacks& callbacks) {
  Input source = read_input(path, reach, callbacks);
  if (source.file.mesh.face_count() == 0) {
    throw Error(ErrorCode::UnusableMesh,
                source.name + ": a source has to be a mesh, and this has no faces");
  }
  return source;
}

// Auto: points are meshed unevenly, which folds progressive surfaces. Of a mesh it starts with the
// progressive one. Other schemes than Doo-Sabin have no fair method.
InterpolationMethod method_for(const Settings& settings, const JobInput& made) {
  const bool fair = settings.interpolation == InterpolationChoice::Fair ||
                    (settings.interpolation == InterpolationChoice::Auto && !made.points.empty() &&
                     settings.scheme == Scheme::DooSabin);
  return fair ? InterpolationMethod::Fair : InterpolationMethod::Progressive;
}

// With the tags that a scene adds.
PolygonMesh tagged(PolygonMesh mesh, const Settings& settings, const std::string& name) {
  const auto require_vertex = [&](std::int32_t vertex, const char* key) {
    if (vertex < mesh.vertex_count()) return;
    require_usable(mesh, name);
    throw Error(ErrorCode::UnusableMesh, formatted("{} of the scene names vertex {} of {}", key,
                                                   vertex, mesh.vertex_count()));
  };
  for (const CreaseEdge& crease : settings.crease_edges)
    require_vertex(std::max(crease.v0, crease.v1), "crease_edges");
  for (const CornerVertex& corner : settings.corner_vertices)
    require_vertex(corner.vertex, "corner_vertices");
  mesh.creases.insert(mesh.creases.end(), settings.crease_edges.begin(),
                      settings.crease_edges.end());
  mesh.corners.insert(mesh.corners.end(), settings.corner_vertices.begin(),
                      settings.corner_vertices.end());
  return mesh;
}

// Whether faces on surfaces that have a name are looked for.
bool writes_analytic(const Job& job) {
  return job.settings.step.analytic == AnalyticChoice::Auto &&
         job.settings.scheme == Scheme::DooSabin &&
         std::ranges::any_of(job.outputs, [](const OutputRequest& output) {
           const auto format = format_of(path_of(output.path));
           return format && info_of(*format).is_brep;
         });
}

bool writes_obj(const Job& job) {
  return std::ranges::any_of(job.outputs, [](const OutputRequest& output) {
    return format_of(path_of(output.path)) == FileFormat::Obj;
  });
}

bool writes_gltf(const Job& job) {
  return std::ranges::any_of(job.outputs, [](const OutputRequest& output) {
    if (output.path == "-") return true;
    const auto format = format_of(path_of(output.path));
    return output.kind == OutputKind::Surface && format &&
           (info_of(*format).is_gltf || info_of(*format).is_tiles || info_of(*format).is_brep ||
            format == FileFormat::Usda);
  });
}

}  // namespace

void require_points(const Job& job, const std::string& name, std::int64_t count) {
  if (job.limits.points <= 0 || count <= job.limits.points) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("{}: has {}, and {} are allowed; simplify it or allow more", name,
                        counted(count, "point"), with_separators(job.limits.points)));
}

InputFile load_job_input(const Job& job, JobReport& report, const JobContext& context) {
  InputFile file = load_input(job.input, job.input_format, callbacks_for(report, context));
  if (job.digests) file.take_digest();
  file.split_normals_crease = report.settings.creases.split_normals;
  file.is_strict = report.settings.repair == RepairChoice::None;
  file.reach = report.settings.textures;
  return file;
}

JobInput read_job_input(const Job& job, const InputFile& file, JobReport& report,
                        const JobContext& context) {
  JobInput made;
  Input& input = made.input;
  const Callbacks callbacks = callbacks_for(report, context);
  input.name = file.name;
  report.input.format = name_of(file.format);
  const auto mesher = [&] { return job.mesher ? job.mesher() : require_mesher(); };
  const auto reconstruct = [&](const PointInput& cloud) {
    require_points(job, input.name, std::ssize(cloud.cloud.points));
    context.progress.update("points", 0);
    reconstruct_points(cloud, mesher(), writes_analytic(job), made, report, callbacks);
  };
  if (holds_points_only(file.format)) {
    reconstruct(points_of(file, callbacks));
  } else {
    input = mesh_of(file, callbacks);
    report.input.format = name_of(input.file.format);
    made.materials =
        read_materials(file.for_reader(), file.format, writes_obj(job), writes_gltf(job));
    for (const Warning& warning : made.materials.warnings()) add_warning(report, context, warning);
    if (const auto cloud = points_of(input)) reconstruct(*cloud);
  }
  if (file.split_normals_crease && input.file.mesh.creases.empty())
    add_warning(report, context,
                {"no-split-normals",
                 file.name + ": --creases normals found no edge where normals are split"});
  if (!job.source.empty()) made.source = read_source(job.source, file.reach, callbacks);
  for (const Warning& warning : input.file.warnings) add_warning(report, context, warning);
  require_points(job, input.name, input.file.mesh.vertex_count());
  report.input.sha256 = file.sha256();
  report.input.dropped = input.file.dropped_element_count;
  report.input.welded = input.file.welded_vertex_count;
  report.input.file_vertices = input.file.mesh.vertex_count();
  report.input.file_faces = input.file.mesh.face_count();
  return made;
}

bool may_be_points(const Job& job) {
  if (is_point_path(job.input, job.input_format)) return true;
  if (job.input == "-" || job.input_format.value_or(FileFormat::Ply) != FileFormat::Ply)
    return false;
  // What a pipe gives comes once.
  constexpr std::uint64_t kHead = std::uint64_t{1} << 16;
  const NamedFile head =
      read_named_start(path_of(job.input), path_of(job.input), FileReach::Anywhere, kHead);
  std::string_view text(reinterpret_cast<const char*>(head.bytes.data()), head.bytes.size());
  text = text.substr(0, text.find("\nend_header"));
  return text.starts_with("ply") && text.find("\nelement face") == std::string_view::npos;
}

bool chooses_by_measurement(const Settings& settings) {
  return settings.interpolation == InterpolationChoice::Auto && settings.scheme == Scheme::DooSabin;
}

std::optional<ReadyFit> take_cage(ReadyFit& ready, const Settings& settings,
                                  const std::vector<PlannedOutput>& outputs, bool has_page) {
  if (!is_open(ready) || settings.cage_scheme || !has_cage(outputs)) return {};
  ReadyFit cage = cage_fit(ready);
  const auto is_cage = [](const PlannedOutput& output) { return output.kind == OutputKind::Cage; };
  if (has_page || !std::ranges::all_of(outputs, is_cage)) return cage;
  ready = std::move(cage);
  return {};
}

ReadyFit prepare_mesh(Input&& input, MeshFitOptions options, const Settings& settings) {
  options.stands_alone = input.file.stands_alone;
  return prepare_fit(tagged(std::move(input.file.mesh), settings, input.name), input.name, options);
}

ReadyFit prepare_input(JobInput& made, JobReport& report, const JobContext& context) {
  const bool is_mesh = made.points.empty();
  if (!is_mesh) report.settings.weld.reset();  // the mesh is our own
  const bool chooses = is_mesh && chooses_by_measurement(report.settings);
  MeshFitOptions options = mesh_fit_options(report.settings);
  options.fit.callbacks = callbacks_for(report, context);
  if (!chooses) options.method = method_for(report.settings, made);
  options.faces_are_given = is_mesh;
  if (!is_mesh) options.quads = QuadChoice::Off;  // which it has already
  ReadyFit ready = prepare_mesh(std::move(made.input), options, report.settings);
  report.fit.method = ready.input.options.method;
  return ready;
}

void warn_of_unused_settings(const Job& job, const JobInput& made, JobReport& report,
                             const JobContext& context) {
  const bool is_fair = report.fit.method == InterpolationMethod::Fair;
  const auto has_surface = [&](bool (*is_wanted)(const FormatInfo&)) {
    return std::ranges::any_of(job.outputs, [&](const OutputRequest& output) {
      const auto format = output.path == "-" ? FileFormat::Glb : format_of(path_of(output.path));
      return output.kind == OutputKind::Surface && format && is_wanted(info_of(*format));
    });
  };
  const bool has_tiles = has_surface([](const FormatInfo& info) { return info.is_tiles; });
  const bool has_step = has_surface([](const FormatInfo& info) { return info.is_brep; });
  const bool has_levels = has_surface([](const FormatInfo& info) { return !info.is_brep; });
  std::string unused;
  std::int64_t count = 0;
  bool lacks_tiles = false, lacks_step = false, lacks_levels = false;
  const auto is_met = [&](OptionNeeds needs) {
    switch (needs) {
      case OptionNeeds::Nothing:
        return true;
      case OptionNeeds::Points:
        return !made.points.empty();
      case OptionNeeds::Faces:
        return made.points.empty();
      case OptionNeeds::Progressive:
        return !is_fair || made.cage;
      case OptionNeeds::Fair:
        return is_fair;
      case OptionNeeds::Tiles:
        return has_tiles;
      case OptionNeeds::Step:
        return has_step;
      case OptionNeeds::Fineness:
        return has_levels || !has_step;
    }
    return true;
  };
  const auto note = [&](const OptionInfo& option) {
    const bool is_given =
        std::ranges::find(job.given_settings, option.name) != job.given_settings.end();
    if (!is_given || is_met(option.needs)) return;
    unused += (unused.empty() ? "" : ", ") + flag_of(option);
    lacks_tiles |= option.needs == OptionNeeds::Tiles;
    lacks_step |= option.needs == OptionNeeds::Step;
    lacks_levels |= option.needs == OptionNeeds::Fineness;
    ++count;
  };
  for (const FitOption& option : option_table()) note(option);
  for (const PointOption& option : point_option_table()) note(option);
  if (count == 0) return;
  add_warning(
      report, context,
      {"unused-settings",
       formatted("{}: without effect here: {} (the input is {}, the method {}{}{}{})",
                 made.input.name, unused, made.points.empty() ? "a mesh" : "of points",
                 name_of(report.fit.method), lacks_tiles ? ", no output 3D Tiles" : "",
                 lacks_step ? ", no output STEP" : "", lacks_levels ? ", STEP has no levels" : ""),
       count, -1});
}

namespace {

// Vertices of the mesh as it was fitted by those of the input: several where sheets were separated.
class VerticesOfInput {
 public:
  explicit VerticesOfInput(const FittedMesh& fitted)
      : sources_(fitted.source_vertices), order_(sources_.size()) {
    count_ = fitted.mesh.vertex_count();
    std::iota(order_.begin(), order_.end(), 0);
    std::ranges::stable_sort(order_, {}, [&](std::int32_t v) { return source(v); });
  }

  // Calls take(vertex) for all of a vertex of the input.
  template <class Take>
  void for_each(std::int32_t given, const std::string& where, const Take& take) const {
    if (sources_.empty()) {
      if (given >= count_)
        refuse(where, "there is no vertex {}; the mesh has 0 to {}", given, count_ - 1);
      return take(given);
    }
    const auto found =
        std::ranges::equal_range(order_, given, {}, [&](std::int32_t v) { return source(v); });
    if (found.empty())
      refuse(where,
             "there is no vertex {} once the mesh is mended: it is not in the "
             "input, or became another",
             given);
    for (const std::int32_t vertex : found) take(vertex);
  }

 private:
  [[nodiscard]] std::int32_t source(std::int32_t v) const { return sources_[v]; }

  std::span<const std::int32_t> sources_;
  std::vector<std::int32_t> order_;
  std::int32_t count_ = 0;
};

void apply_move(Editor& editor, const VerticesOfInput& input, const SceneMove& move) {
  if (move.undo > 0) {
    for (std::int64_t i = 0; i < move.undo; ++i) {
      if (!editor.can_undo()) refuse(move.where, "there are no {} moves to take back", move.undo);
      editor.undo();
    }
    return;
  }
  std::vector<std::int32_t> vertices;
  std::vector<glm::dvec3> to;
  for (std::size_t i = 0; i < move.vertices.size(); ++i) {
    input.for_each(move.vertices[i], move.where, [&](std::int32_t vertex) {
      vertices.push_back(vertex);
      if (!move.to.empty()) to.push_back(move.to[i]);
    });
  }
  try {
    if (!move.to.empty()) {
      editor.move(vertices, to);
    } else if (move.radius > 0) {
      editor.transform(editor.select(vertices, move.radius), move.map);
    } else {
      Selection all{vertices, std::vector<double>(vertices.size(), 1.0)};
      editor.transform(all, move.map);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    refuse(move.where, error.what());
  }
}

// The editor of all moves; why there is none stands where they do.
Editor editor_of(const FittedMesh& fitted, const SceneMove& first, int undo_steps) {
  try {
    return Editor(fitted, EditorOptions{0, fitted.options, undo_steps});
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InvalidArgument) throw;
    refuse(first.where, error.what());
  }
}

// Moves vertices of what was fitted, one move after another, each solving what it reaches. Throws
// Error{InvalidArgument} with the move's place: for vertices that the input has not, or that
// became others when the mesh was mended; where the fit cannot be edited.
MovedFigures apply_moves(FittedMesh& fitted, std::span<const SceneMove> moves) {
  const VerticesOfInput input(fitted);
  Editor editor = editor_of(fitted, moves.front(), static_cast<int>(moves.size()));
  for (const SceneMove& move : moves) apply_move(editor, input, move);
  MovedFigures figures;
  figures.moves = std::ssize(moves);
  const auto points = editor.points();
  for (std::size_t v = 0; v < points.size(); ++v) {
    const double way = glm::length(points[v] - fitted.mesh.positions[v]);
    if (way == 0) continue;
    ++figures.vertices;
    figures.farthest = std::max(figures.farthest, way / fitted.fit.placement.diagonal);
  }
  FittedMesh now = edited(fitted, editor);
  now.fit.timing = fitted.fit.timing;
  fitted = std::move(now);
  return figures;
}

// What does not pass the vertices as it should.
void warn_of_missed(const std::optional<Warning>& missed, JobReport& report,
                    const JobContext& context) {
  if (!missed) return;
  report.falls_short = true;
  add_warning(report, context, *missed);
}

void note_fit(JobReport& report, FittedMesh& fitted) {
  report.fit = fitted.figures();
  settle(report.settings, fitted);
  report.input.welded += fitted.welded_count;
  report.timing.choose = fitted.choose_milliseconds;
  Fit& result = fitted.fit;
  report.timing.check += result.timing.check;
  report.timing.topology += result.timing.topology;
  report.timing.stencils += result.timing.stencils;
  report.timing.upload += result.timing.upload;
  report.timing.solve += result.timing.solve;
  result.interpolation.displacement = {};  // nobody needs it any more
}

}  // namespace

void fit_input(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
               JobReport& report, const JobContext& context) {
  context.progress.update("fit", 0);
  const std::string name = ready.name;
  made.fitted = fit_prepared(std::move(ready), backend);
  made.fitted.split_normals = report.settings.creases.split_normals;
  if (!moves.empty()) {
    if (report.points)
      refuse(moves.front().where, "moves are of vertices of a mesh; the input holds points");
    report.moved =
        timed(made.fitted.fit.timing.solve, [&] { return apply_moves(made.fitted, moves); });
  }
  const PreparedMesh& prepared = *made.fitted.fit.prepared;
  timed(report.timing.check, [&] {
    report.input.statistics = statistics(prepared);
    made.folds = folded_edges(made.fitted.mesh, *prepared.topology);
  });
  report.input.folded_edges = made.folds.count;
  report.input.folded_edge_area = made.folds.area;
  // Said of the fit where it is made; here of moves.
  warn_of_missed(convergence_warning(made.fitted, name), report, context);
  note_fit(report, made.fitted);
}

void fit_cage(JobInput& made, ReadyFit&& ready, Backend& backend, std::span<const SceneMove> moves,
              JobReport& report, const JobContext& context) {
  if (has_own_cage(made.fitted)) return;
  const std::string name = ready.name;
  FittedMesh& cage = made.cage.emplace(
      timed(report.timing.choose, [&] { return fit_prepared(std::move(ready), backend); }));
  cage.split_normals = report.settings.creases.split_normals;
  if (!moves.empty()) timed(report.timing.choose, [&] { return apply_moves(cage, moves); });
  warn_of_missed(convergence_warning(cage, name + ": control cage"), report, context);
}

void fit_cage_in_scheme(JobInput& made, Backend& backend, JobReport& report,
                        const JobContext& context) {
  const std::optional<Scheme> scheme = report.settings.cage_scheme;
  if (!scheme || *scheme == made.fitted.options.scheme) return;
  Callbacks callbacks = callbacks_for(report, context);
  callbacks.progress = {};
  made.cage = timed(report.timing.choose,
                    [&] { return cage_in_scheme(made.fitted, *scheme, backend, callbacks); });
  warn_of_missed(cage_warning(*made.cage, input_name(report.input.path)), report, context);
}

}  // namespace planish
