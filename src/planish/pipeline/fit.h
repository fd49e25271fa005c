#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_topology.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/primal/scheme.h"
#include "planish/solve/backend.h"
#include "planish/solve/progressive.h"
#include "planish/surface/doo_sabin_surface.h"
#include "planish/surface/evaluate.h"
#include "planish/surface/quality_sum.h"

namespace planish {

struct FitOptions {
  /// Fair surfaces fold beside corners that turn inward: take with_convex_faces() of such meshes.
  InterpolationMethod method = InterpolationMethod::Progressive;
  Scheme scheme = Scheme::DooSabin;
  Weights weights = Weights::DooSabin;  ///< of Doo-Sabin
  Solver solver = Solver::Chebyshev;    ///< of the progressive method, as max_iterations
  double tolerance = 1e-6;  ///< of the maximum error, relative to the bounding-box diagonal
  std::int32_t max_iterations = 200;
  std::int32_t polish_steps = 8;  ///< of the fair method, see FairOptions
  /// Of the fair method: those of another frame of an animation, usually the rest pose's, so that
  /// nothing pops.
  const FairDecisions* fair_decisions = nullptr;
  const FairDecisions* sharp_fair_decisions = nullptr;  ///< FairFit::sharp_decisions, likewise
  bool cures_folds = true;                              ///< of the fair method, see FairOptions
  bool obeys_semi_sharp = true;  ///< of the fair method, see fair/semi_sharp.h; else smooth
  /// Of the fair method without `fair_decisions`: planes are kept, see find_kept_planes().
  bool keeps_planes = false;
  /// Of the diagonal: a surface that bends less and passes every given vertex at no more than this
  /// (see fit_steps.h); 0: through them. Empty: kNoiseBound of the noise that is measured. What is
  /// not above the tolerance is 0.
  std::optional<double> within = 0.0;
  SharpFeatureOptions sharp;
  /// Where given, what prepare_mesh() made of the mesh: it is not tested and searched again.
  std::shared_ptr<const PreparedMesh> prepared;
  Callbacks callbacks;
};

/// Wall-clock milliseconds of the parts of fit(): tests of the mesh with its connectivity, sharp
/// features (and OpenSubdiv's refiner for the schemes that take it), limit stencils, their way to
/// the device, and the solve.
struct FitTiming {
  double check = 0, topology = 0, stencils = 0, upload = 0, solve = 0;
};

/// What the fair method makes.
struct FairFit : FairFigures {
  LevelOne level_one;
  FairDecisions decisions;
  /// With FitOptions::obeys_semi_sharp, of a mesh with such tags: those of the net in which they
  /// are sharp.
  std::optional<FairDecisions> sharp_decisions;
};

/// How far a surface leaves the given vertices where it may, the tolerance included.
struct WithinFit : LeaveWithin {
  ErrorNorms distance;        ///< of the points that the surface passes through from the given
  std::int64_t at_bound = 0;  ///< vertices that are as far off as was allowed
  double bending_before = 0, bending_after = 0;  ///< of the polygon mesh, see BendingTable
  /// At level 1, of the surface through the given vertices and of this one, which bends no more and
  /// is folded no more. Over ranks they are not measured.
  std::optional<SurfaceQuality> exact, left;
};

/// The control points of a surface that passes through the given vertices.
struct Fit {
  /// The input with its positions replaced by control points. With the fair method, which moves
  /// none of them, without vertices and faces; see control_cage().
  PolygonMesh cage;
  std::optional<FairFit> fair;  ///< with that method
  /// Where FitOptions::within is above 0; errors of `interpolation` are then from the points that
  /// the surface passes through in place of the given vertices.
  std::optional<WithinFit> within;
  /// Those points, one per vertex of the mesh; empty: the given vertices, also where no surface
  /// that leaves them bends less.
  std::vector<glm::dvec3> points;
  Interpolation interpolation;
  Placement placement;                           ///< of the input
  std::shared_ptr<const PreparedMesh> prepared;  ///< of the input
  /// What is sharp in the input without its unused vertices, whatever pose is evaluated later.
  std::shared_ptr<const SharpFeatures> features;
  /// Lower bound of B's spectrum that the iteration took. For Catmull-Clark and Loop it may be an
  /// estimate, raised to a small positive number where that lies at or below 0.
  double spectral_bound = 0;
  std::int64_t stencil_entries = 0;
  std::int32_t sharp_edge_count = 0;  ///< boundary edges included
  std::int32_t boundary_edge_count = 0;
  std::int32_t corner_count = 0;
  FitTiming timing;
};

/// Finds the control points: check, limit stencils, progressive interpolation; or the fair net.
/// Warns "folds-left" where a fair net still has edges or faces that are turned over, and
/// "concave-faces" where it is of a mesh with such faces (see mend/repair.h). Throws
/// Error{UnusableMesh} (also for Loop on other faces than triangles), Error{InvalidArgument}
/// (conjugate gradients on a mesh that is not closed and smooth; the fair method with another
/// scheme than Doo-Sabin), Error{OutOfMemory}, Error{Cancelled}. Not converging is a result:
/// Catmull-Clark's B can be singular, as on a cube.
[[nodiscard]] Fit fit(const PolygonMesh& mesh, Backend& backend, const FitOptions& options = {});

/// The same of the surface through `points`, one per vertex of the mesh, in place of the given
/// vertices, which stay what sharp features and coordinates are made of. options.within is not
/// looked at.
[[nodiscard]] Fit fit_through(const PolygonMesh& mesh, std::vector<glm::dvec3> points,
                              Backend& backend, const FitOptions& options);

/// The surface of a fitted mesh; the options' scheme, weights and sharp features are those of the
/// fit. Sector angles are measured on `mesh` unless the options name a rest pose. Throws as the
/// other evaluate().
[[nodiscard]] SurfaceMesh evaluate(const PolygonMesh& mesh, const Fit& fit, Backend& backend,
                                   const EvaluateOptions& options = {});

/// The Doo-Sabin surface of a fitted mesh for all levels, which can be had piece by piece (see
/// surface_blocks.h); the options as above. Mesh and fit must outlive it. Throws
/// Error{UnusableMesh}.
[[nodiscard]] std::unique_ptr<const DooSabinSurface> fitted_surface(
    const PolygonMesh& mesh, const Fit& fit, const EvaluateOptions& options = {});

/// Measures the surface of a fitted mesh against the mesh's faces, at any level of 1 or more. Makes
/// of Doo-Sabin surfaces only pieces at a time; the options' level is not looked at. Mesh and fit
/// must outlive it.
class SurfaceMeter {
 public:
  SurfaceMeter(const PolygonMesh& mesh, const Fit& fit, const EvaluateOptions& options);

  /// See surface_quality(). Throws Error{Cancelled}.
  [[nodiscard]] SurfaceQuality at(int level, const Callbacks& callbacks = {}) const;
  /// The same of a Doo-Sabin surface, and of each part.
  [[nodiscard]] PartQuality parts_at(int level, const PartOfFaces& parts,
                                     const Callbacks& callbacks) const;

 private:
  const PolygonMesh& mesh_;
  const Fit& fit_;
  EvaluateOptions options_;
  std::unique_ptr<const DooSabinSurface> surface_;  // of Doo-Sabin
  std::vector<std::uint8_t> is_beside_folds_;
};

/// The cage as it is written to files: fit.cage, or with the fair method level_one_mesh().
[[nodiscard]] PolygonMesh control_cage(const PolygonMesh& mesh, const Fit& fit,
                                       const SharpFeatureOptions& sharp);

}  // namespace planish
