#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// What a feature is; angles in degrees.
struct FeatureRules {
  /// Faces that turn by less are one plane; three times the noise of normals where it is known.
  double flat = 1;
  /// So much of a turn at most is explained by the smooth surface on one side: prisms of seven
  /// sides are round, of six not.
  double cap = 14;
  /// A jump from here on is a feature where nothing else speaks.
  double jump = 29;
  /// A jump is one where it is so many times what the surfaces around scatter by.
  double spread = 3;
  /// Of the size of a part, as roots of areas: from here on planes are large, and meet in features
  /// at any angle that nothing explains.
  double large = 0.02;
  /// Ways across a smooth surface differ by this factor at most from one to the next.
  double uneven = 3;
  /// What it costs, relative to its length, that a line begins or ends where it could go on.
  double line = 1;
  /// Cosine from which on edges are parallel across a face.
  double parallel = 0.94;
  /// Cosine from which on one edge continues another.
  double straight = 0.8;
  /// Each edge that turns by more is sharp, whatever explains it, and no other.
  std::optional<double> every;
};

/// Why an edge is sharp or smooth.
enum class FeatureReason {
  Tagged,     ///< the mesh says that it is sharp
  Turn,       ///< sharp: it turns by more than FeatureRules::every
  Jump,       ///< sharp: the surfaces of both sides disagree
  Line,       ///< sharp: continues lines that are, or such a line has a corner there
  Explained,  ///< smooth: the surfaces of both sides agree, or nearly
  Ended       ///< smooth although they disagree: no line goes on there
};

/// An edge at which the planes of both sides differ.
struct FeatureEdge {
  std::int32_t v0, v1;
  double turn;  ///< degrees; above 0 at ridges, below at valleys
  /// Degrees: the turn less what the surfaces of both sides explain, 0 or more; the turn itself
  /// where no edge of the mesh turns enough to be sharp, and with FeatureRules::every.
  double jump;
  FeatureReason reason;
  bool is_sharp;
};

struct Features {
  std::vector<FeatureEdge> edges;  ///< those that turn, in the order of MeshTopology
  std::vector<std::int32_t>
      corners;  ///< ascending: of outlines and of lines, tips, and tagged ones

  /// Edges that are sharp.
  [[nodiscard]] std::vector<CreaseEdge> sharp_edges() const;
};

/// The sharp features of a mesh: where extrapolations from both sides disagree. Tagged edges and
/// vertices of the mesh are among them. Time n log n. Throws Error{UnusableMesh} where faces do not
/// meet as a manifold, Error{InvalidArgument} for rules that are out of range.
[[nodiscard]] Features find_features(const PolygonMesh& mesh, const FeatureRules& rules = {});
/// The same where the connectivity is at hand.
/// `done` is told parts of 1 on the way, from the caller's thread.
[[nodiscard]] Features find_features(const PolygonMesh& mesh, const MeshTopology& topology,
                                     const FeatureRules& rules = {},
                                     const std::function<void(double)>& done = {});

/// A vertex at the smooth border of a plane, where the plane is the tangent plane of the surface.
struct KeptPlane {
  std::int32_t vertex;
  std::int32_t face;  ///< of the plane, at the vertex

  friend auto operator<=>(const KeptPlane&, const KeptPlane&) = default;
};

/// Where planes stay planes up to their borders: where the surface beyond explains all of the turn
/// there, or nearly, as a fillet does, so that nothing of it is left to the plane. Beside a facet
/// of a smooth surface that explains half. Ascending; at most one between two sharp edges at a
/// vertex. `is_sharp`: one per edge of the topology, boundary edges included.
[[nodiscard]] std::vector<KeptPlane> find_kept_planes(const PolygonMesh& mesh,
                                                      const MeshTopology& topology,
                                                      std::span<const char> is_sharp,
                                                      const FeatureRules& rules = {});

}  // namespace planish
