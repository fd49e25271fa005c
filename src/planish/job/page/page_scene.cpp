#include "planish/job/page/page_scene.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <new>
#include <numeric>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>

#include "planish/core/guards.h"
#include "planish/core/parallel.h"
#include "planish/core/vectors.h"
#include "planish/files/writers.h"
#include "planish/measure/vertex_fields.h"
#include "planish/mesh/face_geometry.h"
#include "planish/mesh/mesh_parts.h"

namespace planish {
namespace {

std::uint64_t edge_hash(std::int32_t a, std::int32_t b) {
  const auto low = static_cast<std::uint64_t>(std::min(a, b));
  // The constants are those of the splitmix64 generator.
  std::uint64_t hash = static_cast<std::uint64_t>(std::max(a, b)) << 32 | low;
  hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9u;
  hash = (hash ^ hash >> 27) * 0x94d049bb133111ebu;
  return hash ^ hash >> 31;
}

// Level 0: given vertices keep their numbers, a vertex's further rows follow as copies.
void start(PageOrder& order, const LevelFaces& faces, const SurfaceMesh& surface,
           const PolygonMesh& mesh) {
  const auto given = static_cast<std::int32_t>(surface.base_vertices.size());
  for (std::int32_t v = 0; v < given; ++v) order.rows.push_back(v);
  order.sources = surface.base_vertices;
  order.faces.offsets = faces.offsets;
  const std::vector<std::uint8_t> is_hole = hole_flags(mesh);
  std::vector<std::int32_t> corners;  // the mesh's vertices of the faces that are seen
  for (std::int32_t f = 0; f < mesh.face_count(); ++f) {
    if (is_hole[f] != 0) continue;
    corners.insert(corners.end(), mesh.face(f).begin(), mesh.face(f).end());
  }
  PLANISH_ASSERT(corners.size() == faces.vertices.size());
  std::unordered_map<std::int32_t, std::int32_t> copy_of_row;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const std::int32_t row = faces.vertices[i];
    std::int32_t vertex = row;
    if (row >= given) {
      const auto next = static_cast<std::int32_t>(order.rows.size());
      const auto [found, fresh] = copy_of_row.try_emplace(row, next);
      if (fresh) {
        order.rows.push_back(row);
        order.sources.push_back(corners[i]);
      }
      vertex = found->second;
    }
    order.faces.vertices.push_back(vertex);
  }
  order.counts.push_back(order.rows.size());
}

// One split: `faces` in page vertices becomes the next level's.
class Splitter {
 public:
  Splitter(PageOrder& order, const LevelFaces& faces, const LevelFaces& fine)
      : order_(order),
        faces_(faces),
        fine_(fine),
        edges_(std::bit_ceil(faces.vertices.size() + 1), -1) {}

  LevelFaces run() {
    if (!order_.triangles) add_middles();
    LevelFaces next;
    next.offsets = fine_.offsets;
    next.vertices.resize(fine_.vertices.size());
    std::size_t child = 0;
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      const std::size_t n = faces_.face(f).size();
      connect(f, child, next);
      child += order_.triangles ? 4 : n;
    }
    order_.counts.push_back(order_.rows.size());
    return next;
  }

 private:
  std::int32_t add_vertex(std::int32_t row, std::span<const std::int32_t> parents) {
    PageSplit& split = order_.splits.back();
    split.parents.insert(split.parents.end(), parents.begin(), parents.end());
    split.parent_offsets.push_back(static_cast<std::int32_t>(split.parents.size()));
    order_.rows.push_back(row);
    return static_cast<std::int32_t>(order_.rows.size()) - 1;
  }

  void add_middles() {
    std::size_t child = 0;
    for (std::size_t f = 0; f < faces_.face_count(); ++f) {
      const auto face = faces_.face(f);
      const auto corners = fine_.face(child);
      (void)add_vertex(corners[child_corners(face.size(), 4, 0).middle], face);
      child += face.size();
    }
  }

  // Whether a new vertex is that of the edge between two.
  [[nodiscard]] bool halves(std::int32_t vertex, std::int32_t a, std::int32_t b) const {
    const PageSplit& split = order_.splits.back();
    const auto first = static_cast<std::size_t>(
        split.parent_offsets[static_cast<std::size_t>(vertex) - order_.counts.back()]);
    const std::int32_t p = split.parents[first], q = split.parents[first + 1];
    return (p == a && q == b) || (p == b && q == a);
  }

  // The vertex of the edge that begins at a corner.
  std::int32_t edge_vertex(std::size_t corner, std::int32_t a, std::int32_t b, std::int32_t row) {
    const std::size_t mask = edges_.size() - 1;
    std::size_t slot = edge_hash(a, b) & mask;
    while (edges_[slot] >= 0 && !halves(edges_[slot], a, b)) slot = (slot + 1) & mask;
    const std::int32_t found = edges_[slot];
    if (found >= 0 && order_.rows[found] == row) return found;
    const std::int32_t vertex = add_vertex(row, std::array{a, b});
    if (found < 0) {
      edges_[slot] = vertex;
    } else {
      order_.splits.back().cuts.push_back(static_cast<std::int32_t>(corner));
    }
    return vertex;
  }

  void connect(std::size_t f, std::size_t child, LevelFaces& next) {
    const auto face = faces_.face(f);
    const std::size_t n = face.size();
    edge_of_corner_.resize(n);
    for (std::size_t k = 0; k < n; ++k) {
      const auto corners = fine_.face(child + k);
      const ChildCorners at = child_corners(n, corners.size(), static_cast<int>(k));
      edge_of_corner_[k] =
          edge_vertex(faces_.offsets[f] + k, face[k], face[(k + 1) % n], corners[at.edge]);
    }
    const auto first_middle = static_cast<std::int32_t>(order_.counts.back());
    for (std::size_t k = 0; k < n; ++k) {
      const std::int32_t offset = fine_.offsets[child + k];
      const int m = order_.triangles ? 3 : 4;
      const ChildCorners at = child_corners(n, static_cast<std::size_t>(m), static_cast<int>(k));
      next.vertices[offset + at.corner] = face[k];
      next.vertices[offset + at.edge] = edge_of_corner_[k];
      next.vertices[offset + (at.corner + m - 1) % m] = edge_of_corner_[(k + n - 1) % n];
      if (at.middle >= 0)
        next.vertices[offset + at.middle] = first_middle + static_cast<std::int32_t>(f);
    }
    if (!order_.triangles) return;
    // The child in the middle has the edges' points, wherever its first corner lies.
    const auto middle = fine_.face(child + 3);
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t e = 0; e < 3; ++e) {
        if (order_.rows[edge_of_corner_[e]] == middle[k])
          next.vertices[fine_.offsets[child + 3] + k] = edge_of_corner_[e];
      }
    }
  }

  PageOrder& order_;
  const LevelFaces& faces_;
  const LevelFaces& fine_;
  // By hash of the ends, the next free place: the first vertex of each edge; -1: none. There are no
  // more edges than corners.
  std::vector<std::int32_t> edges_;
  std::vector<std::int32_t> edge_of_corner_;  // of the face at hand
};

}  // namespace

PageOrder page_order(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  const std::vector<LevelFaces> levels = level_faces(surface, mesh);
  PageOrder order;
  order.triangles = surface.is_triangles();
  start(order, levels[0], surface, mesh);
  LevelFaces faces = order.faces;
  for (std::size_t l = 1; l < levels.size(); ++l) {
    order.splits.emplace_back();
    LevelFaces next = Splitter(order, faces, levels[l]).run();
    for (std::size_t i = 0; i < next.vertices.size(); ++i)
      PLANISH_ASSERT(order.rows[next.vertices[i]] == levels[l].vertices[i]);
    faces = std::move(next);
  }
  return order;
}

PageOrder texture_order(const SurfaceMesh& surface, const PolygonMesh& mesh) {
  SurfaceMesh charts;
  charts.level = surface.level;
  charts.face_offsets = surface.face_offsets;
  charts.face_vertices = surface.face_uvs;
  return page_order(charts, mesh);
}

namespace {

std::uint64_t zigzag(std::int64_t difference) {
  return static_cast<std::uint64_t>(difference) << 1 ^ static_cast<std::uint64_t>(difference >> 63);
}

// The difference of two numbers that wraps at 2^(8 width), in the half of its range around 0.
std::int64_t wrapped(std::int64_t difference, int width) {
  const std::int64_t range = std::int64_t{1} << (8 * width);
  difference &= range - 1;
  return difference < range / 2 ? difference : difference - range;
}

// A piece of a raw deflate stream, ending at a whole byte; `before`: what the stream holds so far.
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> before,
                                   std::span<const std::uint8_t> bytes, bool is_last) {
  // Level 9 takes four times as long for one byte in a hundred.
  constexpr int kLevel = 6, kRawDeflate = -15, kMemory = 9;
  constexpr std::size_t kWindow = std::size_t{1} << 15;
  z_stream stream{};
  if (deflateInit2(&stream, kLevel, Z_DEFLATED, kRawDeflate, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
  const auto window = before.last(std::min(kWindow, before.size()));
  deflateSetDictionary(&stream, window.data(), static_cast<uInt>(window.size()));
  // zlib's bound is that of a last piece: a flush adds five bytes at most.
  std::vector<std::uint8_t> packed(deflateBound(&stream, static_cast<uLong>(bytes.size())) + 16);
  stream.next_in = const_cast<Bytef*>(bytes.data());
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = packed.data();
  stream.avail_out = static_cast<uInt>(packed.size());
  const int state = deflate(&stream, is_last ? Z_FINISH : Z_SYNC_FLUSH);
  PLANISH_ASSERT(state == (is_last ? Z_STREAM_END : Z_OK) && stream.avail_in == 0);
  packed.resize(packed.size() - stream.avail_out);
  packed.shrink_to_fit();  // all pieces are held at once
  deflateEnd(&stream);
  return packed;
}

}  // namespace

void PageCoder::begin(const std::string& name, std::size_t count, int width, int components) {
  sections_.push_back({{"name", name},
                       {"count", count},
                       {"width", width},
                       {"components", components},
                       {"offset", bytes_.size()}});
  bytes_.resize(bytes_.size() + count * static_cast<std::size_t>(width * components));
}

void PageCoder::put(std::size_t plane, std::size_t count, std::size_t i, int width,
                    std::int64_t difference) {
  const std::uint64_t code = zigzag(wrapped(difference, width));
  for (int b = 0; b < width; ++b)
    bytes_[plane + static_cast<std::size_t>(b) * count + i] =
        static_cast<std::uint8_t>(code >> (8 * b));
}

void PageCoder::add_list(const std::string& name, std::span<const std::int32_t> values) {
  constexpr int kBytes = 4;
  const std::size_t plane = bytes_.size();
  begin(name, values.size(), kBytes, 1);
  std::int64_t last = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    put(plane, values.size(), i, kBytes, values[i] - last);
    last = values[i];
  }
}

void PageCoder::add_values(const std::string& name, std::span<const std::uint16_t> values,
                           int width, int components, const PageOrder& order) {
  const std::size_t count = values.size() / static_cast<std::size_t>(components);
  std::size_t plane = bytes_.size();
  begin(name, count, width, components);
  for (int c = 0; c < components; ++c) {
    const auto value = [&](std::size_t i) {
      return static_cast<std::int64_t>(
          values[i * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)]);
    };
    std::int64_t last = 0;
    const std::size_t first = std::min(count, order.counts.empty() ? count : order.counts[0]);
    for (std::size_t i = 0; i < first; ++i) {
      put(plane, count, i, width, value(i) - last);
      last = value(i);
    }
    for (std::size_t l = 0; l < order.splits.size(); ++l) {
      const PageSplit& split = order.splits[l];
      for (std::size_t i = order.counts[l]; i < std::min(count, order.counts[l + 1]); ++i) {
        const std::size_t k = i - order.counts[l];
        const std::int32_t begin = split.parent_offsets[k], end = split.parent_offsets[k + 1];
        std::int64_t sum = 0;
        for (std::int32_t p = begin; p < end; ++p)
          sum += value(static_cast<std::size_t>(split.parents[p]));
        const std::int64_t n = end - begin;
        put(plane, count, i, width, value(i) - (2 * sum + n) / (2 * n));
      }
    }
    plane += count * static_cast<std::size_t>(width);
  }
}

std::string PageCoder::base64() const {
  constexpr std::size_t kPiece = std::size_t{1} << 20;
  const std::size_t count = std::max<std::size_t>((bytes_.size() + kPiece - 1) / kPiece, 1);
  std::vector<std::vector<std::uint8_t>> pieces(count);
  parallel_each(count, 1, [&](std::size_t i) {
    const std::size_t first = i * kPiece, length = std::min(kPiece, bytes_.size() - first);
    pieces[i] =
        deflated(std::span(bytes_).first(first), {bytes_.data() + first, length}, i + 1 == count);
  });
  std::vector<std::uint8_t> packed;
  for (const auto& piece : pieces) packed.insert(packed.end(), piece.begin(), piece.end());
  return base64_text(packed);
}

std::string base64_text(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = std::uint32_t{bytes[i]} << 16;
    if (left > 1) word |= std::uint32_t{bytes[i + 1]} << 8;
    if (left > 2) word |= bytes[i + 2];
    text += kDigits[word >> 18];
    text += kDigits[word >> 12 & 63];
    text += left > 1 ? kDigits[word >> 6 & 63] : '=';
    text += left > 2 ? kDigits[word & 63] : '=';
  }
  return text;
}

namespace {

// A page stores positions on a grid of so many steps along each side of their box.
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

Box bounds_of(std::span<const glm::dvec3> points) {
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
  const Box box = bounds_of(places);
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
      glm::length(bounds_of(scene.positions).size)) {
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
  const Box box = bounds_of(positions), cage_box = bounds_of(scene.cage.positions),
            given_box = bounds_of(scene.given);
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
