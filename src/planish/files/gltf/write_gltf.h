#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/files/write_polygons.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/surface/surface_blocks.h"

namespace planish {

struct GltfMaterials;  // materials.h

/// How numbers are stored. Quantize (KHR_mesh_quantization): normals and colours in 16 bits,
/// texture coordinates too where they lie between 0 and 1, and positions where position_error
/// allows it. Meshopt (EXT_meshopt_compression): positions on a grid as coarse as position_error
/// allows, else as float32; normals in 14 bits (0.02 degrees), colours in 16, texture coordinates
/// to an eighth of a texel of 16384; packed streams, with triangles and vertices in another order,
/// which asset.extras says ("vertex_order").
enum class GltfCompression { None, Quantize, Meshopt };

/// A texture coordinate of a surface on a row.
struct UvOnRow {
  std::int32_t uv, row;
  auto operator<=>(const UvOnRow&) const = default;
};

/// An attribute of the vertices that is ready: `width` numbers for each row of the surface.
struct GltfAttribute {
  /// As the format has it, "WEIGHTS_0"; of the k-th morph target "target/k/POSITION".
  std::string name;
  int width = 1;            ///< 1 to 4
  bool is_integer = false;  ///< stored in 16 bits without a sign
  std::span<const float> values;
  bool of_uvs = false;  ///< `width` numbers for each texture coordinate instead
  /// With of_uvs: texture coordinates on rows where they have other numbers, ascending, and these.
  std::span<const UvOnRow> further;
  std::span<const float> further_values;
  /// One flag for each group whose primitive has it; empty: all have.
  std::vector<std::uint8_t> in_groups;

  [[nodiscard]] bool is_in(std::int32_t group) const {
    return in_groups.empty() || in_groups[group < 0 ? 0 : group] != 0;
  }
  /// The numbers of a vertex; `uv` counts with of_uvs only.
  [[nodiscard]] const float* numbers(std::int32_t uv, std::int64_t row) const;
};

/// What a program needs to draw the surface of a control cage: see gltf_cage.h.
struct GltfSubdivision {
  CageSubdivision how;
  std::span<const CreaseEdge> creases;
  std::span<const CornerVertex> corners;
  std::vector<std::int32_t> hole_faces;  ///< counted over all primitives, ascending
};

struct GltfOptions {
  std::string name = "surface";  ///< of mesh and node
  bool double_sided = false;     ///< for open surfaces
  bool z_up = false;             ///< turn a Z-up model upright (x, z, -y)
  /// Vertices are stored about this point and node.translation carries it; zero for none.
  glm::dvec3 origin{0.0};
  /// asset.extras, in key order on output.
  std::vector<std::pair<std::string, std::variant<bool, std::int64_t, double, std::string>>> extras;
  /// Further figures of the vertices: "mean_curvature" becomes the attribute _MEAN_CURVATURE. One
  /// value for each position of the surface; they must outlive the call.
  std::vector<NamedField> fields;
  /// The same for attributes that have their names already.
  std::vector<GltfAttribute> attributes;
  /// TEXCOORD_1, TEXCOORD_2 ...: other values, one for each texture coordinate of the surface.
  std::vector<std::span<const glm::dvec2>> further_uvs;
  /// How many sets of texture coordinates the primitive of each group has; empty: all of them,
  /// unless they are all zero.
  std::vector<int> uv_sets;
  /// One flag for each group whose triangles are written so that they encode the surface's faces as
  /// FB_ngon_encoding has it; empty: none are. Meshopt's order of triangles encodes none.
  std::vector<std::uint8_t> ngon_groups;
  /// Corners of the largest faces that are encoded so; larger ones become separate triangles.
  std::size_t most_fanned = 4;
  /// extras of the mesh; must outlive the call.
  const GltfSubdivision* subdivision = nullptr;
  /// In the place of plain materials for groups of their names; must outlive the call.
  const GltfMaterials* materials = nullptr;
  /// Where their images stand, as a relative URI with a slash at its end; empty: in the file. A
  /// .gltf of several buffers has none.
  std::string image_folder;
  GltfCompression compression = GltfCompression::None;
  /// How far compression may move a position, in model units.
  double position_error = 0;
  /// Positions lie on multiples of this about the origin, at most 2^23 of them away: compression
  /// keeps them as they are, in 16 bits where it is Quantize and 2^15 reach. 0: it makes a grid.
  double grid_step = 0;
  /// With compression: gets the first decoded_rows positions of the surface, in its order, as
  /// readers decode them, in model coordinates.
  std::function<void(std::span<const glm::dvec3>)> decoded;
  std::int64_t decoded_rows = 0;
  /// With Quantize, where positions stay float32: gets how far 16 bits would move one; 0: the
  /// translation of a tiny model would be so small that other programs leave it out.
  std::function<void(double)> kept_float;
  /// The largest buffer beside a .gltf: a surface that needs more, uncompressed, has several, each
  /// with a mesh of its own. Many programs hold a buffer in one array of at most 2 GiB.
  std::uint64_t buffer_bytes = std::uint64_t{1} << 30;
  /// Gets all bytes of the .glb, or of the .gltf's document, in order while they are written: for a
  /// digest.
  std::function<void(std::span<const std::byte>)> observe;
  /// Beyond this a file gets the warning "large-file": many readers keep sizes in signed 32-bit
  /// numbers.
  std::uint64_t large_bytes = std::uint64_t{1} << 31;
  Callbacks callbacks;  ///< step "write"
};

/// What was written.
struct GltfFile {
  std::uint64_t byte_count = 0;  ///< of all files together
  std::uint64_t vertex_count = 0, triangle_count = 0;
  std::size_t buffer_count = 0;  ///< files beside a .gltf: see gltf_buffer_path()
};

/// A GLB of the surface: float32 POSITION (with min/max of the float values) and NORMAL, one
/// buffer view each, u16 indices up to 65534 vertices, else u32; polygons and quads are split on
/// the shorter diagonal, concave ones so that no triangle is turned over. PBR materials are the
/// default (metallic 0, roughness 0.5): one, or one and a primitive for each group that has faces,
/// with the material's name; the group's stands in the primitive's extras. Texture coordinates
/// become TEXCOORD_0 (v turned over), vertices on their seams get copies behind the others;
/// colours become COLOR_0. The same surface and options give the same bytes.
/// Fields are float32 scalars behind them.
/// Throws Error{InvalidArgument}: from 4 GiB on, naming .gltf as the way out; a surface without
/// faces; a field of another length; a number that float32 cannot hold, a normal that is not of
/// unit length, a face that names no vertex, texture coordinate or group, with its index as
/// element.
[[nodiscard]] std::vector<std::byte> encode_glb(const SurfaceMesh& surface,
                                                const GltfOptions& options);

/// The same of a surface that is made as it is written, which nobody holds; the same bytes.
[[nodiscard]] std::vector<std::byte> encode_glb(const SurfaceBlocks& surface,
                                                const GltfOptions& options);

/// Faces that compression packs in one piece; a larger surface is packed by blocks of so many.
inline constexpr std::int64_t kPackedFaces = std::int64_t{1} << 19;

/// A buffer of a .gltf: the first is NAME.bin, the next NAME-2.bin, NAME-3.bin ...
[[nodiscard]] std::filesystem::path gltf_buffer_path(const std::filesystem::path& document,
                                                     std::size_t index);

/// Writes .glb, or .gltf with a .bin of the same name beside it, by extension, through OutputFile;
/// the .bin appears first. Above options.buffer_bytes a .gltf has several buffers, of some faces
/// each, with a node and a mesh for each: vertices where they meet are in both. Takes a few MB
/// beside the surface, whatever its size; several buffers take 4 bytes a vertex of one. Compression
/// takes the packed file and, for each thread, some 100 MB.
/// Throws what encode_glb throws, Error{InvalidArgument} for another extension,
/// Error{UnwritableOutput}, Error{Cancelled}.
GltfFile write_gltf(const std::filesystem::path& path, const SurfaceMesh& surface,
                    const GltfOptions& options);
GltfFile write_gltf(const std::filesystem::path& path, const SurfaceBlocks& surface,
                    const GltfOptions& options);

/// The first `count` positions as a reader gets them from the file with these options: rounded to
/// float32 about the origin, with node.translation added in double and the turn of z_up undone.
/// What compression changes is not in it (see GltfOptions::decoded).
/// Comparing them with the wanted points measures the error as written.
[[nodiscard]] std::vector<glm::dvec3> written_positions(const SurfaceMesh& surface,
                                                        const GltfOptions& options,
                                                        std::size_t count);

/// The same of some rows of a surface that nobody holds, on the calling thread.
void written_positions(const SurfaceBlocks& surface, const GltfOptions& options, RowRange rows,
                       std::span<glm::dvec3> positions);

}  // namespace planish
