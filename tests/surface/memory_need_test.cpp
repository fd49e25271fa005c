#include "planish/surface/memory_need.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "planish/core/error.h"
#include "planish/solve/backend.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "support/meshes.h"

namespace planish {
namespace {

// Element counts of the levels 0 to `last` of a torus of side x side quads.
std::vector<LevelCounts> torus_levels(std::int64_t side, int last) {
  const std::int64_t count = side * side;
  return split_counts({count, 2 * count, count}, 4 * count, last);
}

TEST(MemoryNeed, GrowsFourfoldWithEachLevel) {
  const auto bytes = [](int level) {
    return static_cast<double>(tessellation_bytes(torus_levels(100, level), LastLevel::Full));
  };
  EXPECT_NEAR((bytes(5) - bytes(4)) / (bytes(4) - bytes(3)), 4.0, 0.01);
}

TEST(MemoryNeed, IsComparedWithTheLimit) {
  EXPECT_NO_THROW(require_memory(torus_levels(100, 2), LastLevel::Full, {}, 1ull << 30));
  EXPECT_THROW(require_memory(torus_levels(100, 5), LastLevel::Full, {}, 1ull << 30), Error);
}

TEST(MemoryNeed, IndicesStayWithin32Bits) {
  try {
    require_memory(torus_levels(1000, 6), LastLevel::Full, {}, ~0ull);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("32-bit"), std::string::npos) << error.what();
  }
}

// The largest resident size since the last call, in bytes.
std::uint64_t peak_since_last_call() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kibibytes = 0;
  while (status >> word && word != "VmHWM:") {
  }
  status >> kibibytes;
  std::ofstream("/proc/self/clear_refs") << "5";
  return 1024 * kibibytes;
}

std::uint64_t peak_of_tessellating(const PolygonMesh& mesh) {
  const auto backend = make_cpu_backend();
  (void)peak_since_last_call();
  (void)evaluate(mesh, *backend, {.level = 4});
  return peak_since_last_call();
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(MemoryNeed, OfAttributesIsWhatTheyTake) {
  PolygonMesh mesh = test::torus(60, 60, 1.0, 0.4);
  const std::vector<LevelCounts> counts = torus_levels(60, 4);
  const auto estimate = [&] {
    return tessellation_bytes(counts, LastLevel::None, RefinedAttributes::of(mesh));
  };
  const std::uint64_t plain_peak = peak_of_tessellating(mesh), plain_estimate = estimate();
  const auto expect_estimated = [&](const char* what) {
    const auto taken = static_cast<double>(peak_of_tessellating(mesh) - plain_peak);
    const auto estimated = static_cast<double>(estimate() - plain_estimate);
    EXPECT_LT(taken, 1.05 * estimated) << what;
    EXPECT_GT(taken, 0.4 * estimated) << what;
  };
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  mesh.face_uvs = mesh.face_vertices;
  expect_estimated("uvs");
  mesh.colors.resize(mesh.positions.size(), glm::vec4(1.0f));
  mesh.groups = {{"a", "b"}};
  mesh.face_groups.resize(static_cast<std::size_t>(mesh.face_count()), 0);
  expect_estimated("uvs, colours, groups");
}
#endif

TEST(MemoryNeed, OfHolesIsASurfaceMore) {
  const std::vector<LevelCounts> counts = torus_levels(60, 4);
  const auto need = [&](const RefinedAttributes& attributes) {
    return static_cast<double>(tessellation_bytes(counts, LastLevel::Full, attributes));
  };
  // Positions, normals and the corners of quads of the surface that the copy is made from.
  const double surface = 36.0 * static_cast<double>(counts.back().vertices) +
                         16.0 * static_cast<double>(counts.back().faces);
  const double more = need({.holes = true}) - need({});
  EXPECT_GE(more, surface);
  EXPECT_LE(more, 2 * surface);
  EXPECT_GT(need({.colors = true, .holes = true}) - need({.colors = true}), more);
}

TEST(MemoryNeed, AttributesCountAgainstTheLimit) {
  PolygonMesh mesh = test::torus(50, 50, 1.0, 0.4);
  const std::uint64_t limit = tessellation_bytes(torus_levels(50, 2), LastLevel::Full);
  const auto refine = [&] {
    (void)evaluate(mesh, *make_cpu_backend(),
                   {.level = 2, .scheme = Scheme::CatmullClark, .memory_limit_bytes = limit});
  };
  EXPECT_NO_THROW(refine());
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x, p.y);
  mesh.face_uvs = mesh.face_vertices;
  EXPECT_THROW(refine(), Error);
}

// What a writer of files holds does not grow with the level.
TEST(MemoryNeed, OfBlocksIsBoundedAndOfAWholeSurfaceIsNot) {
  const PolygonMesh mesh = test::torus(400, 400, 1.0, 0.4);
  const DooSabinSurface surface(mesh, {});
  constexpr std::uint64_t kLimit = std::uint64_t{2} << 30;
  EXPECT_NO_THROW((void)surface.level(5, kLimit));
  EXPECT_NO_THROW(surface.require_whole(3, kLimit, nullptr));
  EXPECT_THROW(surface.require_whole(5, kLimit, nullptr), Error);
  EXPECT_THROW((void)surface.level(5, 1u << 20), Error);
}

TEST(MemoryNeed, TheMachineHasSome) { EXPECT_GT(available_memory_bytes(), 1ull << 20); }

}  // namespace
}  // namespace planish
