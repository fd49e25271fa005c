#include "planish/mesh/detect_creases.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "mesh/test_meshes.h"
#include "planish/core/error.h"

namespace planish {
namespace {

TEST(DetectCreases, TagsEveryEdgeOfACubeAndNoCorner) {
  // Three creases meet at each vertex: corners by themselves.
  const PolygonMesh mesh = with_detected_creases(test::cube());
  EXPECT_EQ(mesh.creases.size(), 12u);
  EXPECT_TRUE(mesh.corners.empty());
}

TEST(DetectCreases, FollowsTheThreshold) {
  EXPECT_TRUE(with_detected_creases(test::cube(), {.dihedral_degrees = 91}).creases.empty());
  EXPECT_EQ(with_detected_creases(test::cube(), {.dihedral_degrees = 89}).creases.size(), 12u);
  EXPECT_THROW((void)with_detected_creases(test::cube(), {.dihedral_degrees = 181}), Error);
}

// Two triangles that turn by `degrees` at their common edge.
PolygonMesh hinge(double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  PolygonMesh mesh;
  mesh.positions = {
      {0, 0, 0}, {1, 0, 0}, {0, -3, 0}, {1, 2 * std::cos(angle), 2 * std::sin(angle)}};
  mesh.add_face(std::array{0, 2, 1});
  mesh.add_face(std::array{0, 1, 3});
  return mesh;
}

TEST(DetectCreases, DecidesBesideTheThresholdWhateverTheAngle) {
  for (const double threshold : {0.0, 0.001, 30.0, 89.9, 90.0, 120.0, 179.9}) {
    for (const double beside : {-10.0, -1e-3, -1e-6, 1e-6, 1e-3, 10.0}) {
      const double degrees = threshold + beside;
      if (degrees < 0 || degrees > 180) continue;
      EXPECT_EQ(
          with_detected_creases(hinge(degrees), {.dihedral_degrees = threshold}).creases.size(),
          beside > 0 ? 1u : 0u)
          << degrees << " degrees, threshold " << threshold;
    }
  }
}

// A roof ridge over `edges` edges: 33 degrees at the ridge, less everywhere else.
PolygonMesh ridge(int edges, double height = 0.3) {
  PolygonMesh mesh = test::grid(4, 4 + edges);
  for (auto& p : mesh.positions) {
    if (p.x == 2 && p.y >= 2 && p.y <= 2 + edges) p.z = height;
  }
  return mesh;
}

// However steep: 90 degrees at the ridge, less than 60 elsewhere.
TEST(DetectCreases, ASingleEdgeIsNoise) {
  for (const int edges : {1, 2, 3})
    EXPECT_EQ(with_detected_creases(ridge(edges, 1.0), {.dihedral_degrees = 60}).creases.size(),
              edges == 1 ? 0u : static_cast<std::size_t>(edges));
}

TEST(DetectCreases, OneFlagAVertexIsWanted) {
  const std::vector<std::uint8_t> flags(7, 1);
  EXPECT_THROW((void)with_detected_creases(test::cube(), {.smooth_vertices = flags}), Error);
}

TEST(DetectCreases, DropsALoneEdge) {
  EXPECT_TRUE(with_detected_creases(ridge(1)).creases.empty());
  EXPECT_EQ(with_detected_creases(ridge(2)).creases.size(), 2u);
  PolygonMesh tagged = ridge(1);
  tagged.creases = {{12, 17, kInfiniteSharpness}};
  EXPECT_EQ(with_detected_creases(tagged).creases.size(), 1u) << "the mesh's own tag stays";
}

TEST(DetectCreases, ReplacesALowerSharpness) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1, 3.0f}, {0, 2, 12.0f}};
  const PolygonMesh result = with_detected_creases(mesh);
  EXPECT_EQ(result.creases.size(), 12u);
  for (const CreaseEdge& crease : result.creases) EXPECT_GE(crease.sharpness, kInfiniteSharpness);
}

TEST(DetectCreases, TagsSharpTurnsAsCorners) {
  // A flat square plate over a plain: its outline is a crease that turns by 90 degrees.
  PolygonMesh mesh = test::grid(6, 6);
  for (auto& p : mesh.positions) {
    if (p.x >= 2 && p.x <= 4 && p.y >= 2 && p.y <= 4) p.z = 3;
  }
  const PolygonMesh result = with_detected_creases(mesh);
  const auto has_corner = [&](int x, int y) {
    for (const CornerVertex& corner : result.corners) {
      if (corner.vertex == y * 7 + x) return true;
    }
    return false;
  };
  EXPECT_TRUE(has_corner(0, 0)) << "the boundary turns there";
  EXPECT_FALSE(has_corner(3, 0)) << "the boundary is straight there";
  EXPECT_FALSE(result.creases.empty());
}

// A needle that is turned about its length by 60 degrees in flat surroundings: both long edges are
// sharp and meet at its tip, vertex 0.
PolygonMesh turned_needle() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0},        {5, -6, 0}, {10, -0.21, -0.37},
                    {10, 0.21, 0.37}, {5, 6, 0},  {-5, 0, 0}};
  for (int i = 1; i <= 5; ++i) mesh.add_face(std::array{0, i, i % 5 + 1});
  return mesh;
}

TEST(DetectCreases, DropsOneOfTwoEdgesThatFoldALineBack) {
  PolygonMesh mesh = turned_needle();
  EXPECT_EQ(with_detected_creases(mesh).creases.size(), 1u);
  mesh.creases = {{0, 2, kInfiniteSharpness}, {0, 3, kInfiniteSharpness}};
  EXPECT_EQ(with_detected_creases(mesh).creases.size(), 2u) << "the mesh's own tags stay";
}

TEST(DetectCreases, KeepsTheEdgesOfASpike) {
  // Five edges that enclose 7 degrees at the tip.
  PolygonMesh mesh;
  mesh.positions.emplace_back(0.0, 0.0, 10.0);
  for (int i = 0; i < 5; ++i) {
    const double angle = 2 * std::numbers::pi * i / 5;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0.0);
  }
  for (int i = 1; i <= 5; ++i) mesh.add_face(std::array{0, i, i % 5 + 1});
  EXPECT_EQ(with_detected_creases(mesh).creases.size(), 5u);
}

// A cylinder of so many strips, its caps as single polygons.
PolygonMesh prism(int n, double height) {
  PolygonMesh mesh;
  std::vector<std::int32_t> bottom, top;
  for (const double z : {0.0, height}) {
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(std::cos(angle), std::sin(angle), z);
    }
  }
  for (int i = 0; i < n; ++i) {
    const int next = (i + 1) % n;
    mesh.add_face(std::array{i, next, n + next});
    mesh.add_face(std::array{i, n + next, n + i});
    bottom.push_back(n - 1 - i);
    top.push_back(n + i);
  }
  mesh.add_face(bottom);
  mesh.add_face(top);
  return mesh;
}

// The strips of eight turn by 45 degrees, all alike; those of a block do not go on like that.
TEST(DetectCreases, TellsRimsFromTheStripsOfACoarseCylinder) {
  const PolygonMesh mesh = with_detected_creases(prism(8, 3));
  EXPECT_EQ(mesh.creases.size(), 16u);
  for (const CreaseEdge& crease : mesh.creases) {
    EXPECT_EQ(mesh.positions[crease.v0].z, mesh.positions[crease.v1].z);
  }
  EXPECT_EQ(with_detected_creases(prism(4, 3)).creases.size(), 12u);
}

// A sheet of n x n cells, z = height(x, y).
template <class Height>
PolygonMesh sheet(int n, const Height& height) {
  PolygonMesh mesh;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) mesh.positions.emplace_back(x, y, height(x, y));
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x;
      mesh.add_face(std::array{a, a + 1, a + n + 2});
      mesh.add_face(std::array{a, a + n + 2, a + n + 1});
    }
  }
  return mesh;
}

double slope(double degrees) { return std::tan(degrees * std::numbers::pi / 180); }

// A roof of 36 degrees: noise on a curved shape, a line between flat sides.
TEST(DetectCreases, KeepsFlatLinesOfPartsAndDropsThoseOfCurvedShapes) {
  const auto roof = [](double x) { return -slope(18) * std::abs(x - 4); };
  EXPECT_EQ(with_detected_creases(sheet(8, [&](int x, int) { return roof(x); })).creases.size(),
            8u);
  const auto curved = [&](int x, int y) { return roof(x) - 0.05 * (y - 4) * (y - 4); };
  EXPECT_TRUE(with_detected_creases(sheet(8, curved)).creases.empty());
  // Of 60 degrees it is a line there too.
  const auto sharp = [&](int x, int y) {
    return -slope(30) * std::abs(x - 4) - 0.05 * (y - 4) * (y - 4);
  };
  EXPECT_EQ(with_detected_creases(sheet(8, sharp)).creases.size(), 8u);
}

// A profile of (radius, height) turned around z, in triangles; open at both ends.
PolygonMesh turned(std::span<const glm::dvec2> profile, int n) {
  PolygonMesh mesh;
  for (const glm::dvec2& knot : profile) {
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      mesh.positions.emplace_back(knot.x * std::cos(angle), knot.x * std::sin(angle), knot.y);
    }
  }
  for (int ring = 0; ring + 1 < static_cast<int>(profile.size()); ++ring) {
    for (int i = 0; i < n; ++i) {
      const int a = ring * n + i, b = ring * n + (i + 1) % n;
      mesh.add_face(std::array{a, b, b + n});
      mesh.add_face(std::array{a, b + n, a + n});
    }
  }
  return mesh;
}

// The rims of a countersunk bore: between the plate and the cone, between the cone and the bore.
TEST(DetectCreases, KeepsRimsOfRoundFacesThatTurnByHalfARightAngle) {
  const std::array<glm::dvec2, 4> bore{{{9, 0}, {5, 0}, {3, -2}, {3, -8}}};
  const PolygonMesh mesh = with_detected_creases(turned(bore, 24));
  EXPECT_EQ(mesh.creases.size(), 48u);
  for (const CreaseEdge& crease : mesh.creases)
    EXPECT_EQ(mesh.positions[crease.v0].z, mesh.positions[crease.v1].z);
  // Of one side flat a part of the rim is enough.
  PolygonMesh half = turned(bore, 24);
  for (std::int32_t i = 0; i < 9; ++i) half.positions[24 + i].z -= 0.4 * (i % 2);
  EXPECT_GT(with_detected_creases(half).creases.size(), 36u);
  // No face is flat beside a bulge's rim, and its edges turn by 32 to 48 degrees.
  const std::array<glm::dvec2, 5> bulge{{{9, -1}, {7, -0.3}, {5, 0}, {3, -1.4}, {1, -3}}};
  PolygonMesh uneven = turned(bulge, 24);
  for (std::int32_t i = 0; i < 24; ++i) uneven.positions[48 + i].z += 0.2 * std::sin(i * 2.1);
  EXPECT_LT(with_detected_creases(uneven).creases.size(), 3u);
}

// That of a shaft's end, with flat ends.
PolygonMesh turned_and_closed(std::span<const glm::dvec2> profile, int n) {
  PolygonMesh mesh = turned(profile, n);
  std::vector<std::int32_t> first, last;
  for (std::int32_t i = 0; i < n; ++i) {
    first.push_back(n - 1 - i);
    last.push_back(static_cast<std::int32_t>(mesh.positions.size()) - n + i);
  }
  mesh.add_face(first);
  mesh.add_face(last);
  return mesh;
}

// Both turn by 45 degrees at each ring, as three sides of an octagon do.
TEST(DetectCreases, TellsNarrowChamfersFromTheStripsOfACoarseRound) {
  const std::array<glm::dvec2, 4> chamfers{{{9, 0}, {10, 1}, {10, 8}, {9, 9}}};
  EXPECT_EQ(with_detected_creases(turned_and_closed(chamfers, 32)).creases.size(), 128u);
  const std::array<glm::dvec2, 4> octagon{{{4.14, 0}, {10, 5.86}, {10, 14.14}, {4.14, 20}}};
  EXPECT_EQ(with_detected_creases(turned_and_closed(octagon, 32)).creases.size(), 0u);
}

// Of a knob: its head, its stem and the chamfer between both, in 40 sides of 9 degrees.
TEST(DetectCreases, FindsTheChamferBetweenAStemAndItsHead) {
  const std::array<glm::dvec2, 8> knob{
      {{.95, 0}, {1, .05}, {1, .4}, {.95, .45}, {.4, .45}, {.35, .5}, {.35, 1}, {.3, 1.05}}};
  EXPECT_EQ(with_detected_creases(turned_and_closed(knob, 40)).creases.size(), 320u);
}

// A prism of n walls, its ends chamfered all around, in triangles but for the ends themselves.
PolygonMesh chamfered_prism(int n) {
  const std::array<glm::dvec2, 4> profile{{{.9, 0}, {1, .1}, {1, .7}, {.9, .8}}};
  return turned_and_closed(profile, n);
}

// At a corner of its walls four lines meet, of which none turns by twice the third: the wall's own
// edge, two of the chamfer, and between two chamfers one that turns by less.
TEST(DetectCreases, FindsChamfersOfPrisms) {
  for (const int n : {4, 5, 6})
    EXPECT_EQ(with_detected_creases(chamfered_prism(n)).creases.size(), 7u * n) << n;
}

// A block of which every edge and corner is bevelled is meant to be round: nothing else in it is
// sharp.
TEST(DetectCreases, LeavesBevelsAllAroundRound) {
  constexpr double kBevel = 0.15;
  PolygonMesh block;
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 p;
      for (int k = 0; k < 3; ++k)
        p[k] = ((corner >> k & 1) != 0 ? 1 : -1) * (k == axis ? 1 : 1 - kBevel);
      block.positions.push_back(p);
    }
  }
  const auto add = [&](std::vector<std::int32_t> face) {
    const auto &a = block.positions[face[0]], &b = block.positions[face[1]],
               &c = block.positions[face[2]];
    if (glm::dot(glm::cross(b - a, c - b), a) < 0) std::ranges::reverse(face);
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      block.add_face(std::array{face[0], face[i], face[i + 1]});
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, w = 1 << axis;
    for (const int side : {0, w})
      add({3 * side + axis, 3 * (side | u) + axis, 3 * (side | u | v) + axis,
           3 * (side | v) + axis});
    const int first = (axis + 1) % 3, second = (axis + 2) % 3;
    for (const int edge : {0, u, v, u | v})
      add({3 * edge + first, 3 * (edge | w) + first, 3 * (edge | w) + second, 3 * edge + second});
  }
  for (int corner = 0; corner < 8; ++corner) add({3 * corner, 3 * corner + 1, 3 * corner + 2});
  EXPECT_EQ(block.face_count(), 44);
  EXPECT_TRUE(with_detected_creases(block).creases.empty());
}

// Walls over a profile in the plane y = 0, counter-clockwise seen against y, with both ends; in
// triangles if `is_cut`.
PolygonMesh prism_of(const std::vector<glm::dvec2>& profile, bool is_cut) {
  const auto n = static_cast<std::int32_t>(profile.size());
  PolygonMesh mesh;
  for (const double y : {0.0, 2.0})
    for (const glm::dvec2& p : profile) mesh.positions.emplace_back(p.x, y, p.y);
  const auto add = [&](const std::vector<std::int32_t>& face) {
    if (!is_cut) mesh.add_face(face);
    for (std::size_t i = 1; is_cut && i + 1 < face.size(); ++i)
      mesh.add_face(std::array{face[0], face[i], face[i + 1]});
  };
  std::vector<std::int32_t> front, back;
  for (std::int32_t i = 0; i < n; ++i) {
    front.push_back(i);
    back.push_back(2 * n - 1 - i);
    add({i, n + i, n + (i + 1) % n, (i + 1) % n});
  }
  add(front);
  add(back);
  return mesh;
}

// The eaves of a house turn by 51 degrees between walls and a ridge that turn by more; a round
// shape has no single edge, and how flat faces are cut says nothing.
TEST(DetectCreases, FindsTheEavesOfAHouseHoweverItIsCut) {
  const std::vector<glm::dvec2> house{{-1, 0}, {1, 0}, {1, 1}, {0, 1.8}, {-1, 1}};
  std::vector<glm::dvec2> tube;
  for (int i = 0; i < 7; ++i)
    tube.emplace_back(std::cos(2 * std::numbers::pi * i / 7),
                      std::sin(2 * std::numbers::pi * i / 7));
  for (const bool is_cut : {false, true}) {
    EXPECT_EQ(with_detected_creases(prism_of(house, is_cut)).creases.size(), 15u) << is_cut;
    EXPECT_EQ(with_detected_creases(prism_of(tube, is_cut)).creases.size(), 14u)
        << "walls that turn alike by 51 degrees are round: " << is_cut;
  }
}

// Every edge of an icosahedron turns by 42 degrees: it is a coarse sphere.
TEST(DetectCreases, FindsNothingWhereAllEdgesAreAlike) {
  PolygonMesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) mesh.positions.emplace_back(0, a, b);
    for (const double b : {-g, g}) mesh.positions.emplace_back(a, b, 0);
    for (const double b : {-g, g}) mesh.positions.emplace_back(b, 0, a);
  }
  for (int a = 0; a < 12; ++a) {
    for (int b = a + 1; b < 12; ++b) {
      for (int c = b + 1; c < 12; ++c) {
        const auto near = [&](int i, int j) {
          return glm::distance(mesh.positions[i], mesh.positions[j]) < 2.1;
        };
        if (!near(a, b) || !near(b, c) || !near(a, c)) continue;
        const glm::dvec3& p = mesh.positions[a];
        const bool outward =
            glm::dot(glm::cross(mesh.positions[b] - p, mesh.positions[c] - p), p) > 0;
        mesh.add_face(std::array{a, outward ? b : c, outward ? c : b});
      }
    }
  }
  ASSERT_EQ(mesh.face_count(), 20);
  EXPECT_TRUE(with_detected_creases(mesh).creases.empty());
}

}  // namespace
}  // namespace planish
