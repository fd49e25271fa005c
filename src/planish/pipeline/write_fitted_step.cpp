#include "planish/pipeline/write_fitted_step.h"

#include <algorithm>

#include "planish/brep/analytic_faces.h"
#include "planish/brep/free_borders.h"
#include "planish/brep/subdivision_splines.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"
#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/core/words.h"
#include "planish/files/formats.h"
#include "planish/files/materials.h"
#include "planish/measure/figures.h"
#include "planish/pipeline/option_table.h"
#include "planish/surface/quality_sum.h"

namespace planish {
namespace {

std::string limits_text(const Brep& brep, const BrepOptions& wanted) {
  std::string text;
  if (brep.max_angle > wanted.angle)
    text = formatted("normals jump by up to {} degrees at edges, {}, above the {} asked for",
                     short_number(brep.max_angle), words_of(brep.max_angle_at),
                     short_number(wanted.angle));
  if (brep.max_deviation > wanted.deviation)
    text += formatted(
        "{}faces leave the surface by up to {} of the diagonal, {}, above the {} asked for",
        text.empty() ? "" : "; ", short_number(brep.max_deviation), words_of(brep.max_deviation_at),
        short_number(wanted.deviation));
  return text;
}

// What whoever opens the file should know.
std::string description_of(const Interpolation& fit, const std::string& limits) {
  std::string text = limits;
  if (!fit.converged)
    text = formatted("not converged: vertices are off by up to {} of the diagonal{}{}",
                     short_number(fit.error.max), limits.empty() ? "" : "; ", limits);
  return text;
}

double shortest_span(const Brep& brep) {
  return ordered_reduce(
      brep.edges.size(), 256, std::numeric_limits<double>::max(),
      [&](std::size_t begin, std::size_t end) {
        double shortest = std::numeric_limits<double>::max();
        for (std::size_t e = begin; e < end; ++e) {
          const Brep::Edge& edge = brep.edges[e];
          if (edge.curve) {
            const glm::dvec3 &first = brep.vertices[edge.from], &target = brep.vertices[edge.to];
            double length = 0;
            glm::dvec3 last = first;
            for (const glm::dvec3& place : places_along(*edge.curve, first, target)) {
              length += safe_length(place - last);
              last = place;
            }
            shortest = std::min(shortest, length + safe_length(target - last));
            continue;
          }
          glm::dvec3 from = edge.points.front();
          for (std::size_t k = 1; k < edge.knots.size(); ++k) {
            const glm::dvec3 to = point_of(brep, edge, edge.knots[k]);
            shortest = std::min(shortest, safe_length(to - from));
            from = to;
          }
        }
        return shortest;
      },
      [](double& total, double one) { total = std::min(total, one); });
}

// Of the points that the surface passes through.
double largest_distance(const Brep& brep, const FittedMesh& fitted) {
  const std::span<const glm::dvec3> given = fitted.points();
  const auto& vertices = fitted.fit.prepared->vertices;
  return ordered_reduce(
      brep.places.size(), 1024, 0.0,
      [&](std::size_t begin, std::size_t end) {
        double largest = 0;
        for (std::size_t v = begin; v < end; ++v) {
          const Brep::Place& place = brep.places[v];
          if (place.face < 0) continue;
          const glm::dvec3 there = point_of(brep, brep.faces[place.face], place.at);
          largest = std::max(largest, safe_length(there - given[vertices[v]]));
        }
        return largest;
      },
      [](double& total, double one) { total = std::max(total, one); });
}

// Groups of faces with what their materials say; empty where all faces are alike.
std::vector<StepGroup> groups_of(const PolygonMesh& mesh, const GltfMaterials* materials) {
  std::vector<StepGroup> groups;
  for (const FaceGroup& group : mesh.groups) {
    StepGroup& made = groups.emplace_back();
    made.name = group.name.empty() ? group.material : group.name;
    if (materials != nullptr) made.color = materials->display_color(group.material);
  }
  return groups;
}

double folded_part(const FittedMesh& fitted, const LimitSurface& limit) {
  if (const SurfaceQuality* const known = fitted.chosen_quality()) return known->folded_area;
  const auto blocks = limit.surface().level(1);
  return surface_quality(*blocks, fitted.mesh, {}, {}).folded_area;
}

void warn(const std::string& name, const Brep& brep, const BrepCheck& check,
          const FittedMesh& fitted, double folded, const StepFileOptions& options) {
  const auto say = [&](const char* code, const std::string& message, std::int64_t count = 1) {
    options.callbacks.warn({code, name + ": " + message, count});
  };
  if (folded >= kSoundFoldedArea)
    say("step-folds",
        percent(folded) +
            " of the surface is folded, where its shell crosses itself and CAD programs may fail "
            "to cut it; the fair method, or a finer mesh there, avoids that");
  const auto inside_out = std::ranges::count_if(
      brep.shells, [](const Brep::Shell& shell) { return shell.is_inside_out && shell.outer < 0; });
  if (inside_out > 0)
    say("step-inside-out",
        counted(inside_out, "closed part") + (inside_out == 1 ? " is" : " are") +
            " inside out and in no other, which CAD programs take for all of space around; turn "
            "its "
            "faces over",
        inside_out);
  const auto faces = std::ssize(brep.faces);
  if (faces > kManyStepFaces)
    say("step-faces",
        counted(faces, "face") +
            ", for which CAD programs take long; fewer come of quads, most of whose vertices have "
            "four: join triangles to quads, or remesh first (QuadriFlow, QuadWild, Instant Meshes)",
        faces);
  const double span = shortest_span(brep) * millimetres_of(options.settings.unit);
  if (span < kShortStepSpan)
    say("step-spans",
        formatted("the shortest spans of edges are {} mm, where CAD programs may take {} mm for "
                  "nothing; allow a larger angle, or say in which larger unit the coordinates are",
                  short_number(span), short_number(kShortStepSpan)));
  if (!check.is_valid())
    say("step-invalid",
        formatted("{} of {} are not closed, {} of {} are not shared as they must be, and edges are "
                  "off their faces by up to {} of the diagonal, near ({}, {}, {}), where {} is one "
                  "place: CAD programs may not take it for a solid; mend the mesh there",
                  check.broken_loops, counted(std::ssize(brep.faces), "loop"),
                  check.unmatched_edges, counted(std::ssize(brep.edges), "edge"),
                  short_number(check.largest_gap), short_number(check.largest_gap_at.x),
                  short_number(check.largest_gap_at.y), short_number(check.largest_gap_at.z),
                  short_number(Brep::kSamePlace)));
  if (const std::string limits = limits_text(brep, options.settings.faces); !limits.empty())
    say("step-limits",
        limits +
            "; the file says so; allow more, or look at the mesh there: a needle or a sharp turn "
            "wants mending, or its edge a crease");
  const PolygonMesh& mesh = fitted.mesh;
  const std::string lost =
      lost_attributes(FileFormat::Step, {!mesh.face_uvs.empty(), !mesh.colors.empty(),
                                         mesh.groups.size() > 1, !mesh.attributes.empty()});
  if (!lost.empty()) options.callbacks.warn({"lost-attributes", lost});
}

const PolygonMesh& given_mesh(const FittedMesh& fitted) {
  return fitted.bare ? *fitted.bare : fitted.mesh;
}

// The mesh as it was given, and what of it lies on surfaces that have a name.
struct GivenParts {
  std::shared_ptr<const PreparedMesh> prepared;
  UsedPart used;
  std::span<const std::int32_t> groups;
  double diagonal = 1;
  VertexPlaces places = VertexPlaces::OnEdges;
  AnalyticParts found;

  [[nodiscard]] AnalyticMesh mesh() const {
    return {.topology = *prepared->topology,
            .positions = used.mesh.positions,
            .is_sharp = {},
            .groups = groups,
            .diagonal = diagonal,
            .places = places};
  }
  // Whether faces on surfaces are all that there is of every part.
  [[nodiscard]] bool is_whole() const {
    return std::ranges::none_of(found.has_free, [](char free) { return free != 0; });
  }
};

std::span<const std::int32_t> groups_in(const PolygonMesh& mesh) {
  return mesh.groups.size() > 1 ? std::span(mesh.face_groups) : std::span<const std::int32_t>();
}

// Whoever names another scheme wants its surface.
bool wants_parts(const FittedMesh& fitted, const StepFileOptions& options) {
  return options.settings.analytic == AnalyticChoice::Auto &&
         given_mesh(fitted).hole_faces.empty() && fitted.options.scheme == Scheme::DooSabin;
}

// What of a mesh lies on surfaces that have a name.
std::unique_ptr<const GivenParts> parts_of(const PolygonMesh& mesh,
                                           const std::shared_ptr<const PreparedMesh>& prepared,
                                           VertexPlaces places, const FittedMesh& fitted,
                                           const StepFileOptions& options) {
  auto parts = std::make_unique<GivenParts>(GivenParts{.prepared = prepared,
                                                       .used = used_part(mesh, prepared),
                                                       .groups = groups_in(mesh),
                                                       .diagonal = fitted.fit.placement.diagonal,
                                                       .places = places,
                                                       .found = {}});
  const MeshTopology& topology = *prepared->topology;
  std::vector<char> is_sharp(static_cast<std::size_t>(topology.edge_count()), 0);
  // Where features were looked for all of them count, whatever the fit has rounded of them; those
  // of samples are chance.
  std::vector<CreaseEdge> sharp;
  if (places == VertexPlaces::OnEdges)
    sharp = fitted.finds_features ? find_features(parts->used.mesh, topology).sharp_edges()
                                  : parts->used.mesh.creases;
  for (const CreaseEdge& crease : sharp) {
    const std::int32_t edge = topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0) is_sharp[edge] = 1;
  }
  AnalyticMesh analytic = parts->mesh();
  analytic.is_sharp = is_sharp;
  analytic.keeps_smooth = !fitted.finds_features;
  parts->found =
      find_analytic_parts(analytic, options.settings.analytic_tolerance, options.callbacks);
  return parts;
}
// Of the mesh as it was given.
std::unique_ptr<const GivenParts> given_parts(const FittedMesh& fitted,
                                              const StepFileOptions& options) {
  const PolygonMesh& mesh = given_mesh(fitted);
  return parts_of(mesh, fitted.bare ? prepare_mesh(mesh, options.name) : fitted.fit.prepared,
                  VertexPlaces::OnEdges, fitted, options);
}
// Of a mesh through samples, of which no vertex has to lie on an edge: of points, or of the mesh
// where `given` parts are noisy and were told in part only; else null.
std::unique_ptr<const GivenParts> scanned_parts(const GivenParts* given, const FittedMesh& fitted,
                                                const StepFileOptions& options) {
  if (options.scan != nullptr)
    return parts_of(*options.scan, prepare_mesh(*options.scan, options.name), VertexPlaces::Samples,
                    fitted, options);
  if (std::ranges::none_of(given->found.tolerances, [](double t) { return t > kExactTolerance; }))
    return nullptr;
  return parts_of(given_mesh(fitted), given->prepared, VertexPlaces::Samples, fitted, options);
}

// By vertex of the fitted mesh's topology, where it lies in that of the given one.
std::vector<std::array<std::int32_t, 2>> places_in(const PreparedMesh& given,
                                                   const FittedMesh& fitted) {
  std::vector<std::int32_t> number(static_cast<std::size_t>(given.given_vertex_count), -1);
  for (std::size_t v = 0; v < given.vertices.size(); ++v)
    number[given.vertices[v]] = static_cast<std::int32_t>(v);
  std::vector<std::array<std::int32_t, 2>> result;
  for (const std::int32_t v : fitted.fit.prepared->vertices) {
    // Vertices that were added stand behind all given ones.
    const std::int32_t added = v - std::int32_t(std::ssize(number));
    if (added < 0) {
      result.push_back({number[v], number[v]});
      continue;
    }
    const AddedVertex& of = fitted.added_vertices[added];
    constexpr double kBeside = 1e-9;  // of a triangle's height
    std::array<std::int32_t, 2> on{-1, -1};
    for (int i = 0; i < 3; ++i)
      if (std::abs(of.weights[i]) < kBeside)
        on = {number[of.vertices[(i + 1) % 3]], number[of.vertices[(i + 2) % 3]]};
    result.push_back(on);
  }
  return result;
}

// By part: whether it has regions, and faces of none.
std::vector<char> parts_to_mix(const AnalyticParts& found) {
  std::vector<char> result = found.has_free;
  for (std::size_t part = 0; part < result.size(); ++part)
    if (found.regions_of[part].empty()) result[part] = 0;
  return result;
}

// The B-spline faces of parts that have others on surfaces, and where these meet.
struct MixedFaces {
  FreeBorders borders;
  // By face of the fitted mesh, its group + group_count (its part + 1, or 0 where it is not free):
  // faces end at borders.
  std::vector<std::int32_t> groups;
  std::int32_t group_count = 1;
  bool has_any = false;
};
MixedFaces find_mixed_faces(const GivenParts& given, const FittedMesh& fitted,
                            std::span<const std::array<std::int32_t, 2>> places,
                            std::vector<char>& is_sound) {
  const MeshTopology& topology = *fitted.fit.prepared->topology;
  const AnalyticParts& found = given.found;
  MixedFaces mixed;
  mixed.borders = find_free_borders(found.borders, {topology, places});
  // Parts whose borders the fitted mesh has, too.
  for (std::size_t c = 0; c < found.borders.chains.size(); ++c) {
    const BorderChain& chain = found.borders.chains[c];
    if (chain.right < 0 && !chain.is_boundary && mixed.borders.corners[c].empty())
      is_sound[found.parts.of_face[found.regions.regions[chain.left].faces.front()]] = 0;
  }
  std::vector<std::int32_t> part_at(given.prepared->vertices.size(), -1);
  for (std::int32_t f = 0; f < given.prepared->topology->face_count(); ++f)
    for (const std::int32_t v : given.prepared->topology->face(f))
      part_at[v] = found.parts.of_face[f];
  const FaceComponents own = face_components(topology);
  std::vector<std::int32_t> part_of(static_cast<std::size_t>(own.count), -1);
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    for (const std::int32_t v : topology.face(f))
      if (places[v][0] >= 0) part_of[own.of_face[f]] = part_at[places[v][0]];
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (mixed.borders.is_torn[f] != 0) is_sound[part_of[own.of_face[f]]] = 0;
  const std::span<const std::int32_t> groups = groups_in(fitted.mesh);
  if (!groups.empty()) mixed.group_count = std::int32_t(std::ssize(fitted.mesh.groups));
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const std::int32_t part = part_of[own.of_face[f]];
    const bool is_free = mixed.borders.is_free[f] != 0 && part >= 0 && is_sound[part] != 0;
    mixed.has_any = mixed.has_any || is_free;
    mixed.groups.push_back((groups.empty() ? 0 : groups[f]) +
                           (is_free ? mixed.group_count * (part + 1) : 0));
  }
  return mixed;
}

// A fitted mesh's faces for a file, and what is to be said of them.
struct MadeFaces {
  Brep brep;
  double folded = 0;
  std::optional<AnalyticFaces> analytic;
  std::unique_ptr<const FittedMesh> again;  // what they are of, where it is another surface
};

// Whether triangles were joined or vertices added across a border of analytic faces beside which
// freeform ones lie.
bool is_torn(const GivenParts& given, const FittedMesh& fitted) {
  if (!fitted.bare) return false;
  const std::vector<char> wanted = parts_to_mix(given.found);
  std::vector<char> is_sound = wanted;
  (void)find_mixed_faces(given, fitted, places_in(*given.prepared, fitted), is_sound);
  return is_sound != wanted;
}
// The surface through the faces as they are given, by the same method and with the same creases.
std::unique_ptr<const FittedMesh> fitted_as_given(const FittedMesh& fitted,
                                                  const StepFileOptions& options,
                                                  const Callbacks& callbacks) {
  MeshFitOptions as_given{.method = fitted.options.method,
                          .repairs = fitted.repairs,
                          .faces_are_given = false,
                          .chooses_creases = false,
                          .quads = QuadChoice::Off,
                          .refine = RefineChoice::Off,
                          .fit = fitted.options};
  as_given.fit.callbacks = callbacks;
  as_given.fit.callbacks.warning = {};  // of the surface that everybody sees they were said
  return std::make_unique<const FittedMesh>(fit_mesh(
      *fitted.bare, options.name,
      *make_cpu_backend({.solve_precision = precision_for(fitted.options.tolerance)}), as_given));
}

// Of the whole mesh, and what of it lies on surfaces instead.
class MixedFacesMaker {
 public:
  MixedFacesMaker(const FittedMesh& fitted, const GivenParts& given, const StepFileOptions& options)
      : fitted_(fitted),
        given_(given),
        options_(options),
        places_(places_in(*given.prepared, fitted)) {}

  void make(const SplineSurface& surface, const Callbacks& callbacks, MadeFaces& made) {
    const AnalyticParts& found = given_.found;
    std::vector<char> is_sound = parts_to_mix(found);
    make_with(is_sound, surface, callbacks, made);
    // Borders that no part has used in the end should not cut its faces.
    std::vector<char> is_mixed(is_sound.size(), 0);
    for (std::size_t f = 0; f < made.analytic->face_of.size(); ++f)
      if (made.analytic->face_of[f] >= 0) is_mixed[found.parts.of_face[f]] = 1;
    for (std::size_t part = 0; part < is_sound.size(); ++part)
      is_mixed[part] = is_mixed[part] != 0 && is_sound[part] != 0 ? 1 : 0;
    if (is_mixed != is_sound) make_with(is_mixed, surface, callbacks, made);
    join(made);
  }

 private:
  // With freeform faces beside others in parts that are sound.
  void make_with(std::vector<char>& is_sound, const SplineSurface& surface,
                 const Callbacks& callbacks, MadeFaces& made) const {
    const MixedFaces mixed = find_mixed_faces(given_, fitted_, places_, is_sound);
    BrepOptions with_corners = options_.settings.faces;
    with_corners.has_corners = mixed.has_any;
    made.brep = make_brep(surface, with_corners, callbacks, mixed.groups);
    std::vector<std::int32_t> part_of(made.brep.faces.size(), -1);
    std::vector<char> is_free(made.brep.faces.size(), 0);
    for (std::size_t f = 0; f < made.brep.faces.size(); ++f) {
      Brep::Face& face = made.brep.faces[f];
      part_of[f] = face.group / mixed.group_count - 1;
      is_free[f] = part_of[f] >= 0 ? 1 : 0;
      face.group %= mixed.group_count;
    }
    const FreeformFaces freeform{made.brep, part_of,
                                 spans_along(given_.found.borders, mixed.borders,
                                             *fitted_.fit.prepared->topology, made.brep, is_free)};
    made.analytic = make_analytic_faces(given_.mesh(), given_.found, &freeform, options_.callbacks);
  }
  void join(MadeFaces& made) const {
    if (made.analytic->freeform_parts == made.analytic->parts) return;
    const MeshTopology& given = *given_.prepared->topology;
    std::vector<std::int32_t> by_vertex(given_.prepared->vertices.size(), -1), analytic_at;
    for (std::int32_t f = 0; f < given.face_count(); ++f)
      for (const std::int32_t v : given.face(f)) by_vertex[v] = made.analytic->face_of[f];
    for (const auto& [v, other] : places_)
      analytic_at.push_back(v == other && v >= 0 ? by_vertex[v] : -1);
    const UsedPart used = used_part(fitted_.mesh, fitted_.fit.prepared);
    made.brep = joined_parts(made.brep, *made.analytic, *fitted_.fit.prepared->topology,
                             used.mesh.positions, analytic_at);
  }

  const FittedMesh& fitted_;
  const GivenParts& given_;
  const StepFileOptions& options_;
  std::vector<std::array<std::int32_t, 2>> places_;
};

// Whether all parts have become faces on surfaces.
bool take_whole(const GivenParts& given, const StepFileOptions& options, MadeFaces& made) {
  made.analytic = make_analytic_faces(given.mesh(), given.found, nullptr, options.callbacks);
  if (made.analytic->freeform_parts > 0) {
    made.analytic = AnalyticFaces{.parts = made.analytic->parts,
                                  .freeform_parts = made.analytic->parts,
                                  .first_reason = made.analytic->first_reason};
    return false;
  }
  made.brep = std::move(made.analytic->brep);
  find_shells(*given.prepared->topology, given.used.mesh.positions, made.analytic->face_of,
              made.brep);
  return true;
}

MadeFaces make_faces(const FittedMesh& fitted, const StepFileOptions& options,
                     const std::function<const LimitSurface&()>& limit,
                     const Callbacks& callbacks) {
  constexpr double kFitShare = 0.5;  // of the time, where it is fitted again
  MadeFaces made;
  std::unique_ptr<const GivenParts> given;
  if (wants_parts(fitted, options)) {
    if (options.scan == nullptr) {
      given = given_parts(fitted, options);
      if (given->is_whole() && take_whole(*given, options, made)) return made;
    }
    const auto scanned = scanned_parts(given.get(), fitted, options);
    if (scanned && take_whole(*scanned, options, made)) return made;
  }
  if (given && is_torn(*given, fitted))
    made.again = fitted_as_given(fitted, options, share_of(callbacks, 0, kFitShare));
  const FittedMesh& of = made.again ? *made.again : fitted;
  const Callbacks rest = made.again ? share_of(callbacks, kFitShare, 1) : callbacks;
  if (of.options.scheme == Scheme::DooSabin) {
    std::optional<LimitSurface> own;
    const LimitSurface& surface =
        limit && !made.again ? limit()
                             : own.emplace(fitted_surface(of.mesh, of.fit, of.evaluate_options()));
    made.folded = folded_part(of, surface);
    const DooSabinSplines splines(surface);
    if (given) {
      MixedFacesMaker(of, *given, options).make(splines, rest, made);
    } else {
      made.brep = make_brep(splines, options.settings.faces, rest, groups_in(of.mesh));
    }
    return made;
  }
  const EvaluateOptions evaluated = of.evaluate_options(1);
  const SurfaceMesh level_one = evaluate(of.mesh, of.fit, *make_cpu_backend(), evaluated);
  made.brep = make_brep(CatmullClarkSplines(of.fit.cage, evaluated), options.settings.faces, rest,
                        groups_in(of.mesh));
  made.folded = surface_quality(level_one, of.mesh).folded_area;
  return made;
}

}  // namespace

std::string words_of(const Brep::Spot& spot) {
  if (spot.face < 0) return "nowhere";
  const auto& p = spot.position;
  return formatted("near ({}, {}, {}) in face {}", short_number(p.x), short_number(p.y),
                   short_number(p.z), spot.face);
}

void require_step_scheme(Scheme scheme, std::string_view where) {
  if (scheme != Scheme::Loop) return;
  refuse(where,
         "STEP's faces are quads, and patches of loop are triangles; take --scheme doo-sabin or "
         "catmull-clark, or a format of meshes");
}

StepUnit settled_unit(StepUnit unit, std::string_view format) {
  if (unit != StepUnit::OfInput) return unit;
  const auto all = formats();
  const auto found = std::ranges::find(all, format, &FormatInfo::name);
  return found != all.end() && found->is_gltf ? StepUnit::Metre : StepUnit::Millimetre;
}

StepFigures write_fitted_step(const std::filesystem::path& path, const FittedMesh& fitted,
                              const StepFileOptions& options,
                              const std::function<const LimitSurface&()>& limit) {
  require_step_scheme(fitted.options.scheme, visible(path));
  const HostScope host(options.callbacks);
  const BrepOptions& wanted = options.settings.faces;
  constexpr double kFacesShare = 0.7;  // of the time
  std::vector<StepGroup> groups = groups_of(fitted.mesh, options.materials);
  const MadeFaces made =
      make_faces(fitted, options, limit, share_of(options.callbacks, 0, kFacesShare));
  const Brep& brep = made.brep;
  const FittedMesh& of = made.again ? *made.again : fitted;
  const double diagonal = fitted.fit.placement.diagonal;
  StepFigures figures;
  figures.check = check_brep(brep, diagonal);
  warn(visible(options.shown.empty() ? path : options.shown), brep, figures.check, of, made.folded,
       options);
  figures.unit = settled_unit(options.settings.unit, "");
  figures.faces = std::ssize(brep.faces);
  figures.edges = std::ssize(brep.edges);
  figures.vertices = std::ssize(brep.vertices);
  for (const Brep::Face& face : brep.faces) {
    if (face.plane || (face.surface && face.surface->kind == AnalyticKind::Plane)) ++figures.planes;
    if (!face.plane) figures.control_points += std::ssize(face.points);
  }
  for (const Brep::Shell& shell : brep.shells)
    ++(!shell.is_closed ? figures.open_shells : shell.outer >= 0 ? figures.voids : figures.solids);
  if (made.analytic) {
    figures.analytic = made.analytic->faces_by_kind;
    figures.radii = made.analytic->radii;
    figures.freeform_parts = made.analytic->freeform_parts;
    figures.mixed_parts = made.analytic->mixed_parts;
    figures.analytic_parts = made.analytic->parts - figures.freeform_parts - figures.mixed_parts;
    figures.freeform_reason = made.analytic->first_reason;
    figures.analytic_distance = made.analytic->largest_distance;
  }
  figures.extraordinary = brep.extraordinary;
  figures.deepest = brep.deepest;
  figures.max_angle = brep.max_angle;
  figures.max_deviation = brep.max_deviation;
  figures.max_angle_at = brep.max_angle_at;
  figures.max_deviation_at = brep.max_deviation_at;
  const std::string limits = limits_text(brep, wanted);
  figures.keeps_limits = limits.empty();
  constexpr BrepOptions kUnasked;
  figures.keeps_wishes =
      (brep.max_angle <= wanted.angle || wanted.angle == kUnasked.angle) &&
      (brep.max_deviation <= wanted.deviation || wanted.deviation == kUnasked.deviation);
  figures.largest_distance = std::max(largest_distance(brep, of), figures.analytic_distance);
  figures.byte_count = write_step(path, brep,
                                  {.name = options.name,
                                   .unit = figures.unit,
                                   .diagonal = diagonal,
                                   .description = description_of(of.fit.interpolation, limits),
                                   .groups = std::move(groups),
                                   .observe = options.observe,
                                   .callbacks = share_of(options.callbacks, kFacesShare, 1)});
  return figures;
}

}  // namespace planish
