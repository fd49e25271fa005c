#include "planish/mesh/outline_corners.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <numbers>
#include <utility>
#include <vector>

#include "mesh/test_meshes.h"

namespace planish {
namespace {

using Corners = std::vector<std::int32_t>;
using Place = std::function<glm::dvec3(double, double)>;

// `across` by `along` quads of the unit square, placed.
PolygonMesh quad_sheet(int across, int along, const Place& place) {
  PolygonMesh mesh;
  for (int j = 0; j <= along; ++j)
    for (int i = 0; i <= across; ++i)
      mesh.positions.push_back(place(double(i) / across, double(j) / along));
  for (int j = 0; j < along; ++j)
    for (int i = 0; i < across; ++i) {
      const int v = j * (across + 1) + i;
      mesh.add_face(std::array{v, v + 1, v + across + 2, v + across + 1});
    }
  return mesh;
}

glm::dvec3 flat(double u, double v) { return {u, v, 0}; }

Corners found_in(const PolygonMesh& mesh, double degrees = 60) {
  return outline_corners(mesh, MeshTopology(mesh), degrees);
}

TEST(OutlineCorners, AreThoseOfASheetHoweverItIsBent) {
  const Corners corners{0, 6, 28, 34};
  EXPECT_EQ(found_in(quad_sheet(6, 4, flat)), corners);
  EXPECT_EQ(found_in(quad_sheet(6, 4,
                                [](double u, double v) {
                                  return glm::dvec3(std::cos(3 * u), std::sin(3 * u), v);
                                })),
            corners);
  // Rough ground: the rim turns by up to 70 degrees up and down, but not along the surface.
  EXPECT_EQ(found_in(quad_sheet(6, 4,
                                [](double u, double v) {
                                  return glm::dvec3(u, v,
                                                    0.06 * std::cos(6 * std::numbers::pi * u));
                                })),
            corners);
}

TEST(OutlineCorners, TurnInwardToo) {
  // An L of two faces: at its inner corner, 2, the larger one reaches round by 225 degrees.
  PolygonMesh mesh;
  constexpr std::array<std::pair<int, int>, 12> kPlaces{{{4, 0},
                                                         {4, 2},
                                                         {2, 2},
                                                         {2, 4},
                                                         {0, 4},
                                                         {0, 3},
                                                         {0, 2},
                                                         {0, 1},
                                                         {0, 0},
                                                         {1, 0},
                                                         {2, 0},
                                                         {3, 0}}};
  for (const auto& [x, y] : kPlaces) mesh.positions.emplace_back(x, y, 0);
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{0, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11});
  EXPECT_EQ(found_in(mesh), (Corners{0, 1, 2, 3, 4, 8}));
}

// Its tips turn by 127 degrees, the corners between by 55.
TEST(OutlineCorners, LeaveOtherTurnsOfAClearOutline) {
  PolygonMesh star;
  constexpr int kSides = 10, kParts = 4, kCount = kSides * kParts;
  const auto corner = [](int i) {
    const double angle = std::numbers::pi * i / 5;
    return glm::dvec3(std::cos(angle), std::sin(angle), 0) * (i % 2 ? 0.5 : 1.0);
  };
  for (int i = 0; i < kCount; ++i)
    star.positions.push_back(glm::mix(corner(i / kParts), corner(i / kParts + 1),
                                      static_cast<double>(i % kParts) / kParts));
  star.positions.emplace_back(0, 0, 0);
  for (int i = 0; i < kCount; ++i) star.add_face(std::array{i, (i + 1) % kCount, kCount});
  EXPECT_EQ(found_in(star), (Corners{0, 8, 16, 24, 32}));
  EXPECT_EQ(found_in(star, 45).size(), 10u);
}

TEST(OutlineCorners, ARoundRimHasNone) {
  for (const int sides : {5, 8, 24}) {
    PolygonMesh tube = quad_sheet(sides, 3, [&](double u, double v) {
      const double angle = 2 * std::numbers::pi * u;
      return glm::dvec3(std::cos(angle), std::sin(angle), v);
    });
    // Close it: the last of each row is the first.
    for (std::int32_t& v : tube.face_vertices)
      if (v % (sides + 1) == sides) v -= sides;
    const MeshTopology topology(tube);
    EXPECT_TRUE(outline_corners(tube, topology, 60).empty()) << sides;
  }
}

TEST(OutlineCorners, TheRimOfAnOpenBoxHasNone) {
  // Its edges turn by 90 degrees there, in space alone.
  PolygonMesh box = test::cube();
  box.face_vertices.resize(box.face_vertices.size() - 4);
  box.face_offsets.pop_back();
  EXPECT_TRUE(found_in(box).empty());
}

TEST(OutlineCorners, ARaggedRimHasNone) {
  // Triangles along a line, every second one's tip at the rim, as where a scan was cut.
  PolygonMesh mesh;
  constexpr int kTeeth = 12;
  for (int i = 0; i <= kTeeth; ++i) mesh.positions.emplace_back(i, 0, 0);
  for (int i = 0; i < kTeeth; ++i) mesh.positions.emplace_back(i + 0.5, 0.87, 0);
  for (int i = 0; i < kTeeth; ++i) mesh.add_face(std::array{i, i + 1, kTeeth + 1 + i});
  for (int i = 0; i + 1 < kTeeth; ++i) {
    mesh.positions.emplace_back(i + 1, i % 2 ? 0.9 : 0.2, 0.4);
    mesh.add_face(std::array{i + 1, kTeeth + 2 + i, mesh.vertex_count() - 1});
    mesh.add_face(std::array{i + 1, mesh.vertex_count() - 1, kTeeth + 1 + i});
  }
  EXPECT_TRUE(found_in(mesh).empty());
}

TEST(OutlineCorners, AreAtMostHalfOfALoopOrFour) {
  EXPECT_EQ(found_in(quad_sheet(1, 1, flat)).size(), 4u) << "a plane of one face";
  EXPECT_EQ(found_in(quad_sheet(2, 1, flat)).size(), 4u) << "of six";
  EXPECT_EQ(found_in(quad_sheet(2, 2, flat)).size(), 4u);
  EXPECT_TRUE(found_in(quad_sheet(2, 2, flat), 91).empty()) << "the caller's angle";
  for (const int sides : {5, 6, 7}) {
    PolygonMesh disc;
    std::vector<std::int32_t> face;
    for (int i = 0; i < sides; ++i) {
      const double angle = 2 * std::numbers::pi * i / sides;
      disc.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
      face.push_back(i);
    }
    disc.add_face(face);
    EXPECT_TRUE(found_in(disc, 45).empty()) << "a coarse disc of " << sides;
  }
}

// A face is missing: around its place faces reach round by three quarters of a turn.
TEST(OutlineCorners, SmallHolesHaveNone) {
  PolygonMesh sheet;
  const PolygonMesh whole = quad_sheet(5, 5, flat);
  sheet.positions = whole.positions;
  for (std::int32_t f = 0; f < whole.face_count(); ++f)
    if (f != 12) sheet.add_face(whole.face(f));
  EXPECT_EQ(found_in(sheet), (Corners{0, 5, 30, 35}));
}

TEST(OutlineCorners, ClosedMeshesHaveNone) { EXPECT_TRUE(found_in(test::cube()).empty()); }

}  // namespace
}  // namespace planish
