#include "planish/files/gltf/gltf_blocks.h"

#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "planish/core/host_scope.h"
#include "planish/core/parallel.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_packing.h"
#include "planish/files/gltf/gltf_survey.h"
#include "planish/files/gltf/position_grid.h"
#include "planish/files/shared/ordered_stream.h"

namespace planish {
namespace {

// Of which all stand in memory.
constexpr std::size_t kBlocksAtOnce = 8;
// Of the room in a buffer: the vertices where two blocks meet are in both.
constexpr double kFill = 0.98;

struct PackedBlock {
  GltfContents contents;
  std::vector<glm::dvec3> decoded;
  std::vector<std::int32_t> rows;  // of the surface, of those
  std::uint64_t vertex_count = 0;
};

PackedBlock pack_block(const SurfaceBlocks& surface, RowRange faces, const GltfOptions& options,
                       const GltfBounds& bounds) {
  GltfBlock block(surface, faces, options);
  const auto rows = block.surface().surface_rows();
  const auto given = std::ranges::lower_bound(rows, options.decoded_rows) - rows.begin();
  PackedBlock packed;
  packed.rows.assign(rows.begin(), rows.begin() + given);
  packed.vertex_count = block.layout().vertex_count;
  block.options().decoded_rows = given;
  block.options().decoded = [&](std::span<const glm::dvec3> decoded) {
    packed.decoded.assign(decoded.begin(), decoded.end());
  };
  DegenerateRows known;  // by the survey of the whole
  GltfContents plain{block.document(known), {}};
  plain.buffer.reserve(block.layout().buffer_bytes);
  const ByteSink append = [&](std::span<const std::byte> piece) {
    plain.buffer.insert(plain.buffer.end(), piece.begin(), piece.end());
  };
  write_buffer(block.surface(), block.vertices(), block.options(), std::span(&append, 1));
  packed.contents = pack_gltf(plain, block.vertices(), block.options(), bounds);
  return packed;
}

// Of all rows.
GltfBounds bounds_of_rows(const SurfaceBlocks& surface, const GltfOptions& options) {
  GltfVertices all;
  all.kept_rows = surface.info().row_count;
  all.parts = {{.vertex_count = all.kept_rows}};
  return gltf_bounds(surface, all, options).front();
}

}  // namespace

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
  layout_ = gltf_layout(surface_, vertices_, options_);
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

GltfDocument GltfBlock::document(DegenerateRows& degenerate) const {
  const GltfSurvey found = gltf_survey(surface_, vertices_, options_, surface_.surface_rows());
  degenerate.add(found.degenerate);
  return plain_document(layout_, found.bounds, options_);
}

PackedGltf pack_by_blocks(const SurfaceBlocks& surface, const GltfOptions& options) {
  const GltfBounds bounds = bounds_of_rows(surface, options);
  tell_kept_float(options, bounds);
  const std::vector<RowRange> ranges = ranges_of(surface.info().face_count, kPackedFaces);
  LoopProgress progress(options.callbacks, "write", kGltfSurveyed, kGltfPacked, std::ssize(ranges));
  PackedGltf all;
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
      if (all.pieces.empty()) {
        all.document = std::move(block.contents.document);
        all.document.shares_materials = true;
      } else {
        append(all.document, block.contents.document);
      }
      all.vertex_count += block.vertex_count;
      all.pieces.push_back(std::move(block.contents.buffer));
    }
  }
  if (options.decoded) options.decoded(decoded);
  return all;
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
