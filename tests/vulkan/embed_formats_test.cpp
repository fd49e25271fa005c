// Vertices in compact formats and in two streams: decoded as Vulkan's formats are, they are the
// float32 ones to half a unit, and no other byte is touched.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/packing.hpp>
#include <string>

#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using enum VertexFormat;
using ::testing::HasSubstr;

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
          std::fill_n(target.normal(i, k), bytes_of(target.layout.normal_format), kUntouched);
        }
      EXPECT_THAT(target.buffer.mapped(), ::testing::Each(kUntouched));
      EXPECT_THAT(target.apart.mapped(), ::testing::Each(kUntouched));
    }
  }
  static std::vector<glm::vec3> rounded(const PolygonMesh& mesh) {
    return {mesh.positions.begin(), mesh.positions.end()};
  }
};

TEST_F(EmbedFormats, AreTheFloatsToHalfAUnit) {
  with_both_variants([&] {
    for (const PolygonMesh& mesh : {test::torus(24, 14, 2, 0.7),
                                    test::with_random_creases(test::random_open_mesh(2), 0.1, 3)}) {
      HostTopology topology(*context_, mesh);
      topology.upload(*submitter_);
      HostFrame host(*context_, topology);
      host.set_points(mesh);
      const auto count = static_cast<std::size_t>(topology.system.vertex_count());
      std::vector<Target> targets = make_targets(*context_, count);
      const vulkan::Solve solve(*context_, topology.device,
                                options_of(targets, host.points.handle()));
      submitter_->run([&](VkCommandBuffer commands) {
        solve.record_solve(commands, iterations(20));
        for (std::uint32_t i = 0; i < targets.size(); ++i)
          solve.record_evaluate(commands, {.slot = i});
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
  HostTopology topology(*context_, mesh);
  topology.upload(*submitter_);
  HostFrame host(*context_, topology, {}, 64, kCount);
  for (std::uint32_t k = 0; k < kCount; ++k) host.set_points(posed(mesh, static_cast<int>(k)), k);
  const auto count = static_cast<std::size_t>(topology.system.vertex_count());
  std::vector<Target> targets = make_targets(*context_, count, kCount);
  SolveOptions options = options_of(targets, host.points.handle());
  options.instances = kCount;
  const vulkan::Solve solve(*context_, topology.device, options);
  submitter_->run([&](VkCommandBuffer commands) {
    solve.record_solve(commands, iterations(9));
    for (std::uint32_t i = 0; i < targets.size(); ++i) solve.record_evaluate(commands, {.slot = i});
  });
  expect_targets(targets, count, kCount);
}

// What an edit writes in a format are the words of an evaluation of all.
TEST_F(EmbedFormats, EditsHaveThem) {
  const PolygonMesh mesh = test::with_random_creases(test::random_open_mesh(2), 0.1, 3);
  const System system(mesh);
  const DeviceSystem tables(*context_, system, {.takes_edits = true});
  Buffer staging(*context_, tables.upload_bytes(), MemoryUse::Upload);
  tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
  staging.flush();
  std::vector<glm::vec3> points = rounded(mesh);
  Buffer given(*context_, points.size() * sizeof points[0], MemoryUse::Upload);
  Buffer moves(*context_, 64, MemoryUse::Upload);
  const auto count = static_cast<std::size_t>(system.vertex_count());
  std::vector<Target> targets = make_targets(*context_, count, 1, false);
  SolveOptions options = options_of(targets, given.handle());
  options.moved = {moves.handle(), 0, 8};
  for (FrameSlot& slot : options.further_slots) slot.moved = options.moved;
  const vulkan::Solve solve(*context_, tables, options);
  const auto give = [&] {
    std::memcpy(given.mapped().data(), points.data(), given.size());
    given.flush();
  };
  give();
  submitter_->run([&](VkCommandBuffer commands) {
    tables.record_upload(commands, staging.handle(), 0);
    solve.record_solve(commands, iterations(20));
    for (std::uint32_t i = 0; i < targets.size(); ++i) solve.record_evaluate(commands, {.slot = i});
  });
  points[7] += glm::vec3(0.1f, -0.05f, 0.2f);
  give();
  const std::uint32_t list[] = {1, 7};
  std::memcpy(moves.mapped().data(), list, sizeof list);
  moves.flush();
  submitter_->run([&](VkCommandBuffer commands) {
    for (std::uint32_t i = 0; i < targets.size(); ++i)
      solve.record_edit(commands, {.iterations = i == 0 ? 12u : 0u, .slot = i});
  });
  std::vector<std::vector<std::byte>> edited;
  for (Target& target : targets) {
    target.buffer.invalidate();
    edited.emplace_back(target.buffer.mapped().begin(), target.buffer.mapped().end());
  }
  submitter_->run([&](VkCommandBuffer commands) {
    for (std::uint32_t i = 0; i < targets.size(); ++i) solve.record_evaluate(commands, {.slot = i});
  });
  for (std::size_t i = 0; i < targets.size(); ++i) {
    targets[i].buffer.invalidate();
    EXPECT_TRUE(std::ranges::equal(targets[i].buffer.mapped(), edited[i])) << i;
  }
  expect_targets(targets, count);
}

TEST_F(EmbedFormats, WrongLayoutsAreRefusedByName) {
  const HostTopology topology(*context_, test::icosphere(1));
  const Buffer buffer(*context_, 1 << 20, MemoryUse::Device);
  const auto refuse = [&](VertexLayout layout, const char* words) {
    layout.buffer = buffer.handle();
    const std::map<std::string, int> before = PretendedDriver::alive();
    try {
      const vulkan::Solve solve(*context_, topology.device, {.vertices = layout});
      ADD_FAILURE() << "nothing thrown: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      EXPECT_THAT(error.what(), HasSubstr(words));
    }
    EXPECT_EQ(PretendedDriver::alive(), before);
  };
  refuse({.position_format = Snorm10}, "not of a format for normals");
  refuse({.normal_format = Half4}, "not of a format for positions");
  refuse({.box_half = {1, 0, 1}}, "halves above 0");
  refuse({.stride = 12, .position_format = Snorm16x4},
         "a vertex of stride 12 does not hold 12 bytes from offset 12 on");
  const auto apart = [&](std::uint32_t stride) { return VertexStream{buffer.handle(), 0, stride}; };
  refuse({.stride = 4, .normal_offset = 0, .normal_format = Snorm10, .attributes = apart(4)},
         "a vertex of stride 4 does not hold 12 bytes from offset 0 on");
  refuse({.normal_offset = 4, .attributes = apart(12)},
         "a vertex of stride 12 does not hold 12 bytes from offset 4 on");
  refuse({.attributes = apart(128)}, "max_vertex_stride");
  refuse({.attributes = apart(26)}, "multiples of 4 bytes");
  refuse({.tangent_offset = 24}, "make it textured");
  refuse({.tangent_format = Float3}, "tangents are Float4 or Snorm10");
}

}  // namespace
}  // namespace planish::testing
