#include "planish/patches/patch_surface.h"

#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>

#include <cstring>
#include <numeric>

#include "patches/patch_oracle.h"
#include "planish/core/parallel.h"
#include "planish/patches/doo_sabin_step.h"

namespace planish::test {
namespace {

struct Rows {
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
  DegenerateRows degenerate;
};

Rows all_rows(const PatchSurface& surface, std::span<const glm::dvec3> state,
              const Placement& placement, std::int64_t block) {
  Rows rows;
  const std::int64_t count = surface.numbering().row_count();
  rows.positions.resize(static_cast<std::size_t>(count), glm::dvec3(-99));
  rows.normals.resize(static_cast<std::size_t>(count), glm::vec3(-99));
  for (std::int64_t first = 0; first < count; first += block) {
    const std::int64_t size = std::min(block, count - first);
    PatchTarget target;
    target.positions = std::span(rows.positions).subspan(first, size);
    target.normals = std::span(rows.normals).subspan(first, size);
    rows.degenerate.add(surface.rows(state, placement, {first, size}, target));
  }
  return rows;
}

// All rows, by their names.
Rows rows_named(const PatchSurface& surface, std::span<const glm::dvec3> state,
                const Placement& placement) {
  Rows rows;
  std::vector<std::int32_t> names(static_cast<std::size_t>(surface.numbering().row_count()));
  std::iota(names.begin(), names.end(), 0);
  rows.positions.resize(names.size(), glm::dvec3(-99));
  rows.normals.resize(names.size(), glm::vec3(-99));
  PatchTarget target;
  target.positions = rows.positions;
  target.normals = rows.normals;
  rows.degenerate = surface.rows_at(state, placement, names, target);
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
      const PatchCase c(mesh, weights, {}, 1);
      const std::vector<glm::dvec3> wanted = table_state(c);
      const RawVector<glm::dvec3> state = first_step(c.patches, weights, c.points);
      ASSERT_EQ(state.size(), wanted.size());
      for (std::size_t i = 0; i < state.size(); ++i) {
        ASSERT_LT(glm::length(state[i] - wanted[i]), 1e-15) << i;
      }
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
      const LimitRows limits(*c.subdivision, level);
      const auto table = table_samples(c, limits);
      const PatchSurface surface(c.patches, {.level = level});
      const auto limit_of = limits.in_order_of(surface.numbering());
      ASSERT_EQ(surface.numbering().row_count(), limits.count());
      const Rows rows = all_rows(surface, table_state(c), {}, 1 << 20);
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
      const PatchCase c(mesh, Weights::DooSabin, {}, 0);
      const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
      const Placement placement{{3, 4, 5}, 17};
      const PatchSurface baseline(c.patches,
                                  {.level = level, .instructions = PatchInstructions::Baseline});
      const Rows wanted = all_rows(baseline, state, placement, 1 << 30);
      for (const auto instructions : {PatchInstructions::Avx2}) {
        if (!can_run(instructions)) continue;
        const PatchSurface wide(c.patches, {.level = level, .instructions = instructions});
        EXPECT_TRUE(same_bits(wanted, all_rows(wide, state, placement, 1 << 30)));
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
    const PatchCase c(mesh, Weights::DooSabin, {}, 0);
    const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
    const Placement placement{{3, 4, 5}, 17};
    const PatchSurface named(c.patches, {.level = 2});
    const Rows wanted = rows_named(named, state, placement);
    const PatchSamples& samples = named.numbering().samples();
    std::vector<std::int32_t> corners(static_cast<std::size_t>(c.topology.corner_count() - 3));
    std::iota(corners.begin(), corners.end(), 3);  // not from a quad's first corner
    for (const auto instructions : {PatchInstructions::Baseline, PatchInstructions::Avx2}) {
      if (!can_run(instructions)) continue;
      const PatchSurface surface(c.patches, {.level = 2, .instructions = instructions});
      std::vector<glm::dvec3> positions(corners.size() * samples.count());
      std::vector<glm::vec3> normals(positions.size());
      PatchTarget target;
      target.positions = positions;
      target.normals = normals;
      (void)surface.grids(state, placement, corners, target);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::int32_t s = 0; s < samples.owned_count(); ++s) {
          const auto row = static_cast<std::size_t>(surface.numbering().corner_row(corners[i]) + s);
          const std::size_t at = i * samples.count() + s;
          ASSERT_EQ(positions[at], wanted.positions[row]) << corners[i] << " " << s;
          ASSERT_EQ(normals[at], wanted.normals[row]) << corners[i] << " " << s;
        }
      }
    }
  }
}

// Quads of regular patches, evaluated at once or corner by corner, that span no plane.
TEST(PatchSurface, RowsWithoutDirectionAreCountedOfWholeFacesToo) {
  const PolygonMesh mesh = torus(16, 12, 1, .4);
  for (int level = 0; level <= 3; ++level) {
    PatchCase c(mesh, Weights::DooSabin, {}, 0);
    for (glm::dvec3& p : c.points) p = glm::dvec3(p.x, 0, 0);  // on a line
    const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
    for (const auto instructions : {PatchInstructions::Baseline, PatchInstructions::Avx2}) {
      if (!can_run(instructions)) continue;
      const PatchSurface surface(c.patches, {.level = level, .instructions = instructions});
      for (const Rows& rows :
           {all_rows(surface, state, {}, 1 << 30), rows_named(surface, state, {})}) {
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
    const PatchCase c(mesh, Weights::DooSabin, {}, 0);
    const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
    const PatchSurface surface(c.patches, {.level = 3});
    const PatchNumbering& numbering = surface.numbering();
    const Rows rows = all_rows(surface, state, placement_of(mesh), 1 << 30);
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
  const PatchCase c(torus(12, 8, 1, .4), Weights::DooSabin, {}, 0);
  const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
  const Placement placement{{3, 4, 5}, 17};
  const PatchSurface surface(c.patches, {.level = 2});
  const Rows rows = all_rows(surface, state, placement, 1 << 30);
  std::vector<glm::vec3> stored(rows.positions.size());
  PatchTarget target;
  target.stored = stored;
  target.origin = {2.5, 3.25, 4.125};
  const auto count = static_cast<std::int64_t>(stored.size());
  (void)surface.rows(state, placement, {0, count}, target);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    ASSERT_EQ(stored[i], glm::vec3(rows.positions[i] - target.origin)) << i;
  }
}

// Two faces around a vertex span no plane: its normal is that of the facets around it. The smallest
// such closed mesh is a pillow of two triangles with one edge split.
TEST(PatchSurface, NormalsAtValenceTwoAreThoseOfTheFacets) {
  const PolygonMesh mesh = cube_with_split_edges();
  for (int level = 0; level <= 4; ++level) {
    const PatchCase c(mesh, Weights::DooSabin, {}, 0);
    const RawVector<glm::dvec3> state = first_step(c.patches, c.weights, c.points);
    const PatchSurface surface(c.patches, {.level = level});
    const Rows rows = all_rows(surface, state, {}, 1 << 30);
    EXPECT_EQ(rows.degenerate.count, 12) << level;
    EXPECT_EQ(rows.degenerate.first, 8) << level;
    // The middles of the cube's edges: between the two faces.
    for (std::int32_t v = 8; v < 20; ++v) {
      const glm::dvec3 outward = glm::normalize(mesh.positions[v]);
      EXPECT_LT(glm::length(glm::dvec3(rows.normals[v]) - outward), 1e-6) << v;
    }
  }
}

}  // namespace
}  // namespace planish::test
