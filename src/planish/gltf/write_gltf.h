#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "planish/surface/surface_mesh.h"

namespace planish {

struct GltfOptions {
  std::string name = "surface";  ///< of mesh and node
  bool double_sided = false;     ///< for open surfaces
  bool z_up = false;             ///< turn a Z-up model upright (x, z, -y)
  /// Vertices are stored about this point and node.translation carries it; zero for none.
  glm::dvec3 origin{0.0};
  /// asset.extras, in key order on output.
  std::vector<std::pair<std::string, std::variant<bool, std::int64_t, double, std::string>>> extras;
};

/// What was written.
struct GltfFile {
  std::uint64_t byte_count = 0;  ///< of all files together
  std::uint64_t vertex_count = 0, triangle_count = 0;
};

/// A GLB of the surface: float32 POSITION (with min/max of the float values) and NORMAL, one
/// buffer view each, u16 indices up to 65534 vertices, else u32; polygons and quads are split on
/// the shorter diagonal. One default PBR material (metallic 0, roughness 0.5).
/// Throws Error{InvalidArgument} at 4 GiB and above, naming .gltf as the way out.
[[nodiscard]] std::vector<std::byte> encode_glb(const SurfaceMesh& surface,
                                                const GltfOptions& options);

/// Writes .glb, or .gltf with a .bin beside it, by extension, through OutputFile.
GltfFile write_gltf(const std::filesystem::path& path, const SurfaceMesh& surface,
                    const GltfOptions& options);

}  // namespace planish
