// What must hold on every mesh.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "planish/doosabin/limit_masks.h"
#include "planish/pipeline/fit.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/doo_sabin_tables.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

constexpr double kPropertyRounding = 1e-12;

void expect_sums(const StencilView<double>& view, std::span<const double> weights, double sum) {
  double worst = 0;
  for (int32_t row = 0; row < view.row_count(); ++row) {
    double total = 0;
    for (int32_t k = 0; k < view.sizes[row]; ++k) total += weights[view.offsets[row] + k];
    worst = std::max(worst, std::abs(total - sum));
  }
  EXPECT_LT(worst, kPropertyRounding);
}

TEST(Properties, RowsSumToOneAndDerivativesToZero) {
  for (const auto& [name, mesh] : all_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const ChainCase c(mesh, weights, 3);
      const auto masks = limit_masks(c.subdivision);
      EXPECT_EQ(masks.view().row_count(), mesh.vertex_count());
      expect_sums(masks.view(), masks.view().weights, 1);
      for (int level = 1; level <= 3; ++level) {
        const auto step = step_table(c.subdivision, level);
        expect_sums(step.view(), step.view().weights, 1);
        const LimitRows rows(c.subdivision, level);
        const auto limit = limit_table(c.subdivision, rows);
        expect_sums(limit.view(), limit.view().weights, 1);
        expect_sums(limit.view(), limit.view().du_weights, 0);
        expect_sums(limit.view(), limit.view().dv_weights, 0);
      }
    }
  }
}

TEST(Properties, AffineMapsCommute) {
  const glm::dmat3 linear(1.2, 0.3, -0.1, -0.4, 0.9, 0.2, 0.1, 0.5, 1.4);
  const dvec3 offset(3, -2, 5);
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    PolygonMesh mapped = mesh;
    for (dvec3& p : mapped.positions) p = linear * p + offset;
    // The rest pose fixes the rules at corners: a shear changes angles.
    const EvaluateOptions options{.level = 2, .rest_positions = mesh.positions};
    const SurfaceMesh before = evaluate(mesh, *backend, options);
    const SurfaceMesh after = evaluate(mapped, *backend, options);
    ASSERT_EQ(before.positions.size(), after.positions.size());
    double worst = 0;
    for (std::size_t v = 0; v < before.positions.size(); ++v) {
      worst =
          std::max(worst, glm::distance(linear * before.positions[v] + offset, after.positions[v]));
    }
    EXPECT_LT(worst, 1e-11);  // mapped coordinates reach 15
  }
}

TEST(Properties, RelabellingPermutesTheResult) {
  for (const auto& [name, mesh] : all_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const Relabelled other = relabelled(mesh, 11);
      const std::vector<dvec3> before = limit_positions(mesh, weights, {});
      const std::vector<dvec3> after = limit_positions(other.mesh, weights, {});
      for (std::size_t v = 0; v < before.size(); ++v) {
        EXPECT_LT(glm::distance(before[v], after[other.new_index[v]]), kPropertyRounding);
      }
    }
  }
}

TEST(Properties, RelabellingPermutesTheFit) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    const Relabelled other = relabelled(mesh, 12);
    const Fit before = fit(mesh, *backend), after = fit(other.mesh, *backend);
    EXPECT_EQ(before.interpolation.iterations, after.interpolation.iterations);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      EXPECT_LT(glm::distance(before.cage.positions[v], after.cage.positions[other.new_index[v]]),
                1e-11);
    }
  }
}

TEST(Properties, BaseVerticesStayPutOverLevels) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : all_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const std::vector<dvec3> limits = limit_positions(mesh, weights, {});
      const int levels = mesh.face_count() < 40 ? kMaxLevel : 3;
      for (int level = 0; level <= levels; ++level) {
        const SurfaceMesh surface = evaluate(mesh, *backend, {.level = level, .weights = weights});
        ASSERT_EQ(surface.base_vertices.size(), limits.size());
        for (std::size_t i = 0; i < limits.size(); ++i) {
          const dvec3 expected = limits[surface.base_vertices[i]];
          EXPECT_LT(glm::distance(surface.positions[i], expected), kPropertyRounding)
              << "level " << level;
        }
      }
    }
  }
}

TEST(Properties, NormalsAreUnitAndFinite) {
  const auto backend = make_cpu_backend();
  std::vector<NamedMesh> meshes = all_meshes();
  PolygonMesh collapsed = cube();
  for (dvec3& p : collapsed.positions) p = {p.x, 2, 3};
  meshes.push_back({"all vertices on one line", collapsed});
  for (const auto& [name, mesh] : meshes) {
    for (int level = 0; level <= 3; ++level) {
      SCOPED_TRACE(name + ", level " + std::to_string(level));
      const SurfaceMesh surface = evaluate(mesh, *backend, {.level = level});
      ASSERT_EQ(surface.normals.size(), surface.positions.size());
      for (const glm::vec3& n : surface.normals) EXPECT_NEAR(glm::length(n), 1, 1e-6);
    }
  }
}

// Per base vertex, the largest angle between its normal and the Newell normals of the quads around.
std::vector<double> facet_angles(const SurfaceMesh& surface) {
  std::vector<double> angles(surface.base_vertices.size());
  for (std::int64_t f = 0; f < surface.face_count(); ++f) {
    const auto face = surface.face(f);
    const dvec3 facet = glm::cross(surface.positions[face[2]] - surface.positions[face[0]],
                                   surface.positions[face[3]] - surface.positions[face[1]]);
    for (const int32_t v : face) {
      if (v >= int32_t(angles.size())) continue;
      const dvec3 normal(surface.normals[v]);
      angles[v] = std::max(
          angles[v], std::atan2(glm::length(glm::cross(facet, normal)), glm::dot(facet, normal)));
    }
  }
  return angles;
}

// Every mode but the tangents' shrinks by 1/4 a level with the weights of 1978, the tangents by
// 1/2: angles halve. Around boundary and crease vertices they do so from above.
constexpr double kSmoothRatio = 0.55, kSharpRatio = 0.65;
constexpr double kFloatAngle = 1e-4;  // normals are stored in float

TEST(Properties, FacetNormalsConvergeToTheNormals) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : all_meshes()) {
    // Rings of two have no tangent plane, nor has a vertex held off a bent boundary; at poles the
    // first levels still tell of the ring's size.
    if (mesh.face_count() > 40 || name == "cube with split edges") continue;
    if (name == "tagged boundary vertex") continue;
    SCOPED_TRACE(name);
    const SharpFeatures features =
        find_sharp_features(mesh, MeshTopology(mesh), mesh.positions, {});
    const std::vector<double> before = facet_angles(evaluate(mesh, *backend, {.level = 5}));
    const std::vector<double> after = facet_angles(evaluate(mesh, *backend, {.level = 6}));
    for (std::size_t v = 0; v < after.size(); ++v) {
      const bool smooth = features.vertex_kinds[v] == VertexKind::Smooth;
      EXPECT_LT(after[v], 0.1) << "vertex " << v;
      EXPECT_LT(after[v], (smooth ? kSmoothRatio : kSharpRatio) * before[v] + kFloatAngle)
          << "vertex " << v;
    }
  }
}

TEST(Properties, FlatOpenGridsStayFlatAndUnfolded) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] :
       {NamedMesh{"grid", flat_grid(4, 3)}, NamedMesh{"plate with hole", plate_with_hole(5)},
        NamedMesh{"L", l_shaped_plate(2)}}) {
    for (Weights weights : kBothWeights) {
      for (BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
        FitOptions options{.weights = weights};
        options.sharp.boundary = boundary;
        const PolygonMesh cage = fit(mesh, *backend, options).cage;
        for (int level = 1; level <= kMaxLevel; ++level) {
          SCOPED_TRACE(name + ", level " + std::to_string(level));
          const SurfaceMesh surface = evaluate(cage, *backend,
                                               {.level = level,
                                                .weights = weights,
                                                .sharp = options.sharp,
                                                .rest_positions = mesh.positions});
          for (const dvec3& p : surface.positions) EXPECT_LT(std::abs(p.z), kPropertyRounding);
          for (const glm::vec3& n : surface.normals) EXPECT_GT(n.z, 1 - 1e-6f);
          for (std::int64_t f = 0; f < surface.face_count(); ++f) {
            const auto face = surface.face(f);
            for (int i = 0; i < 4; ++i) {
              const dvec3 p = surface.positions[face[i]];
              const dvec3 facet = glm::cross(surface.positions[face[(i + 1) % 4]] - p,
                                             surface.positions[face[(i + 3) % 4]] - p);
              ASSERT_GT(facet.z, 0) << "face " << f;
            }
          }
        }
      }
    }
  }
}

TEST(Properties, CreasedCubeIsReproducedWithoutIterating) {
  const PolygonMesh mesh = creased_cube();
  const auto backend = make_cpu_backend();
  for (Weights weights : kBothWeights) {
    const Fit result = fit(mesh, *backend, {.weights = weights});
    EXPECT_EQ(result.interpolation.iterations, 0);
    EXPECT_TRUE(result.interpolation.converged);
    for (std::size_t v = 0; v < 8; ++v) {
      EXPECT_LT(glm::distance(result.cage.positions[v], mesh.positions[v]), kPropertyRounding);
    }
    for (int level = 1; level <= 4; ++level) {
      const SurfaceMesh surface =
          evaluate(result.cage, *backend, {.level = level, .weights = weights});
      for (std::size_t v = 0; v < surface.positions.size(); ++v) {
        // Each position lies on a face of the cube, each normal is that face's.
        const dvec3 n(surface.normals[v]);
        EXPECT_NEAR(std::max({std::abs(n.x), std::abs(n.y), std::abs(n.z)}), 1, 1e-6);
        EXPECT_NEAR(glm::dot(n, surface.positions[v]), 1, 1e-6);
      }
    }
  }
}

TEST(Properties, TaggedVertexWithoutSharpEdgesIsATipThatTheSurfaceReaches) {
  PolygonMesh mesh = cube();
  mesh.corners.push_back({7});
  const auto backend = make_cpu_backend();
  double before = 0;
  for (int level = 1; level <= kMaxLevel; ++level) {
    const SurfaceMesh surface = evaluate(mesh, *backend, {.level = level});
    const dvec3 tip = surface.positions[7];
    EXPECT_LT(glm::distance(tip, mesh.positions[7]), kPropertyRounding);
    EXPECT_LT(glm::distance(dvec3(surface.normals[7]), glm::normalize(dvec3(1))), 1e-6);
    double reach = 0;
    for (std::int64_t f = 0; f < surface.face_count(); ++f) {
      const auto face = surface.face(f);
      if (std::count(face.begin(), face.end(), 7) == 0) continue;
      for (const int32_t v : face) {
        reach = std::max(reach, glm::distance(surface.positions[v], tip));
      }
    }
    if (level > 1) {
      EXPECT_LT(reach, 0.6 * before) << "level " << level;
    }
    before = reach;
  }
}

}  // namespace
}  // namespace planish::test
