#include "planish/vulkan/backend/vulkan_fair.h"

#include <bit>
#include <cstring>

#include "planish/core/assert.h"
#include "planish/core/host_scope.h"
#include "planish/core/stop.h"
#include "planish/vulkan/fair/gpu_fair.h"

namespace planish::vulkan {

namespace {

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

}  // namespace planish::vulkan
