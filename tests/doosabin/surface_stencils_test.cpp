#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <vector>

#include "support/doo_sabin_tables.h"
#include "support/meshes.h"

namespace planish::test {
namespace {

std::vector<glm::dvec3> apply_table(const StencilView<double>& table,
                                    const std::vector<glm::dvec3>& source) {
  std::vector<glm::dvec3> target(static_cast<std::size_t>(table.row_count()), glm::dvec3(0.0));
  for (std::int32_t i = 0; i < table.row_count(); ++i) {
    for (std::int32_t k = table.offsets[i]; k < table.offsets[i] + table.sizes[i]; ++k) {
      target[i] += table.weights[k] * source[table.indices[k]];
    }
  }
  return target;
}

// A grid with a crease that ends inside, a T-junction, and tagged corners.
PolygonMesh feature_rich_grid() {
  PolygonMesh mesh =
      grid(6, 6, [](double x, double y) { return glm::dvec3(x, y, 0.2 * x * x - 0.1 * x * y); });
  const auto at = [](int i, int j) { return j * 7 + i; };
  mesh.creases = {{at(3, 0), at(3, 1), 10}, {at(3, 1), at(3, 2), 10}, {at(3, 2), at(3, 3), 10}};
  mesh.corners = {{at(6, 6), 10}, {at(5, 5), 10}};
  return mesh;
}

TEST(SurfaceTables, RowsOfEveryTableSumToOne) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(3);
  for (const Weights weights : {Weights::DooSabin, Weights::Averaged}) {
    const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
    const SubdivisionChain subdivision(split, features, weights);
    const auto expect_sums = [](const StencilView<double>& view) {
      for (std::int32_t i = 0; i < view.row_count(); ++i) {
        double sum = 0;
        for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
          sum += view.weights[k];
        }
        ASSERT_NEAR(sum, 1.0, 1e-14) << "row " << i;
      }
    };
    expect_sums(step_table(subdivision, 1).view());
    expect_sums(step_table(subdivision, 2).view());
    const LimitRows rows(subdivision, 2);
    const auto limit = limit_table(subdivision, rows);
    expect_sums(limit.view());
    const auto view = limit.view();
    for (std::int32_t i = 0; i < view.row_count(); ++i) {
      double du = 0, dv = 0;
      for (int k = view.offsets[i]; k < view.offsets[i] + view.sizes[i]; ++k) {
        du += view.du_weights[k];
        dv += view.dv_weights[k];
      }
      ASSERT_NEAR(du, 0.0, 1e-14) << "row " << i;
      ASSERT_NEAR(dv, 0.0, 1e-14) << "row " << i;
    }
  }
}

TEST(LimitRows, AddOneRowForEachFurtherSectorOfACrease) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(1);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const SubdivisionChain subdivision(split, features, Weights::DooSabin);
  const std::int64_t vertex_count = split.counts(1).vertices;
  const LimitRows rows(subdivision, 1);
  // T-junction, two crease vertices and three edge midpoints; the dart has one normal.
  EXPECT_EQ(rows.count(), vertex_count + 6);

  VertexRing ring;
  const auto& level = split.level(1);
  const std::int32_t crease_vertex = 7 + 3;
  std::vector<std::int32_t> seen;
  for (int f = 0; f < level.GetNumFaces(); ++f) {
    const auto vertices = level.GetFaceVertices(f);
    for (int k = 0; k < 4; ++k) {
      if (vertices[k] != crease_vertex) continue;
      const std::int32_t row = rows.row_of(crease_vertex, f, ring);
      EXPECT_EQ(rows.place(row).vertex, crease_vertex);
      seen.push_back(row);
    }
  }
  std::sort(seen.begin(), seen.end());
  ASSERT_EQ(seen.size(), 4u);
  EXPECT_EQ(seen[0], seen[1]);
  EXPECT_EQ(seen[0], crease_vertex);
  EXPECT_EQ(seen[2], seen[3]);
  EXPECT_GE(seen[2], vertex_count);
}

TEST(SurfaceTables, SlicesEqualTheWholeTable) {
  const PolygonMesh mesh = feature_rich_grid();
  QuadSplit split(mesh);
  split.refine(2);
  const SharpFeatures features = find_sharp_features(mesh, split.topology(), mesh.positions, {});
  const SubdivisionChain subdivision(split, features, Weights::DooSabin);
  const std::int64_t size = subdivision.state_layout(2).size;
  const auto state = apply_table(step_table(subdivision, 1).view(), mesh.positions);
  const auto whole = apply_table(step_table(subdivision, 2).view(), state);
  const auto head = apply_table(step_table(subdivision, 2, {0, 100}).view(), state);
  const auto tail = apply_table(step_table(subdivision, 2, {100, size - 100}).view(), state);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(whole[i], i < 100 ? head[i] : tail[i - 100]);
  }
}

}  // namespace
}  // namespace planish::test
