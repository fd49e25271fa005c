// The command's operator new: large arrays are taken as --memory says, others as ever.
#include <cstdlib>
#include <new>

#include "large_arrays.h"

void* operator new(std::size_t bytes) {
  using namespace planish::command;
  if (bytes >= kLargeArray)
    if (void* const array = take_large_array(bytes)) return array;
  while (true) {
    if (void* const array = std::malloc(bytes > 0 ? bytes : 1)) return array;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

// As the standard library has it; the address sanitizer's own would not come here, but its memory
// would.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void operator delete(void* array) noexcept {
  if (array == nullptr || planish::command::give_back_array(array)) return;
  std::free(array);
}

void operator delete(void* array, std::size_t) noexcept { operator delete(array); }
