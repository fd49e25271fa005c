#pragma once

#include <cstdint>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// Meshes as other people's files hold them: uneven, full of needles, open along ragged lines,
/// folded. Each is drawn from its seed, the same on every machine, and passes check().

/// Icosphere of `level` without `holes` patches of faces, the rims' vertices strewn.
[[nodiscard]] PolygonMesh holed_sphere(std::int32_t level, std::int32_t holes, std::uint32_t seed);
/// Open tube whose two ends zigzag along its axis.
[[nodiscard]] PolygonMesh zigzag_tube(std::int32_t sides, std::int32_t rings, std::uint32_t seed);
/// Flat disc with a zigzag rim and single triangles missing.
[[nodiscard]] PolygonMesh holed_disc(std::int32_t sides, std::int32_t rings, std::uint32_t seed);
/// Wavy sheet whose boundary edges carry needle triangles.
[[nodiscard]] PolygonMesh needle_sheet(std::int32_t cells, std::uint32_t seed);
/// Box of quads, their grid lines at very unequal distances; or of those cut in two by lot.
[[nodiscard]] PolygonMesh uneven_box(std::int32_t cells, std::uint32_t seed, bool cut);
/// Icosphere of level 1 with spikes at vertices drawn by lot.
[[nodiscard]] PolygonMesh spiked_star(std::uint32_t seed);
/// A four-legged animal of about `vertices` vertices in triangles, its edges sharp.
[[nodiscard]] PolygonMesh low_poly_animal(std::int32_t vertices, std::uint32_t seed);
/// The bust's head by our own simplifier, to `percent` of its vertices.
[[nodiscard]] PolygonMesh decimated_head(double percent, double tolerance);
/// Flat coin whose two sides are cut into needles around hubs off its middle.
[[nodiscard]] PolygonMesh needle_disc(std::int32_t sides, std::uint32_t seed);
/// Body of revolution about z of `sides` needles a ring; spindle 0: a sphere, else that long.
[[nodiscard]] PolygonMesh needle_spindle(std::int32_t sides, std::int32_t rings, double spindle);
/// Icosphere of level 2 with `count` vertices dragged across their neighbours.
[[nodiscard]] PolygonMesh folded_sphere(std::int32_t count, std::uint32_t seed);
/// Three bent sheets that meet at one line, as repair() separates them.
[[nodiscard]] PolygonMesh three_sheets(std::int32_t cells, std::uint32_t seed);
/// Thin pipe of three legs with mitre joints, in needles as long as the legs, caps as fans around a
/// vertex of the rim.
[[nodiscard]] PolygonMesh mitred_pipe(std::int32_t sides, double length, std::uint32_t seed);
/// Triangles of a mesh, simplified within a tolerance that is a part of its diagonal.
[[nodiscard]] PolygonMesh simplified(const PolygonMesh& mesh, double tolerance,
                                     std::int64_t target_vertices = 0);

}  // namespace planish::quality
