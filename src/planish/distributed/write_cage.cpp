#include "planish/distributed/write_cage.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "planish/core/error.h"

namespace planish {

namespace {

constexpr std::size_t kShortCount = 255;
static_assert(std::endian::native == std::endian::little, "files are written as memory has them");

template <class Value>
void put(RawVector<std::byte>& bytes, Value value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof(Value));
}

std::string head_of(std::int64_t vertices, std::int64_t faces, bool has_short_counts,
                    const std::vector<std::string>& header) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& line : header) text += "comment " + line + "\n";
  text += "element vertex " + std::to_string(vertices) +
          "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
          std::to_string(faces);
  text += has_short_counts ? "\nproperty list uchar" : "\nproperty list int";
  return text + " int vertex_indices\nend_header\n";
}

}  // namespace

CageFaces encode_cage_faces(const Ranks& ranks, const MeshSlice& slice) {
  CageFaces faces;
  std::int64_t largest = 0;
  for (std::int64_t f = 0; f < slice.face_count(); ++f)
    largest = std::max(largest, static_cast<std::int64_t>(slice.face(f).size()));
  faces.has_short_counts = max_over(ranks, largest) <= static_cast<std::int64_t>(kShortCount);
  agree(ranks, [&] {
    if (slice.vertex_total() > std::numeric_limits<std::int32_t>::max())
      throw Error(ErrorCode::InvalidArgument,
                  "--cage: a PLY's int indices end at 2^31 - 1, and the mesh has " +
                      std::to_string(slice.vertex_total()) + " vertices");
    const std::size_t count_bytes = faces.has_short_counts ? 1 : 4;
    faces.bytes.reserve(4 * slice.face_vertices.size() +
                        count_bytes * static_cast<std::size_t>(slice.face_count()));
    for (std::int64_t f = 0; f < slice.face_count(); ++f) {
      const auto named = slice.face(f);
      if (faces.has_short_counts) {
        put(faces.bytes, static_cast<std::uint8_t>(named.size()));
      } else {
        put(faces.bytes, static_cast<std::int32_t>(named.size()));
      }
      for (const std::int64_t vertex : named) put(faces.bytes, static_cast<std::int32_t>(vertex));
    }
  });
  return faces;
}

void write_cage(const Ranks& ranks, const Layout& vertices, std::int64_t face_total,
                std::span<const glm::dvec3> positions, const CageFaces& faces,
                const std::vector<std::string>& header, StagedFile& file) {
  static_assert(sizeof(glm::dvec3) == 24);
  const std::string head = head_of(vertices.back(), face_total, faces.has_short_counts, header);
  const auto head_bytes = static_cast<std::int64_t>(head.size());
  file.write(0, ranks.rank == 0 ? std::as_bytes(std::span(head)) : std::span<const std::byte>());
  file.write(head_bytes + 24 * vertices[ranks.rank], std::as_bytes(positions));
  const auto own = static_cast<std::int64_t>(faces.bytes.size());
  const std::int64_t faces_at = head_bytes + 24 * vertices.back();
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
