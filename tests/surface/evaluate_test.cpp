#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_faces.h"
#include "planish/surface/memory_need.h"
#include "planish/surface/quality_sum.h"
#include "support/calls.h"
#include "support/meshes.h"

namespace planish {
namespace {

SurfaceMesh evaluated(const PolygonMesh& cage, int level) {
  return evaluate(cage, *make_cpu_backend(), {.level = level});
}

TEST(Evaluate, LevelsStartWithTheSameLimitPointsAndNormals) {
  const PolygonMesh cage = test::prism(5);
  const std::vector<glm::dvec3> limits = limit_positions(cage, Weights::DooSabin, {});
  SurfaceMesh first;
  for (int level = 0; level <= 5; ++level) {
    const SurfaceMesh surface = evaluated(cage, level);
    if (level == 0) first = surface;
    for (std::size_t v = 0; v < limits.size(); ++v) {
      EXPECT_LT(glm::length(surface.positions[v] - limits[v]), 1e-14) << "level " << level;
      EXPECT_LT(glm::length(surface.normals[v] - first.normals[v]), 2e-7f) << "level " << level;
    }
  }
}

TEST(Evaluate, LevelZeroKeepsTheInputsFaces) {
  const PolygonMesh cage = test::prism(5);
  const SurfaceMesh surface = evaluated(cage, 0);
  EXPECT_EQ(surface.face_vertices, cage.face_vertices);
  EXPECT_EQ(surface.face_offsets, cage.face_offsets);
}

TEST(Evaluate, NormalsPointOutwards) {
  const SurfaceMesh surface = evaluated(test::icosphere(1), 3);
  for (std::size_t v = 0; v < surface.positions.size(); ++v) {
    EXPECT_NEAR(glm::length(surface.normals[v]), 1.0f, 1e-6f);
    EXPECT_GT(glm::dot(glm::dvec3(surface.normals[v]), glm::normalize(surface.positions[v])), 0.98);
  }
}

TEST(Evaluate, LeavesUnusedVerticesOut) {
  PolygonMesh cage = test::cube();
  cage.positions.insert(cage.positions.begin(), glm::dvec3(100, 0, 0));
  for (auto& v : cage.face_vertices) ++v;
  const SurfaceMesh surface = evaluated(cage, 1);
  EXPECT_EQ(surface.base_vertices, (std::vector<std::int32_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  const SurfaceMesh plain = evaluated(test::cube(), 1);
  EXPECT_EQ(surface.positions, plain.positions);
  EXPECT_EQ(limit_positions(cage, Weights::DooSabin, {})[0], glm::dvec3(100, 0, 0));
}

// With the warning that some normals are not the surface's own, and of how many.
std::pair<SurfaceMesh, std::int64_t> evaluated_with_warning(const PolygonMesh& cage,
                                                            EvaluateOptions options) {
  std::vector<Warning> warnings;
  options.callbacks.warning = [&](const Warning& w) { warnings.push_back(w); };
  SurfaceMesh surface = evaluate(cage, *make_cpu_backend(), options);
  EXPECT_EQ(warnings.size(), 1u);
  if (warnings.empty()) return {surface, 0};
  EXPECT_EQ(warnings[0].code, "degenerate-normals");
  return {surface, warnings[0].count};
}

TEST(Evaluate, ReplacesNormalsWhereTangentsAreParallel) {
  // All vertices on one line: no normal anywhere.
  PolygonMesh cage = test::cube();
  for (auto& p : cage.positions) p = glm::dvec3(p.x, 2, 3);
  const auto [surface, count] = evaluated_with_warning(cage, {.level = 1});
  for (const auto& normal : surface.normals) EXPECT_EQ(normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(count, std::ssize(surface.normals));
}

// Bicubic about its middle: there both tangents run along x (a B-spline's derivative is half the
// difference of its neighbours), while the facets on both sides lean towards -y.
TEST(Evaluate, CatmullClarkTakesFacetsNormalsWhereTangentsAreParallel) {
  const PolygonMesh cage = test::grid(4, 4, [](double x, double y) {
    const double v = y - 2;
    return glm::dvec3(x + 0.5 * v, v * v, v * (v * v - 1) / 6);
  });
  const SurfaceMesh surface =
      evaluated_with_warning(cage, {.level = 0, .scheme = Scheme::CatmullClark}).first;
  constexpr std::size_t kMiddle = 2 + 5 * 2;
  EXPECT_LT(glm::distance(surface.normals[kMiddle], glm::vec3(0, -1, 0)), 1e-6f);
}

TEST(Evaluate, InteriorValenceTwoHasAUnitNormal) {
  const SurfaceMesh surface = evaluated(test::cube_with_split_edges(), 2);
  for (const auto& normal : surface.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-6f);
}

TEST(Evaluate, SplitsNormalsAlongCreasesOnly) {
  PolygonMesh cage = test::cube();
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 3}, {3, 2}, {2, 0}}) {
    cage.creases.push_back({a, b, kInfiniteSharpness});
  }
  const SurfaceMesh surface = evaluated(cage, 1);
  // 8 + 6 + 12 vertices; the closed crease has 4 vertices and 4 midpoints.
  ASSERT_EQ(surface.positions.size(), 26u + 8u);
  const SurfaceMesh smooth =
      evaluate(cage, *make_cpu_backend(), {.level = 1, .sharp = {.use_tags = false}});
  EXPECT_EQ(smooth.positions.size(), 26u);
}

TEST(Evaluate, RefusesLevelsOutOfRange) {
  for (const int level : {-1, 7})
    EXPECT_NE(
        test::message_of(ErrorCode::InvalidArgument, [&] { (void)evaluated(test::cube(), level); }),
        "no error");
}

TEST(Evaluate, RefusesWhatDoesNotFitIntoMemoryBeforeTakingIt) {
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [] {
                                 (void)evaluate(test::torus(64, 32, 1, 0.4), *make_cpu_backend(),
                                                {.level = 6, .memory_limit_bytes = 1u << 28});
                               }),
              testing::HasSubstr("8,388,608 faces"));
}

// The surface's vertex on level 0 that a corner of the mesh should be, by place.
void expect_mesh_faces(const PolygonMesh& mesh, const SurfaceMesh& surface) {
  const SurfaceMesh coarse =
      evaluate(mesh, *make_cpu_backend(), {.level = 0, .scheme = Scheme::DooSabin});
  const std::vector<LevelFaces> levels = level_faces(surface, mesh);
  ASSERT_EQ(levels.size(), static_cast<std::size_t>(surface.level) + 1);
  ASSERT_EQ(levels[0].face_count(), static_cast<std::size_t>(coarse.face_count()));
  for (std::size_t f = 0; f < levels[0].face_count(); ++f) {
    const auto face = levels[0].face(f), wanted = coarse.face(static_cast<std::int64_t>(f));
    ASSERT_EQ(face.size(), wanted.size());
    for (std::size_t k = 0; k < face.size(); ++k) {
      EXPECT_LT(glm::distance(surface.positions[face[k]], coarse.positions[wanted[k]]), 1e-12);
    }
  }
}

TEST(LevelFaces, LevelZeroAreTheMeshsFaces) {
  for (int level = 1; level <= 3; ++level) {
    for (const PolygonMesh& mesh : {test::prism(5), test::cube(), test::plate_with_hole(5)}) {
      expect_mesh_faces(mesh, evaluate(mesh, *make_cpu_backend(), {.level = level}));
    }
  }
}

TEST(LevelFaces, HolesAreLeftOut) {
  PolygonMesh mesh = test::prism(5);
  mesh.hole_faces = {1, 3};
  const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = 2});
  expect_mesh_faces(mesh, surface);
  for (const std::int32_t ancestor : ancestor_faces(surface, mesh)) {
    EXPECT_TRUE(ancestor != 1 && ancestor != 3);
  }
}

// Children of a coarser level are the faces that evaluating that level gives.
TEST(LevelFaces, CoarserLevelsAreThoseOfTheirOwnSurface) {
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark, Scheme::Loop}) {
    const PolygonMesh mesh = test::icosphere(1);
    const auto backend = make_cpu_backend();
    const SurfaceMesh fine = evaluate(mesh, *backend, {.level = 3, .scheme = scheme});
    const std::vector<LevelFaces> levels = level_faces(fine, mesh);
    for (int level = 0; level <= 3; ++level) {
      const SurfaceMesh coarse = evaluate(mesh, *backend, {.level = level, .scheme = scheme});
      // Vertices have other numbers there, and the same limit points.
      ASSERT_EQ(levels[level].vertices.size(), coarse.face_vertices.size()) << level;
      for (std::size_t i = 0; i < coarse.face_vertices.size(); ++i) {
        const std::int32_t v = levels[level].vertices[i], w = coarse.face_vertices[i];
        ASSERT_LT(glm::distance(fine.positions[v], coarse.positions[w]), 1e-13) << level;
        ASSERT_LT(glm::distance(fine.normals[v], coarse.normals[w]), 1e-6f) << level;
      }
    }
  }
}

// The places in a child are those of its parent's corners, edges and middle.
TEST(LevelFaces, ChildrenHoldCornerEdgeAndMiddle) {
  for (const Scheme scheme : {Scheme::CatmullClark, Scheme::Loop}) {
    const PolygonMesh mesh = test::icosphere(0);
    const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = 2, .scheme = scheme});
    const std::vector<LevelFaces> levels = level_faces(surface, mesh);
    const bool triangles = scheme == Scheme::Loop;
    for (std::size_t l = 0; l < 2; ++l) {
      std::size_t child = 0;
      for (std::size_t f = 0; f < levels[l].face_count(); ++f) {
        const auto face = levels[l].face(f);
        for (std::size_t k = 0; k < face.size(); ++k) {
          const auto corners = levels[l + 1].face(child + k);
          const auto next = levels[l + 1].face(child + (k + 1) % face.size());
          const ChildCorners at = child_corners(face.size(), corners.size(), static_cast<int>(k));
          EXPECT_EQ(corners[at.corner], face[k]);
          // The edge's point is in the next corner's child as well, which the corner is not.
          EXPECT_EQ(std::count(next.begin(), next.end(), corners[at.edge]), 1);
          EXPECT_EQ(std::count(next.begin(), next.end(), face[k]), 0);
          EXPECT_EQ(at.middle < 0, triangles);
          if (triangles) continue;
          for (std::size_t other = 0; other < face.size(); ++other) {
            const auto all = levels[l + 1].face(child + other);
            EXPECT_EQ(std::count(all.begin(), all.end(), corners[at.middle]), 1);
          }
        }
        child += triangles ? 4 : face.size();
      }
    }
  }
}

// A 2 x 1 grid whose two quads have texture coordinates of their own: a seam on x = 1.
PolygonMesh two_charts() {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {5, 5}, {6, 5}, {6, 6}, {5, 6}};
  mesh.face_uvs = {0, 1, 2, 3, 4, 5, 6, 7};
  for (const glm::dvec3& p : mesh.positions) mesh.colors.emplace_back(p.x / 2, p.y, 0, 1);
  mesh.groups = {{"left", "red"}, {"right", "blue"}};
  mesh.face_groups = {0, 1};
  return mesh;
}

SurfaceMesh surface_of(const PolygonMesh& mesh, int level) {
  // Corners keep the grid's outline, so that a face's corners stay where its parameters are.
  return evaluate(mesh, *make_cpu_backend(),
                  {.level = level, .sharp = {.boundary = BoundaryRule::EdgeAndCorner}});
}

TEST(Attributes, TextureCoordinatesKeepTheirSeams) {
  for (int level = 0; level <= 3; ++level) {
    const SurfaceMesh surface = surface_of(two_charts(), level);
    ASSERT_EQ(surface.face_uvs.size(), surface.face_vertices.size());
    for (std::int64_t f = 0; f < surface.face_count(); ++f) {
      const bool left = 2 * f < surface.face_count();
      for (int i = 0; i < 4; ++i) {
        const auto corner = static_cast<std::size_t>(4 * f + i);
        const glm::dvec2 uv = surface.uvs[surface.face_uvs[corner]];
        const double low = left ? 0 : 5;
        EXPECT_GE(uv.x, low - 1e-14);
        EXPECT_LE(uv.x, low + 1 + 1e-14);
        // On the seam each side has its own value.
        if (surface.positions[surface.face_vertices[corner]].x == 1) {
          EXPECT_NEAR(uv.x, left ? 1 : 5, 1e-14);
        }
      }
    }
  }
}

// Numbers of vertices are as colours, which are tested above, for any width: by fours.
TEST(Attributes, NumbersOfVerticesAreAsColours) {
  PolygonMesh cube = test::cube();
  cube.hole_faces = {2};
  cube.creases = {{0, 1}, {1, 3}};
  PolygonMesh loop = test::tetrahedron();
  loop.positions.emplace_back(9, 9, 9);  // which no face names
  for (PolygonMesh* const given : {&cube, &loop}) {
    PolygonMesh& mesh = *given;
    VertexAttribute six{"six", {}, 6};
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
      const auto x = static_cast<float>(v);
      mesh.colors.emplace_back(std::sin(x), std::cos(x), x / 8, std::sin(3 * x));
      for (int k = 0; k < 4; ++k) six.values.push_back(mesh.colors.back()[k]);
      six.values.insert(six.values.end(), {0, 1});
    }
    mesh.attributes = {six};
  }
  const auto compare = [](const PolygonMesh& mesh, Scheme scheme, int level) {
    const SurfaceMesh surface =
        evaluate(mesh, *make_cpu_backend(), {.level = level, .scheme = scheme});
    ASSERT_EQ(surface.attributes.size(), 1u);
    const VertexAttribute& six = surface.attributes[0];
    EXPECT_EQ(six.name, "six");
    ASSERT_EQ(six.count(), surface.positions.size());
    for (std::size_t row = 0; row < six.count(); ++row) {
      EXPECT_EQ(six.four(row, 4)[0], 0);
      EXPECT_EQ(six.four(row, 4)[1], 1);
      for (int k = 0; k < 4; ++k)
        EXPECT_NEAR(six.four(row, 0)[k], surface.colors[row][k], 1e-6) << level << " " << row;
    }
  };
  for (int level = 0; level <= 3; ++level) {
    compare(cube, Scheme::DooSabin, level);
    compare(cube, Scheme::CatmullClark, level);
    compare(loop, Scheme::Loop, level);
    compare(loop, Scheme::DooSabin, level);
  }
}

TEST(Attributes, AreLinearBetweenTheCornersOfAQuad) {
  // At level 3 a unit quad's texture coordinates are a grid of eighths.
  const SurfaceMesh surface = surface_of(two_charts(), 3);
  for (const glm::dvec2& uv : surface.uvs) {
    EXPECT_NEAR(uv.x * 8, std::round(uv.x * 8), 1e-13);
    EXPECT_NEAR(uv.y * 8, std::round(uv.y * 8), 1e-13);
  }
  for (std::size_t corner = 0; corner < surface.face_uvs.size(); ++corner) {
    const glm::dvec2 uv = surface.uvs[surface.face_uvs[corner]];
    const glm::vec4 color = surface.colors[surface.face_vertices[corner]];
    const double x = uv.x < 2 ? uv.x / 2 : (uv.x - 4) / 2;
    const double y = uv.y < 2 ? uv.y : uv.y - 5;
    EXPECT_NEAR(color.r, x, 1e-6);
    EXPECT_NEAR(color.g, y, 1e-6);
  }
}

// A vertex of a crease has a row for each side: they differ in their normal alone.
TEST(Attributes, ColoursAreTheSameOnBothSidesOfACrease) {
  PolygonMesh mesh = test::cube();
  mesh.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  for (const glm::dvec3& p : mesh.positions)
    mesh.colors.emplace_back((1 + p.x) / 2, (1 + p.y) / 2, (1 + p.z) / 2, 1);
  for (const Scheme scheme : {Scheme::DooSabin, Scheme::CatmullClark}) {
    const SurfaceMesh surface = evaluate(mesh, *make_cpu_backend(), {.level = 2, .scheme = scheme});
    ASSERT_EQ(surface.colors.size(), surface.positions.size());
    std::map<std::array<double, 3>, glm::vec4> colors;
    int twice = 0;
    for (std::size_t row = 0; row < surface.positions.size(); ++row) {
      const glm::dvec3& p = surface.positions[row];
      const auto [known, is_new] = colors.try_emplace({p.x, p.y, p.z}, surface.colors[row]);
      twice += is_new ? 0 : 1;
      EXPECT_EQ(known->second, surface.colors[row]) << row;
    }
    EXPECT_EQ(twice, 16) << "4 edges in quarters";
    for (std::size_t row = 0; row < surface.base_vertices.size(); ++row)
      EXPECT_EQ(surface.colors[row], mesh.colors[surface.base_vertices[row]]) << row;
  }
}

TEST(Attributes, GroupsFollowTheirFaces) {
  const SurfaceMesh surface = surface_of(two_charts(), 2);
  ASSERT_EQ(surface.face_groups.size(), 32u);
  for (std::int64_t f = 0; f < 32; ++f) {
    double x = 0;
    for (const std::int32_t v : surface.face(f)) x += surface.positions[v].x / 4;
    EXPECT_EQ(surface.face_groups[f], x < 1 ? 0 : 1);
  }
  EXPECT_EQ(surface.groups[1].material, "blue");
}

TEST(Attributes, HolesShapeTheSurfaceButAreNoPartOfIt) {
  PolygonMesh mesh = test::torus(8, 6, 1.0, 0.4);
  const SurfaceMesh whole = surface_of(mesh, 1);
  mesh.hole_faces = {0, 5};
  const SurfaceMesh holed = surface_of(mesh, 1);
  EXPECT_EQ(holed.face_count(), whole.face_count() - 8);
  // The two holes have an edge in common: two centres and a midpoint leave with them.
  EXPECT_EQ(holed.positions.size(), whole.positions.size() - 3);
  EXPECT_EQ(holed.positions[holed.face_vertices[0]], whole.positions[whole.face_vertices[16]]);
  EXPECT_EQ(surface_quality(holed, mesh).folded_area, 0.0);
}

TEST(Attributes, AMissingTextureCoordinateIsNoCrash) {
  PolygonMesh mesh = two_charts();
  mesh.face_uvs[5] = -1;
  const SurfaceMesh surface = surface_of(mesh, 2);
  for (const std::int32_t uv : surface.face_uvs) {
    ASSERT_GE(uv, 0);
    ASSERT_LT(static_cast<std::size_t>(uv), surface.uvs.size());
  }
}

// Element counts of the levels 0 to `last` of a torus of side x side quads.
std::vector<LevelCounts> torus_levels(std::int64_t side, int last) {
  const std::int64_t count = side * side;
  return split_counts({count, 2 * count, count}, 4 * count, last);
}

TEST(MemoryNeed, GrowsFourfoldWithEachLevel) {
  const auto bytes = [](int level) {
    return static_cast<double>(tessellation_bytes(torus_levels(100, level), LastLevel::Full));
  };
  EXPECT_NEAR((bytes(5) - bytes(4)) / (bytes(4) - bytes(3)), 4.0, 0.01);
}

TEST(MemoryNeed, IndicesStayWithin32Bits) {
  EXPECT_THAT(
      test::message_of(ErrorCode::OutOfMemory,
                       [] { require_memory(torus_levels(1000, 6), LastLevel::Full, {}, ~0ull); }),
      testing::HasSubstr("32-bit"));
}

// The largest resident size since the last call, in bytes.
std::uint64_t peak_since_last_call() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kibibytes = 0;
  while (status >> word && word != "VmHWM:") {
  }
  status >> kibibytes;
  std::ofstream("/proc/self/clear_refs") << "5";
  return 1024 * kibibytes;
}

std::uint64_t peak_of_tessellating(const PolygonMesh& mesh) {
  const auto backend = make_cpu_backend();
  (void)peak_since_last_call();
  (void)evaluate(mesh, *backend, {.level = 4});
  return peak_since_last_call();
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(MemoryNeed, OfAttributesIsWhatTheyTake) {
  PolygonMesh mesh = test::torus(60, 60, 1.0, 0.4);
  const std::vector<LevelCounts> counts = torus_levels(60, 4);
  const auto estimate = [&] {
    return tessellation_bytes(counts, LastLevel::None, RefinedAttributes::of(mesh));
  };
  const std::uint64_t plain_peak = peak_of_tessellating(mesh), plain_estimate = estimate();
  const auto expect_estimated = [&](const char* what) {
    const auto taken = static_cast<double>(peak_of_tessellating(mesh) - plain_peak);
    const auto estimated = static_cast<double>(estimate() - plain_estimate);
    EXPECT_LT(taken, 1.05 * estimated) << what;
    EXPECT_GT(taken, 0.4 * estimated) << what;
  };
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  mesh.face_uvs = mesh.face_vertices;
  expect_estimated("uvs");
  mesh.colors.resize(mesh.positions.size(), glm::vec4(1.0f));
  mesh.groups = {{"a", "b"}};
  mesh.face_groups.resize(static_cast<std::size_t>(mesh.face_count()), 0);
  expect_estimated("uvs, colours, groups");
}
#endif

TEST(MemoryNeed, OfHolesIsASurfaceMore) {
  const std::vector<LevelCounts> counts = torus_levels(60, 4);
  const auto need = [&](const RefinedAttributes& attributes) {
    return static_cast<double>(tessellation_bytes(counts, LastLevel::Full, attributes));
  };
  // Positions, normals and the corners of quads of the surface that the copy is made from.
  const double surface = 36.0 * static_cast<double>(counts.back().vertices) +
                         16.0 * static_cast<double>(counts.back().faces);
  const double more = need({.holes = true}) - need({});
  EXPECT_GE(more, surface);
  EXPECT_LE(more, 2 * surface);
  EXPECT_GT(need({.colors = true, .holes = true}) - need({.colors = true}), more);
}

TEST(MemoryNeed, AttributesCountAgainstTheLimit) {
  PolygonMesh mesh = test::torus(50, 50, 1.0, 0.4);
  const std::uint64_t limit = tessellation_bytes(torus_levels(50, 2), LastLevel::Full);
  const auto refine = [&] {
    (void)evaluate(mesh, *make_cpu_backend(),
                   {.level = 2, .scheme = Scheme::CatmullClark, .memory_limit_bytes = limit});
  };
  EXPECT_NO_THROW(refine());
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  mesh.face_uvs = mesh.face_vertices;
  EXPECT_THROW(refine(), Error);
}

// What a writer of files holds does not grow with the level.
TEST(MemoryNeed, OfBlocksIsBoundedAndOfAWholeSurfaceIsNot) {
  const PolygonMesh mesh = test::torus(400, 400, 1.0, 0.4);
  const DooSabinSurface surface(mesh, {});
  constexpr std::uint64_t kLimit = std::uint64_t{2} << 30;
  EXPECT_NO_THROW((void)surface.level(5, kLimit));
  EXPECT_NO_THROW(surface.require_whole(3, kLimit, nullptr));
  EXPECT_THROW(surface.require_whole(5, kLimit, nullptr), Error);
  EXPECT_THROW((void)surface.level(5, 1u << 20), Error);
}

TEST(MemoryNeed, TheMachineHasSome) { EXPECT_GT(available_memory_bytes(), 1ull << 20); }

}  // namespace
}  // namespace planish
