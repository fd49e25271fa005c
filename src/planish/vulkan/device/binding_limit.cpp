#include "planish/vulkan/device/binding_limit.h"

#include "planish/core/error.h"

namespace planish::vulkan {

void BindingLimit::require(std::uint64_t wanted, const std::string& what,
                           const std::string& remedy) const {
  if (allows(wanted)) return;
  throw Error(ErrorCode::OutOfMemory, what + " take " + std::to_string(wanted) +
                                          " bytes of one binding, but " + name + " is " +
                                          std::to_string(bytes) + "; " + remedy);
}

}  // namespace planish::vulkan
