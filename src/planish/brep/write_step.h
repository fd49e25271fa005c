#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "planish/brep/brep.h"
#include "planish/core/callbacks.h"

namespace planish {

/// OfInput: what the format of the input says, metres of a glTF; else, and where nothing was read,
/// millimetres.
enum class StepUnit : std::uint8_t { Millimetre, Centimetre, Metre, Inch, OfInput };
[[nodiscard]] double millimetres_of(StepUnit unit);

/// Faces of one group.
struct StepGroup {
  std::string name{};                 ///< UTF-8
  std::optional<glm::dvec3> color{};  ///< red, green and blue as displays have them, 0 to 1
};

struct StepOptions {
  std::string name = "surface";          ///< of the product, UTF-8
  StepUnit unit = StepUnit::Millimetre;  ///< of the coordinates, which stay as they are
  double diagonal = 1;                   ///< of the model: edges are told to meet within 1e-7 of it
  std::string description{};             ///< of the file, UTF-8
  std::vector<StepGroup> groups{};       ///< by Brep::Face::group; where none is, nothing is said
  /// Is given the bytes in their order, as they are written.
  std::function<void(std::span<const std::byte>)> observe;
  Callbacks callbacks{};  ///< step "write"
};

[[nodiscard]] inline std::string_view name_of_group(const StepOptions& options,
                                                    std::int32_t group) {
  return group < 0 || static_cast<std::size_t>(group) >= options.groups.size()
             ? std::string_view()
             : options.groups[group].name;
}

/// Writes a STEP file (ISO 10303-21, AP214): a solid for each closed shell, with those in it that
/// are inside out as its voids, and shells of the others. Flat faces are planes. Groups name faces,
/// and solids and shells that they have whole, and colour them.
/// The same bytes for every number of threads. Returns their number. Throws
/// Error{InvalidArgument} without faces, Error{UnwritableOutput}, Error{Cancelled}.
std::uint64_t write_step(const std::filesystem::path& path, const Brep& brep,
                         const StepOptions& options = {});

}  // namespace planish
