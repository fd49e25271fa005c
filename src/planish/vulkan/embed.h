#pragma once

// Interpolating Doo-Sabin surfaces inside a Vulkan application that owns its device, its command
// buffers, its memory and its frame loop. This is the one header for such hosts.
//
// - System: topology, limit masks and corner patches of a mesh, on the CPU; immutable, shared by
//   all.
// - Context: functions, limits and pipelines of the host's VkDevice
//   (planish/vulkan/device/context.h).
// - DeviceSystem: the tables of one System on the device; read-only once its upload ran.
// - Solve: work buffers and descriptor sets of one mesh that moves, for all frames in flight.
// - Places: the surface of a Solve at a list of places, for particles, cameras, baking.
// - Tessellation: a Solve's instances, each at the level that a view needs (host/evaluation.h).
//
// Each must outlive those below it; a System need only live until DeviceSystem::write_upload() is
// done. Order of use:
//
//   System system(mesh);                                 // once per topology
//   Context context(host);                               // once per device
//   DeviceSystem tables(context, system);                // once per device and topology
//   tables.write_upload(system, mapped_staging);         //   ... its bytes, into the host's memory
//   tables.record_upload(commands, staging, 0, indices); //   ... and on to the device
//   Solve solve(context, tables, options);               // once per mesh that moves by itself
//   Places places(context, tables, solve, options);      // if wanted; Tessellation likewise
//   each frame: solve.record_solve(commands, parameters); solve.record_evaluate(commands);
//               places.record_evaluate(commands);
//   or, where few points have moved: solve.record_edit(commands, edit_parameters);
//
// Frames in flight. One Solve serves all of them, each by a slot (SolveOptions::further_slots): the
//   points that the host writes for that frame, and the vertices that it draws. Frame n takes
//   {.slot = n}. Their command buffers may be submitted before earlier ones are done, to one
//   queue, in the order of the frames. The last slot's vertices are the last frame's positions,
//   for motion vectors; a warm start goes on from the last frame. A Tessellation, whose vertices
//   change their levels, writes previous positions beside the new ones.
//
// Vertices. A VertexLayout says where positions and normals go and in which VertexFormat: by
//   default 24 bytes a vertex, in compact formats 12; normals may be a stream of their own.
//
// Many meshes. Instances of one mesh, each with points of its own, are best one Solve with
//   SolveOptions::instances: its dispatches do all of them, and cost what one mesh of their size
//   costs. Different meshes that are always solved together are best one System, of the mesh that
//   merged_meshes() (mesh/mesh_parts.h) makes of them. What is left are Solves beside each
//   other: record_solves(commands, calls); record_evaluates(commands, calls);
//
// Iterations. Ask for sufficient_iterations(rest_error()) of the System with its tolerance() as
//   stop_error: a frame then takes as many as its pose needs, a warm start often one to three, and
//   those that are left out cost next to nothing. Without a stop_error all that are asked for are
//   done, 140 bytes a point each.
//
// Errors. Making objects may fail: planish::Error, whose code is InvalidArgument (an option),
//   UnusableMesh, NoDevice (the device lacks something, which the message names), OutOfMemory (the
//   limit is named before memory is taken) or DeviceLost; vulkan::VulkanError where a Vulkan call
//   failed, with its VkResult. What was made until then is destroyed.
// Recording cannot fail. Every record_ function is noexcept and does nothing but vkCmd calls: no
//   allocation, map, submission, wait or descriptor update. It takes a command buffer of any level,
//   in the recording state, outside a render pass, of a family with compute. It disturbs the
//   compute bind point and its push constants, nothing else. One that has nothing to do for want of
//   an option (record_edit without a list) tells HostDevice::log so.
// Barriers. Every record_ function waits by itself for earlier planish work on the same queue.
//   Against its own work the host records barriers: from its own stages to kEntryScope before, from
//   kExitScope to its own stages after (vkCmdPipelineBarrier; a VkMemoryBarrier does). Writing
//   points for the next solve, and evaluating into a vertex buffer that a draw still reads, are
//   such cases. Between queues: semaphores, whose wait stages hold kEntryScope's.
// Submitting. A recorded command buffer may be submitted again and again, not simultaneously: no
//   recorded value depends on what ran before. A Solve's command buffers go to one queue, where
//   each waits for the work of those before it; between queues the host's semaphores see to that.
// Buffers. All are VK_SHARING_MODE_EXCLUSIVE; ownership transfers of the host's buffers are the
//   host's. Offsets and strides are multiples of 4 bytes.
// Destroying. Handles may be dropped once no pending command buffer uses them, as vkDestroyBuffer
//   demands.
// Software drivers. Mesa's llvmpipe (22.3) draws nothing beyond 65,535 vertices that the stages of
//   tessellation make in one draw, and counts gl_PrimitiveID anew after 1,024 patches: draw fewer
//   corners of surface_buffers() at a time there. Draws of written vertices are whole.
// Threads. System, Context and DeviceSystem may be used from many threads; a Solve and the command
//   buffer that it records to, from one at a time.
// Names. planish::Solve is the interface of backends; this one is planish::vulkan::Solve.
// Hubs. Rings of 32 faces and more, and faces of as many corners, are evaluated by three sums that
//   a work group makes, so a corner there costs what others do, as in the first step of the
//   progressive method; with Weights::Averaged each corner's lane walks its rings on the surface,
//   which have 1,024 faces or corners at most.
//   In the fair method a work group walks around such a vertex or face, each of its 64 lanes a
//   piece, some 25 times in a kernel, up to a hundred where creases fold: at 1 us a corner, without
//   anything to hide it, no dispatch takes 50 ms below 30,000 corners. Iterations of the
//   progressive method take faces without sums, so that one of m corners costs m^2 entries a step:
//   a System refuses meshes that need more than 2^24 and eight times what sums would, a face of
//   4,097 corners for one, which the fair method takes.
// Units. Positions and errors are in the mesh's own units, in float32; coordinates should lie
//   within 1e-9 to 1e9. Single precision reaches about 1e-7 of the largest coordinate.

#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planish/core/callbacks.h"
#include "planish/doosabin/subdivision.h"
#include "planish/fair/fair_net.h"
#include "planish/mesh/polygon_mesh.h"
#include "planish/solve/stencil_table.h"
#include "planish/vulkan/device/context.h"
#include "planish/vulkan/device/driver.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/host/evaluation.h"
#include "planish/vulkan/host/solve_options.h"

namespace planish {
struct FairDecisions;
}

namespace planish::vulkan {

struct BendingRecords;
struct EvaluatedParts;
struct FairRecords;
struct SolvePoints;
struct SurfaceBuffers;
struct SurfaceRecords;

struct SystemOptions {
  int level = 2;  ///< quad splits of the surface, 0 to 6: its vertex count grows fourfold with each
  /// Further levels, ascending from 1 to 5, that a Tessellation chooses from: what each would take
  /// as `level`, but for what is the same in all.
  std::vector<int> levels;
  /// Fair: the surface's control points of level 1 are built, without iterations; making the System
  /// builds them once, for the rest pose. A System's tables and all Solves made with them are of
  /// one method. Fair surfaces fold beside corners that turn inward: take with_convex_faces() of
  /// such meshes (mend/repair.h). Needles and sharp turns are cured as fair_net() does; fit()
  /// looks once more, and its decisions say what came of it.
  InterpolationMethod method = InterpolationMethod::Progressive;
  Weights weights = Weights::DooSabin;
  SharpFeatureOptions sharp;
  /// The mesh has texture coordinates: vertices are cut at their seams, uvs() has one of each, and
  /// tangents can be asked for (VertexLayout::tangent_offset), 8 bytes a vertex of tables more.
  bool textured = false;
  /// Of the fair method: what its thresholds decided in one pose, FairNet::decisions of a net of
  /// `rest` or of another pose of it (Fit::fair of fit()), one per used vertex; copied. All poses
  /// then keep them, so that nothing pops while the mesh moves. Null: each pose decides for itself.
  const FairDecisions* fair_decisions = nullptr;
  /// Of the rest pose's diagonal, below 0.1: surfaces of meshes that bend least and leave each
  /// point by no more than this; 0: through them. Empty: measured in the rest pose. Unlike with
  /// FitOptions::within no surface is measured, and one may bend more for it where a mesh is
  /// uneven. Each solve then moves the points first, 61 dispatches; what is said of given points
  /// below holds for the moved ones.
  std::optional<double> within = 0.0;
  double tolerance = 1e-6;  ///< wanted error, relative to the rest pose's bounding-box diagonal
  Callbacks callbacks;      ///< for the time of construction
};

/// Everything about a mesh that stays the same while its points move. CPU only; immutable.
class System {
 public:
  /// `rest` fixes topology, creases and the angles at corners; its positions are the rest pose.
  /// Throws Error{UnusableMesh}, Error{InvalidArgument}, Error{OutOfMemory}, Error{Cancelled}.
  explicit System(const PolygonMesh& rest, const SystemOptions& options = {});
  ~System();
  System(System&&) noexcept;
  System& operator=(System&&) noexcept;

  [[nodiscard]] int level() const;
  /// Points that a solve is given: the mesh's vertices, those that no face names included.
  [[nodiscard]] std::int32_t given_count() const;
  /// Rows of the limit masks, the vertices that faces name; entry i is row i's index in the mesh.
  [[nodiscard]] std::span<const std::int32_t> used_vertices() const;
  /// Vertices that record_evaluate writes. The first used_vertices().size() of them are the limit
  /// points of those vertices, in their order; vertices on creases have one copy more at the end
  /// for each further normal, and on seams for each further texture coordinate.
  [[nodiscard]] std::int32_t vertex_count() const;
  /// Entry i is the vertex that vertex i stands for: itself, or for a copy the one that it copies,
  /// with the same position. Entries below used_vertices().size() are given vertices, that one's
  /// index in the mesh being used_vertices()[entry]; the others lie between given vertices.
  [[nodiscard]] std::span<const std::int32_t> copied_vertices() const;
  /// Where each vertex lies on the mesh's faces, to bake or look up what is given there; copies lie
  /// on their own side. Made anew for each call.
  [[nodiscard]] std::vector<SurfacePlace> places() const;
  /// Texture coordinates of each vertex, for a stream of the host's own: those that `planish fit`'s
  /// glTF of the rest pose has at file_vertices(), as exactly as tolerance() has its surface, and
  /// the same in all poses. Their v counts from the image's first row as Vulkan samples it (1 - v
  /// of the mesh's). Empty unless SystemOptions::textured. Made anew for each call.
  [[nodiscard]] std::vector<glm::vec2> uvs() const;
  /// Which vertex of `planish fit`'s glTF each vertex is, to index what was baked for that file:
  /// its vertices on seams stand in another order, and several here may be one there. It is the
  /// file of the same mesh and level, not packed (without --compress meshopt); its vertices are
  /// counted through all primitives, of which groups of faces have one each, and one that several
  /// have is the first one's. -1: the file has none, as only holes name the vertex. Made anew for
  /// each call.
  [[nodiscard]] std::vector<std::int32_t> file_vertices() const;
  /// The same three at a level that is the System's or one of SystemOptions::levels, for the level
  /// draws of a Tessellation (Tessellation::level_draw). Throws Error{InvalidArgument} for another
  /// one.
  [[nodiscard]] std::vector<SurfacePlace> places(int level) const;
  [[nodiscard]] std::vector<glm::vec2> uvs(int level) const;
  [[nodiscard]] std::vector<std::int32_t> file_vertices(int level) const;
  /// Three indices a triangle, counter-clockwise seen from outside; holes are left out. Those of
  /// `planish fit`'s glTF: quads are cut along the diagonal that suits the surface in the rest
  /// pose, which all poses keep, and the polygons of level 0 likewise.
  [[nodiscard]] std::span<const std::uint32_t> triangles() const;
  /// Four indices a quad; empty at level 0, whose faces are the mesh's polygons.
  [[nodiscard]] std::span<const std::uint32_t> quads() const;

  /// Of each of SystemOptions::levels, how far its triangles are from the surface in the rest pose:
  /// the largest distance from them of its points at the middles of quads and of quads' sides.
  [[nodiscard]] std::vector<double> chord_errors() const;

  /// B: row i gives the limit point of used vertex i from all control points. Without rows where
  /// the method is Fair.
  [[nodiscard]] StencilView<double> limit_masks() const;
  /// What devices need to know of the surface.
  [[nodiscard]] const SurfaceRecords& surface_records() const;

  /// What the fair method needs to know of the mesh; null where the method is another.
  [[nodiscard]] const FairRecords* fair_records() const;

  /// What SystemOptions::within came to, in the mesh's units; 0 where points are not moved.
  [[nodiscard]] double within() const;
  /// Null there.
  [[nodiscard]] const BendingRecords* bending_records() const;

  /// Of the rest pose's bounding box.
  [[nodiscard]] double diagonal() const;
  /// The wanted error: SystemOptions::tolerance times the diagonal.
  [[nodiscard]] double tolerance() const;
  /// Lower bound of B's spectrum, which lies in (0, 1].
  [[nodiscard]] double spectral_bound() const;
  /// Largest distance of a rest vertex from its limit point before any iteration. This and all that
  /// tells of iterations is 0 where the method is Fair.
  [[nodiscard]] double rest_error() const;
  /// Iterations after which the rest pose, from a cold start, is within tolerance(); counted by
  /// solving it in double.
  [[nodiscard]] std::uint32_t rest_iterations() const;
  /// Iterations that suffice for any pose whose error before the first is `initial_error`. Proven
  /// for closed meshes without sharp edges, where it holds with room to spare: the bound is on a
  /// sum over all vertices, the error wanted is one vertex's.
  [[nodiscard]] std::uint32_t sufficient_iterations(double initial_error) const;

 private:
  struct Parts;
  std::unique_ptr<const Parts> parts_;
};

struct DeviceSystemOptions {
  /// Largest stride of the vertex layouts that Solves of this system will write.
  std::uint32_t max_vertex_stride = 64;
  /// Places can be asked for: more tables, 8 bytes a corner and some 60 kB for each kind of corner
  /// (valence, face size, what is sharp).
  bool answers_places = false;
  /// Solves can take edits: more tables, some 60 bytes a vertex of a quad mesh. Only where the
  /// method is progressive and SystemOptions::within is 0.
  bool takes_edits = false;
};

/// A range of a host's buffer that receives 3 * 4 bytes for each triangle: uint32 indices, usable
/// as an index buffer. VK_BUFFER_USAGE_TRANSFER_DST_BIT. No buffer: indices are not written.
struct IndexTarget {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize offset = 0;
};

class Solve;

/// The tables of a System on a device, shared by all instances of the mesh and all frames.
class DeviceSystem {
 public:
  /// Takes the memory. Throws Error{OutOfMemory} naming the limit that cannot be met, VulkanError.
  DeviceSystem(Context& context, const System& system, const DeviceSystemOptions& options = {});
  ~DeviceSystem();
  DeviceSystem(DeviceSystem&&) noexcept;
  DeviceSystem& operator=(DeviceSystem&&) noexcept;

  /// Bytes of staging memory that the upload takes.
  [[nodiscard]] std::uint64_t upload_bytes() const;
  /// Fills the host's staging memory, upload_bytes() long; `system` is the one that this was made
  /// from. Once: until then tables are held in the host's memory, too. May run on any thread.
  /// Throws Error{InvalidArgument} for another size or System, and the second time.
  void write_upload(const System& system, std::span<std::byte> staging) const;
  /// Copies from [offset, offset + upload_bytes()) of the host's buffer, which has
  /// VK_BUFFER_USAGE_TRANSFER_SRC_BIT; offset is a multiple of 4. The host's writes have been made
  /// visible (by flushing and submitting). To be run once, before any solve.
  void record_upload(VkCommandBuffer commands, VkBuffer staging, VkDeviceSize offset,
                     const IndexTarget& indices = {}) const noexcept;

  [[nodiscard]] std::uint32_t index_count() const;
  [[nodiscard]] std::int32_t given_count() const;
  [[nodiscard]] std::int32_t vertex_count() const;
  /// Of an instance at each of SystemOptions::levels.
  [[nodiscard]] std::vector<std::int32_t> level_vertex_counts() const;
  /// Bytes that the buffer of a Tessellation's vertices has at least, of a Solve of so many
  /// instances; options.vertices.buffer may still be missing. Throws Error{InvalidArgument} for
  /// wrong places.
  [[nodiscard]] std::uint64_t tessellation_bytes(const TessellationOptions& options,
                                                 std::uint32_t instances) const;
  /// Dispatches that one pass over all tables takes: more where the device's limits are low.
  [[nodiscard]] std::size_t slice_count() const;
  /// Device memory that the tables take.
  [[nodiscard]] std::uint64_t device_bytes() const;

 private:
  struct Parts;
  friend class Places;
  friend class Solve;
  friend class Tessellation;
  friend SurfaceBuffers surface_buffers(const DeviceSystem&, const Solve&, std::uint32_t);
  std::unique_ptr<Parts> parts_;
};

/// One of the solves that record_solves puts beside each other.
struct SolveCall {
  const Solve* solve;
  SolveParameters parameters;
};

/// One of the evaluations that record_evaluates puts beside each other.
struct EvaluateCall {
  const Solve* solve;
  EvaluateParameters parameters;
};

/// One mesh that moves, or several instances of it: moves control points until the limit surface
/// passes through the given points, then evaluates it. Externally synchronised.
class Solve {
 public:
  /// Throws Error{InvalidArgument} for a layout, Error{OutOfMemory} naming the limit, VulkanError.
  Solve(Context& context, const DeviceSystem& system, const SolveOptions& options = {});
  ~Solve();
  Solve(Solve&&) noexcept;
  Solve& operator=(Solve&&) noexcept;

  /// Forgets the last displacement. After a jump of the pose, and before a first warm start.
  void record_reset(VkCommandBuffer commands) const noexcept;
  /// Copies given points, 12 tight bytes each, all of an instance after those of the last, from a
  /// host's buffer with VK_BUFFER_USAGE_TRANSFER_SRC_BIT; offset is a multiple of 4. For the next
  /// solve of a slot without a GivenPoints buffer; does nothing where all have one.
  void record_given(VkCommandBuffer commands, VkBuffer source, VkDeviceSize offset) const noexcept;
  /// Finds the displacement of the control points from the given points as they are when it runs.
  void record_solve(VkCommandBuffer commands, const SolveParameters& parameters) const noexcept;
  /// Limit positions and normals of the last solve, of whatever slot, into the buffer of the
  /// slot's VertexLayout. Read them as vertices after a barrier from kExitScope to VERTEX_INPUT,
  /// VERTEX_ATTRIBUTE_READ; build acceleration structures of them, or refit, as triangles stay the
  /// same, after one to ACCELERATION_STRUCTURE_BUILD_KHR, SHADER_READ.
  void record_evaluate(VkCommandBuffer commands,
                       const EvaluateParameters& parameters = {}) const noexcept;
  /// The part of record_evaluate that Places need, the surface's control points, for who wants no
  /// vertices: record_evaluate does it, too.
  void record_surface(VkCommandBuffer commands) const noexcept;
  /// Moves the points that SolveOptions::moved lists to where GivenPoints' buffer has them, solves
  /// and evaluates what they reach, and nothing else: vertices, control_points() and what Places
  /// read change in place, and what is not reached keeps its bits. Costs what it reaches, not what
  /// the mesh has; an empty list costs empty dispatches. Points of faces with 32 corners or more,
  /// and sums of rings of as many, are the exception: each edit makes all of them. Where an edit
  /// reaches a tenth of the mesh and more, record_solve and record_evaluate take less time.
  /// A record_solve and its record_evaluate (or record_surface) came before. Edits go on from
  /// edits, and solves (warm starts, too) from them. Points that moved without being listed wait
  /// for the next solve. Afterwards record_status tells of the edit: residual is the largest among
  /// points that it reached, the others keep theirs; above stop_error a warm solve helps. So all
  /// points are within the largest stop_error that was met. Vertices are written in place: a draw
  /// that still reads them is waited for by a barrier to kEntryScope. With slots each list is taken
  /// once, by one slot's edit, whose vertices then also get what edits of other slots have moved
  /// since its last; before a slot's first edit after a solve its record_evaluate came. Solves take
  /// all points from their slot's buffer, so that the host writes what it moved to all of these.
  /// A slot without MovedPoints has no edits: nothing is recorded, and HostDevice::log is told.
  void record_edit(VkCommandBuffer commands, const EditParameters& parameters) const noexcept;
  /// Copies an EditReach of the last edit to a host's buffer, as record_status does.
  void record_reach(VkCommandBuffer commands, VkBuffer target, VkDeviceSize offset) const noexcept;
  /// Copies a GpuStatus of the last solve or edit for each instance, one after another, to a host's
  /// buffer with VK_BUFFER_USAGE_TRANSFER_DST_BIT; offset is a multiple of 4. The host polls it
  /// when it likes, after its own fence.
  void record_status(VkCommandBuffer commands, VkBuffer target, VkDeviceSize offset) const noexcept;

  /// The control cage's points after record_evaluate: four floats each (the last is 0), one per
  /// used vertex; may be bound as a vertex or storage buffer. One for all slots, so that what reads
  /// it is waited for, by a barrier to kEntryScope, before the next frame's work. Where the method
  /// is Fair the state of level 1, as Subdivision documents it, after record_solve. Owned by the
  /// Solve.
  [[nodiscard]] VkBuffer control_points() const;
  /// Bytes from an instance's control points to the next one's there.
  [[nodiscard]] VkDeviceSize control_point_stride() const;
  [[nodiscard]] std::uint32_t instance_count() const;

 private:
  struct Parts;
  friend void record_solves(VkCommandBuffer, std::span<const SolveCall>) noexcept;
  friend void record_evaluates(VkCommandBuffer, std::span<const EvaluateCall>) noexcept;
  friend class Places;
  friend class Tessellation;
  friend SurfaceBuffers surface_buffers(const DeviceSystem&, const Solve&, std::uint32_t);
  [[nodiscard]] SolvePoints surface_points(std::uint32_t instance) const;
  [[nodiscard]] EvaluatedParts evaluated_parts() const;
  std::unique_ptr<Parts> parts_;
};

/// The work of record_solve of each call, in lock-step: one barrier stands where each solve by
/// itself would have one, so that small meshes fill a device together. Results are the same bits.
/// Each call is of another Solve; Contexts are of one device; systems, methods and parameters may
/// differ. Each call's timestamps stand around the whole. Nothing is recorded for no calls.
/// Dispatches are not shared: see "Many meshes" above.
void record_solves(VkCommandBuffer commands, std::span<const SolveCall> calls) noexcept;
/// The same of record_evaluate. Vertices of several Solves in one buffer start at multiples of 256
/// bytes: elsewhere validation layers may suspect a hazard where bindings overlap.
void record_evaluates(VkCommandBuffer commands, std::span<const EvaluateCall> calls) noexcept;

}  // namespace planish::vulkan
