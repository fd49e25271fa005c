#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <new>
#include <span>
#include <string>

#include "planish/c/planish.h"
#include "planish/core/callbacks.h"
#include "planish/core/error.h"

namespace planish::c {

/// Sets this thread's last error to the exception that is being handled. Returns its status.
[[nodiscard]] planish_status note_exception() noexcept;

/// Runs `work` and turns what it throws into a status and this thread's last error. A template, for
/// a std::function takes memory before anything is caught.
template <class Work>
[[nodiscard]] planish_status call(const Work& work) noexcept {
  try {
    return work();
  } catch (...) {
    return note_exception();
  }
}

/// Sets this thread's last error, for a status that comes with results.
void note(const char* message, std::int64_t element) noexcept;

/// The same of what `make_message` returns; where there is no memory for that, of `short_message`:
/// results that are there are not an error of memory.
template <class MakeMessage>
void note_of_results(const MakeMessage& make_message, const char* short_message) noexcept {
  try {
    note(make_message().c_str(), -1);
  } catch (const std::bad_alloc&) {
    note(short_message, -1);
  }
}

/// Runs `work` on so many threads; 0: all.
void run_on(int thread_count, const std::function<void()>& work);

/// Throws Error{InvalidArgument} that says which function wants what.
[[noreturn]] void refuse(const std::string& message);

/// Either target may be NULL. `of`: whose warnings they are, "mesh".
void give_warning(std::span<const Warning> warnings, const char* of, std::size_t index,
                  const char** code, const char** message);

template <class Pointer>
void require(Pointer* pointer, const char* name) {
  if (pointer == nullptr) refuse(std::string(name) + " is NULL");
}

/// Throws for NULL and for more values, or pairs of them, than the library counts.
void require_list(const std::int32_t* values, std::size_t count, const char* name,
                  const char* count_name);

/// Sets the defaults of a caller's struct of `size` bytes, as it knows it, and its size.
template <class Struct>
void start(const Struct& defaults, Struct* target, std::size_t size) {
  if (target == nullptr || size < sizeof size) return;
  std::memset(target, 0, size);
  std::memcpy(target, &defaults, size < sizeof defaults ? size : sizeof defaults);
  std::memcpy(target, &size, sizeof size);
}

/// A struct of the caller's, whatever version of the header it was compiled with: what it does not
/// know stays at its default. Throws Error{InvalidArgument} for a size that no header ever had.
template <class Struct>
Struct taken(const Struct* given, void (*init)(Struct*, std::size_t), const char* name) {
  Struct own;
  init(&own, sizeof own);
  if (given == nullptr) return own;
  std::size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  if (size < sizeof size + 1 || size > 4096) {
    refuse(formatted("{}.struct_size is {}; planish_..._init() sets it", name, size));
  }
  std::memcpy(&own, given, size < sizeof own ? size : sizeof own);
  own.struct_size = sizeof own;
  return own;
}

/// Fills the part of the caller's struct that it knows.
template <class Struct>
void give(const Struct& own, Struct* target, const char* name) {
  require(target, name);
  std::size_t size = 0;
  std::memcpy(&size, target, sizeof size);
  if (size < sizeof size + 1 || size > 4096) {
    refuse(formatted("{}.struct_size is {}; planish_..._init() sets it", name, size));
  }
  std::memcpy(target, &own, size < sizeof own ? size : sizeof own);
  std::memcpy(target, &size, sizeof size);
}

}  // namespace planish::c
