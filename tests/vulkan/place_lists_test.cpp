// What lists of places may hold, and where their results go.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <random>

#include "planish/core/error.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "vulkan/places_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class PlaceLists : public PlacesOnDevice {};

bool is_place_of(const MeshTopology& topology, const SurfaceParameter& at) {
  try {
    (void)corner_parameter(topology, at);
    return true;
  } catch (const Error&) {
    return false;
  }
}

bool is_beside_face(const MeshTopology& topology, const SurfaceParameter& at) {
  for (const double du : {-1e-6, 0.0, 1e-6})
    for (const double dv : {-1e-6, 0.0, 1e-6})
      if (is_place_of(topology, {at.face, at.u + du, at.v + dv})) return true;
  return false;
}

TEST_F(PlaceLists, RecordsOfAnyContentAreAnsweredOrNone) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  for (const PolygonMesh& mesh : {test::torus(5, 4, 2, 0.7), test::prism(13)}) {
    const auto faces = static_cast<std::uint32_t>(mesh.face_count());
    const std::vector<PlaceRecord> bad = {{faces, 0.2f, 0.2f}, {0xffffffffu, 0.2f, 0.2f},
                                          {0x80000000u, 0, 0}, {0, nan, 0.2f},
                                          {0, 0.2f, nan},      {0, infinite, 0},
                                          {0, -infinite, 0},   {0, 0.2f, -0.01f},
                                          {0, 70000.0f, 0.2f}, {0, 0.2f, 3.6f},
                                          {0, -1e30f, 1e30f},  {1, 1e38f, 0.1f},
                                          {0, -0.01f, 0.2f},   {0, 0.2f, 5.2f}};
    for (const ReadPath path : {ReadPath::Texel, ReadPath::Storage}) {
      open_reading(path);
      for (const PlaceResult& result : results_of(mesh, bad)) {
        EXPECT_EQ(result.state, PlaceState::None);
        for (const glm::vec3& v : {result.position, result.normal, result.du, result.dv, result.duu,
                                   result.duv, result.dvv})
          EXPECT_EQ(v, glm::vec3(0));
      }
      // Any words at all.
      std::mt19937 random(3);
      std::vector<PlaceRecord> any(20'000);
      for (PlaceRecord& place : any) {
        const auto word = [&] { return static_cast<std::uint32_t>(random()); };
        place = {word() % 2 == 0 ? word() % (faces + 2) : word(), std::bit_cast<float>(word()),
                 std::bit_cast<float>(word())};
        if (word() % 4 == 0) place.u = static_cast<float>(word() % 1000) / 200;
        if (word() % 4 == 0) place.v = static_cast<float>(word() % 1000) / 200;
      }
      int answered = 0;
      const PlaceOracle oracle(mesh, Weights::DooSabin);
      const auto found = results_of(mesh, any);
      for (std::size_t i = 0; i < any.size(); ++i) {
        const PlaceResult& result = found[i];
        const SurfaceParameter at{static_cast<std::int32_t>(any[i].face), any[i].u, any[i].v};
        const bool is_place = is_place_of(oracle.limit.topology(), at);
        answered += is_place ? 1 : 0;
        // Places within 1e-6 of a face count here, within 1e-9 there.
        if (is_place || !is_beside_face(oracle.limit.topology(), at)) {
          ASSERT_EQ(result.state != PlaceState::None, is_place)
              << at.face << " " << at.u << " " << at.v;
        }
        ASSERT_TRUE(std::isfinite(result.position.x + result.du.x + result.duv.y)) << i;
      }
      EXPECT_GT(answered, 100);
    }
  }
}

TEST_F(PlaceLists, TakeAnyLayoutAndTouchNothingBeside) {
  const PolygonMesh mesh = in_floats(test::icosphere(1));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  const auto places = places_on(oracle.limit.topology(), 5, 1);
  const auto count = static_cast<std::uint32_t>(places.size());
  const auto expected = results_of(mesh, places);
  Case c(*context_, *submitter_, mesh);
  Buffer list(*context_, 20 + 28 * std::uint64_t(count), MemoryUse::Upload);
  for (std::size_t i = 0; i < count; ++i)
    std::memcpy(&list.mapped()[20 + 28 * i], &places[i], sizeof places[i]);
  list.flush();
  PlaceLayout layout{.stride = 40};
  layout.offset = 12;
  layout.dvv_offset = 4;
  layout.position_offset = 28;
  layout.state_offset = 20;
  layout.normal_offset = layout.du_offset = layout.dv_offset = kNotWritten;
  layout.duu_offset = layout.duv_offset = kNotWritten;
  const std::uint32_t asked = count - 7;
  Buffer results(*context_, layout.offset + 40 * std::uint64_t(count), MemoryUse::Download);
  std::memset(results.mapped().data(), 0x5a, results.mapped().size());
  results.flush();
  layout.buffer = results.handle();
  const Places strided(*context_, c.tables, c.solve,
                       {.list = {list.handle(), 20, 28, count}, .results = layout});
  submitter_->run([&](VkCommandBuffer commands) {
    c.solve.record_solve(commands, {});
    c.solve.record_surface(commands);
    strided.record_evaluate(commands, asked);
  });
  results.invalidate();
  for (std::size_t i = 0; i < asked; ++i) {
    std::byte* at = &results.mapped()[layout.offset + 40 * i];
    glm::vec3 position, dvv;
    PlaceState state;
    std::memcpy(&position, at + 28, sizeof position);
    std::memcpy(&dvv, at + 4, sizeof dvv);
    std::memcpy(&state, at + 20, sizeof state);
    ASSERT_EQ(position, expected[i].position) << i;
    ASSERT_EQ(dvv, expected[i].dvv) << i;
    ASSERT_EQ(state, expected[i].state) << i;
    std::memset(at + 28, 0x5a, sizeof position);
    std::memset(at + 4, 0x5a, sizeof dvv);
    std::memset(at + 20, 0x5a, sizeof state);
  }
  EXPECT_THAT(results.mapped(), ::testing::Each(std::byte{0x5a}));
}

TEST_F(PlaceLists, SlicesAndListsOfTheirOwnChangeNothing) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::icosphere(1), 0.1, 3));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  const auto places = places_on(oracle.limit.topology(), 6, 60);
  const auto count = static_cast<std::uint32_t>(places.size());
  const auto expected = results_of(mesh, places);
  for (const ContextOptions& low :
       {ContextOptions{.max_storage_range = 1 << 20}, ContextOptions{.max_group_count = 3}}) {
    open(low);
    PretendedDriver::forget_notes();
    Case c(*context_, *submitter_, mesh, {}, {.list = {.count = count}});
    std::memcpy(c.list.mapped().data(), places.data(), places.size() * sizeof places[0]);
    c.list.flush();
    const Places asked(*context_, c.tables, c.solve,
                       {.list = {.count = count}, .results = {.buffer = c.results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      asked.record_list(commands, c.list.handle(), 0);
      c.solve.record_solve(commands, {});
      c.solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    if (low.max_group_count > 0) {
      EXPECT_LE(PretendedDriver::notes().largest_dispatch, low.max_group_count);
    }
    c.results.invalidate();
    EXPECT_EQ(std::memcmp(c.results.mapped().data(), expected.data(),
                          expected.size() * sizeof expected[0]),
              0);
  }
}

TEST_F(PlaceLists, RecordingIsOnlyVkCmd) {
  const PolygonMesh mesh = test::icosphere(1);
  Case c(*context_, *submitter_, mesh, {}, {.list = {.count = 100}});
  const Places asked(*context_, c.tables, c.solve,
                     {.list = {.count = 100}, .results = {.buffer = c.results.handle()}});
  std::memset(c.list.mapped().data(), 0, c.list.mapped().size());
  c.list.flush();
  HostCommands commands(*own_);
  commands.record([&](VkCommandBuffer buffer) {
    c.solve.record_solve(buffer, {});
    const std::map<std::string, int> before = PretendedDriver::counts();
    c.solve.record_surface(buffer);
    asked.record_list(buffer, c.list.handle(), 0);
    asked.record_evaluate(buffer, 50);
    for (const auto& [name, calls] : PretendedDriver::counts()) {
      const auto found = before.find(name);
      if (found != before.end() && found->second == calls) continue;
      EXPECT_THAT(name, StartsWith("vkCmd"));
    }
  });
  commands.submit();
  commands.wait();
}

TEST_F(PlaceLists, BadOptionsAreRefused) {
  const PolygonMesh mesh = test::icosphere(1);
  Case c(*context_, *submitter_, mesh, {}, {.list = {.count = 8}});
  const auto message = [&](const PlacesOptions& options) {
    return test::message_of(ErrorCode::InvalidArgument,
                            [&] { Places(*context_, c.tables, c.solve, options); });
  };
  const PlaceLayout results{.buffer = c.results.handle()};
  const PlaceList list{.count = 8};
  EXPECT_THAT(message({.results = results}), HasSubstr("has none"));
  EXPECT_THAT(message({.list = {c.list.handle(), 2, 12, 8}, .results = results}),
              HasSubstr("offset 2"));
  EXPECT_THAT(message({.list = {c.list.handle(), 0, 8, 8}, .results = results}),
              HasSubstr("stride 8"));
  EXPECT_THAT(message({.list = {{}, 0, 16, 8}, .results = results}), HasSubstr("stride 12"));
  EXPECT_THAT(message({.list = list}), HasSubstr("no buffer"));
  PlaceLayout bad = results;
  bad.dvv_offset = 80;
  EXPECT_THAT(message({.list = list, .results = bad}), HasSubstr("end at 92 bytes"));
  bad.dvv_offset = 88;
  EXPECT_THAT(message({.list = list, .results = bad}), HasSubstr("offset 88"));
  bad = results;
  bad.duv_offset = 56;
  EXPECT_THAT(message({.list = list, .results = bad}),
              HasSubstr("duu of places and duv of places share bytes 56 to "));
  EXPECT_THAT(message({.list = {c.results.handle(), 0, 12, 8}, .results = results}),
              HasSubstr("a list of places and positions of places share bytes 0 to "));
  const DeviceSystem without(*context_, c.system);
  EXPECT_THAT(test::message_of(
                  ErrorCode::InvalidArgument,
                  [&] { Places(*context_, without, c.solve, {.list = list, .results = results}); }),
              HasSubstr("answers_places"));
}

TEST_F(PlaceLists, LowLimitsAreNamed) {
  open({.max_storage_range = 1 << 18});
  const System system(test::random_closed_mesh(2));
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] {
                                 DeviceSystem(*context_, system,
                                              {.max_vertex_stride = 24, .answers_places = true});
                               }),
              HasSubstr("kinds of corners take"));
}

}  // namespace
}  // namespace planish::testing
