#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "planish/files/formats.h"

namespace planish {

/// What the path of an input alone says is wrong with it: no such file, with the nearest name
/// beside it or an explanation of `~` and `file://`; a folder; not readable; an extension of a
/// format that is not read, with the program that converts it. "-" and a path of any other
/// extension pass: content decides. Throws Error{UnreadableInput}; Error{InvalidArgument} for a
/// format.
void require_input(const std::string& path, std::optional<FileFormat> format);

/// What converts a file of that extension ("step", with or without the dot) to one that planish
/// reads; empty where the extension is none that we know of.
[[nodiscard]] std::string conversion_to_readable(const std::filesystem::path& path);

/// The same for a file to write: what makes it of a GLB.
[[nodiscard]] std::string conversion_from_glb(const std::filesystem::path& path);

}  // namespace planish
