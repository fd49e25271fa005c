#pragma once

#include <filesystem>
#include <mutex>

namespace planish {

/// A hidden folder of files that are not in place yet, in the list of the process.
void add_temporary_folder(const std::filesystem::path& folder);
void forget_temporary_folder(const std::filesystem::path& folder);

/// Removes it with all that it holds, as far as that can be. Takes no memory by `new`: what ran out
/// of that ends here, and std::filesystem::remove_all() would end the process.
void remove_folder(const std::filesystem::path& folder) noexcept;

/// Held while files are put in place, so that all of them are there or none.
[[nodiscard]] std::unique_lock<std::mutex> while_files_move();

/// Removes all folders of the list, and lets nobody add one any more: for who ends the process
/// while jobs are under way, which must hold while_files_move().
void remove_temporary_folders();

}  // namespace planish
