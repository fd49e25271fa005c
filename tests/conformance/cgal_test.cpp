// CGAL's Doo-Sabin subdivision, which uses the weights of 1978, against our first level.

#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/subdivision_method_3.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "support/doo_sabin_tables.h"
#include "support/mesh_catalogue.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;
using CgalMesh = CGAL::Surface_mesh<CGAL::Simple_cartesian<double>::Point_3>;

CgalMesh cgal_mesh(const PolygonMesh& mesh) {
  CgalMesh result;
  for (const dvec3& p : mesh.positions) result.add_vertex({p.x, p.y, p.z});
  for (const auto& face : faces_of(mesh)) {
    std::vector<CgalMesh::Vertex_index> corners;
    for (int32_t v : face) corners.push_back(CgalMesh::Vertex_index(std::uint32_t(v)));
    EXPECT_NE(result.add_face(corners), CgalMesh::null_face());
  }
  return result;
}

std::vector<dvec3> points_of(const CgalMesh& mesh) {
  std::vector<dvec3> points;
  for (const auto vertex : mesh.vertices()) {
    const auto& p = mesh.point(vertex);
    points.emplace_back(p.x(), p.y(), p.z());
  }
  return points;
}

// CGAL numbers its points otherwise: each of ours must have one of its own within rounding.
TEST(Cgal, FirstLevelPointsAgree) {
  for (const auto& [name, mesh] : closed_meshes()) {
    SCOPED_TRACE(name);
    CgalMesh refined = cgal_mesh(mesh);
    CGAL::Subdivision_method_3::DooSabin_subdivision(refined,
                                                     CGAL::parameters::number_of_iterations(1));
    std::vector<dvec3> theirs = points_of(refined);
    const ChainCase c(mesh, Weights::DooSabin, 1);
    const std::vector<dvec3> ours = applied(step_table(c.subdivision, 1), mesh.positions);
    ASSERT_EQ(ours.size(), theirs.size());
    for (const dvec3& p : ours) {
      const auto nearest = std::min_element(theirs.begin(), theirs.end(), [&](auto& a, auto& b) {
        return glm::distance(a, p) < glm::distance(b, p);
      });
      EXPECT_LT(glm::distance(*nearest, p), 1e-12);
      theirs.erase(nearest);
    }
  }
}

}  // namespace
}  // namespace planish::test
