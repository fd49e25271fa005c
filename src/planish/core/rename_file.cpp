#include "planish/core/rename_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace planish {
namespace {

std::error_code result_of(int returned) {
  return returned == 0 ? std::error_code() : std::error_code(errno, std::generic_category());
}

}  // namespace

std::error_code rename_file(const std::filesystem::path& from, const std::filesystem::path& to,
                            bool replaces) {
  if (replaces) return result_of(std::rename(from.c_str(), to.c_str()));
#ifdef RENAME_NOREPLACE
  const std::error_code error =
      result_of(::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE));
  if (error != std::errc::invalid_argument && error != std::errc::function_not_supported)
    return error;
#endif
  return link_in_place(from, to);
}

std::error_code link_in_place(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (::link(from.c_str(), to.c_str()) == 0) return result_of(::unlink(from.c_str()));
  if (errno == EEXIST) return result_of(-1);
  // Folders have no second names, nor have files everywhere: what comes between these two lines is
  // replaced.
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(to, ignored)))
    return std::make_error_code(std::errc::file_exists);
  return result_of(std::rename(from.c_str(), to.c_str()));
}

}  // namespace planish
