// Catmull-Clark and Loop from fit() to the tessellated surface.

#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/core/error.h"
#include "planish/pipeline/fit.h"
#include "planish/primal/primal_stencils.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

Scheme scheme_of(PrimalScheme scheme) {
  return scheme == PrimalScheme::Loop ? Scheme::Loop : Scheme::CatmullClark;
}

double largest_distance(std::span<const dvec3> a, std::span<const dvec3> b, std::size_t count) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, glm::length(a[i] - b[i]));
  return largest;
}

// B of Catmull-Clark is singular on prisms of an even number of sides and has negative eigenvalues
// on valence 2.
bool is_solvable(const std::string& name) {
  return name != "cube" && name != "cube with split edges" && name != "prism 64";
}

class Schemes : public testing::TestWithParam<PrimalScheme> {
 protected:
  Scheme scheme() const { return scheme_of(GetParam()); }
};

TEST_P(Schemes, SurfacesOfAllLevelsPassThroughEveryVertex) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    SCOPED_TRACE(name);
    if (!is_solvable(name)) continue;
    FitOptions options;
    options.scheme = scheme();
    options.tolerance = 1e-10;
    const Fit result = fit(mesh, *backend, options);
    ASSERT_TRUE(result.interpolation.converged)
        << result.interpolation.error.max << " after " << result.interpolation.iterations;
    const double allowed = 1.1e-10 * result.placement.diagonal;
    const auto count = static_cast<std::size_t>(mesh.vertex_count());
    const auto limits = limit_positions(result.cage, {.scheme = scheme()});
    EXPECT_LT(largest_distance(limits, mesh.positions, count), allowed);
    for (int level = 0; level <= 2; ++level) {
      const SurfaceMesh surface =
          evaluate(mesh, result, *backend, {.level = level, .scheme = scheme()});
      ASSERT_EQ(surface.base_vertices.size(), count);
      // Semi-sharp blends are single precision, by one step more or less.
      EXPECT_LT(largest_distance(surface.positions, mesh.positions, count), allowed + 1e-6);
      for (const glm::vec3& normal : surface.normals) {
        ASSERT_NEAR(glm::length(normal), 1.0f, 1e-5f);
      }
    }
  }
}

TEST_P(Schemes, VerticesOfALevelStayOnTheNext) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : primal_meshes(GetParam())) {
    if (mesh.vertex_count() > 300) continue;
    SCOPED_TRACE(name);
    std::vector<SurfaceMesh> levels;
    for (int level = 0; level <= 3; ++level) {
      levels.push_back(evaluate(mesh, *backend, {.level = level, .scheme = scheme()}));
    }
    PrimalSplit split(mesh, {GetParam(), {}});
    const auto counts = split.counts_to(3);
    for (int level = 0; level < 3; ++level) {
      EXPECT_LT(largest_distance(levels[level].positions, levels[level + 1].positions,
                                 static_cast<std::size_t>(counts[level].vertices)),
                1e-6);
    }
  }
}

// A primvar of OpenSubdiv's protocol.
struct Point {
  dvec3 value{0.0};
  void Clear() { value = dvec3(0.0); }
  void AddWithWeight(const Point& other, double weight) { value += weight * other.value; }
};

// OpenSubdiv's own refinement and limits, which are right on level 2 of smooth meshes.
TEST_P(Schemes, LevelTwoIsOpenSubdivs) {
  for (const PolygonMesh& given :
       {icosphere(1), jittered(torus(7, 5, 1, 0.4), 0.05, 3), random_closed_mesh(5)}) {
    const PolygonMesh mesh = GetParam() == PrimalScheme::Loop ? as_triangles(given) : given;
    PrimalSplit split(mesh, {GetParam(), {}});
    split.refine(2);
    const OpenSubdiv::Far::PrimvarRefinerReal<double> refiner(split.refiner());
    std::vector<Point> points(mesh.positions.size());
    for (std::size_t i = 0; i < points.size(); ++i) points[i].value = mesh.positions[i];
    for (int l = 1; l <= 2; ++l) {
      std::vector<Point> finer(static_cast<std::size_t>(split.level(l).GetNumVertices()));
      refiner.Interpolate(l, points, finer);
      points = std::move(finer);
    }
    std::vector<Point> limit(points.size()), du(points.size()), dv(points.size());
    refiner.Limit(points, limit, du, dv);
    const SurfaceMesh surface =
        evaluate(mesh, *make_cpu_backend(), {.level = 2, .scheme = scheme()});
    ASSERT_EQ(surface.positions.size(), points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_LT(glm::length(surface.positions[i] - limit[i].value), 1e-12);
      const dvec3 normal = glm::normalize(glm::cross(du[i].value, dv[i].value));
      ASSERT_GT(glm::dot(normal, dvec3(surface.normals[i])), 1 - 1e-6) << "vertex " << i;
    }
  }
}

TEST_P(Schemes, CommuteWithAffineMaps) {
  const dvec3 shift(3, -2, 7);
  const glm::dmat3 map(2, 0.3, 0, -0.1, 1.5, 0.4, 0.2, 0, 0.7);
  for (PolygonMesh mesh : {random_closed_mesh(3), random_open_mesh(4)}) {
    if (GetParam() == PrimalScheme::Loop) mesh = as_triangles(mesh);
    PolygonMesh moved = mesh;
    for (dvec3& p : moved.positions) p = map * p + shift;
    const auto backend = make_cpu_backend();
    const SurfaceMesh a = evaluate(mesh, *backend, {.level = 2, .scheme = scheme()});
    const SurfaceMesh b = evaluate(moved, *backend, {.level = 2, .scheme = scheme()});
    for (std::size_t i = 0; i < a.positions.size(); ++i) {
      ASSERT_LT(glm::length(map * a.positions[i] + shift - b.positions[i]), 1e-12);
    }
  }
}

TEST_P(Schemes, EverySolverFindsTheSameCage) {
  const PolygonMesh mesh = jittered(icosphere(2), 0.03, 1);
  std::vector<Fit> fits;
  for (const Solver solver : {Solver::Chebyshev, Solver::Plain, Solver::ConjugateGradients}) {
    FitOptions options;
    options.scheme = scheme();
    options.solver = solver;
    options.tolerance = 1e-11;
    fits.push_back(fit(mesh, *make_cpu_backend(), options));
    EXPECT_TRUE(fits.back().interpolation.converged);
  }
  const auto count = mesh.positions.size();
  EXPECT_LT(largest_distance(fits[0].cage.positions, fits[1].cage.positions, count), 1e-9);
  EXPECT_LT(largest_distance(fits[0].cage.positions, fits[2].cage.positions, count), 1e-9);
}

TEST_P(Schemes, RefuseTheFairMethodAndConjugateGradientsOnOpenMeshes) {
  const PolygonMesh mesh = as_triangles(flat_grid(3, 3));
  FitOptions options;
  options.scheme = scheme();
  options.solver = Solver::ConjugateGradients;
  EXPECT_THROW((void)fit(mesh, *make_cpu_backend(), options), Error);
  options = {};
  options.scheme = scheme();
  options.method = InterpolationMethod::Fair;
  EXPECT_THROW((void)fit(mesh, *make_cpu_backend(), options), Error);
}

TEST_P(Schemes, CarryAttributesLinearlyAndLeaveHolesOut) {
  PolygonMesh mesh = flat_grid(2, 1);
  mesh.colors = {{0, 0, 0, 1}, {0.5, 0, 0, 1}, {1, 0, 0, 1},
                 {0, 1, 0, 1}, {0.5, 1, 0, 1}, {1, 1, 0, 1}};
  mesh.uvs = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}};
  if (GetParam() == PrimalScheme::Loop) {
    const auto keep = mesh;
    mesh = as_triangles(mesh);
    mesh.colors = keep.colors;
    mesh.uvs = keep.uvs;
  }
  mesh.face_uvs = mesh.face_vertices;
  mesh.groups = {{"first", "red"}, {"last", "blue"}};
  mesh.face_groups.assign(static_cast<std::size_t>(mesh.face_count()), 0);
  mesh.face_groups.back() = 1;
  for (int level = 0; level <= 3; ++level) {
    const SurfaceMesh whole = evaluate(
        mesh, *make_cpu_backend(),
        {.level = level, .scheme = scheme(), .sharp = {.boundary = BoundaryRule::EdgeAndCorner}});
    ASSERT_EQ(whole.face_uvs.size(), whole.face_vertices.size());
    ASSERT_EQ(static_cast<std::int64_t>(whole.face_groups.size()), whole.face_count());
    EXPECT_EQ(std::ranges::count(whole.face_groups, 1) * mesh.face_count(), whole.face_count());
    for (std::size_t c = 0; c < whole.face_vertices.size(); ++c) {
      // Both are the linear function (x, y) / (2, 1) of the flat grid's parameters.
      const glm::vec4& color = whole.colors[whole.face_vertices[c]];
      const glm::dvec2& uv = whole.uvs[whole.face_uvs[c]];
      ASSERT_NEAR(color.r, uv.x / 2, 1e-6);
      ASSERT_NEAR(color.g, uv.y, 1e-6);
    }
    EXPECT_EQ(surface_quality(whole, mesh).folded_area, 0);
    PolygonMesh holed = mesh;
    holed.hole_faces = {0};
    const SurfaceMesh part =
        evaluate(holed, *make_cpu_backend(), {.level = level, .scheme = scheme()});
    EXPECT_EQ(part.face_count() * mesh.face_count(), whole.face_count() * (mesh.face_count() - 1));
  }
}

INSTANTIATE_TEST_SUITE_P(Both, Schemes, testing::ValuesIn(kBothPrimalSchemes),
                         [](const auto& test) {
                           return test.param == PrimalScheme::Loop ? "Loop" : "CatmullClark";
                         });

// Its B has the eigenvalue 0 (alternating signs), so that only some cubes have an interpolant: the
// regular one does.
TEST(SingularSchemes, APerturbedCubeDoesNotConverge) {
  PolygonMesh mesh = cube();
  mesh.positions[0] *= 1.1;
  for (const Solver solver : {Solver::Chebyshev, Solver::Plain, Solver::ConjugateGradients}) {
    FitOptions options;
    options.scheme = Scheme::CatmullClark;
    options.solver = solver;
    options.max_iterations = 1000;
    const Fit result = fit(mesh, *make_cpu_backend(), options);
    EXPECT_FALSE(result.interpolation.converged);
    EXPECT_EQ(result.interpolation.stop_reason, StopReason::Singular)
        << static_cast<int>(solver) << " " << name_of(result.interpolation.stop_reason);
    EXPECT_LT(result.interpolation.iterations, 300);
    EXPECT_GT(result.interpolation.error.max, 1e-3);
  }
  FitOptions options;
  options.scheme = Scheme::CatmullClark;
  EXPECT_TRUE(fit(cube(), *make_cpu_backend(), options).interpolation.converged);
}

// A vertex in the middle of every edge gives B a negative eigenvalue: the error grows.
TEST(SingularSchemes, ANegativeEigenvalueDiverges) {
  PolygonMesh mesh = jittered(cube_with_split_edges(), 0.1, 2);
  FitOptions options;
  options.scheme = Scheme::CatmullClark;
  options.max_iterations = 1000;
  for (const Solver solver : {Solver::Chebyshev, Solver::Plain}) {
    options.solver = solver;
    const Fit result = fit(mesh, *make_cpu_backend(), options);
    EXPECT_FALSE(result.interpolation.converged);
    EXPECT_EQ(result.interpolation.stop_reason, StopReason::Diverged)
        << name_of(result.interpolation.stop_reason);
  }
}

}  // namespace
}  // namespace planish::test
