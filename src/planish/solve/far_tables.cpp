#include "planish/solve/far_tables.h"

#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "planish/core/error.h"
#include "planish/core/parallel.h"
#include "planish/solve/refiner.h"

namespace planish {
namespace {

// What the factory below takes for a mesh.
struct RefinerSource {
  const PolygonMesh& mesh;
  const MeshTopology& topology;
  const RefinerOptions& options;
};

constexpr std::size_t kGrain = 4096;

}  // namespace
}  // namespace planish

namespace OpenSubdiv::OPENSUBDIV_VERSION::Far {

// OpenSubdiv asks to be given complete topology by specialising these members.

using planish::kGrain;
using planish::MeshTopology;
using planish::RefinerSource;
using SourceFactory = TopologyRefinerFactory<RefinerSource>;

template <>
bool SourceFactory::resizeComponentTopology(TopologyRefiner& refiner, const RefinerSource& source) {
  const MeshTopology& topology = source.topology;
  setNumBaseVertices(refiner, topology.vertex_count());
  setNumBaseFaces(refiner, topology.face_count());
  setNumBaseEdges(refiner, topology.edge_count());
  for (int f = 0; f < topology.face_count(); ++f)
    setNumBaseFaceVertices(refiner, f, topology.face_size(f));
  for (int e = 0; e < topology.edge_count(); ++e)
    setNumBaseEdgeFaces(refiner, e, topology.is_boundary_edge(e) ? 1 : 2);
  for (int v = 0; v < topology.vertex_count(); ++v) {
    setNumBaseVertexFaces(refiner, v, static_cast<int>(topology.corners_at(v).size()));
    setNumBaseVertexEdges(refiner, v, topology.valence(v));
  }
  return true;
}

template <>
bool SourceFactory::assignComponentTopology(TopologyRefiner& refiner, const RefinerSource& source) {
  const MeshTopology& topology = source.topology;
  planish::parallel_each(topology.face_count(), kGrain, [&](std::size_t i) {
    const auto f = static_cast<int>(i);
    IndexArray vertices = getBaseFaceVertices(refiner, f), edges = getBaseFaceEdges(refiner, f);
    std::copy_n(topology.face(f).begin(), vertices.size(), vertices.begin());
    std::copy_n(topology.face_edges(f).begin(), edges.size(), edges.begin());
  });
  planish::parallel_each(topology.edge_count(), kGrain, [&](std::size_t i) {
    const auto e = static_cast<int>(i);
    const int corners[] = {topology.corner_of(e), topology.twin(topology.corner_of(e))};
    const auto ends = topology.edge_vertices(e);
    getBaseEdgeVertices(refiner, e)[0] = ends.first;
    getBaseEdgeVertices(refiner, e)[1] = ends.second;
    IndexArray faces = getBaseEdgeFaces(refiner, e);
    LocalIndexArray places = getBaseEdgeFaceLocalIndices(refiner, e);
    for (int k = 0; k < faces.size(); ++k) {
      faces[k] = topology.face_of(corners[k]);
      places[k] = static_cast<LocalIndex>(topology.place_of(corners[k]));
    }
  });
  planish::parallel_each(topology.vertex_count(), kGrain, [&](std::size_t i) {
    const auto v = static_cast<int>(i);
    const auto corners = topology.corners_at(v);
    IndexArray faces = getBaseVertexFaces(refiner, v), edges = getBaseVertexEdges(refiner, v);
    LocalIndexArray places = getBaseVertexFaceLocalIndices(refiner, v);
    LocalIndexArray ends = getBaseVertexEdgeLocalIndices(refiner, v);
    for (int k = 0; k < faces.size(); ++k) {
      faces[k] = topology.face_of(corners[k]);
      places[k] = static_cast<LocalIndex>(topology.place_of(corners[k]));
    }
    for (int k = 0; k < edges.size(); ++k) {
      edges[k] = k < faces.size() ? topology.edge_of(corners[k])
                                  : topology.edge_of(topology.prev(corners.back()));
      ends[k] = topology.edge_vertices(edges[k]).first == v ? 0 : 1;
    }
  });
  return true;
}

template <>
bool SourceFactory::assignComponentTags(TopologyRefiner& refiner, const RefinerSource& source) {
  if (!source.options.sharp.use_tags) return true;
  for (const planish::CreaseEdge& crease : source.mesh.creases) {
    const int edge = source.topology.find_edge(crease.v0, crease.v1);
    if (edge >= 0) setBaseEdgeSharpness(refiner, edge, crease.sharpness);
  }
  for (const planish::CornerVertex& corner : source.mesh.corners)
    setBaseVertexSharpness(refiner, corner.vertex, corner.sharpness);
  return true;
}

template <>
bool SourceFactory::assignFaceVaryingTopology(TopologyRefiner& refiner,
                                              const RefinerSource& source) {
  const planish::PolygonMesh& mesh = source.mesh;
  if (mesh.face_uvs.empty()) return true;
  const auto uv_count = static_cast<int>(mesh.uvs.size());
  const int channel = createBaseFVarChannel(refiner, uv_count + 1);
  planish::parallel_each(mesh.face_count(), kGrain, [&](std::size_t i) {
    const auto f = static_cast<int>(i);
    IndexArray values = getBaseFaceFVarValues(refiner, f, channel);
    for (int k = 0; k < values.size(); ++k) {
      const std::int32_t uv = mesh.face_uvs[mesh.face_offsets[i] + k];
      values[k] = uv < 0 ? uv_count : uv;
    }
  });
  return true;
}

}  // namespace OpenSubdiv::OPENSUBDIV_VERSION::Far

namespace planish {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;

std::unique_ptr<Far::TopologyRefiner> make_refiner(const PolygonMesh& mesh,
                                                   const RefinerOptions& options,
                                                   const MeshTopology& topology) {
  // OpenSubdiv's default boundary option tags every boundary face a hole.
  Sdc::Options rules;
  rules.SetVtxBoundaryInterpolation(options.sharp.boundary == BoundaryRule::EdgeAndCorner
                                        ? Sdc::Options::VTX_BOUNDARY_EDGE_AND_CORNER
                                        : Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
  rules.SetFVarLinearInterpolation(Sdc::Options::FVAR_LINEAR_ALL);
  using Factory = Far::TopologyRefinerFactory<RefinerSource>;
  std::unique_ptr<Far::TopologyRefiner> refiner(
      Factory::Create({mesh, topology, options}, Factory::Options(options.scheme, rules)));
  if (!refiner) {
    throw Error(ErrorCode::UnusableMesh,
                "OpenSubdiv refuses the mesh's topology; `planish inspect` lists its problems");
  }
  return refiner;
}

namespace {

// A table's arrays without gaps between its rows, as OpenSubdiv copies them.
template <class Real>
struct FarArrays {
  explicit FarArrays(const StencilView<double>& table)
      : sizes(table.sizes.begin(), table.sizes.end()) {
    for (std::size_t row = 0; row < sizes.size(); ++row) {
      offsets.push_back(static_cast<int>(indices.size()));
      const auto first = static_cast<std::size_t>(table.offsets[row]);
      const auto append = [&](const auto& from, auto& to) {
        if (from.empty()) return;
        const auto entries = from.subspan(first, static_cast<std::size_t>(sizes[row]));
        to.insert(to.end(), entries.begin(), entries.end());
      };
      append(table.indices, indices);
      append(table.weights, weights);
      append(table.du_weights, du_weights);
      append(table.dv_weights, dv_weights);
    }
  }

  std::vector<int> sizes, offsets{}, indices{};
  std::vector<Real> weights{}, du_weights{}, dv_weights{};
};

// OpenSubdiv's constructors are protected.
template <class Real>
struct OwnTable : FarStencilTable<Real> {
  OwnTable(int source_count, const FarArrays<Real>& from)
      : FarStencilTable<Real>(source_count, from.offsets, from.sizes, from.indices, from.weights,
                              /*includeCoarseVerts=*/false, /*firstOffset=*/0) {}
};

template <class Real>
struct OwnLimitTable : FarLimitStencilTable<Real> {
  OwnLimitTable(int source_count, const FarArrays<Real>& from)
      : FarLimitStencilTable<Real>(source_count, from.offsets, from.sizes, from.indices,
                                   from.weights, from.du_weights, from.dv_weights, {}, {}, {},
                                   /*includeCoarseVerts=*/false, /*firstOffset=*/0) {}
};

}  // namespace

template <class Real>
std::unique_ptr<const FarStencilTable<Real>> to_far(const StencilView<double>& table) {
  return std::make_unique<const OwnTable<Real>>(table.source_count, FarArrays<Real>(table));
}

template <class Real>
std::unique_ptr<const FarLimitStencilTable<Real>> to_far_limit(const StencilView<double>& table) {
  return std::make_unique<const OwnLimitTable<Real>>(table.source_count, FarArrays<Real>(table));
}

template std::unique_ptr<const FarStencilTable<float>> to_far<float>(const StencilView<double>&);
template std::unique_ptr<const FarStencilTable<double>> to_far<double>(const StencilView<double>&);
template std::unique_ptr<const FarLimitStencilTable<float>> to_far_limit<float>(
    const StencilView<double>&);
template std::unique_ptr<const FarLimitStencilTable<double>> to_far_limit<double>(
    const StencilView<double>&);

}  // namespace planish
