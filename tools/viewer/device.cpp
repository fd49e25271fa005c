#include "device.h"

#include <optional>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/vulkan/device/device_rank.h"

namespace planish::viewer {
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

/// Why the device does not serve; empty if it does.
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

}  // namespace planish::viewer
