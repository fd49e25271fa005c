#pragma once

#include <opensubdiv/far/patchTable.h>
#include <opensubdiv/osd/types.h>

#include <memory>
#include <vector>

#include "planish/osd/vk_device_context.h"

namespace planish::osd {

struct PatchBuffers;

/// OpenSubdiv's PATCH_TABLE on a Vulkan device, with the functions of Osd::GLPatchTable. Indices
/// are int, parameters three words (Osd::PatchParam); buffers have storage, vertex and transfer
/// usage. Read only. May be deleted at any time in the life of the device context that made it,
/// like a VkVertexBuffer.
class VkPatchTable {
 public:
  typedef VkBuffer VertexBufferBinding;

  /// Copies the table to the device; it may be deleted then. The caller owns the result. Throws
  /// planish::Error{OutOfMemory}, naming the limit.
  static VkPatchTable* Create(OpenSubdiv::Far::PatchTable const* patchTable,
                              VkDeviceContext* deviceContext);
  ~VkPatchTable();
  VkPatchTable(VkPatchTable const&) = delete;
  VkPatchTable& operator=(VkPatchTable const&) = delete;

  OpenSubdiv::Osd::PatchArrayVector const& GetPatchArrays() const;
  VkBuffer GetPatchIndexBuffer() const;
  VkBuffer GetPatchParamBuffer() const;

  /// Empty and null where the table has no varying patches.
  OpenSubdiv::Osd::PatchArrayVector const& GetVaryingPatchArrays() const;
  VkBuffer GetVaryingPatchIndexBuffer() const;

  int GetNumFVarChannels() const { return static_cast<int>(_fvarPatches.size()); }
  OpenSubdiv::Osd::PatchArrayVector const& GetFVarPatchArrays(int fvarChannel = 0) const;
  VkBuffer GetFVarPatchIndexBuffer(int fvarChannel = 0) const;
  VkBuffer GetFVarPatchParamBuffer(int fvarChannel = 0) const;

  /// What evaluators bind; null where there are no such patches or channel.
  PatchBuffers const* GetPatches() const { return _patches.get(); }
  PatchBuffers const* GetVaryingPatches() const { return _varyingPatches.get(); }
  PatchBuffers const* GetFVarPatches(int fvarChannel) const;

 private:
  explicit VkPatchTable(VkDeviceContext& deviceContext) : _deviceContext(deviceContext) {}

  VkDeviceContext& _deviceContext;
  std::shared_ptr<PatchBuffers> _patches, _varyingPatches;
  std::vector<std::shared_ptr<PatchBuffers>> _fvarPatches;
};

}  // namespace planish::osd
