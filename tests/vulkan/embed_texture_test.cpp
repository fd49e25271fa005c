// Textured vertices: rows cut at seams, texture coordinates as in the files of `planish fit`,
// places, and tangents against finite differences of the limit surface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "planish/files/gltf/write_gltf.h"
#include "planish/files/mesh_file.h"
#include "planish/queries/limit_surface.h"
#include "planish/solve/backend.h"
#include "planish/surface/evaluate.h"
#include "planish/vulkan/host/system.h"
#include "support/temporary_folder.h"
#include "vulkan/embedding_fixture.h"
#include "vulkan/textured_meshes.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;

TEST(TexturedSystem, UvsAreThoseOfTheFile) {
  const test::TemporaryFolder folder;
  for (const PolygonMesh& mesh : textured_meshes())
    for (const int level : {0, 1, 2, 3}) {
      // Its given points are those that the cage's surface has.
      const PolygonMesh given = on_surface(mesh);
      const System system(given, {.level = level, .textured = true, .tolerance = 1e-9});
      const std::vector<glm::vec2> uvs = system.uvs();
      ASSERT_EQ(std::ssize(uvs), system.vertex_count());
      const SurfaceMesh surface =
          evaluate(mesh, *make_cpu_backend(), {.level = level, .rest_positions = given.positions});
      const std::filesystem::path path = folder.path() / "surface.glb";
      (void)write_gltf(path, surface, {});
      const PolygonMesh file = read_mesh(path).mesh;
      ASSERT_EQ(std::ssize(system.triangles()), std::ssize(file.face_uvs));
      std::size_t corner = 0;
      for (std::int64_t f = 0; f < surface.face_count(); ++f) {
        std::vector<glm::vec2> ours, theirs;
        for (const std::size_t end = corner + 3 * (surface.face(f).size() - 2); corner < end;
             ++corner) {
          ours.push_back(uvs[system.triangles()[corner]]);
          // The reader turns v over again, which is exact.
          const glm::dvec2 uv = file.uvs[file.face_uvs[corner]];
          theirs.emplace_back(static_cast<float>(uv.x), static_cast<float>(1 - uv.y));
        }
        for (const glm::vec2& uv : ours)
          ASSERT_TRUE(std::ranges::any_of(
              theirs, [&](const glm::vec2& other) { return glm::distance(uv, other) < 1e-5F; }))
              << "face " << f << " at level " << level;
      }
    }
}

TEST(TexturedSystem, HasNoMoreVerticesThanSeamsTake) {
  PolygonMesh mesh = with_charts(test::torus(9, 7, 2, 0.7), 1, 1);
  const System one(mesh, {.textured = true}), none(mesh);
  EXPECT_EQ(one.vertex_count(), none.vertex_count());
  EXPECT_TRUE(none.uvs().empty());
  EXPECT_TRUE(std::ranges::equal(one.triangles(), none.triangles()));
  // A seam of one edge: its inside twice, its ends once.
  mesh.uvs.push_back({9, 9});
  mesh.face_uvs[0] = static_cast<std::int32_t>(mesh.uvs.size()) - 1;
  const System seam(mesh, {.level = 3, .textured = true}), whole(mesh, {.level = 3});
  // The vertex of that corner, and two edges of seven places each.
  EXPECT_EQ(seam.vertex_count(), whole.vertex_count() + 1 + 2 * 7);
}

TEST(TexturedSystem, WantsTextureCoordinates) {
  try {
    const System system(test::cube(), {.textured = true});
    ADD_FAILURE() << "nothing thrown";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_THAT(error.what(), HasSubstr("no texture coordinates"));
  }
}

struct TexturedVertex {
  glm::vec3 position, normal;
  glm::vec4 tangent;
};

// The limit surface of the mesh itself as a cage, and its texture.
struct TextureOracle {
  // With the corners of the rest pose.
  TextureOracle(const PolygonMesh& cage, const PolygonMesh& rest)
      : mesh(cage),
        limit(std::make_shared<const DooSabinSurface>(
            mesh, EvaluateOptions{.rest_positions = rest.positions})) {}

  // The surface's texture coordinates at a corner's (s, t).
  [[nodiscard]] glm::dvec2 uv_at(std::int32_t corner, double s, double t) const {
    std::vector<std::int32_t> indices;
    std::vector<glm::dvec2> values;
    limit.surface().uv_field().columns(limit.surface().patches().corner_patch(corner), corner,
                                       indices, values);
    std::vector<glm::dvec3> points;
    for (const glm::dvec2& value : values) points.emplace_back(value - values[0], 0.0);
    PatchScratch scratch;
    return values[0] +
           glm::dvec2(patch_point(limit.form(corner), points, {s, t}, scratch).position);
  }
  [[nodiscard]] glm::dmat2 jacobian(std::int32_t corner, double s, double t) const {
    // By differences within the square, of second order.
    const auto derivative = [](double at, const auto& value) {
      const double h = 2e-5 * (at <= 0.5 ? 1 : -1);
      return (4.0 * value(at + h) - 3.0 * value(at) - value(at + 2 * h)) / (2 * h);
    };
    return {derivative(s, [&](double x) { return uv_at(corner, x, t); }),
            derivative(t, [&](double x) { return uv_at(corner, s, x); })};
  }
  [[nodiscard]] SurfacePoint at(std::int32_t corner, double s, double t) const {
    return limit.evaluate(surface_parameter(limit.topology(), corner, s, t));
  }
  // The point with its derivatives by the corner's s and t.
  [[nodiscard]] SurfacePoint by_corner(std::int32_t corner, double s, double t) const {
    SurfacePoint point = at(corner, s, t);
    const std::int32_t m = limit.topology().face_size(limit.topology().face_of(corner));
    if (m != 4) return point;
    // Of the face's parameters on a face of four.
    const std::int32_t turn = limit.topology().place_of(corner);
    const glm::dvec3 du = point.du, dv = point.dv;
    if (turn == 1) point.du = dv, point.dv = -du;
    if (turn == 2) point.du = -du, point.dv = -dv;
    if (turn == 3) point.du = -dv, point.dv = du;
    return point;
  }
  [[nodiscard]] bool is_half_plane(std::int32_t corner) const {
    return limit.surface().patches().corner_patch(corner).patch.kind == PatchKind::HalfPlane;
  }
  // Whether both edges leave a corner in one direction or against it, so that its derivatives span
  // no plane.
  [[nodiscard]] bool leaves_along_one_curve(std::int32_t corner) const {
    const SurfacePoint point = by_corner(corner, 0, 0);
    return glm::length(glm::cross(point.du, point.dv)) <
           1e-3 * glm::length(point.du) * glm::length(point.dv);
  }
  // Along u, v held, seen from a corner's square: by differences of positions within it, at its
  // border by its derivatives.
  [[nodiscard]] glm::dvec3 tangent(std::int32_t corner, double s, double t) const {
    const glm::dmat2 uv = jacobian(corner, s, t);
    const glm::dvec2 step = glm::inverse(uv) * glm::dvec2(1, 0);
    glm::dvec3 along;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
      const double h = 1e-5 / glm::length(step);
      // u grows by 2h, v by no more than its curvature.
      along = at(corner, s + h * step.x, t + h * step.y).position -
              at(corner, s - h * step.x, t - h * step.y).position;
    } else {
      const SurfacePoint point = by_corner(corner, s, t);
      along = step.x * point.du + step.y * point.dv;
    }
    const glm::dvec3 normal = at(corner, s, t).normal;
    return glm::normalize(along - glm::dot(along, normal) * normal);
  }

  PolygonMesh mesh;
  LimitSurface limit;
};

class EmbedTexture : public Embedding {
 protected:
  // With the mesh itself as the cage, through layouts of their own.
  std::vector<TexturedVertex> vertices_of(const PolygonMesh& mesh, const System& system) {
    const DeviceSystem tables(*context_, system);
    Buffer staging(*context_, tables.upload_bytes(), MemoryUse::Upload);
    tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
    staging.flush();
    const std::vector<glm::vec3> points(mesh.positions.begin(), mesh.positions.end());
    Buffer given(*context_, points.size() * sizeof points[0], MemoryUse::Upload);
    std::memcpy(given.mapped().data(), points.data(), points.size() * sizeof points[0]);
    given.flush();
    const auto count = static_cast<std::size_t>(system.vertex_count());
    Buffer vertices(*context_, count * sizeof(TexturedVertex), MemoryUse::Download);
    Buffer positions(*context_, count * 12, MemoryUse::Download);
    Buffer attributes(*context_, count * 8, MemoryUse::Download);
    const VertexLayout whole{
        .buffer = vertices.handle(), .stride = sizeof(TexturedVertex), .tangent_offset = 24};
    const VertexLayout compact{.buffer = positions.handle(),
                               .stride = 12,
                               .normal_offset = 4,
                               .normal_format = VertexFormat::Snorm10,
                               .attributes = {attributes.handle(), 0, 8},
                               .tangent_offset = 0,
                               .tangent_format = VertexFormat::Snorm10};
    const vulkan::Solve solve(*context_, tables,
                              {.given = {given.handle()},
                               .vertices = whole,
                               .further_slots = {{{given.handle()}, compact, {}}}});
    submitter_->run([&](VkCommandBuffer commands) {
      tables.record_upload(commands, staging.handle(), 0);
      solve.record_solve(commands, {.iterations = 0});
      solve.record_evaluate(commands);
      solve.record_evaluate(commands, {.slot = 1});
    });
    for (Buffer* buffer : {&vertices, &positions, &attributes}) buffer->invalidate();
    std::vector<TexturedVertex> result(count);
    std::memcpy(result.data(), vertices.mapped().data(), count * sizeof result[0]);
    std::vector<std::uint32_t> words(2 * count);
    std::memcpy(words.data(), attributes.mapped().data(), 8 * count);
    for (std::size_t i = 0; i < count; ++i) expect_same(result[i], words[2 * i]);
    return result;
  }
  // VK_FORMAT_A2B10G10R10_SNORM_PACK32.
  static void expect_same(const TexturedVertex& vertex, std::uint32_t word) {
    const auto signed_bits = [&](int shift, int count) {
      const auto bits = static_cast<std::int32_t>(word << (32 - shift - count));
      return bits >> (32 - count);
    };
    for (int k = 0; k < 3; ++k)
      ASSERT_NEAR(signed_bits(10 * k, 10) / 511.0, vertex.tangent[k], 0.5 / 511 + 1e-6);
    ASSERT_EQ(signed_bits(30, 2), vertex.tangent.w);
  }
};

TEST_F(EmbedTexture, PlacesAreTheVertices) {
  for (const PolygonMesh& mesh : textured_meshes()) {
    const System system(mesh, {.textured = true});
    const std::vector<TexturedVertex> vertices = vertices_of(mesh, system);
    const std::vector<SurfacePlace> places = system.places();
    const TextureOracle oracle(mesh, mesh);
    ASSERT_EQ(places.size(), vertices.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SurfacePoint point = oracle.limit.evaluate(
          {static_cast<std::int32_t>(places[i].face), places[i].u, places[i].v});
      ASSERT_LT(glm::distance(point.position, glm::dvec3(vertices[i].position)), 1e-6) << i;
    }
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto first = static_cast<std::size_t>(system.copied_vertices()[i]);
      ASSERT_EQ(vertices[i].position, vertices[first].position);
      if (system.surface_records().features.sharp_edge_count == 0) {
        ASSERT_EQ(vertices[i].normal, vertices[first].normal);
      }
    }
  }
}

// Every corner's square says where u grows at the rows of its samples. Where squares meet, the
// tangent lies between what they say.
TEST_F(EmbedTexture, TangentsAreTheSurfacesDerivatives) {
  with_both_variants([&] {
    for (const PolygonMesh& mesh : textured_meshes())
      for (const int level : {0, 1, 2, 3}) {
        SCOPED_TRACE("level " + std::to_string(level));
        const PolygonMesh rest = on_surface(mesh);
        const System system(rest, {.level = level, .textured = true, .tolerance = 1e-9});
        const PatchNumbering& numbering = system.surface_records().patches.numbering();
        const int n = level == 0 ? 1 : 1 << (level - 1);
        const TextureOracle oracle(mesh, rest);
        struct Said {
          std::vector<glm::dvec3> tangents;
          double area = 0, allowed = 3e-4;
        };
        std::vector<Said> said(static_cast<std::size_t>(system.vertex_count()));
        for (std::int32_t c = 0; c < oracle.limit.topology().corner_count(); ++c)
          for (int b = 0; b <= n; ++b)
            for (int a = 0; a <= n; ++a) {
              if (level == 0 && (a > 0 || b > 0)) continue;
              Said& row = said[level == 0 ? numbering.vertex_row(c) : numbering.row(c, a, b)];
              double u = double(a) / n, v = double(b) / n;
              // Beside the vertex instead, where the texture is continuous and its derivatives by
              // the square are not.
              if (a == 0 && b == 0 && oracle.leaves_along_one_curve(c))
                u = v = 1e-3, row.allowed = 0.02;
              // Edges of a half plane leave in no plane that all poses share.
              if (a == 0 && b == 0 && oracle.is_half_plane(c)) u = v = 1e-3, row.allowed = 0.2;
              row.tangents.push_back(oracle.tangent(c, u, v));
              row.area += glm::determinant(oracle.jacobian(c, u, v));
            }
        const std::vector<TexturedVertex> vertices = vertices_of(mesh, system);
        for (std::size_t i = 0; i < vertices.size(); ++i) {
          const glm::dvec3 tangent(vertices[i].tangent), normal(vertices[i].normal);
          ASSERT_NEAR(glm::length(tangent), 1, 1e-5) << i;
          ASSERT_NEAR(glm::dot(tangent, normal), 0, 1e-5) << i;
          double spread = 0;
          for (const glm::dvec3& x : said[i].tangents)
            for (const glm::dvec3& y : said[i].tangents)
              spread = std::max(spread, glm::distance(x, y));
          if (spread > 1.5) continue;  // charts that are turned over meet
          for (const glm::dvec3& expected : said[i].tangents)
            ASSERT_LT(glm::distance(tangent, expected), spread + said[i].allowed)
                << i << " of " << vertices.size() << ", " << said[i].tangents.size();
          if (std::abs(said[i].area) > 1e-6) {
            ASSERT_EQ(vertices[i].tangent.w, said[i].area < 0 ? -1 : 1) << i;
          }
        }
      }
  });
}

// What an edit writes are the words of an evaluation of all, in each instance.
TEST_F(EmbedTexture, EditsAndInstancesHaveTangents) {
  const PolygonMesh mesh = with_charts(test::torus(9, 7, 2, 0.7), 5, 1);
  const System system(mesh, {.textured = true});
  const DeviceSystem tables(*context_, system, {.takes_edits = true});
  Buffer staging(*context_, tables.upload_bytes(), MemoryUse::Upload);
  tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
  staging.flush();
  std::vector<glm::vec3> points;
  for (int k = 0; k < 2; ++k)
    for (const glm::dvec3& p : mesh.positions) points.emplace_back(p * (1 + 0.5 * k));
  Buffer given(*context_, points.size() * sizeof points[0], MemoryUse::Upload);
  Buffer moves(*context_, 8, MemoryUse::Upload);
  const auto count = static_cast<std::size_t>(system.vertex_count());
  Buffer vertices(*context_, 2 * count * sizeof(TexturedVertex), MemoryUse::Download);
  const vulkan::Solve solve(*context_, tables,
                            {.given = {given.handle()},
                             .vertices = {.buffer = vertices.handle(),
                                          .stride = sizeof(TexturedVertex),
                                          .tangent_offset = 24},
                             .instances = 2,
                             .moved = {moves.handle(), 0, 1}});
  const auto give = [&] {
    std::memcpy(given.mapped().data(), points.data(), given.size());
    given.flush();
  };
  const auto fetch = [&] {
    vertices.invalidate();
    std::vector<TexturedVertex> result(2 * count);
    std::memcpy(result.data(), vertices.mapped().data(), vertices.size());
    return result;
  };
  give();
  submitter_->run([&](VkCommandBuffer commands) {
    tables.record_upload(commands, staging.handle(), 0);
    solve.record_solve(commands, iterations(20));
    solve.record_evaluate(commands);
  });
  const std::vector<TexturedVertex> before = fetch();
  const auto moved = static_cast<std::uint32_t>(mesh.positions.size()) + 3;
  points[moved] += glm::vec3(0.1f, -0.05f, 0.2f);
  give();
  const std::uint32_t list[] = {1, moved};
  std::memcpy(moves.mapped().data(), list, sizeof list);
  moves.flush();
  submitter_->run(
      [&](VkCommandBuffer commands) { solve.record_edit(commands, {.iterations = 12}); });
  const std::vector<TexturedVertex> edited = fetch();
  submitter_->run([&](VkCommandBuffer commands) { solve.record_evaluate(commands); });
  const std::vector<TexturedVertex> all = fetch();
  EXPECT_EQ(std::memcmp(edited.data(), all.data(), vertices.size()), 0);
  for (std::size_t i = 0; i < count; ++i) {
    // The second instance is the first one's, half as large again.
    ASSERT_LT(glm::distance(glm::vec3(before[i].tangent), glm::vec3(before[count + i].tangent)),
              1e-4);
    ASSERT_EQ(std::memcmp(&all[i], &before[i], sizeof all[i]), 0);
  }
  EXPECT_NE(std::memcmp(&all[count], &before[count], count * sizeof all[0]), 0);
}

}  // namespace
}  // namespace planish::testing
