#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "planish/core/raw_vector.h"
#include "planish/distributed/mesh_slice.h"
#include "planish/distributed/staged_file.h"

namespace planish {

/// The faces of a slice as they stand in a cage's PLY, and the colours of its vertices, which are
/// kept from reading to writing: 17 bytes a quad, 4 a vertex.
struct CageFaces {
  bool has_short_counts = true;  ///< no face of any rank has more than 255 corners
  RawVector<std::byte> bytes;
  bool has_colors = false;  ///< on any rank
  std::vector<std::array<std::uint8_t, 4>> colors;
};

/// Throws AgreedError{InvalidArgument} above 2^31 - 1 vertices, which the file's indices cannot
/// name.
[[nodiscard]] CageFaces encode_cage_faces(const Ranks& ranks, const MeshSlice& slice);

/// The same of faces that are there already: `sizes` of each, then its `corners`, which are numbers
/// of the cage's `vertex_total`.
[[nodiscard]] CageFaces encode_faces(const Ranks& ranks, std::span<const std::int64_t> sizes,
                                     std::span<const std::int64_t> corners,
                                     std::int64_t vertex_total);

/// The cage as `planish fit` writes it: binary little-endian PLY, double positions. `positions`: of
/// the slice's vertices in the order of the file. Throws as StagedFile; not committed yet.
void write_cage(const Ranks& ranks, const Layout& vertices, std::int64_t face_total,
                std::span<const glm::dvec3> positions, const CageFaces& faces,
                const std::vector<std::string>& header, StagedFile& file);

/// Values of owned vertices sent to where they stand in the file.
[[nodiscard]] std::vector<glm::dvec3> in_file_order(const Ranks& ranks, const Layout& vertices,
                                                    std::span<const std::int64_t> file_ids,
                                                    std::span<const glm::dvec3> values);

}  // namespace planish
