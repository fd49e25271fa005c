// Levels by need: which one each instance of a view has, against a choice in double; that what is
// evaluated has record_evaluate's bits; that what is not seen is neither dispatched nor drawn.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "planish/pipeline/fit.h"
#include "planish/queries/surface_queries.h"
#include "planish/solve/backend.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/large_rings.h"
#include "vulkan/level_host.h"
#include "vulkan/places_fixture.h"

namespace planish::testing {
namespace {

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
      HostTopology topology(*context_, host.rest, one);
      topology.upload(*submitter_);
      HostFrame frame(*context_, topology);
      const auto triangles = topology.system.triangles();
      const std::vector<std::uint32_t> indices =
          host.fetch(host.levels->indices(), index_offset(draws, levels, k) * sizeof(std::uint32_t),
                     triangles.size_bytes());
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
      const std::vector<std::uint32_t> groups = host.fetch(buffer, offset, 12);
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
    submitter_->run([&](VkCommandBuffer commands) { host.levels->record_reset(commands); });
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
    HostTopology topology(*context_, mesh);
    topology.upload(*submitter_);
    HostFrame frame(*context_, topology);
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
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const PolygonMesh pose = host.pose_of(numbers[i]);
      const std::vector<glm::vec3> rounded(pose.positions.begin(), pose.positions.end());
      std::memcpy(alone.points.mapped().data() + i * rounded.size() * sizeof rounded[0],
                  rounded.data(), rounded.size() * sizeof rounded[0]);
    }
    alone.points.flush();
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
    submitter_->run([&](VkCommandBuffer commands) { host.levels->record_reset(commands); });
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
  submitter_->run([&](VkCommandBuffer commands) { host.levels->record_reset(commands); });
  EXPECT_EQ(host.draw(at(0.12f, 0.7f)), expected_levels(host, at(0.12f, 0.7f)));
  EXPECT_NE(fine, coarse);
}

// Instances in their order, where a level has no place left: a coarser one.
TEST_F(EmbedLevels, TakeACoarserOneWhereTheirsIsFull) {
  const PolygonMesh mesh = test::torus(9, 6, 2, 0.7);
  const SystemOptions options{.level = 1, .levels = kLevels};
  const std::vector<std::uint32_t> room = {40, 6, 2, 3};
  with_both_variants([&] {
    LevelHost host(*context_, *submitter_, mesh, options, field(40), room);
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
    submitter_->run([&](VkCommandBuffer commands) { host.levels->record_reset(commands); });
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

}  // namespace
}  // namespace planish::testing
