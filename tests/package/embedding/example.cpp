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
  MappedBuffer points = app.make_buffer(12 * tables.given_count(), storage);
  MappedBuffer vertices = app.make_buffer(24 * tables.vertex_count(), storage);
  tables.write_upload(system, staging.bytes);
  app.run([&](VkCommandBuffer commands) {
    tables.record_upload(commands, staging.handle, 0, {indices.handle, 0});
  });

  const pv::Solve solve(context, tables,  // one per frame in flight
                        {.given = {points.handle}, .vertices = {vertices.handle}});
  for (int frame = 0; frame < frame_count; ++frame) {
    move_points(frame, points.bytes);
    app.run([&](VkCommandBuffer commands) {
      solve.record_solve(commands, {.iterations = 20, .warm_start = frame > 0});
      solve.record_evaluate(commands);  // limit positions and normals, into `vertices`
      app.vertices_after(commands, pv::kExitScope.stages, pv::kExitScope.accesses);
    });
    draw(frame, vertices.bytes, indices.bytes);
  }
}
// README ends
