#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "planish/adaptive/adaptive_tessellation.h"
#include "planish/core/callbacks.h"
#include "planish/features/find_features.h"
#include "planish/mend/repair.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/mesh/statistics.h"
#include "planish/pipeline/choice.h"
#include "planish/pipeline/fit.h"
#include "planish/quads/pair_triangles.h"
#include "planish/refine/refine_mesh.h"
#include "planish/solve/backend.h"
#include "planish/surface/quality_sum.h"

namespace planish {

/// What was found to be sharp of a mesh, its own tags aside: edges by their vertices, the smaller
/// first, and corners; both ascending.
struct FoundCreases {
  std::vector<std::array<std::int32_t, 2>> edges;
  std::vector<std::int32_t> corners;

  [[nodiscard]] bool is_empty() const { return edges.empty() && corners.empty(); }
};

/// Tags it. Throws Error{UnusableMesh} for what is no vertex of the mesh.
void add_tags(PolygonMesh& mesh, const FoundCreases& found);

/// Tags what find_features() finds. `prepared` is the mesh's, and stays so.
[[nodiscard]] FoundCreases add_features(PolygonMesh& mesh,
                                        const std::shared_ptr<const PreparedMesh>& prepared,
                                        const FeatureRules& rules = {},
                                        const std::function<void(double)>& done = {});

/// Takes back what was found at one of these vertices, of the tags and of `found`.
void leave_smooth(PolygonMesh& mesh, FoundCreases& found, std::span<const std::int32_t> vertices);

/// The share of the area that may fold before all found creases are taken back, part of it before
/// as large a part of them is, but for a few: an edge that is rounded is seen from far, a fold of
/// so little is not.
inline constexpr double kWorthAllCreases = 3e-3;

/// A fair surface whose creases only help.
struct CreasedFit {
  Fit fit;
  FoundCreases found;  ///< what was not taken back
};

/// Fits by the fair method a mesh whose creases were found. Where the surface is folded at level 3
/// (see DeepLook), found creases around are taken back, four rounds at most; where folds
/// remain, all of them; each time if the folds, by the worst of levels 1 to 3, are worth it (see
/// kWorthAllCreases). `mesh` has the tags of what is given out then. A mesh that does not fold
/// costs a look at its folds. options.prepared is the mesh's, or null. Warnings are those of the
/// fit that is given out; throws as fit().
[[nodiscard]] CreasedFit fit_with_found_creases(PolygonMesh& mesh, const FoundCreases& found,
                                                Backend& backend, const FitOptions& options);

struct MeshFitOptions {
  /// Empty: of Doo-Sabin the better one by measurement (see fit_steps.h), else progressive.
  std::optional<InterpolationMethod> method;
  /// See repair(), weld_short_edges() and without_flat_triangles(); and cuts concave faces for fair
  /// surfaces.
  bool repairs = true;
  /// Nothing else is kept by the mesh's vertices and texture coordinates: where it is, none is
  /// welded or added.
  bool stands_alone = true;
  /// Else faces were made of points, and nobody is told of what is odd about them: see
  /// fit_report.h.
  bool faces_are_given = true;
  std::optional<double> crease_degrees;  ///< edges whose faces turn by more are sharp, too
  bool finds_features = false;           ///< sharp is what find_features() finds, too
  /// The same where the method and crease_degrees are empty and the mesh has no tags.
  bool chooses_creases = true;
  /// Of Doo-Sabin alone auto joins anything, and where the surface is better (see fit_steps.h).
  QuadChoice quads = QuadChoice::Auto;
  /// Adds vertices (see refine_mesh()) to meshes of triangles that stand alone, of the fair method
  /// with FitOptions::within 0; auto: where the method is chosen, too, and the surface bends less.
  RefineChoice refine = RefineChoice::Auto;
  std::optional<double> weld;  ///< vertices within this fraction of the diagonal
  FitOptions fit;              ///< its method and prepared are not looked at
};

/// What a fit says of itself: a FittedMesh without the arrays of its mesh.
struct FitFigures {
  InterpolationMethod method = InterpolationMethod::Progressive;
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;
  Solver solver = Solver::Chebyshev;
  BoundaryRule boundary = BoundaryRule::Edge;
  std::int32_t polish_steps = 0;
  double tolerance = 0;
  std::string creases;  ///< as MeshToFit::creases() has them
  bool repairs = true;
  std::optional<double> weld;
  std::optional<Choice> choice;
  MeshDensity density;
  std::int64_t found_edges = 0;  ///< that are kept sharp
  std::int64_t rounded_edges = 0, separated_edges = 0;
  std::int64_t joined = 0;  ///< pairs of triangles, to quads
  std::int64_t added = 0;   ///< vertices, between those of uneven triangles
  std::int64_t welded = 0;  ///< vertices that became another
  std::int64_t sharp_edges = 0, corners = 0;
  std::vector<std::int32_t> changed_faces;  ///< the given mesh's that repair changed
  std::optional<WithinFit> within;
  std::optional<FairFigures> fair;
  Interpolation interpolation;  ///< without its displacement
  double spectral_bound = 0;
};

/// A mesh that anybody made, repaired and tagged, and what was found of it. The lists of source
/// vertices and faces are empty where they are the same.
struct ReadyMesh : RepairedMesh {
  std::int64_t welded_count = 0;  ///< vertices that became another
  std::int64_t paired_count = 0;  ///< triangles that became quads, each a diagonal less
  FoundCreases found;             ///< of `mesh`, and tagged
  /// The last vertices of `mesh`, those that refine_mesh() added; of these source_vertices has -1.
  std::vector<AddedVertex> added_vertices;
  /// Places, faces, tags and groups before triangles were joined and vertices added; null where
  /// neither was.
  std::shared_ptr<const PolygonMesh> bare;
  std::shared_ptr<const PreparedMesh> prepared;  ///< null where it cannot be used
};

/// Keeps what the mesh is now, unless an earlier one is kept.
void keep_bare(ReadyMesh& ready);

/// With the rules that it is to be fitted by.
struct MeshToFit : ReadyMesh {
  FitOptions options;  ///< without `prepared`
  bool repairs = true, uses_tags = true;
  bool finds_features = false;
  std::optional<double> crease_degrees, weld;
  bool split_normals = false;     ///< see FitFileOptions
  bool pairs_triangles = false;   ///< whether they were joined: with it the cage can be verified
  MeshDensity density;            ///< before triangles are joined by measurement
  std::vector<Warning> warnings;  ///< of repair and of the fit

  /// What is sharp, as the command's --creases has it.
  [[nodiscard]] std::string creases() const;
};

/// And fitted: `mesh` is what was. What was found sharp and taken back is not among `found`.
struct FittedMesh : MeshToFit {
  Fit fit;
  std::optional<Choice> choice;  ///< where something was left open
  /// Of the surface at level 1, where it was measured to choose it.
  std::optional<SurfaceQuality> level_one_quality;
  std::vector<PartSums> level_one_parts;  ///< the same of each part of the mesh
  double choose_milliseconds = 0;         ///< what measuring and a fit that was not taken cost
  std::int64_t rounded_count = 0;         ///< edges that were, for they fold a fair surface
  /// Of a mesh whose vertices have moved since (edit/editor.h): where they were, for its rules stay
  /// those of that pose. Empty: `mesh`'s own.
  std::vector<glm::dvec3> rest_positions;

  /// How to evaluate the surface of `fit`; this must outlive it.
  [[nodiscard]] EvaluateOptions evaluate_options(int level = 2) const;
  /// The points that the surface passes through, one per vertex of `mesh`: its own, but where
  /// FitOptions::within moved them.
  [[nodiscard]] std::span<const glm::dvec3> points() const {
    return fit.points.empty() ? std::span<const glm::dvec3>(mesh.positions) : fit.points;
  }
  /// At level 1, where measurement chose it or how far it leaves the vertices; else null.
  [[nodiscard]] const SurfaceQuality* chosen_quality() const;
  [[nodiscard]] FitFigures figures() const;
};

/// A mesh that can be fitted, and what may be chosen.
struct ReadyFit {
  MeshToFit input;  ///< the method may change where measurement chooses it
  std::string name;
  MeshFitOptions options;
  bool chooses_method = false;       ///< by measurement
  std::string reason;                ///< of a method that is not, and was not named: Choice::reason
  std::optional<PolygonMesh> given;  ///< as it was, where that needs it
  /// The same with triangles joined, where these may be better, or plainly are.
  std::shared_ptr<ReadyFit> paired;
  bool is_plainly_halved = false;
  std::vector<Halves> looks;  ///< of each part, where triangles may be joined
  /// Which faces may be joined, where these are; empty: all.
  std::vector<std::uint8_t> may_join;
  /// The same with added vertices, which prepare_refined() makes: for who wants to know beforehand
  /// what may come; fit_prepared() makes them of the mesh with all that it finds.
  std::shared_ptr<ReadyFit> refined;
};

/// Sets ReadyFit::refined where vertices may be added and are.
void prepare_refined(ReadyFit& ready);

/// The first half of fit_mesh(): welds, repairs and tags. Throws Error{UnusableMesh} with every
/// problem and its remedy, and as repair(). Callbacks must outlive what is returned.
[[nodiscard]] ReadyFit prepare_fit(PolygonMesh mesh, std::string_view name,
                                   const MeshFitOptions& options = {});

/// What a control cage is of, whatever is chosen for the surface: the mesh's own faces with what is
/// sharp in it, by the method that is named, else the progressive one.
[[nodiscard]] ReadyFit cage_fit(const ReadyFit& ready);
/// Whether a surface is that of cage_fit(), too.
[[nodiscard]] bool has_own_cage(const FittedMesh& fitted);

/// The second half: the choice of the method, and fit(). Throws as that.
[[nodiscard]] FittedMesh fit_prepared(ReadyFit ready, Backend& backend);

/// All that happens between reading a mesh and evaluating its surface: repair, creases, the
/// choice of the method, fit(). `name` stands in messages. Warnings go to the callbacks, too.
[[nodiscard]] FittedMesh fit_mesh(PolygonMesh mesh, std::string_view name, Backend& backend,
                                  const MeshFitOptions& options = {});

/// What the command solves in on the CPU: double for tolerances that float does not reach.
[[nodiscard]] Precision precision_for(double tolerance);

/// What a glTF file says of how its surface was made: for GltfOptions::extras.
using FileExtras =
    std::vector<std::pair<std::string, std::variant<bool, std::int64_t, double, std::string>>>;
[[nodiscard]] FileExtras fit_extras(const FitOptions& options, std::string creases,
                                    const Interpolation& result);

/// The point that vertices of a glTF are best stored about: 0, or the centre of a model so far from
/// it that float32 would lose digits.
[[nodiscard]] glm::dvec3 storage_origin(const Placement& placement);

/// Triangles of a fit's Doo-Sabin surface as fine as it is curved, in one call: tessellate() of
/// fitted_surface(). Of the options `diagonal` is not looked at: errors are parts of the fit's.
/// Throws as both.
[[nodiscard]] SurfaceMesh tessellate(const PolygonMesh& mesh, const Fit& fit,
                                     AdaptiveOptions options, const EvaluateOptions& evaluate = {});

/// The same of a mesh that fit_mesh() fitted. Throws Error{InvalidArgument} for another scheme than
/// Doo-Sabin, too.
[[nodiscard]] SurfaceMesh tessellate(const FittedMesh& fitted, const AdaptiveOptions& options);

}  // namespace planish
