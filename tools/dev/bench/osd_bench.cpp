#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/ompEvaluator.h>

#include <memory>

#include "bench/benchmarks.h"
#include "bench/gl_stencils.h"
#include "planish/solve/backend.h"
#ifdef PLANISH_HAS_VULKAN
#include "planish/osd/vk_compute_evaluator.h"
#include "planish/osd/vk_vertex_buffer.h"
#include "planish/vulkan/device/own_device.h"
#include "planish/vulkan/vulkan_backend.h"
#endif

namespace planish::bench {

namespace {

using namespace OpenSubdiv;

constexpr int kLevel = 2;
const Osd::BufferDescriptor kTight(0, 3, 3);

std::unique_ptr<const Far::StencilTable> refinement_of(const PolygonMesh& mesh) {
  const std::vector<int> sizes(mesh.face_count(), 4);
  Far::TopologyDescriptor descriptor;
  descriptor.numVertices = mesh.vertex_count();
  descriptor.numFaces = mesh.face_count();
  descriptor.numVertsPerFace = sizes.data();
  descriptor.vertIndicesPerFace = mesh.face_vertices.data();
  using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
  const std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create(descriptor, Factory::Options(Sdc::SCHEME_CATMARK)));
  refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(kLevel));
  Far::StencilTableFactory::Options options;
  options.generateIntermediateLevels = false;
  options.generateOffsets = true;
  return std::unique_ptr<const Far::StencilTable>(
      Far::StencilTableFactory::Create(*refiner, options));
}

std::vector<glm::dvec3> points_of(const std::vector<float>& floats) {
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < floats.size(); i += 3)
    points.emplace_back(floats[i], floats[i + 1], floats[i + 2]);
  return points;
}

/// The table, what it is applied to, and what Osd::CpuEvaluator makes of that.
struct Refinement {
  explicit Refinement(const PolygonMesh& mesh) : table(refinement_of(mesh)) {
    for (const glm::dvec3& p : mesh.positions)
      for (int k = 0; k < 3; ++k) source.push_back(static_cast<float>(p[k]));
    target.resize(3 * std::size_t(table->GetNumStencils()));
    run<Osd::CpuEvaluator>();
    expected = points_of(target);
  }

  template <class Evaluator>
  void run() {
    Evaluator::EvalStencils(source.data(), kTight, target.data(), kTight, table->GetSizes().data(),
                            table->GetOffsets().data(), table->GetControlIndices().data(),
                            table->GetWeights().data(), 0, table->GetNumStencils());
  }

  std::unique_ptr<const Far::StencilTable> table;
  std::vector<float> source, target;
  std::vector<glm::dvec3> expected;
};

Peer cpu_peer(const Refinement& from) {
  // Planish applies tables in double.
  struct State {
    std::vector<double> weights;
    StencilView<double> view;
    std::vector<glm::dvec3> source, target;
  };
  const auto state = std::make_shared<State>();
  const std::size_t entries = from.table->GetControlIndices().size();
  state->weights.assign(from.table->GetWeights().begin(),
                        from.table->GetWeights().begin() + entries);
  state->view.source_count = from.table->GetNumControlVertices();
  state->view.sizes = from.table->GetSizes();
  state->view.offsets = from.table->GetOffsets();
  state->view.indices = from.table->GetControlIndices();
  state->view.weights = state->weights;
  state->source = points_of(from.source);
  state->target.resize(static_cast<std::size_t>(from.table->GetNumStencils()));
  const auto run = [state] { apply(state->view, state->source, state->target); };
  run();
  require_agreement("planish-cpu-double", state->target, from.expected);
  return {"planish-cpu-double", run};
}

#ifdef PLANISH_HAS_VULKAN
/// The evaluator submits; the peer waits for its end.
struct VulkanState {
  VulkanState(const Refinement& from, const std::string& wanted)
      : device(vulkan::OwnDeviceOptions{.wanted = wanted}),
        context(device),
        where(context, device.queue(), device.capabilities().compute_family),
        source(osd::VkVertexBuffer::Create(3, static_cast<int>(from.source.size() / 3), &where)),
        target(osd::VkVertexBuffer::Create(3, static_cast<int>(from.target.size() / 3), &where)),
        table(osd::VkStencilTable::Create(from.table.get(), &where)),
        kernels(osd::VkComputeEvaluator::Create(kTight, kTight, {}, {}, &where)) {
    source->UpdateData(from.source.data(), 0, source->GetNumVertices(), &where);
  }

  void run() {
    kernels->EvalStencils(source.get(), kTight, target.get(), kTight, table.get());
    where.Synchronize();
  }

  vulkan::OwnDevice device;
  vulkan::Context context;
  osd::VkDeviceContext where;
  std::unique_ptr<osd::VkVertexBuffer> source, target;
  std::unique_ptr<osd::VkStencilTable> table;
  std::unique_ptr<osd::VkComputeEvaluator> kernels;
};

void add_vulkan(const Refinement& from, const std::string& wanted, Group& group) {
  if (list_vulkan_devices().best < 0) {
    group.size += ", no Vulkan";
    return;
  }
  const auto state = std::make_shared<VulkanState>(from, wanted);
  state->run();
  std::vector<float> result(from.target.size());
  state->target->ReadData(result.data(), 0, state->target->GetNumVertices(), &state->where);
  require_agreement("planish-vulkan", points_of(result), from.expected);
  group.size += ", Vulkan on " + state->device.capabilities().name;
  group.peers.push_back({"planish-vulkan", [state] { state->run(); }});
}
#endif

void add_gl(const Refinement& from, Group& group) {
  const std::shared_ptr<GlStencils> gl = make_gl_stencils(*from.table, from.source);
  if (!gl) {
    group.size += ", no GL";
    return;
  }
  gl->run();
  require_agreement("osd-gl", points_of(gl->result()), from.expected);
  group.size += ", GL on " + gl->renderer();
  group.peers.push_back({"osd-gl", [gl] { gl->run(); }});
}

}  // namespace

std::vector<Row> bench_osd(const Options& options) {
  // Every face becomes 16 quads.
  Refinement refinement(torus_grid(options.quad_count / 16));
  Group group;
  group.name = "osd";
  group.size = std::to_string(refinement.table->GetNumStencils()) + " stencils, " +
               std::to_string(refinement.table->GetControlIndices().size()) + " entries";
  group.baseline = "osd-cpu";
  group.peers = {{"osd-cpu", [&] { refinement.run<Osd::CpuEvaluator>(); }},
                 {"osd-omp", [&] { refinement.run<Osd::OmpEvaluator>(); }},
                 cpu_peer(refinement)};
#ifdef PLANISH_HAS_VULKAN
  add_vulkan(refinement, options.device, group);
#endif
  add_gl(refinement, group);
  return run_group(group, options.repetitions);
}

}  // namespace planish::bench
