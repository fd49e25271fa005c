#include "planish/job/job_outputs.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/gltf/gltf_cage.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/files/write_surface.h"
#include "planish/job/digest.h"
#include "planish/job/job_input.h"
#include "planish/job/job_text.h"
#include "planish/job/page/page.h"
#include "planish/job/report.h"
#include "planish/job/staged_files.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/queries/limit_surface.h"
#include "planish/surface/surface_blocks.h"

namespace planish {
namespace {

// How far the vertices of a file are from the points that its surface passes through, in units of
// the model: what is left of the fit's error, and what rounding for the file adds.

// Gives rows of a surface as somebody has them.
using RowPositions = std::function<void(RowRange, std::span<glm::dvec3>)>;

// The same as write_gltf() has them, but for compression.
double written_distance(const SurfaceBlocks& surface, std::span<const glm::dvec3> given,
                        const GltfOptions& options);

// The largest distance of points of the same place in two lists; infinite as above.
double largest_distance(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b);

// Rounds positions as a format does that keeps single precision.
void round_for(FileFormat format, std::span<glm::dvec3> positions);

// Of points that come as pairs, apart(i) of [0, count); infinite where one is not a number.
template <class Apart>
double largest_of(std::size_t count, const Apart& apart) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    largest = std::max(largest, safe_length(apart(i)));
    if (std::isinf(largest)) break;
  }
  return largest;
}

// The same on all threads: of_piece(range) of the ranges of [0, count).
template <class OfPiece>
double largest_of_pieces(std::int64_t count, const OfPiece& of_piece) {
  constexpr std::int64_t kPiece = 1 << 14;
  const std::vector<RowRange> pieces = ranges_of(count, kPiece);
  std::vector<double> largest(pieces.size(), 0);
  parallel_each(pieces.size(), 1, [&](std::size_t i) { largest[i] = of_piece(pieces[i]); });
  return largest.empty() ? 0 : *std::max_element(largest.begin(), largest.end());
}

// The largest distance of the rows of given vertices from these, on all threads; infinite where
// one is not a number. Nobody holds all rows.
double largest_distance(const SurfaceInfo& info, std::span<const glm::dvec3> given,
                        const RowPositions& positions) {
  const auto count = std::min(static_cast<std::int64_t>(info.base_vertices.size()), info.row_count);
  return largest_of_pieces(count, [&](RowRange rows) {
    thread_local std::vector<glm::dvec3> some;
    some.resize(static_cast<std::size_t>(rows.count));
    positions(rows, some);
    const std::int32_t* vertices = info.base_vertices.data() + rows.first;
    return largest_of(some.size(), [&](std::size_t i) { return some[i] - given[vertices[i]]; });
  });
}

// The same as write_surface() has the rows in a file of that format.
double written_distance(const SurfaceBlocks& surface, std::span<const glm::dvec3> given,
                        FileFormat format) {
  return largest_distance(surface.info(), given, [&](RowRange rows, std::span<glm::dvec3> some) {
    RowTarget to;
    to.positions = some;
    (void)surface.rows(rows, to);
    round_for(format, some);
  });
}

double written_distance(const SurfaceBlocks& surface, std::span<const glm::dvec3> given,
                        const GltfOptions& options) {
  return largest_distance(surface.info(), given, [&](RowRange rows, std::span<glm::dvec3> some) {
    written_positions(surface, options, rows, some);
  });
}

double largest_distance(std::span<const glm::dvec3> a, std::span<const glm::dvec3> b) {
  const auto count = static_cast<std::int64_t>(std::min(a.size(), b.size()));
  return largest_of_pieces(count, [&](RowRange rows) {
    const auto first = static_cast<std::size_t>(rows.first);
    return largest_of(static_cast<std::size_t>(rows.count),
                      [&](std::size_t i) { return a[first + i] - b[first + i]; });
  });
}

void round_for(FileFormat format, std::span<glm::dvec3> positions) {
  if (info_of(format).keeps_doubles) return;
  for (glm::dvec3& position : positions) position = glm::dvec3(glm::vec3(position));
}

// Little of what the tolerance leaves to compression is kept for rounding.
constexpr double kCompressionShare = 0.99;

void write_as_gltf(const PlannedOutput& planned, const std::filesystem::path& target,
                   const SurfaceBlocks& surface, const SurfaceOutputOptions& options,
                   WrittenOutput& written, std::vector<std::byte>& stdout_bytes) {
  MeasuredGltf measured;
  measure_gltf(planned, surface, options, measured);
  GltfOptions& gltf = measured.options;
  WrittenDigest digest(options.digests);
  if (planned.to_stdout) {
    stdout_bytes = encode_glb(surface, gltf);
    written.bytes = stdout_bytes.size();
    digest.add(stdout_bytes);
  } else {
    gltf.observe = digest.observer();
    written.bytes = write_gltf(target, surface, gltf).byte_count;
  }
  written.sha256 = digest.finish();
  written.as_written_error = measured.distance / options.diagonal;
}

// How USD is to draw the cage; it knows no Doo-Sabin.
CageSubdivision subdivision_of(const FitOptions& options) {
  CageSubdivision subdivision;
  if (options.scheme == Scheme::CatmullClark) subdivision.scheme = "catmullClark";
  if (options.scheme == Scheme::Loop) subdivision.scheme = "loop";
  subdivision.has_sharp_boundary_corners = options.sharp.boundary == BoundaryRule::EdgeAndCorner;
  return subdivision;
}

// The control points of a fair cage as they are written.
LevelOne state_of(const PolygonMesh& cage, const FairFit& fair) {
  LevelOne written{cage.positions, {}};
  written.state.resize(fair.level_one.state.size());
  return written;
}

}  // namespace

void measure_gltf(const PlannedOutput& planned, const SurfaceBlocks& surface,
                  const SurfaceOutputOptions& options, MeasuredGltf& measured) {
  GltfOptions& gltf = measured.options = options.gltf;
  const SurfaceInfo& info = surface.info();
  measured.distance = written_distance(surface, options.given, gltf);
  if (gltf.compression == GltfCompression::None) return;
  gltf.position_error =
      options.may_be_scaled
          ? std::max(0.0,
                     kCompressionShare * (options.tolerance * options.diagonal - measured.distance))
          : 0.0;
  gltf.decoded_rows = static_cast<std::int64_t>(info.base_vertices.size());
  gltf.decoded = [&](std::span<const glm::dvec3> decoded) {
    measured.distance =
        largest_distance(info, options.given, [&](RowRange rows, std::span<glm::dvec3> some) {
          std::copy_n(decoded.begin() + rows.first, rows.count, some.begin());
        });
  };
  if (!options.may_be_scaled) return;
  gltf.kept_float = [&](double moved) {
    const std::string reason =
        moved > 0 ? "16 would move them by up to " + short_number(moved / options.diagonal) +
                        " of the diagonal, and --tolerance leaves " +
                        short_number(gltf.position_error / options.diagonal) +
                        "; a larger one may allow it"
                  : std::string("other programs lose the place of a model as small as this one");
    gltf.callbacks.warn(
        {"float-positions", visible(planned.path) + ": positions stay 32 bits: " + reason});
  };
}

WrittenOutput counted_output(const PlannedOutput& planned, const SurfaceInfo& info) {
  WrittenOutput written;
  written.path = utf8(planned.path);
  written.kind = planned.kind;
  written.fineness = planned.fineness;
  written.vertices = info.row_count;
  written.faces = info.face_count;
  written.quads = info.face_offsets.empty() ? info.face_count : 0;
  written.triangles = info.corner_count - 2 * info.face_count;
  return written;
}

WrittenOutput write_surface_output(const PlannedOutput& planned,
                                   const std::filesystem::path& target, JobLevel& surface,
                                   const SurfaceOutputOptions& options,
                                   std::vector<std::byte>& stdout_bytes) {
  const SurfaceInfo& info = surface.blocks().info();
  WrittenOutput written = counted_output(planned, info);
  if (surface.decimated()) written.decimated = {*surface.decimated()};
  const bool is_gltf = info_of(planned.format).is_gltf;
  if (is_gltf) {
    write_as_gltf(planned, target, surface.blocks(), options, written, stdout_bytes);
    return written;
  }
  WrittenDigest digest(options.digests);
  SurfaceWriteOptions polygons{
      .header = {},
      .fields = options.gltf.fields,
      .is_z_up = options.gltf.z_up,
      .materials = {options.materials, planned.path.parent_path(), options.gltf.materials},
      .observe = digest.observer(),
      .callbacks = options.gltf.callbacks};
  for (const auto& [key, value] : options.gltf.extras) {
    if (key == "curvature_from")
      polygons.header.push_back("planish curvature_from=" + std::get<std::string>(value));
  }
  written.bytes = write_surface(target, planned.format, surface.blocks(), polygons);
  written.sha256 = digest.finish();
  written.as_written_error =
      written_distance(surface.blocks(), options.given, planned.format) / options.diagonal;
  return written;
}

WrittenOutput write_tiles_output(const PlannedOutput& planned, const std::filesystem::path& target,
                                 const DooSabinSurface& surface, const Settings& settings,
                                 const SurfaceOutputOptions& options) {
  WrittenDigest digest(options.digests);
  TilesOptions tiles{.level = planned.fineness.level,
                     .tile_vertices = settings.tile_vertices,
                     .skirts = settings.skirts,
                     .given = options.vertices,
                     .points = options.given,
                     .gltf = options.gltf};
  tiles.gltf.position_error = kCompressionShare * options.tolerance * options.diagonal;
  tiles.gltf.observe = digest.observer();
  const TilesFile file = write_tiles(target, surface, tiles);
  WrittenOutput written;
  written.path = utf8(planned.path);
  written.fineness = planned.fineness;
  written.bytes = file.byte_count;
  written.sha256 = digest.finish();
  written.vertices = file.row_count;
  written.faces = written.quads = file.face_count;
  written.triangles = 2 * file.face_count;
  written.as_written_error = file.largest_distance / options.diagonal;
  for (const TileLevel& level : file.levels) {
    written.tile_levels.push_back({.level = level.level,
                                   .tiles = level.tiles,
                                   .vertices = static_cast<std::int64_t>(level.vertex_count),
                                   .triangles = static_cast<std::int64_t>(level.triangle_count),
                                   .bytes = level.bytes,
                                   .geometric_error = level.geometric_error});
  }
  return written;
}

WrittenOutput write_cage_output(const PlannedOutput& planned, const std::filesystem::path& target,
                                const FittedMesh& whole, const JobReport& report,
                                const SurfaceOutputOptions& options) {
  Settings settings = report.settings;
  settle(settings, whole);
  const PolygonMesh& input = whole.mesh;
  const Fit& fitted = whole.fit;
  WrittenOutput written;
  PolygonMesh cage = control_cage(input, fitted, settings.sharp());
  if (info_of(planned.format).is_gltf) {
    GltfOptions gltf = options.gltf;
    gltf.extras = fit_extras(whole.options, whole.creases(), fitted.interpolation);
    gltf.compression = GltfCompression::None;
    written.bytes = write_gltf_cage(target, cage, subdivision_of(whole.options), gltf).byte_count;
    cage.positions = written_cage_positions(cage, gltf);
  } else {
    round_for(planned.format, cage.positions);
    write_mesh(target, planned.format, cage,
               {.header = cage_header_lines(settings, whole.options.method, report.input.path,
                                            whole.found),
                .subdivision = subdivision_of(whole.options),
                .is_z_up = settings.up == UpAxis::Z,
                .materials = {options.materials, planned.path.parent_path()}});
  }
  written.path = utf8(planned.path);
  written.kind = planned.kind;
  written.vertices = cage.vertex_count();
  for (std::int32_t face = 0; face < cage.face_count(); ++face) {
    const std::int32_t size = cage.face_size(face);
    if (size == 4) ++written.quads;
    if (size == 3) ++written.triangles;
  }
  written.scheme = whole.options.scheme;
  written.creases = std::ssize(cage.creases);
  if (options.digests) {
    const FileDigest digest = digest_of(target);
    if (written.bytes == 0) written.bytes = digest.bytes;
    written.sha256 = digest.sha256;
  } else if (written.bytes == 0) {
    written.bytes = std::filesystem::file_size(target);
  }
  const std::vector<glm::dvec3> limit =
      fitted.fair ? limit_positions(input, state_of(cage, *fitted.fair), settings.sharp())
                  : limit_positions(cage, {settings.scheme, settings.weights, settings.sharp()});
  written.as_written_error = largest_distance(limit, whole.points()) / fitted.placement.diagonal;
  return written;
}

namespace {

// Writes the surface of a fitted mesh as STEP, as fit_file() does, and measures what was written.
// `limit` makes its Doo-Sabin surface.
WrittenOutput write_step_output(const PlannedOutput& planned, const std::filesystem::path& target,
                                const std::function<const LimitSurface&()>& limit,
                                const JobInput& made, const FittedMesh& fitted,
                                const StepSettings& settings, const SurfaceOutputOptions& options) {
  WrittenDigest digest(options.digests);
  const StepFileOptions step{.settings = settings,
                             .name = options.gltf.name,
                             .shown = planned.path,
                             .materials = options.gltf.materials,
                             .scan = made.scan.face_count() > 0 ? &made.scan : nullptr,
                             .observe = digest.observer(),
                             .callbacks = options.gltf.callbacks};
  const StepFigures figures = write_fitted_step(target, fitted, step, limit);
  WrittenOutput written;
  written.path = utf8(planned.path);
  written.bytes = figures.byte_count;
  written.sha256 = digest.finish();
  written.vertices = figures.vertices;
  written.faces = figures.faces;
  written.as_written_error = figures.largest_distance / options.diagonal;
  written.step = figures;
  return written;
}

BakeFileOptions bake_options(const FittedJob& work) {
  BakeFileOptions options;
  options.size = work.job.settings.bake;
  options.name = work.made.input.name;
  options.callbacks = callbacks_for(work.report, work.context);
  options.callbacks.progress = {};
  return options;
}

// Where the maps take their normals from.
JobLevel fine_level(const FittedJob& work, JobSurface& all) {
  check_stop();
  return all.level(bake_level(work.fitted.mesh, work.job.settings.bake));
}

}  // namespace

void settle_bake(Job& job) {
  if (job.settings.bake == 0) return;
  for (OutputRequest& output : job.outputs) {
    if (output.kind == OutputKind::Cage) continue;
    if (output.by_density) {
      output.levels = {0};
      output.by_density = false;
    }
    if (output.adaptive.any() || output.levels != std::vector<int>{0})
      refuse(
          output.where,
          "{}: a baked map is of level 0, the input's own mesh; leave other levels out, or write "
          "them without --bake",
          visible(output.path));
  }
}

void require_bakeable(const std::vector<PlannedOutput>& outputs) {
  bool any = false;
  for (const PlannedOutput& output : outputs) {
    if (output.kind == OutputKind::Cage) continue;
    any = true;
    if (!info_of(output.format).is_gltf || info_of(output.format).is_tiles)
      refuse("--bake", visible(output.path) + " holds no baked map; .glb and .gltf do");
  }
  if (!any) refuse("--bake", "no surface is written that holds a map; name one: -o out.glb");
}

std::unique_ptr<const BakedSurface> baked_surface(const FittedJob& work, JobSurface& all,
                                                  const JobLevel& low, const GltfOptions& gltf) {
  if (work.job.settings.bake == 0) return nullptr;
  return timed(work.report.timing.evaluate, [&] {
    const JobLevel fine = fine_level(work, all);
    BakeFileOptions options = bake_options(work);
    options.double_sided = gltf.double_sided;
    return std::make_unique<const BakedSurface>(work.fitted, low.blocks(), fine.blocks(),
                                                work.made.materials.gltf, options);
  });
}

std::unique_ptr<const BakedAssetMesh> baked_mesh(const FittedJob& work, const GltfAsset& asset,
                                                 const AssetMesh& mesh, JobSurface& all,
                                                 const JobLevel& low,
                                                 const AssetAttributes& attributes) {
  if (work.job.settings.bake == 0) return nullptr;
  return timed(work.report.timing.evaluate, [&] {
    const JobLevel fine = fine_level(work, all);
    return std::make_unique<const BakedAssetMesh>(asset, mesh, work.fitted, low.blocks(),
                                                  attributes, fine.blocks(), bake_options(work));
  });
}

void note_maps(std::span<const BakedMap> maps, const std::string& mesh, int size,
               WrittenOutput& written) {
  written.bake_size = size;
  for (const BakedMap& map : maps)
    if (!map.png.empty())
      written.maps.push_back({.mesh = mesh,
                              .material = map.material,
                              .bytes = map.png.size(),
                              .covered = map.map.covered,
                              .overlapped = map.map.overlapped});
}

namespace {

// What `make` returns, which writes or draws: a step of the job.
template <class Make>
auto written_step(const FittedJob& work, std::string_view step, const Make& make) {
  check_stop();
  work.context.progress.update(step, 0);
  return timed(work.report.timing.write, make);
}

void write_one(const FittedJob& work, const PlannedOutput& planned, JobLevel* surface,
               const SurfaceOutputOptions& options, WrittenOutput& written,
               std::vector<std::byte>& stdout_bytes) {
  const FittedMesh& caged = work.made.cage ? *work.made.cage : work.fitted;
  written_step(work, "write", [&] {
    std::filesystem::path target;
    if (!planned.to_stdout) target = work.staged.stage(planned.path);
    written = surface != nullptr
                  ? write_surface_output(planned, target, *surface, options, stdout_bytes)
                  : write_cage_output(planned, target, caged, work.report, options);
    if (planned.to_stdout) return;
    const std::filesystem::path beside = companion_of(target, planned.format);
    if (!beside.empty() && std::filesystem::exists(beside))
      (void)work.staged.stage(companion_of(planned.path, planned.format));
    if (planned.format == FileFormat::Gltf) stage_further_buffers(planned, target, work.staged);
  });
  if (surface != nullptr || caged.fit.interpolation.converged)
    warn_of_rounding(work.report, work.context, written);
}

// Tiles are made level by level as they are written.
void write_tiles_of(const FittedJob& work, const PlannedOutput& planned, JobSurface& all,
                    const SurfaceOutputOptions& options, WrittenOutput& written) {
  written_step(work, "write", [&] {
    const std::filesystem::path target =
        work.staged.stage_with_folder(planned.path, tile_folder(planned.path));
    written =
        write_tiles_output(planned, target, *all.made_doo_sabin(), work.job.settings, options);
  });
  warn_of_rounding(work.report, work.context, written);
}

// Faces are made as a whole.
void write_step_of(const FittedJob& work, const PlannedOutput& planned, JobSurface& all,
                   const SurfaceOutputOptions& options, WrittenOutput& written) {
  written_step(work, "faces", [&] {
    StepSettings settings = work.job.settings.step;
    settings.unit = settled_unit(settings.unit, work.report.input.format);
    written = write_step_output(
        planned, work.staged.stage(planned.path),
        [&]() -> const LimitSurface& { return all.limit(); }, work.made, work.fitted, settings,
        options);
  });
  const StepFigures& step = *written.step;
  if (!step.is_as_asked()) work.report.falls_short = true;
  // Surfaces that have a name leave their vertices whatever the digits, and what ends at them, too.
  if (step.analytic_parts + step.mixed_parts == 0)
    warn_of_rounding(work.report, work.context, written);
}

// The deepest level that the page may show; -1: none.
int page_level_of(const FittedJob& work) {
  if (!work.context.wants_page()) return -1;
  return work.context.page->level(work.fitted.mesh, work.job.settings.scheme);
}

// Whether the page can show a finer level.
bool show_on_page(const FittedJob& work, std::size_t mesh, const JobSurface& all,
                  JobLevel& surface) {
  return written_step(work, "page", [&] {
    return work.context.page->show(mesh, surface, work.fitted, work.job.settings, all.doo_sabin());
  });
}

// Of large meshes a finer level takes long and may not fit: these are shown level by level.
bool is_shown_by_level(const FittedJob& work) {
  constexpr std::int32_t kLarge = 1 << 15;
  return work.fitted.mesh.vertex_count() >= kLarge;
}

}  // namespace

void show_mesh(const FittedJob& work, std::size_t mesh, JobSurface& all) {
  const int deepest = page_level_of(work);
  bool may_fit = true;
  for (int level = is_shown_by_level(work) ? 0 : deepest; 0 <= level && level <= deepest && may_fit;
       ++level) {
    JobLevel made = timed(work.report.timing.evaluate, [&] { return all.level(level); });
    may_fit = show_on_page(work, mesh, all, made);
  }
}

void measure_rest(const FittedJob& work, JobSurface& all, const SurfaceOutputOptions& common) {
  if (!work.job.measures) return;
  // What cannot be seen on the cage or at level 0.
  const bool asks_for_result =
      !work.outputs.empty() || !work.job.report.empty() || work.context.wants_page();
  const bool lacks_distances = !work.made.points.empty() && !work.report.point_distances;
  if (asks_for_result && lacks_distances) {
    if (work.job.settings.scheme == Scheme::DooSabin) {
      timed(work.report.timing.evaluate, [&] { measure_points(work, all); });
    } else {
      (void)measured_level(work, all, kPointDistanceLevel, common);
    }
  }
  if (asks_for_result && !work.report.surface && !note_chosen_surface(work))
    (void)measured_level(work, all, 1, common);
  if (work.report.surface && work.made.source && work.job.settings.scheme == Scheme::DooSabin) {
    timed(work.report.timing.evaluate, [&] { measure_source(work, all); });
  }
  const bool shows_bending = !work.job.report.empty() || work.context.wants_page();
  if (work.report.surface && shows_bending) {
    timed(work.report.timing.evaluate, [&] { note_bending(work, all); });
    timed(work.report.timing.evaluate, [&] { note_texture_slide(work, all); });
  }
  if (work.report.surface && !work.fitted.separated_edges.empty())
    note_sheet_gap(work.fitted, all.made_doo_sabin(), work.report);
}

std::vector<std::byte> write_outputs(const FittedJob& work) {
  std::vector<std::byte> stdout_bytes;
  const SurfaceOutputOptions common = surface_options(work);
  std::vector<WrittenOutput>& written = work.report.outputs;
  written.resize(work.outputs.size());
  for (std::size_t i = 0; i < work.outputs.size(); ++i)
    if (work.outputs[i].kind == OutputKind::Cage)
      write_one(work, work.outputs[i], nullptr, common, written[i], stdout_bytes);
  JobSurface all(work.fitted, work.backend, callbacks_for(work.report, work.context));
  int page_level = page_level_of(work);
  if (page_level > 0 && is_shown_by_level(work)) {
    show_mesh(work, 0, all);
    page_level = -1;
  }
  for (const Fineness& fineness : finenesses_of(work.outputs)) {
    SurfaceOutputOptions options = common;
    LevelFields fields;
    JobLevel surface = surface_of(work, all, fineness, fields, options);
    const auto baked = baked_surface(work, all, surface, options.gltf);
    if (baked) baked->add_to(options.gltf);
    for (std::size_t i = 0; i < work.outputs.size(); ++i) {
      const PlannedOutput& planned = work.outputs[i];
      if (planned.kind == OutputKind::Surface && planned.fineness == fineness &&
          info_of(planned.format).has_fineness()) {
        write_one(work, planned, &surface, options, written[i], stdout_bytes);
        if (baked) note_maps(baked->maps(), {}, work.job.settings.bake, written[i]);
      }
    }
    if (!fineness.is_adaptive() && fineness.level == page_level) {
      (void)show_on_page(work, 0, all, surface);
      page_level = -1;
    }
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (info_of(work.outputs[i].format).is_tiles)
      write_tiles_of(work, work.outputs[i], all, common, written[i]);
  }
  for (std::size_t i = 0; i < work.outputs.size(); ++i) {
    if (info_of(work.outputs[i].format).is_brep)
      write_step_of(work, work.outputs[i], all, common, written[i]);
  }
  // What is seen on the page is what is measured.
  if (page_level >= 0) {
    JobLevel surface = measured_level(work, all, page_level, common);
    (void)show_on_page(work, 0, all, surface);
  }
  measure_rest(work, all, common);
  return stdout_bytes;
}

}  // namespace planish
