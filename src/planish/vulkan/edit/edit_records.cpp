#include "planish/vulkan/edit/edit_records.h"

#include <limits>
#include <string>
#include <utility>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

// Lists of `vertex_count` vertices: item i is in that of owners[i], where that is not negative.
class VertexLists {
 public:
  explicit VertexLists(std::int32_t vertex_count)
      : words_(static_cast<std::size_t>(vertex_count) + 1, 0) {}

  // All items are counted, then all are added, in the same order.
  void count(std::int32_t owner) {
    if (owner >= 0) ++words_[static_cast<std::size_t>(owner)];
  }
  void end_counting() {
    auto next = static_cast<std::uint32_t>(words_.size());
    for (std::uint32_t& word : words_) next += std::exchange(word, next);
    next_.assign(words_.begin(), words_.end() - 1);
    words_.resize(next);
  }
  void add(std::int32_t owner, std::uint32_t item) {
    if (owner >= 0) words_[next_[static_cast<std::size_t>(owner)]++] = item;
  }
  [[nodiscard]] std::vector<std::uint32_t> take() { return std::move(words_); }

 private:
  std::vector<std::uint32_t> words_, next_;
};

std::vector<std::uint32_t> lists_of(std::int32_t vertex_count,
                                    const std::vector<std::int32_t>& owners) {
  VertexLists lists(vertex_count);
  for (const std::int32_t owner : owners) lists.count(owner);
  lists.end_counting();
  for (std::size_t i = 0; i < owners.size(); ++i)
    lists.add(owners[i], static_cast<std::uint32_t>(i));
  return lists.take();
}

}  // namespace

EditRecords edit_records(const PatchMesh& mesh, const PatchRecords& patches,
                         std::vector<std::uint32_t> slots) {
  const std::int32_t vertex_count = mesh.topology().vertex_count();
  if (patches.owners.size() + static_cast<std::size_t>(vertex_count) + 1 >
      std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::OutOfMemory,
                "edits count " + std::to_string(patches.owners.size()) +
                    " patches in words of 32 bits; use a lower level or a smaller mesh");
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
