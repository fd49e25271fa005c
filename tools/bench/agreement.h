#pragma once

#include <glm/vec3.hpp>
#include <span>
#include <string_view>

namespace planish::bench {

/// Float peers round weights and sums: some 1e-7 of the largest coordinate. Ten iterations and
/// two stopping rules at 1e-6 stay below this too.
inline constexpr double kAgreement = 1e-5;

/// Throws std::runtime_error naming `what` when the points differ by more than kAgreement of the
/// largest coordinate of `expected`: a benchmark that computes something else is worthless.
void require_agreement(std::string_view what, std::span<const glm::dvec3> actual,
                       std::span<const glm::dvec3> expected);

}  // namespace planish::bench
