#include "planish/files/stl/write_stl.h"

#include <glm/geometric.hpp>
#include <limits>
#include <string>
#include <vector>

#include "planish/core/error.h"
#include "planish/files/gltf/triangulate.h"

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

void write_stl(FileBuffer& out, const PolygonView& view) {
  constexpr std::size_t kHeaderBytes = 80;
  // A reader takes a file that begins with `solid` for text.
  std::string header = "binary STL by planish";
  header.resize(kHeaderBytes, ' ');
  out.text(header.substr(0, kHeaderBytes / 2)).text(header.substr(kHeaderBytes / 2));
  const std::size_t count = view.face_vertices.size() - 2 * view.face_count();
  if (count > std::numeric_limits<std::uint32_t>::max())
    throw Error(ErrorCode::InvalidArgument, std::to_string(count) +
                                                " triangles are more than an STL file can hold; "
                                                "use fewer levels");
  out.binary(static_cast<std::uint32_t>(count));
  std::vector<std::uint32_t> triangles;
  for (std::size_t face = 0; face < view.face_count(); ++face) {
    const auto corners = view.face(face);
    triangles.resize(3 * (corners.size() - 2));
    if (corners.size() == 4) {
      const auto split = split_quad(view.positions[corners[0]], view.positions[corners[1]],
                                    view.positions[corners[2]], view.positions[corners[3]]);
      for (std::size_t i = 0; i < split.size(); ++i)
        triangles[i] = static_cast<std::uint32_t>(corners[split[i]]);
    } else {
      triangulate(corners, view.positions, triangles);
    }
    for (std::size_t i = 0; i < triangles.size(); i += 3)
      write_triangle(out, view.positions[triangles[i]], view.positions[triangles[i + 1]],
                     view.positions[triangles[i + 2]]);
  }
}

}  // namespace planish
