// The surface at lists of places, in single precision on a device, against LimitSurface.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "planish/limit/limit_surface.h"
#include "planish/pipeline/fit.h"
#include "support/expect_error.h"
#include "support/meshes.h"
#include "support/random_meshes.h"
#include "vulkan/embedding_fixture.h"

namespace planish::testing {
namespace {

using namespace vulkan;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct PlaceRecord {
  std::uint32_t face = 0;
  float u = 0, v = 0;
};

struct PlaceResult {
  glm::vec3 position, normal, du, dv, duu, duv, dvv;
  PlaceState state;
};
static_assert(sizeof(PlaceResult) == 88);

PolygonMesh in_floats(PolygonMesh mesh) {
  for (glm::dvec3& p : mesh.positions) {
    const glm::vec3 rounded(p);
    std::memcpy(&p, std::array{double(rounded.x), double(rounded.y), double(rounded.z)}.data(),
                sizeof p);
  }
  return mesh;
}

/// Closed, open, creased, with holes; valences 3 to 20, faces of 3 to 20 corners, valence 2.
std::vector<test::NamedMesh> meshes_for_places() {
  std::vector<test::NamedMesh> meshes = {{"torus", test::torus(12, 7, 2, 0.7)},
                                         {"icosphere", test::icosphere(1)},
                                         {"plate", test::plate_with_hole(5)},
                                         {"L", test::l_shaped_plate(2)},
                                         {"valence 2", test::cube_with_split_edges()}};
  for (int n = 3; n <= 20; ++n) {
    meshes.push_back({"bipyramid " + std::to_string(n), test::bipyramid(n)});
    meshes.push_back({"prism " + std::to_string(n), test::prism(n)});
  }
  for (std::uint32_t seed = 1; seed < 5; ++seed) {
    const std::string name = std::to_string(seed);
    meshes.push_back({"closed " + name, test::random_closed_mesh(seed)});
    meshes.push_back(
        {"creases " + name, test::with_random_creases(test::random_closed_mesh(seed), 0.2, seed)});
    meshes.push_back(
        {"open " + name, test::with_random_creases(test::random_open_mesh(seed), 0.1, seed)});
    PolygonMesh holed = meshes.back().mesh;
    holed.hole_faces = {2, 5, holed.face_count() - 1};
    meshes.push_back({"holes " + name, holed});
  }
  for (test::NamedMesh& mesh : meshes) mesh.mesh = in_floats(mesh.mesh);
  return meshes;
}

/// The limit surface of the mesh itself as a cage, hole faces included.
struct PlaceOracle {
  PlaceOracle(const PolygonMesh& cage, Weights weights)
      : mesh(cage),
        limit(std::make_shared<const DooSabinSurface>(mesh, EvaluateOptions{.weights = weights})) {}
  PolygonMesh mesh;
  LimitSurface limit;
};

/// Anywhere, near vertices and centres, and on borders.
std::vector<PlaceRecord> places_on(const MeshTopology& topology, std::uint32_t seed, int each) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(0, 1);
  std::uniform_int_distribution<int> kind(0, 5), power(1, 20);
  std::vector<PlaceRecord> places;
  for (std::int32_t c = 0; c < topology.corner_count(); ++c)
    for (int i = 0; i < each; ++i) {
      double u = within(random), v = within(random);
      const double near = std::ldexp(1.0, -power(random));
      switch (kind(random)) {
        case 0:
          u *= near, v *= near;
          break;
        case 1:
          u = 1 - near * u, v = 1 - near * v;
          break;
        case 2:
          u = kind(random) / 5.0, v = kind(random) < 3 ? 0 : 1;
          break;
        default:
          break;
      }
      const SurfaceParameter at = surface_parameter(topology, c, u, v);
      places.push_back({static_cast<std::uint32_t>(at.face), static_cast<float>(at.u),
                        static_cast<float>(at.v)});
    }
  return places;
}

class PlacesOnDevice : public Embedding {
 protected:
  struct Case {
    Case(Context& context, Submitter& submitter, const PolygonMesh& mesh,
         const SystemOptions& options = {}, const PlacesOptions& places = {})
        : system(mesh, options),
          tables(context, system, {.answers_places = true}),
          staging(context, tables.upload_bytes(), MemoryUse::Upload),
          points(context, tables.given_count() * sizeof(glm::vec3), MemoryUse::Upload),
          solve(context, tables, {.given = {points.handle()}}),
          list(context, std::max(1u, places.list.count) * sizeof(PlaceRecord), MemoryUse::Upload),
          results(context, std::max(1u, places.list.count) * sizeof(PlaceResult),
                  MemoryUse::Download) {
      tables.write_upload(system, staging.mapped().first(tables.upload_bytes()));
      staging.flush();
      submitter.run(
          [&](VkCommandBuffer commands) { tables.record_upload(commands, staging.handle(), 0); });
      const std::vector<glm::vec3> rounded(mesh.positions.begin(), mesh.positions.end());
      std::memcpy(points.mapped().data(), rounded.data(), rounded.size() * sizeof rounded[0]);
      points.flush();
    }
    System system;
    DeviceSystem tables;
    Buffer staging, points;
    vulkan::Solve solve;
    Buffer list, results;
  };

  /// Of the mesh itself as a cage.
  std::vector<PlaceResult> results_of(const PolygonMesh& mesh,
                                      const std::vector<PlaceRecord>& places,
                                      const SystemOptions& options = {},
                                      std::uint32_t step_count = 0) {
    const auto count = static_cast<std::uint32_t>(places.size());
    Case c(*context_, *submitter_, mesh, options, {.list = {.count = count}});
    std::memcpy(c.list.mapped().data(), places.data(), places.size() * sizeof places[0]);
    c.list.flush();
    const Places asked(
        *context_, c.tables, c.solve,
        {.list = {c.list.handle(), 0, 12, count}, .results = {.buffer = c.results.handle()}});
    submitter_->run([&](VkCommandBuffer commands) {
      c.solve.record_solve(commands, {.iterations = step_count});
      c.solve.record_surface(commands);
      asked.record_evaluate(commands);
    });
    c.results.invalidate();
    std::vector<PlaceResult> results(places.size());
    std::memcpy(results.data(), c.results.mapped().data(), results.size() * sizeof results[0]);
    return results;
  }

  void open_reading(ReadPath path, const ContextOptions& given = {}) {
    ContextOptions options = given;
    options.variant = path == ReadPath::Texel ? kSoftwareVariant : kHardwareVariant;
    open(options);
  }
};

struct PlaceErrors {
  double position = 0, first = 0, second = 0, normal = 0;
};

// First derivatives in parts of themselves, second ones of the first ones and themselves: what
// rounding leaves is in proportion to what is added up. At `distance` from V or F double itself has
// rounded points of the patch before it took differences and made them 1 / distance larger, twice
// for second derivatives.
void compare_place(const PlaceResult& found, const SurfacePoint& expected, double size,
                   double distance, PlaceErrors& errors) {
  const auto grow = [](double& largest, double value) {
    if (!(value <= largest)) largest = value;
  };
  const auto off = [](const glm::vec3& a, const glm::dvec3& b) {
    return glm::distance(glm::dvec3(a), b);
  };
  const double first = glm::length(expected.du) + glm::length(expected.dv) + 0.01 * size;
  grow(errors.position, off(found.position, expected.position) / size);
  const bool is_singular = found.state == PlaceState::Singular;
  ASSERT_TRUE(is_singular || found.state == PlaceState::Regular);
  // Beside such a place first derivatives depend on the direction.
  if (!is_singular || distance == 0)
    grow(errors.first, (off(found.du, expected.du) + off(found.dv, expected.dv)) / first);
  if (is_singular) {
    ASSERT_LT(distance, std::ldexp(1.0, -23));
    for (const glm::vec3& d : {found.duu, found.duv, found.dvv}) ASSERT_EQ(d, glm::vec3(0));
  } else {
    ASSERT_TRUE(expected.has_second);
    const double second = glm::length(expected.duu) + glm::length(expected.duv) +
                          glm::length(expected.dvv) + first + 1e-9 * size / (distance * distance);
    grow(errors.second, (off(found.duu, expected.duu) + off(found.duv, expected.duv) +
                         off(found.dvv, expected.dvv)) /
                            second);
  }
  // At vertices of valence 2 tangents are parallel, and LimitSurface has a normal of places around.
  if (is_singular && found.normal == glm::vec3(0)) return;
  // The less of a direction the more parallel tangents are.
  const double area = glm::length(glm::cross(expected.du, expected.dv)) /
                      (glm::length(expected.du) * glm::length(expected.dv));
  const double shorter = std::min(glm::length(expected.du), glm::length(expected.dv));
  const double noise = distance == 0 ? 0 : 1e-10 * size / (distance * shorter);
  if (area > 1e-3) grow(errors.normal, area * off(found.normal, expected.normal) / (1 + noise));
}

// Of a place in its corner's patch from the nearer one of V and F.
double distance_to_ends(const MeshTopology& topology, const SurfaceParameter& at) {
  const CornerParameter in = corner_parameter(topology, at);
  return std::min(std::max(in.u, in.v), std::max(1 - in.u, 1 - in.v));
}

TEST_F(PlacesOnDevice, AreTheLimitSurfaces) {
  for (const ReadPath path : {ReadPath::Texel, ReadPath::Storage}) {
    open_reading(path);
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      PlaceErrors worst;
      for (const auto& [name, mesh] : meshes_for_places()) {
        SCOPED_TRACE(name);
        const PlaceOracle oracle(mesh, weights);
        const auto places = places_on(oracle.limit.topology(), 7, 12);
        const auto found = results_of(mesh, places, {.weights = weights});
        const double size = oracle.limit.surface().placement().diagonal;
        PlaceErrors errors;
        for (std::size_t i = 0; i < places.size(); ++i) {
          const SurfaceParameter at{static_cast<std::int32_t>(places[i].face), places[i].u,
                                    places[i].v};
          compare_place(found[i], oracle.limit.evaluate(at), size,
                        distance_to_ends(oracle.limit.topology(), at), errors);
          ASSERT_FALSE(HasFatalFailure()) << places[i].face << " " << at.u << " " << at.v;
        }
        EXPECT_LT(errors.position, 3e-7);
        EXPECT_LT(errors.first, 1e-5);
        EXPECT_LT(errors.second, 1e-5);
        EXPECT_LT(errors.normal, 1e-5);
        worst = {std::max(worst.position, errors.position), std::max(worst.first, errors.first),
                 std::max(worst.second, errors.second), std::max(worst.normal, errors.normal)};
      }
      std::printf("  off by at most %.1e, du %.1e, duu %.1e, normals %.1e\n", worst.position,
                  worst.first, worst.second, worst.normal);
    }
  }
}

// At vertices and centres themselves the limits are closed forms.
TEST_F(PlacesOnDevice, KnowVerticesAndCentres) {
  for (const auto& [name, mesh] : meshes_for_places()) {
    SCOPED_TRACE(name);
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c)
      for (const double at : {0.0, 1.0}) {
        const SurfaceParameter p = surface_parameter(topology, c, at, at);
        places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      }
    const auto found = results_of(mesh, places);
    const double size = oracle.limit.surface().placement().diagonal;
    PlaceErrors errors;
    for (std::size_t i = 0; i < places.size(); ++i) {
      const SurfacePoint expected = oracle.limit.evaluate(
          {static_cast<std::int32_t>(places[i].face), places[i].u, places[i].v});
      ASSERT_EQ(found[i].state == PlaceState::Regular, expected.has_second) << i;
      compare_place(found[i], expected, size, 0, errors);
    }
    EXPECT_LT(errors.position, 3e-7);
    EXPECT_LT(errors.first, 1e-5);
    EXPECT_LT(errors.normal, 1e-5);
  }
}

TEST_F(PlacesOnDevice, LieOnTheSurfaceOfASolve) {
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    const PolygonMesh mesh =
        in_floats(test::with_random_creases(test::random_open_mesh(2), 0.1, 3));
    const PlaceOracle oracle(mesh, Weights::DooSabin);
    const MeshTopology& topology = oracle.limit.topology();
    std::vector<PlaceRecord> places;
    std::vector<std::int32_t> vertices;
    for (std::int32_t c = 0; c < topology.corner_count(); ++c) {
      const SurfaceParameter p = surface_parameter(topology, c, 0, 0);
      places.push_back({static_cast<std::uint32_t>(p.face), float(p.u), float(p.v)});
      vertices.push_back(topology.vertex_of(c));
    }
    const auto found = results_of(mesh, places, {.method = method}, 60);
    for (std::size_t i = 0; i < places.size(); ++i)
      ASSERT_LT(glm::distance(glm::dvec3(found[i].position), mesh.positions[vertices[i]]), 4e-6)
          << i;
  }
}

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

TEST_F(PlacesOnDevice, RecordsOfAnyContentAreAnsweredOrNone) {
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
        if (is_place || !is_beside_face(oracle.limit.topology(), at))
          ASSERT_EQ(result.state != PlaceState::None, is_place)
              << at.face << " " << at.u << " " << at.v;
        ASSERT_TRUE(std::isfinite(result.position.x + result.du.x + result.duv.y)) << i;
      }
      EXPECT_GT(answered, 100);
    }
  }
}

TEST_F(PlacesOnDevice, TakeAnyLayoutAndTouchNothingBeside) {
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

TEST_F(PlacesOnDevice, SlicesAndListsOfTheirOwnChangeNothing) {
  const PolygonMesh mesh = in_floats(test::with_random_creases(test::icosphere(1), 0.1, 3));
  const PlaceOracle oracle(mesh, Weights::DooSabin);
  const auto places = places_on(oracle.limit.topology(), 6, 60);
  const auto count = static_cast<std::uint32_t>(places.size());
  const auto expected = results_of(mesh, places);
  for (const ContextOptions& low :
       {ContextOptions{.max_storage_range = 1 << 20}, ContextOptions{.max_group_count = 3}}) {
    open(low);
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
    c.results.invalidate();
    EXPECT_EQ(std::memcmp(c.results.mapped().data(), expected.data(),
                          expected.size() * sizeof expected[0]),
              0);
  }
}

TEST_F(PlacesOnDevice, RecordingIsOnlyVkCmd) {
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

TEST_F(PlacesOnDevice, BadOptionsAreRefused) {
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
  const DeviceSystem without(*context_, c.system);
  EXPECT_THAT(test::message_of(
                  ErrorCode::InvalidArgument,
                  [&] { Places(*context_, without, c.solve, {.list = list, .results = results}); }),
              HasSubstr("answers_places"));
}

TEST_F(PlacesOnDevice, LowLimitsAreNamed) {
  open({.max_storage_range = 1 << 18});
  const System system(test::random_closed_mesh(2));
  EXPECT_THAT(test::message_of(ErrorCode::OutOfMemory,
                               [&] {
                                 DeviceSystem(*context_, system,
                                              {.max_vertex_stride = 24, .answers_places = true});
                               }),
              HasSubstr("kinds of corners span"));
}

}  // namespace
}  // namespace planish::testing
