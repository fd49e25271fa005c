#include "planish/pipeline/choice.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/portable_math.h"
#include "planish/core/words.h"
#include "planish/measure/figures.h"
#include "planish/mesh/mesh_parts.h"
#include "planish/pipeline/fit_steps.h"
#include "planish/pipeline/option_table.h"
#include "planish/quads/pair_triangles.h"

namespace planish {
namespace {

// How a surface is better than another, which `name` names.
std::string advantage(const Candidate& taken, const Candidate& other, const std::string& name) {
  if (!other.converged && taken.converged) return name + " misses the tolerance";
  if (other.folds() && other.folded_area > taken.folded_area) {
    const std::string folds =
        formatted("{} folds {} of the area", name, percent(other.folded_area));
    return taken.folds() ? formatted("{}, this {}", folds, percent(taken.folded_area)) : folds;
  }
  if (taken.bending <= kChoiceWeights.flat) return "all is flat";
  if (std::abs(other.cost() - taken.cost()) < kChoiceWeights.alike) return name + " bends as much";
  if (other.bending > taken.bending)
    return formatted("it bends {} less than {}", percent(1 - taken.bending / other.bending), name);
  return name + " bends hardly less";
}

// The best of those for which that holds; null: there is none.
template <class Holds>
const Candidate* best_where(const Choice& choice, const Holds& holds) {
  const Candidate* best = nullptr;
  for (const Candidate& candidate : choice.candidates)
    if (holds(candidate) && (best == nullptr || candidate.cost() < best->cost())) best = &candidate;
  return best;
}

std::string faces_name(CandidateFaces faces) {
  switch (faces) {
    case CandidateFaces::Quads:
      return "that of quads";
    case CandidateFaces::Refined:
      return "that with added vertices";
    case CandidateFaces::Mixed:
      return "that of each part's own faces";
    case CandidateFaces::Given:
      break;
  }
  return "that of the triangles";
}

}  // namespace

CostTerms PartFigures::terms() const {
  const ChoiceWeights& weights = kChoiceWeights;
  return {.bending = portable::log(bending + weights.flat),
          .folds = folded_area >= kSoundFoldedArea ? weights.folds * folded_area : 0,
          .doubt = weights.doubt * doubt,
          .by_lot = is_by_lot ? weights.by_lot : 0};
}

bool Candidate::folds() const { return folded_area >= kSoundFoldedArea; }

double Candidate::cost() const {
  double cost = converged ? 0 : kChoiceWeights.missed;
  for (const PartFigures& part : parts) cost += part.cost();
  return cost;
}

CostTerms Candidate::terms() const {
  CostTerms all{.missed = converged ? 0 : kChoiceWeights.missed};
  for (const PartFigures& part : parts) all += part.terms();
  return all;
}

const Candidate* Choice::of(CandidateFaces faces, InterpolationMethod method) const {
  const auto found = std::ranges::find_if(candidates, [&](const Candidate& candidate) {
    return candidate.faces == faces && candidate.method == method;
  });
  return found == candidates.end() ? nullptr : &*found;
}

bool enter(Choice& choice, const Candidate& candidate) {
  const bool is_first = choice.candidates.empty();
  const bool is_better = is_first || candidate.cost() < choice.best().cost() - kChoiceWeights.alike;
  choice.candidates.push_back(candidate);
  if (is_better) choice.taken = choice.candidates.size() - 1;
  return is_better;
}

std::vector<CandidateFaces> best_faces(const Choice& choice) {
  std::vector<CandidateFaces> faces;
  for (std::size_t p = 0; p < choice.best().parts.size(); ++p) {
    const PartFigures* best = nullptr;
    for (const Candidate& candidate : choice.candidates) {
      const PartFigures& part = candidate.parts[p];
      if (candidate.converged &&
          (best == nullptr || part.cost() < best->cost() - kChoiceWeights.alike))
        best = &part;
    }
    faces.push_back(best == nullptr ? CandidateFaces::Given : best->faces);
  }
  return faces;
}

void explain(Choice& choice, std::int64_t added_vertices) {
  const Candidate& taken = choice.best();
  const std::string method(word_of(kMethodWords, taken.method));
  if (choice.reason.empty()) {
    // Vertices are added to the fair surface of the given faces.
    const bool is_derived =
        taken.faces == CandidateFaces::Refined || taken.faces == CandidateFaces::Mixed;
    const CandidateFaces faces = is_derived ? CandidateFaces::Given : taken.faces;
    const Candidate* const other = best_where(choice, [&](const Candidate& candidate) {
      return candidate.faces == faces && candidate.method != taken.method;
    });
    choice.reason = taken.alone.empty() ? method : method + ": " + taken.alone;
    if (other != nullptr && taken.alone.empty())
      choice.reason +=
          ": " + advantage(taken, *other, std::string(word_of(kMethodWords, other->method)));
  }
  if (!choice.faces_reason.empty()) return;
  const Candidate* const other = best_where(
      choice, [&](const Candidate& candidate) { return candidate.faces != taken.faces; });
  if (other == nullptr) return;
  const std::string why = advantage(taken, *other, faces_name(other->faces));
  switch (taken.faces) {
    case CandidateFaces::Given:
      choice.faces_reason = "triangles as they are: " + why;
      return;
    case CandidateFaces::Quads:
      choice.faces_reason =
          formatted("triangles joined to quads: {} (--quads off leaves them)", why);
      return;
    case CandidateFaces::Refined:
      choice.faces_reason =
          formatted("{} added between those of uneven triangles: {} (--refine off adds none)",
                    counted(added_vertices, "vertex"), why);
      return;
    case CandidateFaces::Mixed:
      choice.faces_reason = formatted(
          "each part with the faces that suit it: {} (--quads off "
          "--refine off leave them all)",
          why);
      return;
  }
}

namespace {

// Where fewer vertices tell anything, the mesh is one of flat and sharp parts.
constexpr double kFewTell = 0.05;

bool are_mostly_triangles(const PolygonMesh& mesh) {
  std::int64_t count = 0;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) count += mesh.face_size(f) == 3 ? 1 : 0;
  return 2 * count >= mesh.face_count();
}

}  // namespace

Halves look_halved(const PolygonMesh& mesh, const PreparedMesh& prepared,
                   std::optional<double> crease_degrees) {
  if (!are_mostly_triangles(mesh)) return Halves::No;
  const HalvedVertices found = halved_vertices(mesh, prepared, pair_options(crease_degrees));
  const auto tell = static_cast<double>(found.telling);
  if (tell <= kFewTell * static_cast<double>(found.looked_at)) return Halves::Maybe;
  const double share = static_cast<double>(found.regular) / tell;
  if (share >= kPlainShare && found.telling >= kPlainCount) return Halves::Plain;
  if (found.regular == found.telling && found.telling >= kPlainAll) return Halves::Plain;
  return share >= kHalvedShare ? Halves::Maybe : Halves::No;
}

std::vector<Halves> look_halved_by_parts(const PolygonMesh& mesh, const PreparedMesh& prepared,
                                         std::optional<double> crease_degrees) {
  const MeshParts parts = mesh_parts(mesh);
  if (parts.count <= 1) return {look_halved(mesh, prepared, crease_degrees)};
  std::vector<Halves> looks;
  for (const PolygonMesh& part : meshes_of(parts, mesh))
    looks.push_back(look_halved(part, *prepare_mesh(part, "part"), crease_degrees));
  return looks;
}

namespace {

// Degrees by which faces turn at their edges: where it is less, facets of a fine surface through
// the given vertices are no more visible than those that are written.
constexpr double kWorthRefining = 1;
// Of the time: joined triangles, where these may not be all, and where they mostly are.
constexpr double kQuadsEntered = 0.3, kPlainEntered = 0.6;
// And all of one kind of faces, where parts may have different ones.
constexpr double kAllEntered = 0.7;
// Of the time of the surfaces of one mesh, a fit, twice of the fair method, and a measure.
constexpr double kFit = 0.1, kMeasure = 0.05;

// Shares of the time, one after another.
class Shares {
 public:
  explicit Shares(const Callbacks& whole) : whole_(whole) {}
  Callbacks next(double part) {
    const double begin = std::exchange(at_, std::min(at_ + part, 1.0));
    return share_of(whole_, begin, at_);
  }

 private:
  const Callbacks& whole_;
  double at_ = 0;
};

double sum_of(const FitTiming& timing) {
  return timing.check + timing.topology + timing.stencils + timing.upload + timing.solve;
}

double milliseconds_since(std::chrono::steady_clock::time_point began) {
  const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - began;
  return took.count();
}

void leave_found(FittedMesh& fitted, FoundCreases&& left) {
  fitted.rounded_count = std::ssize(fitted.found.edges) - std::ssize(left.edges);
  fitted.found = std::move(left);
}

// By the method that its options name.
FittedMesh fit_one(MeshToFit input, const std::string& name, Backend& backend,
                   const Callbacks& caller) {
  FittedMesh made{std::move(input)};
  const WarningList warnings(made.warnings, caller);
  FitOptions options = made.options;
  options.prepared = made.prepared;
  options.callbacks = caller;
  options.callbacks.warning = [&](const Warning& warning) { warnings.add(warning); };
  try {
    if (!made.found.is_empty() && options.method == InterpolationMethod::Fair) {
      CreasedFit creased = fit_with_found_creases(made.mesh, made.found, backend, options);
      leave_found(made, std::move(creased.found));
      made.fit = std::move(creased.fit);
    } else {
      made.fit = fit(made.mesh, backend, options);
    }
  } catch (const Error& error) {
    // fit() knows no name: say it again with the name.
    if (error.code() != ErrorCode::UnusableMesh) throw;
    throw Error(error.code(), name + ": " + error.what(), error.element());
  }
  made.prepared = made.fit.prepared;
  return made;
}

// Folds beside what is sharp hide between the places of coarser levels. The fair method looks for
// them by itself, see DeepLook; those of a dense mesh are not to be seen.
bool may_hide_folds(const FittedMesh& fitted) {
  return fitted.options.method == InterpolationMethod::Progressive && !fitted.found.edges.empty() &&
         !fitted.density.is_dense();
}

SurfaceMeter meter_of(const FittedMesh& fitted) {
  return {fitted.mesh, fitted.fit, fitted.evaluate_options()};
}

// Of the area.
double share(const PartSums& part) { return part.area > 0 ? part.folded_elsewhere / part.area : 0; }

}  // namespace

CandidateMeter::CandidateMeter(const MeshParts& parts, const PolygonMesh& given,
                               std::span<const Halves> looks)
    : parts_(parts), given_counts_(counted(parts.of_faces(given))) {
  for (const Halves look : looks) is_by_lot_.push_back(look == Halves::No);
  is_by_lot_.resize(given_counts_.size(), false);
}

void CandidateMeter::measure_level_one(FittedMesh& fitted, const Callbacks& callbacks) const {
  if (fitted.level_one_quality && !fitted.level_one_parts.empty()) return;
  PartQuality measured = meter_of(fitted).parts_at(1, {parts_of(fitted), parts_.count}, callbacks);
  fitted.level_one_quality = std::move(measured.whole);
  fitted.level_one_parts = std::move(measured.parts);
}

bool CandidateMeter::is_sound(FittedMesh& fitted, const Callbacks& callbacks) const {
  if (!fitted.fit.interpolation.converged) return false;
  measure_level_one(fitted, callbacks);
  return fitted.level_one_quality->folded_area_elsewhere < kSoundFoldedArea;
}

bool CandidateMeter::is_close(FittedMesh& fitted, const Callbacks& callbacks) const {
  if (!is_sound(fitted, share_of(callbacks, 0, 0.5)) ||
      fitted.level_one_quality->rms_normal_deviation >= kChoiceWeights.close_degrees)
    return false;
  // Level 2 tells needles and hubs that look whole between the places of level 1. Those of a dense
  // mesh are near enough to each other.
  return fitted.density.is_dense() ||
         meter_of(fitted)
                 .at(may_hide_folds(fitted) ? 3 : 2, share_of(callbacks, 0.5, 1))
                 .folded_area_elsewhere < kSoundFoldedArea;
}

void CandidateMeter::measure(Candidate& candidate, const std::vector<CandidateFaces>& faces,
                             FittedMesh& fitted, const Callbacks& callbacks) const {
  const std::vector<std::int32_t> of_face = parts_of(fitted);
  const std::vector<CandidateFaces> own =
      faces.size() > 1 ? faces : faces_of_parts(fitted, of_face, faces.front());
  // With added vertices level 1 is as fine as level 2 is without, and it is fine enough where faces
  // are.
  const auto is_fine = [&](CandidateFaces part) {
    return part == CandidateFaces::Refined || fitted.density.is_dense();
  };
  const PartOfFaces in_parts{of_face, parts_.count};
  std::vector<PartSums> finer, hidden;
  if (std::ranges::any_of(own, is_fine)) measure_level_one(fitted, share_of(callbacks, 0, 0.5));
  if (!std::ranges::all_of(own, is_fine)) {
    const SurfaceMeter meter = meter_of(fitted);
    finer = meter.parts_at(2, in_parts, share_of(callbacks, 0.5, 1)).parts;
    if (may_hide_folds(fitted)) hidden = meter.parts_at(3, in_parts, {}).parts;
  }
  std::vector<double> doubts(own.size(), 0.0), added_counts(own.size(), 0.0);
  for (const AddedVertex& added : fitted.added_vertices) {
    const std::int32_t part = parts_.of_vertex[added.vertices[0]];
    doubts[part] += added.doubt;
    ++added_counts[part];
  }
  PartSums all;
  for (std::size_t p = 0; p < own.size(); ++p) {
    PartSums part = (is_fine(own[p]) ? fitted.level_one_parts : finer)[p];
    if (!hidden.empty())
      part.folded_elsewhere = std::max(part.folded_elsewhere, share(hidden[p]) * part.area);
    candidate.parts.push_back({.faces = own[p],
                               .is_by_lot = own[p] == CandidateFaces::Quads && is_by_lot_[p],
                               .folded_area = share(part),
                               .bending = part.bending,
                               .doubt = doubts[p] / std::max(added_counts[p], 1.0)});
    all.area += part.area;
    all.folded_elsewhere += part.folded_elsewhere;
    all.bending += part.bending;
  }
  candidate.folded_area = share(all);
  candidate.bending = all.bending;
}

// Of each face. Added vertices are of the part whose faces they were put on.
std::vector<std::int32_t> CandidateMeter::parts_of(const FittedMesh& fitted) const {
  std::vector<std::int32_t> of_face(static_cast<std::size_t>(fitted.mesh.face_count()));
  const auto given = fitted.mesh.vertex_count() - std::ssize(fitted.added_vertices);
  for (std::int32_t f = 0; f < fitted.mesh.face_count(); ++f) {
    const std::int32_t v = fitted.mesh.face(f)[0];
    of_face[f] = parts_.of_vertex[v < given ? v : fitted.added_vertices[v - given].vertices[0]];
  }
  return of_face;
}

// A part in which nothing was joined or added has the given faces.
std::vector<CandidateFaces> CandidateMeter::faces_of_parts(const FittedMesh& fitted,
                                                           std::span<const std::int32_t> of_face,
                                                           CandidateFaces wanted) const {
  std::vector<CandidateFaces> own(static_cast<std::size_t>(parts_.count), CandidateFaces::Given);
  if (wanted == CandidateFaces::Quads) {
    const std::vector<std::int64_t> counts = counted(of_face);
    for (std::size_t p = 0; p < own.size(); ++p)
      if (counts[p] < given_counts_[p]) own[p] = wanted;
  }
  for (const AddedVertex& added : fitted.added_vertices)
    own[parts_.of_vertex[added.vertices[0]]] = CandidateFaces::Refined;
  return own;
}

// Faces of each part.
std::vector<std::int64_t> CandidateMeter::counted(std::span<const std::int32_t> of_face) const {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(parts_.count), 0);
  for (const std::int32_t part : of_face) ++counts[part];
  return counts;
}

namespace {

// The surfaces that were made: the best one is kept, of the others what they are like.
class Contest {
 public:
  // Of the parts of a mesh that is ready; they must outlive it.
  Contest(const MeshParts& parts, const ReadyFit& ready)
      : meter_(parts, ready.input.mesh, ready.looks) {}

  // `faces`: of each part, or one for all. `alone`: why no other method was tried.
  void add(FittedMesh&& fitted, const std::vector<CandidateFaces>& faces,
           const Callbacks& callbacks, const std::string& alone = {}) {
    Candidate candidate{.faces = faces.size() > 1 ? CandidateFaces::Mixed : faces.front(),
                        .method = fitted.options.method,
                        .alone = alone,
                        .converged = fitted.fit.interpolation.converged};
    if (!best_) {
      first_ = std::move(candidate);
      best_ = std::move(fitted);
      return;
    }
    if (choice_.candidates.empty()) {
      meter_.measure(first_, {first_.faces}, *best_, share_of(callbacks, 0, 0.5));
      enter(choice_, first_);
    }
    meter_.measure(candidate, faces, fitted, share_of(callbacks, 0.5, 1));
    if (enter(choice_, candidate)) best_ = std::move(fitted);
  }

  [[nodiscard]] const CandidateMeter& meter() const { return meter_; }
  [[nodiscard]] FittedMesh& best() { return *best_; }
  [[nodiscard]] const Choice& choice() const { return choice_; }
  // Why no other faces were tried.
  void note_faces(std::string reason) { choice_.faces_reason = std::move(reason); }

  FittedMesh take() {
    if (choice_.candidates.empty()) enter(choice_, first_);  // it needed no measure
    explain(choice_, std::ssize(best_->added_vertices));
    best_->choice = std::move(choice_);
    return *std::move(best_);
  }

 private:
  CandidateMeter meter_;
  std::optional<FittedMesh> best_;
  Candidate first_;
  Choice choice_;
};

// A mesh that is ready for the progressive method, for the fair one.
MeshToFit for_fair(MeshToFit mesh, const ReadyFit& ready) {
  if (ready.given) {
    static_cast<ReadyMesh&>(mesh) =
        make_ready(PolygonMesh(*ready.given),
                   preparation_of(ready.options, InterpolationMethod::Fair, ready.may_join));
  } else if (ready.options.repairs) {
    make_fair(mesh);
  }
  tell_changes(mesh, ready.name, {mesh.warnings, {}});
  mesh.options.method = InterpolationMethod::Fair;
  return mesh;
}

// Faces to which none were added, after the others.
void add_others(RefinedMesh& made, const PolygonMesh& mesh, std::span<const std::uint8_t> faces) {
  std::vector<std::int32_t> some, others;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) (faces[f] != 0 ? some : others).push_back(f);
  for (std::int32_t& face : made.source_faces) face = some[face];
  made.source_faces.insert(made.source_faces.end(), others.begin(), others.end());
  add_other_faces(made.mesh, mesh, faces);
}

// The same with vertices added, fitted; empty where none are. `faces`: where they may be added, one
// per face; empty: everywhere.
std::optional<FittedMesh> refined_of(const FittedMesh& fair, std::span<const std::uint8_t> faces,
                                     const std::string& name, Backend& backend,
                                     const Callbacks& callbacks) {
  std::optional<RefinedMesh> made;
  if (faces.empty()) {
    made = refine_mesh(fair.mesh, *fair.fit.prepared);
  } else {
    const PolygonMesh some = some_faces(fair.mesh, faces);
    made = refine_mesh(some, *prepare_mesh(some, name));
    if (made) add_others(*made, fair.mesh, faces);
  }
  if (!made) return std::nullopt;
  const std::int64_t added_faces = made->mesh.face_count() - std::ranges::count(faces, 0);
  MeshToFit input = fair;
  keep_bare(input);
  input.mesh = std::move(made->mesh);
  input.prepared = nullptr;
  input.found = {};  // what was taken back stays so
  FittedMesh refined = fit_one(std::move(input), name, backend, callbacks);
  refined.found = fair.found;
  refined.rounded_count = fair.rounded_count;
  refined.added_vertices = std::move(made->added);
  refined.density.is_refined = 2 * added_faces > refined.mesh.face_count();
  std::vector<std::int32_t>& sources = refined.source_vertices;
  if (sources.empty()) {
    sources.resize(refined.mesh.positions.size() - refined.added_vertices.size());
    std::iota(sources.begin(), sources.end(), 0);
  }
  sources.resize(refined.mesh.positions.size(), -1);
  if (!fair.source_faces.empty())
    for (std::int32_t& face : made->source_faces) face = fair.source_faces[face];
  refined.source_faces = std::move(made->source_faces);
  return refined;
}

// The surfaces of one mesh. `adds`: with vertices added, too.
void enter_surfaces(Contest& contest, ReadyFit ready, CandidateFaces faces, bool adds,
                    Backend& backend, const Callbacks& callbacks) {
  Shares shares(callbacks);
  if (!ready.chooses_method) {
    FittedMesh made = fit_one(std::move(ready.input), ready.name, backend, shares.next(kFit));
    return contest.add(std::move(made), {faces}, shares.next(kMeasure));
  }
  const auto is_enough = [&](FittedMesh& first) {
    if (!contest.meter().is_close(first, shares.next(kMeasure))) return false;
    contest.add(std::move(first), {faces}, shares.next(kMeasure),
                "it does not fold, and its normals are near the faces'");
    return true;
  };
  // First the one that is likelier to be enough.
  std::optional<FittedMesh> fair;
  if (!ready.given && !ready.input.found.edges.empty()) {
    fair = fit_one(for_fair(ready.input, ready), ready.name, backend, shares.next(2 * kFit));
    if (is_enough(*fair)) return;
  }
  FittedMesh progressive = fit_one(std::move(ready.input), ready.name, backend, shares.next(kFit));
  if (!fair) {
    if (is_enough(progressive)) return;
    fair = fit_one(for_fair(progressive, ready), ready.name, backend, shares.next(2 * kFit));
  }
  std::optional<FittedMesh> refined;
  if (adds) refined = refined_of(*fair, {}, ready.name, backend, shares.next(2 * kFit));
  // The fair one first: where both are alike it passes the vertices to rounding.
  contest.add(*std::move(fair), {faces}, shares.next(kMeasure));
  contest.add(std::move(progressive), {faces}, shares.next(kMeasure));
  if (refined) contest.add(*std::move(refined), {CandidateFaces::Refined}, shares.next(kMeasure));
}

// One per face of the mesh: whether its part has such faces.
std::vector<std::uint8_t> faces_of(const PolygonMesh& mesh, const MeshParts& parts,
                                   const std::vector<CandidateFaces>& of_parts,
                                   CandidateFaces wanted) {
  std::vector<std::uint8_t> flags;
  for (const std::int32_t part : parts.of_faces(mesh))
    flags.push_back(of_parts[part] == wanted ? 1 : 0);
  return flags;
}

// Where parts of the mesh have different faces best, the surface of these: fair, for vertices are
// added to fair surfaces, and else both methods are alike or only that one was left.
void enter_mixed(Contest& contest, ReadyFit ready, const MeshParts& parts, Backend& backend,
                 const Callbacks& callbacks) {
  if (contest.choice().candidates.empty()) return;
  const std::vector<CandidateFaces> best = best_faces(contest.choice());
  if (std::ranges::all_of(best, [&](CandidateFaces faces) { return faces == best.front(); }))
    return;
  Shares shares(callbacks);
  MeshToFit& mixed = ready.input;
  ready.may_join = faces_of(mixed.mesh, parts, best, CandidateFaces::Quads);
  if (ready.given) {
    ready.options.quads = QuadChoice::On;
  } else {
    pair_up(mixed, ready.options.crease_degrees, ready.may_join);
  }
  FittedMesh fair = fit_one(for_fair(mixed, ready), ready.name, backend, shares.next(4 * kFit));
  const auto refines = faces_of(fair.mesh, parts, best, CandidateFaces::Refined);
  if (std::ranges::find(refines, 1) != refines.end())
    if (auto refined = refined_of(fair, refines, ready.name, backend, shares.next(4 * kFit)))
      fair = *std::move(refined);
  contest.add(std::move(fair), best, shares.next(kMeasure));
}

// What is sharp though nobody asked for it.
std::string features_text(const FittedMesh& fitted, const MeshFitOptions& options) {
  if (!fitted.finds_features || options.finds_features) return {};
  // Some may have been taken back.
  const auto edges = std::ssize(fitted.found.edges);
  if (edges > 0)
    return "; " + counted(edges, "edge") +
           " kept sharp, where two surfaces meet (--creases use rounds " +
           (edges == 1 ? "it" : "them") + ")";
  return fitted.found.corners.empty()
             ? ""
             : "; corners of its outline and tips are kept (--creases use rounds them)";
}

}  // namespace

bool may_refine(const ReadyFit& ready) {
  const MeshFitOptions& options = ready.options;
  const MeshToFit& mesh = ready.input;
  const bool is_free = options.stands_alone && options.fit.scheme == Scheme::DooSabin &&
                       options.fit.within == 0.0 && options.fit.fair_decisions == nullptr;
  if (!is_free || mesh.paired_count > 0) return false;
  if (options.refine != RefineChoice::Auto)
    return options.refine == RefineChoice::On &&
           options.method.value_or(InterpolationMethod::Fair) == InterpolationMethod::Fair;
  return !options.method && !ready.is_plainly_halved && !mesh.density.is_dense() &&
         rms_turn(mesh.mesh, *mesh.prepared) >= kWorthRefining;
}

bool is_open(const ReadyFit& ready) {
  return ready.chooses_method || ready.paired || may_refine(ready);
}

FittedMesh choose_fit(ReadyFit ready, Backend& backend) {
  const auto began = std::chrono::steady_clock::now();
  const MeshFitOptions options = ready.options;
  const std::string name = ready.name;
  const Callbacks& caller = options.fit.callbacks;
  const HostScope host(caller);
  const bool chooses_method = ready.chooses_method;
  const bool may_add = may_refine(ready), adds = may_add && options.refine == RefineChoice::Auto;
  if (!chooses_method && !ready.paired && !may_add) {
    FittedMesh fitted = fit_one(std::move(ready.input), name, backend, caller);
    if (!ready.reason.empty()) fitted.choice.emplace().reason = std::move(ready.reason);
    return fitted;
  }
  const std::size_t told = ready.input.warnings.size();
  Callbacks silent = caller;  // warnings are those of the surface that is taken
  silent.warning = {};
  const MeshParts parts = mesh_parts(ready.input.mesh);
  Contest contest(parts, ready);
  std::optional<ReadyFit> kept;  // for parts that have different faces
  bool is_done = false;
  double begun = 0;
  if (ready.paired) {
    begun = ready.is_plainly_halved ? kPlainEntered : kQuadsEntered;
    // Mostly that is of no use any more.
    if (ready.is_plainly_halved) ready.input.prepared.reset();
    ReadyFit paired = std::move(*std::exchange(ready.paired, nullptr));
    paired.input.warnings = ready.input.warnings;
    enter_surfaces(contest, std::move(paired), CandidateFaces::Quads, false, backend,
                   share_of(silent, 0, begun));
    is_done = ready.is_plainly_halved &&
              contest.meter().is_sound(contest.best(), {.cancelled = caller.cancelled});
    if (is_done)
      contest.note_faces(
          "triangles joined to quads, whose halves they are (--quads off leaves them)");
  }
  if (!is_done) {
    auto& prepared = ready.input.prepared;
    if (!prepared) prepared = prepare_mesh(ready.input.mesh, name);
    const bool may_mix = parts.count > 1 && ready.chooses_method;
    if (may_mix) kept = ready;
    enter_surfaces(contest, std::move(ready), CandidateFaces::Given, adds, backend,
                   share_of(silent, begun, may_mix ? kAllEntered : 1));
    if (kept)
      enter_mixed(contest, *std::move(kept), parts, backend, share_of(silent, kAllEntered, 1));
  }
  FittedMesh taken = contest.take();
  if (options.refine == RefineChoice::On && may_add &&
      taken.options.method == InterpolationMethod::Fair) {
    if (auto refined = refined_of(taken, {}, name, backend, silent)) {
      refined->choice = std::move(taken.choice);
      taken = *std::move(refined);
    }
  }
  if (chooses_method) {
    taken.choice->reason += features_text(taken, options);
  } else {
    taken.choice->reason.clear();  // the method was named
  }
  for (std::size_t i = told; i < taken.warnings.size(); ++i) caller.warn(taken.warnings[i]);
  taken.choose_milliseconds = milliseconds_since(began) - sum_of(taken.fit.timing);
  return taken;
}

}  // namespace planish
