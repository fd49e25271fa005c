#include "planish/distributed/write_cage.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "planish/core/error.h"
#include "planish/files/shared/srgb.h"

namespace planish {

namespace {

constexpr std::size_t kShortCount = 255;
static_assert(std::endian::native == std::endian::little, "files are written as memory has them");

template <class Value>
void put(RawVector<std::byte>& bytes, Value value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof(Value));
}

std::string head_of(std::int64_t vertices, std::int64_t face_total, const CageFaces& faces,
                    const std::vector<std::string>& header) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& line : header) text += "comment " + line + "\n";
  text += formatted("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
                    vertices);
  if (faces.has_colors)
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  text += formatted("element face {}", face_total);
  text += faces.has_short_counts ? "\nproperty list uchar" : "\nproperty list int";
  return text + " int vertex_indices\nend_header\n";
}

// As the writer of PLY has them.
std::vector<std::array<std::uint8_t, 4>> encoded_colors(std::span<const glm::vec4> colors) {
  std::vector<std::array<std::uint8_t, 4>> encoded;
  encoded.reserve(colors.size());
  for (const glm::vec4& color : colors) {
    const glm::dvec4 share = srgb_of_linear(color);
    std::array<std::uint8_t, 4>& to = encoded.emplace_back();
    for (int k = 0; k < 4; ++k) to[k] = static_cast<std::uint8_t>(std::lround(255 * share[k]));
  }
  return encoded;
}

RawVector<std::byte> vertex_bytes(std::span<const glm::dvec3> positions, const CageFaces& faces) {
  RawVector<std::byte> bytes;
  bytes.reserve(positions.size() * (sizeof(glm::dvec3) + 4));
  for (std::size_t v = 0; v < positions.size(); ++v) {
    put(bytes, positions[v]);
    put(bytes, faces.colors[v]);
  }
  return bytes;
}

}  // namespace

CageFaces encode_faces(const Ranks& ranks, std::span<const std::int64_t> sizes,
                       std::span<const std::int64_t> corners, std::int64_t vertex_total) {
  CageFaces faces;
  std::int64_t largest = 0;
  for (const std::int64_t size : sizes) largest = std::max(largest, size);
  faces.has_short_counts = max_over(ranks, largest) <= static_cast<std::int64_t>(kShortCount);
  agree(ranks, [&] {
    if (vertex_total > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::InvalidArgument,
                  formatted("--cage: a PLY's int indices end at 2^31 - 1, and the cage has {} "
                            "vertices; leave it out",
                            vertex_total));
    const std::size_t count_bytes = faces.has_short_counts ? 1 : 4;
    faces.bytes.reserve(4 * corners.size() + count_bytes * sizes.size());
    std::size_t corner = 0;
    for (const std::int64_t size : sizes) {
      if (faces.has_short_counts) {
        put(faces.bytes, static_cast<std::uint8_t>(size));
      } else {
        put(faces.bytes, static_cast<std::int32_t>(size));
      }
      for (std::int64_t i = 0; i < size; ++i)
        put(faces.bytes, static_cast<std::int32_t>(corners[corner++]));
    }
  });
  return faces;
}

CageFaces encode_cage_faces(const Ranks& ranks, const MeshSlice& slice) {
  std::vector<std::int64_t> sizes;
  sizes.reserve(static_cast<std::size_t>(slice.face_count()));
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    sizes.push_back(static_cast<std::int64_t>(slice.face(f).size()));
  CageFaces faces = encode_faces(ranks, sizes, slice.face_vertices, slice.vertex_total());
  faces.has_colors = slice.attributes.has_colors;
  faces.colors = encoded_colors(slice.attributes.colors);
  return faces;
}

void write_cage(const Ranks& ranks, const Layout& vertices, std::int64_t face_total,
                std::span<const glm::dvec3> positions, const CageFaces& faces,
                const std::vector<std::string>& header, StagedFile& file) {
  static_assert(sizeof(glm::dvec3) == 24);
  const std::int64_t vertex_stride = faces.has_colors ? 28 : 24;
  const std::string head = head_of(vertices.back(), face_total, faces, header);
  const auto head_bytes = static_cast<std::int64_t>(head.size());
  file.write(0, ranks.rank == 0 ? std::as_bytes(std::span(head)) : std::span<const std::byte>());
  const RawVector<std::byte> colored =
      faces.has_colors ? vertex_bytes(positions, faces) : RawVector<std::byte>();
  file.write(head_bytes + vertex_stride * vertices[ranks.rank],
             faces.has_colors ? std::span<const std::byte>(colored) : std::as_bytes(positions));
  const auto own = static_cast<std::int64_t>(faces.bytes.size());
  const std::int64_t faces_at = head_bytes + vertex_stride * vertices.back();
  const std::int64_t before = sum_before(ranks, own);
  file.write(faces_at + before, faces.bytes);
  file.close(faces_at + sum_over(ranks, own));
}

std::vector<glm::dvec3> in_file_order(const Ranks& ranks, const Layout& vertices,
                                      std::span<const std::int64_t> file_ids,
                                      std::span<const glm::dvec3> values) {
  struct Placed {
    std::int64_t file_id;
    glm::dvec3 value;
  };
  RawVector<Placed> placed(values.size());
  for (std::size_t v = 0; v < values.size(); ++v) placed[v] = {file_ids[v], values[v]};
  placed = route<Placed>(
      ranks, placed, [&](const Placed& p, std::size_t) { return owner_of(vertices, p.file_id); });
  std::vector<glm::dvec3> ordered(
      static_cast<std::size_t>(vertices[ranks.rank + 1] - vertices[ranks.rank]));
  for (const Placed& p : placed) ordered[p.file_id - vertices[ranks.rank]] = p.value;
  return ordered;
}

}  // namespace planish
