#include "planish/osd/vk_patch_table.h"

#include <opensubdiv/osd/cpuPatchTable.h>

#include "planish/osd/patch_buffers.h"

namespace planish::osd {

namespace {

using OpenSubdiv::Osd::PatchArrayVector;

/// OpenSubdiv's own conversion of a Far::PatchTable.
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

}  // namespace planish::osd
