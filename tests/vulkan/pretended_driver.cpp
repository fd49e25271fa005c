#include "vulkan/pretended_driver.h"

#include <dlfcn.h>
#include <vulkan/vulkan_core.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

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
namespace {

// What a function makes or destroys; empty for others, and for what pools free.
std::string kind_of(std::string_view name) {
  if (name == "vkCreateComputePipelines") return "Pipeline";
  for (const char* verb : {"vkCreate", "vkDestroy", "vkAllocate", "vkFree"})
    if (name.starts_with(verb)) {
      const std::string kind(name.substr(std::strlen(verb)));
      return kind == "DescriptorSets" || kind == "CommandBuffers" ? std::string() : kind;
    }
  return {};
}

// Whether a destroying function, (handle, callbacks) or (parent, handle, callbacks), is given
// one.
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

// Threads may ask for functions at the same time: only the first answer is written.
template <class Function>
void keep(Function& kept, PFN_vkVoidFunction function) {
  if (kept != reinterpret_cast<Function>(function)) kept = reinterpret_cast<Function>(function);
}

PFN_vkGetInstanceProcAddr loader() {
  static void* const library = ::dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) throw std::runtime_error("no Vulkan loader");
  return reinterpret_cast<PFN_vkGetInstanceProcAddr>(::dlsym(library, "vkGetInstanceProcAddr"));
}

#define PRETENDED_SLOT(name) Slot_##name,
#define PRETENDED_NAME(name) #name,
#define PRETENDED_MEMBER(name) PFN_##name name = nullptr;
enum Slot : int { PRETENDED_ALL(PRETENDED_SLOT) kSlotCount };
constexpr const char* kNames[] = {PRETENDED_ALL(PRETENDED_NAME)};

// The loader's and the driver's functions.
struct Real {
  PRETENDED_ALL(PRETENDED_MEMBER)
} real;

struct State {
  PretendedDriver::Pretence pretence;
  VkDevice device = VK_NULL_HANDLE;  // the last one made
  std::array<std::atomic<int>, kSlotCount> counts{};
  std::atomic<int> fallible{0}, illegal_maps{0};
  NoteTaker notes;
  RuleBook rules;
  std::mutex mutex;  // guards what follows
  std::map<std::string, int> alive, uncounted;
  std::set<VkDeviceMemory> device_only;
  std::set<std::uint32_t> used_families;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> transfers;
  std::vector<VkMappedMemoryRange> flushed, invalidated;
  std::uint32_t mapped_type = 0;  // of the device's own memory, that all pretended types stand for
} state;

constexpr const char* kPortabilitySubset = "VK_KHR_portability_subset";

PFN_vkVoidFunction VKAPI_CALL get_device_proc(VkDevice device, const char* name);

// What pretends something calls the real function itself; the rest are the real functions.

void VKAPI_CALL get_properties(VkPhysicalDevice device, VkPhysicalDeviceProperties2* properties) {
  real.vkGetPhysicalDeviceProperties2(device, properties);
  const PretendedDriver::Pretence& pretence = state.pretence;
  VkPhysicalDeviceLimits& limits = properties->properties.limits;
  if (pretence.api_version) properties->properties.apiVersion = pretence.api_version;
  if (pretence.storage_buffers)
    limits.maxPerStageDescriptorStorageBuffers = pretence.storage_buffers;
  if (pretence.storage_range) limits.maxStorageBufferRange = pretence.storage_range;
  if (pretence.texel_elements) limits.maxTexelBufferElements = pretence.texel_elements;
  if (pretence.group_count) limits.maxComputeWorkGroupCount[0] = pretence.group_count;
  if (pretence.split_memory) limits.nonCoherentAtomSize = 256;
  state.rules.set_limits({limits.maxComputeWorkGroupCount[0], limits.maxStorageBufferRange,
                          limits.maxTexelBufferElements});
  for (auto* next = static_cast<VkBaseOutStructure*>(properties->pNext); next; next = next->pNext) {
    if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES &&
        pretence.allocation_size)
      reinterpret_cast<VkPhysicalDeviceMaintenance3Properties*>(next)->maxMemoryAllocationSize =
          pretence.allocation_size;
    if (next->sType != VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES) continue;
    auto* subgroup = reinterpret_cast<VkPhysicalDeviceSubgroupProperties*>(next);
    if (pretence.no_subgroup_operations) {
      subgroup->supportedOperations = 0;
      subgroup->supportedStages = 0;
      subgroup->subgroupSize = 1;
    }
    if (pretence.subgroup_size) subgroup->subgroupSize = pretence.subgroup_size;
  }
}

bool is_other_memory() { return state.pretence.split_memory || state.pretence.bar_bytes > 0; }

void VKAPI_CALL get_memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties* memory) {
  real.vkGetPhysicalDeviceMemoryProperties(device, memory);
  if (!is_other_memory()) return;
  state.mapped_type = mapped_type(*memory, ~0u);
  if (state.pretence.bar_bytes > 0)
    *memory = discrete_memory(state.pretence.bar_bytes, state.pretence.host_bytes);
  else
    split_memory(memory->memoryTypes[state.mapped_type].heapIndex, *memory);
}

// What a pretended family is in truth.
std::uint32_t real_family(std::uint32_t family) {
  if (!state.pretence.separate_compute) return family;
  const std::lock_guard lock(state.mutex);
  state.used_families.insert(family);
  return 0;
}

void VKAPI_CALL get_families(VkPhysicalDevice device, std::uint32_t* count,
                             VkQueueFamilyProperties* families) {
  if (state.pretence.separate_compute) {
    *count = 2;
    if (!families) return;
    std::uint32_t one = 1;
    real.vkGetPhysicalDeviceQueueFamilyProperties(device, &one, families);
    families[1] = families[0];
    families[0].queueFlags = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_TRANSFER_BIT;
    if (state.pretence.graphics_compute) families[0].queueFlags |= VK_QUEUE_COMPUTE_BIT;
    families[1].queueFlags = VK_QUEUE_COMPUTE_BIT | VK_QUEUE_TRANSFER_BIT;
    return;
  }
  real.vkGetPhysicalDeviceQueueFamilyProperties(device, count, families);
  for (std::uint32_t i = 0; state.pretence.no_timestamps && families && i < *count; ++i)
    families[i].timestampValidBits = 0;
}

VkResult VKAPI_CALL get_extensions(VkPhysicalDevice device, const char* layer, std::uint32_t* count,
                                   VkExtensionProperties* extensions) {
  if (!state.pretence.portability_subset)
    return real.vkEnumerateDeviceExtensionProperties(device, layer, count, extensions);
  std::uint32_t real_count = extensions ? *count - 1 : 0;
  const VkResult result =
      real.vkEnumerateDeviceExtensionProperties(device, layer, &real_count, extensions);
  *count = real_count + 1;
  if (extensions) {
    extensions[real_count] = {};
    std::snprintf(extensions[real_count].extensionName, VK_MAX_EXTENSION_NAME_SIZE, "%s",
                  kPortabilitySubset);
  }
  return result;
}

VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                  const VkAllocationCallbacks* callbacks, VkDevice* device) {
  VkDeviceCreateInfo changed = *info;
  bool enables_subset = false;
  std::vector<const char*> extensions;
  for (std::uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    const char* name = info->ppEnabledExtensionNames[i];
    if (std::strcmp(name, kPortabilitySubset) == 0)
      enables_subset = true;
    else
      extensions.push_back(name);
  }
  // As the extension's rule wants it.
  if (enables_subset != state.pretence.portability_subset) return VK_ERROR_EXTENSION_NOT_PRESENT;
  changed.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  changed.ppEnabledExtensionNames = extensions.data();
  VkDeviceQueueCreateInfo queue = info->pQueueCreateInfos[0];
  queue.queueFamilyIndex = real_family(queue.queueFamilyIndex);
  changed.pQueueCreateInfos = &queue;
  const VkResult result = real.vkCreateDevice(physical, &changed, callbacks, device);
  if (result == VK_SUCCESS) state.device = *device;
  return result;
}

void VKAPI_CALL get_queue(VkDevice device, std::uint32_t family, std::uint32_t index,
                          VkQueue* queue) {
  real.vkGetDeviceQueue(device, real_family(family), index, queue);
}

VkResult VKAPI_CALL create_pool(VkDevice device, const VkCommandPoolCreateInfo* info,
                                const VkAllocationCallbacks* callbacks, VkCommandPool* pool) {
  VkCommandPoolCreateInfo changed = *info;
  changed.queueFamilyIndex = real_family(info->queueFamilyIndex);
  return real.vkCreateCommandPool(device, &changed, callbacks, pool);
}

void VKAPI_CALL put_barrier(VkCommandBuffer commands, VkPipelineStageFlags from,
                            VkPipelineStageFlags to, VkDependencyFlags flags, std::uint32_t memory,
                            const VkMemoryBarrier* memories, std::uint32_t buffer,
                            const VkBufferMemoryBarrier* buffers, std::uint32_t image,
                            const VkImageMemoryBarrier* images) {
  std::vector<VkBufferMemoryBarrier> changed(buffers, buffers + buffer);
  for (VkBufferMemoryBarrier& barrier : changed) {
    if (!state.pretence.separate_compute) break;
    const std::lock_guard lock(state.mutex);
    ++state.transfers[{barrier.srcQueueFamilyIndex, barrier.dstQueueFamilyIndex}];
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  }
  real.vkCmdPipelineBarrier(commands, from, to, flags, memory, memories, buffer, changed.data(),
                            image, images);
}

void VKAPI_CALL get_requirements(VkDevice device, VkBuffer buffer,
                                 VkMemoryRequirements* requirements) {
  real.vkGetBufferMemoryRequirements(device, buffer, requirements);
  if (state.pretence.split_memory) requirements->memoryTypeBits = 7;
  if (state.pretence.bar_bytes > 0) requirements->memoryTypeBits = 15;
}

VkResult VKAPI_CALL allocate_memory(VkDevice device, const VkMemoryAllocateInfo* info,
                                    const VkAllocationCallbacks* callbacks,
                                    VkDeviceMemory* memory) {
  const VkDeviceSize most = state.pretence.allocation_size;
  if (most && info->allocationSize > most) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  VkMemoryAllocateInfo changed = *info;
  if (is_other_memory()) changed.memoryTypeIndex = state.mapped_type;
  const VkResult result = real.vkAllocateMemory(device, &changed, callbacks, memory);
  if (is_other_memory() && result == VK_SUCCESS) {
    const std::lock_guard lock(state.mutex);
    if (info->memoryTypeIndex == 0)
      state.device_only.insert(*memory);
    else
      state.device_only.erase(*memory);
  }
  return result;
}

VkResult VKAPI_CALL map_memory(VkDevice device, VkDeviceMemory memory, VkDeviceSize offset,
                               VkDeviceSize size, VkMemoryMapFlags flags, void** data) {
  {
    const std::lock_guard lock(state.mutex);
    if (state.device_only.count(memory)) ++state.illegal_maps;
  }
  return real.vkMapMemory(device, memory, offset, size, flags, data);
}

void note_ranges(std::vector<VkMappedMemoryRange>& noted, std::uint32_t count,
                 const VkMappedMemoryRange* ranges) {
  const std::lock_guard lock(state.mutex);
  noted.insert(noted.end(), ranges, ranges + count);
}

VkResult VKAPI_CALL flush(VkDevice device, std::uint32_t count, const VkMappedMemoryRange* ranges) {
  note_ranges(state.flushed, count, ranges);
  return real.vkFlushMappedMemoryRanges(device, count, ranges);
}

VkResult VKAPI_CALL invalidate(VkDevice device, std::uint32_t count,
                               const VkMappedMemoryRange* ranges) {
  note_ranges(state.invalidated, count, ranges);
  return real.vkInvalidateMappedMemoryRanges(device, count, ranges);
}

VkResult VKAPI_CALL submit(VkQueue queue, std::uint32_t count, const VkSubmitInfo* infos,
                           VkFence fence) {
  if (state.pretence.submissions_left == 0) {
    // A lost device runs nothing any more.
    real.vkDeviceWaitIdle(state.device);
    return VK_ERROR_DEVICE_LOST;
  }
  if (state.pretence.submissions_left > 0) --state.pretence.submissions_left;
  return real.vkQueueSubmit(queue, count, infos, fence);
}

// The function behind a slot: ours where there is one.
template <Slot slot, class Function>
Function behind(Function otherwise) {
  if constexpr (slot == Slot_vkGetPhysicalDeviceProperties2) return get_properties;
  if constexpr (slot == Slot_vkGetPhysicalDeviceMemoryProperties) return get_memory;
  if constexpr (slot == Slot_vkGetPhysicalDeviceQueueFamilyProperties) return get_families;
  if constexpr (slot == Slot_vkEnumerateDeviceExtensionProperties) return get_extensions;
  if constexpr (slot == Slot_vkCreateDevice) return create_device;
  if constexpr (slot == Slot_vkGetDeviceProcAddr) return get_device_proc;
  if constexpr (slot == Slot_vkGetDeviceQueue) return get_queue;
  if constexpr (slot == Slot_vkCreateCommandPool) return create_pool;
  if constexpr (slot == Slot_vkCmdPipelineBarrier) return put_barrier;
  if constexpr (slot == Slot_vkGetBufferMemoryRequirements) return get_requirements;
  if constexpr (slot == Slot_vkAllocateMemory) return allocate_memory;
  if constexpr (slot == Slot_vkMapMemory) return map_memory;
  if constexpr (slot == Slot_vkFlushMappedMemoryRanges) return flush;
  if constexpr (slot == Slot_vkInvalidateMappedMemoryRanges) return invalidate;
  if constexpr (slot == Slot_vkQueueSubmit) return submit;
  return otherwise;
}

void note_alive(const std::string& kind, int change) {
  if (kind.empty()) return;
  const std::lock_guard lock(state.mutex);
  if ((state.alive[kind] += change) == 0) state.alive.erase(kind);
}

template <class Function>
struct Thunk;

template <class R, class... A>
struct Thunk<R(VKAPI_PTR*)(A...)> {
  using Function = R(VKAPI_PTR*)(A...);

  template <Slot slot, Function Real::*member>
  static R VKAPI_CALL call(A... arguments) {
    ++state.counts[slot];
    state.notes.take(arguments...);
    state.rules.look(arguments...);
    const Function function = behind<slot>(real.*member);
    if constexpr (std::is_same_v<R, VkResult>) {
      // A name that cannot be set is no error, and destructors wait as well as they can.
      if (slot != Slot_vkSetDebugUtilsObjectNameEXT && slot != Slot_vkDeviceWaitIdle &&
          ++state.fallible == state.pretence.failing_call)
        return state.pretence.failure;
      const VkResult result = function(arguments...);
      if (result >= 0) note_alive(kind_of(kNames[slot]), 1);
      if (result >= 0) state.rules.made(arguments...);
      return result;
    } else {
      if (is_handle(arguments...)) note_alive(kind_of(kNames[slot]), -1);
      return function(arguments...);
    }
  }
};

// The counting function of that name, whose real one is kept; or just the real one.
PFN_vkVoidFunction counted(const char* name, PFN_vkVoidFunction function) {
  if (!function) return nullptr;
#define PRETENDED_CASE(known)                                   \
  if (std::strcmp(name, #known) == 0) {                         \
    keep(real.known, function);                                 \
    return reinterpret_cast<PFN_vkVoidFunction>(                \
        &Thunk<PFN_##known>::call<Slot_##known, &Real::known>); \
  }
  PRETENDED_ALL(PRETENDED_CASE)
  const std::lock_guard lock(state.mutex);
  ++state.uncounted[name];
  return function;
}

PFN_vkVoidFunction VKAPI_CALL get_device_proc(VkDevice device, const char* name) {
  return counted(name, real.vkGetDeviceProcAddr(device, name));
}

PFN_vkVoidFunction VKAPI_CALL get_instance_proc(VkInstance instance, const char* name) {
  return counted(name, loader()(instance, name));
}

}  // namespace

void PretendedDriver::reset() {
  state.pretence = {};
  for (std::atomic<int>& count : state.counts) count = 0;
  state.fallible = 0;
  state.illegal_maps = 0;
  state.notes.reset();
  state.rules.reset();
  const std::lock_guard lock(state.mutex);
  state.alive.clear();
  state.uncounted.clear();
  state.device_only.clear();
  state.used_families.clear();
  state.transfers.clear();
  state.flushed.clear();
  state.invalidated.clear();
}

PFN_vkGetInstanceProcAddr PretendedDriver::get_proc() { return get_instance_proc; }
PretendedDriver::Pretence& PretendedDriver::pretence() { return state.pretence; }

std::map<std::string, int> PretendedDriver::counts() {
  std::map<std::string, int> result;
  for (int slot = 0; slot < kSlotCount; ++slot)
    if (state.counts[slot] > 0) result[kNames[slot]] = state.counts[slot];
  return result;
}

int PretendedDriver::count(const std::string& function) { return counts()[function]; }
int PretendedDriver::fallible_calls() { return state.fallible; }

// What calls on other threads change.
template <class T>
static T locked_copy(const T& of) {
  const std::lock_guard lock(state.mutex);
  return of;
}

std::map<std::string, int> PretendedDriver::alive() { return locked_copy(state.alive); }
std::map<std::string, int> PretendedDriver::uncounted() { return locked_copy(state.uncounted); }
std::set<std::uint32_t> PretendedDriver::used_families() {
  return locked_copy(state.used_families);
}
std::map<std::pair<std::uint32_t, std::uint32_t>, int> PretendedDriver::transfers() {
  return locked_copy(state.transfers);
}
std::vector<VkMappedMemoryRange> PretendedDriver::flushed() { return locked_copy(state.flushed); }
std::vector<VkMappedMemoryRange> PretendedDriver::invalidated() {
  return locked_copy(state.invalidated);
}

std::set<std::string> PretendedDriver::broken_rules() { return state.rules.broken(); }
PretendedNotes PretendedDriver::notes() { return state.notes.notes(); }
void PretendedDriver::forget_notes() { state.notes.reset(); }
int PretendedDriver::illegal_maps() { return state.illegal_maps; }

}  // namespace planish::testing
