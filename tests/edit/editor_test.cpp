#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>
#include <thread>

#include "edit/edit_case.h"
#include "planish/doosabin/subdivision.h"
#include "planish/edit/editor.h"
#include "planish/edit/editor_impl.h"
#include "planish/pipeline/fit_mesh.h"
#include "support/calls.h"

namespace planish::test {
namespace {

// Whether all rows are solved is decided before any is: by how far moves are expected to reach.

// The system of a mesh whose vertices faces name all, as an editor has it.
LocalSolve solve_of(const EditCase& c) {
  const auto& prepared = *c.first.prepared;
  const auto features =
      find_sharp_features(c.mesh, *prepared.topology, c.mesh.positions, c.options.fit.sharp);
  const Subdivision subdivision(*prepared.topology, features, c.options.fit.weights);
  const auto unit = [&](const std::vector<glm::dvec3>& positions) {
    std::vector<glm::dvec3> result;
    for (const glm::dvec3& p : positions) result.push_back(c.first.placement.to_unit(p));
    return result;
  };
  return LocalSolve(doo_sabin_system(c.mesh, subdivision, c.options.fit), prepared.topology,
                    unit(c.mesh.positions), unit(c.first.cage.positions), kTolerance);
}

TEST(LocalSolve, DecidesBeforeItSolvesWhetherAllAreReached) {
  const std::vector<NamedMesh> meshes{{"quads", torus(150, 100, 1, 0.4)},
                                      {"triangles", icosphere(5)},
                                      {"uneven", jittered(icosphere(5), 0.3, 7)}};
  for (const auto& [name, mesh] : meshes) {
    SCOPED_TRACE(name);
    const EditCase c(mesh, 0);
    LocalSolve solve = solve_of(c);
    std::mt19937 random(11);
    const std::size_t size = mesh.positions.size();
    bool was_whole = false;
    std::size_t most_local = 0;
    for (std::size_t count = 1; count < size / 4; count += 1 + count / 3) {
      std::vector<std::int32_t> vertices;
      std::vector<glm::dvec3> points;
      for (std::size_t k = 0; k < count; ++k) {
        // Scattered, none twice.
        vertices.push_back(static_cast<std::int32_t>(k * size / count));
        points.push_back(solve.given()[vertices.back()] +
                         glm::dvec3(random() % 2 == 0 ? 0.01 : -0.01, 0, 0));
      }
      solve.move(vertices, points);
      EXPECT_LE(solve.measured().norms.max, solve.bound() * (1 + 1e-9));
      if (solve.changed_all()) {
        EXPECT_EQ(solve.row_count(), 0) << count;  // nothing was solved in vain
        was_whole = true;
      } else {
        EXPECT_GT(solve.row_count(), 0);
        EXPECT_FALSE(was_whole) << count;  // once they are too many, more are
        most_local = std::max(most_local, solve.changed().size());
      }
    }
    EXPECT_TRUE(was_whole);
    EXPECT_GT(most_local, size / 100);
    EXPECT_LT(most_local, size / 10);
  }
}

TEST(LocalSolve, SmallMovesReachLess) {
  const EditCase c(torus(150, 100, 1, 0.4), 0);
  LocalSolve solve = solve_of(c);
  // So many that ways of 1 % of the diagonal reach all, of the size of the tolerance hardly others.
  std::vector<std::int32_t> vertices;
  for (std::int32_t v = 0; v < 15'000; v += 50) vertices.push_back(v);
  for (const double way : {1e-2, 1e-6}) {
    std::vector<glm::dvec3> points;
    for (const std::int32_t v : vertices)
      points.push_back(solve.given()[v] + glm::dvec3(0, 0, way));
    solve.move(vertices, points);
    EXPECT_EQ(solve.changed_all(), way == 1e-2);
  }
}

template <class Action>
void expect_refusal(const std::string& part, const Action& action) {
  EXPECT_THAT(message_of(ErrorCode::InvalidArgument, action), testing::HasSubstr(part));
}

template <class Action>
void expect_cancelled(const Action& action) {
  EXPECT_NE(message_of(ErrorCode::Cancelled, action), "no error");
}

TEST(Editor, AgreesWithAFitFromScratch) {
  for (const auto& [name, mesh] : edited_meshes()) {
    for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
      SCOPED_TRACE(name);
      const EditCase c(mesh, 2, weights);
      if (!c.first.interpolation.converged) continue;
      Editor editor(c.mesh, c.first, c.options);
      Mover mover(3);
      for (int i = 0; i < 12; ++i) {
        mover.choose(editor, c, i % 3 == 2 ? 3 : 1, i % 2 == 0 ? 0.01 : 0.1);
        editor.move(mover.vertices, mover.positions);
        ASSERT_LE(editor.measured_error(), editor.error_bound() * (1 + 1e-9));
        ASSERT_LE(editor.error_bound(), kTolerance);
      }
      const double diagonal = c.first.placement.diagonal;
      const PolygonMesh moved = editor.mesh();
      const auto [scratch, surface] = c.from_scratch(moved);
      EXPECT_LT(farthest(editor.fit().cage.positions, scratch.cage.positions),
                2 * kTolerance * diagonal);
      EXPECT_LT(farthest(editor.positions(), surface.positions), 2 * kTolerance * diagonal);
      // Its rows are those of its own control points.
      const SurfaceMesh own = c.surface_of(moved, editor.fit());
      EXPECT_LT(farthest(editor.positions(), own.positions), 1e-13 * diagonal);
      for (std::size_t i = 0; i < own.normals.size(); ++i)
        ASSERT_LT(glm::length(editor.normals()[i] - own.normals[i]), 1e-5f) << i;
    }
  }
}

TEST(Editor, OtherRowsKeepTheirBits) {
  for (const int level : {0, 1, 2, 3}) {
    for (const auto& [name, mesh] : edited_meshes()) {
      SCOPED_TRACE(name + " level " + std::to_string(level));
      const EditCase c(mesh, level);
      if (!c.first.interpolation.converged) continue;
      Editor editor(c.mesh, c.first, c.options);
      Mover mover(5);
      for (int i = 0; i < 3; ++i) {
        mover.choose(editor, c, 1, 0.02);
        const std::vector<glm::dvec3> positions(editor.positions().begin(),
                                                editor.positions().end());
        const std::vector<glm::vec3> normals(editor.normals().begin(), editor.normals().end());
        const EditChange change = editor.move(mover.vertices, mover.positions);
        std::vector<bool> is_named(positions.size(), false);
        std::int64_t end = 0;
        for (const RowRange& range : change.rows) {
          ASSERT_GE(range.first, end);
          ASSERT_GT(range.count, 0);
          end = range.first + range.count;
          for (std::int64_t r = range.first; r < end; ++r) is_named[r] = true;
        }
        ASSERT_LE(end, static_cast<std::int64_t>(positions.size()));
        for (std::size_t r = 0; r < positions.size(); ++r) {
          if (is_named[r]) continue;
          ASSERT_EQ(editor.positions()[r], positions[r]) << r;
          ASSERT_EQ(editor.normals()[r], normals[r]) << r;
        }
        // All rows are those of the editor's own control points, so that none was left out.
        const SurfaceMesh own = c.surface_of(editor.mesh(), editor.fit());
        ASSERT_LT(farthest(editor.positions(), own.positions), 1e-13 * c.first.placement.diagonal);
      }
    }
  }
}

// At a tolerance so small that nothing else is left, rows are linear in the moves.
TEST(Editor, IsTheDerivativeOfAFit) {
  EditCase c(jittered(icosphere(3), 0.2, 1));
  c.options.fit.tolerance = 1e-11;
  c.first = fit(c.mesh, *c.backend, c.options.fit);
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<glm::dvec3> before(editor.positions().begin(), editor.positions().end());
  const double h = 1e-3;
  const std::int32_t vertex = 17;
  const glm::dvec3 to = editor.points()[17] + glm::dvec3(0, h, 0);
  editor.move(std::span(&vertex, 1), std::span(&to, 1));
  PolygonMesh other = c.mesh;
  other.positions[17].y -= 2 * h;  // another step, the other way
  const auto [scratch, surface] = c.from_scratch(other);
  for (std::size_t r = 0; r < before.size(); ++r) {
    const glm::dvec3 edited = (editor.positions()[r] - before[r]) / h;
    const glm::dvec3 fitted = (surface.positions[r] - before[r]) / (-2 * h);
    ASSERT_LT(glm::length(edited - fitted), 1e-6) << r;
  }
}

TEST(Editor, KeepsItsBoundOverManyEdits) {
  const EditCase c(torus(40, 30, 1, 0.4));
  Editor editor(c.mesh, c.first, c.options);
  Mover mover(7);
  for (int i = 0; i < 1500; ++i) {
    mover.choose(editor, c, 1, 0.01);
    // Around where it was, so that the torus stays one.
    mover.positions[0] += c.mesh.positions[mover.vertices[0]] - editor.points()[mover.vertices[0]];
    const EditChange change = editor.move(mover.vertices, mover.positions);
    ASSERT_FALSE(change.is_whole);
    ASSERT_LT(change.control_points.size(), 700u);
  }
  EXPECT_LE(editor.measured_error(), editor.error_bound() * (1 + 1e-9));
  EXPECT_LE(editor.error_bound(), kTolerance);
  const auto [scratch, surface] = c.from_scratch(editor.mesh());
  EXPECT_LT(farthest(editor.fit().cage.positions, scratch.cage.positions),
            2 * kTolerance * c.first.placement.diagonal);
  const EditChange change = editor.settle();
  EXPECT_TRUE(change.is_whole);
  EXPECT_EQ(change.control_points.size(), c.mesh.positions.size());
  EXPECT_EQ(editor.fit().interpolation.iterations, c.first.interpolation.iterations);
  EXPECT_LE(editor.measured_error(), kTolerance / 8);
  std::vector<std::int32_t> all(c.mesh.positions.size());
  for (std::size_t v = 0; v < all.size(); ++v) all[v] = static_cast<std::int32_t>(v);
  EXPECT_TRUE(editor.move(all, c.mesh.positions).is_whole);
  EXPECT_LT(farthest(editor.fit().cage.positions, c.first.cage.positions),
            2 * kTolerance * c.first.placement.diagonal);
}

TEST(Editor, CostsWhatItMoves) {
  std::vector<std::int64_t> rows, points;
  for (const int size : {60, 240}) {
    const EditCase c(torus(size, size, 1, 0.4));
    Editor editor(c.mesh, c.first, c.options);
    const std::int32_t vertex = size * size / 2 + size / 2;
    // As many edges on either mesh.
    const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(0, 0, 6.0 / size);
    const EditChange change = editor.move(std::span(&vertex, 1), std::span(&to, 1));
    rows.push_back(change.row_count);
    points.push_back(std::ssize(change.control_points));
  }
  EXPECT_LE(rows[1], rows[0]);  // less: the tolerance is a part of the diagonal
  EXPECT_LE(points[1], points[0]);
  EXPECT_LT(points[0], 600);
}

TEST(Editor, TakesBackAndDoesAgain) {
  const EditCase c(with_random_creases(random_open_mesh(2), 0.15, 2));
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<glm::dvec3> rest(editor.positions().begin(), editor.positions().end());
  EXPECT_FALSE(editor.can_undo());
  EXPECT_EQ(editor.undo().row_count, 0);
  editor.move({}, {});
  EXPECT_FALSE(editor.can_undo());  // nothing moved, nothing is taken back
  Mover mover(9);
  for (int i = 0; i < 5; ++i) {
    mover.choose(editor, c, 2, 0.1);
    editor.move(mover.vertices, mover.positions);
  }
  const std::vector<glm::dvec3> last(editor.points().begin(), editor.points().end());
  const std::vector<glm::dvec3> rows(editor.positions().begin(), editor.positions().end());
  for (int i = 0; i < 5; ++i) editor.undo();
  EXPECT_FALSE(editor.can_undo());
  EXPECT_TRUE(std::ranges::equal(editor.points(), c.mesh.positions));
  EXPECT_LT(farthest(editor.positions(), rest), kTolerance * c.first.placement.diagonal);
  while (editor.can_redo()) editor.redo();
  EXPECT_TRUE(std::ranges::equal(editor.points(), last));
  EXPECT_LT(farthest(editor.positions(), rows), kTolerance * c.first.placement.diagonal);
  editor.undo();
  editor.move(mover.vertices, mover.positions);
  EXPECT_FALSE(editor.can_redo());
}

TEST(Editor, MovesASelectionByAMap) {
  const EditCase c(flat_grid(20, 20));
  Editor editor(c.mesh, c.first, c.options);
  const std::int32_t middle = 10 * 21 + 10;
  const glm::dvec3 at = c.mesh.positions[middle];
  const double edge = glm::length(c.mesh.positions[middle + 1] - at);
  const Selection near = editor.select(std::span(&middle, 1), 2.5 * edge);
  // By edges' lengths: 1 + 4 + 8 vertices of a grid, all ways along edges.
  ASSERT_EQ(near.vertices.size(), 13u);
  for (std::size_t i = 0; i < near.vertices.size(); ++i) {
    const glm::dvec3 off = glm::abs(c.mesh.positions[near.vertices[i]] - at);
    const double part = (off.x + off.y + off.z) / (2.5 * edge);
    EXPECT_NEAR(near.weights[i], (1 - part * part) * (1 - part * part), 1e-12);
  }
  editor.transform(near, glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, 2)));
  for (std::size_t i = 0; i < near.vertices.size(); ++i) {
    EXPECT_NEAR(editor.points()[near.vertices[i]].z - c.mesh.positions[near.vertices[i]].z,
                2 * near.weights[i], 1e-12);
  }
}

TEST(Editor, GivesTheSameBitsOnAnyNumberOfThreads) {
  const oneapi::tbb::global_control allowed(oneapi::tbb::global_control::max_allowed_parallelism,
                                            4);
  const EditCase c(torus(240, 200, 1, 0.4));
  const auto rows_on = [&](int threads) {
    std::vector<glm::dvec3> rows;
    oneapi::tbb::task_arena arena(threads);
    arena.execute([&] {
      Editor editor(c.mesh, c.first, c.options);
      Mover mover(1);
      for (int i = 0; i < 6; ++i) {
        mover.choose(editor, c, 20, 0.02);
        const EditChange change = editor.move(mover.vertices, mover.positions);
        EXPECT_FALSE(change.is_whole);
        EXPECT_GT(change.row_count, 32'768);  // so many that several threads share them
      }
      mover.choose(editor, c, 5000, 0.002);
      EXPECT_TRUE(editor.move(mover.vertices, mover.positions).is_whole);
      rows.assign(editor.positions().begin(), editor.positions().end());
    });
    return rows;
  };
  const std::vector<glm::dvec3> alone = rows_on(1);
  EXPECT_EQ(alone, rows_on(2));
  EXPECT_EQ(alone, rows_on(4));
}

// As documented: whatever is constant, from many threads between two changes.
TEST(Editor, ManyMayReadItBetweenChanges) {
  const EditCase c(torus(60, 40, 1, 0.4));
  Editor editor(c.mesh, c.first, c.options);
  const SurfaceQueries& queries = editor.queries();
  Mover mover(4);
  for (int i = 0; i < 4; ++i) {
    mover.choose(editor, c, 2, 0.05);
    editor.move(mover.vertices, mover.positions);
    std::vector<std::thread> readers;
    std::vector<double> seen(4, -1);
    for (std::size_t k = 0; k < seen.size(); ++k) {
      readers.emplace_back([&, k] {
        const std::int32_t vertex = mover.vertices[0];
        const double distance = queries.closest(editor.points()[vertex]).distance;
        const std::size_t near = editor.select(std::span(&vertex, 1), 0.2).vertices.size();
        const PolygonMesh mesh = editor.mesh();
        seen[k] = distance + editor.measured_error() + editor.fit().interpolation.error.rms +
                  static_cast<double>(near) + mesh.positions[vertex].x + editor.positions()[3].x;
      });
    }
    for (std::thread& reader : readers) reader.join();
    EXPECT_THAT(seen, testing::Each(seen[0]));
  }
}

TEST(Editor, WhatIsCancelledHasNotHappened) {
  const EditCase c(torus(120, 100, 1, 0.4));
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<glm::dvec3> rows(editor.positions().begin(), editor.positions().end());
  const std::vector<glm::dvec3> cage = editor.fit().cage.positions;
  Mover mover(1);
  mover.choose(editor, c, 500, 0.05);
  Callbacks stop;
  stop.cancelled = [] { return true; };
  expect_cancelled([&] { editor.move(mover.vertices, mover.positions, stop); });
  expect_cancelled([&] { editor.settle(stop); });
  EXPECT_TRUE(std::ranges::equal(editor.points(), c.mesh.positions));
  EXPECT_TRUE(std::ranges::equal(editor.positions(), rows));
  EXPECT_EQ(editor.fit().cage.positions, cage);
  EXPECT_FALSE(editor.can_undo());
  editor.move(mover.vertices, mover.positions);
  EXPECT_LE(editor.measured_error(), kTolerance);
}

// Whenever it is asked for: what was moved by then is taken back, or all is done.
TEST(Editor, CancelledAtAnyTimeItIsDoneOrNot) {
  EditCase c(torus(240, 200, 1, 0.4));
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    c.options.fit.method = method;
    c.first = fit(c.mesh, *c.backend, c.options.fit);
    Editor editor(c.mesh, c.first, c.options);
    const std::vector<glm::dvec3> rest(editor.positions().begin(), editor.positions().end());
    Mover mover(1);
    mover.choose(editor, c, 20'000, 0.001);
    int cancelled_count = 0;
    // It is asked by the clock: under a sanitizer some hundred times in one move.
    for (int k = 1; k < 100'000; k += 1 + k / 16) {
      Callbacks stop;
      int asked = 0;
      stop.cancelled = [&] { return ++asked == k; };
      try {
        EXPECT_TRUE(editor.move(mover.vertices, mover.positions, stop).is_whole);
        break;
      } catch (const Error& error) {
        ASSERT_EQ(error.code(), ErrorCode::Cancelled);
        ++cancelled_count;
        ASSERT_TRUE(std::ranges::equal(editor.points(), c.mesh.positions)) << k;
        ASSERT_TRUE(std::ranges::equal(editor.positions(), rest)) << k;
        ASSERT_FALSE(editor.can_undo());
      }
    }
    EXPECT_GT(cancelled_count, 0);
    ASSERT_TRUE(editor.can_undo());
    EXPECT_LE(editor.measured_error(), kTolerance);
    const SurfaceMesh own = c.surface_of(editor.mesh(), editor.fit());
    EXPECT_LT(farthest(editor.positions(), own.positions), 1e-13 * c.first.placement.diagonal);
  }
}

TEST(Editor, GivesItsFitWithErrorsMeasuredAnew) {
  const EditCase c(jittered(icosphere(3), 0.2, 4));
  Editor editor(c.mesh, c.first, c.options);
  Mover mover(2);
  for (int i = 0; i < 5; ++i) {
    mover.choose(editor, c, 2, 0.05);
    editor.move(mover.vertices, mover.positions);
  }
  const Fit now = editor.fit();
  const std::vector<glm::dvec3> limits =
      limit_positions(now.cage, {.weights = c.options.fit.weights});
  double largest = 0, squares = 0;
  std::int64_t worst = -1;
  for (std::size_t v = 0; v < limits.size(); ++v) {
    const double off = glm::length(limits[v] - editor.points()[v]) / c.first.placement.diagonal;
    squares += off * off;
    if (off <= largest) continue;
    largest = off;
    worst = static_cast<std::int64_t>(v);
  }
  EXPECT_NEAR(now.interpolation.error.max, largest, 1e-13);
  EXPECT_NEAR(now.interpolation.error.rms, std::sqrt(squares / static_cast<double>(limits.size())),
              1e-13);
  EXPECT_EQ(now.interpolation.worst_vertex, worst);
  EXPECT_TRUE(now.interpolation.converged);
  EXPECT_LE(largest, kTolerance);
}

TEST(Editor, KnowsVerticesThatNoFaceNames) {
  PolygonMesh mesh = icosphere(2);
  mesh.positions.insert(mesh.positions.begin() + 5, glm::dvec3(9, 9, 9));
  for (std::int32_t& v : mesh.face_vertices) v += v >= 5 ? 1 : 0;
  const EditCase c(mesh);
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<std::int32_t> vertices{5, 8, 8};
  const std::vector<glm::dvec3> to{
      {7, 7, 7}, {0, 0, 0}, c.mesh.positions[8] + glm::dvec3(0.1, 0, 0)};
  const EditChange change = editor.move(vertices, to);
  EXPECT_THAT(std::vector<std::int32_t>(change.vertices.begin(), change.vertices.end()),
              testing::ElementsAre(5, 8));
  EXPECT_EQ(editor.points()[5], to[0]);
  EXPECT_EQ(editor.points()[8], to[2]);  // the last one counts
  const auto [scratch, surface] = c.from_scratch(editor.mesh());
  EXPECT_LT(farthest(editor.positions(), surface.positions),
            2 * kTolerance * c.first.placement.diagonal);
}

TEST(Editor, RefusesWithTheReason) {
  const EditCase c(icosphere(1));
  Editor editor(c.mesh, c.first, c.options);
  const auto move = [&](std::int32_t vertex, const glm::dvec3& to) {
    editor.move(std::span(&vertex, 1), std::span(&to, 1));
  };
  expect_refusal("no vertex 42", [&] { move(42, {}); });
  expect_refusal("no vertex -1", [&] { move(-1, {}); });
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_refusal("vertex 3", [&] { move(3, {0, kNan, 0}); });
  expect_refusal("vertex 3", [&] { move(3, {1e300, 0, 0}); });
  expect_refusal("vertices", [&] { editor.move({}, c.mesh.positions); });
  const std::int32_t vertex = 3, absent = 99;
  expect_refusal("radius", [&] { (void)editor.select(std::span(&vertex, 1), 0); });
  expect_refusal("99", [&] { (void)editor.select(std::span(&absent, 1), 1); });
  expect_refusal("weights", [&] { editor.transform({{3}, {}}, glm::dmat4(1.0)); });
  EXPECT_TRUE(std::ranges::equal(editor.points(), c.mesh.positions));

  FitOptions few = c.options.fit;
  few.max_iterations = 1;
  few.tolerance = 1e-9;
  const Fit unready = fit(c.mesh, *c.backend, few);
  expect_refusal("iteration-limit", [&] { Editor refused(c.mesh, unready, c.options); });
  FitOptions loose = c.options.fit;
  loose.within = 0.01;
  const Fit left = fit(c.mesh, *c.backend, loose);
  EditorOptions with_it = c.options;
  with_it.fit = loose;
  expect_refusal("within", [&] { Editor refused(c.mesh, left, with_it); });
}

// Edges and vertices that become sharp and smooth again: the surface is that of a fit with such
// tags.

// The editor's rows against a fit from scratch of its mesh, whose tags it must have.
void expect_fit_of(const Editor& editor, const EditCase& c, double tolerance) {
  const PolygonMesh mesh = editor.mesh();
  FitOptions tight = c.options.fit;
  if (tight.method == InterpolationMethod::Progressive) tight.tolerance = 1e-12;
  const Fit scratch = fit(mesh, *c.backend, tight);
  EvaluateOptions evaluate;
  evaluate.level = c.options.level;
  const SurfaceMesh rows = planish::evaluate(mesh, scratch, *c.backend, evaluate);
  ASSERT_EQ(rows.positions.size(), editor.positions().size());
  EXPECT_LT(farthest(editor.positions(), rows.positions), tolerance * c.first.placement.diagonal);
  EXPECT_LE(editor.measured_error(), kTolerance);
}

// A ring of edges around the torus' tube.
std::vector<CreaseEdge> ring_of(int around, int first, float sharpness) {
  std::vector<CreaseEdge> edges;
  for (int k = 0; k < around; ++k)
    edges.push_back({first * around + k, first * around + (k + 1) % around, sharpness});
  return edges;
}

TEST(EditorSharp, IsAFitWithThoseTags) {
  for (const auto method : {InterpolationMethod::Progressive, InterpolationMethod::Fair}) {
    EditCase c(torus(30, 20, 1, 0.4));
    c.options.fit.method = method;
    c.first = fit(c.mesh, *c.backend, c.options.fit);
    Editor editor(c.mesh, c.first, c.options);
    const std::size_t smooth_rows = editor.positions().size();
    (void)editor.queries();
    Mover mover(3);
    mover.choose(editor, c, 2, 0.01);
    editor.move(mover.vertices, mover.positions);
    const std::vector<CornerVertex> corner{{407}};
    const EditChange change = editor.set_sharp(ring_of(20, 4, kInfiniteSharpness), corner);
    EXPECT_TRUE(change.is_whole);
    EXPECT_EQ(change.row_count, std::ssize(editor.positions()));
    EXPECT_EQ(change.control_points.size(), c.mesh.positions.size());
    EXPECT_GT(editor.positions().size(), smooth_rows);  // the ring's rows stand twice
    expect_fit_of(editor, c, method == InterpolationMethod::Fair ? 1e-7 : 2 * kTolerance);
    const double off = editor.queries().closest(editor.points()[80]).distance;
    EXPECT_LT(off, kTolerance * c.first.placement.diagonal);  // queries of the new surface

    mover.choose(editor, c, 1, 0.01);
    editor.move(mover.vertices, mover.positions);
    EXPECT_LE(editor.measured_error(), kTolerance);
    editor.undo();
    editor.undo();  // the move before the crease
    EXPECT_TRUE(std::ranges::equal(editor.points(), c.mesh.positions));
    EXPECT_FALSE(editor.can_undo());

    const std::vector<CornerVertex> smooth{{407, 0}};
    editor.set_sharp(ring_of(20, 4, 0), smooth);
    EXPECT_EQ(editor.positions().size(), smooth_rows);
    EXPECT_TRUE(editor.mesh().creases.empty() && editor.mesh().corners.empty());
    expect_fit_of(editor, c, method == InterpolationMethod::Fair ? 1e-7 : 2 * kTolerance);
  }
}

// Angles at corners are those of the mesh when it was tagged, and stay so.
TEST(EditorSharp, MeasuresAnglesWhenItTags) {
  const EditCase c(flat_grid(6, 6));
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<std::int32_t> ends{25, 31};  // of the edges at 24, the middle
  const std::vector<glm::dvec3> inwards{{-0.3, -0.07, 0}, {0.05, -0.28, 0}};
  std::vector<glm::dvec3> to;
  for (std::size_t i = 0; i < 2; ++i)
    to.push_back(c.mesh.positions[ends[i]] + c.first.placement.diagonal * inwards[i]);
  editor.move(ends, to);
  editor.set_sharp(std::vector<CreaseEdge>{{24, 25}, {31, 24}}, std::vector<CornerVertex>{{24}});
  expect_fit_of(editor, c, 2 * kTolerance);
  EXPECT_TRUE(std::ranges::equal(editor.rest_positions(), editor.points()));
}

TEST(EditorSharp, RefusesWithTheReason) {
  const EditCase c(torus(30, 20, 1, 0.4));
  Editor editor(c.mesh, c.first, c.options);
  const auto expect = [&](const std::string& words, const std::vector<CreaseEdge>& edges,
                          const std::vector<CornerVertex>& corners) {
    EXPECT_THAT(message_of(ErrorCode::InvalidArgument, [&] { editor.set_sharp(edges, corners); }),
                testing::HasSubstr(words));
  };
  expect("vertices 3 and 5 have no edge", {{3, 5}}, {});
  expect("no face has a vertex 600", {{3, 600}}, {});
  expect("no face has a vertex -1", {}, {{-1}});
  expect("the sharpness 2.0", {{3, 4, 2.0f}}, {});
  expect("the sharpness nan", {{3, 4, std::nanf("")}}, {});
  EXPECT_TRUE(editor.mesh().creases.empty());
  const std::vector<glm::dvec3> rows(editor.positions().begin(), editor.positions().end());
  Callbacks stop;
  stop.cancelled = [] { return true; };
  EXPECT_NE(message_of(ErrorCode::Cancelled,
                       [&] { editor.set_sharp(ring_of(20, 4, kInfiniteSharpness), {}, stop); }),
            "no error");
  EXPECT_TRUE(std::ranges::equal(editor.positions(), rows));
  EditorOptions untagged = c.options;
  untagged.fit.sharp.use_tags = false;
  Editor blind(c.mesh, c.first, untagged);
  EXPECT_THAT(message_of(ErrorCode::InvalidArgument,
                         [&] { blind.set_sharp(ring_of(20, 4, kInfiniteSharpness), {}); }),
              testing::HasSubstr("use_tags"));
}

struct FairEditCase {
  FairEditCase(PolygonMesh given, std::int32_t polish_steps)
      : mesh(std::move(given)), backend(make_cpu_backend()) {
    options.fit.method = InterpolationMethod::Fair;
    options.fit.polish_steps = polish_steps;
    options.fit.keeps_planes = true;
    first = fit(mesh, *backend, options.fit);
  }
  // From scratch, with the decisions of the first pose.
  [[nodiscard]] SurfaceMesh from_scratch(const PolygonMesh& moved) const {
    FitOptions kept = options.fit;
    kept.fair_decisions = &first.fair->decisions;
    const Fit result = fit(moved, *backend, kept);
    EvaluateOptions evaluate;
    evaluate.rest_positions = mesh.positions;
    return planish::evaluate(moved, result, *backend, evaluate);
  }

  PolygonMesh mesh;
  std::unique_ptr<Backend> backend;
  EditorOptions options;
  Fit first;
};

std::vector<NamedMesh> fair_meshes() {
  return {{"torus", torus(80, 60, 1, 0.4)},
          {"sphere", jittered(icosphere(4), 0.3, 4)},
          {"creased", with_random_creases(jittered(icosphere(4), 0.2, 2), 0.05, 3)},
          {"open", with_random_creases(jittered(flat_grid(60, 60), 0.2, 5), 0.03, 6)},
          {"planes", rounded_box({1, 0.7, 0.4}, 0.3, 24)}};
}

PolygonMesh moved_at_random(Editor& editor, const FairEditCase& c, double part, int moves) {
  std::mt19937 random(11);
  std::uniform_int_distribution<std::int32_t> any(0, c.mesh.vertex_count() - 1);
  std::uniform_real_distribution<double> way(-part, part);
  for (int i = 0; i < moves; ++i) {
    const std::int32_t vertex = any(random);
    const glm::dvec3 to =
        editor.points()[vertex] +
        c.first.placement.diagonal * glm::dvec3(way(random), way(random), way(random));
    const EditChange change = editor.move(std::span(&vertex, 1), std::span(&to, 1));
    EXPECT_FALSE(change.is_whole);
  }
  return editor.mesh();
}

// Without the polish all is local: an edited net is the whole net.
TEST(FairEditor, IsTheWholeNetWithoutPolish) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairEditCase c(mesh, 0);
    Editor editor(c.mesh, c.first, c.options);
    const SurfaceMesh whole = c.from_scratch(moved_at_random(editor, c, 0.004, 4));
    EXPECT_LT(farthest(editor.positions(), whole.positions), 1e-12 * c.first.placement.diagonal);
  }
}

TEST(FairEditor, PassesThroughItsPointsAndStaysNearTheWholeNet) {
  for (const auto& [name, mesh] : fair_meshes()) {
    SCOPED_TRACE(name);
    const FairEditCase c(mesh, 8);
    Editor editor(c.mesh, c.first, c.options);
    const std::vector<glm::dvec3> rest(editor.positions().begin(), editor.positions().end());
    const double part = 0.004;
    const SurfaceMesh whole = c.from_scratch(moved_at_random(editor, c, part, 4));
    EXPECT_LT(editor.measured_error(), 1e-13);
    EXPECT_LE(editor.measured_error(), editor.error_bound() + 1e-15);
    // The polish is minimised on a part: off by a few hundredths of the moves.
    EXPECT_LT(farthest(editor.positions(), whole.positions),
              0.05 * part * c.first.placement.diagonal);
    // The polish is in single precision, and the whole fit takes a moved bounding box for its unit.
    const EditChange settled = editor.settle();
    EXPECT_TRUE(settled.is_whole);
    EXPECT_LT(farthest(editor.positions(), whole.positions), 1e-8 * c.first.placement.diagonal);
    while (editor.can_undo()) editor.undo();
    EXPECT_LT(editor.measured_error(), 1e-13);
    EXPECT_LT(farthest(editor.positions(), rest), 0.05 * part * c.first.placement.diagonal);
  }
}

// What parts leave does not add up for ever: the whole net is made once in so many moves.
TEST(FairEditor, MakesTheWholeNetOnceInAWhile) {
  FairEditCase c(torus(80, 60, 1, 0.4), 8);
  c.options.settle_after = 3;
  Editor editor(c.mesh, c.first, c.options);
  std::vector<bool> is_whole;
  for (int i = 0; i < 9; ++i) {
    const std::int32_t vertex = 500 * i + 7;
    const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(0.01, 0.02, 0);
    is_whole.push_back(editor.move(std::span(&vertex, 1), std::span(&to, 1)).is_whole);
    if (!is_whole.back()) continue;
    EXPECT_LT(farthest(editor.positions(), c.from_scratch(editor.mesh()).positions),
              1e-8 * c.first.placement.diagonal);
  }
  EXPECT_THAT(is_whole,
              testing::ElementsAre(false, false, false, true, false, false, false, true, false));
  EXPECT_LT(editor.error_bound(), 1e-14);
}

std::vector<NamedMesh> edited_meshes() {
  return {{"sphere", jittered(icosphere(2), 0.3, 4)},
          {"closed", random_closed_mesh(5)},
          {"quads", torus(16, 10, 1, 0.4)},
          {"creased", with_random_creases(random_closed_mesh(2), 0.1, 3)},
          {"open", random_open_mesh(4)},
          {"dual", random_dual(60, 3)},
          {"drum", prism(24)}};
}

// Of the same method, of the mesh as it is now and nothing else.
SurfaceMesh fit_of(const Editor& editor, InterpolationMethod method) {
  MeshFitOptions options;
  options.method = method;
  options.repairs = false;
  options.quads = QuadChoice::Off;
  const auto backend = make_cpu_backend();
  const FittedMesh fitted = fit_mesh(editor.mesh(), "mesh", *backend, options);
  return evaluate(fitted.mesh, fitted.fit, *backend, fitted.evaluate_options(2));
}

class Refit : public testing::TestWithParam<InterpolationMethod> {};

// After a session of moves that the fit's decisions do not suit any more.
TEST_P(Refit, IsTheFitOfTheMeshAsItIs) {
  const bool is_fair = GetParam() == InterpolationMethod::Fair;
  double farthest_kept = 0;
  for (const auto& [name, given] : edited_meshes()) {
    SCOPED_TRACE(name);
    const auto backend = make_cpu_backend();
    EditorOptions options;
    options.fit.method = GetParam();
    const Fit first = fit(given, *backend, options.fit);
    ASSERT_TRUE(first.interpolation.converged);
    Editor editor(given, first, options);
    std::mt19937 random(2);
    std::uniform_int_distribution<std::int32_t> any(0, given.vertex_count() - 1);
    std::normal_distribution<double> normal(0, 0.004 * first.placement.diagonal);
    for (int i = 0; i < 250; ++i) {
      const std::int32_t vertex = any(random);
      const double x = normal(random), y = normal(random);
      const glm::dvec3 to = editor.points()[vertex] + glm::dvec3(x, y, normal(random));
      editor.move(std::span(&vertex, 1), std::span(&to, 1));
    }
    const double diagonal = first.placement.diagonal;
    const SurfaceMesh anew = fit_of(editor, GetParam());
    editor.settle();
    farthest_kept =
        std::max(farthest_kept, farthest(editor.positions(), anew.positions) / diagonal);

    const std::vector<glm::dvec3> points(editor.points().begin(), editor.points().end());
    const EditChange change = editor.refit();
    EXPECT_TRUE(change.is_whole);
    EXPECT_EQ(change.row_count, std::ssize(anew.positions));
    EXPECT_LT(farthest(editor.positions(), anew.positions), (is_fair ? 1e-9 : 2e-6) * diagonal);
    EXPECT_EQ(farthest(editor.points(), points), 0);
    EXPECT_EQ(farthest(editor.rest_positions(), points), 0);

    // The session goes on.
    ASSERT_TRUE(editor.can_undo());
    for (int i = 0; i < 20; ++i) editor.undo();
    EXPECT_LT(editor.measured_error(), 1.01e-6);
    for (int i = 0; i < 20; ++i) editor.redo();
    EXPECT_EQ(farthest(editor.points(), points), 0);
    editor.settle();
    EXPECT_LT(farthest(editor.positions(), anew.positions), (is_fair ? 1e-9 : 2e-6) * diagonal);
  }
  // Else this would test nothing.
  if (is_fair) {
    EXPECT_GT(farthest_kept, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Methods, Refit,
                         testing::Values(InterpolationMethod::Progressive,
                                         InterpolationMethod::Fair));

TEST(Refit, ThatIsCancelledChangesNothing) {
  EditCase c(icosphere(2));
  Editor editor(c.mesh, c.first, c.options);
  const std::vector<glm::dvec3> rows(editor.positions().begin(), editor.positions().end());
  Callbacks stop;
  stop.cancelled = [] { return true; };
  EXPECT_THROW(editor.refit(stop), Error);
  EXPECT_EQ(farthest(editor.positions(), rows), 0);
}

}  // namespace
}  // namespace planish::test
