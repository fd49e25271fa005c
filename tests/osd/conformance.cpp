#include "osd/conformance.h"

#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "planish/osd/vk_compute_evaluator.h"

namespace planish::testing {
namespace {

using OpenSubdiv::Osd::BufferDescriptor;

// Of the largest magnitude in a buffer.
constexpr double kTolerance = 1e-6;
constexpr float kMark = 0.75f;

Layout apart(const std::string& name, BufferDescriptor source, BufferDescriptor destination) {
  Layout layout{name};
  layout.source = source;
  for (int i = 0; i < kDestinations; ++i) {
    layout.destinations[i] = destination;
    layout.destinations[i].offset += 3 * i;
    layout.destinations[i].stride += i;
  }
  return layout;
}

Layout together(const std::string& name, BufferDescriptor source, bool in_place) {
  Layout layout{name, true, in_place};
  layout.source = source;
  const int length = source.length;
  const int stride = in_place ? source.stride : kDestinations * length + 1;
  for (int i = 0; i < kDestinations; ++i)
    layout.destinations[i] = {i * length + (in_place ? length : 1), length, stride};
  return layout;
}

std::size_t end_of(const BufferDescriptor& desc, int count) {
  return count > 0 ? place(desc, count - 1, desc.length) : 0;
}

}  // namespace

std::vector<Layout> all_layouts() {
  return {apart("tight 3", {0, 3, 3}, {0, 3, 3}),  apart("gaps 3", {2, 3, 8}, {5, 3, 11}),
          apart("tight 4", {0, 4, 4}, {0, 4, 4}),  apart("one float", {0, 1, 1}, {3, 1, 4}),
          apart("far 7", {70, 7, 9}, {131, 7, 7}), together("one destination 5", {1, 5, 6}, false),
          together("in place 2", {0, 2, 14}, true)};
}

std::vector<Layout> patch_layouts() {
  const std::vector<Layout> all = all_layouts();
  return {all[1], all[5], all[6]};
}

Floats::Floats(const Layout& layout, const Cage& cage, int sources, int rows, int count) {
  std::size_t source_end = end_of(layout.source, sources);
  buffers.resize(1);
  for (int i = 0; i < count; ++i) {
    destination[i] = layout.in_place ? 0 : layout.one_destination ? 1 : 1 + std::size_t(i);
    buffers.resize(std::max(buffers.size(), destination[i] + 1));
    std::vector<float>& buffer = buffers[destination[i]];
    buffer.resize(std::max(buffer.size(), end_of(layout.destinations[i], rows)), kMark);
  }
  buffers[0].resize(std::max(buffers[0].size(), source_end), kMark);
  for (int i = 0; i < sources; ++i)
    for (int c = 0; c < layout.source.length; ++c) {
      const std::size_t vertex = i % cage.positions.size();
      const int copy = c / 3;
      buffers[0][place(layout.source, i, c)] =
          cage.positions[vertex][c % 3] + 0.25f * static_cast<float>(copy) * (vertex % 5);
    }
}

DeviceFloats::DeviceFloats(const Floats& floats, osd::VkDeviceContext& context) {
  for (const std::vector<float>& buffer : floats.buffers) {
    const int size = static_cast<int>(buffer.size());
    buffers.emplace_back(osd::VkVertexBuffer::Create(1, size, &context));
    buffers.back()->UpdateData(buffer.data(), 0, size, &context);
  }
}

std::vector<std::vector<float>> DeviceFloats::read(osd::VkDeviceContext& context) const {
  std::vector<std::vector<float>> result;
  for (const auto& buffer : buffers) {
    result.emplace_back(buffer->GetNumVertices());
    buffer->ReadData(result.back().data(), 0, buffer->GetNumVertices(), &context);
  }
  return result;
}

void Tally::compare(const std::string& name, const std::vector<std::vector<float>>& expected,
                    const std::vector<std::vector<float>>& got) {
  ++evaluations;
  ASSERT_EQ(expected.size(), got.size()) << name;
  for (std::size_t b = 0; b < expected.size(); ++b) {
    ASSERT_EQ(expected[b].size(), got[b].size()) << name;
    double magnitude = 0, difference = 0;
    for (std::size_t i = 0; i < expected[b].size(); ++i) {
      ASSERT_TRUE(std::isfinite(expected[b][i])) << name << ", buffer " << b << ", float " << i;
      magnitude = std::max(magnitude, std::abs(double(expected[b][i])));
      // Not-a-numbers compare to nothing: count them as far off.
      const double off = std::abs(double(expected[b][i]) - double(got[b][i]));
      difference = std::max(difference, std::isnan(off) ? HUGE_VAL : off);
      if (off == 0) {
        ASSERT_EQ(std::signbit(expected[b][i]), std::signbit(got[b][i])) << name << i;
      }
    }
    floats += static_cast<long long>(expected[b].size());
    EXPECT_LE(difference, kTolerance * magnitude) << name << ", buffer " << b;
    if (magnitude > 0) largest = std::max(largest, difference / magnitude);
  }
}

void Tally::print() const {
  std::printf(
      "%d meshes, %lld evaluations, %lld floats compared, largest difference %.3g of the "
      "largest magnitude in the buffer\n",
      cages, evaluations, floats, largest);
}

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

namespace {

using osd::VkPatchTable;
using osd::VkVertexBuffer;

// Places on a patch; all lie on triangles as well, but for the last.
constexpr float kPlaces[][2] = {{0, 0}, {0.13f, 0.21f}, {0.3f, 0.7f},
                                {0, 1}, {0.5f, 0.25f},  {1, 1}};

std::vector<Osd::PatchCoord> coords_on(const Far::PatchTable& table) {
  std::vector<Osd::PatchCoord> coords;
  for (const Patch& patch : patches_of(table))
    for (const auto& [u, v] : kPlaces)
      if (!patch.is_triangle() || u + v <= 1) coords.push_back(patch.coord(u, v));
  return coords;
}

// One kind of a CpuPatchTable's patches.
struct CpuPatches {
  const Osd::PatchArray* arrays;
  const int* indices;
  const Osd::PatchParam* params;
};

CpuPatches cpu_patches_of(const Osd::CpuPatchTable& table, PatchKind kind) {
  if (kind == PatchKind::Vertex)
    return {table.GetPatchArrayBuffer(), table.GetPatchIndexBuffer(), table.GetPatchParamBuffer()};
  if (kind == PatchKind::Varying)
    return {table.GetVaryingPatchArrayBuffer(), table.GetVaryingPatchIndexBuffer(),
            table.GetPatchParamBuffer()};
  return {table.GetFVarPatchArrayBuffer(), table.GetFVarPatchIndexBuffer(),
          table.GetFVarPatchParamBuffer()};
}

const Far::StencilTable& stencils_of(const Refined& refined, PatchKind kind) {
  return kind == PatchKind::Vertex    ? *refined.vertices
         : kind == PatchKind::Varying ? *refined.varying
                                      : *refined.face_varying;
}

// Counts what the coordinates meet.
void note_types(Conformance& conformance, const CpuPatches& patches,
                const std::vector<Osd::PatchCoord>& coords) {
  for (const Osd::PatchCoord& coord : coords) {
    const Osd::PatchArray& array = patches.arrays[coord.handle.arrayIndex];
    const Osd::PatchParam& param = patches.params[coord.handle.patchIndex];
    conformance.patch_types.insert(param.IsRegular() ? array.GetPatchTypeRegular()
                                                     : array.GetPatchTypeIrregular());
    if (param.sharpness > 0) ++conformance.sharp_patches;
    if (param.GetBoundary() != 0) ++conformance.boundary_patches;
  }
}

}  // namespace

void Conformance::patches(const std::string& name, const Cage& cage, const Refined& refined,
                          PatchKind kind, const Layout& layout) {
  const std::vector<Osd::PatchCoord> coords = coords_on(*refined.patches);
  const int count = static_cast<int>(coords.size());
  if (count == 0) return;
  const Far::StencilTable& table = stencils_of(refined, kind);
  const int coarse = table.GetNumControlVertices(), rows = table.GetNumStencils();
  Floats cpu(layout, cage, coarse + rows, count, kDestinations);
  Osd::BufferDescriptor refined_desc = layout.source;
  refined_desc.offset += coarse * layout.source.stride;
  Osd::CpuEvaluator::EvalStencils(cpu.buffers[0].data(), layout.source, cpu.buffers[0].data(),
                                  refined_desc, table.GetSizes().data(), table.GetOffsets().data(),
                                  table.GetControlIndices().data(), table.GetWeights().data(), 0,
                                  rows);
  const DeviceFloats gpu(cpu, context);
  const std::unique_ptr<VkVertexBuffer> device_coords(VkVertexBuffer::Create(5, count, &context));
  device_coords->UpdateData(reinterpret_cast<const float*>(coords.data()), 0, count, &context);
  const std::unique_ptr<VkPatchTable> device_table(
      VkPatchTable::Create(refined.patches.get(), &context));
  const Osd::CpuPatchTable cpu_table(refined.patches.get());
  const CpuPatches patches = cpu_patches_of(cpu_table, kind);
  if (!patches.indices) {
    // Uniform tables have no varying patches; Osd::CpuEvaluator crashes where ours refuses.
    EXPECT_EQ(device_table->GetVaryingPatches(), nullptr) << name;
    return;
  }
  note_types(*this, patches, coords);

  const auto& to = layout.destinations;
  const auto at = [&](int i) { return cpu.buffers[cpu.destination[i]].data(); };
  ASSERT_TRUE(Osd::CpuEvaluator::EvalPatches(cpu.buffers[0].data(), layout.source, at(0), to[0],
                                             at(1), to[1], at(2), to[2], at(3), to[3], at(4), to[4],
                                             at(5), to[5], count, coords.data(), patches.arrays,
                                             patches.indices, patches.params));
  const auto evaluate = [&](auto function, auto... last) {
    return function(gpu.buffers[0].get(), layout.source, gpu.destination(cpu, 0), to[0],
                    gpu.destination(cpu, 1), to[1], gpu.destination(cpu, 2), to[2],
                    gpu.destination(cpu, 3), to[3], gpu.destination(cpu, 4), to[4],
                    gpu.destination(cpu, 5), to[5], count, device_coords.get(), device_table.get(),
                    last..., nullptr, &context);
  };
  const bool done =
      kind == PatchKind::Vertex
          ? evaluate([](auto... a) { return VkComputeEvaluator::EvalPatches(a...); })
      : kind == PatchKind::Varying
          ? evaluate([](auto... a) { return VkComputeEvaluator::EvalPatchesVarying(a...); })
          : evaluate([](auto... a) { return VkComputeEvaluator::EvalPatchesFaceVarying(a...); }, 0);
  ASSERT_TRUE(done);
  tally.compare(name + ", " + layout.name, cpu.buffers, gpu.read(context));
}

}  // namespace planish::testing
