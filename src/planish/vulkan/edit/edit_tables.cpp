#include "planish/vulkan/edit/edit_tables.h"

#include <string>
#include <vector>

namespace planish::vulkan {

namespace {

Buffer make_words(Context& context, const std::vector<std::uint32_t>& words, const char* name) {
  const std::uint64_t bytes = words.size() * sizeof(std::uint32_t);
  require_one_binding(context, bytes, sizeof(std::uint32_t), name);
  return {context, bytes, MemoryUse::Device, name};
}

}  // namespace

EditTables::EditTables(Context& context, const EditRecords& records)
    : job_count(records.job_count),
      slots(make_words(context, records.slots, "planish slots")),
      places(make_words(context, records.places, "planish places of vertices")),
      jobs(make_words(context, records.jobs, "planish patches of vertices")) {}

}  // namespace planish::vulkan
