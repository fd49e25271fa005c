#pragma once

#include <cstdint>
#include <optional>

namespace planish {

/// Subdivision schemes whose limit surface can be made to interpolate.
enum class Scheme : std::uint8_t {
  DooSabin,      ///< dual: planish/doosabin
  CatmullClark,  ///< Catmull & Clark 1978, with OpenSubdiv's rules
  Loop,          ///< Loop 1987, with OpenSubdiv's rules; triangles only
};

/// The two whose control points are the vertices of their refined meshes, OpenSubdiv's own.
enum class PrimalScheme : std::uint8_t { CatmullClark, Loop };

[[nodiscard]] constexpr std::optional<PrimalScheme> primal_scheme(Scheme scheme) {
  if (scheme == Scheme::CatmullClark) return PrimalScheme::CatmullClark;
  if (scheme == Scheme::Loop) return PrimalScheme::Loop;
  return std::nullopt;
}

}  // namespace planish
