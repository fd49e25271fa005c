#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "planish/files/mesh_file.h"

namespace planish {

/// Texture coordinates that faces have at their corners, face by face.
class PlyTextureCorners {
 public:
  /// Two numbers a corner, or none. Any other count, and numbers that are not finite, are none,
  /// too.
  void add_face(std::span<const double> numbers, std::size_t corner_count);

  /// Adds the faces behind.
  void append(const PlyTextureCorners& behind);

  /// Gives the mesh coordinates, unless no face has any: corners at one vertex with the same
  /// coordinates share one, so that there is a seam only where they differ. Warns of faces whose
  /// lists were none.
  void finish(MeshFile& file) const;

 private:
  std::vector<glm::dvec2> values_;  // of every corner
  std::vector<std::uint8_t> has_;
  std::int64_t wrong_count_ = 0, first_wrong_ = -1, face_count_ = 0;
};

}  // namespace planish
