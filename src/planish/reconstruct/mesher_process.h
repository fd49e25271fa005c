#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "planish/mesh/polygon_mesh.h"

namespace planish {

/// Memory that the program takes of each point that it meshes, at most.
inline constexpr std::uint64_t kMesherPointBytes = 2400;

/// The program that meshes points: $PLANISH_RECONSTRUCT if set, else `planish-reconstruct` beside
/// the running program, else on $PATH. Empty if it is not there.
[[nodiscard]] std::optional<std::filesystem::path> find_mesher_program();

/// A mesher that starts `program` for each cloud and talks with it through a socket. The program
/// ends with the call, whether it returns or throws. Besides the program's own errors it throws
/// Error{NoDevice} when the program cannot be started, Error{InvalidArgument} when it answers what
/// no mesher does,
/// Error{OutOfMemory} when it was killed, Error{Cancelled}.
[[nodiscard]] Mesher mesher_process(std::filesystem::path program);

}  // namespace planish
