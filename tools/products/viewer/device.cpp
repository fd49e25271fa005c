#include "device.h"

#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/words.h"
#include "planish/vulkan/device/device_rank.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"

namespace planish::viewer {
namespace {

std::string remedy_of(VkResult result) {
  if (result == VK_ERROR_LAYER_NOT_PRESENT) return "; install the package vulkan-validationlayers";
  if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
    return "; install a driver, e.g. the package mesa-vulkan-drivers";
  return "";
}

}  // namespace

Instance::Instance(const InstanceOptions& options) : message_(options.message) {
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "planish-viewer";
  application.apiVersion = VK_API_VERSION_1_1;

  VkDebugUtilsMessengerCreateInfoEXT messenger = vulkan::messenger_info(message_);
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  const VkValidationFeatureEnableEXT enabled =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;

  const char* layer = "VK_LAYER_KHRONOS_validation";
  std::vector<const char*> extensions = options.extensions;
  if (options.validation) extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  if (options.validation) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &layer;
  }
  const VkResult result = vkCreateInstance(&info, nullptr, &instance_);
  if (result != VK_SUCCESS)
    throw Error(ErrorCode::NoDevice,
                std::string("vkCreateInstance: ") + vulkan::name_of(result) + remedy_of(result));
  if (!options.validation) return;
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      vkGetInstanceProcAddr(instance_, "vkCreateDebugUtilsMessengerEXT"));
  if (create) create(instance_, &messenger, nullptr, &messenger_);
}

Instance::~Instance() {
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  vkDestroyInstance(instance_, nullptr);
}

namespace {

struct Candidate {
  VkPhysicalDevice handle;
  vulkan::Capabilities capabilities;
  std::optional<std::uint32_t> family;
};

std::optional<std::uint32_t> find_family(VkPhysicalDevice device, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  for (std::uint32_t i = 0; i < count; ++i) {
    VkBool32 presents = VK_TRUE;
    if (surface)
      vulkan::check(vkGetPhysicalDeviceSurfaceSupportKHR(device, i, surface, &presents),
                    "vkGetPhysicalDeviceSurfaceSupportKHR");
    if ((families[i].queueFlags & kWanted) == kWanted && presents) return i;
  }
  return std::nullopt;
}

std::vector<Candidate> find_candidates(VkInstance instance, VkSurfaceKHR surface) {
  std::uint32_t count = 0;
  vulkan::check(vkEnumeratePhysicalDevices(instance, &count, nullptr),
                "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> handles(count);
  vulkan::check(vkEnumeratePhysicalDevices(instance, &count, handles.data()),
                "vkEnumeratePhysicalDevices");
  std::vector<Candidate> candidates;
  candidates.reserve(handles.size());
  for (VkPhysicalDevice handle : handles)
    candidates.push_back({handle,
                          vulkan::query_capabilities(vkGetInstanceProcAddr, instance, handle),
                          find_family(handle, surface)});
  return candidates;
}

// Why the device does not serve; empty if it does.
std::string objection(const Candidate& candidate) {
  if (!candidate.capabilities.usable) return candidate.capabilities.reason;
  if (!candidate.family) return "has no queue that draws, computes and presents";
  return "";
}

const Candidate& pick(const std::vector<Candidate>& candidates, const std::string& wanted) {
  const Candidate* best = nullptr;
  std::string listing;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Candidate& candidate = candidates[i];
    const std::string& name = candidate.capabilities.name;
    const std::string why = objection(candidate);
    listing += formatted("; {} '{}'{}", i, name, why.empty() ? "" : " " + why);
    const bool named = std::to_string(i) == wanted ||
                       lower_case(name).find(lower_case(wanted)) != std::string::npos;
    if (named && why.empty() &&
        (!best || rank_of(candidate.capabilities) > rank_of(best->capabilities)))
      best = &candidate;
  }
  if (best) return *best;
  throw Error(ErrorCode::NoDevice, (wanted.empty() ? std::string("no Vulkan device serves")
                                                   : "no Vulkan device '" + wanted + "' serves") +
                                       (listing.empty() ? "; there is none" : listing));
}

}  // namespace

Device::Device(const Instance& instance, const DeviceOptions& options)
    : instance_(instance.handle()), has_debug_utils_(instance.has_debug_utils()) {
  const std::vector<Candidate> candidates = find_candidates(instance_, options.surface);
  const Candidate& picked = pick(candidates, options.wanted);
  physical_ = picked.handle;
  name_ = picked.capabilities.name;
  is_software_ = picked.capabilities.type == VK_PHYSICAL_DEVICE_TYPE_CPU;
  family_ = *picked.family;
  memory_ = picked.capabilities.memory;

  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = family_;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceFeatures supported;
  vkGetPhysicalDeviceFeatures(physical_, &supported);
  VkPhysicalDeviceFeatures features{};
  features.tessellationShader = supported.tessellationShader;
  has_tessellation_ = supported.tessellationShader;
  std::vector<const char*> extensions = options.extensions;
  if (options.surface) extensions.push_back(VK_KHR_SWAPCHAIN_EXTENSION_NAME);
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.pEnabledFeatures = &features;
  info.pNext = options.features;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkDevice device = VK_NULL_HANDLE;
  vulkan::check(vkCreateDevice(physical_, &info, nullptr, &device), "vkCreateDevice");
  device_.reset(device);
  vkGetDeviceQueue(device, family_, 0, &queue_);
}

void Device::demand_tessellation() const {
  if (!has_tessellation_)
    throw Error(ErrorCode::NoDevice,
                name_ + " has no tessellation shaders; leave out --tessellate");
}

vulkan::HostDevice Device::host() const {
  vulkan::HostDevice host;
  host.get_instance_proc = vkGetInstanceProcAddr;
  host.instance = instance_;
  host.physical_device = physical_;
  host.device = device_.get();
  host.features.debug_utils = has_debug_utils_;
  return host;
}

std::uint32_t Device::memory_type(std::uint32_t allowed, VkMemoryPropertyFlags wanted) const {
  for (std::uint32_t i = 0; i < memory_.memoryTypeCount; ++i)
    if ((allowed >> i & 1u) && (memory_.memoryTypes[i].propertyFlags & wanted) == wanted) return i;
  throw Error(ErrorCode::OutOfMemory, name_ + " has no memory type for a buffer or image");
}

void Device::run(const std::function<void(VkCommandBuffer)>& record) const {
  VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool_info.queueFamilyIndex = family_;
  const OwnedCommandPool pool(*this, pool_info, "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  vulkan::check(vkAllocateCommandBuffers(*this, &allocate, &commands), "vkAllocateCommandBuffers");
  const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                       VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  vulkan::check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  record(commands);
  vulkan::check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  vulkan::check(vkQueueSubmit(queue_, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
  wait_idle();
}

void Device::wait_idle() const { vulkan::check(vkDeviceWaitIdle(*this), "vkDeviceWaitIdle"); }

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
