// Semi-sharp edges of Doo-Sabin surfaces, by the fair method, beside OpenSubdiv's of Catmull-Clark.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <vector>

#include "planish/edit/editor.h"
#include "planish/fair/semi_sharp.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "support/mesh_catalogue.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

FitOptions exact_fair() {
  FitOptions options;
  options.method = InterpolationMethod::Fair;
  options.tolerance = 1e-12;
  return options;
}

// A roof of two flat sides that meet at a right angle along the y axis, n by n quads each.
PolygonMesh roof(int n, float sharpness) {
  PolygonMesh mesh = grid(
      2 * n, n, [&](double i, double j) { return dvec3(i - n, j, -std::abs(i - n)) / double(n); });
  const auto ridge = [&](int j) { return j * (2 * n + 1) + n; };
  for (int j = 0; j < n && sharpness > 0; ++j)
    mesh.creases.push_back({ridge(j), ridge(j + 1), sharpness});
  return mesh;
}

// Within which distance of the ridge, in quads, the surface has turned by this part of 45 degrees,
// across the middle of the roof.
double width_of_turn(const PolygonMesh& mesh, int n, const FitOptions& options, double part) {
  const auto backend = make_cpu_backend();
  const SurfaceMesh surface = evaluate(mesh, fit(mesh, *backend, options), *backend,
                                       {.level = 6, .scheme = options.scheme});
  double width = 0;
  for (std::size_t i = 0; i < surface.positions.size(); ++i) {
    const dvec3& p = surface.positions[i];
    const dvec3 normal(surface.normals[i]);
    if (std::abs(p.y - 0.5) > 1e-6 || p.x < 0) continue;
    const double turned = std::atan2(normal.x, normal.z) / std::atan2(1.0, 1.0);
    if (turned < part) width = std::max(width, p.x * n);
  }
  return width;
}

TEST(SemiSharp, SurfacesPassThroughTheVertices) {
  const auto backend = make_cpu_backend();
  std::vector<NamedMesh> meshes = primal_meshes(PrimalScheme::CatmullClark);
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    meshes.push_back({"closed " + std::to_string(seed),
                      with_random_sharpness(random_closed_mesh(seed), 0.3, seed)});
    meshes.push_back(
        {"open " + std::to_string(seed), with_random_sharpness(random_open_mesh(seed), 0.3, seed)});
  }
  int semi_sharp = 0;
  for (auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    if (!has_semi_sharp(mesh)) continue;
    ++semi_sharp;
    const Fit made = fit(mesh, *backend, exact_fair());
    EXPECT_TRUE(made.interpolation.converged) << made.interpolation.error.max;
    ASSERT_TRUE(made.fair->sharp_decisions);
    const SurfaceMesh surface = evaluate(mesh, made, *backend, {.level = 1});
    for (std::size_t v = 0; v < surface.base_vertices.size(); ++v)
      EXPECT_LT(glm::distance(surface.positions[v], mesh.positions[surface.base_vertices[v]]),
                1e-11 * made.placement.diagonal);
    // Kept decisions make the same net, as frames of an animation want it.
    FitOptions again = exact_fair();
    again.fair_decisions = &made.fair->decisions;
    again.sharp_fair_decisions = &*made.fair->sharp_decisions;
    EXPECT_EQ(fit(mesh, *backend, again).fair->level_one.state, made.fair->level_one.state);
  }
  EXPECT_GE(semi_sharp, 12);
}

TEST(SemiSharp, BetweenSmoothAndSharp) {
  const auto backend = make_cpu_backend();
  const auto state_of = [&](float sharpness) {
    return fit(roof(6, sharpness), *backend, exact_fair()).fair->level_one.state;
  };
  const auto distance = [](const std::vector<dvec3>& a, const std::vector<dvec3>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      largest = std::max(largest, glm::distance(a[i], b[i]));
    return largest;
  };
  const std::vector<dvec3> smooth = state_of(0);
  EXPECT_LT(distance(state_of(1e-4f), smooth), 1e-4);
  EXPECT_GT(distance(state_of(1), smooth), 3e-3);
  // Almost sharp: the control points beside the ridge lie on its curve.
  const PolygonMesh mesh = roof(6, 9.99f);
  const std::vector<dvec3> sharp = state_of(9.99f);
  const MeshTopology topology(mesh);
  for (int32_t c = 0; c < topology.corner_count(); ++c)
    if (mesh.positions[topology.vertex_of(c)].x == 0) {
      EXPECT_LT(std::abs(sharp[c].x), 2e-3);
    }
}

// Three quarters of the turn.
TEST(SemiSharp, TurnsOverTheDistanceOfCatmullClark) {
  constexpr int kQuads = 8;
  double before = HUGE_VAL;
  for (const float sharpness : {0.0f, 1.0f, 2.0f, 3.0f, 4.0f}) {
    const PolygonMesh mesh = roof(kQuads, sharpness);
    FitOptions catmull_clark;
    catmull_clark.scheme = Scheme::CatmullClark;
    const double own = width_of_turn(mesh, kQuads, exact_fair(), 0.75);
    const double theirs = width_of_turn(mesh, kQuads, catmull_clark, 0.75);
    EXPECT_LT(own, before) << sharpness;
    EXPECT_GT(own, theirs / 1.5) << sharpness;
    EXPECT_LT(own, theirs * 1.5) << sharpness;
    before = own;
  }
}

TEST(SemiSharp, FoldNothing) {
  const auto backend = make_cpu_backend();
  for (const float sharpness : {0.5f, 1.0f, 2.0f, 4.0f, 8.0f}) {
    PolygonMesh box = creased_cube();
    for (CreaseEdge& crease : box.creases) crease.sharpness = sharpness;
    for (const PolygonMesh& mesh : {roof(6, sharpness), box}) {
      const Fit made = fit(mesh, *backend, exact_fair());
      EXPECT_EQ(SurfaceMeter(mesh, made, {}).at(3).folded_area, 0) << sharpness;
    }
  }
}

TEST(SemiSharp, TakeTheFairMethodByThemselves) {
  const auto backend = make_cpu_backend();
  std::vector<std::string> codes;
  MeshFitOptions options;
  options.fit.callbacks.warning = [&](const Warning& warning) { codes.push_back(warning.code); };
  const FittedMesh fitted = fit_mesh(roof(4, 2), "roof", *backend, options);
  EXPECT_EQ(fitted.options.method, InterpolationMethod::Fair);
  ASSERT_TRUE(fitted.choice);
  EXPECT_THAT(fitted.choice->reason, testing::HasSubstr("semi-sharp"));
  EXPECT_TRUE(codes.empty());
  // Whoever names the other one is told.
  options.method = InterpolationMethod::Progressive;
  (void)fit_mesh(roof(4, 2), "roof", *backend, options);
  EXPECT_EQ(codes, std::vector<std::string>{"semi-sharp-creases"});
  // Tags that are not looked at are none.
  options.method.reset();
  options.fit.sharp.use_tags = false;
  EXPECT_FALSE(fit_mesh(roof(4, 2), "roof", *backend, options).choice->candidates.empty());
}

TEST(SemiSharp, AreSmoothWhileTheyAreEdited) {
  const auto backend = make_cpu_backend();
  const PolygonMesh mesh = roof(4, 2);
  FitOptions options = exact_fair();
  const Fit made = fit(mesh, *backend, options);
  Editor editor(mesh, made, {1, options});
  options.obeys_semi_sharp = false;
  EXPECT_EQ(editor.fit().fair->level_one.state, fit(mesh, *backend, options).fair->level_one.state);
}

}  // namespace
}  // namespace planish::test
