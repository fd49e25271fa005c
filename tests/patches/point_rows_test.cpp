#include "planish/patches/patch_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "planish/mesh/polygon_mesh.h"
#include "planish/patches/doo_sabin_step.h"
#include "planish/patches/patch_surface.h"
#include "support/meshes.h"

namespace planish {
namespace {

struct Level2 {
  explicit Level2(const PolygonMesh& mesh)
      : topology(mesh),
        features(find_sharp_features(mesh, topology, mesh.positions, {})),
        patches(topology, features),
        state(first_step(patches, Weights::DooSabin, mesh.positions)) {}
  [[nodiscard]] PatchSurface surface(PatchInstructions instructions) const {
    return {patches, {.level = 2, .instructions = instructions}};
  }
  MeshTopology topology;
  SharpFeatures features;
  PatchMesh patches;
  RawVector<glm::dvec3> state;
  Placement placement{glm::dvec3(0.5, -1, 2), 3.0};
};

struct AllRows {
  explicit AllRows(std::int64_t count)
      : positions(static_cast<std::size_t>(count)), normals(positions.size()) {}
  [[nodiscard]] PatchTarget target() {
    PatchTarget to;
    to.positions = positions;
    to.normals = normals;
    return to;
  }
  std::vector<glm::dvec3> positions;
  std::vector<glm::vec3> normals;
};

// All regular; creases and vertices of valence 3 and 5 among regular quads; boundaries.
std::vector<test::NamedMesh> meshes_of_quads() {
  const auto wave = [](double x, double y) {
    return glm::dvec3(x, y, std::sin(x) * std::cos(0.7 * y));
  };
  PolygonMesh creased = test::torus(9, 7, 1.0, 0.4);
  creased.creases = {{0, 1}, {1, 2}, {30, 37}};
  return {{"torus", test::torus(9, 7, 1.0, 0.4)},
          {"creased", creased},
          {"cube", test::cube()},
          {"grid", test::grid(7, 6, wave)},
          {"plate", test::plate_with_hole(9)}};
}

// Each row of a vertex, a face or an edge once, with the bits that rows() gives it.
void expect_points(PointRows& points, const PatchSurface& surface, AllRows& wanted) {
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
    const Level2 at(mesh);
    for (const PatchInstructions instructions :
         {PatchInstructions::Baseline, PatchInstructions::Avx2}) {
      if (!can_run(instructions)) continue;
      const PatchSurface surface = at.surface(instructions);
      if (name == "torus") {
        ASSERT_TRUE(surface.makes_points());
      }
      if (!surface.makes_points()) continue;
      const std::int64_t count = surface.numbering().row_count();
      AllRows wanted(count), made(count);
      (void)surface.rows(at.state, at.placement, {0, count}, wanted.target());
      std::vector<std::int32_t> corners(static_cast<std::size_t>(at.topology.corner_count()));
      std::iota(corners.begin(), corners.end(), 0);
      AllRows grids(std::int64_t{surface.numbering().samples().count()} * std::ssize(corners));
      PointRows points;
      (void)surface.grids(at.state, at.placement, corners, grids.target(), &points);
      expect_points(points, surface, wanted);
      const auto first = static_cast<std::size_t>(surface.numbering().corner_row(0));
      PatchTarget owned = made.target();
      owned.positions = owned.positions.subspan(first);
      owned.normals = owned.normals.subspan(first);
      (void)surface.owned(at.state, at.placement, 0, at.topology.corner_count(), owned, points);
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
  const Level2 at(test::torus(9, 7, 1.0, 0.4));
  const PatchSurface surface = at.surface(PatchInstructions::Baseline);
  const std::int64_t count = surface.numbering().row_count();
  AllRows wanted(count);
  (void)surface.rows(at.state, at.placement, {0, count}, wanted.target());
  PointRows all, part;
  all.reset(static_cast<std::size_t>(count));
  for (std::int32_t first = 0; first < at.topology.corner_count(); first += 6) {
    const std::int32_t size = std::min(6, at.topology.corner_count() - first);
    std::vector<std::int32_t> corners(static_cast<std::size_t>(size));
    std::iota(corners.begin(), corners.end(), first);
    AllRows grids(std::int64_t{9} * size);
    (void)surface.grids(at.state, at.placement, corners, grids.target(), &part);
    for (std::size_t i = 0; i < part.size(); ++i)
      all.add(part.rows()[i], &part.positions()[i].x, &part.normals()[i].x);
  }
  expect_points(all, surface, wanted);
}

}  // namespace
}  // namespace planish
