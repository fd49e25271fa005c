#include "planish/vulkan/host/instance_limits.h"

#include <algorithm>
#include <string>
#include <tuple>

#include "planish/core/error.h"

namespace planish::vulkan {

namespace {

constexpr std::uint32_t kGivenBytes = 3 * sizeof(float);
// Work groups that every device has in y.
constexpr std::uint32_t kMostInstances = 65535;

[[noreturn]] void refuse_instances(const std::string& message) {
  throw Error(ErrorCode::InvalidArgument, message);
}

// Of instances together: `bytes`, of which one has `each`.
struct Span {
  const char* what;
  std::uint64_t bytes, each;
};

// Where kernels read texel buffers, the range is what texels of one float allow.
void check_span(const Context& context, std::uint32_t instances, const Span& span) {
  const std::uint64_t most = context.max_storage_range();
  if (span.bytes <= most) return;
  throw Error(ErrorCode::OutOfMemory,
              context.capabilities().name + ": " + span.what + " of " + std::to_string(instances) +
                  " instances span " + std::to_string(span.bytes) +
                  " bytes of one binding, but maxStorageBufferRange is " + std::to_string(most) +
                  "; make Solves of at most " +
                  std::to_string(std::max<std::uint64_t>(most / span.each, 1)) + " instances");
}

void check_strides(const SolveOptions& options, std::uint64_t vertex_count) {
  const VertexLayout& vertices = options.vertices;
  if (options.given.instance_stride % sizeof(float) != 0 ||
      vertices.instance_stride % sizeof(float) != 0)
    refuse_instances("strides between instances are multiples of 4 bytes");
  if (!vertices.buffer || options.instances == 1 || vertex_count == 0) return;
  const std::uint64_t needed = (vertex_count - 1) * vertices.stride +
                               std::max(vertices.position_offset, vertices.normal_offset) +
                               kGivenBytes;
  if (vertices.instance_stride < needed)
    refuse_instances("vertices of an instance take " + std::to_string(needed) +
                     " bytes, but the next one's begin after " +
                     std::to_string(vertices.instance_stride));
}

}  // namespace

SolveOptions checked_instances(const Context& context, const InstanceSizes& sizes,
                               const SolveOptions& options) {
  const std::uint32_t count = options.instances;
  if (count < 1 || count > kMostInstances)
    refuse_instances("instances " + std::to_string(count) + " are outside 1 to " +
                     std::to_string(kMostInstances));
  SolveOptions result = options;
  if (!result.given.buffer) result.given.stride = kGivenBytes;
  if (!result.given.buffer || result.given.instance_stride == 0)
    result.given.instance_stride = sizes.given * result.given.stride;
  if (result.vertices.instance_stride == 0)
    result.vertices.instance_stride = sizes.vertices * result.vertices.stride;
  if (count == 1) return result;
  if (sizes.is_fair)
    refuse_instances("Solves of the fair method have one instance, not " + std::to_string(count) +
                     "; make as many Solves and take record_solves()");
  check_strides(result, sizes.vertices);
  const Instances instances{count};
  const auto all = [&](std::uint64_t stride) { return count * stride + kBindingAlignment; };
  const std::uint64_t step_bytes =
      (std::uint64_t(options.max_iterations) + 1) * sizeof(shared::StepRecord);
  const std::uint64_t row_bytes = instances.bytes(sizes.rows) / count;
  const std::uint64_t point_bytes = instances.bytes(sizes.points) / count;
  check_span(context, count, {"points", count * row_bytes, std::max<std::uint64_t>(row_bytes, 1)});
  if (sizes.has_surface)
    check_span(context, count,
               {"points of level 1", count * point_bytes, std::max<std::uint64_t>(point_bytes, 1)});
  check_span(context, count, {"steps", count * step_bytes, step_bytes});
  for (const auto& [what, stride, wanted] :
       {std::tuple{"given points", result.given.instance_stride, true},
        {"vertices", result.vertices.instance_stride, result.vertices.buffer != VK_NULL_HANDLE}})
    if (wanted && stride > 0) check_span(context, count, {what, all(stride), stride});
  return result;
}

}  // namespace planish::vulkan
