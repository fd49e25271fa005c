#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "planish/brep/brep.h"
#include "planish/core/callbacks.h"

namespace planish {

enum class StepUnit : std::uint8_t { Millimetre, Centimetre, Metre, Inch };
[[nodiscard]] double millimetres_of(StepUnit unit);

struct StepOptions {
  std::string name = "surface";          ///< of the product, UTF-8
  StepUnit unit = StepUnit::Millimetre;  ///< of the coordinates, which stay as they are
  double diagonal = 1;                   ///< of the model: edges are told to meet within 1e-7 of it
  std::string description{};             ///< of the file, UTF-8
  /// Is given the bytes in their order, as they are written.
  std::function<void(std::span<const std::byte>)> observe;
  Callbacks callbacks{};  ///< step "write"
};

/// Writes a STEP file (ISO 10303-21, AP214): a solid for each closed shell, shells of the others.
/// The same bytes for every number of threads. Returns their number. Throws
/// Error{UnwritableOutput}, Error{Cancelled}.
std::uint64_t write_step(const std::filesystem::path& path, const Brep& brep,
                         const StepOptions& options = {});

}  // namespace planish
