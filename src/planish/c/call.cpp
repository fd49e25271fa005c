#include "planish/c/call.h"

#include <oneapi/tbb/task_arena.h>

#include <limits>

#include "planish/core/version.h"

namespace planish::c {
namespace {

// The one thing that the library keeps between calls: C has no other place for a message.
struct LastError {
  std::string message;
  std::int64_t element = -1;
};

thread_local LastError last_error;

planish_status status_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument:
      return PLANISH_INVALID_ARGUMENT;
    case ErrorCode::UnreadableInput:
      return PLANISH_UNREADABLE_INPUT;
    case ErrorCode::UnusableMesh:
      return PLANISH_UNUSABLE_MESH;
    case ErrorCode::NoDevice:
    case ErrorCode::DeviceLost:
    case ErrorCode::OutOfMemory:
      return PLANISH_NO_MEMORY;
    case ErrorCode::UnwritableOutput:
      return PLANISH_UNWRITABLE_OUTPUT;
    case ErrorCode::Cancelled:
      return PLANISH_CANCELLED;
  }
  return PLANISH_INTERNAL_ERROR;
}

}  // namespace

void note(const char* message, std::int64_t element) noexcept {
  try {
    last_error = {message, element};
  } catch (...) {  // no memory for the message
    last_error.message.clear();
    last_error.element = -1;
  }
}

planish_status note_exception() noexcept {
  const Failure failure = current_failure("out of memory; take a lower level or a smaller mesh");
  note(failure.message, failure.element);
  return failure.code ? status_of(*failure.code) : PLANISH_INTERNAL_ERROR;
}

void run_on(int thread_count, const std::function<void()>& work) {
  if (thread_count == 0) {
    work();
    return;
  }
  oneapi::tbb::task_arena arena(thread_count);
  arena.execute(work);
}

void refuse(const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); }

void require_list(const std::int32_t* values, std::size_t count, const char* name,
                  const char* count_name) {
  constexpr std::size_t kMost = std::numeric_limits<std::int32_t>::max();
  if (count > 0) require(values, name);
  if (count > kMost)
    refuse(formatted("{} is {}, more than 2^31 - 1; name fewer at once", count_name, count));
}

void give_warning(std::span<const Warning> warnings, const char* of, std::size_t index,
                  const char** code, const char** message) {
  if (index >= warnings.size())
    refuse(formatted("index is {}; the {} has {} warnings", index, of, warnings.size()));
  if (code != nullptr) *code = warnings[index].code.c_str();
  if (message != nullptr) *message = warnings[index].message.c_str();
}

}  // namespace planish::c

const char* planish_version(void) { return PLANISH_VERSION; }

const char* planish_last_error(void) { return planish::c::last_error.message.c_str(); }

int64_t planish_last_error_element(void) { return planish::c::last_error.element; }
