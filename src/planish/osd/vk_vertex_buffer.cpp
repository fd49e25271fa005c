#include "planish/osd/vk_vertex_buffer.h"

#include <cstring>
#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/buffer.h"

namespace planish::osd {

VkVertexBuffer* VkVertexBuffer::Create(int numElements, int numVertices,
                                       VkDeviceContext* deviceContext) {
  if (numElements < 1 || numVertices < 0)
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("VkVertexBuffer of {} vertices of {} floats: neither may be negative or no float",
                  numVertices, numElements));
  return new VkVertexBuffer(numElements, numVertices, *deviceContext);
}

VkVertexBuffer::VkVertexBuffer(int numElements, int numVertices, VkDeviceContext& deviceContext)
    : _numElements(numElements),
      _numVertices(numVertices),
      _deviceContext(deviceContext),
      _buffer(std::make_shared<vulkan::Buffer>(
          deviceContext.GetContext(), std::uint64_t(numElements) * numVertices * sizeof(float),
          vulkan::MemoryUse::Device, "planish vertex buffer")) {}

VkVertexBuffer::~VkVertexBuffer() { _deviceContext.Retire(_buffer); }

VkBuffer VkVertexBuffer::BindVBO(VkDeviceContext*) const { return _buffer->handle(); }

void VkVertexBuffer::CheckRange(int startVertex, int numVertices) const {
  if (startVertex < 0 || numVertices < 0 || startVertex > _numVertices - numVertices)
    throw Error(ErrorCode::InvalidArgument,
                formatted("VkVertexBuffer: vertices {} to {} of {}", startVertex,
                          std::int64_t(startVertex) + numVertices, _numVertices),
                startVertex);
}

void VkVertexBuffer::UpdateData(float const* src, int startVertex, int numVertices,
                                VkDeviceContext* deviceContext) {
  CheckRange(startVertex, numVertices);
  std::span<float const> const floats(src, std::size_t(numVertices) * _numElements);
  deviceContext->Upload(_buffer->handle(),
                        std::uint64_t(startVertex) * _numElements * sizeof(float),
                        std::as_bytes(floats));
}

void VkVertexBuffer::ReadData(float* dst, int startVertex, int numVertices,
                              VkDeviceContext* deviceContext) const {
  CheckRange(startVertex, numVertices);
  std::uint64_t const vertexBytes = _numElements * sizeof(float);
  std::vector<std::byte> const bytes = deviceContext->Download(
      _buffer->handle(), startVertex * vertexBytes, numVertices * vertexBytes);
  if (!bytes.empty()) std::memcpy(dst, bytes.data(), bytes.size());
}

}  // namespace planish::osd
