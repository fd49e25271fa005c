#include "planish/surface/level_one_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"
#include "surface/level_one_states.h"

namespace planish {
namespace {

// One coordinate a vertex.
PolygonMesh with_vertex_uvs(PolygonMesh mesh) {
  for (const glm::dvec3& p : mesh.positions) {
    mesh.uvs.emplace_back(p.x + 0.3 * p.y * p.y, p.z - 0.2 * p.x * p.y);
  }
  mesh.face_uvs = mesh.face_vertices;
  return mesh;
}

// A torus cut open along two circles: a seam of each, coordinates linear in the place.
PolygonMesh unrolled_torus(int around, int across) {
  PolygonMesh mesh = test::torus(around, across, 1.0, 0.4);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    // Corners by angle, the cell's own first.
    glm::dvec2 low(2.0);
    std::vector<glm::dvec2> uvs;
    for (const std::int32_t v : mesh.face(f)) {
      const glm::dvec3& p = mesh.positions[v];
      const double tube = std::atan2(p.z, std::hypot(p.x, p.y) - 1.0);
      uvs.emplace_back(std::atan2(p.y, p.x) / (2 * M_PI), tube / (2 * M_PI));
      for (int i = 0; i < 2; ++i) uvs.back()[i] -= std::floor(uvs.back()[i] + 1e-9);
    }
    for (int i = 0; i < 2; ++i) {
      const auto [least, most] = std::minmax_element(
          uvs.begin(), uvs.end(), [&](const auto& a, const auto& b) { return a[i] < b[i]; });
      if ((*most)[i] - (*least)[i] < 0.5) continue;
      for (glm::dvec2& uv : uvs) uv[i] += uv[i] < 0.5 ? 1.0 : 0.0;
    }
    for (const glm::dvec2& uv : uvs) {
      mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
      mesh.uvs.push_back(uv);
    }
  }
  return mesh;
}

PolygonMesh net_of(const PolygonMesh& mesh, const SharpFeatureOptions& sharp = {}) {
  return level_one_mesh(mesh, test::first_step(mesh, sharp), sharp);
}

TEST(LevelOneUvs, AreLinearWhereTheGridIs) {
  PolygonMesh mesh = test::flat_grid(6, 4);
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(2 * p.x + p.y, 1 - p.x);
  mesh.face_uvs = mesh.face_vertices;
  mesh.hole_faces = {0, 8, 9, 14};
  const PolygonMesh net = net_of(mesh, {.boundary = BoundaryRule::EdgeAndCorner});
  ASSERT_EQ(net.face_uvs.size(), net.face_vertices.size());
  for (std::size_t c = 0; c < net.face_uvs.size(); ++c) {
    const glm::dvec3& p = net.positions[net.face_vertices[c]];
    const glm::dvec2 expected(2 * p.x + p.y, 1 - p.x);
    EXPECT_LT(glm::distance(net.uvs[net.face_uvs[c]], expected), 1e-13) << c;
  }
}

// The middles of the polygons around vertices, which interpolate them.
TEST(LevelOneUvs, GivenVerticesKeepTheirs) {
  for (const auto& [name, plain] : test::smooth_net_meshes()) {
    const PolygonMesh mesh = with_vertex_uvs(plain);
    const PolygonMesh net = net_of(mesh);
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
      glm::dvec2 mean(0.0);
      for (std::int32_t c = net.face_offsets[v]; c < net.face_offsets[v + 1]; ++c)
        mean += net.uvs[net.face_uvs[c]] / static_cast<double>(net.face_size(v));
      EXPECT_LT(glm::distance(mean, mesh.uvs[v]), 1e-12) << name;
    }
  }
}

TEST(LevelOneUvs, ChartsGoOnAcrossTheirSeams) {
  constexpr int kAround = 8, kAcross = 6;
  const PolygonMesh mesh = unrolled_torus(kAround, kAcross);
  const PolygonMesh net = net_of(mesh);
  ASSERT_EQ(net.face_uvs.size(), net.face_vertices.size());
  // Without the seams every polygon is half a cell wide; across one it still is.
  for (std::int32_t f = 0; f < net.face_count(); ++f) {
    glm::dvec2 low(10.0), high(-10.0);
    for (std::int32_t c = net.face_offsets[f]; c < net.face_offsets[f + 1]; ++c) {
      low = glm::min(low, net.uvs[net.face_uvs[c]]);
      high = glm::max(high, net.uvs[net.face_uvs[c]]);
    }
    EXPECT_NEAR(high.x - low.x, 0.5 / kAround, 1e-12) << f;
    EXPECT_NEAR(high.y - low.y, 0.5 / kAcross, 1e-12) << f;
  }
  // At the vertex where four charts meet the polygon's mean is the coordinate of one of them.
  for (std::int32_t v = 0; v < mesh.vertex_count(); ++v) {
    glm::dvec2 mean(0.0);
    for (std::int32_t c = net.face_offsets[v]; c < net.face_offsets[v + 1]; ++c) {
      mean += net.uvs[net.face_uvs[c]] / 4.0;
    }
    double nearest = 1;
    for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c) {
      if (mesh.face_vertices[c] == v) {
        nearest = std::min(nearest, glm::distance(mean, mesh.uvs[mesh.face_uvs[c]]));
      }
    }
    EXPECT_LT(nearest, 1e-12) << v;
  }
}

// Every given face has a polygon within it, whose corners are near the face's in its own chart.
TEST(LevelOneUvs, CreasesHolesAndCornersStayInTheirCharts) {
  for (const auto& [name, plain] : test::net_meshes()) {
    PolygonMesh mesh = plain;
    // Each face a chart of its own, far from the others.
    for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
      if (f % 3 == 0) mesh.hole_faces.push_back(f);
      for (std::int32_t i = 0; i < mesh.face_size(f); ++i) {
        const double angle = 2 * M_PI * i / mesh.face_size(f);
        mesh.face_uvs.push_back(static_cast<std::int32_t>(mesh.uvs.size()));
        mesh.uvs.emplace_back(10.0 * f + std::cos(angle), std::sin(angle));
      }
    }
    const PolygonMesh net = net_of(mesh);
    ASSERT_EQ(net.face_uvs.size(), net.face_vertices.size()) << name;
    for (std::int32_t f = 0; f < net.face_count(); ++f) {
      const double chart = std::round(net.uvs[net.face_uvs[net.face_offsets[f]]].x / 10);
      for (std::int32_t c = net.face_offsets[f]; c < net.face_offsets[f + 1]; ++c) {
        const glm::dvec2 uv = net.uvs[net.face_uvs[c]] - glm::dvec2(10 * chart, 0);
        EXPECT_LT(glm::length(uv), 3.0) << name << " face " << f;
      }
    }
  }
}

TEST(LevelOneUvs, WhereOneLacksThePolygonHasNone) {
  PolygonMesh mesh = with_vertex_uvs(test::cube());
  mesh.face_uvs[0] = -1;
  const PolygonMesh net = net_of(mesh);
  for (std::int32_t f = 0; f < net.face_count(); ++f) {
    bool lacks = false;
    for (const std::int32_t v : net.face(f)) lacks = lacks || v < 4;  // points of face 0
    for (std::int32_t c = net.face_offsets[f]; c < net.face_offsets[f + 1]; ++c) {
      EXPECT_EQ(net.face_uvs[c] < 0, lacks) << f;
    }
  }
}

}  // namespace
}  // namespace planish
