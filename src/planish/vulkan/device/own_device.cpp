#include "planish/vulkan/device/own_device.h"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/platform/process.h"
#include "planish/core/words.h"
#include "planish/vulkan/device/device_rank.h"
#include "planish/vulkan/device/driver.h"

namespace planish::vulkan {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

VKAPI_ATTR VkBool32 VKAPI_CALL forward_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                               VkDebugUtilsMessageTypeFlagsEXT,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data,
                                               void* user) {
  const auto& message = *static_cast<const std::function<void(std::string_view)>*>(user);
  if (message && data->pMessage) message(data->pMessage);
  return VK_FALSE;
}

bool has_layer(PFN_vkGetInstanceProcAddr get, const char* name) {
  const auto enumerate = reinterpret_cast<PFN_vkEnumerateInstanceLayerProperties>(
      get(nullptr, "vkEnumerateInstanceLayerProperties"));
  std::uint32_t count = 0;
  if (!enumerate || enumerate(&count, nullptr) != VK_SUCCESS) return false;
  std::vector<VkLayerProperties> layers(count);
  enumerate(&count, layers.data());
  for (const VkLayerProperties& layer : layers)
    if (std::strcmp(layer.layerName, name) == 0) return true;
  return false;
}

// Drivers are loaded with a process' first instance and unloaded with its last one, and NVIDIA's
// 580 is not loaded after thirty times. So the first instance that would go stays.
bool stays_to_the_end() {
  static std::atomic_flag taken;
  return !taken.test_and_set();
}

}  // namespace

VkDebugUtilsMessengerCreateInfoEXT messenger_info(
    const std::function<void(std::string_view)>& message) {
  VkDebugUtilsMessengerCreateInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  info.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                         VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  info.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT |
                     VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  info.pfnUserCallback = forward_message;
  info.pUserData = const_cast<std::function<void(std::string_view)>*>(&message);
  return info;
}

Instance::Instance(const InstanceOptions& options)
    : library_(nullptr, platform::unload_library),
      get_proc_(options.get_proc),
      message_(options.message) {
  if (!get_proc_) open_loader();
  try {
    create(options);
  } catch (...) {
    destroy();
    throw;
  }
}

void Instance::open_loader() {
  const std::string file = platform::library_file("vulkan", 1);
  std::string why;
  library_.reset(platform::load_library(file, why));
  if (!library_)
    throw Error(ErrorCode::NoDevice,
                "no Vulkan loader: " + why + "; install the package libvulkan1");
  get_proc_ = reinterpret_cast<PFN_vkGetInstanceProcAddr>(
      platform::function_of(library_.get(), "vkGetInstanceProcAddr"));
  if (!get_proc_) throw Error(ErrorCode::NoDevice, file + " has no vkGetInstanceProcAddr");
}

void Instance::create(const InstanceOptions& options) {
  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.pApplicationName = "planish";
  application.apiVersion = VK_API_VERSION_1_1;

  const VkDebugUtilsMessengerCreateInfoEXT messenger = messenger_info(message_);
  const VkValidationFeatureEnableEXT enabled[] = {
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = enabled;

  const char* layers[] = {kValidationLayer};
  std::vector<const char*> extensions;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  // Without it, loaders hide devices that are layers over another API.
  if (has_instance_extension(get_proc_, VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME)) {
    extensions.push_back(VK_KHR_PORTABILITY_ENUMERATION_EXTENSION_NAME);
    info.flags |= VK_INSTANCE_CREATE_ENUMERATE_PORTABILITY_BIT_KHR;
  }
  if (options.validation) {
    if (!has_layer(get_proc_, kValidationLayer))
      throw Error(ErrorCode::NoDevice, std::string(kValidationLayer) +
                                           " is not installed; the package "
                                           "vulkan-validationlayers has it");
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = layers;
    extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  }
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();

  const auto create_instance =
      reinterpret_cast<PFN_vkCreateInstance>(get_proc_(nullptr, "vkCreateInstance"));
  const VkResult result = create_instance ? create_instance(&info, nullptr, &instance_)
                                          : VK_ERROR_INITIALIZATION_FAILED;
  if (result != VK_SUCCESS)
    throw VulkanError(ErrorCode::NoDevice,
                      std::string("no Vulkan driver: vkCreateInstance: ") + name_of(result) +
                          "; install one, e.g. the package mesa-vulkan-drivers",
                      result);
  functions_ = InstanceFunctions::load(get_proc_, instance_);
  if (options.validation) create_messenger(messenger);
}

void Instance::create_messenger(const VkDebugUtilsMessengerCreateInfoEXT& info) {
  const auto create = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
      get_proc_(instance_, "vkCreateDebugUtilsMessengerEXT"));
  if (create)
    check(create(instance_, &info, nullptr, &messenger_), "vkCreateDebugUtilsMessengerEXT");
}

Instance::~Instance() { destroy(); }

void Instance::destroy() noexcept {
  if (messenger_) {
    const auto destroy = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        get_proc_(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    destroy(instance_, messenger_, nullptr);
  }
  if (!functions_.vkDestroyInstance) return;
  if (library_ && !messenger_ && stays_to_the_end()) {
    static_cast<void>(library_.release());
    return;
  }
  functions_.vkDestroyInstance(instance_, nullptr);
}

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

// Every device whose name contains `wanted`, or the one that bears exactly that name or UUID.
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
