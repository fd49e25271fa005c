#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "planish/core/error.h"
#include "planish/mesh/check.h"
#include "planish/mesh/face_geometry.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/level_one_mesh.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

// Level 1 of the surface of an ordinary cage: one Doo-Sabin step.
LevelOne first_step(const PolygonMesh& cage, const SharpFeatureOptions& sharp = {},
                    Weights weights = Weights::DooSabin) {
  const DooSabinSurface base(cage, {.weights = weights, .sharp = sharp});
  LevelOne result;
  result.placement = base.placement();
  result.state.assign(base.state().begin(), base.state().end());
  return result;
}

std::vector<NamedMesh> smooth_net_meshes() {
  return {{"cube", cube()},
          {"prism", prism(9)},
          {"bipyramid", bipyramid(7)},
          {"torus", torus(6, 5, 1.0, 0.4)},
          {"icosphere", jittered(icosphere(2), 0.05, 3)},
          {"random", random_closed_mesh(5)}};
}

std::vector<NamedMesh> sharp_net_meshes() {
  std::vector<NamedMesh> meshes = {
      {"grid", flat_grid(4, 3)}, {"hole", plate_with_hole(5)},
      {"fan", open_fan(5)},      {"polygon", single_polygon(6)},
      {"L", l_shaped_plate(2)},  {"valence two", cube_with_split_edges()}};
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    meshes.push_back({"open " + std::to_string(seed), random_open_mesh(seed)});
    meshes.push_back({"creased " + std::to_string(seed),
                      with_random_creases(random_open_mesh(seed), 0.2, seed)});
    meshes.push_back({"closed, creased " + std::to_string(seed),
                      with_random_creases(random_closed_mesh(seed), 0.1, seed)});
  }
  PolygonMesh cone = icosphere(1);
  cone.corners = {{3, kInfiniteSharpness}};
  meshes.push_back({"cone", cone});
  return meshes;
}

// Closed, open and creased, with darts and a cone.
std::vector<NamedMesh> net_meshes() {
  std::vector<NamedMesh> meshes = smooth_net_meshes();
  for (NamedMesh& mesh : sharp_net_meshes()) meshes.push_back(std::move(mesh));
  return meshes;
}

TEST(LevelOne, OfAnOrdinaryCageGivesTheSameBits) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : net_meshes()) {
    for (const BoundaryRule boundary : {BoundaryRule::Edge, BoundaryRule::EdgeAndCorner}) {
      for (int level = 0; level <= 2; ++level) {
        EvaluateOptions options{.level = level, .weights = Weights::Averaged};
        options.sharp.boundary = boundary;
        const LevelOne level_one = first_step(mesh, options.sharp, options.weights);
        const SurfaceMesh expected = evaluate(mesh, *backend, options);
        const SurfaceMesh surface = evaluate(mesh, level_one, *backend, options);
        EXPECT_EQ(surface.positions, expected.positions) << name << " level " << level;
        EXPECT_EQ(surface.normals, expected.normals) << name << " level " << level;
        EXPECT_EQ(surface.face_vertices, expected.face_vertices);
      }
    }
  }
}

TEST(LevelOne, CarriesWhatRidesOnTheMesh) {
  PolygonMesh mesh = torus(8, 6, 1.0, 0.4);
  mesh.positions.insert(mesh.positions.begin(), glm::dvec3(9, 9, 9));  // unused
  for (auto& v : mesh.face_vertices) ++v;
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    mesh.face_uvs.insert(mesh.face_uvs.end(), {0, 1, 2, 3});
    mesh.face_groups.push_back(f % 2);
  }
  mesh.groups = {{"even", "a"}, {"odd", "b"}};
  mesh.colors.assign(mesh.positions.size(), glm::vec4(1, 0, 0, 1));
  mesh.hole_faces = {2};
  const auto backend = make_cpu_backend();
  const SurfaceMesh expected = evaluate(mesh, *backend, {.level = 2});
  const SurfaceMesh surface = evaluate(mesh, first_step(mesh), *backend, {.level = 2});
  EXPECT_EQ(surface.positions, expected.positions);
  EXPECT_EQ(surface.base_vertices, expected.base_vertices);
  EXPECT_EQ(surface.face_uvs, expected.face_uvs);
  EXPECT_EQ(surface.face_groups, expected.face_groups);
  EXPECT_EQ(surface.colors, expected.colors);
  EXPECT_EQ(surface.face_count(), 47 * 16);
}

TEST(LevelOne, AStateOfAnotherSizeIsRefused) {
  LevelOne level_one = first_step(cube());
  level_one.state.pop_back();
  for (const std::function<void()>& use :
       {std::function<void()>([&] { (void)evaluate(cube(), level_one, *make_cpu_backend()); }),
        std::function<void()>([&] { (void)level_one_mesh(cube(), level_one, {}); })})
    EXPECT_THAT(message_of(ErrorCode::InvalidArgument, use),
                testing::HasSubstr("24 control points, and 23"));
}

TEST(LevelOne, LimitPositionsAreThoseOfTheSurface) {
  for (const auto& [name, mesh] : net_meshes()) {
    const auto limits = limit_positions(mesh, first_step(mesh), {});
    const auto expected = limit_positions(mesh, Weights::DooSabin, {});
    for (std::size_t v = 0; v < limits.size(); ++v) {
      EXPECT_LT(glm::length(limits[v] - expected[v]), 1e-14) << name << " vertex " << v;
    }
  }
}

// On closed smooth meshes it is a cage: of the same surface, whose vertices (the limit points at
// the middles of its faces) are those of the first quad split.
TEST(LevelOneMesh, OfAClosedSmoothMeshIsADooSabinCage) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, mesh] : smooth_net_meshes()) {
    // Any interpolating net will do; this one is no Doo-Sabin step of a cage.
    LevelOne level_one = first_step(mesh);
    for (std::size_t i = 0; i < level_one.state.size(); ++i) {
      level_one.state[i] *= 1.0 + 0.05 * static_cast<double>(i % 7);
    }
    const PolygonMesh cage = level_one_mesh(mesh, level_one, {});
    const SurfaceMesh expected = evaluate(mesh, level_one, *backend, {.level = 1});
    const SurfaceMesh surface = evaluate(cage, *backend, {.level = 1});
    const auto first = static_cast<std::size_t>(cage.vertex_count());
    ASSERT_EQ(static_cast<std::size_t>(cage.face_count()), expected.positions.size());
    for (std::size_t i = 0; i < expected.positions.size(); ++i) {
      EXPECT_LT(glm::length(surface.positions[first + i] - expected.positions[i]), 1e-13)
          << name << " face " << i;
      EXPECT_LT(glm::length(surface.normals[first + i] - expected.normals[i]), 1e-6f)
          << name << " face " << i;
    }
  }
}

TEST(LevelOneMesh, ASharpEdgeHasAQuadOnEachSide) {
  PolygonMesh mesh = cube();
  mesh.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  const PolygonMesh net = level_one_mesh(mesh, first_step(mesh), {});
  // 4 smooth vertices and 4 with two sectors, 6 faces, 8 smooth edges and 4 with two quads.
  EXPECT_EQ(net.face_count(), 4 + 8 + 6 + 8 + 8);
  EXPECT_EQ(net.vertex_count(), 24 + 8);
  // Every segment of the closed curve is tagged: 4 edges' and 4 vertices'.
  EXPECT_EQ(net.creases.size(), 8u);
  for (const CreaseEdge& crease : net.creases) {
    EXPECT_GE(std::min(crease.v0, crease.v1), 24);
  }
}

TEST(LevelOneMesh, CarriesColoursAndGroups) {
  PolygonMesh mesh = flat_grid(2, 1);
  mesh.groups = {{"left", "red"}, {"right", "blue"}};
  mesh.face_groups = {0, 1};
  for (const glm::dvec3& p : mesh.positions) mesh.colors.emplace_back(p.x / 2, p.y, 0, 1);
  mesh.attributes = {{"x", {}, 1}};
  for (const glm::dvec3& p : mesh.positions)
    mesh.attributes[0].values.push_back(static_cast<float>(p.x));
  const LevelOne level_one = first_step(mesh);
  const PolygonMesh net = level_one_mesh(mesh, level_one, {});
  ASSERT_EQ(net.colors.size(), net.positions.size());
  ASSERT_EQ(net.attributes[0].count(), net.positions.size());
  // Quads of a grid: colours are linear in the position, as the control points are.
  for (std::size_t i = 0; i < net.positions.size(); ++i) {
    EXPECT_NEAR(net.colors[i].r, net.positions[i].x / 2, 1e-6) << i;
    EXPECT_NEAR(net.colors[i].g, net.positions[i].y, 1e-6) << i;
    EXPECT_NEAR(net.attributes[0].values[i], net.positions[i].x, 1e-6) << i;
  }
  ASSERT_EQ(net.face_groups.size(), static_cast<std::size_t>(net.face_count()));
  for (std::int32_t f = 0; f < net.face_count(); ++f) {
    double least = 2, greatest = 0;
    for (const std::int32_t v : net.face(f)) {
      least = std::min(least, net.positions[v].x);
      greatest = std::max(greatest, net.positions[v].x);
    }
    if (greatest < 1) {
      EXPECT_EQ(net.face_groups[f], 0);
    }
    if (least > 1) {
      EXPECT_EQ(net.face_groups[f], 1);
    }
  }
}

// Some faces of every mesh.
PolygonMesh with_holes(PolygonMesh mesh, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (random() % 3 == 0) mesh.hole_faces.push_back(f);
  }
  return mesh;
}

double area_of(const PolygonMesh& mesh, bool holes) {
  const std::set<std::int32_t> tagged(mesh.hole_faces.begin(), mesh.hole_faces.end());
  double area = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (tagged.contains(f) == holes) {
      area += glm::length(area_vector(mesh.positions, mesh.face(f)));
    }
  }
  return area;
}

std::set<std::pair<std::int32_t, std::int32_t>> boundary_of(const PolygonMesh& mesh) {
  std::set<std::pair<std::int32_t, std::int32_t>> edges;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t i = 0; i < face.size(); ++i) {
      const std::pair edge(face[i], face[(i + 1) % face.size()]);
      if (edges.erase({edge.second, edge.first}) == 0) edges.insert(edge);
    }
  }
  return edges;
}

double crease_length(const PolygonMesh& mesh) {
  double length = 0;
  for (const CreaseEdge& crease : mesh.creases)
    length += glm::distance(mesh.positions[crease.v0], mesh.positions[crease.v1]);
  return length;
}

TEST(LevelOneMesh, IsUsableAndHolesCutPolygonsAndLeaveNoGap) {
  for (const auto& [name, whole] : net_meshes()) {
    for (const PolygonMesh& mesh :
         {whole, with_holes(whole, 1), with_holes(whole, 2), with_holes(whole, 3)}) {
      const LevelOne level_one = first_step(mesh);
      const PolygonMesh net = level_one_mesh(mesh, level_one, {});
      const auto problems = check(net);
      EXPECT_TRUE(problems.empty()) << name << ": " << problems.front().message;
      std::vector<bool> used(net.positions.size());
      for (const std::int32_t v : net.face_vertices) used[v] = true;
      EXPECT_EQ(std::accumulate(used.begin(), used.end(), 0u), net.positions.size()) << name;
      // The net's borders are those that it has without holes, whose segments a cut may halve:
      // none at all where the mesh is closed.
      const PolygonMesh without = level_one_mesh(whole, level_one, {});
      EXPECT_NEAR(crease_length(net), crease_length(without), 1e-12) << name;
      const auto plain = boundary_of(without);
      const auto cut = boundary_of(net);
      if (plain.empty()) {
        EXPECT_TRUE(cut.empty()) << name;
      }
      EXPECT_LE(cut.size(), 2 * plain.size()) << name;
      EXPECT_EQ(net.hole_faces.empty(), mesh.hole_faces.empty()) << name;
    }
  }
}

// The net of a flat grid is flat and reaches as far, so that tagged parts have the holes' area.
TEST(LevelOneMesh, HolesKeepTheirArea) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const PolygonMesh mesh = with_holes(flat_grid(7, 5), seed);
    const SharpFeatureOptions sharp{.boundary = BoundaryRule::EdgeAndCorner};
    const PolygonMesh net = level_one_mesh(mesh, first_step(mesh, sharp), sharp);
    EXPECT_NEAR(area_of(net, true), static_cast<double>(mesh.hole_faces.size()), 1e-12);
    EXPECT_NEAR(area_of(net, false), 35.0 - static_cast<double>(mesh.hole_faces.size()), 1e-12);
  }
}

TEST(LevelOneMesh, TheCageGivesTheStateBack) {
  const auto backend = make_cpu_backend();
  for (const auto& [name, whole] : net_meshes()) {
    PolygonMesh mesh = with_holes(whole, 4);
    mesh.positions.insert(mesh.positions.begin(), glm::dvec3(9, 9, 9));  // unused
    for (auto& v : mesh.face_vertices) ++v;
    for (CreaseEdge& crease : mesh.creases) ++crease.v0, ++crease.v1;
    for (CornerVertex& corner : mesh.corners) ++corner.vertex;
    const LevelOne level_one = first_step(mesh);
    const LevelOne again = level_one_of_cage(mesh, level_one_mesh(mesh, level_one, {}), {});
    const SurfaceMesh expected = evaluate(mesh, level_one, *backend, {.level = 1});
    const SurfaceMesh surface = evaluate(mesh, again, *backend, {.level = 1});
    EXPECT_EQ(surface.face_vertices, expected.face_vertices) << name;
    ASSERT_EQ(surface.positions.size(), expected.positions.size()) << name;
    for (std::size_t i = 0; i < surface.positions.size(); ++i) {
      EXPECT_LT(glm::length(surface.positions[i] - expected.positions[i]), 1e-13) << name;
    }
  }
}

TEST(LevelOneMesh, AForeignCageIsRefused) {
  const auto message = [](const PolygonMesh& mesh, const PolygonMesh& cage) {
    return message_of(ErrorCode::InvalidArgument, [&] { (void)level_one_of_cage(mesh, cage, {}); });
  };
  const PolygonMesh box = cube();
  PolygonMesh cage = level_one_mesh(box, first_step(box), {});
  EXPECT_EQ(message(box, cage), "no error");
  std::swap(cage.face_vertices[0], cage.face_vertices[1]);
  EXPECT_THAT(message(box, cage), testing::HasSubstr("face 0 has other corners"));
  EXPECT_THAT(message(prism(5), cage), testing::HasSubstr("30 control points, and 24 are given"));
  EXPECT_THAT(message(tetrahedron(), cage), testing::HasSubstr("26 faces for 14"));
}

// One coordinate a vertex.
PolygonMesh with_vertex_uvs(PolygonMesh mesh) {
  for (const glm::dvec3& p : mesh.positions) {
    mesh.uvs.emplace_back(p.x + 0.3 * p.y * p.y, p.z - 0.2 * p.x * p.y);
  }
  mesh.face_uvs = mesh.face_vertices;
  return mesh;
}

PolygonMesh net_of(const PolygonMesh& mesh, const SharpFeatureOptions& sharp = {}) {
  return level_one_mesh(mesh, first_step(mesh, sharp), sharp);
}

TEST(LevelOneUvs, AreLinearWhereTheGridIs) {
  PolygonMesh mesh = flat_grid(6, 4);
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

// Of a face's corners.
glm::dvec2 mean_uv(const PolygonMesh& mesh, std::int32_t face) {
  glm::dvec2 sum(0.0);
  for (std::int32_t c = mesh.face_offsets[face]; c < mesh.face_offsets[face + 1]; ++c)
    sum += mesh.uvs[mesh.face_uvs[c]];
  return sum / static_cast<double>(mesh.face_size(face));
}

// The middles of the polygons around vertices, which interpolate them.
TEST(LevelOneUvs, GivenVerticesKeepTheirs) {
  for (const auto& [name, plain] : smooth_net_meshes()) {
    const PolygonMesh mesh = with_vertex_uvs(plain);
    const PolygonMesh net = net_of(mesh);
    for (std::int32_t v = 0; v < mesh.vertex_count(); ++v)
      EXPECT_LT(glm::distance(mean_uv(net, v), mesh.uvs[v]), 1e-12) << name;
  }
}

TEST(LevelOneUvs, ChartsGoOnAcrossTheirSeams) {
  constexpr int kAround = 8, kAcross = 6;
  // A torus cut open along two circles: a seam of each.
  const PolygonMesh mesh = mapped_grid(kAround, kAcross, true, true, [](double u, double v) {
    const double a = 2 * M_PI * u, b = 2 * M_PI * v, radius = 1 + 0.4 * std::cos(b);
    return glm::dvec3(radius * std::cos(a), radius * std::sin(a), 0.4 * std::sin(b));
  });
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
    double nearest = 1;
    for (std::size_t c = 0; c < mesh.face_vertices.size(); ++c)
      if (mesh.face_vertices[c] == v)
        nearest = std::min(nearest, glm::distance(mean_uv(net, v), mesh.uvs[mesh.face_uvs[c]]));
    EXPECT_LT(nearest, 1e-12) << v;
  }
}

// Every given face has a polygon within it, whose corners are near the face's in its own chart.
TEST(LevelOneUvs, CreasesHolesAndCornersStayInTheirCharts) {
  for (const auto& [name, plain] : net_meshes()) {
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
  PolygonMesh mesh = with_vertex_uvs(cube());
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
}  // namespace planish::test
