#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "patches/patch_oracle.h"
#include "planish/patches/face_kernel.h"
#include "planish/patches/patch_plan.h"

namespace planish::test {
namespace {

// Rows that the visible corners name, with what names each: a position of the surface and side.
std::set<std::int32_t> named_rows(const PatchMesh& mesh, const PatchNumbering& numbering) {
  std::set<std::int32_t> rows;
  const std::int32_t n = numbering.samples().side();
  std::vector<std::int32_t> grid(static_cast<std::size_t>((n + 1) * (n + 1)));
  for (std::int32_t c = 0; c < mesh.topology().corner_count(); ++c) {
    if (numbering.is_hidden(mesh.topology().face_of(c))) continue;
    numbering.grid(c, grid.data());
    for (std::int32_t b = 0; b <= n; ++b) {
      for (std::int32_t a = 0; a <= n; ++a) {
        EXPECT_EQ(grid[b * (n + 1) + a], numbering.row(c, a, b));
        rows.insert(numbering.row(c, a, b));
      }
    }
  }
  return rows;
}

std::vector<std::uint8_t> hidden_faces(const PolygonMesh& mesh, std::int32_t every) {
  std::vector<std::uint8_t> hidden(static_cast<std::size_t>(mesh.face_count()), 0);
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) hidden[f] = f % every < 2;
  return hidden;
}

void expect_each_row_named(const PolygonMesh& mesh, std::int32_t hide_every) {
  const PatchCase c(mesh);
  const auto hidden = hide_every > 0 ? hidden_faces(mesh, hide_every) : std::vector<std::uint8_t>{};
  for (int level = 1; level <= 3; ++level) {
    const PatchNumbering numbering(c.patches, level, hidden);
    const std::set<std::int32_t> rows = named_rows(c.patches, numbering);
    ASSERT_EQ(static_cast<std::int64_t>(rows.size()), numbering.row_count()) << level;
    EXPECT_EQ(*rows.begin(), 0);
    EXPECT_EQ(*rows.rbegin(), numbering.row_count() - 1);
  }
}

TEST(PatchNumbering, EachRowIsNamedButThoseOfHiddenFaces) {
  for (const auto& [name, mesh] : all_meshes()) {
    SCOPED_TRACE(name);
    expect_each_row_named(mesh, 0);
    if (mesh.face_count() < 4) continue;
    expect_each_row_named(mesh, 3);
    expect_each_row_named(mesh, 5);
  }
}

TEST(PatchNumbering, VerticesComeFirstThenFacesThenEdgesThenCorners) {
  const PolygonMesh mesh = cube();
  const PatchCase c(mesh);
  const PatchNumbering numbering(c.patches, 2);
  EXPECT_EQ(numbering.row(0, 0, 0), mesh.face_vertices[0]);
  EXPECT_EQ(numbering.row(0, 2, 2), 8);
  EXPECT_EQ(numbering.row(0, 2, 0), 8 + 6);
  EXPECT_EQ(numbering.row(5, 1, 0), 8 + 6 + 12 + 5 * 3);
  EXPECT_EQ(numbering.row(5, 1, 1), 8 + 6 + 12 + 5 * 3 + 1);
  EXPECT_EQ(numbering.row(5, 2, 1), 8 + 6 + 12 + 5 * 3 + 2);
  EXPECT_EQ(numbering.row_count(), 98);
}

// A crease has the rows of both its sides, seams of texture coordinates those of theirs.
TEST(PatchNumbering, SeamsOfTextureCoordinatesAreCuts) {
  const PolygonMesh mesh = flat_grid(2, 1);
  const MeshTopology topology(mesh);
  // Vertices 1 and 4 lie between the two quads: joined, then cut.
  const std::vector<std::int32_t> joined = mesh.face_vertices;
  std::vector<std::int32_t> cut = joined;
  for (int i = 4; i < 8; ++i) cut[i] += 6;
  for (int level = 0; level <= 3; ++level) {
    const PatchNumbering one(topology, joined, 6, level);
    const PatchNumbering two(topology, cut, 12, level);
    const std::int64_t n = level == 0 ? 1 : std::int64_t{1} << level;  // cells along an edge
    EXPECT_EQ(one.row_count(), level == 0 ? 6 : (2 * n + 1) * (n + 1)) << level;
    EXPECT_EQ(two.row_count(), level == 0 ? 12 : 2 * (n + 1) * (n + 1) + 4) << level;
  }
}

// Every sample of every corner, as each corner sees it, against the chain of stencil tables.

// Of the bounding box's diagonal, which is 1; and degrees.
constexpr double kPosition = 1e-14;
constexpr double kNormal = 1e-9;

struct Worst {
  double position = 0, normal = 0;
  std::int64_t normals = 0;
};

TableSample sample_of(const PatchCase& c, const PatchPlace& place, const PatchTemplate& weights,
                      std::int32_t sample, const std::vector<glm::dvec3>& state) {
  std::vector<std::int32_t> indices(static_cast<std::size_t>(place.patch.column_count()));
  c.patches.gather(place, indices.data(), 1);
  const glm::dvec3 own = state[indices[0]];
  const auto rows = weights.rows(sample);
  TableSample result;
  const std::size_t k = indices.size() - 1;
  for (std::size_t i = 0; i < k; ++i) {
    const glm::dvec3 p = state[indices[i + 1]] - own;
    result.position += rows[i] * p;
    result.du += rows[k + i] * p;
    result.dv += rows[2 * k + i] * p;
  }
  result.position += own;
  return result;
}

void compare(const TableSample& patch, const TableSample& table, Worst& worst) {
  worst.position = std::max(worst.position, glm::length(patch.position - table.position));
  const glm::dvec3 wanted = glm::cross(table.du, table.dv), got = glm::cross(patch.du, patch.dv);
  const double length = glm::length(wanted);
  const auto is_degenerate = [](const TableSample& s, const glm::dvec3& n) {
    return !(glm::length(n) > 1e-6 * glm::length(s.du) * glm::length(s.dv));
  };
  // Barely degenerate ones may be called otherwise by the other.
  if (length < 1e-5 * glm::length(table.du) * glm::length(table.dv) || length == 0) return;
  ASSERT_FALSE(is_degenerate(patch, got));
  const double sine = glm::length(glm::cross(got, wanted)) / (glm::length(got) * length);
  ASSERT_GT(glm::dot(got, wanted), 0.0);
  // Where tangents are nearly parallel the tables' own rounding turns the normal.
  const double condition = length / (glm::length(table.du) * glm::length(table.dv));
  worst.normal =
      std::max(worst.normal, std::asin(std::min(sine, 1.0)) * condition * 180 / std::numbers::pi);
  ++worst.normals;
}

Worst compare_corners(const PolygonMesh& mesh, Weights weights, const SharpFeatureOptions& sharp,
                      int level) {
  const PatchCase c(mesh, weights, sharp, level);
  const LimitRows limits(c.subdivision, level);
  const std::vector<TableSample> table = table_samples(c, limits);
  const PatchNumbering numbering(c.patches, level);
  const std::vector<std::int32_t> limit_of_row = limits.in_order_of(numbering);
  EXPECT_EQ(numbering.row_count(), limits.count());
  EXPECT_EQ(std::set(limit_of_row.begin(), limit_of_row.end()).size(), limit_of_row.size());

  const PatchClasses classes(numbering, c.patches, weights);
  const std::vector<glm::dvec3> state = table_state(c);
  const PatchSamples& samples = numbering.samples();
  Worst worst;
  for (std::int32_t corner = 0; corner < c.topology.corner_count(); ++corner) {
    const PatchPlace place = c.patches.corner_patch(corner);
    const PatchTemplate& of_class = classes.weights(classes.index_of(place.patch));
    for (std::int32_t b = 0; b <= samples.side(); ++b) {
      for (std::int32_t a = 0; a <= samples.side(); ++a) {
        const auto& wanted = table[limit_of_row.at(numbering.row(corner, a, b))];
        compare(sample_of(c, place, of_class, samples.index(a, b), state), wanted, worst);
        if (::testing::Test::HasFatalFailure()) return worst;
      }
    }
  }
  return worst;
}

int deepest_level(const PolygonMesh& mesh, std::int64_t max_faces) {
  int level = 1;
  auto faces = static_cast<std::int64_t>(mesh.face_vertices.size());
  while (level < 6 && 4 * faces <= max_faces) faces *= 4, ++level;
  return level;
}

void expect_equal(const std::vector<NamedMesh>& meshes, const SharpFeatureOptions& sharp,
                  std::int64_t max_faces) {
  Worst all;
  for (const auto& [name, mesh] : meshes) {
    for (const Weights weights : kBothWeights) {
      for (int level = 1; level <= deepest_level(mesh, max_faces); ++level) {
        SCOPED_TRACE(name + ", level " + std::to_string(level));
        const Worst worst = compare_corners(mesh, weights, sharp, level);
        EXPECT_LT(worst.position, kPosition);
        EXPECT_LT(worst.normal, kNormal);
        all.position = std::max(all.position, worst.position);
        all.normal = std::max(all.normal, worst.normal);
        all.normals += worst.normals;
        if (::testing::Test::HasFatalFailure()) return;
      }
    }
  }
  EXPECT_GT(all.normals, 0);
  ::testing::Test::RecordProperty("worst_position", std::to_string(all.position * 1e16) + "e-16");
  ::testing::Test::RecordProperty("worst_normal", std::to_string(all.normal * 1e12) + "e-12");
}

TEST(PatchSamples, PlacesAreWhereIndicesLead) {
  for (int level = 1; level <= 5; ++level) {
    const PatchSamples samples(level);
    const std::int32_t count = samples.first_trailing() + samples.trailing_count();
    for (std::int32_t i = 0; i < count; ++i) {
      const auto [a, b] = samples.place(i);
      ASSERT_GE(std::min(a, b), 0) << level << " " << i;
      ASSERT_LE(std::max(a, b), samples.side()) << level << " " << i;
      ASSERT_EQ(samples.index(a, b), i) << level;
    }
  }
}

TEST(PatchTemplates, AgreeWithTablesOnSmallMeshes) { expect_equal(all_meshes(), {}, 40000); }

TEST(PatchTemplates, AgreeWithTablesAtLevelSix) {
  expect_equal(
      {{"cube", cube()}, {"prism", prism(9)}, {"fan", open_fan(5)}, {"torus", torus(5, 4, 1, .4)}},
      {}, 4 << 16);
}

TEST(PatchTemplates, AgreeWithTablesWithBoundaryCorners) {
  expect_equal(open_meshes(), {.boundary = BoundaryRule::EdgeAndCorner}, 10000);
}

TEST(PatchTemplates, AgreeWithTablesOnScenes) {
  const std::vector<NamedMesh> meshes = scene_meshes();
  ASSERT_GE(meshes.size(), 10u);
  expect_equal(meshes, {}, 100000);
}

TEST(PatchTemplates, AgreeWithTablesOnRandomMeshesWithRandomCreases) {
  std::vector<NamedMesh> meshes;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const std::string name = "seed " + std::to_string(seed);
    PolygonMesh closed = with_random_creases(random_closed_mesh(seed), 0.05 * seed, seed);
    for (std::int32_t v = 0; v < closed.vertex_count(); v += 7) closed.corners.push_back({v, 10});
    meshes.push_back({"closed, " + name, std::move(closed)});
    meshes.push_back({"open, " + name, with_random_creases(random_open_mesh(seed), 0.15, seed)});
  }
  expect_equal(meshes, {}, 20000);
}

TEST(PatchTemplates, OwnPointsAreOriginsOfTheOthers) {
  // Rows of positions sum to at most 1: what is missing is the own point's weight.
  PatchTemplates templates(Weights::DooSabin);
  const PatchTemplate quad = templates.make({PatchKind::Smooth, 4, 0, 4}, 2);
  ASSERT_EQ(quad.column_count, 8);
  ASSERT_EQ(quad.sample_count, 9);
  double sum = 0;
  for (const double weight : quad.rows(0).first(8)) sum += weight;
  // The midpoint of V and E1: (1, 6, 1) / 8 along u of the mean of two across.
  EXPECT_NEAR(sum, 1 - 6.0 / 16, 1e-15);
}

TEST(FaceKernel, LeavesOutJustTheColumnsWithoutWeight) {
  const PatchClass regular{PatchKind::Smooth, 4, 0, 4};
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    PatchTemplates templates(weights);
    const PatchTemplate patch = templates.make(regular, 2);
    ASSERT_EQ(patch.sample_count, kFaceSamples);
    ASSERT_EQ(patch.column_count, 8);
    for (std::int32_t s = 0; s < kFaceSamples; ++s) {
      unsigned needed = 0;
      for (std::int32_t i = 0; i < 3 * 8; ++i) {
        if (patch.rows(s)[i] != 0) needed |= 1U << (i % 8);
      }
      EXPECT_EQ(needed, kFaceSampleColumns[s]) << "sample " << s;
    }
  }
}

}  // namespace
}  // namespace planish::test
