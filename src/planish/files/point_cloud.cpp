#include "planish/files/point_cloud.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/files/pcd/read_pcd.h"
#include "planish/files/xyz/read_xyz.h"
#include "planish/mesh/check.h"

namespace planish {
namespace {

constexpr std::array<std::pair<std::string_view, PointFormat>, 4> kFormats = {{
    {"ply", PointFormat::Ply},
    {"xyz", PointFormat::Xyz},
    {"pts", PointFormat::Pts},
    {"pcd", PointFormat::Pcd},
}};

struct Bounds {
  glm::dvec3 low{0.0}, high{0.0};
};

Bounds bounds_of(std::span<const glm::dvec3> points) {
  if (points.empty()) return {};
  Bounds bounds{points.front(), points.front()};
  for (const glm::dvec3& point : points) {
    bounds.low = glm::min(bounds.low, point);
    bounds.high = glm::max(bounds.high, point);
  }
  return bounds;
}

PointCloud read_ply_points(std::span<const std::byte> bytes, std::string_view name) {
  MeshFile file = read_mesh(bytes, name, MeshFormat::Ply);
  PointCloud cloud = cloud_of(std::move(file.mesh.positions), name);
  cloud.warnings = std::move(file.warnings);
  return cloud;
}

}  // namespace

std::string_view name_of(PointFormat format) {
  for (const auto& [name, value] : kFormats)
    if (value == format) return name;
  return "";
}

std::optional<PointFormat> point_format_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  for (const auto& [name, value] : kFormats)
    if (extension == "." + std::string(name)) return value;
  return std::nullopt;
}

double diagonal_of(std::span<const glm::dvec3> points) {
  const Bounds bounds = bounds_of(points);
  return glm::length(bounds.high - bounds.low);
}

void recentre(PointCloud& cloud) {
  const Bounds bounds = bounds_of(cloud.points);
  const double diagonal = glm::length(bounds.high - bounds.low);
  if (!(diagonal > 0)) return;
  // A multiple of a power of two above the diagonal: then every difference has fewer bits than
  // the coordinate it came from and is exact.
  const double grain = std::ldexp(1.0, std::ilogb(diagonal) + 1);
  for (int axis = 0; axis < 3; ++axis) {
    const double centre = 0.5 * bounds.low[axis] + 0.5 * bounds.high[axis];
    if (std::abs(centre) > kFarDiagonals * diagonal)
      cloud.origin[axis] = std::round(centre / grain) * grain;
  }
  if (cloud.origin == glm::dvec3(0.0)) return;
  for (glm::dvec3& point : cloud.points) point -= cloud.origin;
}

PointCloud cloud_of(std::vector<glm::dvec3> positions, std::string_view name) {
  for (std::size_t i = 0; i < positions.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (!(std::abs(positions[i][axis]) <= kMaxCoordinate))
        throw Error(ErrorCode::UnreadableInput,
                    std::string(name) + ": point " + std::to_string(i) + " of " +
                        std::to_string(positions.size()) + ": a coordinate is beyond 1e150",
                    static_cast<std::int64_t>(i));
  PointCloud cloud{.points = std::move(positions)};
  recentre(cloud);
  return cloud;
}

PointCloud read_points(std::span<const std::byte> bytes, std::string_view name,
                       PointFormat format) {
  if (format == PointFormat::Ply) return read_ply_points(bytes, name);
  PointCloud cloud;
  if (format == PointFormat::Pcd) {
    cloud = read_pcd(bytes, name);
  } else {
    cloud = read_xyz(bytes, name, format == PointFormat::Pts ? TextPoints::Pts : TextPoints::Xyz);
  }
  recentre(cloud);
  return cloud;
}

}  // namespace planish
