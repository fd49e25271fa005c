#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/mend/repair.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/pipeline/fit.h"
#include "planish/pipeline/fit_mesh.h"
#include "planish/primal/primal_stencils.h"
#include "planish/quads/pair_triangles.h"
#include "planish/solve/backend.h"
#include "planish/solve/stencil_table.h"

namespace planish {

/// What changes a mesh on its way to the fit.
struct Preparation {
  /// Mends what check() reports; and see weld_short_edges() and without_flat_triangles().
  bool repairs = true;
  bool uses_tags = true;                 ///< else edges and vertices lose theirs
  bool finds_features = false;           ///< and tags them: see find_features()
  std::optional<double> crease_degrees;  ///< sharp are edges whose faces turn by more, too
  InterpolationMethod method = InterpolationMethod::Progressive;
  std::optional<double> weld;  ///< see weld_vertices()
  /// Of the mesh that comes out, in place of a search.
  const FoundCreases* found = nullptr;
  bool pairs_triangles = false;                    ///< see with_paired_triangles()
  std::span<const std::uint8_t> may_join{};        ///< where; see PairOptions
  bool stands_alone = true;                        ///< see MeshFitOptions
  std::function<void(double)> features_done = {};  ///< told parts of 1, for these take a while
};

/// How triangles are joined for a fit: edges that may be found as creases, which turn by more than
/// `crease_degrees`, stay.
[[nodiscard]] PairOptions pair_options(std::optional<double> crease_degrees,
                                       std::span<const std::uint8_t> may_join = {});

/// The mesh that is fitted: without tags where they are to be ignored, welded where that is asked
/// for, repaired where that is, and then with mirrored charts cut, with its triangles paired, with
/// creases detected where an angle is given, and for fair surfaces, which fold beside corners that
/// turn inward and around tips of slits, with concave faces cut and such tips made corners where
/// repair may. A mesh that remains unusable comes back as it is, for require_usable() to refuse.
/// Throws what repair() throws, and then leaves `mesh` as it is, or welded.
[[nodiscard]] ReadyMesh make_ready(PolygonMesh&& mesh, const Preparation& choice);

/// What that does where triangles are paired, of a mesh that is ready otherwise and has no found
/// creases. False, and nothing is done, where none are.
bool pair_up(ReadyMesh& ready, std::optional<double> crease_degrees,
             std::span<const std::uint8_t> may_join = {});

/// What that does for fair surfaces alone, of a mesh that is ready otherwise and has no found
/// creases.
void make_fair(ReadyMesh& ready);

/// "use", "ignore", "auto" or "auto:40": what is sharp besides boundaries, as flags and reports say
/// it.
[[nodiscard]] std::string creases_text(bool uses_tags, bool finds_features,
                                       std::optional<double> crease_degrees);

/// Every warning once, to the caller and into the list. Both must outlive it.
class WarningList {
 public:
  WarningList(std::vector<Warning>& list, const Callbacks& caller) : list_(list), caller_(caller) {}
  void add(const Warning& warning) const;

 private:
  std::vector<Warning>& list_;
  const Callbacks& caller_;
};

/// What make_ready() is to do of a mesh with these options. `may_join` must outlive it.
[[nodiscard]] Preparation preparation_of(const MeshFitOptions& options, InterpolationMethod method,
                                         std::span<const std::uint8_t> may_join = {});

/// Says what was changed on the way, once.
void tell_changes(ReadyMesh& ready, std::string_view name, const WarningList& warnings);

/// Fits a mesh that is ready: as its options say, and where these leave the method, joined
/// triangles or added vertices open, by each way that may be the best, of which the one with the
/// least cost is taken (see choice.h). Through given vertices: FitOptions::within is 0. Throws as
/// fit().
[[nodiscard]] FittedMesh choose_fit(ReadyFit ready, Backend& backend);

/// Measures what surfaces of one mesh are weighed by.
class CandidateMeter {
 public:
  /// `given`: the mesh with the faces that it has, `parts` its parts, which must outlive this.
  /// `looks`: see ReadyFit.
  CandidateMeter(const MeshParts& parts, const PolygonMesh& given, std::span<const Halves> looks);

  /// `faces`: of each part, or those that were wanted of all. Level 1 is measured once.
  void measure(Candidate& candidate, const std::vector<CandidateFaces>& faces, FittedMesh& fitted,
               const Callbacks& callbacks = {}) const;

  /// Whether level 1 neither misses the tolerance nor folds.
  [[nodiscard]] bool is_sound(FittedMesh& fitted, const Callbacks& callbacks) const;
  /// Whether no other surface can be much nearer to the shape.
  [[nodiscard]] bool is_close(FittedMesh& fitted, const Callbacks& callbacks) const;

 private:
  void measure_level_one(FittedMesh& fitted, const Callbacks& callbacks) const;
  [[nodiscard]] std::vector<std::int32_t> parts_of(const FittedMesh& fitted) const;
  [[nodiscard]] std::vector<CandidateFaces> faces_of_parts(const FittedMesh& fitted,
                                                           std::span<const std::int32_t> of_face,
                                                           CandidateFaces wanted) const;
  [[nodiscard]] std::vector<std::int64_t> counted(std::span<const std::int32_t> of_face) const;

  const MeshParts& parts_;
  std::vector<std::int64_t> given_counts_;
  std::vector<bool> is_by_lot_;
};

/// Whether anything is left open.
[[nodiscard]] bool is_open(const ReadyFit& ready);

/// Whether vertices may be added: nothing but its surface hangs on the mesh's own, and where nobody
/// named it, nothing but measurement chooses.
[[nodiscard]] bool may_refine(const ReadyFit& ready);

/// Where a surface of control points of level 1 is folded at level 3, beyond the places that the
/// fair construction looks at.
struct DeepFolds {
  std::vector<std::uint8_t> at_vertex;  ///< one per vertex: 1 where its part of a face has folds
  double area = 0;                      ///< of these, a share of the mesh's
};

/// Shares of the area below this are none. Of a single place: at coarser levels it counts for more.
inline constexpr double kNoDeepFolds = 1e-8;

/// Looks at the vertices where there may be any: those with sharp edges, those whose faces turn by
/// more than about 25 degrees from their normal and, where there are folds, those around. Faces at
/// folded edges (mesh/mesh_parts.h) do not count. One look is for all control points of a mesh;
/// what it needs of the mesh is made when there is something to look at.
class DeepLook {
 public:
  /// `mesh`: without unused vertices; topology and features are its; all outlive this. The weights
  /// are those of the fit. `halo`: where the mesh is a part; the area is a share of the whole then.
  DeepLook(const PolygonMesh& mesh, const MeshTopology& topology, const SharpFeatures& features,
           Weights weights, FairHalo* halo = nullptr);
  ~DeepLook();

  /// `level_one` in any coordinates. Empty where no vertex is to be looked at.
  [[nodiscard]] DeepFolds at(const LevelOne& level_one, const Callbacks& callbacks = {});

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

struct DeepCure {
  /// Takes decisions or makes its own.
  std::function<FairNet(const FairDecisions* decisions)> make_net;
  std::function<DeepFolds(FairNet& net)> folds_of;
  /// choose_ellipses() of fair/fold_cure.h.
  std::function<std::vector<std::uint8_t>(std::span<const std::uint8_t> flagged,
                                          FairDecisions& decisions)>
      choose_ellipses;
  FairHalo* halo = nullptr;  ///< where the mesh is a part: all parts take the same way
};

/// Folds between the places that the construction looks at shrink with the polygons around: those
/// of the vertices beside them are cured once more, in a net of the same decisions otherwise; where
/// that leaves folds all over again, with ellipses that cross the edges. Not every round helps: the
/// best net counts.
[[nodiscard]] FairNet deeply_cured_net(const DeepCure& cure);

/// Builds the fair net of a mesh without unused vertices and measures, in double from its limit
/// points, how far it is from `given` (unit coordinates): result.fair and result.interpolation,
/// which has no iterations. `subdivision` has Weights::DooSabin. Throws and warns as fit().
void solve_fair(Fit& result, const PolygonMesh& mesh, const Subdivision& subdivision,
                std::span<const glm::dvec3> given, Backend& backend, const FitOptions& options);

/// What fit() warns of such counts.
[[nodiscard]] Warning folds_left_warning(std::int64_t edges, std::int64_t faces);
[[nodiscard]] Warning concave_faces_warning(std::int64_t faces, std::int64_t crossing = 0);

/// The linear system of the interpolation, B P = V0, and what is known of it.
struct LimitSystem {
  SummedTable masks;          ///< B
  double spectral_bound = 0;  ///< above 0 and below 1; what the Chebyshev semi-iteration takes
  /// Estimate of B's smallest eigenvalue; at or near 0 B is singular, below it no iteration
  /// converges.
  double smallest_eigenvalue = 0;
  std::vector<double> row_weights;  ///< for conjugate gradients; empty for the other solvers
};

// Both throw as fit().

[[nodiscard]] LimitSystem doo_sabin_system(const PolygonMesh& mesh, const Subdivision& subdivision,
                                           const FitOptions& options);

/// The split must have a level 1.
[[nodiscard]] LimitSystem primal_system(const PrimalSplit& split, const FitOptions& options);

/// Moves the fair net that solve_fair() made towards the one in which what is semi-sharp is sharp,
/// and measures its error again. `features`: of the latter.
void solve_semi_sharp(Fit& result, const PolygonMesh& mesh, const Subdivision& smooth,
                      const SharpFeatures& features, std::span<const glm::dvec3> given,
                      Backend& backend, const FitOptions& options);

/// Moves the points that a surface is to pass through, one per vertex in unit coordinates, to where
/// the mesh bends least, as far as options.within lets them; none where that is 0. Nothing is said
/// of the surface: for ranks, which do not measure it. Each calls it for its part: the same bits
/// but for sums over blocks. Throws Error{InvalidArgument}.
[[nodiscard]] std::optional<WithinFit> bend_least(
    const MeshTopology& topology, const SharpFeatures& features, const Placement& placement,
    const FitOptions& options, std::span<glm::dvec3> points, FairHalo* halo = nullptr);

/// Makes of the surface through the given vertices one that leaves them by no more than
/// options.within and bends less, folded no more, as a report measures both; it stays where there
/// is none. Of those through the points where the mesh bends least within the bound, half of it,
/// and so on, the one that bends least. Warnings are those of the surfaces that are tried and
/// taken. Throws as fit().
void leave_vertices(const PolygonMesh& mesh, Backend& backend, const FitOptions& options,
                    Fit& result);

}  // namespace planish
