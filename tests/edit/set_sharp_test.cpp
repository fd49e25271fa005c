// Edges and vertices that become sharp and smooth again: the surface is that of a fit with such
// tags.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "edit/edit_case.h"
#include "support/expect_error.h"

namespace planish::test {
namespace {

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

}  // namespace
}  // namespace planish::test
