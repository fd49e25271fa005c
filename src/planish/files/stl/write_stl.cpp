#include "planish/files/stl/write_stl.h"

#include <glm/geometric.hpp>
#include <limits>
#include <span>
#include <string>

#include "planish/core/error.h"

namespace planish {
namespace {

void write_vector(FileBuffer& out, const glm::vec3& v) { out.binary(v.x).binary(v.y).binary(v.z); }

void write_triangle(FileBuffer& out, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::dvec3 across =
      glm::cross(glm::dvec3(b) - glm::dvec3(a), glm::dvec3(c) - glm::dvec3(a));
  const double length = glm::length(across);
  write_vector(out, length > 0 ? glm::vec3(across / length) : glm::vec3(0.0f));
  for (const glm::vec3& corner : {a, b, c}) write_vector(out, corner);
  out.binary(std::uint16_t{0});
}

}  // namespace

void write_stl(const PolygonStream& stream) {
  constexpr std::size_t kHeaderBytes = 80;
  // A reader takes a file that begins with `solid` for text.
  std::string header = "binary STL by planish";
  header.resize(kHeaderBytes, ' ');
  const std::int64_t count = stream.totals().corner_count - 2 * stream.totals().face_count;
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::InvalidArgument,
                formatted("{}: {} triangles are more than an STL file can hold; use fewer levels",
                          stream.name(), count));
  stream.part(PolygonPart::Head, [&](FileBuffer& out, const PolygonPiece&, RowRange) {
    out.text(header).binary(static_cast<std::uint32_t>(count));
  });
  stream.part(PolygonPart::Triangles, [](FileBuffer& out, const PolygonPiece& piece, RowRange) {
    const std::span<const glm::dvec3> positions = piece.view.positions;
    for (std::size_t i = 0; i < positions.size(); i += 3)
      write_triangle(out, glm::vec3(positions[i]), glm::vec3(positions[i + 1]),
                     glm::vec3(positions[i + 2]));
  });
}

}  // namespace planish
