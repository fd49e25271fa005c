#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <span>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/patches/patch_surface.h"
#include "planish/solve/backend.h"
#include "planish/solve/stencil_builder.h"
#include "planish/vulkan/backend/vulkan_machine.h"
#include "planish/vulkan/device/commands.h"
#include "planish/vulkan/evaluate/gpu_patches.h"
#include "planish/vulkan/evaluate/patch_tables.h"
#include "planish/vulkan/fair/gpu_fair.h"
#include "planish/vulkan/solve/gpu_solve.h"
#include "planish/vulkan/tables/device_table.h"
#include "planish/vulkan/vulkan_backend.h"

namespace planish::vulkan {
namespace {

template <class Item>
void upload_items(Submitter& submitter, const Buffer& target, const std::vector<Item>& items) {
  const std::span<const std::byte> bytes = std::as_bytes(std::span(items));
  submitter.upload({target.handle(), 0, bytes.size()}, bytes);
}

}  // namespace

void VulkanMachine::upload_table(DeviceTable& table, const StencilView<double>& view) {
  for (std::size_t i = 0; i < table.slices().size(); ++i) {
    const DeviceTable::Slice& slice = table.slices()[i];
    const PackedSlice packed = table.pack(i, view);
    upload_items(submitter, slice.chunks, packed.chunks);
    upload_items(submitter, slice.entries, packed.entries);
  }
  table.finish_packing();
}

void VulkanMachine::upload_points(const Buffer& target, std::span<const glm::dvec3> points) {
  const BufferRange range{target.handle(), 0, points.size() * kPointBytes};
  submitter.upload(range, [&](std::uint64_t offset, std::span<std::byte> piece) {
    const std::size_t first = offset / kPointBytes;
    parallel_each(piece.size() / kPointBytes, [&](std::size_t i) {
      const glm::vec4 point(points[first + i], 0);
      std::memcpy(&piece[i * kPointBytes], &point, kPointBytes);
    });
  });
}

std::vector<glm::dvec3> VulkanMachine::download_points(const Buffer& source, std::size_t count) {
  std::vector<glm::dvec3> points(count);
  submitter.download({source.handle(), 0, count * kPointBytes},
                     [&](std::uint64_t offset, std::span<const std::byte> piece) {
                       const std::size_t first = offset / kPointBytes;
                       parallel_each(piece.size() / kPointBytes, [&](std::size_t i) {
                         glm::vec3 point;
                         std::memcpy(&point, &piece[i * kPointBytes], sizeof point);
                         points[first + i] = glm::dvec3(point);
                       });
                     });
  return points;
}

namespace {

constexpr std::uint32_t kRowBytes = sizeof(PatchEvaluator::Row);
static_assert(kRowBytes == 24);

// Points of level 1 as the kernel takes them. There are no given vertices here: those of a vertex
// are seen from one of them.
struct SeenPoints {
  SeenPoints(const PatchMesh& mesh, std::span<const glm::dvec3> state) {
    const std::vector<std::int32_t> owners = state_owners(mesh);
    origins.resize(static_cast<std::size_t>(mesh.topology().vertex_count()));
    for (std::size_t i = state.size(); i-- > 0;)
      origins[owners[i]] = glm::vec4(glm::vec3(state[i]), 0);
    offsets.resize(state.size());
    parallel_each(state.size(), [&](std::size_t i) {
      const auto owner = static_cast<std::uint32_t>(owners[i]);
      const glm::vec3 offset(state[i] - glm::dvec3(glm::vec3(origins[owner])));
      offsets[i] = glm::vec4(offset, std::bit_cast<float>(owner | shared::kVertexTag));
    });
  }
  std::vector<glm::vec4> origins, offsets;
};

// PatchEvaluator::evaluate_patches() on the command's device.
void evaluate_patches(VulkanMachine& machine, const PatchSurface& surface,
                      std::span<const glm::dvec3> state, std::span<PatchEvaluator::Row> rows) {
  PLANISH_ASSERT(std::ssize(rows) == surface.numbering().row_count());
  if (rows.empty()) return;
  Context& context = machine.context;
  const auto upload = [&](const Buffer& buffer, std::span<const std::byte> bytes) {
    machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
  };
  const auto make = [&](const std::vector<glm::vec4>& points) {
    Buffer buffer(context, points.size() * sizeof points[0], MemoryUse::Device);
    upload(buffer, std::as_bytes(std::span(points)));
    return buffer;
  };
  const PatchRecords records = patch_records(surface, patch_limits(context, kRowBytes));
  const PatchTables tables(context, records, std::ssize(state));
  tables.for_each(records, upload);
  const SeenPoints points(surface.mesh(), state);
  const Buffer origins = make(points.origins), offsets = make(points.offsets);
  const Buffer target(context, rows.size_bytes(), MemoryUse::Device);
  const GpuPatches patches(context, tables, origins, offsets, {target.handle(), 0, kRowBytes});
  machine.submitter.run([&](VkCommandBuffer commands) { patches.record(commands); });
  const std::span<std::byte> bytes = std::as_writable_bytes(rows);
  machine.submitter.download({target.handle(), 0, bytes.size()},
                             [&](std::uint64_t offset, std::span<const std::byte> piece) {
                               std::memcpy(&bytes[offset], piece.data(), piece.size());
                             });
}

std::vector<std::uint32_t> download_words(Submitter& submitter, const Buffer& source,
                                          std::size_t count) {
  std::vector<std::uint32_t> words(count);
  submitter.download({source.handle(), 0, count * sizeof words[0]},
                     [&](std::uint64_t offset, std::span<const std::byte> piece) {
                       std::memcpy(&words[offset / sizeof words[0]], piece.data(), piece.size());
                     });
  return words;
}

}  // namespace

FairNet build_fair_net(VulkanMachine& machine, const FairTopology& topology,
                       std::span<const glm::dvec3> given, const FairOptions& options) {
  require_valid(options);
  if (options.decisions)
    require_valid(*options.decisions, topology.vertex_count, topology.face_count);
  const HostScope host(options.callbacks);
  options.callbacks.report("solve", 0);
  PLANISH_ASSERT(std::ssize(given) == topology.vertex_count);
  Context& context = machine.context;
  const FairRecords records = fair_records(topology, options.decisions, planes_of(options));
  const FairTables tables(context, records);
  tables.for_each(records, [&](const Buffer& buffer, std::span<const std::byte> bytes) {
    machine.submitter.upload({buffer.handle(), 0, bytes.size()}, bytes);
  });
  const Buffer points(context, given.size() * shared::kPointFloats * sizeof(float),
                      MemoryUse::Device, "planish given points");
  machine.upload_points(points, given);
  check_stop();

  GpuFairOptions on_device;
  on_device.polish_steps = static_cast<std::uint32_t>(options.polish_steps);
  on_device.cures_folds = options.cures_folds;
  on_device.counts_folds = true;
  const GpuFair fair(context, tables, points, on_device);
  machine.submitter.run([&](VkCommandBuffer commands) { fair.record(commands); });

  // What the given points lose to single precision is nothing that the net must lose.
  FairNet net;
  net.state = machine.download_points(fair.buffers().result, records.owners.size());
  const std::vector<std::uint32_t> decisions =
      download_words(machine.submitter, fair.buffers().decisions, given.size());
  for (const std::uint32_t word : decisions) {
    net.reversed_vertices += (word & shared::kReversed) != 0;
    net.shrunk_vertices += (word & (shared::kReversed - 1)) != 0;
    net.cured_vertices += options.cures_folds && word >> shared::kCureShift != 0;
  }
  std::vector<float> planes;
  if (options.cures_folds) {
    for (const std::uint32_t word :
         download_words(machine.submitter, fair.buffers().planes, 4 * given.size())) {
      planes.push_back(std::bit_cast<float>(word));
    }
  }
  net.decisions = unpack_decisions(decisions, planes);
  if (options.decisions) net.decisions.ellipses = options.decisions->ellipses;
  const auto kept = planes_of(options);
  net.decisions.planes.assign(kept.begin(), kept.end());
  if (!options.cures_folds) net.decisions.cures.assign(given.size(), 0);
  const std::vector<std::uint32_t> counts =
      download_words(machine.submitter, fair.buffers().counts, shared::kFairCounts);
  net.flagged_edges = counts[shared::kEndCounts];
  net.flagged_faces = counts[shared::kEndCounts + 1];
  for (std::size_t i = 0; i < net.state.size(); ++i) net.state[i] += given[records.owners[i]];
  return net;
}

namespace {

DeviceTable make_table(VulkanMachine& machine, const StencilView<double>& masks) {
  DeviceTableOptions options;
  options.includes_own_rows = true;
  DeviceTable table(machine.context, masks, options);
  machine.upload_table(table, masks);
  return table;
}

ErrorNorms norms_of(std::uint32_t max_square_bits, float square_sum, std::int32_t rows) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  ErrorNorms norms;
  norms.max = std::sqrt(static_cast<double>(std::bit_cast<float>(max_square_bits)));
  norms.rms = rows > 0 ? std::sqrt(static_cast<double>(square_sum) / rows) : 0;
  if (!std::isfinite(norms.max) || !std::isfinite(norms.rms)) norms.rms = kInfinity;
  return norms;
}

}  // namespace

VulkanSolve::VulkanSolve(std::shared_ptr<VulkanMachine> machine,
                         const StencilView<double>& limit_masks)
    : machine_(std::move(machine)),
      masks_(make_table(*machine_, limit_masks)),
      solve_(machine_->context, masks_),
      report_(machine_->context, solve_.status().size() + solve_.steps().size(),
              MemoryUse::Download) {
  PLANISH_ASSERT(limit_masks.source_count == limit_masks.row_count());
}

void VulkanSolve::begin(std::span<const glm::dvec3> initial_residual) {
  PLANISH_ASSERT(std::ssize(initial_residual) == masks_.row_count());
  machine_->upload_points(solve_.initial(), initial_residual);
  machine_->submitter.run([&](VkCommandBuffer commands) { solve_.record_clear(commands); });
  side_ = 0;
}

std::uint32_t VulkanSolve::run_piece(std::span<const StepCoefficients> steps, float stop_square,
                                     std::vector<ErrorNorms>& errors) {
  const auto count = static_cast<std::uint32_t>(steps.size());
  solve_.set_plan(steps);
  machine_->submitter.run([&](VkCommandBuffer commands) {
    solve_.record_steps(commands, {side_, count, stop_square});
    // Within the same submission: each wait costs the host as much as a small step.
    const VkBufferCopy status_copy{0, 0, solve_.status().size()};
    const VkBufferCopy steps_copy{0, solve_.status().size(), solve_.steps().size()};
    const DeviceFunctions& vk = machine_->context.vk();
    vk.vkCmdCopyBuffer(commands, solve_.status().handle(), report_.handle(), 1, &status_copy);
    vk.vkCmdCopyBuffer(commands, solve_.steps().handle(), report_.handle(), 1, &steps_copy);
  });
  report_.invalidate();
  shared::SolveStatus status;
  std::vector<shared::StepRecord> records(count);
  std::memcpy(&status, report_.mapped().data(), sizeof status);
  std::memcpy(records.data(), report_.mapped().data() + solve_.status().size(),
              count * sizeof(shared::StepRecord));
  const std::uint32_t measured =
      status.state == shared::kStateConverged ? status.iterations + 1 : status.iterations;
  for (std::uint32_t i = 0; i < measured; ++i)
    errors.push_back(
        norms_of(records[i].max_square_bits, records[i].square_sum, masks_.row_count()));
  side_ = status.side;
  return status.iterations;
}

StepLog VulkanSolve::run(std::span<const StepCoefficients> steps, double stop_error) {
  StepLog log;
  const float stop_square = stop_square_of(stop_error);
  while (!steps.empty()) {
    const std::span piece = steps.first(std::min<std::size_t>(steps.size(), solve_.max_steps()));
    const std::uint32_t taken = run_piece(piece, stop_square, log.errors);
    log.steps_taken += static_cast<std::int32_t>(taken);
    if (taken < piece.size()) break;
    steps = steps.subspan(piece.size());
  }
  return log;
}

ErrorNorms VulkanSolve::error() {
  // A step that goes nowhere still measures; what it writes is the side that the next one writes.
  const std::uint32_t side = side_;
  const StepCoefficients measure{0, 0};
  std::vector<ErrorNorms> errors;
  run_piece(std::span(&measure, 1), -1, errors);
  side_ = side;
  return errors.front();
}

std::vector<glm::dvec3> VulkanSolve::displacement() const {
  return machine_->download_points(solve_.side(side_), masks_.row_count());
}

}  // namespace planish::vulkan

namespace planish {
namespace vulkan {
namespace {

// Faces of some 90 corners, if the mesh has no others.
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

}  // namespace

std::shared_ptr<VulkanMachine> make_machine(const VulkanBackendOptions& options) {
  OwnDeviceOptions device;
  device.wanted = options.device;
  device.instance.validation = options.validation;
  device.instance.message = options.validation_message;
  ContextOptions context;
  context.max_storage_range = options.max_storage_bytes;
  context.max_group_count = options.max_work_groups;
  if (options.reads == VulkanReads::StorageBuffers) context.variant = kHardwareVariant;
  if (options.reads == VulkanReads::TexelBuffers) context.variant = kSoftwareVariant;
  return std::make_shared<VulkanMachine>(device, context);
}

std::unique_ptr<Backend> make_backend(std::shared_ptr<VulkanMachine> machine) {
  return std::make_unique<VulkanBackend>(std::move(machine));
}

}  // namespace vulkan

}  // namespace planish

namespace planish {

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
  return vulkan::make_backend(vulkan::make_machine(options));
}

}  // namespace planish
