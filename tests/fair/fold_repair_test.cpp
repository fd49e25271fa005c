#include "planish/fair/fold_cure.h"

#include <gtest/gtest.h>

#include <numeric>

#include "fair/fair_case.h"
#include "planish/fair/fair_topology.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

using glm::dvec3;
using std::int32_t;

struct RepairCase {
  explicit RepairCase(const PolygonMesh& mesh)
      : c(mesh),
        topology(make_fair_topology(c.mesh, c.subdivision)),
        face_normals(unit_face_normals(topology, c.given)),
        offsets(c.net(0).state),
        halvings(c.given.size(), 0) {
    for (int32_t i = 0; i < topology.corner_count; ++i) {
      offsets[i] -= c.given[topology.corner_vertices[i]];
    }
  }
  FoldCount repair() { return repair_folds(topology, c.given, face_normals, offsets, halvings); }
  void scale(int32_t vertex, double factor) {
    for (int32_t i = topology.ring_offsets[vertex]; i < topology.ring_offsets[vertex + 1]; ++i) {
      offsets[topology.ring_corners[i]] *= factor;
    }
  }

  FairCase c;
  FairTopology topology;
  std::vector<dvec3> face_normals, offsets;
  std::vector<std::uint8_t> halvings;
};

TEST(FoldRepair, LeavesSoundNetsAlone) {
  RepairCase r(icosphere(2));
  const std::vector<dvec3> before = r.offsets;
  const FoldCount left = r.repair();
  EXPECT_EQ(left.edges + left.faces, 0);
  EXPECT_EQ(r.offsets, before);
  EXPECT_EQ(std::accumulate(r.halvings.begin(), r.halvings.end(), 0), 0);
}

TEST(FoldRepair, DrawsAnOverlappingPolygonIn) {
  RepairCase r(icosphere(2));
  const std::vector<dvec3> sound = r.offsets;
  r.scale(17, 6);
  const FoldCount left = r.repair();
  EXPECT_EQ(left.edges + left.faces, 0);
  EXPECT_GE(r.halvings[17], 1);
  // Only its neighbourhood, each polygon by the powers of a half that are told.
  int touched = 0;
  for (int32_t v = 0; v < r.topology.vertex_count; ++v) {
    touched += r.halvings[v] > 0;
    const double factor = std::pow(0.5, r.halvings[v]) * (v == 17 ? 6 : 1);
    for (int32_t i = r.topology.ring_offsets[v]; i < r.topology.ring_offsets[v + 1]; ++i) {
      const int32_t corner = r.topology.ring_corners[i];
      EXPECT_LT(glm::distance(r.offsets[corner], factor * sound[corner]), 1e-15);
    }
  }
  EXPECT_LE(touched, 7);
}

TEST(FoldRepair, CountsWhatShrinkingCannotCure) {
  RepairCase r(icosphere(2));
  r.scale(17, -1);  // turned over: the polygon's centre stays turned at any size
  const FoldCount left = r.repair();
  EXPECT_GT(left.edges + left.faces, 0);
  EXPECT_EQ(r.halvings[17], 3);
}

}  // namespace
}  // namespace planish::test
