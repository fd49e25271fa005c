#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <random>
#include <span>
#include <tuple>
#include <utility>

#include "fair/cure_meshes.h"
#include "planish/core/error.h"
#include "planish/fair/fold_cure.h"
#include "planish/mend/faults.h"
#include "planish/mend/repair.h"
#include "planish/mesh/face_geometry.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"
#include "support/meshes.h"
#include "support/outlines.h"
#include "support/random_meshes.h"

namespace planish {
namespace {

FitOptions fair_options() {
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  return options;
}

// A sphere of uneven triangles: random steps along it.
PolygonMesh uneven_sphere(std::uint32_t seed) {
  PolygonMesh mesh = test::jittered(test::icosphere(3), 0.04, seed);
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  return mesh;
}

std::vector<test::NamedMesh> meshes() {
  return {{"cube", test::cube()},
          {"prism", test::prism(9)},
          {"grid", test::flat_grid(4, 3)},
          {"L", test::l_shaped_plate(3)},
          {"uneven", uneven_sphere(1)},
          {"random", test::random_closed_mesh(4)},
          {"open", test::random_open_mesh(4)},
          {"creased", test::with_random_creases(test::random_open_mesh(5), 0.2, 5)}};
}

// The least of all polygons around smooth vertices, against one made of the control points as they
// stand by corner; and needles keep theirs above what the cure's bound leaves of them.
TEST(FairFit, TellsItsLeastPolygon) {
  const auto backend = make_cpu_backend();
  std::vector<test::NamedMesh> all = meshes();
  all.push_back({"needles", test::needle_rod(24, 6)});
  all.push_back({"needle tube", test::jittered(test::needle_tube(24, 4, 0.3), 0.05, 20)});
  for (const auto& [name, mesh] : all) {
    SCOPED_TRACE(name);
    const Fit result = fit(mesh, *backend, fair_options());
    const std::span<const VertexKind> kinds = result.features->vertex_kinds;
    const std::vector<glm::dvec3>& state = result.fair->level_one.state;
    std::map<std::int32_t, std::pair<double, double>> sizes;  // farthest point, shortest edge
    for (std::int32_t f = 0; f < mesh.face_count(); ++f)
      for (std::int32_t k = 0; k < mesh.face_size(f); ++k) {
        const std::int32_t v = mesh.face(f)[static_cast<std::size_t>(k)];
        if (kinds[v] != VertexKind::Smooth && kinds[v] != VertexKind::Dart) continue;
        auto& [farthest, shortest] = sizes.try_emplace(v, 0, HUGE_VAL).first->second;
        const auto at = [&](std::int32_t vertex) {
          return result.placement.to_unit(mesh.positions[vertex]);
        };
        farthest = std::max(farthest, glm::distance(state[mesh.face_offsets[f] + k], at(v)));
        for (const std::int32_t step : {1, mesh.face_size(f) - 1})
          shortest = std::min(
              shortest,
              glm::distance(
                  at(mesh.face(f)[static_cast<std::size_t>((k + step) % mesh.face_size(f))]),
                  at(v)));
      }
    double least = HUGE_VAL;
    for (const auto& [vertex, size] : sizes) least = std::min(least, size.first / size.second);
    ASSERT_EQ(result.fair->least_polygon.has_value(), std::isfinite(least));
    if (!std::isfinite(least)) continue;
    EXPECT_NEAR(*result.fair->least_polygon, least, 1e-9 * least);
    EXPECT_GT(least, 1e-3);
  }
}

TEST(FairFit, SurfacePassesThroughEveryVertex) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : meshes()) {
    const Fit result = fit(mesh, *backend, fair_options());
    ASSERT_TRUE(result.fair) << name;
    EXPECT_TRUE(result.interpolation.converged) << name;
    EXPECT_EQ(result.interpolation.iterations, 0);
    EXPECT_EQ(result.cage.vertex_count(), 0);
    for (int level = 0; level <= 2; ++level) {
      const SurfaceMesh surface = evaluate(mesh, result, *backend, {.level = level});
      for (std::size_t v = 0; v < surface.base_vertices.size(); ++v) {
        const glm::dvec3 given = mesh.positions[surface.base_vertices[v]];
        EXPECT_LT(glm::length(surface.positions[v] - given), 1e-13) << name << " vertex " << v;
      }
    }
  }
}

// The written cage of a closed smooth mesh, taken as any Doo-Sabin cage, hits the given vertices
// at the middles of its first faces.
TEST(FairFit, TheCageIsADooSabinCage) {
  const auto backend = make_cpu_backend();
  for (const PolygonMesh& mesh : {uneven_sphere(2), test::random_closed_mesh(7)}) {
    const Fit result = fit(mesh, *backend, fair_options());
    const PolygonMesh cage = control_cage(mesh, result, {});
    const SurfaceMesh surface = evaluate(cage, *backend, {.level = 1});
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
      EXPECT_LT(glm::length(surface.positions[cage.vertex_count() + v] - mesh.positions[v]), 1e-13);
    }
  }
}

TEST(FairFit, DoesNotFoldWhereTheProgressiveMethodDoes) {
  const auto backend = make_cpu_backend();
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const PolygonMesh mesh = uneven_sphere(seed);
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {  // the mesh itself is sound
      ASSERT_GT(
          glm::dot(area_vector(mesh.positions, mesh.face(f)), mesh.positions[mesh.face(f)[0]]),
          0.0);
    }
    const auto quality_of = [&](const FitOptions& options) {
      const Fit result = fit(mesh, *backend, options);
      const SurfaceMesh surface = evaluate(mesh, result, *backend, {.level = 3});
      // Against the sphere itself.
      return surface_quality(surface, [&](std::int64_t face, std::int32_t corner) {
        return surface.positions[surface.face(face)[corner]];
      });
    };
    const SurfaceQuality progressive = quality_of({});
    const SurfaceQuality fair = quality_of(fair_options());
    EXPECT_GT(progressive.folded_area, 0.0);
    EXPECT_EQ(fair.folded_area, 0.0);
    EXPECT_LT(fair.rms_normal_deviation, progressive.rms_normal_deviation);
  }
}

TEST(FairFit, KeepsUnusedVerticesAndPlacesFarModels) {
  PolygonMesh mesh = uneven_sphere(3);
  for (glm::dvec3& p : mesh.positions) p += glm::dvec3(1e4, -2e4, 3e4);
  // As many as are used, so that no number among these alone is one of the mesh's.
  const std::int32_t unused = mesh.vertex_count();
  mesh.positions.insert(mesh.positions.begin(), unused, glm::dvec3(0.0));
  for (std::int32_t& v : mesh.face_vertices) v += unused;
  const auto backend = make_cpu_backend();
  const Fit result = fit(mesh, *backend, fair_options());
  EXPECT_GE(result.interpolation.worst_vertex, unused);
  const auto limits = limit_positions(mesh, result.fair->level_one, {});
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (v < unused)
      EXPECT_EQ(limits[v], glm::dvec3(0.0));
    else
      EXPECT_LT(glm::length(limits[v] - mesh.positions[v]), 1e-11);
  }
}

TEST(FairFit, AveragedWeightsTakeOverFromLevelOne) {
  const PolygonMesh mesh = uneven_sphere(1);
  const auto backend = make_cpu_backend();
  FitOptions options = fair_options();
  options.weights = Weights::Averaged;
  const Fit averaged = fit(mesh, *backend, options);
  const Fit standard = fit(mesh, *backend, fair_options());
  EXPECT_EQ(averaged.fair->level_one.state, standard.fair->level_one.state);
  const SurfaceMesh surface =
      evaluate(mesh, averaged, *backend, {.level = 2, .weights = Weights::Averaged});
  EXPECT_NE(surface.positions, evaluate(mesh, standard, *backend, {.level = 2}).positions);
}

TEST(FairFit, KeepsTheDecisionsOfAnotherFrame) {
  // Crumpled, so that some polygons are drawn in.
  PolygonMesh mesh = test::jittered(test::icosphere(2), 0.3, 1);
  const auto backend = make_cpu_backend();
  const Fit rest = fit(mesh, *backend, fair_options());
  ASSERT_GT(rest.fair->shrunk_vertices, 0);
  for (glm::dvec3& p : mesh.positions) p = glm::normalize(p);
  FitOptions options = fair_options();
  options.fair_decisions = &rest.fair->decisions;
  const Fit frame = fit(mesh, *backend, options);
  EXPECT_EQ(frame.fair->decisions.halvings, rest.fair->decisions.halvings);
  EXPECT_EQ(frame.fair->decisions.late_halvings, rest.fair->decisions.late_halvings);
  EXPECT_NE(fit(mesh, *backend, fair_options()).fair->decisions.halvings,
            rest.fair->decisions.halvings);
  EXPECT_TRUE(frame.interpolation.converged);
}

TEST(FairFit, EllipsesCureWhatNoSizeDoes) {
  const PolygonMesh mesh = test::needle_loft(10);
  const auto backend = make_cpu_backend();
  const Fit fitted = fit(mesh, *backend, fair_options());
  const FairDecisions& decisions = fitted.fair->decisions;
  EXPECT_GT(std::ranges::count_if(decisions.ellipses, is_ellipse), 0);
  for (int level = 1; level <= 3; ++level) {
    const SurfaceMesh surface = evaluate(mesh, fitted, *backend, {.level = level});
    EXPECT_EQ(surface_quality(surface, mesh).folded_area_elsewhere, 0) << level;
  }
  EXPECT_TRUE(fitted.interpolation.converged);
  // Decisions alone say all of it.
  FitOptions options = fair_options();
  options.fair_decisions = &decisions;
  const Fit again = fit(mesh, *backend, options);
  EXPECT_EQ(again.fair->level_one.state, fitted.fair->level_one.state);
  FairDecisions others = decisions;
  others.ellipses.pop_back();
  options.fair_decisions = &others;
  EXPECT_THROW((void)fit(mesh, *backend, options), Error);
}

TEST(FairFit, WarnsOfFoldsThatAreLeft) {
  // A crumpled ball: its own faces are folded over each other.
  const PolygonMesh mesh = test::jittered(test::icosphere(2), 0.5, 1);
  std::vector<Warning> warnings;
  FitOptions options = fair_options();
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  const Fit result = fit(mesh, *make_cpu_backend(), options);
  const std::int64_t left = result.fair->flagged_edges + result.fair->flagged_faces;
  ASSERT_GT(left, 0);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].code, "folds-left");
  EXPECT_EQ(warnings[0].count, left);
  EXPECT_TRUE(result.interpolation.converged);
}

TEST(FairFit, SeparatedSheetsStayTogether) {
  const PolygonMesh given = test::bent_sheets();
  const PolygonMesh mesh = repair(given).mesh;
  const auto backend = make_cpu_backend({Precision::Double});
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    FitOptions options;
    options.method = method;
    options.tolerance = 1e-10;
    const SurfaceMesh surface =
        evaluate(mesh, fit(mesh, *backend, options), *backend, EvaluateOptions{.level = 2});
    int on_line = 0;
    for (const glm::dvec3& p : surface.positions) {
      double distance = HUGE_VAL;
      for (int i = 0; i < test::kBentEdges; ++i) {
        const glm::dvec3 a = given.positions[i], along = given.positions[i + 1] - a;
        const double t = std::clamp(glm::dot(p - a, along) / glm::dot(along, along), 0.0, 1.0);
        distance = std::min(distance, glm::distance(p, a + t * along));
      }
      on_line += distance < 1e-8;
      EXPECT_FALSE(distance > 1e-8 && distance < 1e-3) << distance;
    }
    EXPECT_GE(on_line, 3 * (4 * test::kBentEdges + 1));
  }
}

// Another look asks only for what has changed, and finds what a first one would.
TEST(DeepLook, FindsAgainWhatAFreshOneFinds) {
  const auto backend = make_cpu_backend();
  const std::vector<test::NamedMesh> meshes = {
      {"crumpled", test::jittered(test::icosphere(2), 0.5, 1)},
      {"creased", test::with_random_creases(test::random_open_mesh(5), 0.2, 5)},
      {"torus", test::torus(12, 8, 2, 0.7)}};
  int found = 0;
  for (const auto& [name, mesh] : meshes) {
    FitOptions options;
    options.method = InterpolationMethod::Fair;
    const Fit fitted = fit(mesh, *backend, options);
    const UsedPart used = used_part(mesh, fitted.prepared);
    const MeshTopology& topology = *used.prepared->topology;
    LevelOne level_one = fitted.fair->level_one;
    DeepLook look(used.mesh, topology, *fitted.features, options.weights);
    std::mt19937 random(3);
    for (int round = 0; round < 8; ++round) {
      const DeepFolds again = look.at(level_one);
      const DeepFolds fresh =
          DeepLook(used.mesh, topology, *fitted.features, options.weights).at(level_one);
      EXPECT_EQ(again.at_vertex, fresh.at_vertex) << name << round;
      EXPECT_EQ(again.area, fresh.area) << name << round;
      found += fresh.area > 0 ? 1 : 0;
      // Some points move, of curves too, and in the sixth round all stand as they did at first.
      if (round == 5) level_one = fitted.fair->level_one;
      for (int moved = 0; round != 5 && moved < 3; ++moved) {
        glm::dvec3& point = level_one.state[random() % level_one.state.size()];
        point += 0.02 * glm::dvec3(1.0 - 2.0 * (random() % 2), 1.0 - 2.0 * (random() % 2), 0.5);
      }
    }
  }
  EXPECT_GT(found, 10);
}

// Folds that do not end: nets with ellipses are made from the first ellipse on.
TEST(DeeplyCuredNet, MakesNoNetTwice) {
  for (const int first_ellipse : {0, 2, 100}) {
    int nets = 0, choices = 0;
    double area = 1;
    std::vector<std::vector<std::uint8_t>> asked;
    const FairNet net =
        deeply_cured_net({.make_net =
                              [&](const FairDecisions* decisions) {
                                ++nets;
                                FairNet made;
                                if (decisions) made.decisions = *decisions;
                                made.decisions.cures.resize(2, 0);
                                if (decisions) asked.push_back(decisions->cures);
                                made.decisions.leans.assign(2, glm::vec2(static_cast<float>(nets)));
                                return made;
                              },
                          .folds_of =
                              [&](FairNet&) {
                                return DeepFolds{{1, 0}, area *= 0.8};
                              },
                          .choose_ellipses =
                              [&](std::span<const std::uint8_t>, FairDecisions&) {
                                std::vector<std::uint8_t> chosen(2, 0);
                                chosen[0] = choices++ == first_ellipse;
                                return chosen;
                              }});
    // No vertex is cured more often than kMostCures, and then all is done.
    const int with_ellipses = first_ellipse < kMostCures ? 6 - first_ellipse : 0;
    EXPECT_EQ(nets, 1 + kMostCures + with_ellipses);
    EXPECT_EQ(choices, 6);
    EXPECT_EQ(net.rounds.nets, nets);
    // A vertex that has just got its ellipse is not cured in that round.
    if (with_ellipses > 0) {
      EXPECT_EQ(asked[kMostCures][0], first_ellipse);
    }
    EXPECT_EQ(asked[kMostCures - 1][0], kMostCures);
  }
}

}  // namespace
}  // namespace planish

namespace planish::test {
namespace {

// Flat parts with finely drawn outlines by default: all sharp edges kept, no fold.

// The largest folded part of levels 1 to 3.
double folded_area(const PolygonMesh& mesh, const Fit& fit, Backend& backend) {
  double area = 0;
  for (const int level : {1, 2, 3})
    area = std::max(
        area, surface_quality(evaluate(mesh, fit, backend, {.level = level}), mesh).folded_area);
  return area;
}

TEST(FineOutlines, KeepTheirRimsWithoutFolds) {
  // `upright`: sharp edges between the rims. `degrees`: the walls turn by so much at a corner.
  const std::tuple<const char*, Outline, int, double> cases[] = {
      {"rounded square", rounded_square(100, 0.5), 0, 0.3},
      {"square with small arcs", rounded_square(32, 0.1), 0, 0.5},
      {"slot", slot(100, 4), 0, 0.5},
      {"half disc", pie_slice(300, 180), 2, 0.3},
      {"pie slice", pie_slice(100, 90), 3, 0.3},
      {"gear", gear_outline(8, 32), 32, 0.3},
      {"cam of 500", cam(500, 1), 0, 0.6},
      {"another", cam(1000, 5), 0, 0.6}};
  const auto backend = make_cpu_backend();
  for (const auto& [name, outline, upright, degrees] : cases) {
    SCOPED_TRACE(name);
    const PolygonMesh mesh = prism_over(outline);
    const FittedMesh fitted = fit_mesh(mesh, "outline", *backend);
    EXPECT_EQ(fitted.mesh.creases.size(), 2 * outline.size() + std::size_t(upright));
    EXPECT_LT(folded_area(fitted.mesh, fitted.fit, *backend), 1e-5);
    const SurfaceMesh surface = evaluate(fitted.mesh, fitted.fit, *backend, {.level = 2});
    EXPECT_LT(surface_quality(surface, fitted.mesh).rms_normal_deviation, degrees);
  }
}

// What kMostSwirl stands for.
TEST(FineOutlines, FoldWhereTheirCornersSwirlAndNothingIsCut) {
  const auto backend = make_cpu_backend();
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  options.cures_folds = false;
  for (const auto& [steps, least, most] :
       {std::tuple(8, 0.0, 0.0), {16, 0.0, 0.0}, {100, 1e-3, 1.0}, {300, 1e-2, 1.0}}) {
    const Outline outline = rounded_square(steps, 0.5);
    EXPECT_EQ(corner_swirl(outline) > kMostSwirl, least > 0) << steps;
    const PolygonMesh mesh = with_sharp_rims(prism_over(outline));
    const double folded = folded_area(mesh, fit(mesh, *backend, options), *backend);
    EXPECT_GE(folded, least) << steps;
    EXPECT_LE(folded, most) << steps;
  }
}

}  // namespace
}  // namespace planish::test
