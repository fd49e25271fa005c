#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec4.hpp>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Groups of faces in the order in which they are first asked for, each once.
class GroupList {
 public:
  std::int32_t index_of(const FaceGroup& group) {
    const auto next = static_cast<std::int32_t>(groups_.size());
    const auto [entry, is_new] = index_of_.try_emplace({group.name, group.material}, next);
    if (is_new) groups_.push_back(group);
    return entry->second;
  }
  [[nodiscard]] const std::vector<FaceGroup>& groups() const { return groups_; }
  /// Hands them over; the list is not used any more.
  [[nodiscard]] std::vector<FaceGroup> take() { return std::move(groups_); }

 private:
  std::vector<FaceGroup> groups_;
  std::map<std::pair<std::string, std::string>, std::int32_t> index_of_;
};

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

/// The sRGB transfer function and its inverse, 0 to 1 on both sides; what lies outside is clamped.
[[nodiscard]] double linear_of_srgb(double encoded);
[[nodiscard]] double srgb_of_linear(double linear);

/// Linear RGBA of sRGB colour with its (always linear) alpha.
[[nodiscard]] glm::vec4 linear_of_srgb(const glm::dvec4& encoded);
[[nodiscard]] glm::dvec4 srgb_of_linear(const glm::vec4& linear);

/// Makes linear colours of the numbers of a file that does not say what they go up to: sRGB from 0
/// to 1; from 0 to 255 where one is 2 or more, with the warning "color-range" unless whole numbers
/// are usual and all are. Alpha, linear, for itself. What lies outside is clamped, with the warning
/// "clamped-colors"; a colour that is no number becomes white.
void settle_colors(std::span<glm::vec4> colors, std::string_view file, bool whole_is_usual,
                   std::vector<Warning>& warnings);

/// A name of letters, digits and '_', no digit first: other bytes become '_'.
[[nodiscard]] std::string identifier_of(const std::string& name);

/// What PLY's convention calls the numbers of a vertex, and their slots in PlyVertexLayout.
struct KnownProperty {
  std::string_view name;
  int slot;
};
inline constexpr std::array<KnownProperty, 19> kKnownProperties = {{{"x", 0},
                                                                    {"y", 1},
                                                                    {"z", 2},
                                                                    {"s", 3},
                                                                    {"t", 4},
                                                                    {"u", 3},
                                                                    {"v", 4},
                                                                    {"texture_u", 3},
                                                                    {"texture_v", 4},
                                                                    {"red", 5},
                                                                    {"green", 6},
                                                                    {"blue", 7},
                                                                    {"alpha", 8},
                                                                    {"diffuse_red", 5},
                                                                    {"diffuse_green", 6},
                                                                    {"diffuse_blue", 7},
                                                                    {"nx", 9},
                                                                    {"ny", 10},
                                                                    {"nz", 11}}};

/// How many further properties of vertices or points are read.
inline constexpr std::size_t kMaxProperties = 32;

/// Names of further properties, as VertexAttribute has them: other characters of a name than
/// letters, digits and '_' become '_'. Those behind the first kMaxProperties are left out, of equal
/// names all but the first, whatever their case, and names that files of surfaces use themselves.
class PropertyNames {
 public:
  PropertyNames();

  /// Whether a property of that name is one of names() now.
  bool add(const std::string& given);
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Appends "left-out-properties" where some were left out. `elements`: "vertices".
  void warn(std::vector<Warning>& warnings, std::string_view file, std::string_view elements) const;

 private:
  std::vector<std::string> names_;
  std::set<std::string, std::less<>> taken_;
  std::int64_t left_out_count_ = 0;
  std::string left_out_;  // the first
};

}  // namespace planish
