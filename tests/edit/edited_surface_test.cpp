#include <gtest/gtest.h>

#include <array>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "edit/edit_case.h"
#include "planish/core/error.h"
#include "planish/edit/editor_impl.h"
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

// Closest points and rays while vertices are dragged: those of queries made anew.

// Queries of the surface that an editor gives back as a fit, which has not seen its tree.
struct FreshQueries {
  FreshQueries(const Editor& editor, const EditCase& c)
      : mesh(editor.mesh()), now(editor.fit()), limit(surface_of(c)), queries(limit) {}
  [[nodiscard]] std::shared_ptr<const DooSabinSurface> surface_of(const EditCase& c) const {
    EvaluateOptions evaluate;
    evaluate.weights = c.options.fit.weights;
    evaluate.rest_positions = c.mesh.positions;
    return fitted_surface(mesh, now, evaluate);
  }

  PolygonMesh mesh;
  Fit now;
  LimitSurface limit;
  SurfaceQueries queries;
};

// Points around the surface, and rays through it, asked of both.
void expect_same_answers(Editor& editor, const EditCase& c, std::mt19937& random) {
  const FreshQueries fresh(editor, c);
  const double size = c.first.placement.diagonal;
  std::uniform_int_distribution<std::size_t> any(0, editor.positions().size() - 1);
  std::normal_distribution<double> way;
  int hits = 0;
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 aside(way(random), way(random), way(random));
    const glm::dvec3 at = editor.positions()[any(random)];
    const glm::dvec3 point = at + (i % 2 == 0 ? 0.02 : 0.5) * size * aside;
    const ClosestPoint nearest = editor.queries().closest(point);
    ASSERT_NEAR(nearest.distance, fresh.queries.closest(point).distance, 1e-11 * size);
    ASSERT_NEAR(glm::length(editor.queries().surface().evaluate(nearest.at).position - point),
                nearest.distance, 1e-11 * size);
    const SurfaceRay ray{at + size * aside, -aside};
    const auto own = editor.queries().first_hit(ray), other = fresh.queries.first_hit(ray);
    if ((own && own->is_tangent) || (other && other->is_tangent)) continue;
    ASSERT_EQ(own.has_value(), other.has_value());
    if (!own) continue;
    ++hits;
    ASSERT_NEAR(own->t, other->t, 1e-7 * size);
  }
  if (fresh.limit.surface().hidden().empty()) {
    EXPECT_GT(hits, 3);
  }
}

TEST(EditedQueries, AreThoseOfTheSurfaceAsItIs) {
  std::mt19937 random(3);
  for (const auto& [name, mesh] : edited_meshes()) {
    SCOPED_TRACE(name);
    const EditCase c(mesh, 1);
    if (!c.first.interpolation.converged) continue;
    Editor editor(c.mesh, c.first, c.options);
    const SurfaceQueries& queries = editor.queries();
    Mover mover(8);
    for (int i = 0; i < 200; ++i) {
      mover.choose(editor, c, 1 + i % 3, i % 50 == 0 ? 0.3 : 0.02);
      // Around where they were, so that the mesh keeps its size.
      for (std::size_t k = 0; k < mover.vertices.size(); ++k) {
        const auto v = static_cast<std::size_t>(mover.vertices[k]);
        mover.positions[k] += c.mesh.positions[v] - editor.points()[v];
      }
      editor.move(mover.vertices, mover.positions);
      if (i % 7 == 0) editor.undo();
    }
    expect_same_answers(editor, c, random);
    editor.settle();
    expect_same_answers(editor, c, random);
    EXPECT_EQ(&queries, &editor.queries());
  }
}

// As a viewer asks: in every frame of drags with a falloff, and once they are taken back.
TEST(EditedQueries, AreRightInEveryFrameOfADrag) {
  std::mt19937 random(6);
  const std::vector<NamedMesh> meshes{
      {"torus", torus(24, 16, 1, 0.4)},
      {"sphere", jittered(icosphere(2), 0.2, 4)},
      {"creased", with_random_creases(torus(20, 12, 1, 0.4), 0.1, 3)}};
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    const EditCase c(mesh, 0);
    Editor editor(c.mesh, c.first, c.options);
    (void)editor.queries();
    for (int drag = 0; drag < 4; ++drag) {
      const auto vertex = static_cast<std::int32_t>(random() % c.mesh.positions.size());
      const double size = c.first.placement.diagonal;
      const Selection held = editor.select(std::span(&vertex, 1), (0.05 + 0.1 * drag) * size);
      const glm::dvec3 way = 0.02 * size * glm::dvec3(drag - 1.5, 0.5, 1);
      int local = 0;
      for (int frame = 1; frame <= 10; ++frame) {
        local += editor.transform(held, glm::translate(glm::dmat4(1.0), way)).is_whole ? 0 : 1;
        expect_same_answers(editor, c, random);
        if (HasFatalFailure()) return;
      }
      EXPECT_GT(local, 0);
      for (int frame = 0; frame < 10; ++frame) editor.undo();
      expect_same_answers(editor, c, random);
    }
  }
}

TEST(EditedQueries, AreRightAfterMovesOfAll) {
  std::mt19937 random(4);
  const EditCase c(torus(60, 40, 1, 0.4), 1);
  Editor editor(c.mesh, c.first, c.options);
  (void)editor.queries();
  std::vector<std::int32_t> all(c.mesh.positions.size());
  std::vector<glm::dvec3> to(all.size());
  for (std::size_t v = 0; v < all.size(); ++v) {
    all[v] = static_cast<std::int32_t>(v);
    const glm::dvec3& p = c.mesh.positions[v];
    to[v] = {p.y, 1.2 * p.z, 0.7 * p.x};  // no box is where it was
  }
  EXPECT_TRUE(editor.move(all, to).is_whole);
  expect_same_answers(editor, c, random);
}

TEST(EditedQueries, CostWhatMoves) {
  std::vector<std::int64_t> nodes;
  for (const int size : {60, 240}) {
    const EditCase c(torus(size, size, 1, 0.4));
    Editor editor(c.mesh, c.first, c.options);
    const std::int32_t vertex = size * size / 2 + size / 2;
    const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(0, 0, 6.0 / size);
    EXPECT_EQ(editor.move(std::span(&vertex, 1), std::span(&to, 1)).tree_nodes, 0);  // none yet
    EXPECT_GT(editor.undo().row_count, 0);
    (void)editor.queries();
    nodes.push_back(editor.redo().tree_nodes);
  }
  EXPECT_GT(nodes[0], 100);
  // A sixteen times larger mesh has a tree four levels higher, whose nodes there hold most corners.
  EXPECT_LT(static_cast<double>(nodes[1]), 1.3 * static_cast<double>(nodes[0]));
}

TEST(EditedQueries, FollowFairFits) {
  std::mt19937 random(5);
  EditCase c(jittered(icosphere(4), 0.2, 8), 1);
  c.options.fit.method = InterpolationMethod::Fair;
  c.first = fit(c.mesh, *c.backend, c.options.fit);
  Editor editor(c.mesh, c.first, c.options);
  (void)editor.queries();
  Mover mover(2);
  for (int i = 0; i < 5; ++i) {
    mover.choose(editor, c, 1, 0.1);
    EXPECT_FALSE(editor.move(mover.vertices, mover.positions).is_whole);
  }
  expect_same_answers(editor, c, random);
}

}  // namespace
}  // namespace planish::test
