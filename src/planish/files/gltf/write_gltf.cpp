#include "planish/files/gltf/write_gltf.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>  // for tinygltf
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/output_file.h"
#include "planish/core/parallel.h"
#include "planish/core/version.h"
#include "planish/core/words.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_source.h"
#include "planish/files/gltf/gltf_vertices.h"
#include "planish/files/materials.h"
#include "planish/files/mesh_file.h"

namespace planish {
namespace {

// Based on: Khronos, "glTF 2.0 Specification", 2021, sections 3 and 4 (GLB). tinygltf makes the
// JSON of what is new; the container is written here: tinygltf copies the buffer several times and
// corrupts files above 4 GiB.

}  // namespace
}  // namespace planish

// Compiled here, with planish's JSON and without what reads and writes files: under a name of its
// own, since a program may link tinygltf's library, too.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define tinygltf planish_tinygltf
#include <tiny_gltf.h>

namespace planish {
namespace {

using nlohmann::json;
using tinygltf::Value;

constexpr double kRoughness = 0.5;

template <class Vector>
std::vector<double> array_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

Value value_of(const std::variant<bool, std::int64_t, double, std::string>& held) {
  if (const auto* flag = std::get_if<bool>(&held)) return Value(*flag);
  if (const auto* number = std::get_if<double>(&held)) return Value(*number);
  if (const auto* text = std::get_if<std::string>(&held)) return Value(valid_utf8(*text));
  const std::int64_t integer = std::get<std::int64_t>(held);
  // tinygltf's integers have 32 bits.
  const int narrow = static_cast<int>(integer);
  return narrow == integer ? Value(narrow) : Value(static_cast<double>(integer));
}

tinygltf::Asset asset_of(const GltfOptions& options) {
  tinygltf::Asset asset;
  asset.version = "2.0";
  asset.generator = "planish " PLANISH_VERSION;
  Value::Object extras;
  for (const auto& [key, held] : options.extras) extras[valid_utf8(key)] = value_of(held);
  if (options.compression == GltfCompression::Meshopt)
    extras["vertex_order"] = Value(std::string("as triangles first use them"));
  if (!extras.empty()) asset.extras = Value(std::move(extras));
  return asset;
}

int type_of(std::string_view name) {
  if (name == "SCALAR") return TINYGLTF_TYPE_SCALAR;
  if (name == "VEC2") return TINYGLTF_TYPE_VEC2;
  return name == "VEC3" ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC4;
}

json accessor_json(const GltfArray& array, std::int64_t view) {
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(view);
  accessor.componentType = static_cast<int>(array.component);
  accessor.normalized = array.normalized;
  accessor.count = static_cast<std::size_t>(array.count);
  accessor.type = type_of(array.type);
  if (array.bounds) {
    accessor.minValues = array_of(array.bounds->minimum);
    accessor.maxValues = array_of(array.bounds->maximum);
  }
  json made;
  tinygltf::SerializeGltfAccessor(accessor, made);
  return made;
}

// Of an array in a document's last buffer, behind what is there. An array packed by a stream lies
// in the second one, which nobody has: it may be larger than the 32 bits of WebAssembly, and so
// than what tinygltf knows as an offset. Nor does it know extensions of views.
json view_json(const GltfArray& array, const GltfDocument& document) {
  tinygltf::BufferView view;
  view.buffer = array.stream ? 1 : static_cast<int>(document.full_buffers.size());
  view.byteLength = static_cast<std::size_t>(array.bytes);
  view.byteStride = array.stride;
  view.target =
      array.is_indices ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER : TINYGLTF_TARGET_ARRAY_BUFFER;
  json made;
  tinygltf::SerializeGltfBufferView(view, made);
  const std::uint64_t offset =
      array.offset + (array.stream ? document.decoded_bytes : document.buffer_bytes);
  if (offset > 0) made["byteOffset"] = offset;
  if (!array.stream) return made;
  json& stream = made["extensions"][kMeshoptExtension];
  stream = {{"buffer", 0},
            {"byteOffset", array.stream->offset + document.buffer_bytes},
            {"byteLength", array.stream->bytes},
            {"byteStride", array.bytes / array.count},
            {"count", array.count},
            {"mode", array.stream->mode}};
  if (array.stream->filter != "NONE") stream["filter"] = array.stream->filter;
  return made;
}

// Plain materials of the primitives, in order, each with its number.
std::vector<int> add_materials(std::span<const GltfPayload> surfaces, bool double_sided,
                               tinygltf::Model& model) {
  std::vector<int> numbers;
  std::map<std::string, int> known;
  for (const GltfPayload& surface : surfaces) {
    for (const GltfPrimitive& primitive : surface.primitives) {
      std::string name =
          valid_utf8(primitive.material.empty() ? primitive.name : primitive.material);
      const auto next = static_cast<int>(model.materials.size());
      const auto [entry, is_new] = known.try_emplace(name, next);
      numbers.push_back(surface.shares_materials ? entry->second : next);
      if (surface.shares_materials && !is_new) continue;
      tinygltf::Material& material = model.materials.emplace_back();
      material.pbrMetallicRoughness.metallicFactor = 0.0;
      material.pbrMetallicRoughness.roughnessFactor = kRoughness;
      material.doubleSided = double_sided;
      material.name = std::move(name);
    }
  }
  return numbers;
}

// What a primitive has besides its arrays. Primitives have no name of their own.
json plain_rest(const GltfPrimitive& primitive, int material) {
  json rest{{"material", material}, {"mode", TINYGLTF_MODE_TRIANGLES}};
  if (!primitive.name.empty()) rest["extras"] = {{"group", valid_utf8(primitive.name)}};
  if (primitive.encodes_ngons) rest["extensions"][kNgonExtension] = json::object();
  return rest;
}

// By USD's names.
json subdivision_json(const GltfSubdivision& given) {
  json made{{"subdivisionScheme", given.how.scheme},
            {"interpolateBoundary", boundary_of(given.how)}};
  const auto add = [&](const char* list, auto value) { made[list].push_back(value); };
  for (const CreaseEdge& crease : given.creases) {
    add("creaseIndices", crease.v0);
    add("creaseIndices", crease.v1);
    add("creaseLengths", 2);
    add("creaseSharpnesses", written_sharpness(crease.sharpness));
  }
  for (const CornerVertex& corner : given.corners) {
    add("cornerIndices", corner.vertex);
    add("cornerSharpnesses", written_sharpness(corner.sharpness));
  }
  for (const std::int32_t face : given.hole_faces) add("holeIndices", face);
  return made;
}

// A node of its name for each surface.
void add_nodes(std::span<const GltfPayload> surfaces, const std::string& given,
               tinygltf::Model& model) {
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    tinygltf::Node& node = model.nodes.emplace_back();
    model.scenes.front().nodes.push_back(static_cast<int>(i));
    node.mesh = static_cast<int>(i);
    node.name = valid_utf8(given + (surfaces.size() > 1 ? formatted(" {}", i + 1) : ""));
    if (surfaces[i].translation != glm::dvec3(0.0))
      node.translation = array_of(surfaces[i].translation);
    if (surfaces[i].scale != 1.0) node.scale = array_of(glm::dvec3(surfaces[i].scale));
  }
}

constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr std::uint32_t kGlbVersion = 2;
// Of a GLB and of each of its two chunks.
constexpr std::uint64_t kGlbHeaderBytes = 12, kGlbChunkHeaderBytes = 8;

std::string words(std::initializer_list<std::uint32_t> values) {
  return {reinterpret_cast<const char*>(values.begin()), values.size() * sizeof(std::uint32_t)};
}

void send(std::span<const ByteSink> sinks, std::span<const std::byte> bytes) {
  for (const ByteSink& sink : sinks) sink(bytes);
}

void send_buffer(std::span<const ByteSink> sinks, const GltfDocument& document) {
  for (const auto& write : document.parts) write(sinks);
}

void warn_if_large(std::uint64_t bytes, const GltfOptions& options) {
  if (bytes <= options.large_bytes) return;
  options.callbacks.warn(
      {"large-file", formatted("{}: {} bytes; many programs cannot open a glTF file as large as "
                               "this, fewer levels make it smaller",
                               options.name, bytes)});
}

std::vector<ByteSink> sinks_to(OutputFile& file, const GltfOptions& options) {
  std::vector<ByteSink> sinks{[&file](std::span<const std::byte> bytes) { file.write(bytes); }};
  if (options.observe) sinks.push_back(options.observe);
  return sinks;
}

// Its JSON, which goes, as text.
std::string take_text(GltfDocument& document, const std::filesystem::path& gltf) {
  std::string text = document.text(gltf);
  document.json = nullptr;
  return text;
}

// All of a GLB that stands before its buffer.
std::string take_head(GltfDocument& document, const GltfOptions& options) {
  std::string text = take_text(document, {});
  text.resize(padded(text.size()), ' ');
  const std::uint64_t bytes = glb_byte_count(text.size(), document.buffer_bytes, options.name);
  warn_if_large(bytes, options);
  text.insert(0, words({kGlbMagic, kGlbVersion, static_cast<std::uint32_t>(bytes),
                        static_cast<std::uint32_t>(text.size()), kJsonChunk}));
  return text += words({static_cast<std::uint32_t>(document.buffer_bytes), kBinaryChunk});
}

std::uint64_t write_glb(const std::filesystem::path& path, GltfDocument& document,
                        const GltfOptions& options) {
  const std::string head = take_head(document, options);
  OutputFile file(path);
  file.reserve(head.size() + document.buffer_bytes);
  write_text(file, head, options);
  send_buffer(sinks_to(file, options), document);
  file.commit();
  return head.size() + document.buffer_bytes;
}

std::uint64_t write_pair(const std::filesystem::path& path, GltfDocument& document,
                         const GltfOptions& options) {
  const std::string text = take_text(document, path);
  warn_if_large(document.buffer_bytes, options);
  OutputFile file(path), buffer(gltf_buffer_path(path, 0));
  buffer.reserve(document.buffer_bytes);
  const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
  send_buffer(std::span(&to_buffer, 1), document);
  write_text(file, text, options);
  buffer.commit();
  file.commit();
  return text.size() + document.buffer_bytes;
}

}  // namespace

std::int64_t GltfDocument::Places::next(nlohmann::json& list) {
  if (list.is_null()) list = nlohmann::json::array();
  if (free.empty()) {
    list.push_back(nullptr);
    return std::ssize(list) - 1;
  }
  return free.extract(free.begin()).value();
}

std::uint64_t GltfDocument::keep(std::span<const std::byte> bytes) {
  const std::uint64_t offset = buffer_bytes;
  parts.emplace_back([bytes](std::span<const ByteSink> sinks) { write_padded(bytes, sinks); });
  buffer_bytes += padded(bytes.size());
  return offset;
}

std::int64_t GltfDocument::add_view(std::span<const std::byte> bytes) {
  nlohmann::json& list = json["bufferViews"];
  const std::int64_t view = views.next(list);
  list[view] = {{"buffer", 0}, {"byteOffset", keep(bytes)}, {"byteLength", bytes.size()}};
  return view;
}

std::vector<std::int64_t> GltfDocument::add(const GltfPayload& payload) {
  std::vector<std::int64_t> numbers;
  for (const GltfArray& array : payload.arrays) {
    const std::int64_t view = views.next(json["bufferViews"]);
    json["bufferViews"][view] = view_json(array, *this);
    numbers.push_back(accessors.next(json["accessors"]));
    json["accessors"][numbers.back()] = accessor_json(array, view);
  }
  buffer_bytes += payload.buffer_bytes;
  decoded_bytes += payload.decoded_bytes;
  vertex_count += payload.vertex_count;
  triangle_count += payload.triangle_count;
  extensions.insert(payload.extensions.begin(), payload.extensions.end());
  return numbers;
}

std::string GltfDocument::text(const std::filesystem::path& gltf) {
  nlohmann::json& buffers = json["buffers"] = nlohmann::json::array();
  for (std::size_t i = 0; i <= full_buffers.size(); ++i) {
    const std::uint64_t bytes = i < full_buffers.size() ? full_buffers[i] : buffer_bytes;
    buffers.push_back({{"byteLength", bytes}});
    if (!gltf.empty()) buffers[i]["uri"] = encode_uri(utf8(gltf_buffer_path(gltf, i).filename()));
  }
  if (decoded_bytes > 0)
    buffers.push_back({{"byteLength", decoded_bytes},
                       {"extensions", {{kMeshoptExtension, {{"fallback", true}}}}}});
  return json.dump(gltf.empty() ? -1 : 2, ' ', false, nlohmann::json::error_handler_t::replace);
}

json asset_json(const GltfOptions& options) {
  json made;
  tinygltf::SerializeGltfAsset(asset_of(options), made);
  return made;
}

json primitive_json(const GltfPrimitive& primitive, std::span<const std::int64_t> accessors,
                    json rest) {
  constexpr std::string_view kTarget = "target/";
  for (const auto& [name, array] : primitive.attributes) {
    if (!name.starts_with(kTarget)) {
      rest["attributes"][valid_utf8(name)] = accessors[array];
      continue;
    }
    const std::size_t slash = name.find('/', kTarget.size());
    const std::size_t target = std::stoul(name.substr(kTarget.size()));
    while (rest["targets"].size() <= target) rest["targets"].push_back(json::object());
    rest["targets"][target][name.substr(slash + 1)] = accessors[array];
  }
  rest["indices"] = accessors[primitive.indices];
  return rest;
}

GltfDocument plain_document(std::span<const GltfPayload> surfaces, const GltfOptions& options) {
  tinygltf::Model model;
  model.asset = asset_of(options);
  model.defaultScene = 0;
  model.scenes.emplace_back();
  add_nodes(surfaces, options.name, model);
  const std::vector<int> materials = add_materials(surfaces, options.double_sided, model);
  GltfDocument document;
  tinygltf::SerializeGltfModel(&model, document.json);
  auto material = materials.begin();
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    if (i > 0) document.full_buffers.push_back(std::exchange(document.buffer_bytes, 0));
    const std::vector<std::int64_t> accessors = document.add(surfaces[i]);
    json& mesh = document.json["meshes"].emplace_back(json::object());
    if (!model.nodes[i].name.empty()) mesh["name"] = model.nodes[i].name;
    if (options.subdivision) mesh["extras"]["subdivision"] = subdivision_json(*options.subdivision);
    for (const GltfPrimitive& primitive : surfaces[i].primitives)
      mesh["primitives"].push_back(
          primitive_json(primitive, accessors, plain_rest(primitive, *material++)));
  }
  if (!document.extensions.empty())
    document.json["extensionsUsed"] = document.json["extensionsRequired"] = document.extensions;
  if (!options.ngon_groups.empty()) document.json["extensionsUsed"].push_back(kNgonExtension);
  return document;
}

GltfFile write_document(const std::filesystem::path& path, GltfDocument document,
                        const GltfOptions& options) {
  const bool is_glb = lower_case(utf8(path.extension())) == ".glb";
  const GltfFile written{.byte_count = is_glb ? write_glb(path, document, options)
                                              : write_pair(path, document, options),
                         .vertex_count = document.vertex_count,
                         .triangle_count = document.triangle_count,
                         .buffer_count = is_glb ? 0U : 1U};
  options.callbacks.report("write", 1);
  return written;
}

std::vector<std::byte> encode_document(GltfDocument document, const GltfOptions& options) {
  const std::string head = take_head(document, options);
  std::vector<std::byte> bytes;
  bytes.reserve(memory_size(head.size() + document.buffer_bytes, options.name));
  const ByteSink append = [&](std::span<const std::byte> piece) {
    bytes.insert(bytes.end(), piece.begin(), piece.end());
  };
  append(std::as_bytes(std::span(head)));
  send_buffer(std::span(&append, 1), document);
  options.callbacks.report("write", 1);
  return bytes;
}

void write_text(OutputFile& file, std::string_view text, const GltfOptions& options) {
  send(sinks_to(file, options), std::as_bytes(std::span(text)));
}

void write_padded(std::span<const std::byte> bytes, std::span<const ByteSink> sinks) {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  constexpr std::array<std::byte, 4> kZeros{};
  for (std::size_t at = 0; at < bytes.size(); at += kPiece)
    send(sinks, bytes.subspan(at, std::min(kPiece, bytes.size() - at)));
  if (bytes.size() % 4 != 0) send(sinks, std::span(kZeros).first(4 - bytes.size() % 4));
}

std::uint64_t glb_byte_count(std::uint64_t json_bytes, std::uint64_t buffer_bytes,
                             std::string_view name) {
  const std::uint64_t bytes =
      kGlbHeaderBytes + 2 * kGlbChunkHeaderBytes + padded(json_bytes) + padded(buffer_bytes);
  if (bytes > std::numeric_limits<std::uint32_t>::max()) {
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} bytes are more than a .glb file can hold (4294967295); write "
                          ".gltf, whose .bin has no such limit, or use fewer levels",
                          name, bytes));
  }
  return bytes;
}

std::string encode_uri(std::string_view file_name) {
  constexpr std::string_view kHexDigits = "0123456789ABCDEF";
  constexpr std::string_view kUnreserved = "-._~";
  std::string uri;
  for (const char c : file_name) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain =
        byte < 128 && (std::isalnum(byte) || kUnreserved.find(c) != kUnreserved.npos);
    if (plain) {
      uri += c;
    } else {
      uri += {'%', kHexDigits[byte / 16], kHexDigits[byte % 16]};
    }
  }
  return uri;
}

namespace {

GltfDocument document_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  const auto payload = std::make_shared<const GltfPayload>(payload_of(surface, options, is_glb));
  GltfDocument document = plain_document(std::span(payload.get(), 1), options);
  document.parts.emplace_back(
      [payload](std::span<const ByteSink> sinks) { payload->write(sinks); });
  if (options.materials != nullptr) options.materials->apply(document, options.image_folder);
  return document;
}

// A document and buffers of some faces each, one after another.
class SeveralBuffers {
 public:
  SeveralBuffers(const std::filesystem::path& path, const SurfaceBlocks& surface,
                 std::uint64_t surface_bytes, const GltfOptions& options)
      : path_(path), surface_(surface), surface_bytes_(surface_bytes), options_(options) {}

  GltfFile write() {
    OutputFile file(path_);
    const std::int64_t all = surface_.info().face_count;
    DegenerateRows degenerate;
    for (std::int64_t first = 0; first < all;) first += write_block(first, degenerate);
    warn_of(degenerate, options_.callbacks);
    GltfDocument document = plain_document(blocks_, options_);
    const std::string text = document.text(path_);
    write_text(file, text, options_);
    for (const auto& buffer : buffers_) buffer->commit();
    file.commit();
    options_.callbacks.report("write", 1);
    GltfFile written{.byte_count = text.size(),
                     .vertex_count = document.vertex_count,
                     .triangle_count = document.triangle_count,
                     .buffer_count = buffers_.size()};
    for (const GltfPayload& block : blocks_) written.byte_count += block.buffer_bytes;
    return written;
  }

 private:
  // Returns how many faces it has taken.
  std::int64_t write_block(std::int64_t first, DegenerateRows& degenerate) {
    RowRange faces = faces_of_buffer(surface_, first, surface_bytes_, options_);
    auto block = std::make_unique<GltfBlock>(surface_, faces, options_);
    // Where faces that follow one another lie apart, more of their vertices are in two blocks.
    while (block->buffer_bytes() > options_.buffer_bytes && faces.count > 1) {
      faces.count /= 2;
      block = std::make_unique<GltfBlock>(surface_, faces, options_);
    }
    const double done =
        static_cast<double>(first) / static_cast<double>(surface_.info().face_count);
    const double share =
        static_cast<double>(faces.count) / static_cast<double>(surface_.info().face_count);
    block->options().callbacks.progress = share_of(options_.callbacks, done, done + share).progress;
    GltfPayload& payload = blocks_.emplace_back(block->payload(degenerate));
    payload.shares_materials = true;
    OutputFile& buffer = *buffers_.emplace_back(
        std::make_unique<OutputFile>(gltf_buffer_path(path_, buffers_.size())));
    buffer.reserve(payload.buffer_bytes);
    const ByteSink to_buffer = [&](std::span<const std::byte> bytes) { buffer.write(bytes); };
    payload.write(std::span(&to_buffer, 1));
    payload.write_plain = nullptr;  // the block goes
    return faces.count;
  }

  const std::filesystem::path& path_;
  const SurfaceBlocks& surface_;
  std::uint64_t surface_bytes_;
  const GltfOptions& options_;
  std::vector<GltfPayload> blocks_;
  std::vector<std::unique_ptr<OutputFile>> buffers_;
};

// A surface whose seams and groups make copies has more.
std::uint64_t least_buffer_bytes(const SurfaceInfo& info, const GltfOptions& options) {
  GltfVertices vertices;
  vertices.parts = {
      {.vertex_count = info.row_count,
       .uv_sets = info.uv_count > 0 ? 1 + static_cast<int>(options.further_uvs.size()) : 0,
       .triangle_count = static_cast<std::uint64_t>(info.corner_count - 2 * info.face_count)}};
  return plain_payload(info, vertices, options).buffer_bytes;
}

}  // namespace

std::vector<std::byte> encode_glb(const SurfaceBlocks& surface, const GltfOptions& options) {
  const HostScope host(options.callbacks);
  if (options.compression == GltfCompression::None)
    (void)memory_size(least_buffer_bytes(surface.info(), options), options.name);
  return encode_document(document_of(surface, options, true), options);
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceBlocks& surface,
                    const GltfOptions& options) {
  const std::string extension = lower_case(utf8(path.extension()));
  if (extension != ".glb" && extension != ".gltf") {
    throw Error(ErrorCode::InvalidArgument,
                visible(path) + ": extension is neither .glb nor .gltf");
  }
  if (options.materials != nullptr) require_apart(options.materials->input, path, *format_of(path));
  const HostScope host(options.callbacks);
  const std::uint64_t bytes = least_buffer_bytes(surface.info(), options);
  const bool is_glb = extension == ".glb";
  if (!is_glb && options.compression == GltfCompression::None && bytes > options.buffer_bytes) {
    require_numbers(surface, options);
    return SeveralBuffers(path, surface, bytes, options).write();
  }
  return write_document(path, document_of(surface, options, is_glb), options);
}

std::filesystem::path gltf_buffer_path(const std::filesystem::path& document, std::size_t index) {
  std::filesystem::path path = document;
  if (index == 0) return path.replace_extension(".bin");
  return path.replace_filename(path_of(formatted("{}-{}.bin", utf8(document.stem()), index + 1)));
}

std::vector<std::byte> encode_glb(const SurfaceMesh& surface, const GltfOptions& options) {
  require_writable(surface, options);
  return encode_glb(*blocks_of(surface, {}), options);
}

GltfFile write_gltf(const std::filesystem::path& path, const SurfaceMesh& surface,
                    const GltfOptions& options) {
  require_writable(surface, options);
  return write_gltf(path, *blocks_of(surface, {}), options);
}

void written_positions(const SurfaceBlocks& surface, const GltfOptions& options, RowRange rows,
                       std::span<glm::dvec3> positions) {
  const StoredPosition stored(options);
  std::vector<glm::vec3> made(positions.size());
  RowTarget target;
  target.stored = made;
  target.origin = options.origin;
  (void)surface.rows(rows, target);
  for (std::size_t i = 0; i < made.size(); ++i) positions[i] = stored.load(stored.turn(made[i]));
}

std::vector<glm::dvec3> written_positions(const SurfaceMesh& surface, const GltfOptions& options,
                                          std::size_t count) {
  std::vector<glm::dvec3> written(std::min(count, surface.positions.size()));
  written_positions(*blocks_of(surface, {}), options,
                    {0, static_cast<std::int64_t>(written.size())}, written);
  return written;
}

}  // namespace planish
