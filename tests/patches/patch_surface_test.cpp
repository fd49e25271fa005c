#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "patches/patch_oracle.h"
#include "planish/core/parallel.h"
#include "planish/core/work.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/patches/patch_form.h"
#include "planish/patches/patch_mesh.h"
#include "planish/patches/patch_plan.h"
#include "planish/patches/patch_surface.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

struct Rows {
  explicit Rows(std::int64_t count)
      : positions(static_cast<std::size_t>(count), glm::dvec3(-99)),
        normals(positions.size(), glm::vec3(-99)) {}
  [[nodiscard]] PatchTarget target(std::int64_t first = 0) {
    return target(first, std::ssize(positions) - first);
  }
  [[nodiscard]] PatchTarget target(std::int64_t first, std::int64_t count) {
    PatchTarget to;
    to.positions = std::span(positions).subspan(first, count);
    to.normals = std::span(normals).subspan(first, count);
    return to;
  }

  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  DegenerateRows degenerate;
};

Rows all_rows(const PatchSurface& surface, std::span<const glm::dvec3> state,
              const Placement& placement, std::int64_t block = 1 << 30) {
  const std::int64_t count = surface.numbering().row_count();
  Rows rows(count);
  for (std::int64_t first = 0; first < count; first += block) {
    const std::int64_t size = std::min(block, count - first);
    rows.degenerate.add(surface.rows(state, placement, {first, size}, rows.target(first, size)));
  }
  return rows;
}

std::vector<std::int32_t> numbers(std::int64_t count, std::int32_t first = 0) {
  std::vector<std::int32_t> result(static_cast<std::size_t>(count));
  std::iota(result.begin(), result.end(), first);
  return result;
}

std::vector<PatchInstructions> runnable_instructions() {
  std::vector<PatchInstructions> all{PatchInstructions::Baseline, PatchInstructions::Avx2};
  std::erase_if(all, [](PatchInstructions instructions) { return !can_run(instructions); });
  return all;
}

// All rows, by their names.
Rows rows_named(const PatchSurface& surface, std::span<const glm::dvec3> state,
                const Placement& placement) {
  Rows rows(surface.numbering().row_count());
  rows.degenerate =
      surface.rows_at(state, placement, numbers(std::ssize(rows.positions)), rows.target());
  return rows;
}

// NaN would not compare equal to itself.
bool same_bits(const Rows& a, const Rows& b) {
  return a.positions.size() == b.positions.size() &&
         std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * 24) == 0 &&
         std::memcmp(a.normals.data(), b.normals.data(), a.normals.size() * 12) == 0;
}

TEST(FirstStep, AgreesWithTheTable) {
  for (const auto& [name, mesh] : all_meshes()) {
    for (const Weights weights : kBothWeights) {
      SCOPED_TRACE(name);
      const SteppedCase c(mesh, weights, 1);
      const std::vector<glm::dvec3> wanted = table_state(c);
      ASSERT_EQ(c.state.size(), wanted.size());
      for (std::size_t i = 0; i < wanted.size(); ++i)
        ASSERT_LT(glm::length(c.state[i] - wanted[i]), 1e-15) << i;
    }
  }
}

TEST(PatchSurface, RowsAgreeWithTables) {
  std::vector<NamedMesh> meshes = all_meshes();
  for (NamedMesh& scene : scene_meshes()) {
    if (scene.mesh.face_count() < 3000) meshes.push_back(std::move(scene));
  }
  for (const auto& [name, mesh] : meshes) {
    for (int level = 0; level <= 3; ++level) {
      SCOPED_TRACE(name + ", level " + std::to_string(level));
      const PatchCase c(mesh, Weights::DooSabin, {}, level);
      const LimitRows limits(c.subdivision, level);
      const auto table = table_samples(c, limits);
      const PatchSurface surface(c.patches, {.level = level});
      const auto limit_of = limits.in_order_of(surface.numbering());
      ASSERT_EQ(surface.numbering().row_count(), limits.count());
      const Rows rows = all_rows(surface, table_state(c), {});
      for (std::size_t row = 0; row < limit_of.size(); ++row) {
        const std::int32_t i = limit_of[row];
        ASSERT_LT(glm::length(rows.positions.at(row) - table[i].position), 1e-14) << row;
        const glm::dvec3 normal = glm::cross(table[i].du, table[i].dv);
        EXPECT_NEAR(glm::length(rows.normals[row]), 1.0, 1e-6) << row;
        const double length = glm::length(normal);
        if (length < 1e-4 * glm::length(table[i].du) * glm::length(table[i].dv)) continue;
        if (length == 0) continue;
        ASSERT_LT(glm::length(glm::dvec3(rows.normals[row]) - normal / length), 1e-6) << row;
      }
    }
  }
}

TEST(PatchSurface, BitsDoNotDependOnInstructionsNamesOrRanges) {
  for (const PolygonMesh& mesh : {with_random_creases(random_closed_mesh(3), 0.2, 3),
                                  random_open_mesh(2), torus(40, 30, 1, .4), icosphere(3)}) {
    for (int level = 0; level <= 3; ++level) {
      const SteppedCase c(mesh);
      const RawVector<glm::dvec3>& state = c.state;
      const Placement placement{{3, 4, 5}, 17};
      const PatchSurface baseline(c.patches,
                                  {.level = level, .instructions = PatchInstructions::Baseline});
      const Rows wanted = all_rows(baseline, state, placement);
      for (const auto instructions : runnable_instructions()) {
        const PatchSurface wide(c.patches, {.level = level, .instructions = instructions});
        EXPECT_TRUE(same_bits(wanted, all_rows(wide, state, placement)));
      }
      EXPECT_TRUE(same_bits(wanted, rows_named(baseline, state, placement)));
      for (const std::int64_t block : {61, 1000}) {
        const Rows rows = all_rows(baseline, state, placement, block);
        EXPECT_TRUE(same_bits(wanted, rows));
        EXPECT_EQ(rows.degenerate.count, wanted.degenerate.count);
        EXPECT_EQ(rows.degenerate.first, wanted.degenerate.first);
        if (level > 1) break;
      }
    }
  }
}

// Quads of regular patches are evaluated at once: all samples of a corner are the rows that it
// names.
TEST(PatchSurface, GridsHaveTheBitsOfRows) {
  for (const PolygonMesh& mesh : {torus(40, 30, 1, .4), random_open_mesh(2)}) {
    const SteppedCase c(mesh);
    const RawVector<glm::dvec3>& state = c.state;
    const Placement placement{{3, 4, 5}, 17};
    const PatchSurface named(c.patches, {.level = 2});
    const Rows wanted = rows_named(named, state, placement);
    const PatchSamples& samples = named.numbering().samples();
    // Not from a quad's first corner.
    const std::vector<std::int32_t> corners = numbers(c.topology.corner_count() - 3, 3);
    for (const auto instructions : runnable_instructions()) {
      const PatchSurface surface(c.patches, {.level = 2, .instructions = instructions});
      Rows grids(std::ssize(corners) * samples.count());
      (void)surface.grids(state, placement, corners, grids.target());
      for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::int32_t s = 0; s < samples.owned_count(); ++s) {
          const auto row = static_cast<std::size_t>(surface.numbering().corner_row(corners[i]) + s);
          const std::size_t at = i * samples.count() + s;
          ASSERT_EQ(grids.positions[at], wanted.positions[row]) << corners[i] << " " << s;
          ASSERT_EQ(grids.normals[at], wanted.normals[row]) << corners[i] << " " << s;
        }
      }
    }
  }
}

// Quads of regular patches, evaluated at once or corner by corner, that span no plane.
TEST(PatchSurface, RowsWithoutDirectionAreCountedOfWholeFacesToo) {
  const PolygonMesh mesh = torus(16, 12, 1, .4);
  for (int level = 0; level <= 3; ++level) {
    PatchCase c(mesh);
    for (glm::dvec3& p : c.points) p = glm::dvec3(p.x, 0, 0);  // on a line
    const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
    for (const auto instructions : runnable_instructions()) {
      const PatchSurface surface(c.patches, {.level = level, .instructions = instructions});
      for (const Rows& rows : {all_rows(surface, state, {}), rows_named(surface, state, {})}) {
        EXPECT_EQ(rows.degenerate.count, static_cast<std::int64_t>(rows.normals.size())) << level;
        EXPECT_EQ(rows.degenerate.first, 0) << level;
        for (const glm::vec3& normal : rows.normals) ASSERT_NEAR(glm::length(normal), 1, 1e-6);
      }
    }
  }
}

// Points on a crease belong to two rows: their positions are the same to the last bit, so that
// whoever welds by position closes the surface.
TEST(PatchSurface, BothSidesOfACreaseHaveTheSamePositions) {
  for (std::uint32_t seed = 1; seed <= 6; ++seed) {
    const PolygonMesh mesh = with_random_creases(random_closed_mesh(seed), 0.3, seed);
    const SteppedCase c(mesh);
    const PatchSurface surface(c.patches, {.level = 3});
    const PatchNumbering& numbering = surface.numbering();
    const Rows rows = all_rows(surface, c.state, placement_of(mesh));
    const std::int32_t n = numbering.samples().side();
    std::int64_t doubled = 0;
    for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
      const std::int32_t other = c.topology.cw(corner);
      ASSERT_GE(other, 0);
      for (std::int32_t a = 0; a <= n; ++a) {
        const std::int32_t own = numbering.row(corner, a, 0), across = numbering.row(other, 0, a);
        if (own != across) ++doubled;
        ASSERT_EQ(rows.positions[own], rows.positions[across]) << corner << " " << a;
      }
    }
    EXPECT_GT(doubled, 0);
  }
}

TEST(PatchSurface, StoredPositionsAreRoundedOnce) {
  const SteppedCase c(torus(12, 8, 1, .4));
  const Placement placement{{3, 4, 5}, 17};
  const PatchSurface surface(c.patches, {.level = 2});
  const Rows rows = all_rows(surface, c.state, placement);
  std::vector<glm::vec3> stored(rows.positions.size());
  PatchTarget target;
  target.stored = stored;
  target.origin = {2.5, 3.25, 4.125};
  const auto count = static_cast<std::int64_t>(stored.size());
  (void)surface.rows(c.state, placement, {0, count}, target);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    ASSERT_EQ(stored[i], glm::vec3(rows.positions[i] - target.origin)) << i;
  }
}

// Two faces around a vertex span no plane: its normal is that of the facets around it. The smallest
// such closed mesh is a pillow of two triangles with one edge split.
TEST(PatchSurface, NormalsAtValenceTwoAreThoseOfTheFacets) {
  const PolygonMesh mesh = cube_with_split_edges();
  for (int level = 0; level <= 4; ++level) {
    const SteppedCase c(mesh);
    const PatchSurface surface(c.patches, {.level = level});
    const Rows rows = all_rows(surface, c.state, {});
    EXPECT_EQ(rows.degenerate.count, 12) << level;
    EXPECT_EQ(rows.degenerate.first, 8) << level;
    // The middles of the cube's edges: between the two faces.
    for (std::int32_t v = 8; v < 20; ++v) {
      const glm::dvec3 outward = glm::normalize(mesh.positions[v]);
      EXPECT_LT(glm::length(glm::dvec3(rows.normals[v]) - outward), 1e-6) << v;
    }
  }
}

// Large rings by their sums: against the same patches by all their points, which have been held to
// the tables.

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

struct BothWays : SteppedCase {
  explicit BothWays(const PolygonMesh& given)
      : SteppedCase(given, Weights::DooSabin, 1), by_sums(topology, features, RingColumns::Sums) {
    state = first_step(by_sums, weights, points);
  }

  PatchMesh by_sums;
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
      const PatchCase c(mesh, weights);
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
  const PatchCase c(prism(3000));
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

const Placement kPlacement{glm::dvec3(0.5, -1, 2), 3.0};

// All regular; creases and vertices of valence 3 and 5 among regular quads; boundaries.
std::vector<NamedMesh> meshes_of_quads() {
  const auto wave = [](double x, double y) {
    return glm::dvec3(x, y, std::sin(x) * std::cos(0.7 * y));
  };
  PolygonMesh with_creases = torus(9, 7, 1.0, 0.4);
  with_creases.creases = {{0, 1}, {1, 2}, {30, 37}};
  return {{"torus", torus(9, 7, 1.0, 0.4)},
          {"creased", with_creases},
          {"cube", cube()},
          {"grid", grid(7, 6, wave)},
          {"plate", plate_with_hole(9)}};
}

// Each row of a vertex, a face or an edge once, with the bits that rows() gives it.
void expect_points(PointRows& points, const PatchSurface& surface, const Rows& wanted) {
  const auto end =
      static_cast<std::size_t>(surface.numbering().end_row(PatchNumbering::Part::Edges));
  ASSERT_EQ(points.size(), end);
  std::vector<int> times(end, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<std::size_t>(points.rows()[i]);
    ASSERT_LT(row, end);
    ++times[row];
    EXPECT_EQ(points.positions()[i], wanted.positions[row]) << row;
    EXPECT_EQ(points.normals()[i], wanted.normals[row]) << row;
  }
  EXPECT_EQ(times, std::vector<int>(end, 1));
}

TEST(PointRows, AreMadeAlongWithTheBitsOfRows) {
  for (const auto& [name, mesh] : meshes_of_quads()) {
    SCOPED_TRACE(name);
    const SteppedCase c(mesh);
    for (const PatchInstructions instructions : runnable_instructions()) {
      const PatchSurface surface(c.patches, {.level = 2, .instructions = instructions});
      if (name == "torus") {
        ASSERT_TRUE(surface.makes_points());
      }
      if (!surface.makes_points()) continue;
      const Rows wanted = all_rows(surface, c.state, kPlacement);
      Rows made(surface.numbering().row_count());
      const std::vector<std::int32_t> corners = numbers(c.topology.corner_count());
      Rows grids(std::int64_t{surface.numbering().samples().count()} * std::ssize(corners));
      PointRows points;
      (void)surface.grids(c.state, kPlacement, corners, grids.target(), &points);
      expect_points(points, surface, wanted);
      const auto first = static_cast<std::size_t>(surface.numbering().corner_row(0));
      (void)surface.owned(c.state, kPlacement, 0, c.topology.corner_count(),
                          made.target(static_cast<std::int64_t>(first)), points);
      expect_points(points, surface, wanted);
      const auto end =
          static_cast<std::size_t>(surface.numbering().end_row(PatchNumbering::Part::Corners));
      for (std::size_t row = first; row < end; ++row) {
        ASSERT_EQ(made.positions[row], wanted.positions[row]);
        ASSERT_EQ(made.normals[row], wanted.normals[row]);
      }
    }
  }
}

// A quad whose corners come in two ranges stands for the same rows.
TEST(PointRows, DoNotDependOnRanges) {
  const SteppedCase c(torus(9, 7, 1.0, 0.4));
  const PatchSurface surface(c.patches, {.level = 2, .instructions = PatchInstructions::Baseline});
  const Rows wanted = all_rows(surface, c.state, kPlacement);
  PointRows all, part;
  all.reset(wanted.positions.size());
  for (std::int32_t first = 0; first < c.topology.corner_count(); first += 6) {
    const std::int32_t size = std::min(6, c.topology.corner_count() - first);
    Rows grids(std::int64_t{9} * size);
    (void)surface.grids(c.state, kPlacement, numbers(size, first), grids.target(), &part);
    for (std::size_t i = 0; i < part.size(); ++i)
      all.add(part.rows()[i], &part.positions()[i].x, &part.normals()[i].x);
  }
  expect_points(all, surface, wanted);
}

}  // namespace
}  // namespace planish::test
