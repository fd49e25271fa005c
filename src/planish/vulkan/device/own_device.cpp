#include "planish/vulkan/device/own_device.h"

#include <algorithm>

#include "planish/core/error.h"
#include "planish/core/lower_case.h"
#include "planish/vulkan/device/device_rank.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

std::string listing(const std::vector<FoundDevice>& devices) {
  if (devices.empty()) return "there is no Vulkan device";
  std::string text = "there are";
  for (std::size_t i = 0; i < devices.size(); ++i)
    text += formatted("{}{} '{}'", i ? ", " : " ", i, devices[i].capabilities.name);
  return text;
}

bool is_index(const std::string& text) {
  constexpr std::size_t kMostDigits = 4;  // and so it fits an int
  return !text.empty() && text.size() <= kMostDigits &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c); });
}

/// Every device whose name contains `wanted`, or the one that bears exactly that name or UUID.
std::vector<std::size_t> devices_named(const std::vector<FoundDevice>& devices,
                                       const std::string& wanted) {
  std::vector<std::size_t> matches;
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const std::string name = lower_case(devices[i].capabilities.name);
    if (name == wanted || devices[i].capabilities.uuid == wanted) return {i};
    if (name.find(wanted) != std::string::npos) matches.push_back(i);
  }
  return matches;
}

std::size_t best_device(const std::vector<FoundDevice>& devices) {
  const auto best = std::max_element(devices.begin(), devices.end(), [](auto& a, auto& b) {
    return rank_of(a.capabilities) < rank_of(b.capabilities);
  });
  if (best == devices.end()) throw Error(ErrorCode::NoDevice, "there is no Vulkan device");
  return static_cast<std::size_t>(best - devices.begin());
}

}  // namespace

std::vector<FoundDevice> find_devices(const Instance& instance) {
  const InstanceFunctions& vk = instance.functions();
  std::uint32_t count = 0;
  check(vk.vkEnumeratePhysicalDevices(instance.handle(), &count, nullptr),
        "vkEnumeratePhysicalDevices");
  std::vector<VkPhysicalDevice> handles(count);
  check(vk.vkEnumeratePhysicalDevices(instance.handle(), &count, handles.data()),
        "vkEnumeratePhysicalDevices");
  std::vector<FoundDevice> devices;
  devices.reserve(handles.size());
  for (VkPhysicalDevice handle : handles)
    devices.push_back({handle, query_capabilities(instance.get_proc(), instance.handle(), handle)});
  return devices;
}

std::size_t pick_device(const std::vector<FoundDevice>& devices, const std::string& wanted) {
  std::size_t picked = 0;
  if (wanted.empty()) {
    picked = best_device(devices);
  } else if (is_index(wanted)) {
    picked = static_cast<std::size_t>(std::stoi(wanted));
  } else {
    const std::vector<std::size_t> matches = devices_named(devices, lower_case(wanted));
    if (matches.size() > 1)
      throw Error(ErrorCode::NoDevice,
                  formatted("'{}' names several devices; {}", wanted, listing(devices)));
    picked = matches.empty() ? devices.size() : matches.front();
  }
  if (picked >= devices.size())
    throw Error(ErrorCode::NoDevice, formatted("no device '{}'; {}", wanted, listing(devices)));
  const Capabilities& device = devices[picked].capabilities;
  if (!device.usable)
    throw Error(ErrorCode::NoDevice, formatted("device '{}' {}", device.name, device.reason));
  return picked;
}

OwnDevice::OwnDevice(const OwnDeviceOptions& options) : instance_(options.instance) {
  const std::vector<FoundDevice> devices = find_devices(instance_);
  const FoundDevice& picked = devices[pick_device(devices, options.wanted)];
  physical_device_ = picked.handle;
  capabilities_ = picked.capabilities;

  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = capabilities_.compute_family;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  std::vector<const char*> extensions;
  for (const std::string& name : capabilities_.required_extensions)
    extensions.push_back(name.c_str());
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  const InstanceFunctions& vk = instance_.functions();
  check(vk.vkCreateDevice(physical_device_, &info, nullptr, &device_), "vkCreateDevice");
  destroy_device_ =
      reinterpret_cast<PFN_vkDestroyDevice>(vk.vkGetDeviceProcAddr(device_, "vkDestroyDevice"));
  const auto get_queue =
      reinterpret_cast<PFN_vkGetDeviceQueue>(vk.vkGetDeviceProcAddr(device_, "vkGetDeviceQueue"));
  get_queue(device_, capabilities_.compute_family, 0, &queue_);
}

OwnDevice::~OwnDevice() { destroy_device_(device_, nullptr); }

HostDevice OwnDevice::host_device() const {
  HostDevice host;
  host.get_instance_proc = instance_.get_proc();
  host.instance = instance_.handle();
  host.physical_device = physical_device_;
  host.device = device_;
  host.features.debug_utils = instance_.has_debug_utils();
  return host;
}

}  // namespace planish::vulkan
