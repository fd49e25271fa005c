#include "planish/edit/editor_impl.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "edit/edit_case.h"
#include "planish/core/error.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"
#include "support/meshes.h"
#include "support/random_meshes.h"

namespace planish::test {
namespace {

ErrorCode refusal_of(const EvaluateOptions& options) {
  const PolygonMesh mesh = prism(5);
  try {
    const EditedSurface surface(mesh, placement_of(mesh), mesh.positions, {}, options);
  } catch (const Error& error) {
    return error.code();
  }
  ADD_FAILURE() << "made at level " << options.level;
  return ErrorCode::Cancelled;
}

// Before its rows are numbered, which takes shifts and memory by the level.
TEST(EditedSurface, IsRefusedWhereThereIsNoSuchLevelOrNoRoom) {
  EvaluateOptions options;
  for (const int level : {-1, 31, 40, std::numeric_limits<int>::max()}) {
    options.level = level;
    EXPECT_EQ(refusal_of(options), ErrorCode::InvalidArgument) << level;
  }
  options.level = 2;
  options.memory_limit_bytes = 1;
  EXPECT_EQ(refusal_of(options), ErrorCode::OutOfMemory);
}

// What writers get after a move, at the editor's own level and at others.
// Asked for before and after.
TEST(EditedSurface, TextureCoordinatesAreThoseOfTheSurfaceAsItIs) {
  PolygonMesh mesh = jittered(icosphere(2), 0.1, 5);
  for (const glm::dvec3& p : mesh.positions) mesh.uvs.emplace_back(p.x + 0.2 * p.z * p.z, p.y);
  mesh.face_uvs = mesh.face_vertices;
  const EditCase c(mesh, 2);
  Editor editor(c.mesh, c.first, c.options);
  const std::unique_ptr<SurfaceBlocks> blocks = editor.blocks(2);
  const RawVector<glm::dvec2> before = collect(*blocks, {}).uvs;
  editor.move(std::array{7, 20}, std::array{1.4 * mesh.positions[7], 0.8 * mesh.positions[20]});
  const RawVector<glm::dvec2> after = collect(*blocks, {}).uvs;
  const RawVector<glm::dvec2> own = c.surface_of(editor.mesh(), editor.fit()).uvs;
  ASSERT_EQ(after.size(), own.size());
  double moved = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_LT(glm::distance(after[i], own[i]), 1e-12) << i;
    moved = std::max(moved, glm::distance(after[i], before[i]));
  }
  EXPECT_GT(moved, 1e-3);
}

TEST(EditedSurface, BlocksAreTheSurfaceOfTheirLevel) {
  EditCase c(torus(8, 6, 1, 0.4));
  Editor editor(c.mesh, c.first, c.options);
  Mover mover(2);
  mover.choose(editor, c, 2, 0.05);
  editor.move(mover.vertices, mover.positions);
  for (const int level : {1, 2, 3}) {
    const SurfaceMesh blocks = collect(*editor.blocks(level), {});
    c.options.level = level;
    const SurfaceMesh expected = c.surface_of(editor.mesh(), editor.fit());
    EXPECT_LT(farthest(blocks.positions, expected.positions), 1e-13 * c.first.placement.diagonal)
        << level;
    EXPECT_EQ(blocks.face_vertices, expected.face_vertices) << level;
  }
}

}  // namespace
}  // namespace planish::test
