#include "resources.h"

#include <cstring>

namespace planish::viewer {
namespace {

constexpr std::size_t kPixelBytes = 4;

OwnedMemory allocate(const Device& device, const VkMemoryRequirements& requirements,
                     VkMemoryPropertyFlags properties) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = requirements.size;
  info.memoryTypeIndex = device.memory_type(requirements.memoryTypeBits, properties);
  return OwnedMemory(device, info, "vkAllocateMemory");
}

}  // namespace

Buffer::Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place)
    : bytes_(bytes) {
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes;
  info.usage = usage;
  buffer_ = OwnedBuffer(device, info, "vkCreateBuffer");
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device, buffer_, &requirements);
  // Vulkan promises a coherent type for every buffer.
  memory_ = allocate(device, requirements,
                     place == Place::Device ? VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
                                            : VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT |
                                                  VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  vulkan::check(vkBindBufferMemory(device, buffer_, memory_, 0), "vkBindBufferMemory");
  if (place == Place::Device) return;
  void* start = nullptr;
  vulkan::check(vkMapMemory(device, memory_, 0, VK_WHOLE_SIZE, 0, &start), "vkMapMemory");
  mapped_ = static_cast<std::byte*>(start);
}

void barrier(VkCommandBuffer commands, const vulkan::Scope& from, const vulkan::Scope& to) {
  VkMemoryBarrier memory{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  memory.srcAccessMask = from.accesses;
  memory.dstAccessMask = to.accesses;
  vkCmdPipelineBarrier(commands, from.stages, to.stages, 0, 1, &memory, 0, nullptr, 0, nullptr);
}

void host_barrier(VkCommandBuffer commands) {
  barrier(commands, {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT},
          {VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT});
}

Buffer buffer_of(const Device& device, std::span<const std::byte> bytes, VkBufferUsageFlags usage) {
  const Buffer staging(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, Place::Host);
  std::memcpy(staging.mapped().data(), bytes.data(), bytes.size());
  Buffer buffer(device, bytes.size(), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Device);
  device.run([&](VkCommandBuffer commands) {
    const VkBufferCopy all{0, 0, bytes.size()};
    vkCmdCopyBuffer(commands, staging, buffer, 1, &all);
    barrier(commands, {VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT},
            {VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_VERTEX_SHADER_BIT |
                 VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
             VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_SHADER_READ_BIT});
  });
  return buffer;
}

Buffer word_buffer(const Device& device, std::span<const std::uint32_t> words) {
  return buffer_of(device, std::as_bytes(words), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
}

Buffer picture_buffer(const Device& device, VkExtent2D extent) {
  return {device, VkDeviceSize(extent.width) * extent.height * kPixelBytes,
          VK_BUFFER_USAGE_TRANSFER_DST_BIT, Place::Host};
}

void copy_picture(VkCommandBuffer commands, VkImage image, VkExtent2D extent,
                  const Buffer& target) {
  VkBufferImageCopy region{};
  region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
  region.imageExtent = {extent.width, extent.height, 1};
  vkCmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target, 1, &region);
  host_barrier(commands);
}

std::vector<std::uint8_t> rgb_of(const Buffer& picture) {
  const std::span<const std::byte> bytes = picture.mapped();
  std::vector<std::uint8_t> rgb(bytes.size() / kPixelBytes * 3);
  for (std::size_t i = 0; i < rgb.size() / 3; ++i)
    std::memcpy(&rgb[3 * i], &bytes[kPixelBytes * i], 3);
  return rgb;
}

OwnedImageView make_view(VkDevice device, VkImage image, VkFormat format,
                         VkImageAspectFlags aspect) {
  VkImageViewCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
  info.image = image;
  info.viewType = VK_IMAGE_VIEW_TYPE_2D;
  info.format = format;
  info.subresourceRange = {aspect, 0, 1, 0, 1};
  return OwnedImageView(device, info, "vkCreateImageView");
}

Image::Image(const Device& device, const ImageOptions& options) {
  VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
  info.imageType = VK_IMAGE_TYPE_2D;
  info.format = options.format;
  info.extent = {options.extent.width, options.extent.height, 1};
  info.mipLevels = 1;
  info.arrayLayers = 1;
  info.samples = options.samples;
  info.tiling = VK_IMAGE_TILING_OPTIMAL;
  info.usage = options.usage;
  image_ = OwnedImage(device, info, "vkCreateImage");
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device, image_, &requirements);
  memory_ = allocate(device, requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
  vulkan::check(vkBindImageMemory(device, image_, memory_, 0), "vkBindImageMemory");
  view_ = make_view(device, image_, options.format, options.aspect);
}

}  // namespace planish::viewer
