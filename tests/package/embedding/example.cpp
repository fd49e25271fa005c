#include "example.h"

// README begins
#include <planish/vulkan/embed.h>

namespace pv = planish::vulkan;

void draw_frames(Application& app, const planish::PolygonMesh& mesh, int frame_count,
                 const MovePoints& move_points, const Draw& draw) {
  const pv::System system(mesh, {.level = 2});  // topology and stencils, on the CPU
  pv::Context context(
      pv::HostDevice{app.get_instance_proc, app.instance, app.physical_device, app.device});
  const pv::DeviceSystem tables(context, system);  // the stencils on the application's device

  const auto storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_VERTEX_BUFFER_BIT;
  MappedBuffer staging = app.make_buffer(tables.upload_bytes(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  MappedBuffer indices =
      app.make_buffer(4 * tables.index_count(),
                      VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  MappedBuffer points[2], vertices[2];  // of two frames in flight
  for (int slot : {0, 1}) {
    points[slot] = app.make_buffer(12 * tables.given_count(), storage);
    vertices[slot] = app.make_buffer(24 * tables.vertex_count(), storage);
  }
  tables.write_upload(system, staging.bytes);
  app.run([&](VkCommandBuffer commands) {
    tables.record_upload(commands, staging.handle, 0, {indices.handle, 0});
  });

  const pv::Solve solve(context, tables,  // one for all frames
                        {.given = {points[0].handle},
                         .vertices = {vertices[0].handle},
                         .further_slots = {{{points[1].handle}, {vertices[1].handle}}}});
  // Each frame takes as many iterations as its pose needs: few, from where the last frame ended.
  const std::uint32_t most = system.sufficient_iterations(system.rest_error());
  const float stop_error = static_cast<float>(system.tolerance());
  for (int frame = 0; frame < frame_count; ++frame) {
    const std::uint32_t slot = frame % 2;
    move_points(frame, points[slot].bytes);
    app.run([&](VkCommandBuffer commands) {
      solve.record_solve(
          commands,
          {.iterations = most, .stop_error = stop_error, .warm_start = frame > 0, .slot = slot});
      solve.record_evaluate(commands, {slot});  // limit positions and normals
      app.vertices_after(commands, pv::kExitScope.stages, pv::kExitScope.accesses);
    });
    draw(frame, vertices[slot].bytes, vertices[1 - slot].bytes, indices.bytes);
  }
}
// README ends
