#pragma once

#include <filesystem>
#include <system_error>

namespace planish {

/// Gives `from` the name `to`. Without `replaces` what stands at `to` stays, and the error is
/// std::errc::file_exists: also where it came a moment ago, on file systems that can rename so or
/// give a file a second name.
[[nodiscard]] std::error_code rename_file(const std::filesystem::path& from,
                                          const std::filesystem::path& to, bool replaces);

/// The same without `replaces` for file systems whose only tool are second names.
[[nodiscard]] std::error_code link_in_place(const std::filesystem::path& from,
                                            const std::filesystem::path& to);

}  // namespace planish
