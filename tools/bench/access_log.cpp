#include "bench/access_log.h"

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <tuple>

#include "bench/device_frame.h"
#include "bench/device_trace.h"
#include "planish/vulkan/device/result.h"

namespace planish::bench {

using namespace vulkan;

namespace {

constexpr std::uint64_t kLogBytes = 128u << 20;  // which every device's bindings may have
constexpr std::uint32_t kWarpLanes = 32, kSectorBytes = 32;

struct Record {
  std::uint32_t dispatch, access, invocation, offset;
};
static_assert(sizeof(Record) == kAccessWords * sizeof(std::uint32_t));

// A piece that an access touches in a round of its loops.
struct Sector {
  std::uint32_t access, warp, round, number;
  auto operator<=>(const Sector&) const = default;
};

// Of one dispatch. A lane's records of an access are in the order of its rounds.
AccessTotal total_of(std::span<Record> records) {
  std::ranges::stable_sort(records, {}, [](const Record& record) {
    return std::tuple(record.access, record.invocation);
  });
  AccessTotal total;
  std::vector<Sector> sectors;
  std::uint32_t round = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto& [dispatch, number, invocation, offset] = records[i];
    const bool goes_on =
        i > 0 && records[i - 1].access == number && records[i - 1].invocation == invocation;
    round = goes_on ? round + 1 : 0;
    total.longest_walk = std::max<std::uint64_t>(total.longest_walk, round + 1);
    const Access& access = DeviceTrace::accesses().at(number);
    if (access.reads) total.read_bytes += access.bytes;
    if (access.writes) total.written_bytes += access.bytes;
    const std::uint32_t last = (offset + access.bytes - 1) / kSectorBytes;
    for (std::uint32_t sector = offset / kSectorBytes; sector <= last; ++sector)
      sectors.push_back({number, invocation / kWarpLanes, round, sector});
  }
  std::ranges::sort(sectors);
  const auto beyond = std::ranges::unique(sectors);
  total.transactions = static_cast<std::uint64_t>(beyond.begin() - sectors.begin());
  return total;
}

}  // namespace

AccessLog::AccessLog(const Options& options) {
  DeviceTrace::log_accesses(true);
  Options of_hardware = options;
  of_hardware.hardware_kernels = true;
  of_hardware.max_range = 0;  // the log needs a binding of its own
  machine_ = traced_machine(of_hardware);
  records_ = Buffer(machine_->context, kLogBytes, MemoryUse::Download, "log of accesses");
  bind();
  clear();
}

void AccessLog::bind() {
  const Context& context = machine_->context;
  const DeviceFunctions& vk = context.vk();
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 1};
  const VkDescriptorPoolCreateInfo pool{
      VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO, nullptr, 0, 1, 1, &size};
  check(vk.vkCreateDescriptorPool(context.device(), &pool, nullptr, &pool_),
        "vkCreateDescriptorPool");
  const VkDescriptorSetLayout layout = DeviceTrace::log_layout();
  const VkDescriptorSetAllocateInfo wanted{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, nullptr,
                                           pool_, 1, &layout};
  VkDescriptorSet set = VK_NULL_HANDLE;
  check(vk.vkAllocateDescriptorSets(context.device(), &wanted, &set), "vkAllocateDescriptorSets");
  const VkDescriptorBufferInfo buffer{records_.handle(), 0, VK_WHOLE_SIZE};
  VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
  write.dstSet = set;
  write.descriptorCount = 1;
  write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  write.pBufferInfo = &buffer;
  vk.vkUpdateDescriptorSets(context.device(), 1, &write, 0, nullptr);
  DeviceTrace::set_log(set, records_.handle());
}

AccessLog::~AccessLog() {
  const Context& context = machine_->context;
  context.vk().vkDestroyDescriptorPool(context.device(), pool_, nullptr);
  context.vk().vkDestroyDescriptorSetLayout(context.device(), DeviceTrace::log_layout(), nullptr);
  DeviceTrace::set_log(VK_NULL_HANDLE, VK_NULL_HANDLE);
  DeviceTrace::log_accesses(false);
}

void AccessLog::clear() {
  const std::uint32_t head[kFirstAccess] = {kFirstAccess};
  std::memcpy(records_.mapped().data(), head, sizeof head);
  records_.flush();
}

std::vector<AccessTotal> AccessLog::totals(std::size_t dispatch_count) {
  records_.invalidate();
  const std::span<const std::byte> bytes = records_.mapped();
  std::uint32_t end = 0;
  std::memcpy(&end, bytes.data(), sizeof end);
  if (end > bytes.size() / sizeof end)
    throw std::runtime_error("the log of accesses has " + std::to_string(bytes.size()) +
                             " bytes, but " + std::to_string(4ull * end) + " were wanted");
  std::vector<Record> records((end - kFirstAccess) / kAccessWords);
  std::memcpy(records.data(), bytes.data() + kFirstAccess * sizeof end,
              records.size() * sizeof(Record));
  std::ranges::stable_sort(records, {}, &Record::dispatch);
  std::vector<AccessTotal> totals;
  for (std::uint32_t i = 0; i < dispatch_count; ++i) {
    const auto own = std::ranges::equal_range(records, i, {}, &Record::dispatch);
    totals.push_back(total_of(own));
  }
  return totals;
}

}  // namespace planish::bench
