#include "planish/surface/level_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <glm/geometric.hpp>

#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

PolygonMesh mixed_mesh() { return test::prism(5); }

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
    for (const PolygonMesh& mesh : {mixed_mesh(), test::cube(), test::plate_with_hole(5)}) {
      expect_mesh_faces(mesh, evaluate(mesh, *make_cpu_backend(), {.level = level}));
    }
  }
}

TEST(LevelFaces, HolesAreLeftOut) {
  PolygonMesh mesh = mixed_mesh();
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

}  // namespace
}  // namespace planish
