// Based on: Khronos Group, "glTF 2.0 Specification", sections 2.8 (URIs) and 3.6.1 (buffers).
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/read_file.h"

#include <algorithm>
#include <charconv>

#include "planish/core/error.h"
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

std::optional<std::string> decode_relative_uri(std::string_view uri) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    if (uri[i] != '%') {
      decoded += uri[i];
      continue;
    }
    unsigned value = 0;
    const std::string_view digits = uri.substr(i + 1, 2);
    const auto [end, error] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (digits.size() != 2 || error != std::errc() || end != digits.data() + 2) return std::nullopt;
    decoded += static_cast<char>(value);
    i += 2;
  }
  if (decoded.empty() || decoded.find('\0') != std::string::npos) return std::nullopt;
  if (decoded.find_first_of("\\:") != std::string::npos) return std::nullopt;
  const std::filesystem::path path(decoded);
  const bool leads_up = std::ranges::any_of(path, [](const auto& part) { return part == ".."; });
  if (path.is_absolute() || leads_up) return std::nullopt;
  return decoded;
}

std::span<const std::byte> GltfSource::fetch(const JsonPlace& uri) {
  const std::string& text = uri.text();
  if (const auto found = fetched_.find(text); found != fetched_.end()) return found->second;
  RawVector<std::byte> bytes;
  if (text.starts_with("data:")) {
    constexpr std::string_view kMark = ";base64,";
    const std::size_t mark = text.find(kMark);
    auto decoded = mark == std::string::npos
                       ? std::nullopt
                       : decode_base64(std::string_view(text).substr(mark + kMark.size()));
    if (!decoded) uri.fail(quote(text) + " is no base64 data URI");
    bytes.assign(decoded->begin(), decoded->end());
  } else {
    const std::optional<std::string> file = decode_relative_uri(text);
    if (!file) uri.fail(quote(text) + " leads away from the folder of the file");
    if (!folder_) uri.fail(quote(text) + " is another file, but only embedded data can be read");
    try {
      bytes = read_file(*folder_ / *file);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::UnreadableInput) throw;
      uri.fail(std::string(error.what()) + "; it belongs to this file, copy it along");
    }
  }
  return fetched_.emplace(text, std::move(bytes)).first->second;
}

std::span<const std::byte> GltfSource::buffer(std::int64_t index) {
  const JsonPlace place = root_["buffers"][index];
  const auto length = static_cast<std::uint64_t>(place["byteLength"].integer());
  const std::optional<JsonPlace> uri = place.find("uri");
  const bool is_chunk = !uri && index == 0 && !glb_chunk_.empty();
  if (!uri && !is_chunk) place.fail("has no `uri`, and there is no binary chunk for it");
  const std::span<const std::byte> bytes = is_chunk ? glb_chunk_ : fetch(*uri);
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

}  // namespace planish
