#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <iterator>
#include <list>
#include <optional>
#include <random>
#include <set>
#include <vector>

#include "planish/pipeline/fit.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/backend.h"
#include "planish/vulkan/device/commands.h"
#include "support/calls.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/device_cases.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

// The sphere around a box of points, in double.
struct Sphere {
  glm::dvec3 centre{0.0};
  double radius = 0;
};
Sphere sphere_around(const std::vector<glm::dvec3>& points) {
  glm::dvec3 low = points.at(0), high = low;
  for (const glm::dvec3& p : points) low = glm::min(low, p), high = glm::max(high, p);
  Sphere sphere{0.5 * (low + high)};
  for (const glm::dvec3& p : points)
    sphere.radius = std::max(sphere.radius, glm::distance(p, sphere.centre));
  return sphere;
}

// A camera at the origin that looks along -z, 60 degrees high and wide, in Vulkan's clip space.
glm::mat4 perspective(float near, float far) {
  const float f = std::sqrt(3.0f);
  glm::mat4 clip(0.0f);
  clip[0][0] = f;
  clip[1][1] = -f;
  clip[2][2] = far / (near - far);
  clip[2][3] = -1;
  clip[3][2] = near * far / (near - far);
  return clip;
}

// A view of instances, with a host's picture in mind.
vulkan::TessellateParameters view_of(const glm::mat4& clip, float chord_pixels = 0.5f) {
  vulkan::TessellateParameters view;
  std::memcpy(view.clip_from_world.data(), &clip, sizeof clip);
  view.viewport_height = 720;
  view.chord_pixels = chord_pixels;
  return view;
}

// Instances of a mesh, each at a place of its own in a pose of its own, with a Tessellation.
struct LevelHost {
  using Place = std::function<glm::dvec3(std::uint32_t)>;

  LevelHost(vulkan::Context& on, vulkan::Submitter& with, const PolygonMesh& mesh,
            const vulkan::SystemOptions& options, const std::vector<glm::dvec3>& places,
            vulkan::TessellationOptions wanted = {})
      : context(on),
        submitter(with),
        rest(mesh),
        offsets(places),
        count(static_cast<std::uint32_t>(places.size())),
        level_numbers(options.levels),
        system(mesh, options),
        tables(on, system, {.max_vertex_stride = 64}),
        points(on, count * mesh.positions.size() * sizeof(glm::vec3), vulkan::MemoryUse::Upload),
        output(on, tables.tessellation_bytes(wanted, count), vulkan::MemoryUse::Download),
        solve(on, tables, {.given = {points.handle()}, .instances = count}) {
    wanted.vertices.buffer = output.handle();
    if (wanted.previous_positions.stride > 0) wanted.previous_positions.buffer = output.handle();
    levels.emplace(on, tables, solve, wanted);
    upload_tables(on, submitter, system, tables);
    pose(0);
    reset();
    submitter.run([&](VkCommandBuffer commands) { solve.record_surface(commands); });
  }

  // Solves all instances in the poses of a frame.
  void pose(std::uint32_t frame) {
    for (std::uint32_t i = 0; i < count; ++i)
      put(points, points_of(pose_of(i, frame)), i * rest.positions.size() * sizeof(glm::vec3));
    submitter.run([&](VkCommandBuffer commands) { solve.record_solve(commands, iterations(20)); });
  }
  [[nodiscard]] PolygonMesh pose_of(std::uint32_t instance, std::uint32_t frame = 0) const {
    PolygonMesh pose = posed(rest, static_cast<int>(instance + 7 * frame));
    for (glm::dvec3& p : pose.positions) p = glm::dvec3(glm::vec3(p + offsets[instance]));
    return pose;
  }

  // Forgets what levels there were.
  void reset() {
    submitter.run([&](VkCommandBuffer commands) { levels->record_reset(commands); });
  }
  // Draws a view; returns each instance's level.
  std::vector<std::uint32_t> draw(const vulkan::TessellateParameters& view) {
    vulkan::Buffer report(context, count * sizeof(std::uint32_t), vulkan::MemoryUse::Download);
    submitter.run([&](VkCommandBuffer commands) {
      levels->record_evaluate(commands, view);
      levels->record_levels(commands, report.handle(), 0);
    });
    return fetched<std::uint32_t>(report, count);
  }

  // Of a buffer of planish's own.
  template <class Item>
  std::vector<Item> fetch(VkBuffer from, VkDeviceSize offset, std::size_t item_count) {
    const VkBufferCopy region{offset, 0, item_count * sizeof(Item)};
    vulkan::Buffer copy(context, region.size, vulkan::MemoryUse::Download);
    submitter.run([&](VkCommandBuffer commands) {
      vulkan::record_barrier(context, commands, vulkan::kExitScope, vulkan::kEntryScope);
      context.vk().vkCmdCopyBuffer(commands, from, copy.handle(), 1, &region);
    });
    return fetched<Item>(copy, item_count);
  }
  std::vector<VkDrawIndexedIndirectCommand> draws() {
    return fetch<VkDrawIndexedIndirectCommand>(levels->draws(), 0, count);
  }
  // Control points of an instance.
  std::vector<glm::dvec3> control_points(std::uint32_t instance) {
    const auto found =
        fetch<glm::vec4>(solve.control_points(), instance * solve.control_point_stride(),
                         system.used_vertices().size());
    std::vector<glm::dvec3> result;
    for (const glm::vec4& p : found) result.emplace_back(p);
    return result;
  }

  vulkan::Context& context;
  vulkan::Submitter& submitter;
  PolygonMesh rest;
  std::vector<glm::dvec3> offsets;
  std::uint32_t count;
  std::vector<int> level_numbers;
  vulkan::System system;
  vulkan::DeviceSystem tables;
  vulkan::Buffer points, output;
  vulkan::Solve solve;
  std::optional<vulkan::Tessellation> levels;
};

// What a view should choose, in double and without a device: the rule of vulkan/host/evaluation.h.
class LevelChoice {
 public:
  static constexpr std::uint32_t kNotSeen = vulkan::Tessellation::kNotSeen;

  // `ratios`: chord errors for a sphere of radius 1.
  LevelChoice(const vulkan::TessellateParameters& view, std::vector<double> ratios)
      : view_(view), ratios_(std::move(ratios)) {}

  [[nodiscard]] std::uint32_t level(const Sphere& sphere, std::uint32_t last = kNotSeen) {
    glm::dvec4 rows[4];
    for (int r = 0; r < 4; ++r)
      for (int c = 0; c < 4; ++c) rows[r][c] = view_.clip_from_world[4 * c + r];
    const glm::dvec4 planes[] = {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
                                 rows[3] - rows[1], rows[2],           rows[3] - rows[2]};
    for (const glm::dvec4& plane : planes) {
      const double length = glm::length(glm::dvec3(plane));
      if (length == 0) continue;
      const double distance = (glm::dot(glm::dvec3(plane), sphere.centre) + plane.w) / length;
      note(distance, -sphere.radius, sphere.radius);
      if (distance < -sphere.radius) return kNotSeen;
    }
    const double depth = glm::dot(glm::dvec3(rows[3]), sphere.centre) + rows[3].w -
                         sphere.radius * glm::length(glm::dvec3(rows[3]));
    const auto pixels = [&](std::size_t k) {
      return depth > 0 ? sphere.radius * ratios_[k] * glm::length(glm::dvec3(rows[1])) * 0.5 *
                             view_.viewport_height / depth
                       : 1e30;
    };
    const auto first_within = [&](double limit) {
      std::uint32_t k = 0;
      while (k + 1 < ratios_.size()) {
        note(pixels(k), limit, limit);
        if (pixels(k) <= limit) break;
        ++k;
      }
      return k;
    };
    const std::uint32_t needed = first_within(view_.chord_pixels);
    if (last >= ratios_.size() || needed >= last) return needed;
    return std::min(last, first_within(view_.chord_pixels * view_.coarser_at));
  }
  // How near any comparison was to its limit, of the limit's size.
  [[nodiscard]] double closest_call() const { return closest_; }

 private:
  void note(double value, double limit, double scale) {
    if (scale > 0) closest_ = std::min(closest_, std::abs(value - limit) / scale);
  }

  vulkan::TessellateParameters view_;
  std::vector<double> ratios_;
  double closest_ = 1e30;
};

// Levels by need: which one each instance of a view has, against a choice in double; that what is
// evaluated has record_evaluate's bits; that what is not seen is neither dispatched nor drawn.

using namespace vulkan;
using ::testing::Each;

const std::vector<int> kLevels = {1, 2, 3, 4};
constexpr std::uint32_t kNotSeen = Tessellation::kNotSeen;

PolygonMesh cage_of(const PolygonMesh& mesh) {
  FitOptions options;
  options.tolerance = 1e-10;
  return fit(mesh, *make_cpu_backend(), options).cage;
}

// For a sphere of radius 1 around the rest pose's cage, which the CPU fits.
std::vector<double> chord_ratios(const System& system, const PolygonMesh& rest) {
  std::vector<double> ratios = system.chord_errors();
  const double radius = sphere_around(cage_of(rest).positions).radius;
  for (double& ratio : ratios) ratio /= radius;
  return ratios;
}

// From near to far, to the left and right, and behind the eye.
std::vector<glm::dvec3> field(std::uint32_t count, double nearest = 4, double step = 1.35) {
  std::vector<glm::dvec3> places;
  for (std::uint32_t i = 0; i < count; ++i) {
    const double away = nearest * std::pow(step, i % 20);
    const double aside = 0.5 * (static_cast<double>(i * 7 % 5) - 2) * away;
    places.emplace_back(aside, 0.1 * away, i % 6 == 5 ? away : -away);
  }
  return places;
}

class EmbedLevels : public Embedding {
 protected:
  std::vector<std::uint32_t> expected_levels(LevelHost& host, const TessellateParameters& view,
                                             const std::vector<std::uint32_t>& last = {}) {
    LevelChoice choice(view, chord_ratios(host.system, host.rest));
    std::vector<std::uint32_t> levels;
    for (std::uint32_t i = 0; i < host.count; ++i)
      levels.push_back(
          choice.level(sphere_around(host.control_points(i)), last.empty() ? kNotSeen : last[i]));
    // Floats tell all of these apart.
    EXPECT_GT(choice.closest_call(), 1e-5);
    return levels;
  }

  // Vertices of an instance's draw are those of a Solve of its own at that level.
  void expect_bits(LevelHost& host, const std::vector<std::uint32_t>& levels,
                   const SystemOptions& options) {
    const std::vector<VkDrawIndexedIndirectCommand> draws = host.draws();
    host.output.invalidate();
    std::set<std::pair<std::int32_t, std::int32_t>> ranges;
    for (std::size_t k = 0; k < host.level_numbers.size(); ++k) {
      SystemOptions one = options;
      one.levels.clear();
      one.level = host.level_numbers[k];
      const HostTopology topology = topology_of(host.rest, one);
      HostFrame frame = frame_of(topology);
      const auto triangles = topology.system.triangles();
      const std::vector<std::uint32_t> indices = host.fetch<std::uint32_t>(
          host.levels->indices(), index_offset(draws, levels, k) * sizeof(std::uint32_t),
          triangles.size());
      for (std::uint32_t i = 0; i < host.count; ++i) {
        if (levels[i] != k) continue;
        const VkDrawIndexedIndirectCommand& draw = draws[i];
        EXPECT_EQ(draw.indexCount, triangles.size());
        EXPECT_EQ(draw.instanceCount, 1u);
        EXPECT_TRUE(std::ranges::equal(indices, triangles));
        const std::vector<Vertex> wanted = run(frame, host.pose_of(i), iterations(20));
        const std::byte* found =
            host.output.mapped().data() + std::uint64_t(draw.vertexOffset) * sizeof(Vertex);
        EXPECT_EQ(std::memcmp(found, wanted.data(), wanted.size() * sizeof(Vertex)), 0)
            << "instance " << i << " of level " << host.level_numbers[k];
        const std::int32_t end = draw.vertexOffset + static_cast<std::int32_t>(wanted.size());
        EXPECT_TRUE(ranges.emplace(draw.vertexOffset, end).second);
      }
    }
    std::int32_t last = 0;
    for (const auto& [begin, end] : ranges) {
      EXPECT_GE(begin, last);
      last = end;
    }
    for (std::uint32_t i = 0; i < host.count; ++i)
      if (levels[i] == kNotSeen) {
        EXPECT_EQ(draws[i].indexCount + draws[i].instanceCount, 0u) << i;
      }
  }

  static std::uint64_t index_offset(const std::vector<VkDrawIndexedIndirectCommand>& draws,
                                    const std::vector<std::uint32_t>& levels, std::size_t level) {
    for (std::size_t i = 0; i < draws.size(); ++i)
      if (levels[i] == level) return draws[i].firstIndex;
    return 0;
  }

  // Work groups of all indirect dispatches of a view, and how many of them there are.
  struct Dispatched {
    std::uint64_t groups = 0;
    std::size_t count = 0;
  };
  Dispatched dispatched(LevelHost& host, const TessellateParameters& view) {
    PretendedDriver::forget_notes();
    host.draw(view);
    Dispatched result;
    for (const auto& [buffer, offset] : PretendedDriver::notes().indirect_dispatches) {
      const std::vector<std::uint32_t> groups = host.fetch<std::uint32_t>(buffer, offset, 3);
      result.groups += std::uint64_t(groups[0]) * groups[1] * groups[2];
      ++result.count;
    }
    return result;
  }
};

TEST_F(EmbedLevels, AreTheCpusAndVerticesThoseOfTheLevel) {
  const PolygonMesh meshes[] = {test::torus(12, 7, 2, 0.7), test::icosphere(1),
                                test::with_random_creases(test::random_closed_mesh(4), 0.15, 2)};
  with_both_variants([&] {
    for (const PolygonMesh& mesh : meshes) {
      const SystemOptions options{.level = 0, .levels = kLevels};
      LevelHost host(*context_, *submitter_, mesh, options, field(40));
      const TessellateParameters view = view_of(perspective(0.1f, 5000), 0.1f);
      const std::vector<std::uint32_t> levels = host.draw(view);
      EXPECT_EQ(levels, expected_levels(host, view));
      std::set<std::uint32_t> kinds(levels.begin(), levels.end());
      EXPECT_EQ(kinds, (std::set<std::uint32_t>{0, 1, 2, 3, kNotSeen}));
      expect_bits(host, levels, options);
    }
  });
}

// Of planes near and far, reversed depth without end, and no perspective.
TEST_F(EmbedLevels, FollowAnyProjection) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  LevelHost host(*context_, *submitter_, mesh, {.levels = kLevels}, field(40));
  glm::mat4 reversed = perspective(0.1f, 5000);
  reversed[2][2] = 0;
  reversed[3][2] = 0.1f;
  glm::mat4 parallel(0.0f);
  parallel[0][0] = parallel[1][1] = 0.02f;
  parallel[2][2] = -1.0f / 300;
  parallel[3][3] = 1;
  std::set<std::vector<std::uint32_t>> choices;
  for (const glm::mat4& clip : {perspective(20, 200), reversed, parallel}) {
    const TessellateParameters view = view_of(clip);
    host.reset();
    const std::vector<std::uint32_t> levels = host.draw(view);
    EXPECT_EQ(levels, expected_levels(host, view));
    EXPECT_TRUE(choices.insert(levels).second);
  }
}

// Whatever has a vertex in the view is seen: the sphere holds the surface.
TEST_F(EmbedLevels, NothingThatIsInViewIsLeftOut) {
  const PolygonMesh meshes[] = {test::torus(12, 7, 2, 0.7), test::prism(9),
                                test::with_random_creases(test::random_open_mesh(2), 0.1, 3)};
  std::mt19937 random(7);
  std::size_t seen = 0, unseen = 0;
  for (const PolygonMesh& mesh : meshes) {
    LevelHost host(*context_, *submitter_, mesh, {.level = 2, .levels = {1, 2}}, field(30));
    const HostTopology topology = topology_of(mesh);
    HostFrame frame = frame_of(topology);
    std::vector<std::vector<Vertex>> vertices;
    for (std::uint32_t i = 0; i < host.count; ++i)
      vertices.push_back(run(frame, host.pose_of(i), iterations(20)));
    for (int k = 0; k < 20; ++k) {
      glm::mat4 clip = perspective(0.1f, 100);
      for (int c = 0; c < 3; ++c)
        clip[3] += clip[c] * (static_cast<float>(random() % 1000) * 0.02f - 10);
      const std::vector<std::uint32_t> levels = host.draw(view_of(clip));
      for (std::uint32_t i = 0; i < host.count; ++i) {
        const bool in_view = std::ranges::any_of(vertices[i], [&](const Vertex& vertex) {
          const glm::vec4 p = clip * glm::vec4(vertex.position, 1);
          return std::abs(p.x) <= p.w && std::abs(p.y) <= p.w && p.z >= 0 && p.z <= p.w;
        });
        if (in_view) {
          EXPECT_NE(levels[i], kNotSeen) << i;
        }
        ++(levels[i] == kNotSeen ? unseen : seen);
      }
    }
  }
  EXPECT_GT(seen, 300u);
  EXPECT_GT(unseen, 300u);
}

TEST_F(EmbedLevels, WhatIsOffScreenIsNeitherDispatchedNorDrawn) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  std::vector<glm::dvec3> places = field(30);
  LevelHost host(*context_, *submitter_, mesh, {.levels = kLevels}, places);
  const TessellateParameters view = view_of(perspective(0.1f, 5000));
  glm::mat4 away = perspective(0.1f, 5000);
  away[3] += 1e6f * away[2];  // a thousand miles ahead
  const Dispatched none = dispatched(host, view_of(away));
  EXPECT_GT(none.count, kLevels.size());  // of each level, and more where ways are not joined
  EXPECT_EQ(none.groups, 0u);
  EXPECT_THAT(host.draw(view_of(away)), Each(kNotSeen));
  for (const VkDrawIndexedIndirectCommand& draw : host.draws())
    EXPECT_EQ(draw.indexCount + draw.instanceCount + draw.firstIndex, 0u);
  const Dispatched some = dispatched(host, view);
  EXPECT_EQ(some.count, none.count);
  EXPECT_GT(some.groups, 0u);
  // As much as those that are seen take by themselves.
  const std::vector<std::uint32_t> levels = host.draw(view);
  std::vector<glm::dvec3> seen;
  std::vector<std::uint32_t> numbers;
  for (std::uint32_t i = 0; i < host.count; ++i)
    if (levels[i] != kNotSeen) seen.push_back(places[i]), numbers.push_back(i);
  ASSERT_LT(seen.size(), places.size());
  const auto alone_with = [&](const std::vector<glm::dvec3>& offsets) {
    LevelHost alone(*context_, *submitter_, mesh, {.levels = kLevels}, offsets);
    for (std::size_t i = 0; i < numbers.size(); ++i)
      put(alone.points, points_of(host.pose_of(numbers[i])),
          i * mesh.positions.size() * sizeof(glm::vec3));
    submitter_->run(
        [&](VkCommandBuffer commands) { alone.solve.record_solve(commands, iterations(20)); });
    return dispatched(alone, view);
  };
  EXPECT_EQ(alone_with(seen).groups, some.groups);
}

TEST_F(EmbedLevels, KeepALevelUntilACoarserOneIsWellEnough) {
  const PolygonMesh mesh = test::icosphere(1);
  LevelHost host(*context_, *submitter_, mesh, {.levels = kLevels}, field(20, 5, 1.1));
  const auto at = [](float pixels, float coarser_at) {
    TessellateParameters view = view_of(perspective(0.1f, 5000), pixels);
    view.coarser_at = coarser_at;
    return view;
  };
  // As the limit rises and falls, by steps that are small beside 0.7, where some have level 2.
  const float limit = static_cast<float>(360 * std::sqrt(3.0) * host.system.chord_errors()[1] / 10);
  std::vector<std::uint32_t> last(host.count, kNotSeen);
  int changes[2] = {};
  for (const float coarser_at : {0.7f, 1.0f}) {
    host.reset();
    std::ranges::fill(last, kNotSeen);
    for (int frame = 0; frame < 12; ++frame) {
      const TessellateParameters view = at(frame % 2 == 0 ? limit : 1.2f * limit, coarser_at);
      const std::vector<std::uint32_t> levels = host.draw(view);
      EXPECT_EQ(levels, expected_levels(host, view, last)) << frame;
      if (frame > 0) changes[coarser_at == 1.0f] += levels != last;
      last = levels;
    }
  }
  EXPECT_LE(changes[0], 1);
  EXPECT_EQ(changes[1], 11);
  // Much coarser is taken, and what was is forgotten when told so.
  const std::vector<std::uint32_t> coarse = host.draw(at(8, 0.7f));
  EXPECT_EQ(coarse, expected_levels(host, at(8, 0.7f), last));
  EXPECT_NE(coarse, last);
  const std::vector<std::uint32_t> fine = host.draw(at(0.1f, 0.7f));
  host.reset();
  EXPECT_EQ(host.draw(at(0.12f, 0.7f)), expected_levels(host, at(0.12f, 0.7f)));
  EXPECT_NE(fine, coarse);
}

// Instances in their order, where a level has no place left: a coarser one.
TEST_F(EmbedLevels, TakeACoarserOneWhereTheirsIsFull) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  const SystemOptions options{.level = 1, .levels = kLevels};
  const std::vector<std::uint32_t> room = {40, 6, 2, 3};
  with_both_variants([&] {
    LevelHost host(*context_, *submitter_, mesh, options, field(40), {.places = room});
    const TessellateParameters view = view_of(perspective(0.1f, 5000), 0.1f);
    std::vector<std::uint32_t> expected = expected_levels(host, view);
    std::uint32_t moved = 0;
    for (std::uint32_t level = 3; level > 0; --level) {
      std::uint32_t count = 0;
      for (std::uint32_t& own : expected)
        if (own == level && ++count > room[level]) --own, ++moved;
    }
    EXPECT_GT(moved, 8u);
    const std::vector<std::uint32_t> levels = host.draw(view);
    EXPECT_EQ(levels, expected);
    expect_bits(host, levels, options);
    // What was not to be had is wanted again.
    EXPECT_EQ(host.draw(view), expected);
  });
}

// One draw a level: its instances in their order, each at the vertices of its own draw.
TEST_F(EmbedLevels, ALevelsDrawHasItsInstances) {
  const std::vector<std::uint32_t> room = {40, 6, 2, 3};
  for (const bool numbers : {false, true}) {
    LevelHost host(*context_, *submitter_, test::torus(9, 6, 2, 0.7), {.levels = kLevels},
                   field(40), {.places = room, .numbers_draws = numbers});
    const std::vector<std::uint32_t> levels =
        host.draw(view_of(perspective(0.1f, 5000), numbers ? 0.1f : 3.0f));
    const std::vector<VkDrawIndexedIndirectCommand> draws = host.draws();
    std::int32_t first_row = 0;
    std::uint32_t first_place = 0, drawn = 0;
    for (std::uint32_t k = 0; k < kLevels.size(); ++k) {
      const LevelDraw level = host.levels->level_draw(k);
      const auto all = host.fetch<VkDrawIndexedIndirectCommand>(level.draw, level.draw_offset, 1);
      EXPECT_EQ(level.draw_offset, host.levels->level_draw(0).draw_offset + k * sizeof all[0]);
      EXPECT_EQ(all[0].vertexOffset, first_row);
      EXPECT_EQ(all[0].firstInstance, numbers ? first_place : 0);
      EXPECT_EQ(all[0].instanceCount, std::ranges::count(levels, k));
      const auto records = host.fetch<DrawnInstance>(
          level.instances, level.instances_offset + all[0].firstInstance * sizeof(DrawnInstance),
          room[k]);
      const DrawnInstance* record = records.data();
      for (std::uint32_t i = 0; i < host.count; ++i) {
        if (levels[i] != k) continue;
        EXPECT_EQ(record->instance, i);
        EXPECT_EQ(static_cast<std::int32_t>(record->first_vertex) + first_row,
                  draws[i].vertexOffset);
        EXPECT_EQ(all[0].indexCount, draws[i].indexCount);
        EXPECT_EQ(all[0].firstIndex, draws[i].firstIndex);
        ++record, ++drawn;
      }
      first_row += host.tables.level_vertex_counts()[k];
      first_place += room[k];
    }
    EXPECT_GT(drawn, 20u);
  }
}

// Of what an instance was a view ago, at the level that it has now, whether it had that, another or
// none: the bits of a solve of its own.
class PreviousPositions : public EmbedLevels {
 protected:
  struct Moving {
    Vertex now;
    glm::vec3 before;
  };

  void draw_frames(const PolygonMesh& mesh, const SystemOptions& options,
                   const std::vector<glm::dvec3>& places, bool turns) {
    LevelHost host(
        *context_, *submitter_, mesh, options, places,
        {.vertices = {.stride = sizeof(Moving)},
         .previous_positions = {.offset = offsetof(Moving, before), .stride = sizeof(Moving)}});
    std::list<HostTopology> topologies;
    std::list<HostFrame> alone;
    for (const int level : options.levels) {
      SystemOptions one = options;
      one.levels.clear();
      one.level = level;
      topologies.emplace_back(*context_, *submitter_, mesh, one);
      alone.push_back(frame_of(topologies.back()));
    }
    std::vector<std::uint32_t> last;
    for (std::uint32_t frame = 0; frame < 4; ++frame) {
      if (frame > 0) host.pose(frame);
      // Levels rise, and what was behind the eye comes before it.
      const glm::mat4 clip = perspective(0.1f, 5000) * (turns && frame == 2 ? -1.0f : 1.0f);
      const std::vector<std::uint32_t> levels = host.draw(view_of(clip, frame == 0 ? 40.0f : 0.3f));
      const std::vector<VkDrawIndexedIndirectCommand> draws = host.draws();
      host.output.invalidate();
      for (std::uint32_t i = 0; i < host.count; ++i) {
        if (levels[i] == kNotSeen) continue;
        const std::byte* found =
            &host.output.mapped()[std::uint64_t(draws[i].vertexOffset) * sizeof(Moving)];
        HostFrame& own = *std::next(alone.begin(), levels[i]);
        EXPECT_TRUE(are(found, offsetof(Moving, now), sizeof(Vertex),
                        run(own, host.pose_of(i, frame), iterations(20))))
            << "frame " << frame << ", instance " << i;
        EXPECT_TRUE(are(found, offsetof(Moving, before), sizeof(glm::vec3),
                        run(own, host.pose_of(i, frame > 0 ? frame - 1 : 0), iterations(20))))
            << "frame " << frame << ", instance " << i;
        if (frame > 0) ++(last[i] == levels[i] ? same_ : last[i] == kNotSeen ? unseen_ : other_);
      }
      last = levels;
    }
  }
  // Whether the first bytes of the vertices stand at an offset of those found.
  static bool are(const std::byte* found, std::size_t offset, std::size_t bytes,
                  const std::vector<Vertex>& vertices) {
    for (std::size_t i = 0; i < vertices.size(); ++i)
      if (std::memcmp(found + i * sizeof(Moving) + offset, &vertices[i], bytes) != 0) return false;
    return true;
  }

  std::size_t same_ = 0, other_ = 0, unseen_ = 0;
};

TEST_F(PreviousPositions, AreThoseOfTheViewBefore) {
  std::vector<PolygonMesh> meshes = {test::with_random_creases(test::torus(7, 5, 2, 0.7), 0.15, 2)};
  for (const test::NamedMesh& of : large_rings())
    if (of.name == "ring") meshes.push_back(of.mesh);
  with_both_variants([&] {
    for (const PolygonMesh& mesh : meshes) draw_frames(mesh, {.levels = {1, 2}}, field(12), true);
  });
  EXPECT_GT(same_, 2u);
  EXPECT_GT(unseen_, 2u);
  EXPECT_GT(other_, 2u);
}

// Whose state is kept instead of a displacement.
TEST_F(PreviousPositions, TheFairMethodHasThemToo) {
  draw_frames(test::torus(7, 5, 2, 0.7), {.levels = {1, 2}, .method = InterpolationMethod::Fair},
              {{0, 0, -6}}, false);
  EXPECT_GT(other_, 0u);
}

// Into a buffer of their own, in the format of positions: what these were.
TEST_F(EmbedLevels, PreviousPositionsHaveTheFormatOfPositions) {
  with_both_variants([&] {
    const HostTopology topology = topology_of(test::icosphere(1), {.levels = {2}});
    HostFrame host = frame_of(topology);
    TessellationOptions wanted{.vertices = {.offset = 4,
                                            .stride = 12,
                                            .normal_offset = 8,
                                            .position_format = VertexFormat::Snorm16x4,
                                            .normal_format = VertexFormat::Octahedral16,
                                            .box_half = {3, 3, 3}},
                               .previous_positions = {.offset = 20, .stride = 16}};
    const std::uint64_t bytes = topology.device.tessellation_bytes(wanted, 1);
    const auto count = static_cast<std::size_t>(topology.device.level_vertex_counts()[0]);
    EXPECT_EQ(bytes, 20 + 16 * count - 8);
    Buffer vertices(*context_, bytes, MemoryUse::Download),
        previous(*context_, bytes, MemoryUse::Download);
    wanted.vertices.buffer = vertices.handle();
    wanted.previous_positions.buffer = previous.handle();
    const Tessellation levels(*context_, topology.device, host.solve, wanted);
    std::vector<std::uint64_t> last;
    for (int frame = 0; frame < 3; ++frame) {
      PolygonMesh pose = posed(test::icosphere(1), frame);
      host.set_points(pose);
      std::ranges::fill(previous.mapped(), std::byte{0x5a});
      previous.flush();
      submitter_->run([&](VkCommandBuffer commands) {
        host.solve.record_solve(commands, iterations(9));
        if (frame == 0) levels.record_reset(commands);
        glm::mat4 clip(0.1f);
        clip[2][2] = 0.01f, clip[3] = {0, 0, 0.5f, 1};
        levels.record_evaluate(commands, view_of(clip));
      });
      const auto positions = [&](Buffer& from, std::size_t offset, std::size_t stride) {
        const auto all = fetched<std::byte>(from, bytes);
        std::vector<std::uint64_t> found(count);
        for (std::size_t i = 0; i < count; ++i)
          std::memcpy(&found[i], &all[offset + i * stride], sizeof found[i]);
        return found;
      };
      const std::vector<std::uint64_t> now = positions(vertices, 4, 12);
      if (frame == 0) last = now;
      EXPECT_EQ(positions(previous, 20, 16), last) << frame;
      EXPECT_EQ(now == last, frame == 0);
      for (std::size_t i = 0; i + 1 < count; ++i)
        for (std::size_t k = 8; k < 16; ++k)
          ASSERT_EQ(previous.mapped()[20 + 16 * i + k], std::byte{0x5a});
      last = now;
    }
  });
}

TEST_F(EmbedLevels, HubsAndFewWorkGroupsHaveTheSameBits) {
  for (const PipelineVariant& variant : {kSoftwareVariant, kHardwareVariant})
    for (const test::NamedMesh& of : large_rings()) {
      if (of.name != "faces" && of.name != "ring" && of.name != "reflex") continue;
      SCOPED_TRACE(of.name);
      open({.max_group_count = 300, .variant = variant});
      const SystemOptions options{.levels = {1, 2}};
      LevelHost host(*context_, *submitter_, of.mesh, options, field(8, 6));
      const std::vector<std::uint32_t> levels = host.draw(view_of(perspective(0.1f, 5000), 1));
      expect_bits(host, levels, options);
    }
}

// The fair method has one instance, whose hull is made of its points of level 1.
TEST_F(EmbedLevels, TheFairMethodHasThemToo) {
  const PolygonMesh mesh = test::torus(12, 7, 2, 0.7);
  const SystemOptions options{.level = 1, .levels = kLevels, .method = InterpolationMethod::Fair};
  LevelHost host(*context_, *submitter_, mesh, options, {{0, 0, -20}});
  std::set<std::uint32_t> kinds;
  for (float pixels = 0.01f; pixels < 100; pixels *= 3) {
    host.reset();
    const std::vector<std::uint32_t> levels = host.draw(view_of(perspective(0.1f, 5000), pixels));
    if (kinds.insert(levels[0]).second) expect_bits(host, levels, options);
  }
  EXPECT_THAT(host.draw(view_of(-perspective(0.1f, 5000))), Each(kNotSeen));
  EXPECT_EQ(kinds.size(), 4u);
}

// The chords' middles are as far from the surface as its own middles are from the chords, but for
// the third order; and by most of it somewhere.
TEST_F(EmbedLevels, ChordErrorsAreThoseOfTheSurface) {
  const PolygonMesh meshes[] = {test::torus(12, 7, 2, 0.7), test::icosphere(1), test::prism(9)};
  for (const PolygonMesh& mesh : meshes) {
    const System levels(mesh, {.levels = kLevels});
    const std::vector<double> errors = levels.chord_errors();
    ASSERT_EQ(errors.size(), kLevels.size());
    const PlaceOracle oracle(cage_of(mesh), Weights::DooSabin);
    const SurfaceQueries queries(oracle.limit);
    for (std::size_t k = 0; k < 3; ++k) {
      const SystemOptions options{.level = kLevels[k]};
      const System system(mesh, options);
      const std::vector<Vertex> vertices = surface_by_cpu(mesh, mesh, options);
      double largest = 0;
      const auto triangles = system.triangles();
      for (std::size_t i = 0; i < triangles.size(); ++i) {
        const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
        const glm::dvec3 middle = 0.5 * (glm::dvec3(vertices[triangles[i]].position) +
                                         glm::dvec3(vertices[triangles[next]].position));
        largest = std::max(largest, queries.closest(middle).distance);
      }
      EXPECT_LE(largest, errors[k] * 1.02) << kLevels[k];
      EXPECT_GE(largest, 0.4 * errors[k]) << kLevels[k];
    }
  }
}

// What a Tessellation promises its host: that recording only records, and that options which do not
// fit are refused by name.
using ::testing::HasSubstr;

using EmbedLevelsHost = Embedding;

TEST_F(EmbedLevelsHost, RecordingOnlyRecords) {
  LevelHost host(*context_, *submitter_, test::icosphere(1), {.levels = {1, 2, 3, 4}},
                 {{0, 0, -4}, {0, 0, -40}, {0, 0, 4}},
                 {.vertices = {.stride = 36}, .previous_positions = {.offset = 24, .stride = 36}});
  HostCommands commands(*own_);
  Buffer report(*context_, 64, MemoryUse::Download);
  recorded_calls(commands, [&](VkCommandBuffer buffer) {
    host.levels->record_reset(buffer);
    host.levels->record_evaluate(buffer, view_of(perspective(0.1f, 5000)));
    host.levels->record_levels(buffer, report.handle(), 0);
  });
  // The same commands again and again.
  std::vector<std::uint32_t> first;
  for (int i = 0; i < 3; ++i) {
    commands.submit();
    commands.wait();
    const auto levels = fetched<std::uint32_t>(report, 3);
    if (i == 0) first = levels;
    EXPECT_EQ(levels, first);
  }
}

TEST_F(EmbedLevelsHost, WrongOptionsAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  const std::pair<std::vector<int>, const char*> of_systems[] = {
      {{0, 1}, "ascend from 1 to 5, but 0 stands first"},
      {{2, 2}, "but 2 stands behind 2"},
      {{3, 6}, "but 6 stands behind 3"}};
  for (const auto& [levels, words] : of_systems)
    EXPECT_THAT(
        test::message_of(ErrorCode::InvalidArgument, [&] { System(mesh, {.levels = levels}); }),
        HasSubstr(words));
  const HostTopology none = topology_of(mesh), some = topology_of(mesh, {.levels = {1, 3}});
  const Buffer target(*context_, 1 << 16, MemoryUse::Device),
      other(*context_, 64, MemoryUse::Device);
  const VertexLayout all{target.handle()};
  const VertexLayout apart{
      .buffer = target.handle(), .normal_offset = 0, .attributes = {other.handle(), 0, 12}};
  const vulkan::Solve without(*context_, none.device),
      with(*context_, some.device, {.instances = 3});
  EXPECT_THAT(
      test::message_of(ErrorCode::InvalidArgument,
                       [&] { Tessellation(*context_, none.device, without, {.vertices = all}); }),
      HasSubstr("no levels to choose from"));
  const std::pair<TessellationOptions, const char*> of_options[] = {
      {{}, "have no buffer"},
      {{.vertices = all, .places = {3}}, "places are of 1 levels, but the System has 2"},
      {{.vertices = all, .places = {2, 2}}, "places for 2 instances, but takes all 3"},
      {{.vertices = all, .places = {3, 0}}, "places for no instance"},
      {{.vertices = apart}, "in one buffer"},
      {{.vertices = all, .previous_positions = {.stride = 12}},
       "previous positions of a Tessellation have no buffer"},
      {{.vertices = all, .previous_positions = {other.handle(), 0, 8}},
       "a vertex of stride 8 does not hold 12 bytes from offset 0 on"},
      {{.vertices = all, .previous_positions = {target.handle(), 12, 24}},
       "normals of the Tessellation and positions of the view before share bytes"}};
  for (const auto& [options, words] : of_options)
    EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                                 [&] { Tessellation(*context_, some.device, with, options); }),
                HasSubstr(words));
}

// Of a device that binds 128 KiB: what is too large, by how much, and the way out.
TEST_F(EmbedLevelsHost, TooManyPlacesAreRefusedByLevel) {
  PretendedDriver::pretence().storage_range = 1 << 17;
  with_both_variants([&] {
    const HostTopology topology = topology_of(test::icosphere(1), {.levels = {1, 4}}, {24});
    const vulkan::Solve solve(*context_, topology.device, {.instances = 5});
    const Buffer target(*context_, 1 << 21, MemoryUse::Device);
    TessellationOptions options{.vertices = {.buffer = target.handle(), .offset = 8, .stride = 24}};
    const auto counts = topology.device.level_vertex_counts();
    const auto bytes = [&](std::int32_t coarse, std::int32_t fine) {
      return static_cast<std::uint64_t>(8 + 24 * (coarse * counts[0] + fine * counts[1]));
    };
    EXPECT_EQ(topology.device.tessellation_bytes(options, 5), bytes(5, 5));
    const std::string message = test::message_of(
        ErrorCode::OutOfMemory, [&] { Tessellation(*context_, topology.device, solve, options); });
    EXPECT_THAT(message, HasSubstr(": the Tessellation's vertices of level 4 take "));
    EXPECT_THAT(message,
                HasSubstr(" bytes of one binding, but maxStorageBufferRange is 131072; give that "
                          "level fewer places than 5 (TessellationOptions::places), or vertices "
                          "a smaller stride"));
    options.places = {9, 1};  // of which there are five
    EXPECT_EQ(topology.device.tessellation_bytes(options, 5), bytes(5, 1));
    const Tessellation levels(*context_, topology.device, solve, options);
    options.places = {5};
    EXPECT_THAT(test::message_of(ErrorCode::InvalidArgument,
                                 [&] { (void)topology.device.tessellation_bytes(options, 5); }),
                HasSubstr("places are of 1 levels, but the System has 2"));
  });
}

// Of a buffer that the Solve's points are in.
TEST_F(EmbedLevelsHost, VerticesOverPointsAreRefused) {
  const HostTopology topology = topology_of(test::icosphere(1), {.levels = {1, 3}});
  const Buffer all(*context_, 1 << 21, MemoryUse::Device);
  const vulkan::Solve solve(*context_, topology.device,
                            {.given = {all.handle(), 1 << 20}, .instances = 2});
  const auto made_at = [&](VkDeviceSize offset) {
    const Tessellation levels(*context_, topology.device, solve,
                              {.vertices = {.buffer = all.handle(), .offset = offset}});
  };
  const std::uint64_t bytes = topology.device.tessellation_bytes({}, 2);
  made_at((1 << 20) - bytes);
  EXPECT_THAT(
      test::message_of(ErrorCode::InvalidArgument, [&] { made_at((1 << 20) + 24 - bytes); }),
      HasSubstr("given points of slot 0 and positions of the Tessellation share bytes "));
}

}  // namespace
}  // namespace planish::testing
