#include <gtest/gtest.h>
#include <oneapi/tbb/global_control.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>

#include <array>
#include <map>
#include <random>
#include <vector>

#include "planish/solve/far_tables.h"
#include "planish/solve/stencil_builder.h"

namespace planish {
namespace {

TEST(StencilRow, SortsAndMergesAsAMapWould) {
  std::mt19937 random(7);
  for (const int count : {0, 1, 5, 32, 33, 500}) {
    StencilRow row;
    std::map<int, double> expected;
    for (int i = 0; i < count; ++i) {
      const int index = static_cast<int>(random() % 40);
      const double weight = static_cast<double>(random() % 64);
      row.add(index, weight, 2 * weight, -weight);
      expected[index] += weight;
    }
    row.finish();
    ASSERT_EQ(row.entries().size(), expected.size());
    auto entry = row.entries().begin();
    for (const auto& [index, weight] : expected) {
      EXPECT_EQ(entry->index, index);
      EXPECT_EQ(entry->weight, weight);
      EXPECT_EQ(entry->du, 2 * weight);
      EXPECT_EQ(entry->dv, -weight);
      ++entry;
    }
  }
}

StencilTable build(std::int64_t first, std::int64_t count) {
  return build_rows(7, {first, count}, Derivatives::Yes, [] {
    return [](std::int32_t index, StencilRow& row) {
      for (std::int32_t k = 0; k <= index % 7; ++k) row.add(k, index + 0.1 * k, k, index);
    };
  });
}

TEST(BuildRows, IsTheSameForAnyThreadCount) {
  const auto parallel = build(0, 100000);
  const oneapi::tbb::global_control one(oneapi::tbb::global_control::max_allowed_parallelism, 1);
  const auto serial = build(0, 100000);
  EXPECT_EQ(parallel.sizes, serial.sizes);
  EXPECT_EQ(parallel.indices, serial.indices);
  EXPECT_EQ(parallel.weights, serial.weights);
  EXPECT_EQ(parallel.du_weights, serial.du_weights);
  EXPECT_EQ(parallel.dv_weights, serial.dv_weights);
}

TEST(BuildRows, SlicesJoinToTheWhole) {
  const auto whole = build(0, 20000);
  auto joined = build(0, 9000);
  const auto rest = build(9000, 11000);
  joined.weights.insert(joined.weights.end(), rest.weights.begin(), rest.weights.end());
  joined.sizes.insert(joined.sizes.end(), rest.sizes.begin(), rest.sizes.end());
  EXPECT_EQ(joined.weights, whole.weights);
  EXPECT_EQ(joined.sizes, whole.sizes);
}

TEST(BuildRows, MakesAnEmptyTableOfNoRows) {
  const auto rows = build(0, 0);
  EXPECT_TRUE(rows.sizes.empty());
  EXPECT_TRUE(rows.weights.empty());
}

// A primvar of OpenSubdiv's protocol.
struct Value {
  double v = 0;
  void Clear() { v = 0; }
  void AddWithWeight(const Value& other, double weight) { v += weight * other.v; }
};

StencilTable three_rows() {
  StencilTable rows;
  rows.sizes = {2, 0, 3};
  rows.indices = {0, 2, 0, 1, 2};
  rows.weights = {0.25, 0.75, 1, -2, 3};
  rows.close(3);
  return rows;
}

TEST(StencilTable, UpdatesValuesThroughOpenSubdiv) {
  const auto table = to_far<double>(three_rows().view());
  const std::array<Value, 3> source{{{1.0}, {10.0}, {100.0}}};
  std::array<Value, 3> target;
  table->UpdateValues(source.data(), target.data());
  EXPECT_DOUBLE_EQ(target[0].v, 75.25);
  EXPECT_DOUBLE_EQ(target[1].v, 0.0);
  EXPECT_DOUBLE_EQ(target[2].v, 281.0);
}

TEST(StencilTable, ServesOpenSubdivsEvaluator) {
  const auto table = to_far<float>(three_rows().view());
  const std::array<float, 3> source{1, 10, 100};
  std::array<float, 3> target{};
  const OpenSubdiv::Osd::BufferDescriptor descriptor(0, 1, 1);
  const OpenSubdiv::Far::StencilTable& far_table = *table;
  ASSERT_TRUE(OpenSubdiv::Osd::CpuEvaluator::EvalStencils(
      source.data(), descriptor, target.data(), descriptor, far_table.GetSizes().data(),
      far_table.GetOffsets().data(), far_table.GetControlIndices().data(),
      far_table.GetWeights().data(), 0, 3));
  EXPECT_FLOAT_EQ(target[0], 75.25f);
  EXPECT_FLOAT_EQ(target[1], 0.0f);
  EXPECT_FLOAT_EQ(target[2], 281.0f);
}

TEST(StencilTable, ViewShowsTheRows) {
  const StencilTable table = three_rows();
  const StencilView<double> view = table.view();
  EXPECT_EQ(view.source_count, 3);
  EXPECT_EQ(view.row_count(), 3);
  EXPECT_EQ(view.offsets[2], 2);
  EXPECT_EQ(view.weights[4], 3.0);
}

TEST(StencilTable, LeavesOutGapsBetweenRowsForOpenSubdiv) {
  StencilTable rows = three_rows();
  rows.indices.insert(rows.indices.begin() + 2, {7, 7});
  rows.weights.insert(rows.weights.begin() + 2, {9, 9});
  rows.offsets = {0, 3, 4};
  const auto table = to_far<double>(rows.view());
  EXPECT_EQ(table->GetOffsets(), (std::vector<int>{0, 2, 2}));
  EXPECT_EQ(table->GetControlIndices(), (std::vector<int>{0, 2, 0, 1, 2}));
  EXPECT_EQ(table->GetWeights(), (std::vector<double>{0.25, 0.75, 1, -2, 3}));
}

TEST(StencilTable, GivesDerivativesThroughOpenSubdiv) {
  StencilTable rows = three_rows();
  rows.du_weights = {1, 2, 3, 4, 5};
  rows.dv_weights = {5, 4, 3, 2, 1};
  const auto table = to_far_limit<double>(rows.view());
  const std::array<Value, 3> source{{{1.0}, {10.0}, {100.0}}};
  std::array<Value, 3> values, du, dv;
  table->UpdateValues(source.data(), values.data());
  table->UpdateDerivs(source.data(), du.data(), dv.data());
  EXPECT_DOUBLE_EQ(values[2].v, 281.0);
  EXPECT_DOUBLE_EQ(du[0].v, 201.0);
  EXPECT_DOUBLE_EQ(du[2].v, 543.0);
  EXPECT_DOUBLE_EQ(dv[2].v, 123.0);
  EXPECT_EQ(rows.view().dv_weights[1], 4.0);
}

TEST(StencilTable, AppliesItsRowsToPoints) {
  StencilTable rows = three_rows();
  rows.indices.insert(rows.indices.begin() + 2, {7, 7});
  rows.weights.insert(rows.weights.begin() + 2, {9, 9});
  rows.offsets = {0, 3, 4};
  const std::array<glm::dvec3, 3> source{{{1, 2, 3}, {10, 20, 30}, {100, 200, 300}}};
  std::array<glm::dvec3, 3> target;
  target.fill(glm::dvec3(5));
  apply(rows.view(), source, target);
  EXPECT_EQ(target[0], glm::dvec3(75.25, 150.5, 225.75));
  EXPECT_EQ(target[1], glm::dvec3(0));
  EXPECT_EQ(target[2], glm::dvec3(281, 562, 843));
}

TEST(StencilTable, LimitNormalsAreUnitOrZeroWhereTangentsAreParallel) {
  StencilTable table;
  table.sizes = {3, 3};
  table.indices = {0, 1, 2, 0, 1, 2};
  table.weights = {1, 0, 0, 0, 0.5, 0.5};
  table.du_weights = {-1, 1, 0, -1, 1, 0};
  table.dv_weights = {-1, 0, 1, -2, 2, 0};
  table.close(3);
  const std::array<glm::dvec3, 3> source{{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}}};
  std::array<glm::dvec3, 2> positions;
  std::array<glm::vec3, 2> normals;
  apply_limit(table.view(), source, positions, normals);
  EXPECT_EQ(positions[1], glm::dvec3(1, 1.5, 0));
  EXPECT_EQ(normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(normals[1], glm::vec3(0, 0, 0));
}

}  // namespace
}  // namespace planish
