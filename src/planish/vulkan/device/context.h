#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/vulkan/device/driver.h"

namespace planish::vulkan {

/// Stages and accesses on one side of a barrier.
struct Scope {
  VkPipelineStageFlags stages;
  VkAccessFlags accesses;
};

inline constexpr Scope kKernelScope{VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
                                    VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT};
inline constexpr Scope kCopyScope{VK_PIPELINE_STAGE_TRANSFER_BIT,
                                  VK_ACCESS_TRANSFER_READ_BIT | VK_ACCESS_TRANSFER_WRITE_BIT};
inline constexpr Scope kIndirectScope{VK_PIPELINE_STAGE_DRAW_INDIRECT_BIT | kKernelScope.stages,
                                      VK_ACCESS_INDIRECT_COMMAND_READ_BIT | kKernelScope.accesses};
/// Everything that a record_ function does; what a host's own barriers pair with. Before: from what
/// the host did to kEntryScope. After: from kExitScope to what the host does next.
inline constexpr Scope kEntryScope{kIndirectScope.stages | kCopyScope.stages,
                                   kIndirectScope.accesses | kCopyScope.accesses};
inline constexpr Scope kExitScope = kEntryScope;
inline constexpr Scope kHostReadScope{VK_PIPELINE_STAGE_HOST_BIT, VK_ACCESS_HOST_READ_BIT};

/// The first multiple of `step` that is not below `value`.
[[nodiscard]] constexpr std::uint64_t round_up(std::uint64_t value, std::uint64_t step) {
  return (value + step - 1) / step * step;
}

/// What a buffer's memory is for.
enum class MemoryUse {
  Device,    ///< read and written by kernels only
  Upload,    ///< written by the host, mapped
  Download,  ///< read by the host, mapped, cached where possible
};

struct MemoryRequest {
  VkMemoryRequirements requirements;
  MemoryUse use;
};

/// A piece of device memory. `mapped` is null for MemoryUse::Device.
struct MemoryBlock {
  VkDeviceMemory memory = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
  void* mapped = nullptr;
  bool coherent = true;    ///< false: planish flushes and invalidates [offset, offset + size)
  void* owner = nullptr;   ///< the host allocator's own handle, if any; without hooks: the page
  std::uint32_t heap = 0;  ///< without hooks: the heap that it is taken from
  VkDeviceSize size = 0;   ///< bytes from `offset` on; 0: as many as were requested
};

/// How a host's allocator serves every allocation, of which an object has one for each MemoryUse.
/// Both or neither are set. They are called without a lock of planish's, from any thread that makes
/// or destroys objects. `allocate` may throw planish::Error, `free` nothing. A block has memory,
/// begins at a multiple of the requested alignment, and is mapped for Upload and Download, which
/// are requested in whole multiples of nonCoherentAtomSize: one that is not so is freed again, and
/// Error{InvalidArgument} says what it lacks.
struct MemoryHooks {
  std::function<MemoryBlock(const MemoryRequest&)> allocate;
  std::function<void(const MemoryBlock&)> free;
};

/// Gives memory to arenas, by the hooks or by vkAllocateMemory, and counts it. Small blocks share
/// an allocation, a page: devices need not allow more than 4096. Thread-safe.
class MemoryAllocator {
 public:
  MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                  const Capabilities& capabilities, const VkAllocationCallbacks* callbacks,
                  MemoryHooks hooks, bool has_addresses);
  ~MemoryAllocator();

  /// Throws Error{OutOfMemory} before taking memory that a heap or limit does not allow, naming
  /// it.
  [[nodiscard]] MemoryBlock allocate(const MemoryRequest& request);
  void free(const MemoryBlock& block, VkDeviceSize size) noexcept;

  [[nodiscard]] std::uint64_t peak_bytes() const;
  [[nodiscard]] bool has_hooks() const { return static_cast<bool>(hooks_.allocate); }

 private:
  [[nodiscard]] std::uint32_t pick_type(const MemoryRequest& request) const;
  /// Why so many bytes of a type cannot be had; empty if they can.
  [[nodiscard]] std::string lacking_room(std::uint32_t type, std::uint64_t size) const;
  struct Page;
  [[nodiscard]] MemoryBlock allocate_own(const MemoryRequest& request);
  /// A whole VkDeviceMemory.
  [[nodiscard]] MemoryBlock take(std::uint32_t type, std::uint64_t size, bool is_mapped);
  void give_back(const MemoryBlock& block, std::uint64_t size) noexcept;
  /// From a page of the type, made if need be; without memory where a heap has no room for one.
  [[nodiscard]] MemoryBlock from_page(const MemoryRequest& request, std::uint32_t type);
  /// Throws Error{InvalidArgument} for a block that cannot serve the request, once it is freed.
  [[nodiscard]] MemoryBlock allocate_by_hook(const MemoryRequest& request) const;
  void count(std::uint64_t size);  // under the lock

  const DeviceFunctions& vk_;
  VkDevice device_;
  const Capabilities& capabilities_;
  const VkAllocationCallbacks* callbacks_;
  MemoryHooks hooks_;
  bool has_addresses_;  // shaders may know where buffers are
  mutable std::mutex mutex_;
  std::array<std::uint64_t, VK_MAX_MEMORY_HEAPS> heap_bytes_{};  // taken without hooks
  std::vector<std::unique_ptr<Page>> pages_;
  std::uint64_t used_ = 0;
  std::uint64_t peak_ = 0;
};

/// What bindings.h names.
enum class Kernel : std::uint32_t;

/// What a binding holds. All but Storage are read only, and are uniform texel buffers where the
/// device reads those faster.
enum class Binding { Storage, Entries, Words, Records, Points, Pairs, Floats };

/// How kernels read the arrays that they only read.
enum class ReadPath { Storage, Texel };

/// VK_FORMAT_UNDEFINED for a storage buffer.
[[nodiscard]] VkFormat texel_format(Binding binding, ReadPath path);
[[nodiscard]] VkDescriptorType descriptor_type(Binding binding, ReadPath path);

struct Pipeline {
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  std::span<const Binding> bindings;
  std::uint32_t parameter_bytes = 0;  ///< size of its push constants
};

struct PipelineVariant {
  ReadPath read_path = ReadPath::Storage;
  std::uint32_t chunks_per_group = 1;  ///< chunks of kChunkRows rows that a table kernel walks
  bool lane_sums = false;              ///< partial sums per lane instead of per work group
};

/// Specialisation constants below this one follow from the variant.
inline constexpr std::uint32_t kFirstOwnConstant = 3;

/// The compute pipelines of all kernels on one device, each compiled when it is first wanted.
class Pipelines {
 public:
  /// Makes the layouts. Throws planish::Error.
  Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
            const VkAllocationCallbacks* callbacks, const PipelineVariant& variant,
            const DebugLabels& labels);
  ~Pipelines();
  Pipelines(const Pipelines&) = delete;
  Pipelines& operator=(const Pipelines&) = delete;

  /// With a VkPipeline once it was prepared.
  [[nodiscard]] const Pipeline& operator[](Kernel kernel) const {
    return pipelines_[static_cast<std::size_t>(kernel)];
  }

  /// Compiles the kernel, which is not only specialised, unless that was done. Thread-safe. Throws
  /// planish::Error.
  void prepare(Kernel kernel) const;

  /// The kernel with its own specialisation constants, those with ids from kFirstOwnConstant on,
  /// instead of their defaults. Compiled when first asked for; as long-lived as this. Thread-safe.
  /// Throws planish::Error.
  [[nodiscard]] Pipeline specialised(Kernel kernel, std::span<const std::uint32_t> constants) const;

 private:
  void create(Kernel kernel);
  [[nodiscard]] VkPipeline compile(Kernel kernel, VkPipelineLayout layout,
                                   std::span<const std::uint32_t> constants) const;
  void destroy() noexcept;

  const DeviceFunctions& vk_;
  VkDevice device_;
  VkPipelineCache cache_;
  const VkAllocationCallbacks* callbacks_;
  PipelineVariant variant_;
  const DebugLabels& labels_;
  mutable std::vector<Pipeline> pipelines_;
  mutable std::mutex mutex_;  // of what is compiled
  mutable std::map<std::pair<Kernel, std::vector<std::uint32_t>>, VkPipeline> specialised_;
};

class OwnDevice;

/// What the host enabled on its instance and device: that cannot be asked of a VkDevice. planish
/// needs none of it.
struct EnabledFeatures {
  bool debug_utils = false;  ///< VK_EXT_debug_utils: objects get names, recorded work gets labels
};

/// What a host gives. Nothing is owned; everything must outlive the Context.
struct HostDevice {
  PFN_vkGetInstanceProcAddr get_instance_proc = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
  /// The lower of VkApplicationInfo::apiVersion and the device's; 1.1 at least.
  std::uint32_t api_version = VK_API_VERSION_1_1;
  EnabledFeatures features;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;
  const VkAllocationCallbacks* allocation_callbacks = nullptr;
  MemoryHooks memory;
  /// Gets what a developer may want to know, one line a call: what was chosen, how large tables
  /// are, and which record_ function did nothing for want of an option. Called where objects are
  /// made, and by that function, on the thread that does so.
  std::function<void(std::string_view)> log;
};

/// Where a CPU plays the device, storage buffers are read lane by lane but texel buffers by
/// gathers, barriers suspend every subgroup, and a work group's fixed costs weigh more.
inline constexpr PipelineVariant kSoftwareVariant{ReadPath::Texel, 16, true};
inline constexpr PipelineVariant kHardwareVariant{ReadPath::Storage, 1, false};

struct ContextOptions {
  /// Bytes that one binding may span at most, below the device's limit; 0: the device's limit.
  std::uint64_t max_storage_range = 0;
  /// Work groups of one dispatch at most, below the device's limit; 0: the device's limit.
  std::uint32_t max_group_count = 0;
  /// How kernels read and sum; unset: what suits the device.
  std::optional<PipelineVariant> variant;
  /// What else the host does with buffers that planish makes, as an osd::VkVertexBuffer whose
  /// triangles rays meet: VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR and
  /// VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT. With the latter memory has addresses, too; that of
  /// MemoryHooks is the host's to allocate so. The device has enabled what they need.
  VkBufferUsageFlags further_usage = 0;
};

/// Device functions, limits, memory and pipelines: what all objects on a device share. Never
/// submits, never waits. Thread-safe; outlives every object made with it.
class Context {
 public:
  /// Throws Error{NoDevice} where the device is not usable, saying why.
  explicit Context(const HostDevice& host, const ContextOptions& options = {});
  /// On the command's own device, which outlives the Context.
  explicit Context(const OwnDevice& own, const ContextOptions& options = {});

  [[nodiscard]] const DeviceFunctions& vk() const { return functions_; }
  [[nodiscard]] VkDevice device() const { return device_; }
  [[nodiscard]] const VkAllocationCallbacks* callbacks() const { return callbacks_; }
  [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }
  [[nodiscard]] MemoryAllocator& memory() { return memory_; }
  [[nodiscard]] const Pipelines& pipelines() const { return pipelines_; }

  /// Of maxStorageBufferRange, maxMemoryAllocationSize and, where kernels read texel buffers,
  /// maxTexelBufferElements of four bytes, the smallest that they have.
  [[nodiscard]] const BindingLimit& binding_limit() const { return binding_limit_; }
  [[nodiscard]] std::uint64_t max_storage_range() const { return binding_limit_.bytes; }
  [[nodiscard]] std::uint32_t max_group_count() const { return max_group_count_; }
  /// Work groups of a dispatch in x and z: in z more than one where x may not be as many, so that
  /// some may be too many. Kernels take them by item_of_lane().
  struct Groups {
    std::uint32_t x, z;
  };
  [[nodiscard]] Groups groups_in_layers(std::uint32_t groups) const {
    const std::uint32_t layers = groups / max_group_count_ + (groups % max_group_count_ ? 1 : 0);
    return layers <= 1 ? Groups{groups, 1} : Groups{max_group_count_, layers};
  }
  /// Work groups of a dispatch whose lanes go on with further items after their own: as many as
  /// `count` items need, or may be.
  [[nodiscard]] std::uint32_t groups_of(std::uint64_t count, std::uint32_t lanes = 64) const {
    return static_cast<std::uint32_t>(
        std::min<std::uint64_t>((count + lanes - 1) / lanes, max_group_count_));
  }
  [[nodiscard]] const PipelineVariant& variant() const { return variant_; }
  [[nodiscard]] VkBufferUsageFlags further_usage() const { return further_usage_; }

  [[nodiscard]] const DebugLabels& labels() const { return labels_; }
  void log(std::string_view line) const {
    if (log_) log_(line);
  }
  /// The same while recording, which cannot fail: what the host throws is dropped.
  void tell(std::string_view line) const noexcept;

 private:
  VkDevice device_;
  const VkAllocationCallbacks* callbacks_;
  Capabilities capabilities_;
  PipelineVariant variant_;
  BindingLimit binding_limit_;
  std::uint32_t max_group_count_;
  VkBufferUsageFlags further_usage_;
  std::function<void(std::string_view)> log_;
  DeviceFunctions functions_;
  DebugLabels labels_;
  MemoryAllocator memory_;
  Pipelines pipelines_;
};

}  // namespace planish::vulkan
