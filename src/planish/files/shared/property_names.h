#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "planish/core/callbacks.h"

namespace planish {

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
