#include "planish/job/page/page_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "planish/core/point_bounds.h"
#include "planish/files/shared/finite_numbers.h"
#include "planish/job/page/page_coding.h"
#include "planish/mesh/area_vector.h"
#include "planish/mesh/triangulate.h"
#include "planish/surface/vertex_fields.h"

namespace planish {
namespace {

/// A page stores positions on a grid of so many steps along each side of their box.
constexpr double kPositionSteps = 65535;

// Of 99 % of the magnitudes.
double most_of(const std::vector<float>& values) {
  if (values.empty()) return 0;
  std::vector<float> sizes(values.size());
  std::ranges::transform(values, sizes.begin(), [](float x) { return std::abs(x); });
  const auto place = sizes.begin() + static_cast<std::ptrdiff_t>(0.99 * (sizes.size() - 1));
  std::ranges::nth_element(sizes, place);
  return *place;
}

double largest_value(const std::vector<float>& values) {
  double largest = 0;
  for (const float x : values) largest = std::max(largest, std::abs(double{x}));
  return largest;
}

std::vector<float> in_order(const std::vector<float>& values, const PageOrder& order,
                            double factor) {
  std::vector<float> result;
  result.reserve(order.rows.size());
  for (const std::int32_t row : order.rows)
    result.push_back(static_cast<float>(values[row] * factor));
  return result;
}

void add_fields(const VertexFields& fields, double diagonal, PageScene& scene) {
  const auto add = [&](PageField field, const std::vector<float>& values, double factor) {
    field.values = in_order(values, scene.order, factor);
    field.largest = largest_value(field.values);
    field.most = most_of(field.values);
    // Curvature has poles; all else is stored to its largest.
    field.limit = field.kind == FieldKind::Signed ? field.most : field.largest;
    if (field.kind == FieldKind::Share) field.limit = 1;
    if (!(field.limit > 0)) field.limit = 1;
    scene.fields.push_back(std::move(field));
  };
  add({"error", "Interpolation error", "of the diagonal", FieldKind::Amount, {}}, fields.error, 1);
  // Between given vertices the viewer takes means by itself.
  scene.fields.back().values.resize(scene.order.counts[0]);
  add({"deviation", "Normals off the input\u2019s faces", "degrees", FieldKind::Amount, {}},
      fields.normal_deviation, 1);
  add({"fold", "Folded", "of the area around", FieldKind::Share, {}}, fields.folded, 1);
  const std::string source =
      fields.curvature_source == CurvatureSource::Normals ? " from normals" : "";
  add({"mean", "Mean curvature" + source, "1/diagonal", FieldKind::Signed, {}},
      fields.curvatures.mean, diagonal);
  add({"gauss", "Gaussian curvature" + source, "1/diagonal\u00b2", FieldKind::Signed, {}},
      fields.curvatures.gaussian, diagonal * diagonal);
}

// The largest folds, no two near one another.
void add_folds(const PageSceneInput& input, PageScene& scene) {
  constexpr std::size_t kMost = 12;
  constexpr double kApart = 1.0 / 50;  // of the diagonal
  const std::vector<FoldedFace> folded = folded_faces(input.surface, input.mesh);
  scene.folded_faces = folded.size();
  double whole = 0;
  for (std::int64_t f = 0; !folded.empty() && f < input.surface.face_count(); ++f)
    whole += glm::length(area_vector(input.surface.positions, input.surface.face(f)));
  for (const FoldedFace& fold : folded) {
    if (scene.folds.size() == kMost) break;
    const auto corners = input.surface.face(fold.face);
    glm::dvec3 middle(0.0);
    for (const std::int32_t v : corners) middle += input.surface.positions[v];
    middle /= static_cast<double>(corners.size());
    const bool is_new = std::ranges::all_of(scene.folds, [&](const PageFold& other) {
      return glm::distance(other.position, middle) > kApart * input.diagonal;
    });
    if (!is_new) continue;
    const auto face = input.mesh.face(fold.ancestor);
    const glm::dvec3 area = area_vector(input.mesh.positions, face);
    const double length = glm::length(area);
    double size = 0;
    for (std::size_t k = 0; k < face.size(); ++k)
      size = std::max(size, glm::distance(input.mesh.positions[face[k]],
                                          input.mesh.positions[face[(k + 1) % face.size()]]));
    scene.folds.push_back({middle, length > 0 ? area / length : glm::dvec3(0, 0, 1), size,
                           fold.area / whole, fold.ancestor});
  }
}

struct Box {
  glm::dvec3 low, size;
};

Box box_of(std::span<const glm::dvec3> points) {
  const auto [low, high] = point_bounds(points);
  // A flat side needs a size to be divided by.
  constexpr double kFlat = 1e-30;
  return {low, glm::max(high - low, glm::dvec3(kFlat))};
}

nlohmann::ordered_json json_of(const glm::dvec3& v) {
  return nlohmann::ordered_json::array({v.x, v.y, v.z});
}
nlohmann::ordered_json json_of(const Box& box) {
  return {{"low", json_of(box.low)}, {"size", json_of(box.size)}};
}

std::vector<std::uint16_t> quantised(std::span<const glm::dvec3> points, const Box& box) {
  std::vector<std::uint16_t> result;
  result.reserve(3 * points.size());
  for (const glm::dvec3& point : points) {
    for (int k = 0; k < 3; ++k) {
      const double t = (point[k] - box.low[k]) / box.size[k];
      result.push_back(
          static_cast<std::uint16_t>(std::lround(std::clamp(t, 0.0, 1.0) * kPositionSteps)));
    }
  }
  return result;
}

// Unit vectors on an octahedron unfolded to a square (Meyer and others, 2010).
std::vector<std::uint16_t> octahedral(std::span<const glm::vec3> normals) {
  std::vector<std::uint16_t> result;
  result.reserve(2 * normals.size());
  for (const glm::vec3& normal : normals) {
    const glm::dvec3 n(normal);
    const double sum = std::abs(n.x) + std::abs(n.y) + std::abs(n.z);
    double x = n.x / sum, y = n.y / sum;
    if (n.z < 0) {
      const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
      y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
      x = folded;
    }
    for (const double t : {x, y})
      result.push_back(static_cast<std::uint16_t>(std::lround((t * 0.5 + 0.5) * kPositionSteps)));
  }
  return result;
}

// Square roots, since small errors are looked at as well as large ones.
std::vector<std::uint16_t> quantised(const PageField& field, std::size_t count, int width) {
  std::vector<std::uint16_t> result;
  result.reserve(count);
  const double top = width == 1 ? 255 : 65535;
  for (std::size_t i = 0; i < std::min(count, field.values.size()); ++i) {
    const double t = std::min(std::abs(double{field.values[i]}) / field.limit, 1.0);
    double step = std::sqrt(t) * top;
    if (field.kind == FieldKind::Share) step = t * top;
    if (field.kind == FieldKind::Signed)  // 1 to 255, 0 in the middle
      step = 128 + std::copysign(std::sqrt(t) * 127, double{field.values[i]});
    result.push_back(static_cast<std::uint16_t>(std::lround(step)));
  }
  return result;
}

const char* word_of(FieldKind kind) {
  return kind == FieldKind::Amount ? "amount" : kind == FieldKind::Signed ? "signed" : "share";
}

// Both ends of every edge, the lower first; by lower ends, then by differences, which pack well.
struct Edges {
  std::vector<std::int32_t> from, along;
};

Edges edges_of(const PolygonMesh& mesh) {
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    const auto face = mesh.face(f);
    for (std::size_t k = 0; k < face.size(); ++k)
      pairs.emplace_back(std::minmax(face[k], face[(k + 1) % face.size()]));
  }
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  Edges edges;
  for (const auto& [low, high] : pairs) {
    edges.from.push_back(low);
    edges.along.push_back(high - low);
  }
  return edges;
}

// Faces of level 0 as the viewer builds everything from them.
void add_topology(const PageScene& scene, int level, PageCoder& coder) {
  const PageOrder& order = scene.order;
  std::vector<std::int32_t> sizes, names, triangles;
  for (std::size_t f = 0; f < order.faces.face_count(); ++f) {
    const auto face = order.faces.face(f);
    sizes.push_back(static_cast<std::int32_t>(face.size()));
    if (face.size() <= 4) continue;  // the viewer cuts those by itself
    std::vector<std::int32_t> numbers(face.size());
    std::iota(numbers.begin(), numbers.end(), 0);
    std::vector<glm::dvec3> corners;
    for (const std::int32_t v : face) corners.push_back(scene.positions[v]);
    std::vector<std::uint32_t> cut(3 * (face.size() - 2));
    triangulate(numbers, corners, cut);
    triangles.insert(triangles.end(), cut.begin(), cut.end());
  }
  for (const std::int32_t source : order.sources) names.push_back(scene.file_vertices[source]);
  coder.add_list("sizes", sizes);
  coder.add_list("corners", order.faces.vertices);
  coder.add_list("triangles", triangles);
  coder.add_list("names", names);
  for (int l = 0; l < level; ++l) coder.add_list("cuts" + std::to_string(l), order.splits[l].cuts);
}

nlohmann::ordered_json add_fields(const PageScene& scene, std::size_t count, PageCoder& coder) {
  nlohmann::ordered_json fields = nlohmann::ordered_json::array();
  for (const PageField& field : scene.fields) {
    // Errors are read by vertex, so they are worth two bytes.
    const int width = field.name == "error" ? 2 : 1;
    coder.add_values(field.name, quantised(field, count, width), width, 1, scene.order);
    fields.push_back({{"name", field.name},
                      {"label", field.label},
                      {"unit", field.unit},
                      {"kind", word_of(field.kind)},
                      {"limit", field.limit},
                      {"largest", field.largest},
                      {"most", field.most}});
  }
  return fields;
}

// Where the texture is, for a board of squares on it. Returns its box.
nlohmann::ordered_json add_uvs(const PageScene& scene, int level, PageCoder& coder) {
  const PageOrder& order = scene.uv_order;
  const std::span uvs(scene.uvs.data(), order.counts[level]);
  std::vector<glm::dvec3> places;
  for (const glm::dvec2& uv : uvs) places.emplace_back(uv, 0.0);
  const Box box = box_of(places);
  std::vector<std::uint16_t> values;
  for (const glm::dvec3& place : places)
    for (int k = 0; k < 2; ++k)
      values.push_back(static_cast<std::uint16_t>(
          std::lround((place[k] - box.low[k]) / box.size[k] * kPositionSteps)));
  coder.add_list("uv_corners", order.faces.vertices);
  for (int l = 0; l < level; ++l)
    coder.add_list("uv_cuts" + std::to_string(l), order.splits[l].cuts);
  coder.add_values("uv", values, 2, 2, order);
  return json_of(box);
}

nlohmann::ordered_json folds_json(const PageScene& scene) {
  nlohmann::ordered_json folds = nlohmann::ordered_json::array();
  for (const PageFold& fold : scene.folds) {
    folds.push_back({{"position", json_of(fold.position)},
                     {"direction", json_of(fold.direction)},
                     {"size", fold.size},
                     {"area", fold.area},
                     {"face", fold.face}});
  }
  return folds;
}

}  // namespace

PageScene make_page_scene(const PageSceneInput& input) {
  const std::string name = "page";
  require_finite(std::span<const glm::dvec3>(input.surface.positions), 0, "vertex", name);
  require_finite(std::span<const glm::vec3>(input.surface.normals), 0, "the normal of vertex",
                 name);
  require_finite(std::span<const glm::dvec3>(input.cage.positions), 0, "control point", name);
  PageScene scene;
  {
    // Before the order, so that what both take on the way is not held at once.
    const VertexFields fields =
        vertex_fields(input.surface, input.mesh, input.diagonal, input.exact);
    scene.order = page_order(input.surface, input.mesh);
    add_fields(fields, input.diagonal, scene);
  }
  scene.diagonal = input.diagonal;
  scene.positions.reserve(scene.order.rows.size());
  scene.normals.reserve(scene.order.rows.size());
  for (const std::int32_t row : scene.order.rows) {
    scene.positions.push_back(input.surface.positions[row]);
    scene.normals.push_back(input.surface.normals[row]);
  }
  if (!input.mesh.face_uvs.empty() && std::ranges::min(input.mesh.face_uvs) >= 0) {
    require_finite(std::span<const glm::dvec2>(input.surface.uvs), 0, "texture coordinate", name);
    scene.uv_order = texture_order(input.surface, input.mesh);
    for (const std::int32_t row : scene.uv_order.rows) scene.uvs.push_back(input.surface.uvs[row]);
  }
  if (input.surface.level > 0) add_folds(input, scene);
  scene.cage = input.cage;
  scene.file_vertices.resize(input.mesh.positions.size());
  std::iota(scene.file_vertices.begin(), scene.file_vertices.end(), 0);
  if (!input.file_vertices.empty())
    scene.file_vertices.assign(input.file_vertices.begin(), input.file_vertices.end());
  const auto& sources = scene.order.sources;
  const auto worst = std::ranges::find(sources, input.worst_vertex);
  if (worst != sources.end()) scene.worst = static_cast<std::int32_t>(worst - sources.begin());
  if (scene.fields[0].largest * input.diagonal * kPositionSteps >
      glm::length(box_of(scene.positions).size)) {
    for (const std::int32_t vertex : sources) scene.given.push_back(input.mesh.positions[vertex]);
  }
  return scene;
}

PagePayload encode_scene(const PageScene& scene, int level) {
  const PageOrder& order = scene.order;
  const std::size_t count = order.counts[level];
  const PageOrder none;
  PageCoder coder;
  add_topology(scene, level, coder);
  const std::span positions(scene.positions.data(), count);
  const Box box = box_of(positions), cage_box = box_of(scene.cage.positions),
            given_box = box_of(scene.given);
  coder.add_values("position", quantised(positions, box), 2, 3, order);
  coder.add_values("normal", octahedral({scene.normals.data(), count}), 2, 2, order);
  const nlohmann::ordered_json fields = add_fields(scene, count, coder);
  coder.add_values("cage", quantised(scene.cage.positions, cage_box), 2, 3, none);
  nlohmann::ordered_json uv_box;
  if (!scene.uvs.empty()) uv_box = add_uvs(scene, level, coder);
  const Edges edges = edges_of(scene.cage);
  coder.add_list("cage_from", edges.from);
  coder.add_list("cage_along", edges.along);
  if (!scene.given.empty())
    coder.add_values("given", quantised(scene.given, given_box), 2, 3, none);

  PagePayload payload;
  payload.level = level;
  payload.head = {{"level", level},
                  {"split", order.triangles ? "triangles" : "quads"},
                  {"base", order.counts[0]},
                  {"diagonal", scene.diagonal},
                  {"box", json_of(box)},
                  {"cage_box", json_of(cage_box)},
                  {"given_box", json_of(given_box)},
                  {"worst", scene.worst},
                  {"folded_faces", scene.folded_faces},
                  {"folds", folds_json(scene)},
                  {"fields", fields},
                  {"sections", coder.sections()}};
  if (!scene.uvs.empty()) {
    payload.head["uv_base"] = scene.uv_order.counts[0];
    payload.head["uv_box"] = uv_box;
  }
  payload.packed = coder.base64();
  return payload;
}

}  // namespace planish
