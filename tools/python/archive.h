#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "bindings.h"

namespace planish::python {

/// All that a Mesh, a Surface or a Fit holds as bytes, for pickles of this version of planish on
/// machines alike: no format for files.
[[nodiscard]] std::string packed(const PythonMesh& mesh);
[[nodiscard]] std::string packed(const PythonSurface& surface);
[[nodiscard]] std::string packed(const PythonFit& fit);

/// The same object from them. Throws Error{UnreadableInput} for bytes of another version or kind,
/// or that end early.
void unpack(std::string_view bytes, PythonMesh& mesh);
void unpack(std::string_view bytes, PythonSurface& surface);
void unpack(std::string_view bytes, PythonFit& fit);

}  // namespace planish::python
