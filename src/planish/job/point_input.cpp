#include "planish/job/point_input.h"
#include "planish/core/counted.h"
#include "planish/core/number_text.h"

#include <algorithm>
#include <glm/common.hpp>
#include <limits>

#include "planish/core/error.h"
#include "planish/core/host_scope.h"
#include "planish/files/read_file.h"
#include "planish/files/read_points.h"
#include "planish/job/input_path.h"
#include "planish/job/report.h"
#include "planish/job/text.h"
#include "planish/reconstruct/mesher_process.h"

namespace planish {

bool is_point_path(const std::string& path, std::optional<FileFormat> format) {
  if (!format) format = format_of(path);
  return format && holds_points_only(*format);
}

void require_readable(const std::string& path, std::optional<FileFormat> format) {
  require_input(path, format);
  if (is_point_path(path, format)) (void)require_mesher();
}

PointInput points_of(const InputFile& file, const Callbacks& callbacks) {
  if (!serves(file.format, FormatUse::ReadPoints))
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: .{} is no format of points ({} are)", file.name,
                          name_of(file.format), names_of(FormatUse::ReadPoints)));
  return {.name = file.name,
          .cloud = read_points(FileBytes{.bytes = file.bytes,
                                         .name = file.name,
                                         .path = file.path,
                                         .is_strict = file.is_strict},
                               file.format, share_of(callbacks, kFileLoaded, 1)),
          .sha256 = file.sha256(),
          .format = file.format};
}

std::optional<PointInput> points_of(const Input& input) {
  const PolygonMesh& mesh = input.file.mesh;
  // Fewer make no surface: such a file of another format is a mesh that lacks its faces.
  const std::size_t least = input.file.format == FileFormat::Ply ? 1 : 4;
  if (!serves(input.file.format, FormatUse::ReadPoints) || mesh.face_count() > 0 ||
      mesh.positions.size() < least)
    return std::nullopt;
  return PointInput{.name = input.name,
                    .cloud = planish::points_of(input.file, input.name),
                    .sha256 = input.sha256};
}

Mesher require_mesher() {
  auto program = find_mesher_program();
  if (!program)
    throw Error(ErrorCode::NoDevice,
                "points need the program planish-reconstruct, which is not installed (a build "
                "with CGAL makes it; it is found beside planish, on PATH or by "
                "PLANISH_RECONSTRUCT); a polygon mesh needs none");
  return mesher_process(std::move(*program));
}

namespace {

// Degrees are metres neither here nor there: beside heights they are a line.
std::string geographic_hint(const PointCloud& cloud) {
  constexpr double kLeastHeights = 100;  // times the width
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::dvec3& point : cloud.points) {
    low = glm::min(low, cloud.origin + point);
    high = glm::max(high, cloud.origin + point);
  }
  const glm::dvec3 size = high - low;
  const bool may_be_degrees = low.x >= -180 && high.x <= 180 && low.y >= -90 && high.y <= 90;
  const bool are_flat = kLeastHeights * std::max(size.x, size.y) > size.z || size.z == 0;
  if (!may_be_degrees || are_flat) return {};
  return formatted(
      "; x from {} and y from {} look geographic, degrees of longitude and latitude: "
      "project them to metres first (\"pdal translate\" with filters.reprojection)",
      short_number(low.x), short_number(low.y));
}

}  // namespace

Reconstruction reconstruct_input(const PointInput& input, const Mesher& mesher,
                                 const ReconstructOptions& options) {
  for (const Warning& warning : input.cloud.warnings) options.callbacks.warn(warning);
  if (input.cloud.missing_count > 0)
    options.callbacks.warn(
        {.code = "missing-points",
         .message =
             input.name + ": " + counted(input.cloud.missing_count, "point") +
             (input.format == FileFormat::Ptx   ? " at the scanner's own place or not numbers, "
                                                  "where it saw nothing: left out"
              : input.format == FileFormat::Las ? " with the least 32-bit number for a coordinate, "
                                                  "which stands for none: left out"
              : input.cloud.missing_count == 1  ? " is not a number and left out"
                                                : " are not numbers and left out"),
         .count = input.cloud.missing_count});
  try {
    return reconstruct(input.cloud, mesher, options);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnusableMesh) throw;
    throw Error(error.code(), input.name + ": " + error.what() + geographic_hint(input.cloud),
                error.element());
  }
}

PointFacts facts_of(const PointInput& input, const Reconstruction& result) {
  return {.points = std::ssize(input.cloud.points),
          .missing = input.cloud.missing_count,
          .used = std::ssize(result.used_points),
          .origin = input.cloud.origin,
          .mesh = result,
          .sampled = {}};
}

// Where points were moved.
std::string noise_line(const ReconstructionFigures& result) {
  if (result.smooth_rounds == 0) return {};
  std::string line = "  noise       ";
  if (result.noise >= 0)
    line += short_number(result.noise / result.diagonal) + " of the diagonal; ";
  return formatted("{}points moved onto local fits {}, mesh within {}; --smooth 0 leaves them\n",
                   line,
                   result.smooth_rounds == 1 ? "once" : formatted("{} times", result.smooth_rounds),
                   short_number(result.tolerance));
}

std::string points_text(const PointFacts& points) {
  const ReconstructionFigures& result = points.mesh;
  const MeshStatistics& facts = result.statistics;
  return formatted(
      "  points      {}, {} used, spacing {} of the diagonal\n{}  mesh        {}, {}, genus {}, "
      "{}; farthest point {}, rms {} of the diagonal\n",
      with_separators(points.points), with_separators(points.used),
      short_number(result.spacing / result.diagonal), noise_line(result),
      counted(facts.vertex_count, "vertex"), counted(facts.face_count, "face"), facts.genus,
      counted(facts.boundary_loop_count, "boundary loop"),
      short_number(result.distances.max / result.diagonal),
      short_number(result.distances.rms / result.diagonal));
}

}  // namespace planish
