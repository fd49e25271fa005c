#pragma once

#include <memory>

#include "planish/osd/vk_device_context.h"

namespace planish::osd {

/// OpenSubdiv's VERTEX_BUFFER on a Vulkan device: numVertices elements of numElements floats, not
/// cleared. The host may draw from it. May be deleted at any time in the life of the device context
/// that made it: the buffer stays until that context's commands are done. Commands of others must
/// be.
class VkVertexBuffer {
 public:
  /// The caller owns the result. Throws planish::Error{OutOfMemory}, naming the limit.
  static VkVertexBuffer* Create(int numElements, int numVertices, VkDeviceContext* deviceContext);
  ~VkVertexBuffer();
  VkVertexBuffer(VkVertexBuffer const&) = delete;
  VkVertexBuffer& operator=(VkVertexBuffer const&) = delete;

  /// Overwrites elements [startVertex, startVertex + numVertices); `src` is free at once.
  void UpdateData(float const* src, int startVertex, int numVertices,
                  VkDeviceContext* deviceContext);
  /// Waits and copies the same elements out. Not while a command buffer is set.
  void ReadData(float* dst, int startVertex, int numVertices, VkDeviceContext* deviceContext) const;

  int GetNumElements() const { return _numElements; }
  int GetNumVertices() const { return _numVertices; }

  /// The buffer: storage, vertex and transfer usage.
  VkBuffer BindVBO(VkDeviceContext* deviceContext = nullptr) const;

 private:
  VkVertexBuffer(int numElements, int numVertices, VkDeviceContext& deviceContext);
  void CheckRange(int startVertex, int numVertices) const;

  int _numElements, _numVertices;
  VkDeviceContext& _deviceContext;
  std::shared_ptr<vulkan::Buffer> _buffer;
};

}  // namespace planish::osd
