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
    if (table.has_derivatives()) upload_items(submitter, slice.derivatives, packed.derivatives);
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
  in_gradients_ = false;
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
  if (in_gradients_)
    machine_->submitter.run([&](VkCommandBuffer commands) {
      const VkBufferCopy copy{0, 0, solve_.side(side_).size()};
      machine_->context.vk().vkCmdCopyBuffer(commands, gradients_->displacement().handle(),
                                             solve_.side(side_).handle(), 1, &copy);
    });
  // A step that goes nowhere still measures; what it writes is the side that the next one writes.
  const std::uint32_t side = side_;
  const StepCoefficients measure{0, 0};
  std::vector<ErrorNorms> errors;
  run_piece(std::span(&measure, 1), -1, errors);
  side_ = side;
  return errors.front();
}

std::vector<glm::dvec3> VulkanSolve::displacement() const {
  const Buffer& result = in_gradients_ ? gradients_->displacement() : solve_.side(side_);
  return machine_->download_points(result, masks_.row_count());
}

glm::dvec3 VulkanSolve::cg_begin(std::span<const glm::dvec3> initial_residual,
                                 std::span<const double> row_weights) {
  PLANISH_ASSERT(std::ssize(row_weights) == masks_.row_count());
  begin(initial_residual);
  if (!gradients_) gradients_.emplace(machine_->context, masks_);
  in_gradients_ = true;
  machine_->upload_points(gradients_->residual(), initial_residual);
  const std::vector<float> weights(row_weights.begin(), row_weights.end());
  machine_->submitter.upload({gradients_->weights().handle(), 0, weights.size() * sizeof(float)},
                             std::as_bytes(std::span(weights)));
  machine_->submitter.run([&](VkCommandBuffer commands) {
    gradients_->record_begin(commands);
    // An advance by nothing yields the sums.
    gradients_->record_advance(commands, glm::vec3(0));
  });
  return read_sums().residual_square;
}

glm::dvec3 VulkanSolve::cg_apply() {
  machine_->submitter.run([&](VkCommandBuffer commands) { gradients_->record_apply(commands); });
  return read_sums().residual_square;
}

planish::Solve::CgAdvance VulkanSolve::cg_advance(const glm::dvec3& alpha) {
  machine_->submitter.run(
      [&](VkCommandBuffer commands) { gradients_->record_advance(commands, glm::vec3(alpha)); });
  return read_sums();
}

void VulkanSolve::cg_turn(const glm::dvec3& beta) {
  machine_->submitter.run(
      [&](VkCommandBuffer commands) { gradients_->record_turn(commands, glm::vec3(beta)); });
}

planish::Solve::CgAdvance VulkanSolve::read_sums() {
  std::uint32_t sums[shared::kSumFloats];
  machine_->submitter.download(whole(gradients_->sums()),
                               [&](std::uint64_t, std::span<const std::byte> piece) {
                                 std::memcpy(sums, piece.data(), sizeof sums);
                               });
  CgAdvance result;
  for (int c = 0; c < 3; ++c) result.residual_square[c] = std::bit_cast<float>(sums[c]);
  result.error = norms_of(sums[4], std::bit_cast<float>(sums[3]), masks_.row_count());
  return result;
}

}  // namespace planish::vulkan

namespace planish {
namespace vulkan {
namespace {

// apply_limit writes a position and a normal for each row.
constexpr std::uint64_t kLimitFloats = 6;
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
