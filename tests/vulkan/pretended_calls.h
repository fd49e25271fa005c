#pragma once

#include <dlfcn.h>
#include <vulkan/vulkan_core.h>

#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>

#include "planish/vulkan/device/driver.h"

// All functions that a program is given.
#define PRETENDED_OTHERS(X)          \
  X(vkCreateInstance)                \
  X(vkCreateDebugUtilsMessengerEXT)  \
  X(vkDestroyDebugUtilsMessengerEXT) \
  X(vkSetDebugUtilsObjectNameEXT)    \
  X(vkCmdBeginDebugUtilsLabelEXT)    \
  X(vkCmdEndDebugUtilsLabelEXT)

#define PRETENDED_ALL(X)               \
  PLANISH_VULKAN_INSTANCE_FUNCTIONS(X) \
  PLANISH_VULKAN_DEVICE_FUNCTIONS(X)   \
  PRETENDED_OTHERS(X)

namespace planish::testing {

/// What a function makes or destroys; empty for others, and for what pools free.
inline std::string kind_of(std::string_view name) {
  if (name == "vkCreateComputePipelines") return "Pipeline";
  for (const char* verb : {"vkCreate", "vkDestroy", "vkAllocate", "vkFree"})
    if (name.starts_with(verb)) {
      const std::string kind(name.substr(std::strlen(verb)));
      return kind == "DescriptorSets" || kind == "CommandBuffers" ? std::string() : kind;
    }
  return {};
}

/// Whether a destroying function, (handle, callbacks) or (parent, handle, callbacks), is given
/// one.
template <class Handle>
bool is_handle(Handle handle, const VkAllocationCallbacks*) {
  return handle != VK_NULL_HANDLE;
}
template <class Parent, class Handle>
bool is_handle(Parent, Handle handle, const VkAllocationCallbacks*) {
  return handle != VK_NULL_HANDLE;
}
template <class... Others>
bool is_handle(Others...) {
  return false;
}

/// Threads may ask for functions at the same time: only the first answer is written.
template <class Function>
void keep(Function& kept, PFN_vkVoidFunction function) {
  if (kept != reinterpret_cast<Function>(function)) kept = reinterpret_cast<Function>(function);
}

inline PFN_vkGetInstanceProcAddr loader() {
  static void* const library = ::dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error("no Vulkan loader");
  return reinterpret_cast<PFN_vkGetInstanceProcAddr>(::dlsym(library, "vkGetInstanceProcAddr"));
}

}  // namespace planish::testing
