#include "planish/vulkan/edit/edit_tables.h"

#include <string>
#include <vector>

namespace planish::vulkan {

namespace {

Buffer make_words(const Maker& on, const std::vector<std::uint32_t>& words, const char* name) {
  const std::uint64_t bytes = words.size() * sizeof(std::uint32_t);
  return make_bindable(on, bytes, name);
}

}  // namespace

EditTables::EditTables(const Maker& on, const EditRecords& records)
    : job_count(records.job_count),
      slots(make_words(on, records.slots, "planish slots")),
      places(make_words(on, records.places, "planish places of vertices")),
      jobs(make_words(on, records.jobs, "planish patches of vertices")) {}

}  // namespace planish::vulkan
