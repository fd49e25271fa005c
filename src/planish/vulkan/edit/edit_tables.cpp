#include "planish/vulkan/edit/edit_tables.h"

#include <string>
#include <vector>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

Buffer make_words(Context& context, const std::vector<std::uint32_t>& words, const char* name) {
  const std::uint64_t bytes = words.size() * sizeof(std::uint32_t);
  require_one_binding(context, bytes, sizeof(std::uint32_t), name);
  return {context, bytes, MemoryUse::Device, name};
}

}  // namespace

void require_one_binding(const Context& context, std::uint64_t bytes, std::uint64_t texel_bytes,
                         const char* what) {
  const auto refuse = [&](const std::string& limit, std::uint64_t value) {
    throw Error(ErrorCode::OutOfMemory, context.capabilities().name + ": " + what + " take " +
                                            std::to_string(bytes) + " bytes, which edits bind as " +
                                            "one, but " + limit + " is " + std::to_string(value) +
                                            "; use a smaller mesh or fewer instances");
  };
  if (bytes > context.max_storage_range())
    refuse("maxStorageBufferRange", context.max_storage_range());
  if (texel_bytes > 0 && bytes / texel_bytes > context.max_texel_elements())
    refuse("maxTexelBufferElements", context.max_texel_elements());
}

EditTables::EditTables(Context& context, const EditRecords& records)
    : job_count(records.job_count),
      slots(make_words(context, records.slots, "planish slots")),
      places(make_words(context, records.places, "planish places of vertices")),
      jobs(make_words(context, records.jobs, "planish patches of vertices")) {}

}  // namespace planish::vulkan
