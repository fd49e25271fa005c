#include "support/quad_split.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace planish::test {
namespace {

// A triangle and a pentagon that share an edge: mixed sizes and a boundary.
PolygonMesh triangle_and_pentagon() {
  PolygonMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 2, 0}, {1, 2, 0}};
  mesh.add_face(std::array{0, 1, 2});
  mesh.add_face(std::array{1, 3, 4, 5, 2});
  return mesh;
}

TEST(QuadSplit, CountsEqualOpenSubdivsLevels) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(4);
  ASSERT_EQ(split.level_count(), 4);
  for (int l = 0; l <= 4; ++l) {
    const LevelCounts counts = split.counts(l);
    EXPECT_EQ(counts.vertices, split.level(l).GetNumVertices());
    EXPECT_EQ(counts.faces, split.level(l).GetNumFaces());
    if (l < 4) {
      EXPECT_EQ(counts.edges, split.level(l).GetNumEdges());
    }
  }
}

TEST(QuadSplit, ChildFacesFollowTheirParentsCorners) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(3);
  for (int l = 0; l < 3; ++l) {
    const auto& parent = split.level(l);
    const auto& child = split.level(l + 1);
    for (int f = 0; f < parent.GetNumFaces(); ++f) {
      const auto vertices = parent.GetFaceVertices(f);
      const auto children = parent.GetFaceChildFaces(f);
      ASSERT_EQ(children.size(), vertices.size());
      for (int i = 0; i < vertices.size(); ++i) {
        EXPECT_EQ(children[i], split.first_corner(l, f) + i);
        const auto corners = child.GetFaceVertices(children[i]);
        EXPECT_EQ(std::count(corners.begin(), corners.end(), vertices[i]), 1)
            << "a child face has the vertex of its corner, with the same index";
      }
    }
  }
}

TEST(QuadSplit, FacesAroundAVertexComeCounterClockwise) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(2);
  for (int l = 0; l < 2; ++l) {
    const auto& level = split.level(l);
    for (int v = 0; v < level.GetNumVertices(); ++v) {
      const auto faces = level.GetVertexFaces(v);
      const auto corners = level.GetVertexFaceLocalIndices(v);
      for (int i = 0; i + 1 < faces.size(); ++i) {
        const auto edges = level.GetFaceEdges(faces[i]);
        const int trailing = edges[(corners[i] + edges.size() - 1) % edges.size()];
        EXPECT_EQ(trailing, level.GetFaceEdges(faces[i + 1])[corners[i + 1]]);
      }
      if (level.IsVertexBoundary(v)) {
        EXPECT_TRUE(level.IsEdgeBoundary(level.GetFaceEdges(faces[0])[corners[0]]));
      }
    }
  }
}

TEST(QuadSplit, KeepsCreaseTagsAsSharpness) {
  PolygonMesh mesh = triangle_and_pentagon();
  mesh.creases = {{2, 1, kInfiniteSharpness}};
  const QuadSplit split(mesh);
  const auto& base = split.level(0);
  int sharp = 0;
  for (int e = 0; e < base.GetNumEdges(); ++e) {
    if (base.IsEdgeBoundary(e) || base.GetEdgeSharpness(e) < kInfiniteSharpness) continue;
    ++sharp;
    const auto ends = base.GetEdgeVertices(e);
    EXPECT_EQ(std::min(ends[0], ends[1]), 1);
    EXPECT_EQ(std::max(ends[0], ends[1]), 2);
  }
  EXPECT_EQ(sharp, 1);
}

TEST(QuadSplit, RefinesAgainAfterwards) {
  QuadSplit split(triangle_and_pentagon());
  split.refine(2);
  split.refine(0);
  EXPECT_EQ(split.level_count(), 0);
  split.refine(1);
  EXPECT_EQ(split.level_count(), 1);
  EXPECT_EQ(split.level(1).GetNumFaces(), 8);
}

}  // namespace
}  // namespace planish::test
