#pragma once

#include <cstdint>
#include <span>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

struct CreaseDetectionOptions {
  double dihedral_degrees = 30;  ///< edges whose faces turn by more become creases
  double corner_degrees = 60;    ///< vertices where a crease line turns by more become corners
  /// One flag a vertex, or none: edges with an end at one of these are left smooth and the vertex
  /// no corner, unless tagged.
  std::span<const std::uint8_t> smooth_vertices{};
};

/// Adds creases and corners that the shape suggests to those the mesh has: every edge whose two
/// faces' normals differ by more than `dihedral_degrees`, except
///   - what does not stand out from its surroundings (coherent_edges.h) nor carries a line on
///     straight that does;
///   - lines of which no edge turns by 50 degrees or has flat faces around or on one side, and that
///     are no ring of edges that turn alike;
///   - the flatter of two edges that fold a line back on itself, by less than 15 degrees, as both
///     long edges of a needle do;
///   - lines of a single edge that touch no other crease and no boundary;
/// and as corners the vertices where a line of two sharp edges turns by more than `corner_degrees`
/// (three or more sharp edges make a corner by themselves), and cone_apexes(). A lower sharpness of
/// an edge that is found sharp is replaced. Throws Error{UnusableMesh} for a mesh that does not
/// pass check(), Error{InvalidArgument} for angles outside 0 to 180 and for another number of
/// flags.
[[nodiscard]] PolygonMesh with_detected_creases(const PolygonMesh& mesh,
                                                const CreaseDetectionOptions& options = {});

/// The same in place, for a mesh that passes check() and whose connectivity is at hand.
void detect_creases(PolygonMesh& mesh, const MeshTopology& topology,
                    const CreaseDetectionOptions& options = {});

}  // namespace planish
