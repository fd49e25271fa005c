#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include "brep/step_cases.h"
#include "brep/step_checks.h"
#include "planish/pipeline/write_fitted_step.h"
#include "planish/queries/surface_queries.h"

namespace planish::test {
namespace {

double largest_size(const Brep& brep) {
  double size = 0;
  for (const glm::dvec3& p : brep.vertices) size = std::max(size, glm::length(p));
  return size;
}

TEST(Step, FacesMeetAlongEdges) {
  for (const auto& [name, mesh] : step_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit, {.angle = 2, .deviation = 1e-4});
    const StepFile file = written(c, brep, scratch("joined.step"));
    const auto border_count =
        std::ranges::count_if(brep.edges, [](const Brep::Edge& e) { return e.lines[1].face < 0; });
    // 15 digits of coordinates, which may be larger than the surface.
    const double size = std::max(c.surface->placement().diagonal, largest_size(brep));
    expect_joined(file, 1e-12 * size, 1e-9 * size, border_count);
    expect_loops(file);
    const auto count = [&](const char* keyword) { return std::ssize(file.all(keyword)); };
    EXPECT_EQ(count("VERTEX_POINT") - count("EDGE_CURVE") + count("ADVANCED_FACE"),
              euler_number(c.limit.topology(), c.limit.surface().hidden()));
    EXPECT_EQ(count("OPEN_SHELL") > 0, border_count > 0);
    EXPECT_EQ(count("B_SPLINE_SURFACE_WITH_KNOTS") + count("PLANE"), count("ADVANCED_FACE"));
    EXPECT_EQ(count("CLOSED_SHELL"), count("MANIFOLD_SOLID_BREP"));
  }
}

// Of places of a file from the surface, of the diagonal: within `reach` of two borders, and others.
struct Distances {
  double inner = 0, outer = 0;
};
Distances distances_from(const SurfaceQueries& queries, const StepFile& file, double reach,
                         double diagonal) {
  Distances worst;
  std::mt19937 random(3);
  const auto surfaces = file.all("B_SPLINE_SURFACE_WITH_KNOTS");
  const std::size_t step = std::max<std::size_t>(1, surfaces.size() / 20);
  for (std::size_t f = 0; f < surfaces.size(); f += step) {
    const StepFile::Surface& surface = file.surface(surfaces[f]);
    std::uniform_real_distribution<double> x(surface.u.low(), surface.u.high()),
        y(surface.v.low(), surface.v.high());
    for (int k = 0; k < 12; ++k) {
      const double u = x(random), v = y(random);
      const double off = queries.closest(surface.at(u, v)).distance / diagonal;
      const auto is_end = [&](const KnotLine& line, double t) {
        return std::min(t - line.low(), line.high() - t) < reach;
      };
      double& of_kind = is_end(surface.u, u) && is_end(surface.v, v) ? worst.inner : worst.outer;
      of_kind = std::max(of_kind, off);
    }
  }
  return worst;
}

// Asked of the surface itself, by closest points. Squares at extraordinary points are at most half
// a quad, and where points beside them are moved a whole one.
TEST(Step, LiesOnTheSurfaceAndKeepsTheTolerance) {
  int moved = 0, unmoved = 0;
  for (const auto& [name, mesh] : step_meshes()) {
    SCOPED_TRACE(name);
    const LimitCase c(mesh);
    const SurfaceQueries queries(c.limit);
    for (const double limit : {1.0, 1e-5}) {
      const Brep brep = make_brep(c.limit, {.angle = 90, .deviation = limit});
      const StepFile file = written(c, brep, scratch("places.step"));
      const Distances off =
          distances_from(queries, file, brep.moved > 0 ? 1 : 0.5, c.surface->placement().diagonal);
      EXPECT_LE(off.outer, 1e-12);
      EXPECT_LE(off.inner, brep.max_deviation * 1.5 + 1e-11);
      EXPECT_LE(brep.max_deviation, limit);
      ++(brep.moved > 0 ? moved : unmoved);
    }
  }
  EXPECT_GT(moved, 5);
  EXPECT_GT(unmoved, 15);
}

// Of surfaces that leave the given vertices by so much: the file is that surface, and as far off.
TEST(Step, SurfacesWithinATolerancePassVerticesByNoMore) {
  const PolygonMesh mesh = jittered(torus(24, 16, 3, 1), 0.1, 4);
  const auto backend = make_cpu_backend();
  constexpr double kWithin = 0.005;  // of the diagonal
  for (const InterpolationMethod method :
       {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    MeshFitOptions how;
    how.method = method;
    how.fit.within = kWithin;
    const FittedMesh fitted = fit_mesh(mesh, "noisy", *backend, how);
    ASSERT_TRUE(fitted.fit.within);
    const double diagonal = fitted.fit.placement.diagonal;
    const StepFigures figures = write_fitted_step(scratch("within.step"), fitted, {});
    EXPECT_EQ(figures.solids, 1);
    EXPECT_TRUE(figures.keeps_limits);
    EXPECT_LE(figures.largest_distance, 2e-6 * diagonal);
    const StepFile file(scratch("within.step"));
    expect_joined(file, 1e-12 * diagonal, 1e-9 * diagonal, 0);
    const LimitSurface limit(fitted_surface(fitted.mesh, fitted.fit, fitted.evaluate_options()));
    const Distances off = distances_from(SurfaceQueries(limit), file, 1, diagonal);
    EXPECT_LE(std::max(off.inner, off.outer), 1.5 * figures.max_deviation + 1e-11);
    // By the faces of the B-rep, against the given vertices.
    const Brep brep = make_brep(limit);
    double largest = 0;
    for (std::size_t v = 0; v < brep.places.size(); ++v) {
      const Brep::Place& place = brep.places[v];
      const glm::dvec3 there = point_of(brep, brep.faces[place.face], place.at);
      largest = std::max(largest, glm::length(there - mesh.positions[v]) / diagonal);
    }
    EXPECT_LE(largest, kWithin + 2e-6);
    EXPECT_GE(largest, 0.9 * kWithin);
  }
}

// Moves let squares be larger within the same limits, and only where all around is smooth.
TEST(Step, PointsBesideExtraordinaryOnesAreMovedWhereItHelps) {
  const LimitCase c(icosphere(2));
  const Brep brep = make_brep(c.limit, {.angle = 1, .deviation = 1e-4});
  EXPECT_GT(brep.moved, 0);
  EXPECT_LT(brep.moved, brep.extraordinary);
  // Each limit alone asks for no less.
  EXPECT_LE(brep.max_angle, 1);
  EXPECT_LE(brep.max_deviation, 1e-4);
  EXPECT_EQ(make_brep(c.limit, {.angle = 90, .deviation = 1}).moved, 0);
  // Around hubs of twelve they spare halvings: a third more points where they go astray.
  std::size_t points = 0;
  for (const Brep::Face& face :
       make_brep(LimitCase(bipyramid(12)).limit, {.angle = 1, .deviation = 1e-4}).faces)
    points += face.points.size();
  EXPECT_LT(points, 2600u);  // 2,304
  // A pentagon's centre has no edge that is sharp; of the corners of a cube all have.
  EXPECT_EQ(make_brep(LimitCase(creased_cube(true)).limit, {.angle = 1e-3}).moved, 0);
}

TEST(Step, NormalsAgreeAcrossSmoothEdges) {
  for (const PolygonMesh& mesh : {cube(), torus(7, 5, 3, 1), icosphere(1), prism(5)}) {
    const LimitCase c(mesh);
    const Brep brep = make_brep(c.limit, {});
    EXPECT_LE(brep.max_angle, 0.25);
    const StepFile file = written(c, brep, scratch("angles.step"));
    EXPECT_LE(worst_jump(file), 0.26);
  }
}

TEST(Step, HasTheSameBytesOnEveryNumberOfThreads) {
  const LimitCase c(random_closed_mesh(7));
  std::array<std::string, 2> bytes;
  for (const std::size_t i : {0u, 1u}) {
    const oneapi::tbb::global_control threads(oneapi::tbb::global_control::max_allowed_parallelism,
                                              i == 0 ? 1 : 4);
    const std::string path = scratch("threads.step");
    const std::uint64_t size = write_step(path, make_brep(c.limit), {.name = "it's a \xc3\xa4"});
    bytes[i] = bytes_of(path);
    EXPECT_EQ(size, bytes[i].size());
  }
  EXPECT_EQ(bytes[0], bytes[1]);
  EXPECT_NE(bytes[0].find("PRODUCT('it''s a \\X4\\000000E4\\X0\\'"), std::string::npos);
}

}  // namespace
}  // namespace planish::test
