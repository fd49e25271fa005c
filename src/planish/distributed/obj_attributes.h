#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "planish/distributed/mesh_slice.h"
#include "planish/files/obj/obj_part.h"

namespace planish {

/// What rides on the vertices, corners and faces of a range of an OBJ file, gathered part by part.
class ObjAttributes {
 public:
  /// Of the next part; `before` has the parts before it. `place` stands in messages.
  void append(const ObjPart& part, const std::string& place, const MeshSlice& before);

  /// Gives the slice what it has, all ranks together: indices that count backwards, colours of
  /// vertices that have none, groups that go on from the ranks before, warnings. The slice's runs
  /// are known. Throws AgreedError{UnreadableInput} for coordinates that the file has not.
  void settle(const Ranks& ranks, const std::string& path, MeshSlice& slice);

 private:
  void settle_colors(const Ranks& ranks, MeshSlice& slice);
  void settle_uvs(const Ranks& ranks, const std::string& path, MeshSlice& slice);
  void settle_names(const Ranks& ranks, MeshSlice& slice);

  std::vector<glm::vec4> colors_;
  std::vector<glm::dvec2> uvs_;
  std::vector<std::int64_t> face_uvs_;
  std::vector<std::size_t> backward_;  // places in face_uvs_
  std::vector<ObjPart::Naming> namings_;
  std::vector<std::int64_t> named_from_;  // the first face of each of them
  std::int64_t largest_uv_ = -1, clamped_colors_ = 0;
  std::string largest_place_;
};

}  // namespace planish
