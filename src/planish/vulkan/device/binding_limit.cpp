#include "planish/vulkan/device/binding_limit.h"

#include "planish/core/error.h"

namespace planish::vulkan {

void BindingLimit::require(std::uint64_t wanted, const std::string& what,
                           const std::string& remedy) const {
  if (allows(wanted)) return;
  throw Error(ErrorCode::OutOfMemory, formatted("{} take {} bytes of one binding, but {} is {}; {}",
                                                what, wanted, name, bytes, remedy));
}

}  // namespace planish::vulkan
