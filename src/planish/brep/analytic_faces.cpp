#include "planish/brep/analytic_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "planish/analytic/border_curves.h"
#include "planish/analytic/find_regions.h"
#include "planish/analytic/region_borders.h"
#include "planish/analytic/settle_surfaces.h"
#include "planish/brep/analytic_part.h"
#include "planish/brep/freeform_side.h"
#include "planish/core/callbacks.h"
#include "planish/mesh/mesh_parts.h"

namespace planish {
namespace {

AnalyticSurface to_model(AnalyticSurface surface, const Placement& placement) {
  surface.origin = placement.to_model(surface.origin);
  surface.radius *= placement.diagonal;
  surface.minor *= placement.diagonal;
  return surface;
}
BorderCurve to_model(BorderCurve curve, const Placement& placement) {
  curve.centre = placement.to_model(curve.centre);
  curve.radius *= placement.diagonal;
  curve.minor *= placement.diagonal;
  for (glm::dvec3& p : curve.points) p = placement.to_model(p);
  return curve;
}

// Corners of faces with samples that lie on no surface around: across an edge, or out of order.
std::size_t few_of(std::size_t corners) { return std::max<std::size_t>(20, corners / 50); }

// One by one for each part: those that left their vertices when all were settled, and whose faces
// cannot be closed.
std::vector<char> unsound_regions(const AnalyticParts& found, const MeshTopology& topology,
                                  VertexPlaces places) {
  std::vector<char> is_unsound(found.regions.regions.size(), 0);
  for (std::size_t part = 0; part < found.regions_of.size(); ++part) {
    const std::vector<std::int32_t>& regions = found.regions_of[part];
    const double most = 2 * found.tolerances[part];
    for (const std::int32_t r : regions) {
      const AnalyticRegion& region = found.regions.regions[r];
      std::size_t off = 0, all = 0;
      for (const std::int32_t f : region.faces) {
        for (const std::int32_t v : topology.face(f)) {
          if (!(std::abs(signed_distance(region.surface, found.positions[v])) <= most + region.sag))
            ++off;
          ++all;
        }
      }
      if (off > (places == VertexPlaces::Samples ? few_of(all) : 0)) is_unsound[r] = 1;
    }
    if (std::ranges::any_of(regions, [&](std::int32_t r) { return is_unsound[r] != 0; })) continue;
    try {
      for (const std::int32_t r : regions_in_the_way(found, topology, regions)) is_unsound[r] = 1;
    } catch (const NotAnalytic&) {
      // Nothing that could be left out would help.
    }
  }
  return is_unsound;
}

// Closed borders that go along an edge and back: around a handle that triangles between samples
// have made, and no hole.
void drop_handles(AnalyticParts& found) {
  std::vector<char> is_handle;
  for (const BorderChain& chain : found.borders.chains) {
    is_handle.push_back(0);
    if (!chain.is_closed || chain.left < 0 || chain.right < 0) continue;
    std::vector<glm::dvec3> points;
    for (const std::int32_t v : chain.vertices) points.push_back(found.positions[v]);
    is_handle.back() = comes_back({{&found.regions.regions[chain.left].surface},
                                   {&found.regions.regions[chain.right].surface}},
                                  points)
                           ? 1
                           : 0;
  }
  for (auto& loops : found.borders.loops)
    std::erase_if(loops, [&](const std::vector<ChainUse>& loop) {
      return is_handle[loop.front().chain] != 0;
    });
}

// Whether there were any.
bool drop_regions(const std::vector<char>& is_dropped, AnalyticRegions& regions) {
  const std::size_t before = regions.regions.size();
  for (std::size_t r = 0; r < is_dropped.size(); ++r) {
    if (is_dropped[r] == 0) continue;
    for (const std::int32_t f : regions.regions[r].faces) regions.region_of[f] = kNoRegion;
    regions.regions[r].faces.clear();
  }
  remove_empty(regions);
  return regions.regions.size() != before;
}

// Of samples, where they were, from the nearest surface around them.
double farthest_sample(const AnalyticMesh& mesh, const AnalyticParts& found) {
  double farthest = 0;
  for (std::int32_t v = 0; v < mesh.topology.vertex_count(); ++v) {
    double nearest = std::numeric_limits<double>::max();
    for (const std::int32_t corner : mesh.topology.corners_at(v)) {
      const std::int32_t r = found.regions.region_of[mesh.topology.face_of(corner)];
      if (r < 0) continue;
      nearest =
          std::min(nearest, std::abs(signed_distance(found.regions.regions[r].surface,
                                                     found.placement.to_unit(mesh.positions[v]))));
    }
    if (nearest < std::numeric_limits<double>::max()) farthest = std::max(farthest, nearest);
  }
  return found.placement.diagonal * farthest;
}

// What a face of a region says of the whole.
void add_figures(const AnalyticParts& found, const AnalyticRegion& region,
                 const MeshTopology& topology, const AnalyticSurface& in_model,
                 AnalyticFaces& result) {
  ++result.faces_by_kind[static_cast<std::size_t>(in_model.kind)];
  if (in_model.radius > 0) result.radii.push_back(in_model.radius);
  if (in_model.minor > 0) result.radii.push_back(in_model.minor);
  for (const std::int32_t f : region.faces)
    for (const std::int32_t v : topology.face(f))
      result.largest_distance = std::max(
          result.largest_distance,
          found.placement.diagonal * std::abs(signed_distance(region.surface, found.positions[v])));
}

}  // namespace

AnalyticParts find_analytic_parts(const AnalyticMesh& mesh, std::optional<double> tolerance,
                                  const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const MeshTopology& topology = mesh.topology;
  AnalyticParts found;
  found.placement = placement_of(mesh.positions);
  found.placement.diagonal = mesh.diagonal;
  for (const glm::dvec3& p : mesh.positions) found.positions.push_back(found.placement.to_unit(p));
  // Groups end faces as sharp edges do.
  std::vector<char> is_sharp(mesh.is_sharp.begin(), mesh.is_sharp.end());
  for (std::int32_t e = 0; !mesh.groups.empty() && e < topology.edge_count(); ++e) {
    const std::int32_t corner = topology.corner_of(e), twin = topology.twin(corner);
    if (twin >= 0 && mesh.groups[topology.face_of(corner)] != mesh.groups[topology.face_of(twin)])
      is_sharp[e] = kGroupBorder;
  }
  const double exact = std::min(kExactTolerance, tolerance.value_or(kExactTolerance));
  AnalyticRegions regions =
      find_regions(found.positions, topology, is_sharp, exact, mesh.keeps_smooth);
  if (tolerance) {
    std::vector<char> is_deep;
    for (const AnalyticRegion& region : regions.regions)
      is_deep.push_back(region.sag > *tolerance ? 1 : 0);
    drop_regions(is_deep, regions);
  }
  found.parts = face_components(topology);
  found.tolerances = find_noisy_regions(found.positions, topology, is_sharp, found.parts, tolerance,
                                        exact, mesh.places, regions);
  if (mesh.places == VertexPlaces::Samples)
    move_samples(topology, found.parts, found.tolerances, regions, found.positions);
  // Regions that surfaces cannot be settled for become freeform, until all others can.
  do {
    check_stop();
    found.regions = regions;
    found.borders = find_borders(topology, found.regions);
    if (mesh.places == VertexPlaces::Samples) drop_handles(found);
    found.settled = settle_surfaces(found.positions, topology, found.borders, found.regions);
    found.regions_of.assign(static_cast<std::size_t>(found.parts.count), {});
    for (std::int32_t r = 0; r < std::ssize(found.regions.regions); ++r)
      found.regions_of[found.parts.of_face[found.regions.regions[r].faces.front()]].push_back(r);
  } while (drop_regions(unsound_regions(found, topology, mesh.places), regions));
  found.has_free.assign(found.regions_of.size(), 0);
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    if (found.regions.region_of[f] < 0) found.has_free[found.parts.of_face[f]] = 1;
  return found;
}

AnalyticFaces make_analytic_faces(const AnalyticMesh& mesh, const AnalyticParts& found,
                                  const FreeformFaces* freeform, const Callbacks& callbacks) {
  const HostScope host(callbacks);
  const MeshTopology& topology = mesh.topology;
  const Placement& placement = found.placement;
  AnalyticFaces result;
  result.face_of.assign(static_cast<std::size_t>(topology.face_count()), -1);
  result.parts = found.parts.count;
  std::vector<std::vector<std::int32_t>> freeform_of(found.regions_of.size());
  if (freeform != nullptr) {
    result.freeform_number.assign(freeform->brep.faces.size(), -1);
    for (std::size_t f = 0; f < freeform->part_of.size(); ++f)
      if (freeform->part_of[f] >= 0)
        freeform_of[freeform->part_of[f]].push_back(static_cast<std::int32_t>(f));
  }
  std::vector<std::int32_t> face_of_part(found.regions_of.size(), -1);
  for (std::int32_t part = 0; part < found.parts.count; ++part) {
    check_stop();
    const std::vector<std::int32_t>& regions = found.regions_of[part];
    Brep brep;
    try {
      if (regions.empty())
        throw NotAnalytic{"its faces lie on no plane, cylinder, cone, sphere or torus"};
      if (found.has_free[part] != 0 && mesh.places == VertexPlaces::Samples)
        throw NotAnalytic{"its points do not tell such a surface everywhere"};
      if (found.has_free[part] != 0 && freeform_of[part].empty())
        throw NotAnalytic{
            "triangles were joined or vertices added across borders of its planes, cylinders, "
            "cones, spheres and tori; --quads off --refine off may keep these"};
      brep = analytic_part(found, topology, regions, freeform, freeform_of[part]);
      if (!check_brep(brep, 1).is_valid()) throw NotAnalytic{"its faces would leave gaps"};
    } catch (const NotAnalytic& reason) {
      ++result.freeform_parts;
      if (result.first_reason.empty()) result.first_reason = reason.reason;
      continue;
    }
    if (found.has_free[part] != 0) ++result.mixed_parts;
    const auto first_edge = static_cast<std::int32_t>(result.brep.edges.size()),
               first_face = static_cast<std::int32_t>(result.brep.faces.size());
    face_of_part[part] = first_face;
    for (std::size_t i = 0; i < brep.faces.size(); ++i) {
      Brep::Face& face = brep.faces[i];
      for (Brep::Use& use : face.loop) use.edge += first_edge;
      for (auto& hole : face.holes)
        for (Brep::Use& use : hole) use.edge += first_edge;
      for (glm::dvec3& p : face.points) p = placement.to_model(p);
      if (i < regions.size()) {
        const AnalyticRegion& region = found.regions.regions[regions[i]];
        face.surface = to_model(*face.surface, placement);
        if (!mesh.groups.empty()) face.group = mesh.groups[region.faces.front()];
        add_figures(found, region, topology, *face.surface, result);
      } else {
        result.freeform_number[freeform_of[part][i - regions.size()]] =
            static_cast<std::int32_t>(result.brep.faces.size());
      }
      result.brep.faces.push_back(std::move(face));
    }
    // But for those that another stands for.
    std::vector<std::int32_t> vertex_number(brep.vertices.size(), -1);
    for (const Brep::Edge& edge : brep.edges) vertex_number[edge.from] = vertex_number[edge.to] = 0;
    for (std::size_t v = 0; v < brep.vertices.size(); ++v) {
      if (vertex_number[v] < 0) continue;
      vertex_number[v] = static_cast<std::int32_t>(result.brep.vertices.size());
      result.brep.vertices.push_back(placement.to_model(brep.vertices[v]));
    }
    for (Brep::Edge& edge : brep.edges) {
      edge.from = vertex_number[edge.from];
      edge.to = vertex_number[edge.to];
      if (edge.curve) edge.curve = to_model(*edge.curve, placement);
      for (glm::dvec3& p : edge.points) p = placement.to_model(p);
      for (Brep::Line& line : edge.lines)
        if (line.face >= 0) line.face += first_face;
      result.brep.edges.push_back(std::move(edge));
    }
  }
  for (std::int32_t f = 0; f < topology.face_count(); ++f)
    result.face_of[f] = face_of_part[found.parts.of_face[f]];
  if (mesh.places == VertexPlaces::Samples) result.largest_distance = farthest_sample(mesh, found);
  std::ranges::sort(result.radii);
  result.radii.erase(std::ranges::unique(result.radii).begin(), result.radii.end());
  return result;
}

Brep joined_parts(const Brep& freeform, const AnalyticFaces& analytic, const MeshTopology& topology,
                  std::span<const glm::dvec3> points, std::span<const std::int32_t> analytic_at) {
  const FaceComponents parts = face_components(topology);
  std::vector<std::int32_t> analytic_of(static_cast<std::size_t>(parts.count), -1);
  std::vector<char> is_dropped(freeform.shells.size(), 0);
  std::vector<std::size_t> shell_of(freeform.faces.size());
  for (std::size_t s = 0; s < freeform.shells.size(); ++s)
    for (const std::int32_t f : freeform.shells[s].faces) shell_of[f] = s;
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    for (const std::int32_t v : topology.face(f)) {
      if (analytic_at[v] < 0) continue;
      analytic_of[parts.of_face[f]] = analytic_at[v];
      if (freeform.places[v].face >= 0) is_dropped[shell_of[freeform.places[v].face]] = 1;
    }
  }
  // The analytic faces stand first.
  Brep result = freeform;
  result.vertices = analytic.brep.vertices;
  result.edges = analytic.brep.edges;
  result.faces = analytic.brep.faces;
  const auto first = static_cast<std::int32_t>(result.faces.size());
  std::vector<std::int32_t> face_number(freeform.faces.size(), -1),
      edge_number(freeform.edges.size(), -1), vertex_number(freeform.vertices.size(), -1);
  std::int32_t count = first;
  for (std::size_t f = 0; f < freeform.faces.size(); ++f)
    if (is_dropped[shell_of[f]] == 0) face_number[f] = count++;
  const auto vertex = [&](std::int32_t v) {
    if (vertex_number[v] < 0) {
      vertex_number[v] = static_cast<std::int32_t>(result.vertices.size());
      result.vertices.push_back(freeform.vertices[v]);
    }
    return vertex_number[v];
  };
  for (std::size_t e = 0; e < freeform.edges.size(); ++e) {
    Brep::Edge edge = freeform.edges[e];
    if (face_number[edge.lines[0].face] < 0) continue;
    edge_number[e] = static_cast<std::int32_t>(result.edges.size());
    edge.from = vertex(edge.from);
    edge.to = vertex(edge.to);
    for (Brep::Line& line : edge.lines)
      if (line.face >= 0) line.face = face_number[line.face];
    result.edges.push_back(std::move(edge));
  }
  for (std::size_t f = 0; f < freeform.faces.size(); ++f) {
    if (face_number[f] < 0) continue;
    Brep::Face face = freeform.faces[f];
    for (Brep::Use& use : face.loop) use.edge = edge_number[use.edge];
    result.faces.push_back(std::move(face));
  }
  std::vector<std::int32_t> face_of(static_cast<std::size_t>(topology.face_count()), -1);
  for (Brep::Place& place : result.places) {
    if (place.face < 0) continue;
    const std::int32_t kept =
        analytic.freeform_number.empty() ? -1 : analytic.freeform_number[place.face];
    place.face = kept >= 0 ? kept : face_number[place.face];
  }
  for (std::int32_t f = 0; f < topology.face_count(); ++f) {
    const std::int32_t known = analytic_of[parts.of_face[f]];
    face_of[f] = known >= 0 ? known : result.places[topology.face(f)[0]].face;
  }
  find_shells(topology, points, face_of, result);
  return result;
}

}  // namespace planish
