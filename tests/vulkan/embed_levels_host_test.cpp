// What a Tessellation promises its host: that recording only records, and that options which do not
// fit are refused by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/expect_error.h"
#include "support/meshes.h"
#include "vulkan/level_host.h"
#include "vulkan/places_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;

class EmbedLevelsHost : public Embedding {};

TEST_F(EmbedLevelsHost, RecordingOnlyRecords) {
  LevelHost host(*context_, *submitter_, test::icosphere(1), {.levels = {1, 2, 3, 4}},
                 {{0, 0, -4}, {0, 0, -40}, {0, 0, 4}});
  HostCommands commands(*own_);
  Buffer report(*context_, 64, MemoryUse::Download);
  commands.record([&](VkCommandBuffer buffer) {
    const std::map<std::string, int> before = PretendedDriver::counts();
    host.levels->record_reset(buffer);
    host.levels->record_evaluate(buffer, view_of(perspective(0.1f, 5000)));
    host.levels->record_levels(buffer, report.handle(), 0);
    for (const auto& [name, count] : PretendedDriver::counts()) {
      const auto found = before.find(name);
      if (found != before.end() && found->second == count) continue;
      EXPECT_THAT(name, ::testing::StartsWith("vkCmd"));
    }
  });
  // The same commands again and again.
  std::vector<std::uint32_t> first;
  for (int i = 0; i < 3; ++i) {
    commands.submit();
    commands.wait();
    if (i == 0) first = words_of(report);
    EXPECT_EQ(words_of(report), first);
  }
}

TEST_F(EmbedLevelsHost, WrongOptionsAreRefusedByName) {
  const PolygonMesh mesh = test::icosphere(1);
  const auto refusal = [](const auto& make) {
    try {
      make();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
      return std::string(error.what());
    }
    return std::string("nothing thrown");
  };
  const auto of_levels = [&](std::vector<int> levels) {
    return refusal([&] { const System system(mesh, {.levels = std::move(levels)}); });
  };
  EXPECT_THAT(of_levels({0, 1}), HasSubstr("ascend from 1 to 5, but 0 stands first"));
  EXPECT_THAT(of_levels({2, 2}), HasSubstr("but 2 stands behind 2"));
  EXPECT_THAT(of_levels({3, 6}), HasSubstr("but 6 stands behind 3"));
  HostTopology none(*context_, mesh), some(*context_, mesh, {.levels = {1, 3}});
  const Buffer target(*context_, 1 << 16, MemoryUse::Device),
      other(*context_, 64, MemoryUse::Device);
  const vulkan::Solve without(*context_, none.device),
      with(*context_, some.device, {.instances = 3});
  const auto of_options = [&](const TessellationOptions& options) {
    return refusal([&] { const Tessellation levels(*context_, some.device, with, options); });
  };
  EXPECT_THAT(refusal([&] {
                const Tessellation levels(*context_, none.device, without,
                                          {.vertices = {target.handle()}});
              }),
              HasSubstr("no levels to choose from"));
  EXPECT_THAT(of_options({}), HasSubstr("have no buffer"));
  EXPECT_THAT(of_options({.vertices = {target.handle()}, .places = {3}}),
              HasSubstr("places are of 1 levels, but the System has 2"));
  EXPECT_THAT(of_options({.vertices = {target.handle()}, .places = {2, 2}}),
              HasSubstr("places for 2 instances, but takes all 3"));
  EXPECT_THAT(of_options({.vertices = {target.handle()}, .places = {3, 0}}),
              HasSubstr("places for no instance"));
  VertexLayout apart{target.handle()};
  apart.attributes = {other.handle(), 0, 12};
  apart.normal_offset = 0;
  EXPECT_THAT(of_options({.vertices = apart}), HasSubstr("in one buffer"));
}

// Of a device that binds 128 KiB: what is too large, by how much, and the way out.
TEST_F(EmbedLevelsHost, TooManyPlacesAreRefusedByLevel) {
  PretendedDriver::pretence().storage_range = 1 << 17;
  with_both_variants([&] {
    HostTopology topology(*context_, test::icosphere(1), {.levels = {1, 4}}, 24);
    const vulkan::Solve solve(*context_, topology.device, {.instances = 5});
    const Buffer target(*context_, 1 << 21, MemoryUse::Device);
    TessellationOptions options{.vertices = {.buffer = target.handle(), .offset = 8, .stride = 24}};
    const auto counts = topology.device.level_vertex_counts();
    const auto bytes = [&](std::int32_t coarse, std::int32_t fine) {
      return static_cast<std::uint64_t>(8 + 24 * (coarse * counts[0] + fine * counts[1]));
    };
    EXPECT_EQ(topology.device.tessellation_bytes(options, 5), bytes(5, 5));
    try {
      const Tessellation levels(*context_, topology.device, solve, options);
      FAIL() << "nothing thrown";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::OutOfMemory);
      EXPECT_THAT(error.what(), HasSubstr(": the Tessellation's vertices of level 4 take "));
      EXPECT_THAT(error.what(),
                  HasSubstr(" bytes of one binding, but maxStorageBufferRange is 131072; give that "
                            "level fewer places than 5 (TessellationOptions::places), or vertices "
                            "a smaller stride"));
    }
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
  HostTopology topology(*context_, test::icosphere(1), {.levels = {1, 3}});
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
