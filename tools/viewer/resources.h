#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "device.h"

namespace planish::viewer {

enum class Place {
  Device,  ///< for the device alone
  Host,    ///< mapped and coherent
};

/// A buffer with memory of its own: enough for an application of a dozen buffers.
class Buffer {
 public:
  Buffer() = default;
  /// Throws vulkan::VulkanError, Error{OutOfMemory}.
  Buffer(const Device& device, VkDeviceSize bytes, VkBufferUsageFlags usage, Place place);

  operator VkBuffer() const { return buffer_; }
  [[nodiscard]] VkDeviceSize bytes() const { return bytes_; }
  /// Of Place::Host.
  [[nodiscard]] std::span<std::byte> mapped() const {
    return {mapped_, static_cast<std::size_t>(bytes_)};
  }

 private:
  VkDeviceSize bytes_ = 0;
  OwnedMemory memory_;
  OwnedBuffer buffer_;
  std::byte* mapped_ = nullptr;
};

/// From one scope to another, for all memory.
void barrier(VkCommandBuffer commands, const vulkan::Scope& from, const vulkan::Scope& to);

/// After copies into mapped buffers: makes them visible to the host once its fence is there.
void host_barrier(VkCommandBuffer commands);

/// A buffer of these bytes in the device's own memory, which they have reached: to be read by
/// shaders and as vertices.
[[nodiscard]] Buffer buffer_of(const Device& device, std::span<const std::byte> bytes,
                               VkBufferUsageFlags usage);
/// A storage buffer of these words.
[[nodiscard]] Buffer word_buffer(const Device& device, std::span<const std::uint32_t> words);

struct ImageOptions {
  VkFormat format = VK_FORMAT_UNDEFINED;
  VkExtent2D extent{};
  VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
  VkImageUsageFlags usage = 0;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
};

/// A two-dimensional image with a view and memory of its own.
class Image {
 public:
  /// Throws vulkan::VulkanError, Error{OutOfMemory}.
  Image(const Device& device, const ImageOptions& options);

  operator VkImage() const { return image_; }
  [[nodiscard]] VkImageView view() const { return view_; }

 private:
  OwnedMemory memory_;
  OwnedImage image_;
  OwnedImageView view_;
};

/// Of pictures, which all devices draw to and copy from.
inline constexpr VkFormat kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;
/// For a picture's pixels.
[[nodiscard]] Buffer picture_buffer(const Device& device, VkExtent2D extent);
/// Copies one that a render pass has left to be copied from.
void copy_picture(VkCommandBuffer commands, VkImage image, VkExtent2D extent, const Buffer& target);
/// Of such a buffer: RGB, top row first.
[[nodiscard]] std::vector<std::uint8_t> rgb_of(const Buffer& picture);

/// The view of a whole image.
[[nodiscard]] OwnedImageView make_view(VkDevice device, VkImage image, VkFormat format,
                                       VkImageAspectFlags aspect);

}  // namespace planish::viewer
