#include "planish/vulkan/edit/edit_records.h"

#include <limits>
#include <string>
#include <utility>

#include "planish/core/error.h"
#include "planish/core/group_by.h"
#include "planish/vulkan/evaluate/state_owners.h"

namespace planish::vulkan {

namespace {

// Lists of `vertex_count` vertices: item i is in that of owners[i], where that is not negative.
std::vector<std::uint32_t> lists_of(std::int32_t vertex_count,
                                    const std::vector<std::int32_t>& owners) {
  const Groups<std::uint32_t> lists =
      group_by<std::uint32_t>(static_cast<std::size_t>(vertex_count), [&](const auto& take) {
        for (std::size_t i = 0; i < owners.size(); ++i)
          if (owners[i] >= 0)
            take(static_cast<std::size_t>(owners[i]), static_cast<std::uint32_t>(i));
      });
  std::vector<std::uint32_t> words;
  words.reserve(lists.offsets.size() + lists.values.size());
  for (const std::int32_t offset : lists.offsets)
    words.push_back(static_cast<std::uint32_t>(lists.offsets.size()) +
                    static_cast<std::uint32_t>(offset));
  words.insert(words.end(), lists.values.begin(), lists.values.end());
  return words;
}

}  // namespace

EditRecords edit_records(const PatchMesh& mesh, const PatchRecords& patches,
                         std::vector<std::uint32_t> slots) {
  const std::int32_t vertex_count = mesh.topology().vertex_count();
  if (patches.owners.size() > std::numeric_limits<std::int32_t>::max())
    throw Error(
        ErrorCode::OutOfMemory,
        formatted(
            "edits count {} patches in numbers of 31 bits; use a lower level or a smaller mesh",
            patches.owners.size()));
  EditRecords records;
  records.slots = std::move(slots);
  records.job_count = patches.owners.size();
  records.jobs = lists_of(vertex_count, patches.owners);
  // Sums of large rings are made as a whole.
  std::vector<std::int32_t> owners = state_owners(mesh);
  owners.resize(static_cast<std::size_t>(mesh.state_size()));
  records.places = lists_of(vertex_count, owners);
  return records;
}

}  // namespace planish::vulkan
