// Based on: Khronos Group, "glTF 2.0 Specification", section 3.7 (meshes).
#include "planish/files/gltf/scene_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/matrix.hpp>
#include <optional>

#include "planish/core/counted.h"
#include "planish/core/error.h"
#include "planish/core/number_text.h"
#include "planish/core/stop.h"
#include "planish/files/gltf/asset/replaced_geometry.h"
#include "planish/files/gltf/draco_stream.h"
#include "planish/files/gltf/gltf_accessor.h"
#include "planish/files/gltf/gltf_materials.h"

namespace planish {
namespace {

// A few bytes of nodes can place any number of them.
constexpr std::int64_t kMaxPrimitives = std::int64_t{1} << 20;

// Extensions that change nothing about the triangles, are read, or are seen to where an asset is
// written; any other that a file requires is refused. One list, so that whatever is fitted can be
// inspected.
constexpr std::array<std::string_view, 16> kReadExtensions = {"KHR_materials_",
                                                              "KHR_texture_",
                                                              "EXT_texture_",
                                                              "KHR_lights_",
                                                              "KHR_mesh_quantization",
                                                              "EXT_meshopt_compression",
                                                              "EXT_mesh_gpu_instancing",
                                                              "KHR_animation_pointer",
                                                              "KHR_node_",
                                                              "KHR_xmp_json_ld",
                                                              "MSFT_lod",
                                                              "KHR_interactivity",
                                                              "MSFT_texture_dds",
                                                              kNgonExtension,
                                                              "EXT_mesh_features",
                                                              "EXT_structural_metadata"};

// A file may say which version its reader must know at least.
void require_known_version(const JsonPlace& least) {
  constexpr double kKnown = 2.0;
  double number = 0;
  if (!parse_number(least.text(), number)) least.fail(quote(least.text()) + " is no version");
  if (number > kKnown)
    least.fail("the file needs a reader of glTF {}, and 2.0 is read; save it as glTF 2.0",
               least.text());
}

bool encodes_polygons(const JsonPlace& primitive) {
  const auto extensions = primitive.find("extensions");
  return extensions && extensions->is_object() && extensions->find(kNgonExtension);
}

}  // namespace

void require_gltf_version(const JsonPlace& root) {
  const JsonPlace asset = root["asset"], version = asset["version"];
  if (!version.text().starts_with("2.")) version.fail(quote(version.text()) + " is not 2.x");
  if (const auto least = asset.find("minVersion")) require_known_version(*least);
  const auto required = root.find("extensionsRequired");
  for (std::int64_t i = 0; required && i < required->array_size(); ++i) {
    const std::string_view extension = (*required)[i].text();
    const bool is_read = std::ranges::any_of(
        kReadExtensions, [&](std::string_view known) { return extension.starts_with(known); });
    if (!is_read && !(reads_draco() && extension == kDracoExtension))
      (*required)[i].fail(quote(extension) + " cannot be read; save the file without it");
  }
}

MeshFile SceneReader::read(FileFormat format) {
  const GltfScene scene = gltf_scene(root_, source_);
  if (scene.hidden_count > 0)
    file_.warnings.push_back(
        {.code = "hidden-nodes",
         .message =
             formatted("{} that the file hides (KHR_node_visibility) {} left out",
                       counted(scene.hidden_count, "mesh"), scene.hidden_count == 1 ? "is" : "are"),
         .count = scene.hidden_count});
  if (auto warning = empty_scene_warning(root_)) file_.warnings.push_back(*std::move(warning));
  return read(format, scene.instances);
}

MeshFile SceneReader::read_mesh(FileFormat format, std::int64_t mesh, AssetCollector& asset) {
  constexpr std::int64_t kNoNode = -1;
  asset_ = &asset;
  const GltfInstance itself{mesh, kNoNode, glm::dmat4(1.0)};
  return read(format, {&itself, 1});
}

MeshFile SceneReader::read(FileFormat format, std::span<const GltfInstance> instances) {
  for (const GltfInstance& instance : instances) read_instance(instance, bytes_ / instances.size());
  file_.format = format;
  triangles_.finish(welder_, file_);
  attributes_.finish(std::move(uvs_), file_.mesh);
  if (file_.mesh.face_count() == 0 && !points_.empty()) {
    points_.finish(file_);
  } else {
    file_.dropped_element_count += point_primitive_count_;
  }
  if (creases_from_normals_) mark_split_normals(file_.mesh, normals_);
  if (shared_count_ > 0 && asset_ == nullptr)
    file_.warnings.push_back(
        {.code = "shared-attributes",
         .message = formatted("{} of {} {} another colour at a place they share: there the first "
                              "one's is taken",
                              with_separators(shared_count_), counted(colored_count_, "vertex"),
                              shared_count_ == 1 ? "has" : "have"),
         .count = shared_count_,
         .first = first_shared_});
  if (!lost_of_points_.empty() && file_.mesh.face_count() == 0) {
    std::string names;
    for (const std::string& name : lost_of_points_) names += (names.empty() ? "" : ", ") + name;
    file_.warnings.push_back({.code = "left-out-attributes",
                              .message = "left out of the points: " + names +
                                         "; the mesh that is made of them has normals and colours",
                              .count = std::ssize(lost_of_points_)});
  }
  if (deformed_count_ > 0)
    file_.warnings.push_back({.code = "ignored-deformation",
                              .message = "skins and morph targets move the mesh no more: it is "
                                         "read as the file's nodes pose it, at rest",
                              .count = deformed_count_});
  return std::move(file_);
}

// Where the same bytes are placed often, or only some of them, each place has an equal share of
// the file's.
void SceneReader::read_instance(const GltfInstance& instance, std::size_t bytes) {
  const JsonPlace mesh = root_["meshes"][instance.mesh];
  joints_.clear();
  const auto skin = asset_ == nullptr ? root_["nodes"][instance.node].find("skin") : std::nullopt;
  if (skin) {
    ++deformed_count_;
    joints_ = joint_matrices(root_, skin->integer(), source_);
  }
  const JsonPlace primitives = mesh["primitives"];
  for (std::int64_t i = 0; i < primitives.array_size(); ++i) {
    if (++primitive_count_ > kMaxPrimitives)
      primitives.fail("the scene places more than {} primitives", kMaxPrimitives);
    read_primitive(primitives[i], instance,
                   bytes / static_cast<std::size_t>(primitives.array_size()));
  }
}

void SceneReader::read_primitive(const JsonPlace& place, const GltfInstance& instance,
                                 std::size_t bytes) {
  constexpr std::int64_t kPoints = 0, kTriangles = 4, kFan = 6;
  constexpr std::int64_t kPiece = 4096;  // corners
  const std::int64_t mode = place.integer_or("mode", kTriangles);
  if (mode > kFan) place["mode"].fail("{} is no mode of primitives", mode);
  const bool has_positions = place["attributes"].find("POSITION").has_value();
  if (mode == kPoints && has_positions && asset_ == nullptr)
    return read_point_primitive(place, instance);
  if (mode < kTriangles || !has_positions) {
    if (asset_ == nullptr) ++file_.dropped_element_count;
    return;
  }
  if (asset_ == nullptr && place.find("targets")) ++deformed_count_;
  const SourcePrimitive primitive(root_, place, source_);
  const std::optional<GltfAccessor> indices = primitive.indices();
  const std::int64_t vertex_count = primitive.positions().count();
  const std::int64_t count = indices ? indices->count() : vertex_count;
  // Fewer corners than a triangle has, as exporters leave of an empty mesh.
  if (count < 3) {
    if (asset_ == nullptr) ++file_.dropped_element_count;
    return;
  }
  budget_.add_triangles(place, vertex_count, count * (mode == kTriangles ? 1 : 3));
  if (stamps_.size() < static_cast<std::size_t>(vertex_count)) {
    stamps_.resize(static_cast<std::size_t>(vertex_count), 0);
    welded_vertices_.resize(stamps_.size());
  }
  ++stamp_;
  if (asset_ != nullptr) asset_->begin_primitive(place, primitive, budget_);
  joint_sets_.clear();
  if (!joints_.empty()) joint_sets_ = primitive.joint_sets();
  corners_.resize(static_cast<std::size_t>(count));
  vertices_.resize(corners_.size());
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t vertex = indices ? indices->index(i) : i;
    if (vertex >= vertex_count)
      place["indices"].fail("entry {} names vertex {} of {}", i, vertex, vertex_count);
    corners_[i] = static_cast<std::int32_t>(vertex);
    vertices_[i] = welded(primitive, vertex, instance);
    if ((i + 1) % kPiece != 0) continue;
    check_stop();
    count_read(progress_,
               bytes * static_cast<std::size_t>(kPiece) / static_cast<std::size_t>(count));
  }
  find_faces(place, mode, glm::determinant(glm::dmat3(placed(0, instance).to_world)) < 0);
  if (faces_.count() == 0) return;
  if (asset_ != nullptr) {
    const AssetCollector::Faces faces{triangles_.mesh(), faces_, corners_, vertices_};
    if (asset_->add_layer(faces, uvs_)) return;
    const int group = asset_->add_faces(faces, uvs_);
    attributes_.use_group({.name = std::to_string(group), .material = ""});
    first_uv_ = asset_->first_number();
  } else {
    name_group(place);
    read_uvs(place, primitive);
  }
  if (creases_from_normals_) read_normals(primitive, instance);
  color_vertices(primitive);
  add_faces();
}

// Where a vertex of the current primitive stands. The place of a node with a skin means nothing.
GltfInstance SceneReader::placed(std::int64_t vertex, const GltfInstance& instance) const {
  if (joint_sets_.empty()) return instance;
  return {instance.mesh, instance.node, posed(joint_sets_, vertex, joints_)};
}

void SceneReader::name_group(const JsonPlace& place) {
  FaceGroup group;
  if (const auto material = place.find("material")) {
    const std::int64_t number = material->integer();
    (void)root_["materials"][number];
    if (material_names_.empty()) material_names_ = material_names(root_);
    group.material = material_names_[number];
  }
  if (const auto extras = place.find("extras"); extras && extras->is_object()) {
    if (const auto name = extras->find("group"); name && name->is_text()) group.name = name->text();
  }
  attributes_.use_group(std::move(group));
}

// Appended for the whole primitive; OBJ's v runs upwards, glTF's down.
void SceneReader::read_uvs(const JsonPlace& place, const SourcePrimitive& primitive) {
  first_uv_ = -1;
  const auto uvs = primitive.attribute("TEXCOORD_0", GltfAccessor::Use::TextureCoordinates);
  if (!uvs) return;
  const JsonPlace attribute = place["attributes"]["TEXCOORD_0"];
  budget_.add_uvs(attribute, uvs->count());
  first_uv_ = static_cast<std::int64_t>(uvs_.size());
  for (std::int64_t i = 0; i < uvs->count(); ++i) {
    const glm::dvec2 uv = uvs->texture_coordinate(i);
    if (!std::isfinite(uv.x) || !std::isfinite(uv.y))
      attribute.fail("the texture coordinate of vertex {} is not finite", i);
    uvs_.emplace_back(uv.x, 1.0 - uv.y);
  }
}

void SceneReader::read_normals(const SourcePrimitive& primitive, const GltfInstance& instance) {
  first_normal_ = -1;
  const auto normals = primitive.attribute("NORMAL", GltfAccessor::Use::Normals);
  if (!normals) return;
  budget_.add_normals(root_["meshes"], normals->count());
  first_normal_ = static_cast<std::int64_t>(normals_.values.size());
  for (std::int64_t i = 0; i < normals->count(); ++i)
    normals_.values.emplace_back(placed_normal(normals->position(i), placed(i, instance)));
}

void SceneReader::color_vertices(const SourcePrimitive& primitive) {
  const auto colors = primitive.attribute("COLOR_0", GltfAccessor::Use::Colors);
  if (!colors) return;
  std::vector<bool> differs(static_cast<std::size_t>(colors->count()), false);
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    if (attributes_.color_vertex(vertices_[i], primitive.color(*colors, corners_[i]))) continue;
    differs[corners_[i]] = true;
    if (first_shared_ < 0) first_shared_ = vertices_[i];
  }
  colored_count_ += colors->count();
  shared_count_ += std::ranges::count(differs, true);
}

// All vertices: indices would only leave some out, or name some twice.
void SceneReader::read_point_primitive(const JsonPlace& place, const GltfInstance& instance) {
  const SourcePrimitive primitive(root_, place, source_);
  ++point_primitive_count_;
  budget_.add_points(place, primitive.positions().count());
  points_.add(primitive, instance);
  if (place.find("material")) lost_of_points_.insert("material");
  for (const std::string& name : place["attributes"].keys())
    if (name != "POSITION" && name != "NORMAL" && name != "COLOR_0") lost_of_points_.insert(name);
}

std::int32_t SceneReader::welded(const SourcePrimitive& primitive, std::int64_t vertex,
                                 const GltfInstance& instance) {
  const auto slot = static_cast<std::size_t>(vertex);
  if (stamps_[slot] != stamp_) {
    stamps_[slot] = stamp_;
    const glm::dvec3 position = primitive.position(vertex, placed(vertex, instance));
    welded_vertices_[slot] =
        asset_ != nullptr ? asset_->weld(welder_, position, vertex) : welder_.insert(position);
  }
  return welded_vertices_[slot];
}

void SceneReader::add_faces() {
  const auto numbered = [&](std::int64_t first, std::int32_t corner) {
    return first < 0 ? -1 : static_cast<std::int32_t>(first + corners_[corner]);
  };
  std::vector<std::int32_t> face;
  for (std::size_t f = 0; f < faces_.count(); ++f) {
    face.clear();
    for (const std::int32_t corner : faces_.face(f)) {
      face.push_back(vertices_[corner]);
      attributes_.add_corner(numbered(first_uv_, corner));
      if (creases_from_normals_) normals_.of_corners.push_back(numbered(first_normal_, corner));
    }
    triangles_.add_polygon(face);
  }
  attributes_.add_faces(faces_.count());
}

void SceneReader::find_faces(const JsonPlace& place, std::int64_t mode, bool mirrored) {
  constexpr std::int64_t kTriangles = 4, kStrip = 5;
  faces_.clear();
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
    // A mirror turns front faces into back faces.
    if (mirrored) std::swap(b, c);
    if (triangles_.has_area(vertices_[a], vertices_[b], vertices_[c]))
      faces_.add(std::array{static_cast<std::int32_t>(a), static_cast<std::int32_t>(b),
                            static_cast<std::int32_t>(c)});
  };
  if (mode == kTriangles) {
    if (vertices_.size() % 3 != 0)
      place.fail("{} corners make no whole triangles", vertices_.size());
    if (encodes_polygons(place)) return find_polygons(mirrored);
    for (std::size_t i = 0; i < vertices_.size(); i += 3) add(i, i + 1, i + 2);
    return;
  }
  for (std::size_t i = 0; i + 2 < vertices_.size(); ++i) {
    if (mode == kStrip) {
      add(i, i + 1 + i % 2, i + 2 - i % 2);
    } else {
      add(i + 1, i + 2, 0);
    }
  }
}

// FB_ngon_encoding: the triangles of a polygon follow each other, a fan around its first corner.
// Where they are none, as of a writer that did not know the extension, each stays a triangle.
void SceneReader::find_polygons(bool mirrored) {
  std::vector<std::int32_t> polygon;  // corners
  polygon_of_.resize(static_cast<std::size_t>(welder_.count()), 0);
  const auto extend = [&](std::size_t corner) {
    polygon.push_back(static_cast<std::int32_t>(corner));
    polygon_of_[vertices_[corner]] = polygon_number_;
  };
  const auto end = [&] {
    if (polygon.empty()) return;
    if (mirrored) std::reverse(polygon.begin() + 1, polygon.end());
    faces_.add(polygon);
    polygon.clear();
  };
  for (std::size_t i = 0; i < vertices_.size(); i += 3) {
    if (!triangles_.has_area(vertices_[i], vertices_[i + 1], vertices_[i + 2])) continue;
    const bool goes_on = !polygon.empty() && corners_[i] == corners_[polygon.front()] &&
                         vertices_[i + 1] == vertices_[polygon.back()] &&
                         polygon_of_[vertices_[i + 2]] != polygon_number_;
    if (!goes_on) {
      end();
      ++polygon_number_;
      extend(i);
      extend(i + 1);
    }
    extend(i + 2);
  }
  end();
}

}  // namespace planish
