// Based on: Khronos Group, "glTF 2.0 Specification", sections 2.8 (URIs) and 3.6.1 (buffers).
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/read_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/number_text.h"
#include "planish/files/gltf/meshopt_stream.h"
#include "planish/files/mesh_file.h"

namespace planish {
namespace {

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  return c == '/' ? 63 : -1;
}

// Whatever has a URI: buffers, images, what extensions add.
void add_uris(const nlohmann::json& value, const std::filesystem::path& folder,
              std::vector<std::filesystem::path>& files) {
  if (!value.is_structured()) return;
  if (const auto uri = value.is_object() ? value.find("uri") : value.end();
      uri != value.end() && uri->is_string()) {
    const auto& text = uri->get_ref<const std::string&>();
    const auto name = text.starts_with("data:") ? std::nullopt : decode_uri_path(text);
    if (name) files.push_back(folder / *name);
  }
  for (const nlohmann::json& member : value) add_uris(member, folder, files);
}

// The document of a file: of a GLB without its buffer.
RawVector<std::byte> document_bytes(const std::filesystem::path& path) {
  constexpr std::size_t kJsonAt = 20;
  const auto start_of = [&](std::uint64_t most) {
    return read_named_start(path, path, FileReach::Anywhere, most).bytes;
  };
  const RawVector<std::byte> head = start_of(kJsonAt);
  const bool is_glb = head.size() == kJsonAt && std::memcmp(head.data(), "glTF", 4) == 0;
  if (!is_glb) return start_of(std::numeric_limits<std::uint64_t>::max());
  std::uint32_t length = 0;
  std::memcpy(&length, head.data() + 12, sizeof length);
  RawVector<std::byte> bytes = start_of(kJsonAt + std::uint64_t{length});
  bytes.erase(bytes.begin(), bytes.begin() + kJsonAt);
  return bytes;
}

}  // namespace

std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
  for (int padding = 0; padding < 2 && text.ends_with('='); ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3 + 2);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    bit_count += 6;
    if (bit_count < 8) continue;
    bit_count -= 8;
    bytes.push_back(static_cast<std::byte>(bits >> bit_count & 0xff));
  }
  return bytes;
}

std::string decode_percents(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned value = 0;
    const std::string_view digits = text[i] == '%' ? text.substr(i + 1, 2) : std::string_view();
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    const bool is_code =
        digits.size() == 2 && error == std::errc() && end == digits.data() + digits.size();
    decoded += is_code ? static_cast<char>(value) : text[i];
    if (is_code) i += 2;
  }
  return decoded;
}

std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  const std::string_view data = uri.substr(comma + 1);
  if (uri.substr(0, comma).ends_with(";base64") && data.find('%') == std::string_view::npos)
    return decode_base64(data);
  const std::string decoded = decode_percents(data);
  if (uri.substr(0, comma).ends_with(";base64")) return decode_base64(decoded);
  const auto bytes = std::as_bytes(std::span(decoded));
  return std::vector<std::byte>(bytes.begin(), bytes.end());
}

namespace {

// As browsers read it: programs for Windows leave their backslashes.
std::string file_name_of(std::string_view uri) {
  std::string name = decode_percents(uri);
  std::ranges::replace(name, '\\', '/');
  return name;
}

// Why a name is that of no file; empty: it may be one.
std::string_view why_no_file(const std::string& name) {
  if (name.empty() || name.find('\0') != std::string::npos) return "names no file";
  if (name.find(':') != std::string::npos)
    return "is the address of something elsewhere; copy it beside this file and name that";
  return "";
}

}  // namespace

std::optional<std::string> decode_uri_path(std::string_view uri) {
  std::string name = file_name_of(uri);
  if (!why_no_file(name).empty()) return std::nullopt;
  return name;
}

std::span<const std::byte> GltfSource::fetch(const JsonPlace& uri) { return fetch(uri, {}); }

std::span<const std::byte> GltfSource::fetch(const JsonPlace& uri,
                                             std::optional<std::uint64_t> wanted) {
  const std::string& text = uri.text();
  if (is_data_uri(text)) return decoded(uri);
  const std::pair key(text, wanted);
  if (const auto found = files_.find(key); found != files_.end()) return found->second;
  const std::string name = file_name_of(text);
  if (const std::string_view why = why_no_file(name); !why.empty())
    uri.fail("{} {}", quote(text), why);
  if (path_.empty()) uri.fail(quote(text) + " is another file, but only embedded data can be read");
  const std::filesystem::path path = path_.parent_path() / name;
  NamedFile file =
      wanted ? read_named_start(path, path_, reach_, *wanted) : read_named(path, path_, reach_);
  if (!file.trouble.empty()) uri.fail(file.trouble + "; it belongs to this file, copy it along");
  return files_.emplace(key, std::move(file.bytes)).first->second;
}

std::span<const std::byte> GltfSource::decoded(const JsonPlace& uri) {
  const std::string& text = uri.text();
  if (const auto found = decoded_.find(text); found != decoded_.end()) return found->second;
  const auto made = decode_data_uri(text);
  if (!made) uri.fail(quote(text) + " is no data URI: its base64 is broken, or it has no data");
  RawVector<std::byte> bytes;
  bytes.assign(made->begin(), made->end());
  return decoded_.emplace(text, std::move(bytes)).first->second;
}

std::span<const std::byte> GltfSource::buffer(std::int64_t index) {
  const JsonPlace place = root_["buffers"][index];
  const auto length = static_cast<std::uint64_t>(place["byteLength"].integer());
  const std::optional<JsonPlace> uri = place.find("uri");
  const bool is_chunk = !uri && index == 0 && !glb_chunk_.empty();
  if (!uri && !is_chunk) place.fail("has no `uri`, and there is no binary chunk for it");
  const std::span<const std::byte> bytes = is_chunk ? glb_chunk_ : fetch(*uri, length);
  if (length > bytes.size())
    place["byteLength"].fail("promises {} bytes, but there are only {}", length, bytes.size());
  return bytes.first(length);
}

std::span<const std::byte> GltfSource::view(std::int64_t index) {
  const JsonPlace place = root_["bufferViews"][index];
  const auto extensions = place.find("extensions");
  const auto packed = extensions ? extensions->find(kMeshoptExtension) : std::nullopt;
  if (!packed) return part(place);
  auto found = unpacked_.find(index);
  if (found == unpacked_.end())
    found = unpacked_.emplace(index, decode_meshopt(*packed, part(*packed))).first;
  return found->second;
}

std::span<const std::byte> GltfSource::part(const JsonPlace& place) {
  const std::span<const std::byte> bytes = buffer(place["buffer"].integer());
  const auto offset = static_cast<std::uint64_t>(place.integer_or("byteOffset", 0));
  const auto length = static_cast<std::uint64_t>(place["byteLength"].integer());
  // Both are at most 2^53, so that the sum cannot overflow.
  if (offset + length > bytes.size())
    place.fail(
        "bytes {} to {} are asked of a buffer of {}; fetch the file anew, it may be cut short",
        offset, offset + length, bytes.size());
  return bytes.subspan(offset, length);
}

std::vector<std::filesystem::path> gltf_named_files(const std::filesystem::path& path) {
  const RawVector<std::byte> bytes = document_bytes(path);
  std::vector<std::filesystem::path> files;
  try {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    add_uris(parse_json(text, ""), path.parent_path(), files);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::UnreadableInput) throw;  // who reads it says what is wrong
  }
  return files;
}

}  // namespace planish
