#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "planish/mesh/polygon_mesh.h"

namespace planish::quality {

/// Points independent and even on the unit sphere.
[[nodiscard]] std::vector<glm::dvec3> random_sphere_points(std::int32_t count, std::uint32_t seed);

/// Their Delaunay triangulation: the convex hull, in time of the order of count squared. At least
/// four points, no four of them in a plane.
[[nodiscard]] std::vector<Triangle> delaunay_on_sphere(const std::vector<glm::dvec3>& points);

/// Meshes of uneven triangles, as scanning, simplifying and Delaunay's criterion leave them. The
/// same mesh for the same seed everywhere.

/// Random directions, connected as on the unit sphere, each at the place that `map` gives it.
[[nodiscard]] PolygonMesh hull_of_directions(
    std::int32_t count, std::uint32_t seed,
    const std::function<glm::dvec3(const glm::dvec3&)>& map);

/// Random points of the unit disc, `rim` of them on its rim, triangulated there, each at the place
/// that `map` gives it. Open: one boundary loop.
[[nodiscard]] PolygonMesh sheet_over_disc(std::int32_t inner, std::int32_t rim, std::uint32_t seed,
                                          const std::function<glm::dvec3(const glm::dvec2&)>& map);

/// Random points of the torus around the z axis, triangulated in its unrolled plane.
[[nodiscard]] PolygonMesh uneven_torus(std::int32_t count, std::uint32_t seed, double radius,
                                       double tube_radius);

/// A tube around the trefoil knot, `along` x `around` quads.
[[nodiscard]] PolygonMesh knot(std::int32_t along, std::int32_t around);

/// A mesh in few triangles: every vertex stays within that fraction of its diagonal.
[[nodiscard]] PolygonMesh simplified_within(const PolygonMesh& dense, double tolerance);

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

/// More meshes as other people's files hold them, drawn from their seeds.

/// Body through three rings of unlike counts, the first `sides` on a nearly flat ellipse, caps as
/// fans around a vertex of the rim: needles that wind about hubs at sharp rims.
[[nodiscard]] PolygonMesh flat_loft(std::int32_t sides, std::uint32_t seed);
/// Sheet torn to its middle, whose lips bend far apart up and down; `spokes` triangles around the
/// tear's end, in `rings`.
[[nodiscard]] PolygonMesh torn_sheet(std::int32_t spokes, std::int32_t rings, std::uint32_t seed);

/// Meshes of the kinds that came out worst of other programs' files: results of booleans, sheets
/// that touch, scans with holes. Each is drawn from its seed, the same on every machine, and passes
/// check().

/// Closed parts that cross each other, with slivers around hubs of `sides` faces.
[[nodiscard]] PolygonMesh crossing_parts(std::int32_t sides, std::uint32_t seed);
/// Tori that stand on each other along a ring of edges with four faces, as repair() separates them.
[[nodiscard]] PolygonMesh touching_tori(std::int32_t around, std::int32_t count,
                                        std::uint32_t seed);
/// Bent patches of one to six faces that share nothing, strewn over a sphere.
[[nodiscard]] PolygonMesh loose_sheets(std::int32_t count, std::uint32_t seed);
/// Few and large polygons, of which some are pinched between opposite corners.
[[nodiscard]] PolygonMesh pinched_polygons(std::int32_t count, std::uint32_t seed);
/// Triangles through noisy points of a bumpy sphere, with gaps that were out of the scanner's
/// sight.
[[nodiscard]] PolygonMesh holed_scan(std::int32_t points, std::uint32_t seed);

}  // namespace planish::quality
