#include "planish/vulkan/levels/level_records.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/mesh/quad_cut.h"
#include "planish/vulkan/host/surface_records.h"

namespace planish::vulkan {

namespace {

// Corners whose grids are made at once.
constexpr std::size_t kGridCorners = 32;

// From a chord's nearest point.
glm::dvec3 from_chord(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0 ? std::clamp(glm::dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return point - (a + t * along);
}

/// The corners' grids of a level above all others.
class ChordMeasure {
 public:
  ChordMeasure(const SurfaceRecords& surface, std::span<const glm::dvec3> state,
               std::span<const int> levels)
      : surface_(surface),
        state_(state),
        levels_(levels),
        fine_(surface.patch_mesh, surface.patch_options(levels.back() + 1)) {
    for (const int level : levels) cells_.emplace_back(level);
  }

  [[nodiscard]] std::vector<double> of(std::span<const std::int32_t> corners) const {
    const PatchSamples& samples = fine_.numbering().samples();
    const auto count = static_cast<std::size_t>(samples.count());
    std::vector<glm::dvec3> points(corners.size() * count);
    std::vector<glm::vec3> normals(points.size());
    PatchTarget target;
    target.positions = points;
    target.normals = normals;
    fine_.grids(state_, Placement{}, corners, target);
    std::vector<double> largest(levels_.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (std::size_t k = 0; k < levels_.size(); ++k)
        largest[k] = std::max(largest[k],
                              of_level(k, corners[i], std::span(points).subspan(i * count, count),
                                       std::span(normals).subspan(i * count, count)));
    return largest;
  }

 private:
  // Of the sides of a level's quads, and of the diagonals that part their triangles.
  [[nodiscard]] double of_level(std::size_t k, std::int32_t corner,
                                std::span<const glm::dvec3> points,
                                std::span<const glm::vec3> normals) const {
    const PatchSamples& samples = fine_.numbering().samples();
    const std::int32_t side = 1 << (levels_[k] - 1), half = samples.side() / side / 2;
    const bool is_sharp_below = surface_.patch_mesh.is_sharp(corner),
               is_sharp_left = surface_.patch_mesh.is_sharp(surface_.topology->prev(corner));
    const auto at = [&](std::int32_t place) {
      return points[samples.index(place % (side + 1) * 2 * half, place / (side + 1) * 2 * half)];
    };
    double largest = 0;
    const auto take = [&](std::int32_t x, std::int32_t y) {
      const std::int32_t a = x % (side + 1) + y % (side + 1), b = x / (side + 1) + y / (side + 1);
      const std::int32_t m = samples.index(a * half, b * half);
      const glm::dvec3 off = from_chord(points[m], at(x), at(y));
      // Beside singular places a middle lies aside within the surface, which is no error but where
      // it ends.
      const bool is_end = (b == 0 && is_sharp_below) || (a == 0 && is_sharp_left);
      const glm::dvec3 normal(normals[m]);
      largest =
          std::max(largest, is_end || normal == glm::dvec3(0) ? glm::length(off)
                                                              : std::abs(glm::dot(normal, off)));
    };
    for (const auto& cell : cells_[k].of(*surface_.topology, corner)) {
      for (std::size_t i = 0; i < 4; ++i) take(cell[i], cell[(i + 1) % 4]);
      const bool from_1 = is_cut_from_1(at(cell[0]), at(cell[1]), at(cell[2]), at(cell[3]));
      take(cell[from_1 ? 1 : 0], cell[from_1 ? 3 : 2]);
    }
    return largest;
  }

  const SurfaceRecords& surface_;
  std::span<const glm::dvec3> state_;
  std::span<const int> levels_;
  PatchSurface fine_;
  std::vector<PatchCells> cells_;
};

}  // namespace

LevelRecords::LevelRecords(const SurfaceRecords& surface, int level)
    : patches(surface.patch_mesh, surface.patch_options(level)) {
  if (surface.uvs) frames = row_frames(patches, surface.weights, *surface.uv_field);
}

double sphere_radius(std::span<const glm::dvec3> points) {
  if (points.empty()) return 0;
  const auto [low, high] = point_bounds(points);
  double radius = 0;
  for (const glm::dvec3& p : points)
    radius = std::max(radius, glm::distance(p, 0.5 * (low + high)));
  return radius;
}

LevelSet make_levels(const PolygonMesh& mesh, const SurfaceRecords& surface,
                     std::span<const glm::dvec3> hull, const PosedSurface& rest,
                     std::span<const int> levels) {
  LevelSet set;
  set.radius = sphere_radius(hull);
  const ChordMeasure measure(surface, rest.state, levels);
  const std::vector<std::int32_t> corners = kept_corners(mesh, *surface.topology);
  const std::vector<double> chords = ordered_reduce(
      corners.size(), kGridCorners, std::vector<double>(levels.size()),
      [&](std::size_t begin, std::size_t end) {
        return measure.of(std::span(corners).subspan(begin, end - begin));
      },
      [](std::vector<double>& total, const std::vector<double>& part) {
        for (std::size_t k = 0; k < total.size(); ++k) total[k] = std::max(total[k], part[k]);
      });
  for (std::size_t k = 0; k < levels.size(); ++k) {
    LevelRecords& level = set.levels.emplace_back(surface, levels[k]);
    const std::vector<std::uint32_t> triangles = kept_faces(mesh, level.patches, rest).triangles;
    level.first_index = set.triangles.size();
    level.index_count = triangles.size();
    set.triangles.insert(set.triangles.end(), triangles.begin(), triangles.end());
    if (set.radius > 0) level.chord = chords[k] / set.radius;
  }
  return set;
}

}  // namespace planish::vulkan
