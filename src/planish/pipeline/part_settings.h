#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/option.h"

namespace planish {

struct FitSettings;

/// What names parts of a scene.
enum class PartKind : std::uint8_t { Mesh, Material, Node };
/// "mesh", "material", "node".
[[nodiscard]] std::string_view name_of(PartKind kind);

/// An option that holds for some meshes of a scene: those of a name, those with faces of a
/// material, or those that a node of a name shows, itself or by nodes below it.
struct PartSetting {
  PartKind kind = PartKind::Mesh;
  std::string name;  ///< "*" stands for any text
  std::string option, value;

  friend bool operator==(const PartSetting& a, const PartSetting& b) = default;
  /// "mesh=Wheel"
  [[nodiscard]] std::string who() const;
  /// Whether the name is this one.
  [[nodiscard]] bool names(std::string_view part) const;
  /// Whether it may be of no part: one with "*".
  [[nodiscard]] bool may_be_of_none() const { return name.find('*') != std::string::npos; }
  /// Throws Error{InvalidArgument}.
  void apply_to(FitSettings& settings) const;
};

/// Whether a part may have one of its own: how its surface is made, and a level.
[[nodiscard]] bool is_of_parts(const OptionInfo& option);

/// The settings of "mesh=Wheel:creases=use; node=Roof*:quads=off": what parts, what holds for them;
/// those that come later count. Options are spelled as names or flags, without the dashes before
/// them. Throws Error{InvalidArgument}: `where`, the text and what is wanted.
[[nodiscard]] std::vector<PartSetting> parse_part_settings(std::string_view text,
                                                           std::string_view where);
/// A text that says the same.
[[nodiscard]] std::string part_settings_text(const std::vector<PartSetting>& settings);

}  // namespace planish
