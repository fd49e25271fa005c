// Large rings by their sums: against the same patches by all their points, which have been held to
// the tables.
#include "planish/patches/patch_mesh.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "patches/patch_oracle.h"
#include "planish/core/work.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/patches/patch_form.h"
#include "planish/patches/patch_plan.h"

namespace planish::test {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSamePosition = 1e-14;  // of the diagonal, which is about 1
constexpr double kSine = 1e-9;           // of the angle between normals

// n faces of m corners around vertex 0, over an angle; closed where that is 2 pi.
PolygonMesh fan(std::int32_t n, double opening, std::int32_t m, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> near(-0.02, 0.02);
  PolygonMesh mesh;
  mesh.positions.emplace_back(0, 0, 0.1);
  const bool is_closed = opening == 2 * kPi;
  const std::int32_t steps = n * (m - 2), count = is_closed ? steps : steps + 1;
  for (std::int32_t i = 0; i < count; ++i) {
    const double angle = opening * i / steps, radius = 0.5 + near(random);
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), near(random));
  }
  for (std::int32_t f = 0; f < n; ++f) {
    std::vector<std::int32_t> face = {0};
    for (std::int32_t i = 0; i < m - 1; ++i) face.push_back(1 + (f * (m - 2) + i) % count);
    mesh.add_face(face);
  }
  return mesh;
}

// Creases from the centre along some spokes.
PolygonMesh creased(PolygonMesh mesh, std::int32_t m, const std::vector<std::int32_t>& spokes) {
  for (const std::int32_t i : spokes)
    mesh.creases.push_back({0, 1 + i * (m - 2), kInfiniteSharpness});
  return mesh;
}

PolygonMesh tagged(PolygonMesh mesh) {
  mesh.corners.push_back({0, kInfiniteSharpness});
  return mesh;
}

struct RingCase {
  std::string name;
  PolygonMesh mesh;
  PatchKind kind;  // of the large ring
};

std::vector<RingCase> ring_cases() {
  const double whole = 2 * kPi;
  return {
      {"smooth", fan(40, whole, 3, 1), PatchKind::Smooth},
      {"smooth, of quads", fan(33, whole, 4, 2), PatchKind::Smooth},
      {"faces of 40 corners", fan(5, whole, 40, 3), PatchKind::Smooth},
      {"both", fan(37, whole, 35, 4), PatchKind::Smooth},
      {"cone", tagged(fan(40, whole, 3, 5)), PatchKind::Cone},
      {"dart", creased(fan(40, whole, 3, 6), 3, {7}), PatchKind::Dart},
      {"crease", creased(fan(80, whole, 3, 7), 3, {3, 38}), PatchKind::Crease},
      {"crease beside a small sector", creased(fan(40, whole, 4, 8), 4, {3, 38}),
       PatchKind::Crease},
      {"crease, large faces", creased(fan(34, whole, 33, 9), 33, {0, 1}), PatchKind::Crease},
      {"boundary", fan(50, 0.9 * kPi, 3, 10), PatchKind::Crease},
      {"convex", tagged(fan(40, 0.45 * kPi, 3, 11)), PatchKind::Convex},
      {"half plane", tagged(fan(40, kPi, 4, 12)), PatchKind::HalfPlane},
      {"reflex", tagged(fan(41, 1.6 * kPi, 3, 13)), PatchKind::Reflex},
      {"three sectors", creased(fan(120, whole, 3, 14), 3, {0, 34, 70}), PatchKind::Convex},
  };
}

struct BothWays : PatchCase {
  explicit BothWays(const PolygonMesh& given)
      : PatchCase(given, Weights::DooSabin, {}, 1),
        by_sums(topology, features, RingColumns::Sums),
        state(first_step(by_sums, weights, points)) {}

  [[nodiscard]] std::vector<glm::dvec3> points_of(const PatchMesh& records,
                                                  const PatchPlace& place) const {
    std::vector<std::int32_t> indices(static_cast<std::size_t>(place.patch.column_count()));
    records.gather(place, indices.data(), 1);
    std::vector<glm::dvec3> result;
    for (const std::int32_t i : indices) result.push_back(state[i] - state[indices[0]]);
    return result;
  }

  PatchMesh by_sums;
  RawVector<glm::dvec3> state;
};

std::array<glm::dvec3, 3> sample(const PatchTemplate& of_class, std::int32_t index,
                                 const std::vector<glm::dvec3>& points) {
  std::array<glm::dvec3, 3> result{};
  const auto rows = of_class.rows(index);
  const std::size_t k = points.size() - 1;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t j = 0; j < k; ++j) result[r] += rows[r * k + j] * points[j + 1];
  return result;
}

void expect_same_normal(const glm::dvec3& got, const glm::dvec3& wanted, const std::string& where) {
  const double lengths = glm::length(got) * glm::length(wanted);
  ASSERT_GT(glm::dot(got, wanted), 0.0) << where;
  ASSERT_LT(glm::length(glm::cross(got, wanted)), kSine * lengths) << where;
}

void expect_same(BothWays& c, const PatchPlace& whole, const PatchPlace& summed, int level,
                 const std::string& where) {
  PatchTemplates templates(Weights::DooSabin);
  const PatchTemplate wanted = templates.make(whole.patch, level);
  const PatchTemplate got = templates.make(summed.patch, level);
  const auto wanted_points = c.points_of(c.patches, whole);
  const auto got_points = c.points_of(c.by_sums, summed);
  ASSERT_EQ(wanted.sample_count, got.sample_count);
  for (std::int32_t i = 0; i < wanted.sample_count; ++i) {
    const auto a = sample(wanted, i, wanted_points), b = sample(got, i, got_points);
    ASSERT_LT(glm::length(a[0] - b[0]), kSamePosition) << where << ", sample " << i;
    expect_same_normal(glm::cross(b[1], b[2]), glm::cross(a[1], a[2]), where);
  }
}

// Large faces of a cage by their sums, against the rule as it is written.
TEST(FirstStep, OfLargeFacesIsTheirRules) {
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    for (const std::int32_t size : {31, 32, 33, 500}) {
      PolygonMesh mesh = fan(5, 2 * kPi, size, 15);
      for (glm::dvec3& p : mesh.positions) p += glm::dvec3(30);
      const PatchCase c(mesh, weights, {}, 0);
      const auto state = first_step(c.patches, weights, mesh.positions);
      const std::vector<double> rule = face_weights(weights, size);
      for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
        const auto face = mesh.face(f);
        for (std::int32_t i = 0; i < size; ++i) {
          glm::dvec3 expected(0.0);
          for (std::int32_t j = 0; j < size; ++j)
            expected += rule[j] * mesh.positions[face[(i + j) % size]];
          ASSERT_LT(glm::length(state[f * size + i] - expected), 1e-13) << size << " " << i;
        }
      }
    }
  }
}

TEST(FirstStep, TakesTimeOfTheCorners) {
  const PatchCase c(prism(3000), Weights::DooSabin, {}, 0);
  const std::atomic<std::int64_t>& pairs = work_counts[static_cast<std::size_t>(Work::Pairs)];
  const std::int64_t before = pairs;
  (void)first_step(c.patches, Weights::DooSabin, c.mesh.positions);
  EXPECT_LE(pairs - before, 4 * c.topology.corner_count());
  EXPECT_GE(pairs - before, 4 * 12'000);
}

TEST(RingSums, GiveThePatchesOfAllPoints) {
  for (const RingCase& given : ring_cases()) {
    BothWays c(given.mesh);
    std::set<PatchClass> seen;
    bool has_kind = false;
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const PatchPlace summed = c.by_sums.corner_patch(corner);
      const PatchClass& patch = summed.patch;
      has_kind |= patch.kind == given.kind && (patch.has_ring_sums || patch.has_face_sums);
      ASSERT_LE(patch.column_count(), patch.has_ring_sums || patch.has_face_sums ? 36 : 100);
      if (patch.has_ring_sums && (patch.has_face_sums || patch.face_size <= 4)) {
        ASSERT_LE(patch.column_count(), 15);
      }
      if (!patch.has_ring_sums && !patch.has_face_sums) continue;
      // Corners between are one class, whose points stand at another angle each.
      const bool is_new = seen.insert(patch).second;
      if (!is_new && corner % 7 != 0) continue;
      for (const int level : {1, 2, 4}) {
        expect_same(c, c.patches.corner_patch(corner), summed, level,
                    given.name + ", corner " + std::to_string(corner));
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
    EXPECT_TRUE(has_kind) << given.name;
    EXPECT_LE(seen.size(), 12u) << given.name;
  }
}

TEST(RingSums, GiveTheLimitPointsOfAllPoints) {
  for (const RingCase& given : ring_cases()) {
    BothWays c(given.mesh);
    std::vector<std::int32_t> starts;
    c.patches.sector_starts(0, starts);
    for (const std::int32_t start : starts) {
      expect_same(c, c.patches.vertex_point(start), c.by_sums.vertex_point(start), 2, given.name);
      if (::testing::Test::HasFatalFailure()) return;
    }
    expect_same(c, c.patches.face_point(0), c.by_sums.face_point(0), 2, given.name + ", face");
  }
}

TEST(RingSums, GiveTheFormsOfAllPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(0.0, 1.0);
  for (const RingCase& given : ring_cases()) {
    BothWays c(given.mesh);
    PatchForms forms(Weights::DooSabin);
    PatchScratch scratch;
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); corner += 3) {
      const PatchPlace whole = c.patches.corner_patch(corner);
      const PatchPlace summed = c.by_sums.corner_patch(corner);
      if (whole.patch == summed.patch) continue;
      const auto wanted_points = c.points_of(c.patches, whole);
      const auto got_points = c.points_of(c.by_sums, summed);
      for (int i = 0; i < 5; ++i) {
        const double u = i == 0 ? 0 : i == 1 ? 1 : within(random), v = i < 2 ? u : within(random);
        const PatchPoint wanted =
            patch_point(forms.of(whole.patch), wanted_points, {u, v}, scratch);
        const PatchPoint got = patch_point(forms.of(summed.patch), got_points, {u, v}, scratch);
        const std::string where = given.name + ", corner " + std::to_string(corner) + " at " +
                                  std::to_string(u) + ", " + std::to_string(v);
        ASSERT_LT(glm::length(got.position - wanted.position), kSamePosition) << where;
        const double size = glm::length(wanted.du) + glm::length(wanted.dv);
        ASSERT_LT(glm::length(got.du - wanted.du), 1e-7 * size) << where;
        ASSERT_LT(glm::length(got.dv - wanted.dv), 1e-7 * size) << where;
        ASSERT_EQ(got.has_second, wanted.has_second) << where;
        expect_same_normal(got.normal, wanted.normal, where);
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }
}

TEST(RingSums, AreTheirWeightsTimesTheirPoints) {
  for (const RingCase& given : ring_cases()) {
    BothWays c(given.mesh);
    ASSERT_FALSE(c.by_sums.large_rings().empty()) << given.name;
    std::vector<std::int32_t> points;
    for (const LargeRing& ring : c.by_sums.large_rings()) {
      c.by_sums.ring_points(ring, points);
      for (std::int32_t sum = 0; sum < ring.sum_count(); sum += 5) {
        ASSERT_EQ(&c.by_sums.ring_of_sum(ring.first_sum + sum), &ring);
        const std::vector<double> weights = sum_weights(ring, sum);
        ASSERT_EQ(weights.size(), points.size());
        glm::dvec3 expected(0.0);
        for (std::size_t i = 0; i < points.size(); ++i) expected += weights[i] * c.state[points[i]];
        ASSERT_LT(glm::length(c.state[ring.first_sum + sum] - expected), 1e-14) << given.name;
      }
    }
  }
}

}  // namespace
}  // namespace planish::test
