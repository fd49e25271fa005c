#include "planish/vulkan/levels/level_records.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <utility>

#include "planish/core/parallel.h"
#include "planish/core/point_bounds.h"
#include "planish/vulkan/host/kept_faces.h"
#include "planish/vulkan/host/surface_records.h"

namespace planish::vulkan {

namespace {

// Corners whose grids are made at once.
constexpr std::size_t kGridCorners = 32;

double distance_from_chord(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a;
  const double square = glm::dot(along, along);
  const double t = square > 0 ? std::clamp(glm::dot(point - a, along) / square, 0.0, 1.0) : 0.0;
  return glm::distance(point, a + t * along);
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
    PatchTarget target;
    target.positions = points;
    fine_.grids(state_, Placement{}, corners, target);
    std::vector<double> largest(levels_.size());
    for (std::size_t i = 0; i < corners.size(); ++i)
      for (std::size_t k = 0; k < levels_.size(); ++k)
        largest[k] = std::max(largest[k],
                              of_level(k, corners[i], std::span(points).subspan(i * count, count)));
    return largest;
  }

 private:
  // Sides of its quads, and the diagonal that parts their triangles.
  static constexpr std::array<std::array<int, 2>, 5> kChords{
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 2}}};

  [[nodiscard]] double of_level(std::size_t k, std::int32_t corner,
                                std::span<const glm::dvec3> points) const {
    const PatchSamples& samples = fine_.numbering().samples();
    const std::int32_t side = 1 << (levels_[k] - 1), half = samples.side() / side / 2;
    // Of two samples, or of one with itself.
    const auto middle = [&](std::int32_t x, std::int32_t y) {
      const std::int32_t a = x % (side + 1) + y % (side + 1), b = x / (side + 1) + y / (side + 1);
      return points[samples.index(a * half, b * half)];
    };
    double largest = 0;
    for (const auto& cell : cells_[k].of(*surface_.topology, corner))
      for (const auto& [from, to] : kChords) {
        const std::int32_t a = cell[from], b = cell[to];
        largest = std::max(largest, distance_from_chord(middle(a, b), middle(a, a), middle(b, b)));
      }
    return largest;
  }

  const SurfaceRecords& surface_;
  std::span<const glm::dvec3> state_;
  std::span<const int> levels_;
  PatchSurface fine_;
  std::vector<PatchCells> cells_;
};

std::vector<std::int32_t> kept_corners(const PolygonMesh& mesh, const MeshTopology& topology) {
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> corners;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    if (is_hole[topology.face_of(c)] == 0) corners.push_back(c);
  return corners;
}

}  // namespace

LevelRecords::LevelRecords(const SurfaceRecords& surface, int level)
    : patches(surface.patch_mesh, surface.patch_options(level)) {
  if (surface.uvs) frames = row_frames(patches, surface.weights, surface.corner_values());
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
                     std::span<const glm::dvec3> cage, std::span<const glm::dvec3> state,
                     std::span<const int> levels) {
  LevelSet set;
  set.radius = sphere_radius(cage);
  const ChordMeasure measure(surface, state, levels);
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
    level.first_index = set.triangles.size();
    for_kept_faces(mesh, *surface.topology, level.patches.numbering(),
                   [&](std::span<const std::int32_t> face) { add_triangles(face, set.triangles); });
    level.index_count = set.triangles.size() - level.first_index;
    if (set.radius > 0) level.chord = chords[k] / set.radius;
  }
  return set;
}

}  // namespace planish::vulkan
