// Based on: R. L. Cook, "Stochastic Sampling in Computer Graphics", 1986 (dart throwing).
#include "make_scenes/sample_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <unordered_map>

#include "make_scenes/random_numbers.h"

namespace planish::shapes {
namespace {

// Darts thrown for each point that shall stick.
constexpr std::int32_t kDartsPerPoint = 12;
constexpr int kBisections = 10;

// Draws points even in area.
class AreaSampler {
 public:
  explicit AreaSampler(const PolygonMesh& mesh) {
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      const auto face = mesh.face(f);
      for (std::size_t i = 2; i < face.size(); ++i) {
        const std::array<glm::dvec3, 3> corners = {
            mesh.positions[face[0]], mesh.positions[face[i - 1]], mesh.positions[face[i]]};
        area_ += 0.5 * glm::length(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        triangles_.push_back(corners);
        sums_.push_back(area_);
      }
    }
  }
  [[nodiscard]] double area() const { return area_; }
  [[nodiscard]] glm::dvec3 draw(RandomNumbers& random) const {
    const auto found = std::ranges::upper_bound(sums_, random.unit() * area_);
    const auto at = std::min<std::size_t>(found - sums_.begin(), sums_.size() - 1);
    const auto& [a, b, c] = triangles_[at];
    const double s = std::sqrt(random.unit()), t = random.unit();
    return (1 - s) * a + s * (1 - t) * b + s * t * c;
  }

 private:
  std::vector<std::array<glm::dvec3, 3>> triangles_;
  std::vector<double> sums_;  // of the areas up to and with each triangle
  double area_ = 0;
};

// The darts, in order, that keep `radius` from all before them.
std::vector<glm::dvec3> keep_apart(std::span<const glm::dvec3> darts, double radius) {
  // Cells are as wide as the radius: only neighbouring cells matter. Mixed keys may collide, which
  // costs time and changes nothing.
  const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::uint64_t>(x) * 73856093u ^ static_cast<std::uint64_t>(y) * 19349663u ^
           static_cast<std::uint64_t>(z) * 83492791u;
  };
  const auto cell = [&](double v) { return static_cast<std::int64_t>(std::floor(v / radius)); };
  std::unordered_map<std::uint64_t, std::vector<std::int32_t>> grid;
  std::vector<glm::dvec3> kept;
  const auto is_free = [&](const glm::dvec3& dart) {
    for (int i = 0; i < 27; ++i) {
      const auto found = grid.find(
          key(cell(dart.x) + i / 9 - 1, cell(dart.y) + i / 3 % 3 - 1, cell(dart.z) + i % 3 - 1));
      if (found == grid.end()) continue;
      for (const std::int32_t other : found->second)
        if (glm::distance(kept[other], dart) < radius) return false;
    }
    return true;
  };
  for (const glm::dvec3& dart : darts) {
    if (!is_free(dart)) continue;
    grid[key(cell(dart.x), cell(dart.y), cell(dart.z))].push_back(
        static_cast<std::int32_t>(kept.size()));
    kept.push_back(dart);
  }
  return kept;
}

}  // namespace

std::vector<glm::dvec3> sample_uniform(const PolygonMesh& mesh, std::int32_t count,
                                       std::uint32_t seed) {
  const AreaSampler sampler(mesh);
  RandomNumbers random(seed);
  std::vector<glm::dvec3> points;
  for (std::int32_t i = 0; i < count; ++i) points.push_back(sampler.draw(random));
  return points;
}

std::vector<glm::dvec3> sample_poisson_disk(const PolygonMesh& mesh, std::int32_t count,
                                            std::uint32_t seed) {
  const std::vector<glm::dvec3> darts = sample_uniform(mesh, kDartsPerPoint * count, seed);
  const double side = std::sqrt(AreaSampler(mesh).area() / count);
  double low = 0.3 * side, high = 1.2 * side;  // hexagons would reach 1.07
  std::vector<glm::dvec3> best = keep_apart(darts, low);
  for (int i = 0; i < kBisections; ++i) {
    const double radius = 0.5 * (low + high);
    std::vector<glm::dvec3> kept = keep_apart(darts, radius);
    const bool enough = kept.size() >= static_cast<std::size_t>(count);
    (enough ? low : high) = radius;
    if (enough) best = std::move(kept);
  }
  best.resize(std::min(best.size(), static_cast<std::size_t>(count)));
  return best;
}

void add_noise(std::span<glm::dvec3> points, double deviation, std::uint32_t seed) {
  RandomNumbers random(seed);
  for (glm::dvec3& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      // Twelve even numbers have variance 1: normal enough, and the same everywhere.
      double sum = -6;
      for (int i = 0; i < 12; ++i) sum += random.unit();
      point[axis] += deviation * sum;
    }
  }
}

void add_outliers(std::vector<glm::dvec3>& points, std::int32_t count, std::uint32_t seed) {
  if (points.empty()) return;
  glm::dvec3 low = points.front(), high = low;
  for (const glm::dvec3& point : points) {
    low = glm::min(low, point);
    high = glm::max(high, point);
  }
  RandomNumbers random(seed);
  for (std::int32_t i = 0; i < count; ++i) {
    const double x = random.unit(), y = random.unit(), z = random.unit();
    points.push_back(low + glm::dvec3(x, y, z) * (high - low));
  }
}

std::string ply_text(std::span<const glm::dvec3> points) {
  std::string text =
      "ply\nformat binary_little_endian 1.0\ncomment sampled by planish-make-scenes\n"
      "element vertex " +
      std::to_string(points.size()) +
      "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const glm::dvec3& point : points) {
    for (int axis = 0; axis < 3; ++axis) {
      const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(point[axis]));
      for (int byte = 0; byte < 4; ++byte)
        text += static_cast<char>(static_cast<unsigned char>(bits >> (8 * byte)));
    }
  }
  return text;
}

}  // namespace planish::shapes
