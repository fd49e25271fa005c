#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <glm/geometric.hpp>
#include <limits>

#include "limit/limit_case.h"
#include "limit/long_run.h"
#include "planish/core/error.h"
#include "planish/files/mesh_file.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

bool is_finite_vector(const glm::dvec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Questions of every kind to one surface, near and far, on it, and with numbers that are none.
class Asker {
 public:
  Asker(const PolygonMesh& mesh, std::uint32_t seed) : case_(mesh), random_(seed) {}

  void ask() {
    switch (std::uniform_int_distribution<int>(0, 2)(random_)) {
      case 0:
        return evaluate();
      case 1:
        return closest();
      default:
        return rays();
    }
  }

 private:
  [[nodiscard]] double size() const { return case_.surface->placement().diagonal; }
  glm::dvec3 any_vector() {
    const double x = normal_(random_), y = normal_(random_);
    return {x, y, normal_(random_)};
  }
  // Also exactly on borders.
  double any_share() {
    constexpr double kOften[] = {0, 0.5, 1, 1e-9, 1 - 1e-9, 1e-300};
    const int kind = std::uniform_int_distribution<int>(0, 11)(random_);
    return kind < 6 ? kOften[kind] : std::uniform_real_distribution<double>(0, 1)(random_);
  }
  SurfaceParameter any_place() {
    const MeshTopology& topology = case_.limit.topology();
    const std::int32_t corner =
        std::uniform_int_distribution<std::int32_t>(0, topology.corner_count() - 1)(random_);
    const double u = any_share();
    return surface_parameter(topology, corner, u, any_share());
  }
  glm::dvec3 any_point() {
    const glm::dvec3 on = case_.limit.evaluate(any_place()).position;
    constexpr double kOff[] = {0, 1e-16, 1e-9, 1e-4, 1e-2, 0.3, 1, 1e3, 1e8, 1e100, 1e200};
    return on + kOff[std::uniform_int_distribution<int>(0, 10)(random_)] * size() * any_vector();
  }
  void evaluate() {
    const SurfacePoint p = case_.limit.evaluate(any_place());
    ASSERT_TRUE(is_finite_vector(p.position) && is_finite_vector(p.normal));
    ASSERT_NEAR(glm::length(p.normal), 1, 1e-12);
    for (const glm::dvec3& d : {p.du, p.dv, p.duu, p.duv, p.dvv}) ASSERT_TRUE(is_finite_vector(d));
    const PointCurvature curvature = p.curvature();
    if (curvature.is_known) {
      ASSERT_TRUE(std::isfinite(curvature.mean) && std::isfinite(curvature.gaussian));
    }
  }
  void closest() {
    glm::dvec3 point = any_point();
    const int kind = std::uniform_int_distribution<int>(0, 19)(random_);
    if (kind < 2) {
      point[kind] = kind == 0 ? std::nan("") : kInfinite;
      ASSERT_THROW((void)queries_.closest(point), Error);
      return;
    }
    const ClosestPoint found = queries_.closest(point);
    ASSERT_TRUE(is_finite_vector(found.position) && is_finite_vector(found.normal));
    ASSERT_TRUE(std::isfinite(found.distance));
    ASSERT_TRUE(case_.limit.evaluate(found.at).position == found.position);
  }
  void rays() {
    SurfaceRay ray{any_point(), any_vector()};
    const int kind = std::uniform_int_distribution<int>(0, 19)(random_);
    if (kind == 0) ray.direction = {};
    if (kind == 1) ray.direction.y = kInfinite;
    if (kind == 2) ray.origin.x = std::nan("");
    if (kind < 3) {
      ASSERT_THROW((void)queries_.first_hit(ray), Error);
      return;
    }
    if (kind == 3) ray.direction = {0, 0, 1};
    if (kind == 4) ray.direction *= 1e-200;
    if (kind == 5) ray.direction *= 1e150;
    if (kind == 6) ray.t_max = -1;
    const auto all = queries_.all_hits(ray);
    for (const SurfaceHit& hit : all) {
      ASSERT_TRUE(is_finite_vector(hit.position) && is_finite_vector(hit.normal));
      ASSERT_FALSE(std::isnan(hit.t));
    }
    ASSERT_EQ(queries_.first_hit(ray).has_value(), !all.empty());
    ASSERT_EQ(queries_.is_occluded(ray), !all.empty());
  }

  LimitCase case_;
  SurfaceQueries queries_{case_.limit};
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

// PLANISH_LONG_RUN=1000000 asks as often.
TEST(AnyQuestion, IsAnsweredOrRefused) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES))
    if (entry.path().extension() == ".obj") paths.push_back(entry.path());
  std::ranges::sort(paths);
  ASSERT_GT(paths.size(), 10u);
  const int each = run_length(1'000) / static_cast<int>(paths.size());
  std::uint32_t seed = 1;
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    const MeshFile file = read_mesh(path);
    Asker asker(file.mesh, seed++);
    for (int i = 0; i < each; ++i) {
      asker.ask();
      if (HasFatalFailure()) FAIL() << "question " << i;
    }
  }
}

}  // namespace
}  // namespace planish::test
