#include "application.h"

#include <dlfcn.h>

#include <cstring>
#include <stdexcept>

namespace {

constexpr const char* kLayer = "VK_LAYER_KHRONOS_validation";

void require(bool condition, const char* what) {
  if (!condition) throw std::runtime_error(what);
}

VKAPI_ATTR VkBool32 VKAPI_CALL keep_message(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                            VkDebugUtilsMessageTypeFlagsEXT,
                                            const VkDebugUtilsMessengerCallbackDataEXT* data,
                                            void* user) {
  static_cast<std::vector<std::string>*>(user)->emplace_back(data->pMessage);
  return VK_FALSE;
}

}  // namespace

void check(VkResult result, const char* call) {
  if (result != VK_SUCCESS)
    throw std::runtime_error(std::string(call) + ": " + std::to_string(result));
}

Application::Application() {
  library_ = ::dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  require(library_ != nullptr, "no Vulkan loader");
  get_instance_proc =
      reinterpret_cast<PFN_vkGetInstanceProcAddr>(::dlsym(library_, "vkGetInstanceProcAddr"));
  make_instance();
  make_device();
  VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  pool.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
  pool.queueFamilyIndex = family;
  check(LOAD(*this, vkCreateCommandPool)(device, &pool, nullptr, &pool_), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool_;
  allocate.commandBufferCount = 1;
  check(LOAD(*this, vkAllocateCommandBuffers)(device, &allocate, &commands_),
        "vkAllocateCommandBuffers");
}

void Application::make_instance() {
  std::uint32_t count = 0;
  const auto enumerate = LOAD(*this, vkEnumerateInstanceLayerProperties);
  check(enumerate(&count, nullptr), "vkEnumerateInstanceLayerProperties");
  std::vector<VkLayerProperties> layers(count);
  check(enumerate(&count, layers.data()), "vkEnumerateInstanceLayerProperties");
  bool validates = false;
  for (const VkLayerProperties& layer : layers)
    validates |= std::strcmp(layer.layerName, kLayer) == 0;

  VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
  application.apiVersion = VK_API_VERSION_1_1;
  const char* extension = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
  const VkValidationFeatureEnableEXT enabled =
      VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT};
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &enabled;
  VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
  info.pApplicationInfo = &application;
  if (validates) {
    info.pNext = &features;
    info.enabledLayerCount = 1;
    info.ppEnabledLayerNames = &kLayer;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
  }
  check(LOAD(*this, vkCreateInstance)(&info, nullptr, &instance), "vkCreateInstance");
  if (!validates) return;
  VkDebugUtilsMessengerCreateInfoEXT messenger{
      VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
  messenger.messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT |
                              VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
  messenger.pfnUserCallback = keep_message;
  messenger.pUserData = &messages;
  check(LOAD(*this, vkCreateDebugUtilsMessengerEXT)(instance, &messenger, nullptr, &messenger_),
        "vkCreateDebugUtilsMessengerEXT");
}

void Application::make_device() {
  std::uint32_t count = 1;
  const VkResult found =
      LOAD(*this, vkEnumeratePhysicalDevices)(instance, &count, &physical_device);
  require((found == VK_SUCCESS || found == VK_INCOMPLETE) && count == 1, "no Vulkan device");
  LOAD(*this, vkGetPhysicalDeviceQueueFamilyProperties)(physical_device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  LOAD(*this, vkGetPhysicalDeviceQueueFamilyProperties)(physical_device, &count, families.data());
  constexpr VkQueueFlags kWanted = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_GRAPHICS_BIT;
  while (family < count && (families[family].queueFlags & kWanted) != kWanted) ++family;
  require(family < count, "no queue family with compute and graphics");
  const float priority = 1;
  VkDeviceQueueCreateInfo queue_info{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue_info.queueFamilyIndex = family;
  queue_info.queueCount = 1;
  queue_info.pQueuePriorities = &priority;
  VkPhysicalDeviceProperties properties;
  LOAD(*this, vkGetPhysicalDeviceProperties)(physical_device, &properties);
  is_software = properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
  VkPhysicalDeviceFeatures offered, wanted{};
  LOAD(*this, vkGetPhysicalDeviceFeatures)(physical_device, &offered);
  has_tessellation = offered.tessellationShader == VK_TRUE;
  wanted.tessellationShader = offered.tessellationShader;
  VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.pEnabledFeatures = &wanted;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue_info;
  check(LOAD(*this, vkCreateDevice)(physical_device, &info, nullptr, &device), "vkCreateDevice");
  LOAD(*this, vkGetDeviceQueue)(device, family, 0, &queue);
}

Application::~Application() {
  for (const MappedBuffer& buffer : buffers_) {
    LOAD(*this, vkDestroyBuffer)(device, buffer.handle, nullptr);
    LOAD(*this, vkFreeMemory)(device, buffer.memory, nullptr);
  }
  LOAD(*this, vkDestroyCommandPool)(device, pool_, nullptr);
  LOAD(*this, vkDestroyDevice)(device, nullptr);
  if (messenger_) LOAD(*this, vkDestroyDebugUtilsMessengerEXT)(instance, messenger_, nullptr);
  LOAD(*this, vkDestroyInstance)(instance, nullptr);
  ::dlclose(library_);
}

std::uint32_t Application::memory_type(std::uint32_t types, VkMemoryPropertyFlags wanted) const {
  VkPhysicalDeviceMemoryProperties memory;
  LOAD(*this, vkGetPhysicalDeviceMemoryProperties)(physical_device, &memory);
  std::uint32_t type = 0;
  while (type < memory.memoryTypeCount &&
         (!(types >> type & 1) || (memory.memoryTypes[type].propertyFlags & wanted) != wanted))
    ++type;
  require(type < memory.memoryTypeCount, "no such memory");
  return type;
}

MappedBuffer Application::make_buffer(VkDeviceSize size, VkBufferUsageFlags usage) {
  MappedBuffer& buffer = buffers_.emplace_back();
  VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = size;
  info.usage = usage;
  check(LOAD(*this, vkCreateBuffer)(device, &info, nullptr, &buffer.handle), "vkCreateBuffer");
  VkMemoryRequirements requirements;
  LOAD(*this, vkGetBufferMemoryRequirements)(device, buffer.handle, &requirements);
  VkMemoryAllocateInfo allocate{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  allocate.allocationSize = requirements.size;
  allocate.memoryTypeIndex =
      memory_type(requirements.memoryTypeBits,
                  VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
  check(LOAD(*this, vkAllocateMemory)(device, &allocate, nullptr, &buffer.memory),
        "vkAllocateMemory");
  check(LOAD(*this, vkBindBufferMemory)(device, buffer.handle, buffer.memory, 0),
        "vkBindBufferMemory");
  void* place = nullptr;
  check(LOAD(*this, vkMapMemory)(device, buffer.memory, 0, VK_WHOLE_SIZE, 0, &place),
        "vkMapMemory");
  buffer.bytes = {static_cast<std::byte*>(place), static_cast<std::size_t>(size)};
  return buffer;
}

void Application::run(const std::function<void(VkCommandBuffer)>& record) {
  VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  check(LOAD(*this, vkBeginCommandBuffer)(commands_, &begin), "vkBeginCommandBuffer");
  record(commands_);
  check(LOAD(*this, vkEndCommandBuffer)(commands_), "vkEndCommandBuffer");
  VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands_;
  check(LOAD(*this, vkQueueSubmit)(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
  check(LOAD(*this, vkQueueWaitIdle)(queue), "vkQueueWaitIdle");
}

void Application::vertices_after(VkCommandBuffer commands, VkPipelineStageFlags stages,
                                 VkAccessFlags accesses) {
  VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = accesses;
  barrier.dstAccessMask = VK_ACCESS_VERTEX_ATTRIBUTE_READ_BIT | VK_ACCESS_HOST_READ_BIT;
  LOAD(*this, vkCmdPipelineBarrier)
  (commands, stages, VK_PIPELINE_STAGE_VERTEX_INPUT_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1,
   &barrier, 0, nullptr, 0, nullptr);
}
