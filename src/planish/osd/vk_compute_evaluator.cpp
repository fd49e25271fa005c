#include "planish/osd/vk_compute_evaluator.h"

#include <opensubdiv/osd/bufferDescriptor.h>
#include <opensubdiv/osd/cpuPatchTable.h>
#include <opensubdiv/osd/types.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/osd/vk_device_context.h"
#include "planish/osd/vk_patch_evaluator.h"
#include "planish/osd/vk_patch_shader_source.h"
#include "planish/osd/vk_patch_table.h"
#include "planish/osd/vk_stencil_table.h"
#include "planish/solve/stencil_table.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/tables/device_table.h"
#include "shaders/osd_patches_text.h"
#include "shaders/shared.h"

namespace planish::osd {

// One kind of a patch table's patches, as shaders/evaluate/elements.comp reads them.
struct PatchBuffers {
  OpenSubdiv::Osd::PatchArrayVector patchArrays;
  int numPoints = 0;  // elements that the patches read: the highest index + 1
  vulkan::Buffer arrays, indices;
  std::shared_ptr<vulkan::Buffer> params;  // vertex and varying patches have the same ones
};

namespace {

using OpenSubdiv::Osd::PatchArray;
using OpenSubdiv::Osd::PatchArrayVector;
using OpenSubdiv::Osd::PatchParam;
using OpenSubdiv::Osd::PatchParamVector;

static_assert(sizeof(OpenSubdiv::Osd::PatchCoord) ==
              vulkan::shared::kPatchCoordWords * sizeof(float));
static_assert(sizeof(PatchParam) == vulkan::shared::kPatchParamWords * sizeof(float));

vulkan::Buffer Upload(std::span<std::byte const> bytes, char const* name,
                      VkDeviceContext& deviceContext) {
  vulkan::Context& context = deviceContext.GetContext();
  vulkan::Buffer buffer = vulkan::make_bindable(context, bytes.size(), name);
  deviceContext.Upload(buffer.handle(), 0, bytes);
  return buffer;
}

std::shared_ptr<vulkan::Buffer> MakeParamBuffer(PatchParamVector const& params,
                                                VkDeviceContext& deviceContext) {
  return std::make_shared<vulkan::Buffer>(
      Upload(std::as_bytes(std::span(params)), "planish patch parameters", deviceContext));
}

// Uploads. Throws planish::Error{OutOfMemory}, naming the limit.
std::shared_ptr<PatchBuffers> MakePatchBuffers(PatchArrayVector const& patchArrays,
                                               std::span<int const> indices,
                                               std::shared_ptr<vulkan::Buffer> params,
                                               VkDeviceContext& deviceContext) {
  auto patches = std::make_shared<PatchBuffers>();
  patches->patchArrays = patchArrays;
  if (!indices.empty()) patches->numPoints = *std::max_element(indices.begin(), indices.end()) + 1;
  std::vector<int> words;
  for (PatchArray const& array : patchArrays)
    words.insert(words.end(),
                 {array.GetPatchTypeRegular(), array.GetPatchTypeIrregular(), array.GetNumPatches(),
                  array.GetIndexBase(), array.GetStride(), array.GetPrimitiveIdBase()});
  patches->arrays = Upload(std::as_bytes(std::span(words)), "planish patch arrays", deviceContext);
  patches->indices = Upload(std::as_bytes(indices), "planish patch indices", deviceContext);
  patches->params = std::move(params);
  return patches;
}

// OpenSubdiv's own conversion of a Far::PatchTable.
struct Converted : OpenSubdiv::Osd::CpuPatchTable {
  using CpuPatchTable::_fvarIndexBuffers;
  using CpuPatchTable::_fvarParamBuffers;
  using CpuPatchTable::_fvarPatchArrays;
  using CpuPatchTable::_indexBuffer;
  using CpuPatchTable::_patchArrays;
  using CpuPatchTable::_patchParamBuffer;
  using CpuPatchTable::_varyingIndexBuffer;
  using CpuPatchTable::_varyingPatchArrays;
  using CpuPatchTable::CpuPatchTable;
};

PatchArrayVector const kNoArrays;

}  // namespace

VkPatchTable* VkPatchTable::Create(OpenSubdiv::Far::PatchTable const* patchTable,
                                   VkDeviceContext* deviceContext) {
  Converted const from(patchTable);
  std::unique_ptr<VkPatchTable> result(new VkPatchTable(*deviceContext));
  auto const params = MakeParamBuffer(from._patchParamBuffer, *deviceContext);
  result->_patches = MakePatchBuffers(from._patchArrays, from._indexBuffer, params, *deviceContext);
  if (!from._varyingIndexBuffer.empty())
    result->_varyingPatches = MakePatchBuffers(from._varyingPatchArrays, from._varyingIndexBuffer,
                                               params, *deviceContext);
  for (std::size_t i = 0; i < from._fvarPatchArrays.size(); ++i)
    result->_fvarPatches.push_back(MakePatchBuffers(
        from._fvarPatchArrays[i], from._fvarIndexBuffers[i],
        MakeParamBuffer(from._fvarParamBuffers[i], *deviceContext), *deviceContext));
  return result.release();
}

VkPatchTable::~VkPatchTable() {
  _deviceContext.Retire(_patches);
  _deviceContext.Retire(_varyingPatches);
  for (auto const& patches : _fvarPatches) _deviceContext.Retire(patches);
}

PatchArrayVector const& VkPatchTable::GetPatchArrays() const { return _patches->patchArrays; }

VkBuffer VkPatchTable::GetPatchIndexBuffer() const { return _patches->indices.handle(); }

VkBuffer VkPatchTable::GetPatchParamBuffer() const { return _patches->params->handle(); }

PatchArrayVector const& VkPatchTable::GetVaryingPatchArrays() const {
  return _varyingPatches ? _varyingPatches->patchArrays : kNoArrays;
}

VkBuffer VkPatchTable::GetVaryingPatchIndexBuffer() const {
  return _varyingPatches ? _varyingPatches->indices.handle() : VK_NULL_HANDLE;
}

PatchArrayVector const& VkPatchTable::GetFVarPatchArrays(int fvarChannel) const {
  PatchBuffers const* const patches = GetFVarPatches(fvarChannel);
  return patches ? patches->patchArrays : kNoArrays;
}

VkBuffer VkPatchTable::GetFVarPatchIndexBuffer(int fvarChannel) const {
  PatchBuffers const* const patches = GetFVarPatches(fvarChannel);
  return patches ? patches->indices.handle() : VK_NULL_HANDLE;
}

VkBuffer VkPatchTable::GetFVarPatchParamBuffer(int fvarChannel) const {
  PatchBuffers const* const patches = GetFVarPatches(fvarChannel);
  return patches ? patches->params->handle() : VK_NULL_HANDLE;
}

PatchBuffers const* VkPatchTable::GetFVarPatches(int fvarChannel) const {
  return fvarChannel >= 0 && fvarChannel < GetNumFVarChannels() ? _fvarPatches[fvarChannel].get()
                                                                : nullptr;
}

using OpenSubdiv::Far::PatchDescriptor;

std::string VkPatchShaderSource::GetPatchDrawingShaderSource(PatchDescriptor::Type type) {
  switch (type) {
    case PatchDescriptor::QUADS:
    case PatchDescriptor::TRIANGLES:
    case PatchDescriptor::LOOP:
    case PatchDescriptor::REGULAR:
    case PatchDescriptor::GREGORY_BASIS:
    case PatchDescriptor::GREGORY_TRIANGLE:
      return "#define OSD_PATCH_TYPE " + std::to_string(type) + "\n" + kPatchesText +
             kTessellationText;
    default:
      return {};
  }
}

namespace {

using OpenSubdiv::Far::LimitStencilTable;
using OpenSubdiv::Far::StencilTable;
using AnyStencilTable = OpenSubdiv::Far::StencilTableReal<float>;

// A table's rows without weights. Offsets are made: OpenSubdiv's factories leave them out on
// request.
class Rows {
 public:
  explicit Rows(AnyStencilTable const& table) {
    _view.source_count = table.GetNumControlVertices();
    _view.sizes = table.GetSizes();
    _view.indices = table.GetControlIndices();
    _offsets.resize(_view.sizes.size());
    std::exclusive_scan(_view.sizes.begin(), _view.sizes.end(), _offsets.begin(), 0);
    _view.offsets = _offsets;
    for (std::size_t i = 0; i < _view.indices.size(); ++i)
      if (_view.indices[i] < 0 || _view.indices[i] >= _view.source_count)
        throw Error(ErrorCode::InvalidArgument,
                    formatted("stencil table: entry {} reads vertex {} of {} control vertices; set "
                              "factorizeIntermediateLevels",
                              i, _view.indices[i], _view.source_count),
                    static_cast<std::int64_t>(i));
  }

  /// Null where there are no such weights.
  std::unique_ptr<vulkan::DeviceTable> Upload(std::vector<float> const& weights,
                                              VkDeviceContext& deviceContext) {
    // OpenSubdiv may leave more weights than entries.
    if (weights.size() < _view.indices.size()) return nullptr;
    _view.weights = std::span(weights).first(_view.indices.size());
    vulkan::DeviceTableOptions options;
    // Strides are known to evaluators only: they cut rows where a binding would span too much.
    options.source_stride = options.target_stride = sizeof(float);
    auto table = std::make_unique<vulkan::DeviceTable>(deviceContext.GetContext(), _view, options);
    for (std::size_t i = 0; i < table->slices().size(); ++i) {
      vulkan::DeviceTable::Slice const& slice = table->slices()[i];
      vulkan::PackedSlice const packed = table->pack(i, _view);
      deviceContext.Upload(slice.chunks.handle(), 0, std::as_bytes(std::span(packed.chunks)));
      deviceContext.Upload(slice.entries.handle(), 0, std::as_bytes(std::span(packed.entries)));
    }
    table->finish_packing();
    return table;
  }

 private:
  StencilView<float> _view;
  std::vector<int> _offsets;
};

}  // namespace

VkStencilTable::VkStencilTable(AnyStencilTable const& table, VkDeviceContext& deviceContext)
    : _numStencils(table.GetNumStencils()),
      _numControlVertices(table.GetNumControlVertices()),
      _deviceContext(deviceContext) {}

VkStencilTable::~VkStencilTable() {
  for (auto const& weights : _weights)
    if (weights) _deviceContext.Retire(weights);
}

vulkan::DeviceTable const* VkStencilTable::GetWeights(StencilWeights weights) const {
  return _weights[static_cast<std::size_t>(weights)].get();
}

VkStencilTable* VkStencilTable::Create(StencilTable const* table, VkDeviceContext* deviceContext) {
  std::unique_ptr<VkStencilTable> result(new VkStencilTable(*table, *deviceContext));
  result->_weights[0] = Rows(*table).Upload(table->GetWeights(), *deviceContext);
  return result.release();
}

VkStencilTable* VkStencilTable::Create(LimitStencilTable const* table,
                                       VkDeviceContext* deviceContext) {
  std::unique_ptr<VkStencilTable> result(new VkStencilTable(*table, *deviceContext));
  Rows rows(*table);
  std::vector<float> const* const weights[] = {&table->GetWeights(),    &table->GetDuWeights(),
                                               &table->GetDvWeights(),  &table->GetDuuWeights(),
                                               &table->GetDuvWeights(), &table->GetDvvWeights()};
  for (int i = 0; i < kStencilWeightsCount; ++i)
    result->_weights[i] = rows.Upload(*weights[i], *deviceContext);
  return result.release();
}

namespace {

// Where patches are evaluated: Osd::PatchCoord, `count` of them from the buffer's start on.
struct PatchCoords {
  VkBuffer buffer = VK_NULL_HANDLE;
  int count = 0;
};

// Element i of the target = the patch at coordinate i, or a derivative of it: 0 value, 1 du, 2 dv,
// 3 duu, 4 duv, 5 dvv. Zero where the coordinate names no patch of a type that
// Osd::CpuEvaluator evaluates. Patches and buffers outlive it.
class PatchPass {
 public:
  // Both sides have the same length. Throws planish::Error{OutOfMemory} naming the limit that the
  // patches' points exceed.
  PatchPass(vulkan::Context& context, PatchBuffers const& patches, PatchCoords const& coords,
            vulkan::FloatElements const& source, vulkan::FloatElements const& target,
            int derivative);

  // Only records, within vulkan::kEntryScope and kExitScope.
  void record(VkCommandBuffer commands) const noexcept;

 private:
  struct Dispatch {
    vulkan::shared::PatchParameters parameters;
    std::uint32_t groups;
  };

  vulkan::Context& _context;
  vulkan::Pipeline _pipeline;
  std::vector<Dispatch> _dispatches;
  vulkan::DescriptorSets _sets;
};

namespace shared = vulkan::shared;

constexpr std::uint32_t kGroupSize = 64;
constexpr std::uint64_t kCoordBytes = shared::kPatchCoordWords * sizeof(float);
static_assert(kGroupSize * kCoordBytes % vulkan::kBindingAlignment == 0);

PatchPass::PatchPass(vulkan::Context& context, PatchBuffers const& patches,
                     PatchCoords const& coords, vulkan::FloatElements const& source,
                     vulkan::FloatElements const& target, int derivative)
    : _context(context) {
  std::uint32_t const constants[] = {source.length, source.stride, target.stride,
                                     static_cast<std::uint32_t>(derivative)};
  _pipeline = context.pipelines().specialised(vulkan::Kernel::EvalPatches, constants);
  vulkan::ElementWindow const from = vulkan::element_window(source, 0, patches.numPoints);
  require_window(context, from, "control points of patches");
  std::uint64_t const step = vulkan::elements_at_once(
      context, std::max(shared::kPatchCoordWords, target.stride), kGroupSize);
  std::vector<vulkan::BoundKernel> bound;
  for (std::uint64_t first = 0; first < std::uint64_t(coords.count); first += step) {
    std::uint64_t const count = std::min(step, coords.count - first);
    vulkan::ElementWindow const to = vulkan::element_window(target, first, count);
    require_window(context, to, "results of patches");
    Dispatch& dispatch = _dispatches.emplace_back();
    dispatch.parameters.coord_count = static_cast<std::uint32_t>(count);
    dispatch.parameters.array_count = static_cast<std::uint32_t>(patches.patchArrays.size());
    dispatch.parameters.first_source = from.shift;
    dispatch.parameters.first_target = to.shift;
    dispatch.groups = static_cast<std::uint32_t>((count + kGroupSize - 1) / kGroupSize);
    bound.push_back({vulkan::Kernel::EvalPatches,
                     {{coords.buffer, first * kCoordBytes, count * kCoordBytes},
                      whole(patches.arrays),
                      whole(patches.indices),
                      whole(*patches.params),
                      from.range,
                      to.range}});
  }
  _sets = vulkan::DescriptorSets(context, bound);
}

void PatchPass::record(VkCommandBuffer commands) const noexcept {
  for (std::size_t i = 0; i < _dispatches.size(); ++i) {
    // Windows of neighbouring dispatches may share their edge.
    if (i > 0)
      vulkan::record_barrier(_context, commands, vulkan::kKernelScope, vulkan::kKernelScope);
    vulkan::record_dispatch(_context, commands, _pipeline, _sets[i], &_dispatches[i].parameters,
                            _dispatches[i].groups);
  }
}

vulkan::FloatElements Elements(VkBuffer buffer, OpenSubdiv::Osd::BufferDescriptor const& desc) {
  return {buffer, static_cast<std::uint64_t>(desc.offset), static_cast<std::uint32_t>(desc.length),
          static_cast<std::uint32_t>(desc.stride)};
}

// Records or submits one pass for each destination.
template <typename PASS>
void RunPasses(VkDeviceContext& deviceContext, std::shared_ptr<std::vector<PASS>> const& passes) {
  auto const record = [&](VkCommandBuffer commands) {
    for (PASS const& pass : *passes) {
      // Destinations may interleave in one buffer.
      if (&pass != passes->data())
        vulkan::record_barrier(deviceContext.GetContext(), commands, vulkan::kKernelScope,
                               vulkan::kKernelScope);
      pass.record(commands);
    }
  };
  deviceContext.Run(record, passes);
}

}  // namespace

bool VkEvaluator::fits(BufferDescriptor const& desc, int length) {
  return length > 0 && desc.length == length && desc.stride >= length && desc.offset >= 0;
}

bool VkEvaluator::fit(Bound const& src, Destinations const& to) {
  if (!src.buffer || !fits(src.desc, src.desc.length)) return false;
  return std::all_of(to.begin(), to.end(), [&](Bound const& one) {
    return !one.buffer || fits(one.desc, src.desc.length);
  });
}

bool VkPatchEvaluator::evalPatches(VkDeviceContext* deviceContext, Bound const& src,
                                   Destinations const& to, int numPatchCoords, VkBuffer patchCoords,
                                   PatchBuffers const* patches) {
  if (!deviceContext || !patches || !fit(src, to) || numPatchCoords < 0) return false;
  if (numPatchCoords == 0) return true;
  if (!patchCoords) return false;
  auto const passes = std::make_shared<std::vector<PatchPass>>();
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer)
      passes->emplace_back(deviceContext->GetContext(), *patches,
                           PatchCoords{patchCoords, numPatchCoords}, Elements(src.buffer, src.desc),
                           Elements(to[i].buffer, to[i].desc), static_cast<int>(i));
  RunPasses(*deviceContext, passes);
  return true;
}

VkComputeEvaluator* VkComputeEvaluator::Create(BufferDescriptor const& srcDesc,
                                               BufferDescriptor const& dstDesc,
                                               BufferDescriptor const& duDesc,
                                               BufferDescriptor const& dvDesc,
                                               VkDeviceContext* deviceContext) {
  return Create(srcDesc, dstDesc, duDesc, dvDesc, {}, {}, {}, deviceContext);
}

VkComputeEvaluator* VkComputeEvaluator::Create(
    BufferDescriptor const& srcDesc, BufferDescriptor const& dstDesc,
    BufferDescriptor const& duDesc, BufferDescriptor const& dvDesc, BufferDescriptor const& duuDesc,
    BufferDescriptor const& duvDesc, BufferDescriptor const& dvvDesc,
    VkDeviceContext* deviceContext) {
  if (!fits(srcDesc, srcDesc.length) || !fits(dstDesc, srcDesc.length)) return nullptr;
  for (BufferDescriptor const* desc : {&dstDesc, &duDesc, &dvDesc, &duuDesc, &duvDesc, &dvvDesc}) {
    if (*desc == BufferDescriptor()) continue;
    if (!fits(*desc, srcDesc.length)) return nullptr;
    vulkan::StencilPass::compile(deviceContext->GetContext(), srcDesc.length, srcDesc.stride,
                                 desc->stride);
  }
  return new VkComputeEvaluator(deviceContext);
}

void VkComputeEvaluator::Synchronize(VkDeviceContext* deviceContext) {
  deviceContext->Synchronize();
}

bool VkComputeEvaluator::evalStencils(VkDeviceContext* deviceContext, Bound const& src,
                                      Destinations const& to, VkStencilTable const* stencilTable,
                                      int start, int end) {
  if (!deviceContext || !stencilTable || !fit(src, to)) return false;
  auto const weights = [&](std::size_t i) {
    return stencilTable->GetWeights(static_cast<StencilWeights>(i));
  };
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer && !weights(i)) return false;
  if (end <= start) return true;
  if (start < 0 || end > stencilTable->GetNumStencils()) return false;

  auto const passes = std::make_shared<std::vector<vulkan::StencilPass>>();
  for (std::size_t i = 0; i < to.size(); ++i)
    if (to[i].buffer)
      passes->emplace_back(deviceContext->GetContext(), *weights(i), Elements(src.buffer, src.desc),
                           Elements(to[i].buffer, to[i].desc), vulkan::PassRows{start, end});
  RunPasses(*deviceContext, passes);
  return true;
}

}  // namespace planish::osd
