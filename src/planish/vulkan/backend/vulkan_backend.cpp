#include "planish/vulkan/vulkan_backend.h"

#include <algorithm>
#include <cstring>
#include <glm/vec3.hpp>

#include "planish/backend/cpu_backend.h"
#include "planish/core/assert.h"
#include "planish/core/error.h"
#include "planish/stencil/stencil_builder.h"
#include "planish/vulkan/backend/vulkan_fair.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/backend/vulkan_patches.h"
#include "planish/vulkan/backend/vulkan_solve.h"
#include "planish/vulkan/tables/stencil_pass.h"

namespace planish {

namespace vulkan {

namespace {

/// apply_limit writes a position and a normal for each row.
constexpr std::uint64_t kLimitFloats = 6;
/// Faces of some 90 corners, if the mesh has no others.
constexpr double kMostExpansion = 8;

DeviceDescription describe(const Capabilities& device) {
  DeviceDescription description;
  description.kind = device.kind;
  description.name = device.name;
  description.uuid = device.uuid;
  description.driver = device.driver;
  description.api =
      formatted("{}.{}.{}", VK_API_VERSION_MAJOR(device.api_version),
                VK_API_VERSION_MINOR(device.api_version), VK_API_VERSION_PATCH(device.api_version));
  return description;
}

class VulkanPoints final : public DevicePoints {
 public:
  VulkanPoints(std::shared_ptr<VulkanMachine> machine, std::int32_t count)
      : machine_(std::move(machine)),
        buffer_(machine_->context, std::uint64_t(count) * kPointBytes, MemoryUse::Device),
        count_(count) {}
  [[nodiscard]] std::int32_t size() const override { return count_; }
  [[nodiscard]] const Buffer& buffer() const { return buffer_; }

 private:
  std::shared_ptr<VulkanMachine> machine_;  // outlives the buffer
  Buffer buffer_;
  std::int32_t count_;
};

const VulkanPoints& vulkan_points(const DevicePoints& points) {
  const auto* result = dynamic_cast<const VulkanPoints*>(&points);
  PLANISH_ASSERT(result != nullptr);
  return *result;
}

class VulkanBackend final : public Backend, public FairBuilder, public PatchEvaluator {
 public:
  explicit VulkanBackend(std::shared_ptr<VulkanMachine> machine) : machine_(std::move(machine)) {}

  [[nodiscard]] DeviceDescription description() const override {
    return describe(machine_->device.capabilities());
  }
  [[nodiscard]] std::unique_ptr<planish::Solve> make_solve(const SummedView& masks) override {
    if (masks.sum_count() == 0) return std::make_unique<VulkanSolve>(machine_, masks.rows);
    // Kernels have no sums between steps, and without them large faces take the square of their
    // corners: the host is faster there than any device, and needs no more memory than the mesh.
    if (expansion(masks) > kMostExpansion) return host_->make_solve(masks);
    return std::make_unique<VulkanSolve>(machine_, expanded(masks).view());
  }
  [[nodiscard]] std::unique_ptr<DevicePoints> upload(std::span<const glm::dvec3> points) override {
    auto result =
        std::make_unique<VulkanPoints>(machine_, static_cast<std::int32_t>(points.size()));
    machine_->upload_points(result->buffer(), points);
    return result;
  }
  [[nodiscard]] std::unique_ptr<DevicePoints> allocate(std::int32_t count) override {
    return std::make_unique<VulkanPoints>(machine_, count);
  }
  [[nodiscard]] std::vector<glm::dvec3> download(const DevicePoints& points) override {
    return machine_->download_points(vulkan_points(points).buffer(), points.size());
  }
  void apply(const StencilView<double>& table, const DevicePoints& source, DevicePoints& target,
             std::int32_t first_target) override;
  void apply_limit(const StencilView<double>& table, const DevicePoints& source,
                   std::span<glm::dvec3> positions, std::span<glm::vec3> normals) override;
  [[nodiscard]] FairNet build_fair_net(const FairTopology& topology,
                                       std::span<const glm::dvec3> given,
                                       const FairOptions& options) override {
    return vulkan::build_fair_net(*machine_, topology, given, options);
  }
  void evaluate_patches(const PatchSurface& surface, std::span<const glm::dvec3> state,
                        std::span<Row> rows) override {
    vulkan::evaluate_patches(*machine_, surface, state, rows);
  }
  [[nodiscard]] std::uint64_t peak_device_bytes() const override {
    return machine_->context.memory().peak_bytes();
  }

 private:
  std::shared_ptr<VulkanMachine> machine_;
  std::unique_ptr<Backend> host_ = make_cpu_backend();  // of solves that it takes
};

void VulkanBackend::apply(const StencilView<double>& view, const DevicePoints& source,
                          DevicePoints& target, std::int32_t first_target) {
  PLANISH_ASSERT(&source != &target && view.source_count <= source.size() && first_target >= 0 &&
                 view.row_count() <= target.size() - first_target);
  Context& context = machine_->context;
  DeviceTable table(context, view, {});
  machine_->upload_table(table, view);
  constexpr std::uint32_t kFloats = shared::kPointFloats;
  const StencilPass pass(
      context, table, {vulkan_points(source).buffer().handle(), 0, 3, kFloats},
      {vulkan_points(target).buffer().handle(), std::uint64_t(first_target) * kFloats, 3, kFloats},
      {0, view.row_count()});
  machine_->submitter.run([&](VkCommandBuffer commands) { pass.record(commands); });
}

void VulkanBackend::apply_limit(const StencilView<double>& view, const DevicePoints& source,
                                std::span<glm::dvec3> positions, std::span<glm::vec3> normals) {
  PLANISH_ASSERT(view.source_count <= source.size() && std::ssize(positions) == view.row_count() &&
                 std::ssize(normals) == view.row_count());
  Context& context = machine_->context;
  DeviceTableOptions options;
  options.has_derivatives = true;
  options.target_stride = kLimitFloats * sizeof(float);
  DeviceTable table(context, view, options);
  machine_->upload_table(table, view);
  for (std::size_t i = 0; i < table.slices().size(); ++i) {
    const DeviceTable::Slice& slice = table.slices()[i];
    const TableSlice& rows = slice.rows;
    const Buffer target(context, rows.row_count * options.target_stride, MemoryUse::Device);
    const BoundKernel bound[] = {
        {Kernel::ApplyLimit,
         {whole(slice.entries), whole(slice.chunks),
          point_range(vulkan_points(source).buffer(), rows.first_source, rows.source_count),
          whole(target), whole(slice.derivatives)}}};
    const DescriptorSets sets(context, bound);
    machine_->submitter.run([&](VkCommandBuffer commands) {
      shared::TableParameters parameters = table.parameters(i);
      parameters.target_stride = kLimitFloats;
      parameters.normal_offset = 3;
      table.record_dispatch(commands, Kernel::ApplyLimit, sets[0], i, parameters);
    });
    machine_->submitter.download(
        {target.handle(), 0, rows.row_count * options.target_stride},
        [&](std::uint64_t offset, std::span<const std::byte> piece) {
          const std::size_t first = rows.first_row + offset / options.target_stride;
          for (std::size_t k = 0; k < piece.size() / options.target_stride; ++k) {
            glm::vec3 point[2];
            std::memcpy(point, &piece[k * options.target_stride], sizeof point);
            positions[first + k] = glm::dvec3(point[0]);
            normals[first + k] = point[1];
          }
        });
  }
}

}  // namespace

std::unique_ptr<Backend> make_backend(std::shared_ptr<VulkanMachine> machine) {
  return std::make_unique<VulkanBackend>(std::move(machine));
}

}  // namespace vulkan

VulkanDeviceList list_vulkan_devices() {
  VulkanDeviceList list;
  try {
    const vulkan::Instance instance({});
    const std::vector<vulkan::FoundDevice> devices = vulkan::find_devices(instance);
    for (const vulkan::FoundDevice& device : devices) {
      const vulkan::Capabilities& from = device.capabilities;
      VulkanDeviceInfo& to = list.devices.emplace_back();
      to.description = vulkan::describe(from);
      to.usable = from.usable;
      to.reason = from.reason;
      to.memory_bytes = from.largest_device_heap;
      to.max_storage_bytes = from.max_storage_range;
      to.max_allocation_bytes = from.max_allocation;
      to.max_work_groups = from.max_group_count;
      to.max_storage_buffers = from.max_storage_buffers;
      to.portability_subset = from.portability_subset;
      for (const vulkan::OptionalFeature& feature : from.optional_features)
        if (!feature.available) to.missing.push_back(feature.name + ", with which " + feature.use);
    }
    if (std::any_of(list.devices.begin(), list.devices.end(),
                    [](const VulkanDeviceInfo& device) { return device.usable; }))
      list.best = static_cast<int>(vulkan::pick_device(devices, ""));
    if (list.devices.empty()) list.reason = "the Vulkan loader finds no device";
  } catch (const Error& error) {
    list.reason = error.what();
  }
  return list;
}

std::unique_ptr<Backend> make_vulkan_backend(const VulkanBackendOptions& options) {
  vulkan::OwnDeviceOptions device;
  device.wanted = options.device;
  device.instance.validation = options.validation;
  device.instance.message = options.validation_message;
  vulkan::ContextOptions context;
  context.max_storage_range = options.max_storage_bytes;
  context.max_group_count = options.max_work_groups;
  if (options.reads == VulkanReads::StorageBuffers) context.variant = vulkan::kHardwareVariant;
  if (options.reads == VulkanReads::TexelBuffers) context.variant = vulkan::kSoftwareVariant;
  return vulkan::make_backend(std::make_shared<vulkan::VulkanMachine>(device, context));
}

}  // namespace planish
