#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planish/analytic/analytic_surface.h"
#include "planish/brep/brep.h"
#include "planish/brep/free_borders.h"
#include "planish/brep/moved_faces.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Thrown where a part cannot have faces on surfaces: says why, and which region is in the way; -1:
/// all of them.
struct NotAnalytic {
  std::string reason;
  std::int32_t region = -1;
};

/// The freeform faces of a part that has others on surfaces, which are moved to end on these. In
/// unit coordinates.
class FreeformSide {
 public:
  /// `faces`: those of freeform.brep that the part has, which become `first` and those behind it of
  /// `part`. All must outlive it.
  FreeformSide(const FreeformFaces& freeform, const Placement& placement,
               std::span<const std::int32_t> faces, std::int32_t first, Brep& part);

  /// A vertex on a chain, at the parameters that its edges have had before.
  struct Split {
    double place = 0;
    std::int32_t vertex = 0;
  };
  /// Takes a chain beside a surface, between two vertices of the part; both -1: it is closed.
  /// Returns its other vertices, of a closed chain all. Throws NotAnalytic where faces do not end
  /// along it.
  std::vector<Split> add_chain(std::int32_t chain, const AnalyticSurface& surface,
                               std::int32_t from, std::int32_t to);
  /// Moves edges along all chains onto their surfaces. Throws NotAnalytic where that is no curve.
  void move_borders();
  /// On a chain, once borders have moved, at places from 0 to length().
  [[nodiscard]] glm::dvec3 point(std::int32_t chain, double place) const;
  [[nodiscard]] double length(std::int32_t chain) const { return chains_.at(chain).places.back(); }
  /// Adds the edge between two of its vertices, with a face of the part on its left. Returns it.
  std::int32_t add_edge(std::int32_t chain, const Split& from, const Split& to, std::int32_t face);
  /// Adds the faces, with what edges they have off chains.
  void add_faces();

 private:
  struct Chain {
    std::vector<FreeSpan> spans;
    std::vector<double> places;  // where each begins, and the end
  };
  // What an edge becomes.
  struct MovedEdge {
    struct Mark {
      double at = 0;
      std::int32_t vertex = 0;
    };
    struct Beside {
      double low = 0, high = 0;
      const AnalyticSurface* surface = nullptr;
    };
    struct Piece {
      double low = 0;
      Brep::Use use;  // along the edge
    };
    std::vector<Mark> marks;
    std::vector<Beside> beside;
    QuadraticCurve curve;
    std::vector<Piece> pieces;

    [[nodiscard]] const AnalyticSurface* surface_at(double t) const;
  };
  struct SpanPlace {
    const FreeSpan& span;
    double parameter = 0;
  };
  // A place where two spans meet is on the first or the second.
  [[nodiscard]] SpanPlace span_at(std::int32_t chain, double place, bool is_second) const;
  [[nodiscard]] glm::dvec3 given_point(std::int32_t edge, double t) const;
  // The vertex of the freeform faces at an end of an edge.
  [[nodiscard]] std::optional<std::int32_t> end_of(std::int32_t edge, double t) const;
  std::int32_t vertex_at(std::int32_t edge, double t, const AnalyticSurface& surface);
  std::int32_t vertex_of(std::int32_t vertex);
  [[nodiscard]] glm::dvec3 shift_of(std::int32_t vertex) const;
  [[nodiscard]] bool stays(std::int32_t edge) const;
  std::int32_t add_vertex(const glm::dvec3& point);
  void add_inner_edges();
  void add_face(std::int32_t index);

  const FreeformFaces& freeform_;
  const Placement& placement_;
  std::span<const std::int32_t> faces_;
  Brep& part_;
  std::map<std::int32_t, std::int32_t> number_;  // of faces in the part
  std::map<std::int32_t, Chain> chains_;
  std::map<std::int32_t, MovedEdge> edges_;         // by edge of the freeform faces
  std::map<std::int32_t, std::int32_t> vertex_of_;  // by vertex of these
};

}  // namespace planish
