#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>

#include "limit/limit_case.h"
#include "limit/tessellation_error.h"
#include "planish/adaptive/adaptive_blocks.h"
#include "planish/adaptive/adaptive_cells.h"
#include "planish/adaptive/adaptive_faces.h"
#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/files/mesh_file.h"
#include "support/calls.h"

namespace planish::test {
namespace {

constexpr std::int32_t kSide = 2 * kCellSide;

// Places of a side, no two farther apart than `longest`: even ones, or any.
std::vector<std::uint16_t> any_side(std::mt19937& random, std::int32_t parts) {
  std::vector<std::uint16_t> places{0};
  if (random() % 3 == 0) {
    const auto finer = parts + static_cast<std::int32_t>(random() % 5);
    for (std::int32_t i = 1; i < finer; ++i) places.push_back(even_place(i, finer));
    return places;
  }
  const std::int32_t longest = kSide / parts;
  while (kSide - places.back() > longest)
    places.push_back(static_cast<std::uint16_t>(places.back() + 1 +
                                                random() % static_cast<std::uint32_t>(longest)));
  return places;
}

// All vertices of a grid in its square.
std::vector<glm::dvec3> places_of(const FaceGrid& grid,
                                  const std::array<std::vector<std::uint16_t>, 4>& sides) {
  std::vector<glm::dvec3> places;
  for (const double t : sides[0]) places.emplace_back(t, 0, 0);
  for (const double t : sides[1]) places.emplace_back(kSide, t, 0);
  for (const double t : sides[2]) places.emplace_back(kSide - t, kSide, 0);
  for (const double t : sides[3]) places.emplace_back(0, kSide - t, 0);
  for (std::int32_t j = 1; j < grid.v; ++j) {
    for (std::int32_t i = 1; i < grid.u; ++i)
      places.emplace_back(even_place(i, grid.u), even_place(j, grid.v), 0);
  }
  return places;
}

// That is what the bound on a grid's parts is for.
TEST(GridTriangles, AreNoLargerThanPartsAndCoverTheFace) {
  std::mt19937 random(5);
  GridTriangles cutter;
  for (int round = 0; round < 20000; ++round) {
    const FaceGrid grid{static_cast<std::uint8_t>(1 + random() % 6),
                        static_cast<std::uint8_t>(1 + random() % 6)};
    std::array<std::vector<std::uint16_t>, 4> sides;
    for (int s = 0; s < 4; ++s) sides[s] = any_side(random, grid.parts_of_side(s));
    const std::vector<glm::dvec3> places = places_of(grid, sides);
    const auto triangles = cutter.cut(grid, {sides[0], sides[1], sides[2], sides[3]}, places);
    const std::size_t around = places.size() - static_cast<std::size_t>(grid.inside());
    ASSERT_EQ(triangles.size(), around - 2 + 2 * static_cast<std::size_t>(grid.inside()));
    double area = 0;
    std::map<std::pair<std::int32_t, std::int32_t>, int> edges;
    for (const auto& t : triangles) {
      const auto at = [&](std::size_t k) { return places[t[k % 3]]; };
      const glm::dvec3 ab = at(1) - at(0), ac = at(2) - at(0);
      const double twice = ab.x * ac.y - ab.y * ac.x;
      ASSERT_GT(twice, 0);
      area += twice;
      for (int d = 0; d < 2; ++d) {
        const auto [low, high] = std::minmax({at(0)[d], at(1)[d], at(2)[d]});
        ASSERT_LE(high - low, double{kSide} / grid.parts_of_side(d) + 2)
            << int{grid.u} << " by " << int{grid.v};
      }
      for (std::size_t k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
    }
    ASSERT_EQ(area, 2.0 * kSide * kSide);
    for (const auto& [ends, count] : edges) {
      ASSERT_EQ(count, 1);
      const bool is_side = ends.second == (ends.first + 1) % static_cast<std::int32_t>(around) &&
                           ends.first < static_cast<std::int32_t>(around);
      ASSERT_EQ(edges.contains({ends.second, ends.first}), !is_side);
    }
  }
}

// Flat cells are all ties: between ears, and between the diagonals of parts.
TEST(GridTriangles, AreTheSameHoweverPlacesAreRounded) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> rounding(-1e-12 * kSide, 1e-12 * kSide);
  GridTriangles cutter;
  for (int round = 0; round < 2000; ++round) {
    const FaceGrid grid{static_cast<std::uint8_t>(1 + random() % 4),
                        static_cast<std::uint8_t>(1 + random() % 4)};
    std::array<std::vector<std::uint16_t>, 4> sides;
    for (int s = 0; s < 4; ++s) sides[s] = any_side(random, grid.parts_of_side(s));
    std::vector<glm::dvec3> places = places_of(grid, sides);
    const auto cut = [&] {
      const auto triangles = cutter.cut(grid, {sides[0], sides[1], sides[2], sides[3]}, places);
      return std::vector(triangles.begin(), triangles.end());
    };
    const auto exact = cut();
    for (glm::dvec3& place : places)
      place += glm::dvec3(rounding(random), rounding(random), rounding(random));
    ASSERT_EQ(cut(), exact) << int{grid.u} << " by " << int{grid.v};
  }
}

TEST(GridTriangles, OnlyOfFacesThatShareOneEdgeWithAnother) {
  const auto all_stand_alone = [](const PolygonMesh& mesh) {
    const MeshTopology topology(mesh);
    for (std::int32_t f = 0; f < topology.face_count(); ++f)
      if (!stands_alone(topology, f)) return false;
    return true;
  };
  EXPECT_TRUE(all_stand_alone(cube()));
  EXPECT_TRUE(all_stand_alone(torus(3, 4, 2, 1)));
  // Of a pillow, and of two faces at a vertex of two edges.
  const std::vector<glm::dvec3> places{{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {2, 2, 0}};
  EXPECT_FALSE(all_stand_alone(make_mesh(places, {{0, 1, 2, 3}, {3, 2, 1, 0}})));
  EXPECT_FALSE(all_stand_alone(make_mesh(places, {{0, 1, 2, 3}, {1, 4, 3, 2}})));
}

using ::testing::AllOf;
using ::testing::HasSubstr;

AdaptiveSurface tessellated(const LimitCase& c, double chord_error, double angle = 0) {
  return tessellate(
      c.limit,
      {.chord_error = chord_error, .angle = angle, .diagonal = c.surface->placement().diagonal});
}

// Small meshes of every kind, also with few and many edges at a vertex.
std::vector<NamedMesh> adaptive_meshes() {
  std::vector<NamedMesh> meshes = limit_meshes();
  for (int n = 3; n <= 20; ++n) {
    meshes.push_back({"bipyramid " + std::to_string(n), bipyramid(n)});
    meshes.push_back({"prism " + std::to_string(n), prism(n)});
  }
  // Whole faces cut evenly: beside others, beside cells, creases and borders, and along one way.
  meshes.push_back({"jittered torus", jittered(torus(10, 8, 2, 1), 0.1, 3)});
  meshes.push_back({"thin torus", torus(40, 4, 2, 0.2)});
  meshes.push_back({"creased torus", with_random_creases(torus(12, 9, 2, 1), 0.05, 4)});
  meshes.push_back({"jittered sheet", jittered(flat_grid(9, 7), 0.2, 5)});
  PolygonMesh holes = torus(8, 6, 2, 1);
  holes.hole_faces = {0, 1, 7, 20};
  meshes.push_back({"torus with holes", holes});
  PolygonMesh unseen = torus(8, 6, 2, 1);  // no face around a vertex is seen
  for (std::int32_t f = 0; f < unseen.face_count(); ++f)
    if (std::ranges::count(unseen.face(f), 9) > 0) unseen.hole_faces.push_back(f);
  meshes.push_back({"torus with a vertex unseen", unseen});
  return meshes;
}

LimitCase scene_case(const std::string& name) {
  return LimitCase(read_mesh(std::filesystem::path(PLANISH_SCENES) / name).mesh);
}

// Vertices are joined where they are in one place only beside sharp edges, which copy them.
void expect_watertight(const LimitCase& c, const SurfaceMesh& surface) {
  const bool has_copies = c.surface->patches().features().interior_sharp_edge_count > 0;
  const Joints joints = joints_of(surface, has_copies);
  const Joints level_one = joints_of(c.tessellated(1), has_copies);
  EXPECT_EQ(joints.bad_edges, 0);
  EXPECT_EQ(joints.bad_triangles, 0);
  EXPECT_EQ(joints.euler(), level_one.euler());
  EXPECT_EQ(joints.boundary_edges > 0, level_one.boundary_edges > 0);
}

TEST(AdaptiveTessellation, IsAsNearAsAskedForAndWatertight) {
  for (const auto& [name, mesh] : adaptive_meshes()) {
    const LimitCase c(mesh);
    // Polygons of 64 corners and more take their time.
    if (std::ranges::any_of(c.limit.forms(),
                            [](const PatchForm* f) { return f->column_count > 60; }))
      continue;
    const SurfaceQueries queries(c.limit);
    for (const double error : {2e-2, 1e-3}) {
      SCOPED_TRACE(name + ", " + std::to_string(error));
      const AdaptiveSurface surface = tessellated(c, error);
      expect_watertight(c, surface.mesh);
      const TessellationError found = tessellation_error(c, queries, surface.mesh, 200);
      EXPECT_LE(found.to_surface, error);
      EXPECT_LE(found.to_triangles, error);
      EXPECT_GT(found.largest(), 0.02 * error) << "finer than there is need for";
    }
  }
}

// Flat cells at face centres, pinched so that their neighbours do not go on as they do: a part of a
// surface was 1.85 times as far from all triangles as was asked for.
TEST(HullBound, CountsWhatRunsAsideOfATurningCell) {
  const std::vector<glm::dvec3> flat = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, -0.2, 0}};
  const glm::dvec3 up(0, 0, 1), steep(0, 0.6, 0.8);
  const std::vector<glm::dvec3> even = {up, up}, leaning = {steep, {0, -0.6, 0.8}},
                                around = {{0.1, 0, 1}, {-0.1, 0, 1}, {0, 0.2, -1}};
  EXPECT_EQ(hull_bound(flat, even, 0.2).distance, 0);
  EXPECT_NEAR(hull_bound(flat, leaning, 0.2).distance, 0.2 * 0.6 / 0.8, 1e-15);
  EXPECT_GE(hull_bound(flat, around, 0.2).distance, 0.2);
  EXPECT_LE(hull_bound(flat, around, 9).distance, glm::length(glm::dvec3(1, 1.2, 0)) + 1e-15);
}

TEST(AdaptiveTessellation, IsAsNearAsAskedForWhereTheSurfaceBendsTightly) {
  for (const std::uint32_t seed : {5u, 22u}) {
    SCOPED_TRACE(seed);
    const LimitCase c(interpolating_cage(random_dual(120, seed)));
    const AdaptiveSurface surface = tessellated(c, 1e-3);
    const TessellationError found = tessellation_error(c, SurfaceQueries(c.limit), surface.mesh,
                                                       static_cast<std::size_t>(run_length(1'000)));
    EXPECT_LE(found.largest(), 1e-3);
  }
}

TEST(AdaptiveTessellation, ScenesAreAsNearAsAskedFor) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(PLANISH_SCENES))
    if (entry.path().extension() == ".obj") paths.push_back(entry.path());
  std::ranges::sort(paths);
  ASSERT_GT(paths.size(), 10u);
  for (const auto& path : paths) {
    SCOPED_TRACE(path.filename().string());
    const LimitCase c(read_mesh(path).mesh);
    const SurfaceQueries queries(c.limit);
    const AdaptiveSurface surface = tessellated(c, 2e-4);
    expect_watertight(c, surface.mesh);
    EXPECT_LE(tessellation_error(c, queries, surface.mesh, run_length(400)).largest(), 2e-4);
  }
}

// The goblet is curved nearly alike everywhere.
TEST(AdaptiveTessellation, TakesFewerTrianglesThanLevelThree) {
  struct Case {
    const char* name;
    double share;
  };
  for (const auto& [name, share] :
       {Case{"goblet.obj", 0.5}, {"rocker_arm.obj", 0.37}, {"bearing_block.obj", 0.03}}) {
    SCOPED_TRACE(name);
    const LimitCase c = scene_case(name);
    const SurfaceQueries queries(c.limit);
    const SurfaceMesh level = c.tessellated(3);
    const double error = tessellation_error(c, queries, level, 1000).largest();
    const AdaptiveSurface surface = tessellated(c, error);
    EXPECT_LE(static_cast<double>(surface.mesh.face_count()),
              share * 2 * static_cast<double>(level.face_count()));
    EXPECT_LE(tessellation_error(c, queries, surface.mesh, 1000).largest(), error);
  }
}

// The boundary is round at its corners; all others of a flat face's corners are one cell.
TEST(AdaptiveTessellation, FlatFacesAreTwoTriangles) {
  const LimitCase c(flat_grid(9, 8));
  for (const AdaptiveSurface& surface : {tessellated(c, 1e-6), tessellated(c, 0, 1)}) {
    std::vector<int> triangles(static_cast<std::size_t>(c.mesh.face_count()), 0);
    for (const std::int32_t face : surface.ancestors) ++triangles[face];
    EXPECT_EQ(std::ranges::count(triangles, 2), c.mesh.face_count() - 4 * 3);
    expect_watertight(c, surface.mesh);
  }
}

TEST(AdaptiveTessellation, TurnsLessThanTheAngle) {
  for (const PolygonMesh& mesh : {torus(12, 8, 2, 1), cube(), icosphere(1), dodecahedron()}) {
    const LimitCase c(mesh);
    for (const double angle : {30.0, 10.0}) {
      const AdaptiveSurface surface = tessellated(c, 0, angle);
      expect_watertight(c, surface.mesh);
      for (const Triangle& t : triangles_of_surface(surface.mesh)) {
        for (std::size_t k = 0; k < 3; ++k) {
          const glm::dvec3 a(surface.mesh.normals[t[k]]);
          const glm::dvec3 b(surface.mesh.normals[t[(k + 1) % 3]]);
          ASSERT_GE(glm::dot(a, b), std::cos(angle * 3.14159265358979 / 180) - 1e-6);
        }
      }
    }
  }
}

// Degrees between the normals at a triangle's corners.
double turn_of(const SurfaceMesh& surface, const Triangle& t) {
  double turn = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::dvec3 a(surface.normals[t[k]]);
    const glm::dvec3 b(surface.normals[t[(k + 1) % 3]]);
    turn = std::max(turn, std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)));
  }
  return turn * 180 / 3.14159265358979;
}

// The surface beneath any place of a triangle, against its normals at the corners.
void expect_turns_at_random_places(const LimitCase& c, const SurfaceMesh& surface, double angle) {
  const SurfaceQueries queries(c.limit);
  const std::vector<Triangle> triangles = triangles_of_surface(surface);
  std::mt19937 random(8);
  std::uniform_int_distribution<std::size_t> any(0, triangles.size() - 1);
  std::uniform_real_distribution<double> share(0, 1);
  for (int i = 0; i < 3000; ++i) {
    const Triangle& t = triangles[any(random)];
    const double a = share(random), b = (1 - a) * share(random);
    const glm::dvec3 place = a * surface.positions[t[0]] + b * surface.positions[t[1]] +
                             (1 - a - b) * surface.positions[t[2]];
    const glm::dvec3 normal = queries.closest(place).normal;
    for (const std::int32_t corner : t) {
      const double cosine = glm::dot(normal, glm::dvec3(surface.normals[corner]));
      ASSERT_LT(std::acos(std::min(cosine, 1.0)) * 180 / std::numbers::pi, angle + 0.05) << i;
    }
  }
}

TEST(AdaptiveTessellation, TurnsLessThanTheAngleOrSaysWhereNot) {
  struct Case {
    PolygonMesh mesh;
    double angle;
    bool keeps;
  };
  const PolygonMesh folded =
      make_mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0, 0}, {0.5, 1, 0}},
                {{0, 1, 2, 3}, {1, 4, 5, 2}});
  for (const auto& [mesh, angle, keeps] :
       {Case{jittered(torus(9, 7, 2, 1), 0.1, 3), 3, true}, Case{bipyramid(5), 2, true},
        Case{prism(7), 2, true}, Case{random_dual(40, 2), 3, true},
        Case{jittered(icosphere(2), 0.1, 3), 5, true}, Case{folded, 5, false}}) {
    const LimitCase c(mesh);
    std::vector<Warning> warnings;
    AdaptiveOptions options{.angle = angle, .diagonal = c.surface->placement().diagonal};
    options.callbacks.warning = [&](const Warning& warning) { warnings.push_back(warning); };
    const AdaptiveSurface surface = tessellate(c.limit, options);
    std::int64_t count = 0;
    double largest = 0;
    for (const Triangle& t : triangles_of_surface(surface.mesh)) {
      const double turn = turn_of(surface.mesh, t);
      count += turn > angle + 1e-4 ? 1 : 0;
      largest = std::max(largest, turn);
    }
    EXPECT_EQ(count == 0, keeps);
    EXPECT_EQ(warnings.size(), count == 0 ? 0u : 1u);
    if (warnings.empty()) {
      expect_turns_at_random_places(c, surface.mesh, angle);
      continue;
    }
    EXPECT_EQ(warnings[0].code, kAngleNotKept);
    EXPECT_EQ(warnings[0].count, count);
    char text[40];
    std::snprintf(text, sizeof text, "by up to %.3g degrees between", largest);
    EXPECT_THAT(warnings[0].message, AllOf(HasSubstr(text), HasSubstr("near (")));
  }
}

TEST(AdaptiveTessellation, GivenVerticesComeFirstAndStay) {
  const LimitCase c(random_closed_mesh(4));
  const SurfaceMesh level = c.tessellated(2);
  const AdaptiveSurface surface = tessellated(c, 1e-3);
  EXPECT_EQ(surface.mesh.base_vertices, level.base_vertices);
  for (std::size_t i = 0; i < level.base_vertices.size(); ++i) {
    ASSERT_LT(glm::length(surface.mesh.positions[i] - level.positions[i]), 1e-14);
    ASSERT_LT(glm::length(surface.mesh.normals[i] - level.normals[i]), 1e-6);
  }
}

// Linear within the quads of level 1, whatever their triangles: areas, seams and colours are those
// of a level.
TEST(AdaptiveTessellation, AttributesAreThoseOfLevels) {
  const LimitCase c = scene_case("mapped_cube.obj");
  const SurfaceMesh level = c.tessellated(2);
  const AdaptiveSurface surface = tessellated(c, 1e-3);
  const auto figures = [](const SurfaceMesh& of) {
    double area = 0, red = 0;
    std::vector<std::int64_t> groups(of.groups.size());
    std::size_t corner = 0;
    for (std::int64_t f = 0; f < of.face_count(); ++f) {
      const auto face = of.face(f);
      ++groups[of.face_groups[f]];
      for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        const auto uv = [&](std::size_t k) { return of.uvs[of.face_uvs[corner + k]]; };
        const glm::dvec2 a = uv(i) - uv(0), b = uv(i + 1) - uv(0);
        area += 0.5 * std::abs(a.x * b.y - a.y * b.x);
      }
      corner += face.size();
    }
    for (const glm::vec4& color : of.colors) red = std::max(red, double{color.x});
    return std::tuple(area, red, groups.size(), *std::ranges::min_element(groups) > 0);
  };
  const auto [area, red, groups, all] = figures(surface.mesh);
  const auto [wanted_area, wanted_red, wanted_groups, wanted_all] = figures(level);
  // Borders of charts are curves, which both have by other chords.
  EXPECT_NEAR(area, wanted_area, 2e-4);
  EXPECT_NEAR(red, wanted_red, 1e-6);
  EXPECT_EQ(groups, wanted_groups);
  EXPECT_EQ(all, wanted_all);
  EXPECT_EQ(surface.mesh.colors.size(), surface.mesh.positions.size());
  for (std::size_t t = 0; t < surface.ancestors.size(); ++t)
    ASSERT_EQ(surface.mesh.face_groups[t], c.mesh.face_groups[surface.ancestors[t]]);
}

TEST(AdaptiveTessellation, IsTheSameForEveryThreadCount) {
  for (const PolygonMesh& mesh :
       {with_random_creases(random_closed_mesh(6), 0.1, 6),
        with_random_creases(jittered(torus(30, 20, 2, 1), 0.1, 3), 0.02, 4)}) {
    const LimitCase c(mesh);
    const AdaptiveSurface many = tessellated(c, 1e-3);
    const oneapi::tbb::global_control control(oneapi::tbb::global_control::max_allowed_parallelism,
                                              1);
    const AdaptiveSurface one = tessellated(c, 1e-3);
    EXPECT_TRUE(one.mesh.positions == many.mesh.positions);
    EXPECT_TRUE(one.mesh.normals == many.mesh.normals);
    EXPECT_TRUE(one.mesh.face_vertices == many.mesh.face_vertices);
  }
}

TEST(AdaptiveTessellation, WhatCannotBeKeptIsRefused) {
  const LimitCase c(cube());
  const auto message = [&](ErrorCode code, const AdaptiveOptions& options) {
    return message_of(code, [&] { (void)tessellate(c.limit, options); });
  };
  constexpr auto kBad = ErrorCode::InvalidArgument;
  EXPECT_THAT(message(kBad, {}), HasSubstr("neither a chord error nor an angle"));
  EXPECT_THAT(message(kBad, {.chord_error = -1}), HasSubstr("a chord error of -1 is none"));
  EXPECT_THAT(message(kBad, {.angle = 200}), HasSubstr("an angle of 200 degrees is none"));
  EXPECT_THAT(message(kBad, {.chord_error = std::nan("")}), HasSubstr("is none"));
  EXPECT_THAT(message(ErrorCode::OutOfMemory, {.chord_error = 1e-7, .memory_limit_bytes = 1 << 20}),
              HasSubstr("; allow a"));
}

// Before cells are made, which would take all of this memory, and with a remedy that does.
TEST(AdaptiveTessellation, TooManyTrianglesAreForeseen) {
  for (const auto& mesh : {torus(12, 7, 2, 0.7), icosphere(1), cube()}) {
    const LimitCase c(mesh);
    const auto refusal = [&](double error, std::uint64_t memory) {
      return message_of(ErrorCode::OutOfMemory, [&] {
        (void)tessellate(c.limit, {.chord_error = error,
                                   .diagonal = c.surface->placement().diagonal,
                                   .memory_limit_bytes = memory});
      });
    };
    const auto start = std::chrono::steady_clock::now();
    EXPECT_THAT(refusal(1e-13, std::uint64_t{1} << 50), HasSubstr("at least"));
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
    const std::string text = refusal(1e-8, 64 << 20);
    const std::size_t at = text.find("allow an error of ");
    ASSERT_NE(at, std::string::npos) << text;
    const double remedy = std::stod(text.substr(at + 18));
    EXPECT_GT(remedy, 1e-8);
    // Never of what fits.
    for (const double error : {1e-3, 1e-4, 1e-5}) {
      const AdaptiveSurface made = tessellated(c, error);
      const std::vector<std::uint8_t> hidden(
          static_cast<std::size_t>(c.limit.topology().corner_count()), 0);
      EXPECT_LT(2 * fewest_cells(c.limit, hidden, error),
                static_cast<double>(made.mesh.face_count()))
          << error;
    }
  }
}

// As levels do, and as places that are asked for do.
TEST(AdaptiveTessellation, CarriesNumbersOfVertices) {
  PolygonMesh mesh = jittered(torus(7, 5, 2, 1), 0.1, 3);
  mesh.hole_faces = {3};
  VertexAttribute five{"five", {}, 5};
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto x = static_cast<float>(v);
    mesh.colors.emplace_back(std::sin(x), std::cos(x), x / 40, std::sin(3 * x));
    for (int k = 0; k < 4; ++k) five.values.push_back(mesh.colors.back()[k]);
    five.values.push_back(2 * mesh.colors.back()[0]);
  }
  mesh.attributes = {five};
  const LimitCase c(mesh);
  const AdaptiveSurface surface = tessellated(c, 1e-3);
  ASSERT_EQ(surface.mesh.attributes.size(), 1u);
  const VertexAttribute& made = surface.mesh.attributes[0];
  ASSERT_EQ(made.count(), surface.mesh.positions.size());
  for (std::size_t row = 0; row < made.count(); ++row) {
    EXPECT_EQ(made.four(row, 0), surface.mesh.colors[row]) << row;
  }
  // Level 1 has the corners of each square: the places of parameters 0, 1/2 and 1.
  const SurfaceMesh level = c.tessellated(1);
  for (std::int64_t f = 0; f < level.face_count(); ++f) {
    const auto corner = static_cast<std::int32_t>(f < 12 ? f : f + 4);  // without the hole's
    const auto rows = level.face(f);
    const std::array square{surface_parameter(c.limit.topology(), corner, 0, 0),
                            surface_parameter(c.limit.topology(), corner, 1, 0),
                            surface_parameter(c.limit.topology(), corner, 1, 1),
                            surface_parameter(c.limit.topology(), corner, 0, 1)};
    const std::vector<float> values = attribute_at(c.limit, 0, square);
    // A corner keeps the place that it has in its face.
    const auto first = static_cast<std::size_t>(corner % 4);
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 5; ++k)
        EXPECT_NEAR(
            values[5 * i + k],
            level.attributes[0].values[5 * static_cast<std::size_t>(rows[(first + i) % 4]) + k],
            1e-6)
            << f << " " << i;
  }
}

}  // namespace
}  // namespace planish::test
