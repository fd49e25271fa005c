#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "features/shapes.h"
#include "planish/features/find_features.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

EdgeSet sharp_edges(const PolygonMesh& mesh) { return set_of(find_features(mesh).sharp_edges()); }

EdgeSet expected_edges(const FeatureCase& shape) {
  EdgeSet edges;
  for (const FeatureEdge& edge : find_features(shape.mesh).edges)
    if (shape.is_sharp(shape.mesh.positions[edge.v0], shape.mesh.positions[edge.v1]))
      edges.insert(std::minmax(edge.v0, edge.v1));
  return edges;
}

// Sharp edges as pairs of places, so that meshes of the same shape can be compared.
using Places = std::set<std::array<double, 6>>;

Places sharp_places(const PolygonMesh& mesh) {
  // To a grid that is far wider than rounding and far narrower than an edge.
  const auto rounded = [](double x) { return std::round(x * 1e5) / 1e5 + 0.0; };
  Places places;
  for (const auto& [v, w] : sharp_edges(mesh)) {
    std::array<double, 3> a{}, b{};
    for (int i = 0; i < 3; ++i) {
      a[i] = rounded(mesh.positions[v][i]);
      b[i] = rounded(mesh.positions[w][i]);
    }
    if (b < a) std::swap(a, b);
    places.insert({a[0], a[1], a[2], b[0], b[1], b[2]});
  }
  return places;
}

std::vector<FeatureCase> all_cases() {
  std::vector<FeatureCase> cases = tuned_cases();
  for (FeatureCase& shape : held_out_cases()) cases.push_back(std::move(shape));
  return cases;
}

void expect_own_edges(const std::vector<FeatureCase>& cases) {
  std::size_t lost = 0;
  for (const FeatureCase& shape : cases) {
    const EdgeSet found = sharp_edges(shape.mesh), expected = expected_edges(shape);
    EXPECT_EQ(found, expected) << shape.name << ": " << found.size() << " of " << expected.size();
    lost += found != expected;
  }
  EXPECT_EQ(lost, 0u) << "of " << cases.size();
}

TEST(FindFeatures, FindsTheSharpEdgesOfShapes) { expect_own_edges(tuned_cases()); }

TEST(FindFeatures, FindsThoseOfShapesThatWereHeldOut) { expect_own_edges(held_out_cases()); }

TEST(FindFeatures, DoNotDependOnOrderPlaceSizeNorHand) {
  for (const FeatureCase& shape : all_cases()) {
    const EdgeSet own = sharp_edges(shape.mesh);
    for (const double scale : {1e-3, 1e3})
      EXPECT_EQ(sharp_edges(moved(shape.mesh, [&](const auto& p) { return scale * p; })), own)
          << shape.name << " x " << scale;
    const glm::dvec3 far(1e3, -2e3, 500);
    EXPECT_EQ(sharp_edges(moved(shape.mesh, [&](const auto& p) { return p + far; })), own)
        << shape.name << ", far away";
    EXPECT_EQ(sharp_edges(turned(shape.mesh)), own) << shape.name << ", turned";
    EXPECT_EQ(sharp_edges(mirrored(shape.mesh)), own) << shape.name << ", mirrored";
    EXPECT_EQ(sharp_edges(jittered(shape.mesh, 1e-12, 3)), own) << shape.name << ", moved a little";
    const Relabelled other = relabelled(shape.mesh, 5);
    EdgeSet renamed;
    for (const auto& [v, w] : own)
      renamed.insert(std::minmax(other.new_index[v], other.new_index[w]));
    EXPECT_EQ(sharp_edges(other.mesh), renamed) << shape.name << ", in another order";
  }
}

TEST(FindFeatures, DoNotDependOnHowPlanesAreCut) {
  std::vector<FeatureCase> cases = all_cases();
  // Polygons, fans and two cuttings by lot of each come one after another.
  for (std::size_t i = 0; i < cases.size(); i += 4)
    for (std::size_t k = 1; k < 4; ++k)
      EXPECT_EQ(sharp_places(cases[i + k].mesh), sharp_places(cases[i].mesh)) << cases[i + k].name;
}

TEST(FindFeatures, DoNotDependOnWhatElseIsThere) {
  const PolygonMesh ball = moved(icosphere(2), [](const auto& p) { return 5.0 * p + 20.0; });
  for (const FeatureCase& shape : all_cases()) {
    const PolygonMesh both[] = {shape.mesh, ball};
    EXPECT_EQ(sharp_edges(merged_meshes(both).mesh), sharp_edges(shape.mesh)) << shape.name;
  }
}

std::size_t corner_count(const PolygonMesh& mesh) { return find_features(mesh).corners.size(); }

TEST(FindFeatures, FindsTheCornersOfSheets) {
  for (const auto& [sides, corners] : {std::pair(4, 4u), {5, 5u}, {6, 6u}, {8, 0u}, {24, 0u}})
    EXPECT_EQ(corner_count(single_polygon(sides)), corners) << sides;
  EXPECT_EQ(corner_count(flat_grid(5, 3)), 4u);
  EXPECT_EQ(corner_count(l_shaped_plate(2)), 6u);
  const auto l = make_mesh({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}},
                           {{0, 1, 2, 3, 4, 5}});
  EXPECT_EQ(corner_count(l), 6u);
  EXPECT_EQ(corner_count(in_fans(l)), 6u);
  // A T with a straight corner, 5.
  PolygonMesh t = single_polygon(9);
  t.positions = {{1, 0, 0},   {2, 0, 0}, {2, 2, 0}, {3, 2, 0}, {3, 3, 0},
                 {1.5, 3, 0}, {0, 3, 0}, {0, 2, 0}, {1, 2, 0}};
  EXPECT_EQ(find_features(t).corners, (std::vector<std::int32_t>{0, 1, 2, 3, 4, 6, 7, 8}));
  EXPECT_EQ(find_features(cut_by_lot(t, 3)).corners, find_features(t).corners);
  // Bent sheets have corners, too; their boundaries turn little elsewhere.
  EXPECT_EQ(corner_count(grid(8, 8,
                              [](double x, double y) {
                                return glm::dvec3(x, y, 0.04 * (x - 4) * (x - 4) + 0.02 * x * y);
                              })),
            4u);
}

// Sides of one, two and three edges; above six an outline is as round as a circle's samples.
TEST(FindFeatures, FindsTheCornersOfFlatOutlines) {
  for (const std::int32_t sides : {3, 4, 5, 6, 8, 12}) {
    for (std::int32_t edges = 1; edges <= 3; ++edges) {
      PolygonMesh mesh;
      std::vector<std::int32_t> face, corners;
      const auto corner = [&](std::int32_t i) {
        const double angle = 2 * M_PI * i / sides;
        return glm::dvec3(std::cos(angle), std::sin(angle), 0);
      };
      for (std::int32_t i = 0; i < sides; ++i) {
        if (sides <= 6) corners.push_back(mesh.vertex_count());
        for (std::int32_t k = 0; k < edges; ++k) {
          face.push_back(mesh.vertex_count());
          mesh.positions.push_back(
              glm::mix(corner(i), corner(i + 1), static_cast<double>(k) / edges));
        }
      }
      mesh.add_face(face);
      EXPECT_EQ(find_features(mesh).corners, corners) << sides << " sides of " << edges;
    }
  }
}

TEST(FindFeatures, FindsTipsAndNoPoles) {
  for (const int n : {8, 12, 32})
    for (const double h : {1.0, 2.0, 4.0})
      EXPECT_EQ(find_features(cone(n, h)).corners, (std::vector<std::int32_t>{n}))
          << n << " x " << h;
  for (const FeatureCase& shape : all_cases()) {
    if (!shape.name.starts_with("sphere") && !shape.name.starts_with("ico")) continue;
    EXPECT_THAT(find_features(shape.mesh).corners, ::testing::IsEmpty()) << shape.name;
  }
}

TEST(FindFeatures, TakesTagsAsTheyAre) {
  PolygonMesh mesh = icosphere(2);
  const auto face = mesh.face(7);
  mesh.creases = {{face[0], face[1]}};
  mesh.corners = {{face[2]}};
  const Features features = find_features(mesh);
  const std::vector<CreaseEdge> sharp = features.sharp_edges();
  ASSERT_EQ(sharp.size(), 1u);
  EXPECT_EQ(std::minmax(sharp[0].v0, sharp[0].v1), std::minmax(face[0], face[1]));
  EXPECT_THAT(features.corners, ::testing::Contains(face[2]));
}

TEST(FindFeatures, SaysWhy) {
  for (const FeatureEdge& edge : find_features(cube()).edges) {
    EXPECT_NEAR(edge.turn, 90, 1e-9);
    EXPECT_EQ(edge.reason, FeatureReason::Jump);
    EXPECT_GE(edge.jump, 60);
  }
  for (const FeatureEdge& edge : find_features(icosphere(2)).edges) {
    EXPECT_EQ(edge.reason, FeatureReason::Explained);
    EXPECT_LT(edge.jump, edge.turn);
  }
}

TEST(FindFeatures, LeavesNoisySpheresSmooth) {
  const PolygonMesh ball = icosphere(3);
  for (const double noise : {0.005, 0.01, 0.02})
    EXPECT_LE(sharp_edges(jittered(ball, noise, 7)).size(), 19u) << noise;  // a hundredth
}

// A cube of side 1, each side of n x n quads.
PolygonMesh gridded_cube(int n) {
  PolygonMesh mesh;
  std::map<std::array<int, 3>, std::int32_t> vertices;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [place, is_new] = vertices.try_emplace(at, mesh.vertex_count());
    if (is_new) mesh.positions.push_back(glm::dvec3(at[0], at[1], at[2]) / double(n));
    return place->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int end : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          std::vector<std::int32_t> face;
          for (const auto& [di, dj] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
            std::array<int, 3> at{};
            at[axis] = end;
            at[(axis + 1) % 3] = i + di;
            at[(axis + 2) % 3] = j + dj;
            face.push_back(vertex(at));
          }
          if (end == 0) std::ranges::reverse(face);
          mesh.add_face(face);
        }
  return mesh;
}

TEST(FindFeatures, KeepsTheEdgesOfNoisyBoxes) {
  const PolygonMesh box = gridded_cube(6);
  const auto is_rim = [&](const auto& edge) {
    const glm::dvec3 middle = (box.positions[edge.first] + box.positions[edge.second]) / 2.0;
    int ends = 0;
    for (int i = 0; i < 3; ++i) ends += middle[i] < 1e-9 || middle[i] > 1 - 1e-9;
    return ends == 2;
  };
  for (const double noise : {0.0, 0.001, 0.005, 0.01}) {
    const EdgeSet found = sharp_edges(jittered(box, noise, 2));
    EXPECT_EQ(found.size(), 72u) << noise;
    EXPECT_TRUE(std::ranges::all_of(found, is_rim)) << noise;
  }
}

TEST(FindFeatures, RefusesRulesThatAreOutOfRange) {
  FeatureRules rules;
  rules.flat = -1;
  EXPECT_THAT(message_of(ErrorCode::InvalidArgument, [&] { (void)find_features(cube(), rules); }),
              ::testing::HasSubstr("flat"));
}

// Of each family bodies by lot, each as it is and in other meshes. At length: features_sweep.
void expect_edges_of(const std::vector<BodyFamily>& families) {
  constexpr std::uint32_t kBodies = 6;
  constexpr int kMeshes = 4;
  for (const BodyFamily& family : families)
    for (std::uint32_t seed = 1; seed <= kBodies; ++seed) {
      Lot lot(seed);
      const Body body = family.draw(lot);
      for (int k = 0; k < kMeshes; ++k) {
        std::string what;
        const KnownMesh known = k == 0 ? known_mesh(body) : presented(body, lot, what);
        EXPECT_EQ(sharp_edges(known.mesh), set_of(known.sharp))
            << family.name << ", seed " << seed << what;
      }
    }
}

TEST(FeatureFamilies, HaveTheirEdgesInEveryMesh) { expect_edges_of(known_families()); }

TEST(FeatureFamilies, HaveThemWhereTheyCameLater) { expect_edges_of(held_out_families()); }

std::vector<KeptPlane> planes_of(const PolygonMesh& mesh) {
  const MeshTopology topology(mesh);
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  for (std::int32_t e = 0; e < topology.edge_count(); ++e)
    is_sharp[e] = topology.is_boundary_edge(e) ? 1 : 0;
  for (const CreaseEdge& edge : find_features(mesh, topology).sharp_edges())
    is_sharp[topology.find_edge(edge.v0, edge.v1)] = 1;
  return find_kept_planes(mesh, topology, is_sharp);
}

// Four vertices of each of the six planes, however the faces are cut.
TEST(KeptPlanes, AreThoseBesideFillets) {
  for (const int steps : {3, 4, 6, 12})
    for (const double radius : {0.1, 0.3, 0.8}) {
      SCOPED_TRACE(::testing::Message() << steps << " steps, radius " << radius);
      const PolygonMesh box = rounded_box({1, 0.7, 0.4}, radius, steps);
      for (const PolygonMesh& mesh : {box, in_fans(box), cut_by_lot(box, 1), cut_by_lot(box, 2),
                                      turned(box), relabelled(box, 3).mesh}) {
        const std::vector<KeptPlane> planes = planes_of(mesh);
        EXPECT_EQ(planes.size(), 24U);
        for (const auto& [vertex, face] : planes) {
          const auto corners = mesh.face(face);
          EXPECT_NE(std::ranges::find(corners, vertex), corners.end());
          // No face of a fillet is as large.
          EXPECT_GT(glm::length(area_vector(mesh.positions, corners)), 0.49 * 4 * 0.7 * 0.4);
        }
      }
    }
}

// A quarter round at one edge of a box, and two half rounds: with their sharp rims.
TEST(KeptPlanes, AreNoneOfWhatIsSharpOrRound) {
  for (const auto& cases : {tuned_cases(), held_out_cases()})
    for (const FeatureCase& c : cases) {
      const std::size_t expected = c.name.starts_with("slot")          ? 8
                                   : c.name.starts_with("rounded box") ? 4
                                                                       : 0;
      EXPECT_EQ(planes_of(c.mesh).size(), expected) << c.name;
    }
}

}  // namespace
}  // namespace planish::test
