// The oracles against each other and against what is known in closed form: were two of them wrong,
// they would have to be wrong alike although they share no rule.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "support/doo_sabin_oracles.h"
#include "support/mesh_catalogue.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

// Coordinates are about 1 to 5 in size; sums of up to 360 terms.
constexpr double kOracleRounding = 1e-12;

// The quad split's face for each point of the explicit mesh, carried from level to level: the
// point made for corner p of polygon F belongs to the child, at the vertex that F stands for, of
// the face that p stands for.
class DualCorrespondence {
 public:
  explicit DualCorrespondence(std::size_t level_1_points) : face_of_point_(level_1_points) {
    for (std::size_t i = 0; i < level_1_points; ++i) face_of_point_[i] = int32_t(i);
  }
  void refine(const ExplicitMesh& before, const QuadSplitOracle& oracle,
              const ExplicitMesh& after) {
    std::vector<int32_t> next;
    for (const auto [f, corner] : after.origins) {
      const int32_t q = face_of_point_[before.faces[f][corner]];
      const auto& quad = oracle.faces()[q];
      const auto at = std::find(quad.begin(), quad.end(), vertex_of(before, oracle, f));
      next.push_back(4 * q + int32_t(at - quad.begin()));
    }
    face_of_point_ = next;
  }
  [[nodiscard]] int32_t face_of(int32_t point) const { return face_of_point_[point]; }
  // The vertex whose faces are those that stand for polygon f's points.
  [[nodiscard]] int32_t vertex_of(const ExplicitMesh& mesh, const QuadSplitOracle& oracle,
                                  int32_t f) const {
    for (int32_t v : oracle.faces()[face_of_point_[mesh.faces[f][0]]]) {
      const auto& ring = oracle.sectors(v).front().faces;
      const bool same = ring.size() == mesh.faces[f].size() &&
                        std::all_of(mesh.faces[f].begin(), mesh.faces[f].end(), [&](int32_t p) {
                          return std::count(ring.begin(), ring.end(), face_of_point_[p]) == 1;
                        });
      if (same) return v;
    }
    ADD_FAILURE() << "polygon " << f << " has no vertex";
    return -1;
  }

 private:
  std::vector<int32_t> face_of_point_;
};

void expect_same_level(const ExplicitMesh& mesh, const QuadSplitOracle& oracle,
                       const DualCorrespondence& dual) {
  ASSERT_EQ(mesh.points.size(), oracle.faces().size());
  double worst = 0, worst_limit = 0;
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    worst = std::max(worst, distance(mesh.points[p], oracle.face_point(dual.face_of(int32_t(p)))));
  }
  for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
    const int32_t vertex = dual.vertex_of(mesh, oracle, int32_t(f));
    worst_limit = std::max(worst_limit,
                           distance(face_centroid(mesh, int32_t(f)), oracle.limit_point(vertex)));
  }
  EXPECT_LT(worst, kOracleRounding);
  EXPECT_LT(worst_limit, kOracleRounding);
}

TEST(Oracles, QuadSplitIsTheDualOfExplicitSubdivision) {
  for (const auto& [name, mesh] : closed_meshes()) {
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      ExplicitMesh level = explicit_step(explicit_mesh(mesh), weights);
      QuadSplitOracle oracle(mesh, weights, BoundaryRule::Edge);
      DualCorrespondence dual(level.points.size());
      expect_same_level(level, oracle, dual);
      for (int l = 2; l <= 3; ++l) {
        const ExplicitMesh next = explicit_step(level, weights);
        dual.refine(level, oracle, next);
        oracle.refine();
        level = next;
        expect_same_level(level, oracle, dual);
      }
    }
  }
}

TEST(Oracles, VertexPolygonsKeepTheirCentroidAndShrinkToIt) {
  for (const auto& [name, mesh] : closed_meshes()) {
    if (mesh.vertex_count() > 100) continue;
    for (Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      ExplicitMesh level = explicit_step(explicit_mesh(mesh), weights);
      const std::vector<dvec3> limits = explicit_limit_points(level);
      std::vector<double> first_size;
      const int levels = 4;
      // The slowest mode of an n-gon: 1/2 but for two-gons (3/4) and, averaged, large n (3/4).
      const double shrink = std::pow(0.75, levels - 1);
      const auto sizes = [&](const ExplicitMesh& m) {
        std::vector<double> result;
        for (int32_t polygon : m.polygon_of_base_vertex) {
          double size = 0;
          for (int32_t p : m.faces[polygon]) {
            size += std::pow(distance(m.points[p], face_centroid(m, polygon)), 2);
          }
          result.push_back(std::sqrt(size));
        }
        return result;
      };
      first_size = sizes(level);
      for (int l = 2; l <= levels; ++l) level = explicit_step(level, weights);
      const std::vector<dvec3> later = explicit_limit_points(level);
      const std::vector<double> last_size = sizes(level);
      for (std::size_t v = 0; v < limits.size(); ++v) {
        EXPECT_LT(distance(limits[v], later[v]), kOracleRounding);
        EXPECT_LE(last_size[v], shrink * first_size[v] + kOracleRounding);
      }
    }
  }
}

// Limit points of all vertices at every level up to `levels`: those of a level must stay.
void expect_no_drift(const PolygonMesh& mesh, Weights weights, BoundaryRule rule, int levels) {
  QuadSplitOracle oracle(mesh, weights, rule);
  std::vector<dvec3> limits;
  double worst = 0;
  for (int level = 1; level <= levels; ++level) {
    for (int32_t v = 0; v < oracle.vertex_count(); ++v) {
      const dvec3 limit = oracle.limit_point(v);
      if (v < int32_t(limits.size())) {
        worst = std::max(worst, distance(limits[v], limit));
      } else {
        limits.push_back(limit);
      }
    }
    if (level < levels) oracle.refine();
  }
  EXPECT_LT(worst, kOracleRounding);
}

TEST(Oracles, LimitPointsStayPutOnOpenAndSharpMeshes) {
  std::vector<NamedMesh> meshes = open_meshes();
  for (NamedMesh& mesh : sharp_meshes()) meshes.push_back(std::move(mesh));
  for (const auto& [name, mesh] : meshes) {
    for (Weights weights : kBothWeights) {
      for (BoundaryRule rule : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
        SCOPED_TRACE(name);
        expect_no_drift(mesh, weights, rule, mesh.face_count() < 10 ? 5 : 3);
      }
    }
  }
}

TEST(Oracles, OpenGridsAreTensorProductBSplines) {
  const int columns = 5, rows = 4;
  const PolygonMesh mesh = jittered(flat_grid(columns, rows), 0.3, 1);
  const BSplineOracle spline(mesh, columns, rows);
  // Parameters ride along: a grid whose positions are its parameters is reproduced by B-splines.
  const PolygonMesh parameters = flat_grid(columns, rows);
  for (Weights weights : kBothWeights) {
    QuadSplitOracle oracle(mesh, weights, BoundaryRule::EdgeAndCorner);
    QuadSplitOracle where(parameters, weights, BoundaryRule::EdgeAndCorner);
    for (int level = 1; level <= 4; ++level) {
      double worst = 0, worst_normal = 0;
      for (int32_t v = 0; v < oracle.vertex_count(); ++v) {
        const dvec3 uv = where.limit_point(v);
        worst = std::max(worst, distance(oracle.limit_point(v), spline.point(uv.x, uv.y)));
        for (std::size_t s = 0; s < oracle.sectors(v).size(); ++s) {
          const double error = distance(oracle.normal(v, s), spline.normal(uv.x, uv.y));
          worst_normal = std::max(worst_normal, error);
        }
      }
      EXPECT_LT(worst, kOracleRounding) << "level " << level;
      EXPECT_LT(worst_normal, 1e-11) << "level " << level;
      oracle.refine();
      where.refine();
    }
  }
}

TEST(Oracles, FlatMeshesKeepAnUprightNormal) {
  for (const auto& [name, mesh] :
       {NamedMesh{"grid", flat_grid(3, 2)}, NamedMesh{"plate with hole", plate_with_hole(5)},
        NamedMesh{"L", l_shaped_plate(1)}}) {
    for (Weights weights : kBothWeights) {
      for (BoundaryRule rule : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
        SCOPED_TRACE(name);
        QuadSplitOracle oracle(mesh, weights, rule);
        for (int level = 1; level <= 4; ++level) {
          for (int32_t v = 0; v < oracle.vertex_count(); ++v) {
            for (std::size_t s = 0; s < oracle.sectors(v).size(); ++s) {
              EXPECT_LT(distance(oracle.normal(v, s), dvec3(0, 0, 1)), kOracleRounding);
            }
          }
          for (const auto& q : oracle.faces()) {
            const dvec3 a = oracle.limit_point(q[0]);
            for (int i = 1; i < 3; ++i) {
              const dvec3 b = oracle.limit_point(q[i]), c = oracle.limit_point(q[i + 1]);
              EXPECT_GT(cross(b - a, c - a).z, 0);
            }
          }
          oracle.refine();
        }
      }
    }
  }
}

TEST(Oracles, CreasedCubeIsItsOwnSurface) {
  const PolygonMesh mesh = creased_cube();
  for (Weights weights : kBothWeights) {
    QuadSplitOracle oracle(mesh, weights, BoundaryRule::Edge);
    for (int level = 1; level <= 4; ++level) {
      for (int32_t v = 0; v < oracle.vertex_count(); ++v) {
        const dvec3 p = abs(oracle.limit_point(v));
        EXPECT_LT(std::abs(std::max({p.x, p.y, p.z}) - 1), kOracleRounding);
        if (v < 8) {
          EXPECT_LT(distance(oracle.limit_point(v), mesh.positions[v]), kOracleRounding);
        }
      }
      oracle.refine();
    }
  }
}

}  // namespace
}  // namespace planish::test
