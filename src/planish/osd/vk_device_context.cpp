#include "planish/osd/vk_device_context.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "planish/core/error.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/device/driver.h"

namespace planish::osd {

// A command buffer that is sent without waiting, used again once it is done.
class Submission {
 public:
  Submission(vulkan::Context& context, std::uint32_t queueFamily);
  // Waits for it.
  ~Submission();
  Submission(Submission const&) = delete;
  Submission& operator=(Submission const&) = delete;

  // Returns whether nothing is under way, after up to `nanoseconds`; then `resources` are let go.
  bool IsDone(std::uint64_t nanoseconds);

  // Keeps a resource until it is done.
  void Hold(std::shared_ptr<void> const& resource) {
    if (_pending) _resources.push_back(resource);
  }

  // Records, submits and returns. Must be done. What it does is ordered after, and sees, what
  // earlier submissions to the queue did.
  void Submit(VkQueue queue, std::function<void(VkCommandBuffer)> const& record,
              std::shared_ptr<void> resources);

 private:
  vulkan::FencedCommands _commands;
  bool _pending = false;
  std::vector<std::shared_ptr<void>> _resources;
};

Submission::Submission(vulkan::Context& context, std::uint32_t queueFamily)
    : _commands(context, queueFamily) {}

Submission::~Submission() {
  if (_pending) (void)_commands.wait(UINT64_MAX);
}

bool Submission::IsDone(std::uint64_t nanoseconds) {
  if (!_pending) return true;
  VkResult const result = _commands.wait(nanoseconds);
  if (result == VK_TIMEOUT) return false;
  vulkan::check(result, "vkWaitForFences");
  _pending = false;
  _resources.clear();
  return true;
}

void Submission::Submit(VkQueue queue, std::function<void(VkCommandBuffer)> const& record,
                        std::shared_ptr<void> resources) {
  _commands.submit(queue, record);
  _pending = true;
  _resources.push_back(std::move(resources));
}

namespace {

// Staging from this size on is for tables, which are uploaded once, and is not kept.
constexpr std::uint64_t kLargeBytes = 16u << 20;
// Pieces of an upload that may be under way at a time.
constexpr int kPiecesUnderWay = 4;

}  // namespace

struct VkDeviceContext::State {
  vulkan::Context& context;
  VkQueue queue = VK_NULL_HANDLE;
  std::uint32_t queueFamily = 0;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  std::vector<std::shared_ptr<vulkan::Buffer>> staging;
  std::map<VkCommandBuffer, std::vector<std::shared_ptr<void>>> recorded;
  std::vector<std::unique_ptr<Submission>> submissions;
};

VkDeviceContext::VkDeviceContext(vulkan::Context& context)
    : _state(std::make_unique<State>(State{context})) {}

VkDeviceContext::VkDeviceContext(vulkan::Context& context, VkQueue queue, std::uint32_t queueFamily)
    : VkDeviceContext(context) {
  _state->queue = queue;
  _state->queueFamily = queueFamily;
}

VkDeviceContext::~VkDeviceContext() = default;

void VkDeviceContext::SetCommandBuffer(VkCommandBuffer commands) { _state->commands = commands; }

VkCommandBuffer VkDeviceContext::GetCommandBuffer() const { return _state->commands; }

void VkDeviceContext::Release(VkCommandBuffer commands) { _state->recorded.erase(commands); }

void VkDeviceContext::Synchronize() {
  for (auto const& submission : _state->submissions) submission->IsDone(UINT64_MAX);
}

vulkan::Context& VkDeviceContext::GetContext() const { return _state->context; }

VkBufferUsageFlags VkDeviceContext::GetBufferUsage() const {
  VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  if (_state->context.variant().read_path == vulkan::ReadPath::Texel)
    usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  return usage;
}

void VkDeviceContext::Run(std::function<void(VkCommandBuffer)> const& record,
                          std::shared_ptr<void> resources) {
  auto const ordered = [&](VkCommandBuffer commands) {
    vulkan::record_barrier(_state->context, commands, vulkan::kExitScope, vulkan::kEntryScope);
    record(commands);
  };
  if (_state->commands) {
    ordered(_state->commands);
    _state->recorded[_state->commands].push_back(std::move(resources));
    return;
  }
  if (!_state->queue)
    throw Error(ErrorCode::InvalidArgument,
                "VkDeviceContext has no queue: call SetCommandBuffer first");
  auto& all = _state->submissions;
  auto free = std::find_if(all.begin(), all.end(), [](auto& one) { return one->IsDone(0); });
  if (free == all.end()) {
    all.push_back(std::make_unique<Submission>(_state->context, _state->queueFamily));
    free = all.end() - 1;
  }
  (*free)->Submit(_state->queue, ordered, std::move(resources));
}

void VkDeviceContext::Retire(std::shared_ptr<void> const& resource) {
  for (auto const& submission : _state->submissions) submission->Hold(resource);
  for (auto& [commands, resources] : _state->recorded) resources.push_back(resource);
}

void VkDeviceContext::Upload(VkBuffer target, std::uint64_t offset,
                             std::span<std::byte const> bytes) {
  for (int piece = 1; !bytes.empty(); ++piece) {
    auto const size = std::min<std::size_t>(bytes.size(), kLargeBytes);
    std::shared_ptr<vulkan::Buffer> staging = GetStaging(size);
    std::memcpy(staging->mapped().data(), bytes.data(), size);
    staging->flush();
    auto const copy = [&](VkCommandBuffer commands) {
      VkBufferCopy const region{0, offset, size};
      _state->context.vk().vkCmdCopyBuffer(commands, staging->handle(), target, 1, &region);
    };
    Run(copy, staging);
    if (piece % kPiecesUnderWay == 0) Synchronize();
    offset += size;
    bytes = bytes.subspan(size);
  }
}

std::vector<std::byte> VkDeviceContext::Download(VkBuffer source, std::uint64_t offset,
                                                 std::uint64_t size) {
  std::vector<std::byte> bytes(size);
  if (size == 0) return bytes;
  auto const staging =
      std::make_shared<vulkan::Buffer>(_state->context, size, vulkan::MemoryUse::Download);
  auto const copy = [&](VkCommandBuffer commands) {
    VkBufferCopy const region{offset, 0, size};
    _state->context.vk().vkCmdCopyBuffer(commands, source, staging->handle(), 1, &region);
  };
  if (_state->commands)
    throw Error(ErrorCode::InvalidArgument,
                "a VkDeviceContext that records cannot read back: set no command buffer");
  Run(copy, staging);
  Synchronize();
  staging->invalidate();
  std::memcpy(bytes.data(), staging->mapped().data(), size);
  return bytes;
}

std::shared_ptr<vulkan::Buffer> VkDeviceContext::GetStaging(std::uint64_t size) {
  for (auto& buffer : _state->staging)
    // Held by nobody but the list; much larger ones are left for larger data.
    if (buffer.use_count() == 1 && buffer->size() >= size && buffer->size() / 4 <= size)
      return buffer;
  auto buffer = std::make_shared<vulkan::Buffer>(_state->context, size, vulkan::MemoryUse::Upload);
  if (size < kLargeBytes) _state->staging.push_back(buffer);
  return buffer;
}

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
