#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "planish/vulkan/device/driver.h"
#include "vulkan/pretended_notes.h"

namespace planish::testing {

/// A vkGetInstanceProcAddr between planish and the loader: it counts what planish calls and what it
/// leaves alive, and on demand pretends that calls fail, that limits are low and that memory is not
/// what it is. Vulkan hands no state to functions: there is one, for one device at a time.
class PretendedDriver {
 public:
  /// Forgets all counts and pretends nothing.
  static void reset();
  static PFN_vkGetInstanceProcAddr get_proc();

  struct Pretence {
    std::uint32_t storage_buffers = 0;  ///< maxPerStageDescriptorStorageBuffers; 0: the real one
    std::uint32_t storage_range = 0;    ///< maxStorageBufferRange, bytes; 0: the real one
    std::uint64_t allocation_size = 0;  ///< maxMemoryAllocationSize, bytes; 0: the real one
    std::uint32_t texel_elements = 0;   ///< maxTexelBufferElements; 0: the real one
    std::uint32_t group_count = 0;      ///< maxComputeWorkGroupCount in x; 0: the real one
    /// Memory that only the device sees, and two types that the host sees, of which none is
    /// coherent.
    bool split_memory = false;
    /// Bytes of a heap of device memory that the host sees too, named before the host's own heap;
    /// 0: the real heaps. Device and host have 64 MiB and `host_bytes` beside it.
    std::uint64_t bar_bytes = 0, host_bytes = 64u << 20;
    bool no_subgroup_operations = false;
    std::uint32_t subgroup_size = 0;  ///< that is told of; 0: the real one
    bool no_timestamps = false;
    bool portability_subset = false;
    /// Two queue families: 0 without compute, and 1 that only computes.
    bool separate_compute = false;
    bool graphics_compute = false;  ///< of separate families, the first computes, too
    std::uint32_t api_version = 0;  ///< 0: the real one
    VkResult submit_result = VK_SUCCESS;
    /// Submissions until the device is lost for good; negative: it never is.
    int submissions_left = -1;
    /// Which of the calls that return a VkResult fails, counted from 1; 0: none.
    int failing_call = 0;
    VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  };
  static Pretence& pretence();

  /// Calls since reset() by function, only of functions that planish asked for.
  static std::map<std::string, int> counts();
  static int count(const std::string& function);
  /// Calls that return a VkResult and whose failure matters.
  static int fallible_calls();
  /// What vkCreate and vkAllocateMemory made and nothing destroyed, by kind; pools count for what
  /// is allocated from them.
  static std::map<std::string, int> alive();
  /// Functions that planish asked for and that are not counted.
  static std::map<std::string, int> uncounted();
  /// Of the pretended families: those that devices, queues and pools were made for.
  static std::set<std::uint32_t> used_families();
  /// Barriers that hand a buffer from one family to another, by both.
  static std::map<std::pair<std::uint32_t, std::uint32_t>, int> transfers();
  /// What was asked to be made visible to the device and to the host.
  static std::vector<VkMappedMemoryRange> flushed();
  static std::vector<VkMappedMemoryRange> invalidated();
  /// Dispatches, copies, bindings and texel buffers beyond the pretended limits, their buffers or
  /// the widest alignments, in words.
  static std::set<std::string> broken_rules();
  /// What calls were given.
  static PretendedNotes notes();
  static void forget_notes();
  /// Memory of the pretended type 0, which only the device sees, that was mapped.
  static int illegal_maps();
};

}  // namespace planish::testing
