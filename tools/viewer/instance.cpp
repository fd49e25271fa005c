#include "instance.h"

#include <string>

#include "planish/core/error.h"
#include "planish/vulkan/device/instance.h"
#include "planish/vulkan/device/result.h"

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

}  // namespace planish::viewer
