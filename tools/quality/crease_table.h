#pragma once

#include <functional>
#include <string>
#include <vector>

namespace planish::quality {

/// Prints what find_features() finds: of parts as CAD programs tessellate them, and of the same
/// decimated, the share of found edges that are the model's (precision) and of the model's that are
/// found (recall); of organic shapes the share of edges that are found at all. Returns a line for
/// each part below 0.98 and each organic shape above 0.02; heads and animals of a few hundred
/// vertices have sharp edges, and are only listed. What find_features() finds stands beside it, to
/// be compared. Takes the wanted of the names that it prints.
[[nodiscard]] std::vector<std::string> print_crease_table(
    const std::function<bool(const std::string& name)>& is_wanted);

}  // namespace planish::quality
