#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/files/shared/group_list.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Gathers what rides on a mesh while a reader adds corners and faces to it, in their order.
/// Keeps nothing until the first corner, face or vertex that has something.
class AttributeCollector {
 public:
  /// The following faces belong to this group; one without any name is none.
  void use_group(FaceGroup group);
  /// For every corner: its index into the texture coordinates, -1 for none.
  void add_corner(std::int32_t uv);
  /// For every face, or for several.
  void add_face() { add_faces(1); }
  void add_faces(std::size_t count);
  /// For vertices that have a colour (linear RGBA), in any order. The first stays: false where that
  /// is another.
  bool color_vertex(std::int32_t vertex, const glm::vec4& color);

  /// Gives the mesh its attributes. `uvs` are dropped where no corner names one; vertices without
  /// a colour become white.
  void finish(std::vector<glm::dvec2> uvs, PolygonMesh& mesh);

 private:
  std::int32_t group_index();

  std::vector<std::int32_t> face_uvs_, face_groups_;
  std::vector<glm::vec4> colors_;
  GroupList groups_;
  FaceGroup group_;
  std::int32_t group_index_ = -1;  // of group_; -1: not looked up yet
  std::size_t corner_count_ = 0, face_count_ = 0;
};

}  // namespace planish
