#pragma once

namespace planish {

/// The commit that the build was configured at, or "unknown".
[[nodiscard]] const char* git_revision();

}  // namespace planish
