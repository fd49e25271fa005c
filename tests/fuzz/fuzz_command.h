#pragma once

#include <cstddef>
#include <span>

#include "planish/files/formats.h"

// What the command reads, and says of it; the format says nothing of most. All abort as those of
// fuzz_read.h do.
namespace planish::test {

/// A scene file: jobs, or a refusal in which everything can be seen.
void fuzz_read_scene(std::span<const std::byte> bytes, FileFormat format);

/// The header of a cage, which says again what was read of it.
void fuzz_read_cage(std::span<const std::byte> bytes, FileFormat format);

/// A name on its way into messages, JSON, HTML and shells: it stays within its place, and says
/// there what it said.
void fuzz_write_text(std::span<const std::byte> bytes, FileFormat format);

/// A line with the direction of rays, or an empty one, and a file of points: what `query` reads and
/// answers. No place of the surface is nearer, hits lie on ray and surface, and the answers can be
/// read.
void fuzz_query(std::span<const std::byte> bytes, FileFormat format);

/// What `inspect` says of standard input, whose format it tells by the content.
void fuzz_inspect(std::span<const std::byte> bytes, FileFormat format);

}  // namespace planish::test
