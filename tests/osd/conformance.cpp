#include "osd/conformance.h"

#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include "planish/osd/vk_compute_evaluator.h"

namespace planish::testing {

using namespace OpenSubdiv;
using osd::VkComputeEvaluator;
using osd::VkStencilTable;

void Conformance::stencils(const std::string& name, const Cage& cage,
                           const Far::StencilTable& table, const Layout& layout) {
  const int rows = table.GetNumStencils();
  if (rows == 0) return;
  Floats cpu(layout, cage, table.GetNumControlVertices(), rows, 1);
  const DeviceFloats gpu(cpu, context);
  const std::unique_ptr<VkStencilTable> device_table(VkStencilTable::Create(&table, &context));
  const auto& to = layout.destinations[0];

  ASSERT_TRUE(Osd::CpuEvaluator::EvalStencils(
      cpu.buffers[0].data(), layout.source, cpu.buffers[cpu.destination[0]].data(), to,
      table.GetSizes().data(), table.GetOffsets().data(), table.GetControlIndices().data(),
      table.GetWeights().data(), 0, rows));
  ASSERT_TRUE(VkComputeEvaluator::EvalStencils(gpu.buffers[0].get(), layout.source,
                                               gpu.destination(cpu, 0), to, device_table.get(),
                                               nullptr, &context));
  tally.compare(name + ", " + layout.name, cpu.buffers, gpu.read(context));
}

void Conformance::limit_stencils(const std::string& name, const Cage& cage,
                                 const Far::LimitStencilTable& table, const Layout& layout) {
  const int rows = table.GetNumStencils();
  if (rows == 0) return;
  Floats cpu(layout, cage, table.GetNumControlVertices(), rows, kDestinations);
  const DeviceFloats gpu(cpu, context);
  const std::unique_ptr<VkStencilTable> device_table(VkStencilTable::Create(&table, &context));
  const auto& to = layout.destinations;
  const auto at = [&](int i) { return cpu.buffers[cpu.destination[i]].data(); };

  ASSERT_TRUE(Osd::CpuEvaluator::EvalStencils(
      cpu.buffers[0].data(), layout.source, at(0), to[0], at(1), to[1], at(2), to[2], at(3), to[3],
      at(4), to[4], at(5), to[5], table.GetSizes().data(), table.GetOffsets().data(),
      table.GetControlIndices().data(), table.GetWeights().data(), table.GetDuWeights().data(),
      table.GetDvWeights().data(), table.GetDuuWeights().data(), table.GetDuvWeights().data(),
      table.GetDvvWeights().data(), 0, rows));
  ASSERT_TRUE(VkComputeEvaluator::EvalStencils(
      gpu.buffers[0].get(), layout.source, gpu.destination(cpu, 0), to[0], gpu.destination(cpu, 1),
      to[1], gpu.destination(cpu, 2), to[2], gpu.destination(cpu, 3), to[3],
      gpu.destination(cpu, 4), to[4], gpu.destination(cpu, 5), to[5], device_table.get(), nullptr,
      &context));
  tally.compare(name + ", " + layout.name, cpu.buffers, gpu.read(context));
}

}  // namespace planish::testing
