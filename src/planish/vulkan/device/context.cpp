#include "planish/vulkan/device/context.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/vulkan/device/bindings.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"

namespace planish::vulkan {
namespace {

constexpr std::uint64_t kPageBytes = 4u << 20, kLargestInPage = 512u << 10;
constexpr std::uint64_t kPageStep = 256;

std::string_view name_of(MemoryUse use) {
  constexpr std::string_view kNames[] = {"Device", "Upload", "Download"};
  return kNames[static_cast<int>(use)];
}

// What a host's block lacks, and what to do; empty where it serves.
std::string lack_of(const MemoryBlock& block, const MemoryRequest& request) {
  const VkMemoryRequirements& needed = request.requirements;
  if (!block.memory)
    return "without memory; set MemoryBlock::memory, or throw Error{OutOfMemory} where there is "
           "none";
  if (block.offset % needed.alignment != 0)
    return formatted(
        "at MemoryBlock::offset {}, which is no multiple of {}; take "
        "MemoryRequest::requirements.alignment",
        block.offset, needed.alignment);
  if (block.size != 0 && block.size < needed.size)
    return formatted(
        "of MemoryBlock::size {}, but {} bytes are needed; take MemoryRequest::requirements.size",
        block.size, needed.size);
  if (request.use != MemoryUse::Device && !block.mapped)
    return "that is not mapped; set MemoryBlock::mapped";
  return "";
}

}  // namespace

/// Blocks one after another; room comes back when the last of them has gone.
struct MemoryAllocator::Page {
  MemoryBlock memory;
  std::uint32_t type = 0;
  std::uint64_t end = 0;
  std::size_t block_count = 0;
};

MemoryAllocator::MemoryAllocator(const DeviceFunctions& functions, VkDevice device,
                                 const Capabilities& capabilities,
                                 const VkAllocationCallbacks* callbacks, MemoryHooks hooks,
                                 bool has_addresses)
    : vk_(functions),
      device_(device),
      capabilities_(capabilities),
      callbacks_(callbacks),
      hooks_(std::move(hooks)),
      has_addresses_(has_addresses) {}

MemoryAllocator::~MemoryAllocator() = default;

// The first type with the flags wished for most whose heap has room: device memory that the host
// sees too is a small heap of many devices, and may come before their host's. For kernels nothing
// else will do: Vulkan promises device memory for every buffer, and in the host's they are slower
// than the CPU.
std::uint32_t MemoryAllocator::pick_type(const MemoryRequest& request) const {
  constexpr VkMemoryPropertyFlags kVisible = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT;
  constexpr VkMemoryPropertyFlags kCoherent = VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags kCached = VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  constexpr VkMemoryPropertyFlags kLocal = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  const std::initializer_list<VkMemoryPropertyFlags> wishes[] = {
      {kLocal}, {kVisible | kCoherent, kVisible}, {kVisible | kCached, kVisible}};
  const VkPhysicalDeviceMemoryProperties& memory = capabilities_.memory;
  std::string lacking;
  for (const VkMemoryPropertyFlags wish : wishes[static_cast<int>(request.use)]) {
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
      if ((request.requirements.memoryTypeBits >> i & 1u) == 0) continue;
      if ((memory.memoryTypes[i].propertyFlags & wish) != wish) continue;
      const std::string reason = lacking_room(i, request.requirements.size);
      if (reason.empty()) return i;
      if (lacking.empty()) lacking = reason;
    }
  }
  if (lacking.empty())
    throw Error(ErrorCode::OutOfMemory, capabilities_.name + " has no memory type for a buffer");
  throw Error(ErrorCode::OutOfMemory,
              formatted("{}: a buffer needs {} bytes, but {}; use --device cpu or a smaller mesh",
                        capabilities_.name, request.requirements.size, lacking));
}

std::string MemoryAllocator::lacking_room(std::uint32_t type, std::uint64_t size) const {
  if (size > capabilities_.max_allocation)
    return formatted("maxMemoryAllocationSize is {}", capabilities_.max_allocation);
  const std::uint32_t heap = capabilities_.memory.memoryTypes[type].heapIndex;
  const std::uint64_t heap_size = capabilities_.memory.memoryHeaps[heap].size;
  const std::uint64_t taken = heap_bytes_[heap];
  if (taken <= heap_size && size <= heap_size - taken) return "";
  return formatted("memory heap {} has {} bytes, of which {} are taken", heap, heap_size, taken);
}

MemoryBlock MemoryAllocator::take(std::uint32_t type, std::uint64_t size, bool is_mapped) {
  VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = size;
  info.memoryTypeIndex = type;
  VkMemoryAllocateFlagsInfo flags{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  if (has_addresses_) info.pNext = &flags;
  MemoryBlock block;
  check(vk_.vkAllocateMemory(device_, &info, callbacks_, &block.memory), "vkAllocateMemory");
  block.heap = capabilities_.memory.memoryTypes[type].heapIndex;
  block.coherent =
      capabilities_.memory.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  if (is_mapped) {
    const VkResult mapped =
        vk_.vkMapMemory(device_, block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped);
    if (mapped != VK_SUCCESS) vk_.vkFreeMemory(device_, block.memory, callbacks_);
    check(mapped, "vkMapMemory");
  }
  heap_bytes_[block.heap] += size;
  return block;
}

void MemoryAllocator::give_back(const MemoryBlock& block, std::uint64_t size) noexcept {
  vk_.vkFreeMemory(device_, block.memory, callbacks_);
  heap_bytes_[block.heap] -= size;
}

MemoryBlock MemoryAllocator::from_page(const MemoryRequest& request, std::uint32_t type) {
  const bool is_mapped = request.use != MemoryUse::Device;
  // Blocks of their own atoms, which flushing and invalidating takes whole.
  const std::uint64_t step =
      std::max({request.requirements.alignment, capabilities_.non_coherent_atom, kPageStep});
  const std::uint64_t size = round_up(request.requirements.size, step);
  const auto fits = [&](const std::unique_ptr<Page>& page) {
    return page->type == type && (page->memory.mapped != nullptr) == is_mapped &&
           round_up(page->end, step) + size <= kPageBytes;
  };
  auto found = std::ranges::find_if(pages_, fits);
  if (found == pages_.end()) {
    if (!lacking_room(type, kPageBytes).empty()) return {};
    auto page = std::make_unique<Page>();
    pages_.reserve(pages_.size() + 1);
    page->memory = take(type, kPageBytes, is_mapped);
    page->type = type;
    pages_.push_back(std::move(page));
    found = pages_.end() - 1;
  }
  Page& page = **found;
  MemoryBlock block = page.memory;
  block.offset = round_up(page.end, step);
  if (is_mapped) block.mapped = static_cast<std::byte*>(page.memory.mapped) + block.offset;
  block.owner = &page;
  page.end = block.offset + size;
  ++page.block_count;
  return block;
}

MemoryBlock MemoryAllocator::allocate_own(const MemoryRequest& request) {
  const std::uint32_t type = pick_type(request);
  if (request.requirements.size <= kLargestInPage) {
    const MemoryBlock block = from_page(request, type);
    if (block.memory) return block;
  }
  return take(type, request.requirements.size, request.use != MemoryUse::Device);
}

MemoryBlock MemoryAllocator::allocate_by_hook(const MemoryRequest& request) const {
  const MemoryBlock block = hooks_.allocate(request);
  const std::string lack = lack_of(block, request);
  if (lack.empty()) return block;
  if (block.memory) hooks_.free(block);
  throw Error(
      ErrorCode::InvalidArgument,
      formatted("MemoryHooks::allocate returned a block for {} {}", name_of(request.use), lack));
}

void MemoryAllocator::count(std::uint64_t size) {
  used_ += size;
  peak_ = std::max(peak_, used_);
}

// A hook may take the host's lock, under which the host may make objects of planish's: ours is
// never held while it runs.
MemoryBlock MemoryAllocator::allocate(const MemoryRequest& request) {
  const std::uint64_t size = request.requirements.size;
  if (has_hooks()) {
    const MemoryBlock block = allocate_by_hook(request);
    const std::lock_guard lock(mutex_);
    count(size);
    return block;
  }
  const std::lock_guard lock(mutex_);
  const MemoryBlock block = allocate_own(request);
  count(size);
  return block;
}

void MemoryAllocator::free(const MemoryBlock& block, VkDeviceSize size) noexcept {
  if (has_hooks()) hooks_.free(block);
  const std::lock_guard lock(mutex_);
  used_ -= size;
  if (has_hooks()) return;
  if (!block.owner) {
    give_back(block, size);
    return;
  }
  Page& page = *static_cast<Page*>(block.owner);
  if (--page.block_count > 0) return;
  give_back(page.memory, kPageBytes);
  std::erase_if(pages_, [&](const std::unique_ptr<Page>& of) { return of.get() == &page; });
}

std::uint64_t MemoryAllocator::peak_bytes() const {
  const std::lock_guard lock(mutex_);
  return peak_;
}

namespace {

// 0 is the work group's size, which no variant changes.
constexpr std::uint32_t kFirstConstant = 1;

}  // namespace

VkDescriptorType descriptor_type(Binding binding, ReadPath path) {
  return texel_format(binding, path) == VK_FORMAT_UNDEFINED
             ? VK_DESCRIPTOR_TYPE_STORAGE_BUFFER
             : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
}

VkFormat texel_format(Binding binding, ReadPath path) {
  if (path == ReadPath::Storage) return VK_FORMAT_UNDEFINED;
  using enum Binding;
  switch (binding) {
    case Entries:
      return VK_FORMAT_R32G32_UINT;
    case Words:
      return VK_FORMAT_R32_UINT;
    case Records:
      return VK_FORMAT_R32G32B32A32_UINT;
    case Points:
      return VK_FORMAT_R32G32B32A32_SFLOAT;
    case Pairs:
      return VK_FORMAT_R32G32_SFLOAT;
    case Floats:
      return VK_FORMAT_R32_SFLOAT;
    default:
      return VK_FORMAT_UNDEFINED;
  }
}

Pipelines::Pipelines(const DeviceFunctions& functions, VkDevice device, VkPipelineCache cache,
                     const VkAllocationCallbacks* callbacks, const PipelineVariant& variant,
                     const DebugLabels& labels)
    : vk_(functions),
      device_(device),
      cache_(cache),
      callbacks_(callbacks),
      variant_(variant),
      labels_(labels),
      pipelines_(kKernelCount) {
  try {
    for (std::size_t i = 0; i < kKernelCount; ++i) create(static_cast<Kernel>(i));
  } catch (...) {
    destroy();
    throw;
  }
}

Pipelines::~Pipelines() { destroy(); }

void Pipelines::create(Kernel kernel) {
  const KernelSource& source = source_of(kernel);
  Pipeline& target = pipelines_[static_cast<std::size_t>(kernel)];
  target.bindings = std::span(source.bindings).first(source.binding_count);
  target.parameter_bytes = source.parameter_bytes;

  std::array<VkDescriptorSetLayoutBinding, kMaxBindings> bindings{};
  for (std::uint32_t i = 0; i < source.binding_count; ++i)
    bindings[i] = {i, descriptor_type(source.bindings[i], variant_.read_path), 1,
                   VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
  VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
  set_info.bindingCount = source.binding_count;
  set_info.pBindings = bindings.data();
  check(vk_.vkCreateDescriptorSetLayout(device_, &set_info, callbacks_, &target.set_layout),
        "vkCreateDescriptorSetLayout");

  const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, source.parameter_bytes};
  VkPipelineLayoutCreateInfo layout_info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layout_info.setLayoutCount = 1;
  layout_info.pSetLayouts = &target.set_layout;
  layout_info.pushConstantRangeCount = 1;
  layout_info.pPushConstantRanges = &range;
  check(vk_.vkCreatePipelineLayout(device_, &layout_info, callbacks_, &target.layout),
        "vkCreatePipelineLayout");
}

VkPipeline Pipelines::compile(Kernel kernel, VkPipelineLayout layout,
                              std::span<const std::uint32_t> constants) const {
  const KernelSource& source = source_of(kernel);
  VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  const std::span<const std::uint32_t> code =
      variant_.read_path == ReadPath::Texel ? source.texel : source.storage;
  module_info.codeSize = code.size_bytes();
  module_info.pCode = code.data();
  VkShaderModule module = VK_NULL_HANDLE;
  check(vk_.vkCreateShaderModule(device_, &module_info, callbacks_, &module),
        "vkCreateShaderModule");

  std::vector<std::uint32_t> values = {variant_.chunks_per_group, variant_.lane_sums};
  std::vector<VkSpecializationMapEntry> entries;
  values.insert(values.end(), constants.begin(), constants.end());
  for (std::uint32_t i = 0; i < values.size(); ++i)
    entries.push_back({kFirstConstant + i, i * std::uint32_t{sizeof values[0]}, sizeof values[0]});
  const VkSpecializationInfo info_of_constants{static_cast<std::uint32_t>(entries.size()),
                                               entries.data(), values.size() * sizeof values[0],
                                               values.data()};
  VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = &info_of_constants;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result =
      vk_.vkCreateComputePipelines(device_, cache_, 1, &info, callbacks_, &pipeline);
  vk_.vkDestroyShaderModule(device_, module, callbacks_);
  check(result, "vkCreateComputePipelines");
  labels_.name(VK_OBJECT_TYPE_PIPELINE, handle_number(pipeline), source.name);
  return pipeline;
}

void Pipelines::prepare(Kernel kernel) const {
  if (source_of(kernel).is_special) return;
  const std::lock_guard lock(mutex_);
  Pipeline& target = pipelines_[static_cast<std::size_t>(kernel)];
  if (!target.pipeline) target.pipeline = compile(kernel, target.layout, {});
}

Pipeline Pipelines::specialised(Kernel kernel, std::span<const std::uint32_t> constants) const {
  Pipeline result = (*this)[kernel];
  const std::lock_guard lock(mutex_);
  VkPipeline& pipeline = specialised_[{kernel, {constants.begin(), constants.end()}}];
  if (!pipeline) pipeline = compile(kernel, result.layout, constants);
  result.pipeline = pipeline;
  return result;
}

void Pipelines::destroy() noexcept {
  for (const auto& [key, pipeline] : specialised_)
    vk_.vkDestroyPipeline(device_, pipeline, callbacks_);
  for (const Pipeline& kernel : pipelines_) {
    vk_.vkDestroyPipeline(device_, kernel.pipeline, callbacks_);
    vk_.vkDestroyPipelineLayout(device_, kernel.layout, callbacks_);
    vk_.vkDestroyDescriptorSetLayout(device_, kernel.set_layout, callbacks_);
  }
}

namespace {

// Devices with less than this would cut usual tables into many slices.
constexpr std::uint64_t kEnoughTexelElements = std::uint64_t(1) << 26;

PipelineVariant suitable_variant(const Capabilities& device) {
  const bool software =
      device.kind == "software" && device.max_texel_elements >= kEnoughTexelElements;
  return software ? kSoftwareVariant : kHardwareVariant;
}

Capabilities usable_capabilities(const HostDevice& host) {
  if (!host.get_instance_proc || !host.instance || !host.physical_device || !host.device)
    throw Error(ErrorCode::InvalidArgument,
                "a HostDevice needs get_instance_proc, instance, physical_device and device");
  if (static_cast<bool>(host.memory.allocate) != static_cast<bool>(host.memory.free))
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("HostDevice::memory has {}; set both, or neither",
                  host.memory.allocate ? "allocate, but no free" : "free, but no allocate"));
  if (host.api_version < VK_API_VERSION_1_1)
    throw Error(ErrorCode::NoDevice,
                "the host's instance or device is of Vulkan 1.0; planish needs 1.1");
  Capabilities capabilities =
      query_capabilities(host.get_instance_proc, host.instance, host.physical_device);
  if (!capabilities.usable)
    throw Error(ErrorCode::NoDevice, capabilities.name + " " + capabilities.reason);
  return capabilities;
}

template <class Number>
Number lowered(Number limit, Number option) {
  return option ? std::min(limit, option) : limit;
}

BindingLimit binding_limit_of(const Capabilities& device, const PipelineVariant& variant,
                              const ContextOptions& options) {
  BindingLimit limit{lowered(device.max_storage_range, options.max_storage_range)};
  const auto lower = [&](const BindingLimit& other) {
    if (other.bytes < limit.bytes) limit = other;
  };
  lower({device.max_allocation, "maxMemoryAllocationSize"});
  // Texels may be as small as a float; of larger ones there are fewer in as many bytes.
  if (variant.read_path == ReadPath::Texel)
    lower({device.max_texel_elements * sizeof(float), "4 * maxTexelBufferElements"});
  return limit;
}

DeviceFunctions load_functions(const HostDevice& host) {
  const InstanceFunctions functions =
      InstanceFunctions::load(host.get_instance_proc, host.instance);
  return DeviceFunctions::load(functions.vkGetDeviceProcAddr, host.device);
}

}  // namespace

Context::Context(const HostDevice& host, const ContextOptions& options)
    : device_(host.device),
      callbacks_(host.allocation_callbacks),
      capabilities_(usable_capabilities(host)),
      variant_(options.variant.value_or(suitable_variant(capabilities_))),
      binding_limit_(binding_limit_of(capabilities_, variant_, options)),
      max_group_count_(lowered(capabilities_.max_group_count, options.max_group_count)),
      further_usage_(options.further_usage),
      log_(host.log),
      functions_(load_functions(host)),
      labels_(host.features.debug_utils
                  ? DebugLabels(host.get_instance_proc, host.instance, host.device)
                  : DebugLabels()),
      memory_(functions_, device_, capabilities_, callbacks_, host.memory,
              (options.further_usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) != 0),
      pipelines_(functions_, device_, host.pipeline_cache, callbacks_, variant_, labels_) {
  log(formatted("planish: {}, {} buffers, {} bytes a binding", capabilities_.name,
                variant_.read_path == ReadPath::Texel ? "texel" : "storage", binding_limit_.bytes));
}

void Context::tell(std::string_view line) const noexcept {
  try {
    log(line);
  } catch (...) {
    return;
  }
}

Context::Context(const OwnDevice& own, const ContextOptions& options)
    : Context(own.host_device(), options) {}

}  // namespace planish::vulkan
