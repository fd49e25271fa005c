#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "planish/fair/fair_net.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// The faces of a surface that may be taken: those of the mesh, triangles joined to quads, or more
/// triangles, with vertices added between uneven ones; mixed: of each part of the mesh its own.
enum class CandidateFaces : std::uint8_t { Given, Quads, Refined, Mixed };

/// What a cost is the sum of; see ChoiceWeights.
struct CostTerms {
  double missed = 0, bending = 0, folds = 0, doubt = 0, by_lot = 0;

  [[nodiscard]] double sum() const { return missed + bending + folds + doubt + by_lot; }
  CostTerms& operator+=(const CostTerms& other) {
    missed += other.missed;
    bending += other.bending;
    folds += other.folds;
    doubt += other.doubt;
    by_lot += other.by_lot;
    return *this;
  }
};

/// What a surface is like over a part of the mesh that shares no vertex with others, and what it is
/// taken by: of level 2, and of level 1 where the mesh is dense or added vertices make it as fine.
/// See SurfaceQuality: what the input does not fold, of the part's area, and the integral of both
/// squared curvatures.
struct PartFigures {
  CandidateFaces faces = CandidateFaces::Given;
  bool is_by_lot = false;  ///< quads of what does not look like halves of some
  double folded_area = 0, bending = 0;
  double doubt = 0;  ///< mean of the added vertices'

  [[nodiscard]] CostTerms terms() const;
  /// What is least for the surface that is taken.
  [[nodiscard]] double cost() const { return terms().sum(); }
};

/// A surface through the vertices of a mesh that may be taken.
struct Candidate {
  CandidateFaces faces = CandidateFaces::Given;
  InterpolationMethod method = InterpolationMethod::Progressive;
  std::string alone{};  ///< why the other method was not tried, where it was not
  bool converged = false;
  std::vector<PartFigures> parts{};     ///< empty: it needed no measure, for it had no rival
  double folded_area = 0, bending = 0;  ///< of all of it

  [[nodiscard]] bool is_measured() const { return !parts.empty(); }
  [[nodiscard]] bool folds() const;
  /// The sum of its parts', and what a missed tolerance weighs.
  [[nodiscard]] double cost() const;
  [[nodiscard]] CostTerms terms() const;
};

/// Folds of less of the area are none.
inline constexpr double kSoundFoldedArea = 1e-5;

/// The one table of what surfaces are chosen by. A cost is the logarithm of the bending, so that
/// 0.1 more is a tenth more of it, and what follows.
struct ChoiceWeights {
  double missed = 100;       ///< the tolerance
  double folds = 1e4;        ///< times the folded area
  double by_lot = 0.1;       ///< joined triangles that do not look like halves of quads
  double doubt = 3;          ///< times the mean one about where vertices were added
  double flat = 1e-6;        ///< of bending: rounding, beside a sphere's 8 pi
  double alike = 1e-3;       ///< costs that differ by less: the first that was made is taken
  double close_degrees = 1;  ///< normals nearer to the faces' (rms, level 1) need no rival
};
inline constexpr ChoiceWeights kChoiceWeights{};

/// Why a surface was taken.
struct Choice {
  std::vector<Candidate> candidates;  ///< in the order that they were made
  std::size_t taken = 0;
  /// In a line each, for people: why this method, and why these faces; empty: nothing was chosen.
  std::string reason, faces_reason;

  [[nodiscard]] const Candidate& best() const { return candidates[taken]; }
  [[nodiscard]] bool has_other_faces() const {
    return !candidates.empty() && best().faces != CandidateFaces::Given;
  }
  /// Null where it was not made.
  [[nodiscard]] const Candidate* of(CandidateFaces faces, InterpolationMethod method) const;
};

/// Adds a candidate, and takes it where its cost is less than that of the one that was taken, by
/// more than `alike`. True: it was.
bool enter(Choice& choice, const Candidate& candidate);

/// Of each part the faces of the least cost.
[[nodiscard]] std::vector<CandidateFaces> best_faces(const Choice& choice);

/// What the candidates say of why the one is taken; reasons that stand there already stay.
void explain(Choice& choice, std::int64_t added_vertices);

/// What decides; see pipeline/README.md.
inline constexpr double kHalvedShare = 0.8;  ///< of the vertices that are looked at
/// The same, of as many at least, where they are plainly halves: no mesh is known whose surface was
/// better without joining them then.
inline constexpr double kPlainShare = 0.9;
inline constexpr std::int64_t kPlainCount = 50;
/// So many are enough where all of them are: of triangles of which four fifths look so, 20 do once
/// in 87 times.
inline constexpr std::int64_t kPlainAll = 20;
/// What triangles look like: halves of quads, as those of cut grids do and those of scans do not.
enum class Halves { No, Maybe, Plain };

/// Whether a fit of quads is worth its time (Maybe), and one of triangles is not unless that of
/// quads folds (Plain), of a sound mesh of which most faces are triangles, else neither (No). Looks
/// at some hundreds of vertices: pairs of triangles that both would take the other first have to
/// leave four faces around kHalvedShare of those where the mesh is neither flat nor sharp,
/// kPlainShare or all of kPlainAll for Plain. Where it is flat or sharp nearly everywhere, as parts
/// are, nothing can be said: Maybe.
[[nodiscard]] Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                 std::optional<double> crease_degrees);

/// The same of each part of a mesh, in the order of mesh_parts().
[[nodiscard]] std::vector<Halves> look_halved_by_parts(const PolygonMesh& mesh,
                                                       const PreparedMesh& prepared,
                                                       std::optional<double> crease_degrees);

}  // namespace planish
