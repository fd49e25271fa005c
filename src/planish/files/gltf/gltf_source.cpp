#include "planish/files/gltf/gltf_source.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>

#include "planish/core/error.h"
#include "planish/core/json.h"
#include "planish/core/words.h"
#include "planish/files/mesh_file.h"
#include "planish/files/read_file.h"
#include "planish/surface/memory_need.h"

namespace planish {
namespace {

// glTF's own structures are 8 deep; extras may be deeper, but recursive readers of the same file
// would overflow their stack long before anything useful stood there.
constexpr int kMaxDepth = 64;
constexpr std::int64_t kMaxInteger = std::int64_t{1} << 53;

}  // namespace

std::string JsonPlace::named() const {
  return std::string(file_) + (path_.empty() ? "" : ": " + path_);
}

void JsonPlace::fail(const std::string& what) const {
  throw Error(ErrorCode::UnreadableInput, named() + ": " + what);
}

std::string JsonPlace::clipped() const {
  constexpr std::size_t kLongest = 40;
  if (value_->is_structured()) return value_->is_array() ? "an array" : "an object";
  const std::string text = value_->dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  return text.size() > kLongest ? text.substr(0, kLongest) + "..." : text;
}

std::optional<JsonPlace> JsonPlace::find(std::string_view key) const {
  if (!value_->is_object()) fail(clipped() + " is no object");
  const auto found = value_->find(key);
  if (found == value_->end()) return std::nullopt;
  return JsonPlace(*found, file_, (path_.empty() ? "" : path_ + ".") + std::string(key));
}

JsonPlace JsonPlace::operator[](std::string_view key) const {
  std::optional<JsonPlace> found = find(key);
  if (!found) fail("has no `" + std::string(key) + "`");
  return *std::move(found);
}

JsonPlace JsonPlace::operator[](std::int64_t index) const {
  if (index >= array_size())
    fail("entry {} is asked for, but there are only {}", index, array_size());
  return {(*value_)[index], file_, formatted("{}[{}]", path_, index)};
}

std::int64_t JsonPlace::array_size() const {
  if (!value_->is_array()) fail(clipped() + " is no array");
  return static_cast<std::int64_t>(value_->size());
}

std::int64_t JsonPlace::integer(std::int64_t least) const {
  // Some writers put 12.0 for 12.
  const double value = value_->is_number() ? value_->get<double>() : std::nan("");
  if (!(value >= static_cast<double>(least) && value <= static_cast<double>(kMaxInteger)) ||
      value != std::floor(value))
    fail("{} is no integer from {}", clipped(), least);
  return static_cast<std::int64_t>(value);
}

double JsonPlace::number() const {
  if (!value_->is_number()) fail(clipped() + " is no number");
  return value_->get<double>();
}

bool JsonPlace::boolean() const {
  if (!value_->is_boolean()) fail(clipped() + " is neither true nor false");
  return value_->get<bool>();
}

bool JsonPlace::is_text() const { return value_->is_string(); }

bool JsonPlace::is_object() const { return value_->is_object(); }

const std::string& JsonPlace::text() const {
  if (!value_->is_string()) fail(clipped() + " is no text");
  return value_->get_ref<const std::string&>();
}

std::vector<std::string> JsonPlace::keys() const {
  if (!value_->is_object()) fail(clipped() + " is no object");
  std::vector<std::string> keys;
  for (const auto& [key, value] : value_->items()) keys.push_back(key);
  return keys;
}

std::int64_t JsonPlace::integer_or(std::string_view key, std::int64_t otherwise) const {
  const auto found = find(key);
  return found ? found->integer() : otherwise;
}

nlohmann::json parse_json(std::string_view text, std::string_view file) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(file) + ": " + what);
  };
  const auto limit_depth = [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
    if (depth > kMaxDepth) fail(formatted("JSON is nested deeper than {} levels", kMaxDepth));
    return true;
  };
  try {
    return nlohmann::json::parse(text, limit_depth);
  } catch (const nlohmann::json::exception& error) {
    // The library's messages begin with an identifier in brackets.
    const std::string message = error.what();
    const std::size_t begin = message.find("] ");
    fail(begin == std::string::npos ? message : message.substr(begin + 2));
  }
  return {};
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", section 4 (GLB).

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

GlbParts split_glb(std::span<const std::byte> bytes, std::string_view name) {
  constexpr std::size_t kHeader = 12, kChunkHeader = 8;
  constexpr std::uint32_t kJson = 0x4e4f534a, kBinary = 0x004e4942;
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, std::string(name) + ": " + what);
  };
  if (!text_of(bytes).starts_with("glTF")) {
    // After blanks, or a byte order mark.
    const std::size_t first = text_of(bytes).find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (first == std::string_view::npos || text_of(bytes)[first] != '{')
      fail("is no glTF: it starts neither with glTF nor with {");
    return {.json = text_of(bytes), .chunk = {}};
  }
  if (bytes.size() < kHeader + kChunkHeader)
    fail(formatted("a GLB begins with 20 bytes, but the file has {}", bytes.size()));
  const auto version = load<std::uint32_t>(bytes.subspan(4));
  if (version != 2) fail(formatted("GLB version {} is not 2", version));
  const auto length = load<std::uint32_t>(bytes.subspan(8));
  if (length > bytes.size() || length < kHeader)
    fail(formatted("header promises {} bytes, but the file has {}", length, bytes.size()));
  GlbParts parts{.json = {}, .chunk = {}, .format = FileFormat::Glb};
  std::span<const std::byte> left = bytes.subspan(kHeader, length - kHeader);
  for (int index = 0; left.size() >= kChunkHeader; ++index) {
    const auto size = load<std::uint32_t>(left);
    const auto type = load<std::uint32_t>(left.subspan(4));
    if (size > left.size() - kChunkHeader)
      fail(formatted("chunk {} promises {} bytes, but only {} follow", index, size,
                     left.size() - kChunkHeader));
    if (index == 0 && type != kJson) fail("the first chunk is not JSON");
    if (index == 0) parts.json = text_of(left.subspan(kChunkHeader, size));
    if (index == 1 && type == kBinary) parts.chunk = left.subspan(kChunkHeader, size);
    left = left.subspan(kChunkHeader + size);
  }
  return parts;
}

namespace {

// What a reader holds of each at its peak, lists that grow among it. A vertex of the largest
// primitive: its number and stamp; one that is placed: its position, its slot in a table. A corner:
// its vertex before and behind welding, its place in the mesh, its texture coordinate and group.
constexpr std::uint64_t kVertexBytes = 12, kPlacedBytes = 72, kCornerBytes = 28, kPointBytes = 110,
                        kUvBytes = 40, kNormalBytes = 48, kNumberBytes = 16;
// Scenes that need less are read without asking the system.
constexpr std::uint64_t kSmallScene = std::uint64_t{64} << 20;

std::string gibibytes_text(std::uint64_t bytes) {
  const std::uint64_t tenths = bytes / ((std::uint64_t{1} << 30) / 10);
  return formatted("{}.{} GiB", tenths / 10, tenths % 10);
}

}  // namespace

void GltfBudget::add_triangles(const JsonPlace& place, std::int64_t vertices,
                               std::int64_t corners) {
  if (vertices > limits_.corners)
    place.fail("names {} vertices; at most {} are read", vertices, limits_.corners);
  add(place, corners_, corners, "triangle corners and points");
  take(place, corners, kCornerBytes);
  take(place, std::min(vertices, corners), kPlacedBytes);
  if (vertices > largest_) take(place, vertices - largest_, kVertexBytes);
  largest_ = std::max(vertices, largest_);
}

void GltfBudget::add_points(const JsonPlace& place, std::int64_t points) {
  add(place, corners_, points, "triangle corners and points");
  take(place, points, kPointBytes);
}

void GltfBudget::add_uvs(const JsonPlace& place, std::int64_t uvs) {
  add(place, uvs_, uvs, "texture coordinates");
  take(place, uvs, kUvBytes);
}

void GltfBudget::add_normals(const JsonPlace& place, std::int64_t normals) {
  add(place, normals_, normals, "normals");
  take(place, normals, kNormalBytes);
}

void GltfBudget::add_numbers(const JsonPlace& place, std::int64_t numbers) {
  take(place, numbers, kNumberBytes);
}

void GltfBudget::add(const JsonPlace& place, std::int64_t& total, std::int64_t count,
                     const char* what) const {
  // Counts are at most 3 * 2^53 and what was let through is small.
  total += count;
  if (total > limits_.corners)
    place.fail(
        "the scene has more than {} {}, which 32-bit numbers do not reach; split it into "
        "several files",
        limits_.corners, what);
}

void GltfBudget::take(const JsonPlace& place, std::int64_t count, std::uint64_t bytes_each) {
  bytes_ += static_cast<std::uint64_t>(count) * bytes_each;
  if (limits_.memory_bytes == 0 && bytes_ <= kSmallScene) return;
  if (free_bytes_ == 0)
    free_bytes_ = limits_.memory_bytes > 0 ? limits_.memory_bytes : available_memory_bytes();
  if (bytes_ <= free_bytes_) return;
  throw Error(ErrorCode::OutOfMemory,
              formatted("{}: {}: the scene up to here needs about {} of memory where {} are free; "
                        "split it into several files",
                        file_, place.path(), gibibytes_text(bytes_), gibibytes_text(free_bytes_)));
}

namespace {

// Based on: Khronos Group, "glTF 2.0 Specification", sections 2.8 (URIs) and 3.6.1 (buffers).

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
    if (name) files.push_back(folder / path_of(*name));
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
  const std::filesystem::path path = path_.parent_path() / path_of(name);
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
