#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <string>
#include <utility>
#include <vector>

#include "files/gltf/glb_bytes.h"
#include "picture.h"
#include "planish/core/error.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/job/page/render.h"
#include "support/calls.h"
#include "support/files.h"

namespace planish::render {
namespace {

// A latitude-longitude sphere of radius 1 with exact normals.
RenderMesh sphere() {
  constexpr int kRings = 24, kSlices = 48;
  RenderMesh mesh;
  for (int j = 0; j <= kRings; ++j) {
    for (int i = 0; i < kSlices; ++i) {
      const float v = 3.14159265f * j / kRings, u = 2 * 3.14159265f * i / kSlices;
      mesh.positions.emplace_back(std::sin(v) * std::sin(u), std::cos(v),
                                  std::sin(v) * std::cos(u));
    }
  }
  mesh.normals = mesh.positions;
  for (std::uint32_t j = 0; j < kRings; ++j) {
    for (std::uint32_t i = 0; i < kSlices; ++i) {
      const std::uint32_t a = j * kSlices + i, b = j * kSlices + (i + 1) % kSlices;
      for (const std::uint32_t corner : {a, a + kSlices, b + kSlices, a, b + kSlices, b}) {
        mesh.indices.push_back(corner);
      }
    }
  }
  return mesh;
}

PictureOptions small_picture() {
  PictureOptions options;
  options.width = 80;
  options.height = 60;
  return options;
}

TEST(Frame, PointsFillTheImageUpToTheMargin) {
  const RenderMesh mesh = sphere();
  ViewOptions options;
  options.margin = 0.1f;
  const Camera camera = frame(mesh.positions, 400, 300, options);
  float top = 1e9f, bottom = -1e9f, left = 1e9f, right = -1e9f;
  for (const glm::vec3& p : mesh.positions) {
    const glm::vec3 at = camera.project(p);
    left = std::min(left, at.x);
    right = std::max(right, at.x);
    top = std::min(top, at.y);
    bottom = std::max(bottom, at.y);
  }
  EXPECT_NEAR(top, 30, 0.1);
  EXPECT_NEAR(bottom, 270, 0.1);
  EXPECT_NEAR(left + right, 400, 1);
}

TEST(Frame, ZoomEnlargesAboutItsMiddle) {
  const std::vector<glm::vec3> points{{0, 0, 0}, {1, 2, 3}, {-2, 1, 0}};
  ViewOptions zoomed;
  zoomed.zoom = 3;
  zoomed.middle = {0.25f, 0.75f};
  const Camera whole = frame(points, 200, 100, {}), part = frame(points, 200, 100, zoomed);
  for (const glm::vec3& p : points) {
    const glm::vec2 expected =
        glm::vec2(100, 50) + 3.0f * (glm::vec2(whole.project(p)) - glm::vec2(50, 75));
    EXPECT_NEAR(part.project(p).x, expected.x, 1e-3f);
    EXPECT_NEAR(part.project(p).y, expected.y, 1e-3f);
  }
}

TEST(Frame, RayGoesThroughTheProjectedPoint) {
  const RenderMesh mesh = sphere();
  const Camera camera = frame(mesh.positions, 400, 300, {});
  for (const glm::vec3& p : mesh.positions) {
    const glm::vec3 ray = camera.ray(glm::vec2(camera.project(p)));
    EXPECT_LT(glm::distance(ray, glm::normalize(p - camera.eye)), 1e-5f);
  }
}

TEST(Rasterise, NearerTriangleWinsWhateverTheOrder) {
  const std::array<glm::vec3, 6> vertices{glm::vec3(0, 0, 1), {8, 0, 1}, {0, 8, 1},
                                          {0, 0, 2},          {4, 0, 2}, {0, 4, 2}};
  for (const auto& indices : {std::array<std::uint32_t, 6>{0, 1, 2, 3, 4, 5},
                              std::array<std::uint32_t, 6>{3, 4, 5, 0, 1, 2}}) {
    VisibilityBuffer buffer(8, 8);
    rasterise(vertices, indices, 0, 8, buffer);
    const std::uint32_t near = indices[0] == 3 ? 0 : 1;
    EXPECT_EQ(buffer.what[buffer.at(0, 0)], near);
    EXPECT_EQ(buffer.what[buffer.at(5, 0)], 1 - near);
    EXPECT_EQ(buffer.what[buffer.at(7, 7)], VisibilityBuffer::kNothing);
    EXPECT_EQ(std::count(buffer.what.begin(), buffer.what.end(), near), 10);
  }
}

TEST(Overlay, HidesBehindTheSurface) {
  const RenderMesh mesh = sphere();
  const Camera camera = frame(mesh.positions, 200, 200, {0, 0, 0.1f});
  std::vector<glm::vec3> projected;
  for (const glm::vec3& p : mesh.positions) projected.push_back(camera.project(p));
  VisibilityBuffer buffer(200, 200);
  rasterise(projected, mesh.indices, 0, 200, buffer);
  PolygonMesh points;
  points.positions = {{0, 0, 1}, {0.3, 0, -0.954}};  // facing the eye, and on the far side
  draw_overlay(points, camera, {}, buffer);
  EXPECT_EQ(buffer.what[buffer.at(100, 100)], kVertexSample);
  const glm::vec3 hidden = camera.project(glm::vec3(points.positions[1]));
  EXPECT_LT(buffer.what[buffer.at(static_cast<int>(hidden.x), static_cast<int>(hidden.y))],
            mesh.indices.size() / 3);
}

// Edges in the plane of a plate that is seen a little aslant.
TEST(Overlay, EdgesOnTheSurfaceAreAsWideAsWithoutIt) {
  const std::vector<glm::vec3> plate{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  const Camera camera = frame(plate, 200, 200, {.azimuth_degrees = 5, .elevation_degrees = 10});
  std::vector<glm::vec3> projected;
  for (const glm::vec3& p : plate) projected.push_back(camera.project(p));
  PolygonMesh edges;  // a smaller one in the same plane
  edges.positions = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0}};
  edges.add_face(std::array{0, 1, 2, 3});
  VisibilityBuffer alone(200, 200), with_plate(200, 200);
  rasterise(projected, std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}, 0, 200, with_plate);
  for (VisibilityBuffer* buffer : {&alone, &with_plate})
    draw_overlay(edges, camera, {.edge_width = 5, .vertex_width = 0}, *buffer);
  const auto drawn = [](const VisibilityBuffer& buffer) {
    return std::ranges::count(buffer.what, kEdgeSample);
  };
  EXPECT_GT(drawn(alone), 4 * 5 * 40);
  EXPECT_EQ(drawn(with_plate), drawn(alone));
}

// A plate above a larger one, both level: the lower one is in shadow below it, and nowhere else.
TEST(DomeLight, MeshesCastShadowsButNotOnTheirOwnLitSide) {
  RenderMesh mesh;
  for (const auto& [half, y] : {std::pair{1.0f, 0.4f}, std::pair{4.0f, 0.0f}}) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const auto& [x, z] :
         {std::pair{-1, -1}, std::pair{-1, 1}, std::pair{1, 1}, std::pair{1, -1}})
      mesh.positions.emplace_back(half * x, y, half * z);
    for (const std::uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh.indices.push_back(first + k);
  }
  const Camera camera = frame(mesh.positions, 100, 100, {});
  const DomeLight light(mesh, camera);
  const glm::vec3 up(0, 1, 0);
  const std::vector<float> lit =
      light.irradiance({{{0, 0.4f, 0}, up}, {{0, 0, 0}, up}, {{3.9f, 0, 3.9f}, up}});
  const float free = light.free_irradiance(up);
  EXPECT_NEAR(lit[0], free, 0.01f * free);
  EXPECT_LT(lit[1], 0.3f * free);
  EXPECT_GT(lit[2], 0.9f * free);
}

TEST(Picture, ValuesAreColouredOnASymmetricScale) {
  const glm::vec3 none = signed_colour(0), low = signed_colour(-1), high = signed_colour(1);
  EXPECT_GT(low.b, low.r + 0.1f);
  EXPECT_GT(high.r, high.b + 0.1f);
  EXPECT_LT(std::abs(none.r - none.b), 0.15f);
  EXPECT_EQ(signed_colour(-7), low);
  EXPECT_EQ(signed_colour(7), high);
  RenderMesh mesh = sphere();
  for (const glm::vec3& p : mesh.positions) mesh.values.push_back(20 * p.x);
  EXPECT_NEAR(usual_magnitude(mesh.values), 18.5f, 1.5f);
  PictureOptions options = small_picture();
  options.look = Look::Values;
  options.scale = 20;
  options.view = {0, 0};
  const auto pixels = draw_picture(mesh, options);
  const auto redder = [&](int x) {
    const std::size_t at = 3 * (30 * 80 + static_cast<std::size_t>(x));
    return static_cast<int>(pixels[at]) - static_cast<int>(pixels[at + 2]);
  };
  EXPECT_LT(redder(25), -20);
  EXPECT_GT(redder(55), 20);
}

TEST(Picture, SphereIsLitFromTheUpperLeftOnALightGround) {
  const PictureOptions options = small_picture();
  const auto pixels = draw_picture(sphere(), options);
  ASSERT_EQ(pixels.size(), 3u * 80 * 60);
  const auto at = [&](int x, int y) { return static_cast<int>(pixels[3 * (y * 80 + x)]); };
  EXPECT_GT(at(1, 1), 220);
  EXPECT_GT(at(33, 20), at(50, 45) + 40);
  EXPECT_LT(at(50, 45), at(1, 1));
  EXPECT_EQ(draw_picture(sphere(), options), pixels);
}

TEST(Picture, LightDoesNotDependOnWhereTheMeshIs) {
  const PictureOptions options = small_picture();
  RenderMesh moved = sphere();
  for (glm::vec3& p : moved.positions) p += glm::vec3(4, -8, 2);
  const auto here = draw_picture(sphere(), options), there = draw_picture(moved, options);
  ASSERT_EQ(here.size(), there.size());
  double sum = 0;
  for (std::size_t i = 0; i < here.size(); ++i) sum += std::abs(here[i] - there[i]);
  EXPECT_LT(sum / static_cast<double>(here.size()), 0.5);  // of 255
}

// Faces that look inward are seen from behind right up to the outline.
TEST(Picture, ASphereInsideOutLooksLikeASphere) {
  const PictureOptions options = small_picture();
  RenderMesh inside_out = sphere();
  for (glm::vec3& n : inside_out.normals) n = -n;
  for (std::size_t i = 0; i < inside_out.indices.size(); i += 3)
    std::swap(inside_out.indices[i], inside_out.indices[i + 1]);
  const auto right = draw_picture(sphere(), options), wrong = draw_picture(inside_out, options);
  ASSERT_EQ(right.size(), wrong.size());
  int largest = 0;
  for (std::size_t i = 0; i < right.size(); ++i)
    largest = std::max(largest, std::abs(right[i] - wrong[i]));
  EXPECT_LT(largest, 8);  // of 255
}

TEST(RenderMesh, HasTheTrianglesOfAllPrimitives) {
  SurfaceMesh surface;
  surface.level = 1;
  surface.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  surface.normals.assign(6, glm::vec3(0, 0, 1));
  surface.face_vertices = {0, 1, 2, 3, 1, 4, 5, 2};
  surface.groups = {{"", "red"}, {"", "green"}};  // a primitive each
  surface.face_groups = {0, 1};
  const test::TemporaryFolder folder;
  (void)write_gltf(folder.path() / "two.glb", surface, {});
  const RenderMesh mesh = read_glb(folder.path() / "two.glb");
  ASSERT_EQ(mesh.indices.size(), 12u);
  float area = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::vec3 a = mesh.positions[mesh.indices[i]], b = mesh.positions[mesh.indices[i + 1]],
                    c = mesh.positions[mesh.indices[i + 2]];
    area += 0.5f * glm::cross(b - a, c - a).z;
  }
  EXPECT_FLOAT_EQ(area, 2);
}

TEST(Curvature, IsTheDiagonalOverTheRadiusOnASphere) {
  // Diagonal 2 sqrt(3), radius 1; chords are a little shorter than arcs.
  for (const float curvature : curvature_of(sphere())) {
    EXPECT_NEAR(curvature, 2 * std::sqrt(3.0f), 0.02f);
  }
}

// What planish-render draws of a glTF: the meshes that the default scene places, where it does.

using test::values;

// Of the unit square with slanted normals.
RenderMesh read_squares(const std::string& scenes_and_nodes) {
  const float n = std::sqrt(0.5f);
  const std::string chunk =
      test::square_chunk() + values<float>({n, 0, n, n, 0, n, n, 0, n, n, 0, n});
  const std::string square =
      R"({"primitives":[{"attributes":{"POSITION":0,"NORMAL":2},"indices":1}]})";
  const std::string json =
      R"({"asset":{"version":"2.0"},)" + scenes_and_nodes + R"(,"meshes":[)" + square + "," +
      square +
      R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"},)"
      R"({"bufferView":2,"componentType":5126,"count":4,"type":"VEC3"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":48},)"
      R"({"buffer":0,"byteOffset":48,"byteLength":12},)"
      R"({"buffer":0,"byteOffset":60,"byteLength":48}],"buffers":[{"byteLength":108}]})";
  const test::TemporaryFolder folder;
  std::ofstream(folder.path() / "a.glb", std::ios::binary) << test::glb_of(json, chunk);
  return read_glb(folder.path() / "a.glb");
}

void expect_near(const glm::vec3& found, const glm::vec3& expected) {
  EXPECT_LT(glm::distance(found, expected), 1e-5f) << found.x << ' ' << found.y << ' ' << found.z;
}

// A quarter turn about x takes (x, y, z) to (x, -z, y); the scale mirrors.
TEST(RenderScene, MeshesStandWhereNodesPlaceThem) {
  const RenderMesh mesh = read_squares(
      R"("scene":1,"scenes":[{"nodes":[2]},{"nodes":[0]}],"nodes":[)"
      R"({"mesh":0,"translation":[1000000,0,0],"children":[1]},)"
      R"({"mesh":1,"translation":[10,0,0],"rotation":[0.70710678,0,0,0.70710678],"scale":[-2,3,4]},)"
      R"({"mesh":0,"translation":[5,5,5]}])");
  EXPECT_EQ(mesh.origin, glm::dvec3(1e6, 0, 0));
  ASSERT_EQ(mesh.positions.size(), 8u);
  EXPECT_THAT(mesh.indices, ::testing::ElementsAre(0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7));
  expect_near(mesh.positions[0], {0, 0, 0});
  expect_near(mesh.positions[2], {1, 1, 0});
  expect_near(mesh.positions[4], {10, 0, 0});
  expect_near(mesh.positions[5], {8, 0, 0});
  expect_near(mesh.positions[6], {8, 0, 3});
  expect_near(mesh.normals[2], {std::sqrt(0.5f), 0, std::sqrt(0.5f)});
  // By the inverse of the scale: (-1/2, 0, 1/4), turned.
  expect_near(mesh.normals[6], glm::normalize(glm::vec3(-2, -1, 0)));
}

TEST(RenderScene, ScenesWithoutTrianglesAreRefused) {
  EXPECT_THAT(
      test::message_of(
          ErrorCode::UnreadableInput,
          [&] { (void)read_squares(R"("scene":0,"scenes":[{"nodes":[]}],"nodes":[{"mesh":0}])"); }),
      ::testing::HasSubstr("places no triangles"));
}

}  // namespace
}  // namespace planish::render
