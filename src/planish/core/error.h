#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "planish/core/formatted.h"

namespace planish {

/// What kind of thing went wrong. The command maps each to an exit code.
enum class ErrorCode {
  InvalidArgument,   ///< an option or argument is out of range or contradicts another
  UnreadableInput,   ///< a file is missing, malformed or shorter than it says
  UnusableMesh,      ///< the mesh was read but no surface can be made of it
  NoDevice,          ///< no device fits the request, or a program that does is missing
  DeviceLost,        ///< the device stopped answering
  OutOfMemory,       ///< host or device memory does not suffice; thrown before it is taken
  UnwritableOutput,  ///< a file could not be written; the old one is untouched
  Cancelled,         ///< Callbacks::cancelled returned true
};

/// Wrong input, a missing device or an unwritable file. The message says what, where, the value
/// and the remedy: `bunny.obj:812: face names vertex 4031 of 4030`. formatted() writes such.
class Error : public std::runtime_error {
 public:
  static constexpr std::int64_t kNoElement = -1;

  Error(ErrorCode code, const std::string& message, std::int64_t element = kNoElement);

  [[nodiscard]] ErrorCode code() const noexcept { return code_; }
  /// Index of the face, vertex or byte that the message speaks of; kNoElement if none.
  [[nodiscard]] std::int64_t element() const noexcept { return element_; }

 private:
  ErrorCode code_;
  std::int64_t element_;
};

/// What a caught exception says.
struct Failure {
  std::optional<ErrorCode> code;  ///< none: a fault of our own
  const char* message = "";       ///< the exception's, or one that lives as long as the program
  std::int64_t element = Error::kNoElement;
};

/// Of the exception that is being handled: an Error's own, OutOfMemory and `out_of_memory` where
/// memory runs out (std::bad_alloc) or an array has more than can be counted (std::length_error).
/// To be called in a catch block; the message lives as long as that is not left.
[[nodiscard]] Failure current_failure(const char* out_of_memory) noexcept;

}  // namespace planish
