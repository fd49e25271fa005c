#include "planish/vulkan/backend/vulkan_machine.h"

#include <cstring>
#include <glm/vec4.hpp>

#include "planish/core/parallel.h"

namespace planish::vulkan {

namespace {

template <class Item>
void upload_items(Submitter& submitter, const Buffer& target, const std::vector<Item>& items) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(items));
  submitter.upload({target.handle(), 0, bytes.size()}, bytes);
}

}  // namespace

void VulkanMachine::upload_table(DeviceTable& table, const StencilView<double>& view) {
  for (std::size_t i = 0; i < table.slices().size(); ++i) {
    const DeviceTable::Slice& slice = table.slices()[i];
    const PackedSlice packed = table.pack(i, view);
    upload_items(submitter, slice.chunks, packed.chunks);
    upload_items(submitter, slice.entries, packed.entries);
    if (table.has_derivatives()) upload_items(submitter, slice.derivatives, packed.derivatives);
  }
  table.finish_packing();
}

void VulkanMachine::upload_points(const Buffer& target, std::span<const glm::dvec3> points) {
  const BufferRange range{target.handle(), 0, points.size() * kPointBytes};
  submitter.upload(range, [&](std::uint64_t offset, std::span<std::byte> piece) {
    const std::size_t first = offset / kPointBytes;
    parallel_each(piece.size() / kPointBytes, [&](std::size_t i) {
      const glm::vec4 point(points[first + i], 0);
      std::memcpy(&piece[i * kPointBytes], &point, kPointBytes);
    });
  });
}

std::vector<glm::dvec3> VulkanMachine::download_points(const Buffer& source, std::size_t count) {
  std::vector<glm::dvec3> points(count);
  submitter.download({source.handle(), 0, count * kPointBytes},
                     [&](std::uint64_t offset, std::span<const std::byte> piece) {
                       const std::size_t first = offset / kPointBytes;
                       parallel_each(piece.size() / kPointBytes, [&](std::size_t i) {
                         glm::vec3 point;
                         std::memcpy(&point, &piece[i * kPointBytes], sizeof point);
                         points[first + i] = glm::dvec3(point);
                       });
                     });
  return points;
}

}  // namespace planish::vulkan
