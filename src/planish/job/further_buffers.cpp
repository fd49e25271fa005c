#include "planish/job/further_buffers.h"

#include <cstddef>
#include <string>

#include "planish/core/json.h"
#include "planish/core/visible_text.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/write_gltf.h"
#include "planish/files/read_file.h"

namespace planish {
namespace {

namespace fs = std::filesystem;

// Documents of ours are far smaller.
constexpr std::uintmax_t kMostDocumentBytes = std::uintmax_t{1} << 26;

// How many buffers a document names that are named as its own would be.
std::size_t own_buffers(const fs::path& document) {
  std::error_code error;
  if (!fs::is_regular_file(fs::symlink_status(document, error)) ||
      fs::file_size(document, error) > kMostDocumentBytes || error)
    return 0;
  const RawVector<std::byte> text = read_named(document, document, FileReach::Anywhere).bytes;
  const auto* const letters = reinterpret_cast<const char*>(text.data());
  const nlohmann::json json = nlohmann::json::parse(letters, letters + text.size(), nullptr, false);
  if (!json.is_object() || !json.contains("buffers") || !json["buffers"].is_array()) return 0;
  std::size_t count = 0;
  for (const nlohmann::json& buffer : json["buffers"]) {
    const std::string name = encode_uri(gltf_buffer_path(document, count).filename().string());
    if (!buffer.is_object() || buffer.value("uri", nlohmann::json()) != name) break;
    ++count;
  }
  return count;
}

}  // namespace

void stage_further_buffers(const PlannedOutput& planned, const fs::path& written,
                           StagedFiles& staged) {
  std::size_t count = 1;
  for (; fs::exists(gltf_buffer_path(written, count)); ++count) {
    const fs::path buffer = gltf_buffer_path(planned.path, count);
    (void)staged.stage(buffer);
  }
  if (!staged.overwrites()) return;
  for (const std::size_t end = own_buffers(planned.path); count < end; ++count)
    staged.remove_later(gltf_buffer_path(planned.path, count));
}

}  // namespace planish
