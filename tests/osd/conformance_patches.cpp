#include <gtest/gtest.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuPatchTable.h>

#include "osd/conformance.h"
#include "planish/osd/vk_compute_evaluator.h"

namespace planish::testing {

namespace {

using namespace OpenSubdiv;
using Far::PatchDescriptor;
using osd::VkComputeEvaluator;
using osd::VkPatchTable;
using osd::VkVertexBuffer;

/// Places on a patch; all lie on triangles as well, but for the last.
constexpr float kPlaces[][2] = {{0, 0}, {0.13f, 0.21f}, {0.3f, 0.7f},
                                {0, 1}, {0.5f, 0.25f},  {1, 1}};

bool is_triangle(int type) {
  return type == PatchDescriptor::TRIANGLES || type == PatchDescriptor::LOOP ||
         type == PatchDescriptor::GREGORY_TRIANGLE;
}

std::vector<Osd::PatchCoord> coords_on(const Far::PatchTable& table) {
  std::vector<Osd::PatchCoord> coords;
  int patch = 0;
  for (int array = 0; array < table.GetNumPatchArrays(); ++array) {
    const int size = table.GetPatchArrayDescriptor(array).GetNumControlVertices();
    const bool triangle = is_triangle(table.GetPatchArrayDescriptor(array).GetType());
    for (int local = 0; local < table.GetNumPatches(array); ++local, ++patch) {
      Far::PatchTable::PatchHandle handle;
      handle.arrayIndex = array;
      handle.patchIndex = patch;
      handle.vertIndex = local * size;
      const Far::PatchParam param = table.GetPatchParam(handle);
      for (const auto& [u, v] : kPlaces) {
        if (triangle && u + v > 1) continue;
        float s = u, t = v;
        if (triangle)
          param.UnnormalizeTriangle(s, t);
        else
          param.Unnormalize(s, t);
        coords.emplace_back(handle, s, t);
      }
    }
  }
  return coords;
}

/// One kind of a CpuPatchTable's patches.
struct CpuPatches {
  const Osd::PatchArray* arrays;
  const int* indices;
  const Osd::PatchParam* params;
};

CpuPatches patches_of(const Osd::CpuPatchTable& table, PatchKind kind) {
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

/// Counts what the coordinates meet.
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
  const CpuPatches patches = patches_of(cpu_table, kind);
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
