#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <new>
#include <optional>
#include <system_error>

#include "planish/core/error.h"
#include "planish/reconstruct/reconstruct.h"

namespace planish::command {

/// Room in the temporary file's folder that an array asks for in vain.
class NoRoomForArray : public std::bad_alloc {
 public:
  NoRoomForArray(const char* folder, std::size_t bytes, const std::error_code& reason) noexcept;
  [[nodiscard]] const char* what() const noexcept override { return message_; }

 private:
  char message_[512];
};

/// current_failure() in the words of the command; of the class above, its own.
[[nodiscard]] Failure job_failure() noexcept;

/// Arrays of so many bytes and more are counted.
inline constexpr std::size_t kLargeArray = std::size_t{1} << 20;

/// From now on large arrays are counted: beyond a part of the budget each lies in a file without a
/// name in the folder, whose pages leave memory where the process would hold more of it than
/// `bytes`. Nothing is left of such files, whatever ends the process. To be called once, before
/// work. Throws Error{UnwritableOutput} where the folder takes no file.
void hold_arrays_within(std::uint64_t bytes, const std::filesystem::path& folder);

/// Memory of the budget that another process takes meanwhile.
class MemoryOfOthers {
 public:
  explicit MemoryOfOthers(std::uint64_t bytes);
  ~MemoryOfOthers();
  MemoryOfOthers(const MemoryOfOthers&) = delete;
  MemoryOfOthers& operator=(const MemoryOfOthers&) = delete;

 private:
  std::uint64_t bytes_;
};

/// require_mesher(), which takes kMesherPointBytes a point of the budget.
[[nodiscard]] Mesher require_counted_mesher();

/// The budget of hold_arrays_within(), and what the disk has left for what is beyond it.
struct ArrayBudget {
  std::uint64_t bytes = 0;
  std::filesystem::path folder;
  std::uint64_t free_bytes = 0;
};
[[nodiscard]] std::optional<ArrayBudget> array_budget();

// For operator new and delete.

/// Null where arrays are not counted. Throws std::bad_alloc.
[[nodiscard]] void* take_large_array(std::size_t bytes);
/// Whether it was one of take_large_array().
[[nodiscard]] bool give_back_array(void* array) noexcept;

}  // namespace planish::command
