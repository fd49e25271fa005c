#include "planish/job/surface_output.h"
#include "planish/core/number_text.h"

#include <algorithm>
#include <cmath>

#include "planish/core/visible_text.h"
#include "planish/files/mesh_file.h"
#include "planish/files/tiles/write_tiles.h"
#include "planish/files/write_surface.h"
#include "planish/job/cage_header.h"
#include "planish/job/digest.h"
#include "planish/job/text.h"
#include "planish/pipeline/written_distance.h"

namespace planish {
namespace {

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
CageSubdivision subdivision_of(const Settings& settings) {
  CageSubdivision subdivision;
  if (settings.scheme == Scheme::CatmullClark) subdivision.scheme = "catmullClark";
  if (settings.scheme == Scheme::Loop) subdivision.scheme = "loop";
  subdivision.has_sharp_boundary_corners = settings.boundary == BoundaryRule::EdgeAndCorner;
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
  written.path = planned.path.string();
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
  written.path = planned.path.string();
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
                                const FittedMesh& whole, const MaterialLibrary& materials,
                                const JobReport& report, bool digests) {
  Settings settings = report.settings;
  settle(settings, whole);
  const PolygonMesh& input = whole.mesh;
  const Fit& fitted = whole.fit;
  PolygonMesh cage = control_cage(input, fitted, settings.sharp());
  round_for(planned.format, cage.positions);
  write_mesh(
      target, planned.format, cage,
      {.header = cage_header_lines(settings, whole.options.method, report.input.path, whole.found),
       .subdivision = subdivision_of(settings),
       .is_z_up = settings.up == UpAxis::Z,
       .materials = {&materials, planned.path.parent_path()}});
  WrittenOutput written;
  written.path = planned.path.string();
  written.kind = planned.kind;
  written.vertices = cage.vertex_count();
  for (std::int32_t face = 0; face < cage.face_count(); ++face) {
    const std::int32_t size = cage.face_size(face);
    if (size == 4) ++written.quads;
    if (size == 3) ++written.triangles;
  }
  if (digests) {
    const FileDigest digest = digest_of(target);
    written.bytes = digest.bytes;
    written.sha256 = digest.sha256;
  } else {
    written.bytes = std::filesystem::file_size(target);
  }
  const std::vector<glm::dvec3> limit =
      fitted.fair ? limit_positions(input, state_of(cage, *fitted.fair), settings.sharp())
                  : limit_positions(cage, {settings.scheme, settings.weights, settings.sharp()});
  written.as_written_error = largest_distance(limit, whole.points()) / fitted.placement.diagonal;
  return written;
}

}  // namespace planish
