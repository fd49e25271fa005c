#include "planish/surface/level_faces.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"
#include "support/meshes.h"

namespace planish {
namespace {

// A 2 x 1 grid whose two quads have texture coordinates of their own: a seam on x = 1.
PolygonMesh two_charts() {
  PolygonMesh mesh = test::flat_grid(2, 1);
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {5, 5}, {6, 5}, {6, 6}, {5, 6}};
  mesh.face_uvs = {0, 1, 2, 3, 4, 5, 6, 7};
  mesh.colors = {{0, 0, 0, 1}, {0.5, 0, 0, 1}, {1, 0, 0, 1},
                 {0, 1, 0, 1}, {0.5, 1, 0, 1}, {1, 1, 0, 1}};
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

// Vertices of several normals are several rows, each with the colour of its vertex. With all edges
// sharp the cube's faces stay flat, so that a colour that is its place at the corners is so
// everywhere.
TEST(Attributes, FurtherRowsHaveTheColourOfTheirVertex) {
  PolygonMesh mesh = test::cube();
  for (const glm::dvec3& p : mesh.positions) mesh.colors.emplace_back(0.5 * p + 0.5, 1);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f)
    for (int i = 0; i < 4; ++i)
      mesh.creases.push_back({mesh.face(f)[i], mesh.face(f)[(i + 1) % 4]});
  const SurfaceMesh surface =
      evaluate(mesh, *make_cpu_backend(), {.level = 1, .scheme = Scheme::CatmullClark});
  ASSERT_EQ(surface.positions.size(), 6u * 9u);  // nothing is shared between faces
  for (std::size_t row = 0; row < surface.positions.size(); ++row) {
    const glm::dvec3 wanted = 0.5 * surface.positions[row] + 0.5;
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(surface.colors[row][axis], wanted[axis], 1e-6) << row;
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

}  // namespace
}  // namespace planish
