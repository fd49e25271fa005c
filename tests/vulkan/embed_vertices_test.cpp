#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
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
#include "support/files.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// Vertices in compact formats and in two streams: decoded as Vulkan's formats are, they are the
// float32 ones to half a unit, and no other byte is touched.

using namespace vulkan;
using enum VertexFormat;

constexpr std::array<float, 3> kCenter = {0.25f, -0.5f, 0.125f}, kHalf = {8, 7, 9};
constexpr std::byte kUntouched{0x5a};

template <class T>
T read(const std::byte* place) {
  T result;
  std::memcpy(&result, place, sizeof result);
  return result;
}

// VK_FORMAT_*_SNORM: the largest negative number stands for -1, too.
double snorm(std::int32_t value, double largest) { return std::max(value / largest, -1.0); }

// The format's own values.
glm::dvec4 decoded_position(VertexFormat format, const std::byte* place) {
  if (format == Float3) return {glm::dvec3(read<glm::vec3>(place)), 1};
  const auto words = read<std::array<std::uint16_t, 4>>(place);
  if (format == Half4) {
    const auto half = [](std::uint16_t bits) -> double { return glm::unpackHalf1x16(bits); };
    return {half(words[0]), half(words[1]), half(words[2]), half(words[3])};
  }
  const auto values = read<std::array<std::int16_t, 4>>(place);
  return {snorm(values[0], 32767), snorm(values[1], 32767), snorm(values[2], 32767),
          snorm(values[3], 32767)};
}

glm::dvec3 decoded_normal(VertexFormat format, const std::byte* place) {
  if (format == Float3) return glm::dvec3(read<glm::vec3>(place));
  if (format == Octahedral16) {
    const auto values = read<std::array<std::int16_t, 2>>(place);
    const double x = snorm(values[0], 32767), y = snorm(values[1], 32767);
    glm::dvec3 n(x, y, 1 - std::abs(x) - std::abs(y));
    if (n.z < 0) {
      n.x = (1 - std::abs(y)) * (x >= 0 ? 1 : -1);
      n.y = (1 - std::abs(x)) * (y >= 0 ? 1 : -1);
    }
    return glm::normalize(n);
  }
  const auto word = read<std::uint32_t>(place);
  glm::dvec3 n;
  for (int k = 0; k < 3; ++k) {
    const auto bits = static_cast<std::int32_t>(word >> (10 * k) & 0x3ff);
    n[k] = snorm(bits < 512 ? bits : bits - 1024, 511);
  }
  return n;
}

// What a host has of one layout; attributes that are a stream of their own stand behind the
// positions of all instances, or in another buffer.
struct Target {
  Target(Context& context, VertexLayout wanted, std::uint64_t vertex_count, std::uint32_t instances,
         bool is_apart)
      : layout(wanted),
        buffer(context, 512 + instances * vertex_count * (wanted.stride + wanted.attributes.stride),
               MemoryUse::Download),
        apart(context, is_apart ? buffer.size() : 4, MemoryUse::Download) {
    layout.buffer = buffer.handle();
    layout.box_center = kCenter;
    layout.box_half = kHalf;
    stride = vertex_count * layout.stride;
    if (VertexStream& stream = layout.attributes; stream.stride > 0) {
      stream.buffer = is_apart ? apart.handle() : buffer.handle();
      if (!is_apart) stream.offset += layout.offset + instances * stride;
    }
    attributes = attributes_of(layout);
    if (attributes.instance_stride == 0)
      attributes.instance_stride = vertex_count * attributes.stride;
    for (Buffer* bytes : {&buffer, &apart}) {
      std::ranges::fill(bytes->mapped(), kUntouched);
      bytes->flush();
    }
  }
  std::byte* position(std::size_t i, std::uint32_t instance = 0) {
    return &buffer.mapped()[layout.offset + instance * stride + i * layout.stride +
                            layout.position_offset];
  }
  std::byte* normal(std::size_t i, std::uint32_t instance = 0) {
    Buffer& bytes = attributes.buffer == apart.handle() ? apart : buffer;
    return &bytes.mapped()[attributes.offset + instance * attributes.instance_stride +
                           i * attributes.stride + layout.normal_offset];
  }
  void invalidate() {
    buffer.invalidate();
    apart.invalidate();
  }

  VertexLayout layout;
  VertexStream attributes;
  std::uint64_t stride = 0;
  Buffer buffer, apart;
};

class EmbedFormats : public Embedding {
 protected:
  // The first one is of floats. Shadows and depth read the split streams' positions alone.
  static std::vector<VertexLayout> layouts() {
    std::vector<VertexLayout> all;
    for (const VertexFormat position : {Float3, Half4, Snorm16x4})
      for (const VertexFormat normal : {Float3, Octahedral16, Snorm10}) {
        if (position != Float3 && normal == Snorm10) continue;  // 16 slots are all
        const std::uint32_t bytes = bytes_of(position) + bytes_of(normal);
        all.push_back({.stride = bytes,
                       .normal_offset = bytes_of(position),
                       .position_format = position,
                       .normal_format = normal});
      }
    // The normal first, and gaps.
    all.push_back({.offset = 20,
                   .stride = 24,
                   .position_offset = 8,
                   .normal_offset = 4,
                   .position_format = Snorm16x4,
                   .normal_format = Snorm10});
    for (const VertexFormat position : {Float3, Snorm16x4})
      for (const VertexFormat normal : {Float3, Octahedral16})
        all.push_back({.offset = 12,
                       .stride = bytes_of(position),
                       .normal_offset = 4,
                       .position_format = position,
                       .normal_format = normal,
                       .attributes = {.offset = 20, .stride = bytes_of(normal) + 4}});
    // Positions alone.
    for (const VertexFormat position : {Float3, Snorm16x4})
      all.push_back({.offset = 8,
                     .stride = 16,
                     .position_offset = 4,
                     .normal_offset = kNotWritten,
                     .position_format = position});
    return all;
  }
  static SolveOptions options_of(const std::vector<Target>& targets, VkBuffer points) {
    SolveOptions options;
    options.given = {points};
    options.vertices = targets[0].layout;
    for (std::size_t i = 1; i < targets.size(); ++i)
      options.further_slots.push_back({options.given, targets[i].layout, {}});
    return options;
  }
  static std::vector<Target> make_targets(Context& context, std::uint64_t vertex_count,
                                          std::uint32_t instances = 1, bool some_apart = true) {
    std::vector<Target> targets;
    for (const VertexLayout& layout : layouts())
      for (const bool is_apart : {false, true})
        if (!is_apart ||
            (some_apart && layout.attributes.stride > 0 && layout.position_format != Float3))
          targets.emplace_back(context, layout, vertex_count, instances, is_apart);
    return targets;
  }

  static void expect_position(Target& target, std::size_t i, const glm::vec3& floats,
                              std::uint32_t instance) {
    const VertexFormat format = target.layout.position_format;
    const glm::dvec4 found = decoded_position(format, target.position(i, instance));
    ASSERT_EQ(found.w, 1);
    for (int k = 0; k < 3; ++k) {
      const double p = floats[k];
      if (format == Float3) {
        ASSERT_EQ(found[k], p) << i;
        continue;
      }
      const double own = (p - kCenter[k]) / kHalf[k];
      const double unit = format == Snorm16x4 ? 1 / 32767.0 : std::abs(own) / 1024 + 6e-8;
      ASSERT_NEAR(found[k], own, unit / 2 + 2e-7) << i;
    }
  }
  static void expect_normal(Target& target, std::size_t i, const glm::vec3& floats,
                            std::uint32_t instance) {
    if (!has_normals(target.layout)) return;
    const VertexFormat format = target.layout.normal_format;
    const glm::dvec3 found = decoded_normal(format, target.normal(i, instance)), n(floats);
    if (format == Float3) {
      ASSERT_EQ(found, n) << i;
    } else if (format == Snorm10) {
      for (int k = 0; k < 3; ++k) ASSERT_NEAR(found[k], n[k], 0.5 / 511 + 1e-6) << i;
    } else if (n != glm::dvec3(0)) {
      ASSERT_LT(glm::length(glm::cross(found, glm::normalize(n))), 7e-5) << i;
      ASSERT_GT(glm::dot(found, n), 0) << i;
    }
  }
  // Against the first target, which is of floats; then all bytes that are no vertex's.
  static void expect_targets(std::vector<Target>& targets, std::size_t count,
                             std::uint32_t instances = 1) {
    for (Target& target : targets) target.invalidate();
    for (Target& target : targets) {
      SCOPED_TRACE(std::to_string(&target - targets.data()));
      for (std::uint32_t k = 0; k < instances; ++k)
        for (std::size_t i = 0; i < count; ++i) {
          expect_position(target, i, read<glm::vec3>(targets[0].position(i, k)), k);
          expect_normal(target, i, read<glm::vec3>(targets[0].normal(i, k)), k);
          if (HasFatalFailure()) return;
        }
    }
    for (Target& target : targets) {
      for (std::uint32_t k = 0; k < instances; ++k)
        for (std::size_t i = 0; i < count; ++i) {
          std::fill_n(target.position(i, k), bytes_of(target.layout.position_format), kUntouched);
          if (has_normals(target.layout))
            std::fill_n(target.normal(i, k), bytes_of(target.layout.normal_format), kUntouched);
        }
      EXPECT_THAT(target.buffer.mapped(), ::testing::Each(kUntouched));
      EXPECT_THAT(target.apart.mapped(), ::testing::Each(kUntouched));
    }
  }
  // Into all targets, a slot each.
  static void record_all(VkCommandBuffer commands, const vulkan::Solve& solve, std::size_t count) {
    for (std::uint32_t i = 0; i < count; ++i) solve.record_evaluate(commands, {.slot = i});
  }
};

TEST_F(EmbedFormats, AreTheFloatsToHalfAUnit) {
  with_both_variants([&] {
    for (const PolygonMesh& mesh : {test::torus(24, 14, 2, 0.7),
                                    test::with_random_creases(test::random_open_mesh(2), 0.1, 3)}) {
      const HostTopology topology = topology_of(mesh);
      HostFrame host = frame_of(topology);
      host.set_points(mesh);
      const auto count = static_cast<std::size_t>(topology.system.vertex_count());
      std::vector<Target> targets = make_targets(*context_, count);
      const vulkan::Solve solve(*context_, topology.device,
                                options_of(targets, host.points.handle()));
      submitter_->run([&](VkCommandBuffer commands) {
        solve.record_solve(commands, iterations(20));
        record_all(commands, solve, targets.size());
      });
      // Both sides of a crease have the same words.
      for (Target& target : targets) target.invalidate();
      const std::span<const std::int32_t> copied = topology.system.copied_vertices();
      for (Target& target : targets)
        for (std::size_t i = 0; i < count; ++i)
          ASSERT_EQ(std::memcmp(target.position(i), target.position(std::size_t(copied[i])),
                                bytes_of(target.layout.position_format)),
                    0);
      expect_targets(targets, count);
    }
  });
}

TEST_F(EmbedFormats, InstancesHaveThem) {
  constexpr std::uint32_t kCount = 3;
  const PolygonMesh mesh = test::icosphere(1);
  const HostTopology topology = topology_of(mesh);
  HostFrame host = frame_of(topology, {}, kCount);
  for (std::uint32_t k = 0; k < kCount; ++k) host.set_points(posed(mesh, static_cast<int>(k)), k);
  const auto count = static_cast<std::size_t>(topology.system.vertex_count());
  std::vector<Target> targets = make_targets(*context_, count, kCount);
  SolveOptions options = options_of(targets, host.points.handle());
  options.instances = kCount;
  const vulkan::Solve solve(*context_, topology.device, options);
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, iterations(9));
    record_all(commands, solve, targets.size());
  });
  expect_targets(targets, count, kCount);
}

// What an edit writes in a format are the words of an evaluation of all.
TEST_F(EmbedFormats, EditsHaveThem) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  const System system(mesh);
  const DeviceSystem tables(*context_, system, {.takes_edits = true});
  upload_tables(*context_, *submitter_, system, tables);
  std::vector<glm::vec3> points = points_of(mesh);
  Buffer given = filled(*context_, points);
  const Buffer moves = filled(*context_, std::array{1u, 7u});
  const auto count = static_cast<std::size_t>(system.vertex_count());
  std::vector<Target> targets = make_targets(*context_, count, 1, false);
  SolveOptions options = options_of(targets, given.handle());
  options.moved = {moves.handle(), 0, 1};
  for (FrameSlot& slot : options.further_slots) slot.moved = options.moved;
  const vulkan::Solve solve(*context_, tables, options);
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, iterations(20));
    record_all(commands, solve, targets.size());
  });
  points[7] += glm::vec3(0.1f, -0.05f, 0.2f);
  put(given, points);
  submitter_->run([&](VkCommandBuffer commands) {
    for (std::uint32_t i = 0; i < targets.size(); ++i)
      solve.record_edit(commands, {.iterations = i == 0 ? 12u : 0u, .slot = i});
  });
  const auto bytes_of_all = [&] {
    std::vector<std::vector<std::byte>> all;
    for (Target& target : targets)
      all.push_back(fetched<std::byte>(target.buffer, target.buffer.mapped().size()));
    return all;
  };
  const std::vector<std::vector<std::byte>> edited = bytes_of_all();
  submitter_->run([&](VkCommandBuffer commands) { record_all(commands, solve, targets.size()); });
  EXPECT_TRUE(bytes_of_all() == edited);
  expect_targets(targets, count);
}

// Textured vertices: rows cut at seams, texture coordinates as in the files of `planish fit`,
// places, and tangents against finite differences of the limit surface.

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
  EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                               [] { System(test::cube(), {.textured = true}); }),
              ::testing::HasSubstr("no texture coordinates"));
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
    upload_tables(*context_, *submitter_, system, tables);
    const Buffer given = filled(*context_, points_of(mesh));
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
      solve.record_solve(commands, {.iterations = 0});
      solve.record_evaluate(commands);
      solve.record_evaluate(commands, {.slot = 1});
    });
    const auto result = fetched<TexturedVertex>(vertices, count);
    const auto words = fetched<std::uint32_t>(attributes, 2 * count);
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
  upload_tables(*context_, *submitter_, system, tables);
  std::vector<glm::vec3> points;
  for (int k = 0; k < 2; ++k)
    for (const glm::dvec3& p : mesh.positions) points.emplace_back(p * (1 + 0.5 * k));
  const auto moved = static_cast<std::uint32_t>(mesh.positions.size()) + 3;
  Buffer given = filled(*context_, points);
  const Buffer moves = filled(*context_, std::array{1u, moved});
  const auto count = static_cast<std::size_t>(system.vertex_count());
  Buffer vertices(*context_, 2 * count * sizeof(TexturedVertex), MemoryUse::Download);
  const vulkan::Solve solve(*context_, tables,
                            {.given = {given.handle()},
                             .vertices = {.buffer = vertices.handle(),
                                          .stride = sizeof(TexturedVertex),
                                          .tangent_offset = 24},
                             .instances = 2,
                             .moved = {moves.handle(), 0, 1}});
  const auto fetch = [&] { return fetched<TexturedVertex>(vertices, 2 * count); };
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, iterations(20));
    solve.record_evaluate(commands);
  });
  const std::vector<TexturedVertex> before = fetch();
  points[moved] += glm::vec3(0.1f, -0.05f, 0.2f);
  put(given, points);
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
  expect_refusal(ErrorCode::InvalidArgument, "tangents are square to normals", [&] {
    const vulkan::Solve without(
        *context_, tables,
        {.given = {given.handle()},
         .vertices = {
             .buffer = vertices.handle(), .normal_offset = kNotWritten, .tangent_offset = 0}});
  });
}

}  // namespace
}  // namespace planish::testing
