#include "planish/files/gltf/gltf_payload.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_checks.h"
#include "planish/files/gltf/gltf_document.h"
#include "planish/files/gltf/gltf_packing.h"
#include "planish/files/gltf/gltf_survey.h"
#include "planish/files/gltf/position_grid.h"

namespace planish {
namespace {

// Of which all stand in memory.
constexpr std::size_t kBlocksAtOnce = 8;
// Of the room in a buffer: the vertices where two blocks meet are in both.
constexpr double kFill = 0.98;

// Packing needs all of a plain buffer.
void hold_buffer(const SurfaceBlocks& surface, const GltfVertices& vertices,
                 const GltfOptions& options, GltfPayload& plain) {
  RawVector<std::byte>& buffer = plain.pieces.emplace_back();
  buffer.reserve(plain.buffer_bytes);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    buffer.insert(buffer.end(), piece.begin(), piece.end());
  };
  write_buffer(surface, vertices, options, std::span(&append, 1));
}

GltfPayload pack_at_once(const SurfaceBlocks& surface, const GltfOptions& given) {
  GltfOptions options = given;
  options.callbacks = share_of(given.callbacks, 0, 0.5);
  const GltfVertices vertices = gltf_vertices(surface, options);
  GltfPayload plain = plain_payload(surface.info(), vertices, options);
  set_bounds(plain, gltf_bounds(surface, vertices, options), vertices, options);
  hold_buffer(surface, vertices, options, plain);
  const FloatBox bounds = bounds_of_all(plain);
  tell_kept_float(options, bounds);
  return pack_gltf(std::move(plain), vertices, options, bounds);
}

struct PackedBlock {
  GltfPayload payload;
  std::vector<glm::dvec3> decoded;
  std::vector<std::int32_t> rows;  // of the surface, of those
};

PackedBlock pack_block(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options,
                       const FloatBox& bounds) {
  GltfBlock block(surface, faces, options);
  const auto rows = block.surface().surface_rows();
  const auto given = std::ranges::lower_bound(rows, options.decoded_rows) - rows.begin();
  PackedBlock packed;
  packed.rows.assign(rows.begin(), rows.begin() + given);
  block.options().decoded_rows = given;
  block.options().decoded = [&](std::span<const glm::dvec3> decoded) {
    packed.decoded.assign(decoded.begin(), decoded.end());
  };
  DegenerateRows known;  // by the survey of the whole
  GltfPayload plain = block.payload(known);
  hold_buffer(block.surface(), block.vertices(), block.options(), plain);
  packed.payload = pack_gltf(std::move(plain), block.vertices(), block.options(), bounds);
  return packed;
}

// Of all rows.
FloatBox bounds_of_rows(const SurfaceBlocks& surface, const GltfOptions& options) {
  GltfVertices all;
  all.kept_rows = surface.info().row_count;
  all.parts = {{.vertex_count = all.kept_rows}};
  return gltf_bounds(surface, all, options).front();
}

// Arrays and primitives of a block behind those of `all`, into the same mesh.
void append(GltfPayload block, GltfPayload& all) {
  const std::size_t first = all.arrays.size();
  for (GltfArray& array : block.arrays) {
    // The arrays that streams stand for lie in a buffer of their own.
    array.offset += array.stream ? all.decoded_bytes : all.buffer_bytes;
    if (array.stream) array.stream->offset += all.buffer_bytes;
    all.arrays.push_back(array);
  }
  for (GltfPrimitive& primitive : block.primitives) {
    for (auto& [name, array] : primitive.attributes) array += first;
    primitive.indices += first;
    all.primitives.push_back(std::move(primitive));
  }
  for (RawVector<std::byte>& piece : block.pieces) all.pieces.push_back(std::move(piece));
  all.buffer_bytes += block.buffer_bytes;
  all.decoded_bytes += block.decoded_bytes;
  all.vertex_count += block.vertex_count;
  all.triangle_count += block.triangle_count;
}

GltfPayload pack_by_blocks(const SurfaceBlocks& surface, const GltfOptions& options) {
  const FloatBox bounds = bounds_of_rows(surface, options);
  tell_kept_float(options, bounds);
  const std::vector<RowRange> ranges = ranges_of(surface.info().face_count, kPackedFaces);
  LoopProgress progress(options.callbacks, "write", kGltfSurveyed, kGltfPacked, std::ssize(ranges));
  GltfPayload all;
  std::vector<glm::dvec3> decoded(
      static_cast<std::size_t>(std::min(surface.info().row_count, options.decoded_rows)));
  for (std::size_t first = 0; first < ranges.size(); first += kBlocksAtOnce) {
    std::vector<PackedBlock> blocks(std::min(kBlocksAtOnce, ranges.size() - first));
    parallel_each(blocks.size(), 1, [&](std::size_t i) {
      // A thread that waits here must not begin another block.
      oneapi::tbb::this_task_arena::isolate(
          [&] { blocks[i] = pack_block(surface, ranges[first + i], options, bounds); });
      progress.add();
    });
    for (PackedBlock& block : blocks) {
      for (std::size_t i = 0; i < block.decoded.size(); ++i)
        decoded[block.rows[i]] = block.decoded[i];
      if (all.arrays.empty()) {
        all = std::move(block.payload);
      } else {
        append(std::move(block.payload), all);
      }
    }
  }
  all.shares_materials = true;
  if (options.decoded) options.decoded(decoded);
  return all;
}

}  // namespace

void GltfPayload::write(std::span<const ByteSink> sinks) const {
  if (pieces.empty()) return write_plain(sinks);
  for (const RawVector<std::byte>& piece : pieces) write_padded(piece, sinks);
}

GltfPayload payload_of(const SurfaceBlocks& surface, const GltfOptions& options, bool is_glb) {
  require_a_face(surface.info().face_count, options);
  if (options.compression != GltfCompression::None) {
    require_numbers(surface, options);
    const bool is_small = surface.info().face_count <= kPackedFaces;
    return is_small ? pack_at_once(surface, options) : pack_by_blocks(surface, options);
  }
  const auto vertices = std::make_shared<const GltfVertices>(gltf_vertices(surface, options));
  require_numbers(surface, options);
  GltfPayload payload = plain_payload(surface.info(), *vertices, options);
  // Before the work: it may not fit.
  if (is_glb) (void)glb_byte_count(0, payload.buffer_bytes, options.name);
  set_bounds(payload, gltf_bounds(surface, *vertices, options), *vertices, options);
  payload.write_plain = [&surface, &options, vertices](std::span<const ByteSink> sinks) {
    write_buffer(surface, *vertices, options, sinks);
  };
  return payload;
}

GltfBlock::GltfBlock(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options)
    : surface_(surface, faces), options_(options) {
  options_.callbacks = {};
  options_.fields.clear();
  options_.attributes = row_attributes(options);
  for (GltfAttribute& attribute : options_.attributes) {
    std::vector<float>& values = values_.emplace_back();
    const auto width = static_cast<std::size_t>(attribute.width);
    for (const std::int32_t i :
         attribute.of_uvs ? surface_.surface_uvs() : surface_.surface_rows()) {
      const auto of_one = attribute.values.subspan(width * static_cast<std::size_t>(i), width);
      values.insert(values.end(), of_one.begin(), of_one.end());
    }
    attribute.values = values;
    take_further(attribute);
  }
  for (std::span<const glm::dvec2>& set : options_.further_uvs) {
    std::vector<glm::dvec2>& values = uvs_.emplace_back();
    for (const std::int32_t uv : surface_.surface_uvs()) values.push_back(set[uv]);
    set = values;
  }
  vertices_ = gltf_vertices(surface_, options_);
  buffer_bytes_ = plain_payload(surface_.info(), vertices_, options_).buffer_bytes;
}

// Those in the block, under its numbers.
void GltfBlock::take_further(GltfAttribute& attribute) {
  if (attribute.further.empty()) return;
  std::vector<UvOnRow>& further = further_.emplace_back();
  std::vector<float>& values = values_.emplace_back();
  const auto place_of = [](std::span<const std::int32_t> all, std::int32_t number) {
    const auto found = std::ranges::lower_bound(all, number);
    return found != all.end() && *found == number ? static_cast<std::int32_t>(found - all.begin())
                                                  : -1;
  };
  for (const UvOnRow& one : attribute.further) {
    const std::int32_t uv = place_of(surface_.surface_uvs(), one.uv);
    const std::int32_t row = place_of(surface_.surface_rows(), one.row);
    if (uv < 0 || row < 0) continue;
    further.push_back({uv, row});
    const float* const numbers = attribute.numbers(one.uv, one.row);
    values.insert(values.end(), numbers, numbers + attribute.width);
  }
  attribute.further = further;
  attribute.further_values = values;
}

GltfPayload GltfBlock::payload(DegenerateRows& degenerate) const {
  const GltfSurvey found = gltf_survey(surface_, vertices_, options_, surface_.surface_rows());
  degenerate.add(found.degenerate);
  GltfPayload payload = plain_payload(surface_.info(), vertices_, options_);
  set_bounds(payload, found.bounds, vertices_, options_);
  payload.write_plain = [this](std::span<const ByteSink> sinks) {
    write_buffer(surface_, vertices_, options_, sinks);
  };
  return payload;
}

std::size_t gltf_buffer_count(std::uint64_t surface_bytes, std::uint64_t buffer_bytes) {
  if (surface_bytes <= buffer_bytes) return 1;
  return static_cast<std::size_t>(
      std::ceil(static_cast<double>(surface_bytes) / (kFill * static_cast<double>(buffer_bytes))));
}

RowRange faces_of_buffer(const SurfaceBlocks& surface, std::int64_t first,
                         std::uint64_t surface_bytes, const GltfOptions& options) {
  const std::int64_t all = surface.info().face_count;
  const double share =
      kFill * static_cast<double>(options.buffer_bytes) / static_cast<double>(surface_bytes);
  const auto count = static_cast<std::int64_t>(share * static_cast<double>(all));
  return {first, std::clamp<std::int64_t>(count, 1, all - first)};
}

}  // namespace planish
