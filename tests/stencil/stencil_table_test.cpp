#include "planish/solve/far_tables.h"

#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>

#include <array>
#include <vector>

namespace planish {
namespace {

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

}  // namespace
}  // namespace planish
