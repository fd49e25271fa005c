// Based on: R. L. Cook, "Stochastic Sampling in Computer Graphics", 1986 (dart throwing).
#include "make_scenes/sample_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "planish/core/vectors.h"

namespace planish::shapes {
namespace {

// Darts thrown for each point that shall stick.
constexpr std::int32_t kDartsPerPoint = 12;
constexpr int kBisections = 7;

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

// Points in cells as wide as a radius: those nearer than it lie in the 27 cells around a place.
// Cells may share a bucket, which costs time and changes nothing.
class CellGrid {
 public:
  CellGrid(double radius, std::size_t expected)
      : radius_(radius), heads_(std::bit_ceil(2 * expected + 1), -1) {}

  [[nodiscard]] const std::vector<glm::dvec3>& points() const { return points_; }

  void add_if_free(const glm::dvec3& point) {
    const glm::dvec3 cell = glm::floor(point / radius_);
    for (int i = 0; i < 27; ++i) {
      const glm::dvec3 step(i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1);
      for (std::int32_t other = heads_[bucket(cell + step)]; other >= 0; other = next_[other]) {
        const glm::dvec3 between = points_[other] - point;
        if (glm::dot(between, between) < radius_ * radius_) return;
      }
    }
    std::int32_t& head = heads_[bucket(cell)];
    next_.push_back(head);
    head = static_cast<std::int32_t>(points_.size());
    points_.push_back(point);
  }

 private:
  [[nodiscard]] std::size_t bucket(const glm::dvec3& cell) const {
    const auto mixed = static_cast<std::uint64_t>(static_cast<std::int64_t>(cell.x)) * 73856093u ^
                       static_cast<std::uint64_t>(static_cast<std::int64_t>(cell.y)) * 19349663u ^
                       static_cast<std::uint64_t>(static_cast<std::int64_t>(cell.z)) * 83492791u;
    return mixed & (heads_.size() - 1);
  }

  double radius_;
  std::vector<std::int32_t> heads_, next_;
  std::vector<glm::dvec3> points_;
};

// The darts, in order, that keep `radius` from all before them.
std::vector<glm::dvec3> keep_apart(std::span<const glm::dvec3> darts, double radius) {
  CellGrid grid(radius, darts.size() / kDartsPerPoint);
  for (const glm::dvec3& dart : darts) grid.add_if_free(dart);
  return grid.points();
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
  const auto [low, high] = point_bounds(points);
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
