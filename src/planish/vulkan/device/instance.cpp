#include "planish/vulkan/device/instance.h"

#include <dlfcn.h>

#include <atomic>
#include <cstring>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/vulkan/device/result.h"

namespace planish::vulkan {

namespace {

constexpr const char* kLibrary = "libvulkan.so.1";
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
    : library_(nullptr, ::dlclose), get_proc_(options.get_proc), message_(options.message) {
  if (!get_proc_) open_loader();
  try {
    create(options);
  } catch (...) {
    destroy();
    throw;
  }
}

void Instance::open_loader() {
  library_.reset(::dlopen(kLibrary, RTLD_NOW | RTLD_LOCAL));
  if (!library_)
    throw Error(ErrorCode::NoDevice, std::string("no Vulkan loader: ") + ::dlerror() +
                                         "; install the package libvulkan1");
  get_proc_ =
      reinterpret_cast<PFN_vkGetInstanceProcAddr>(::dlsym(library_.get(), "vkGetInstanceProcAddr"));
  if (!get_proc_)
    throw Error(ErrorCode::NoDevice, std::string(kLibrary) + " has no vkGetInstanceProcAddr");
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

}  // namespace planish::vulkan
