#include "planish/core/error.h"

#include <new>

#include "planish/core/visible_text.h"

namespace planish {

// Messages quote what came from outside: hosts can take them as text.
Error::Error(ErrorCode code, const std::string& message, std::int64_t element)
    : std::runtime_error(visible_lines(message)), code_(code), element_(element) {}

Failure current_failure(const char* out_of_memory) noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return {error.code(), error.what(), error.element()};
  } catch (const std::bad_alloc&) {
    return {ErrorCode::OutOfMemory, out_of_memory};
  } catch (const std::length_error&) {
    return {ErrorCode::OutOfMemory, out_of_memory};
  } catch (const std::exception& error) {
    return {{}, error.what()};
  } catch (...) {
    return {{}, "an unknown exception"};
  }
}

}  // namespace planish
