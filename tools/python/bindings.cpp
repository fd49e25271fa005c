#include "bindings.h"

#include <pybind11/pybind11.h>

#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "call.h"
#include "planish/core/error.h"
#include "planish/core/version.h"

namespace planish::python {
namespace {

// What is plain goes as it stands in memory; of everything else fields() names the parts, once for
// both directions.

template <class Value>
inline constexpr bool is_plain = std::is_trivially_copyable_v<Value> && !std::is_pointer_v<Value>;

template <class Archive>
void fields(Archive& archive, FaceGroup& group) {
  archive(group.name, group.material);
}

template <class Archive>
void fields(Archive& archive, VertexAttribute& attribute) {
  archive(attribute.name, attribute.values, attribute.width);
}

template <class Archive>
void fields(Archive& archive, PolygonMesh& mesh) {
  archive(mesh.positions, mesh.face_offsets, mesh.face_vertices, mesh.creases, mesh.corners,
          mesh.uvs, mesh.face_uvs, mesh.colors, mesh.attributes, mesh.groups, mesh.face_groups,
          mesh.hole_faces);
}

template <class Archive>
void fields(Archive& archive, SurfaceMesh& surface) {
  archive(surface.level, surface.positions, surface.normals, surface.face_offsets,
          surface.face_vertices, surface.base_vertices, surface.uvs, surface.face_uvs,
          surface.colors, surface.attributes, surface.groups, surface.face_groups);
}

template <class Archive>
void fields(Archive& archive, LevelOne& level_one) {
  archive(level_one.state, level_one.placement);
}

template <class Archive>
void fields(Archive& archive, FairDecisions& made) {
  archive(made.reversed, made.halvings, made.late_halvings, made.cures, made.leans, made.ellipses,
          made.planes);
}

template <class Archive>
void fields(Archive& archive, FairFit& fair) {
  archive(fair.level_one, fair.least_polygon, fair.shrunk_vertices, fair.reversed_vertices,
          fair.cured_vertices, fair.flagged_edges, fair.flagged_faces, fair.rounds, fair.decisions,
          fair.sharp_decisions);
}

template <class Archive>
void fields(Archive& archive, Interpolation& found) {
  archive(found.displacement, found.converged, found.stop_reason, found.iterations, found.error,
          found.worst_vertex, found.history, found.upload_milliseconds);
}

template <class Archive>
void fields(Archive& archive, WithinFit& within) {
  archive(within.within, within.noise, within.distance, within.at_bound, within.bending_before,
          within.bending_after, within.exact, within.left);
}

// What prepare_mesh() makes is made again.
template <class Archive>
void fields(Archive& archive, Fit& fit) {
  archive(fit.cage, fit.fair, fit.within, fit.points, fit.interpolation, fit.placement,
          fit.spectral_bound, fit.stencil_entries, fit.sharp_edge_count, fit.boundary_edge_count,
          fit.corner_count, fit.timing);
}

// Without callbacks and what belongs to other meshes.
template <class Archive>
void fields(Archive& archive, FitOptions& options) {
  archive(options.method, options.scheme, options.weights, options.solver, options.tolerance,
          options.max_iterations, options.polish_steps, options.cures_folds,
          options.obeys_semi_sharp, options.within, options.sharp);
}

template <class Archive>
void fields(Archive& archive, SurfaceQuality& quality) {
  archive(quality.folded_area, quality.folded_area_elsewhere, quality.folded_places,
          quality.rms_normal_deviation, quality.max_normal_deviation, quality.bending);
}

template <class Archive>
void fields(Archive& archive, Candidate& candidate) {
  archive(candidate.faces, candidate.method, candidate.alone, candidate.converged, candidate.parts,
          candidate.folded_area, candidate.bending);
}

template <class Archive>
void fields(Archive& archive, Choice& choice) {
  archive(choice.candidates, choice.taken, choice.reason, choice.faces_reason);
}

template <class Archive>
void fields(Archive& archive, Warning& warning) {
  archive(warning.code, warning.message, warning.count, warning.first);
}

template <class Archive>
void fields(Archive& archive, FoundCreases& found) {
  archive(found.edges, found.corners);
}

template <class Archive>
void fields(Archive& archive, MeshDensity& density) {
  archive(density.vertex_count, density.even_share, density.is_refined);
}

template <class Archive>
void fields(Archive& archive, FittedMesh& fitted) {
  archive(fitted.mesh, fitted.fit, fitted.options, fitted.repairs, fitted.uses_tags,
          fitted.finds_features, fitted.crease_degrees, fitted.weld, fitted.split_normals,
          fitted.choice, fitted.level_one_quality, fitted.pairs_triangles, fitted.paired_count,
          fitted.added_vertices, fitted.choose_milliseconds, fitted.welded_count, fitted.density,
          fitted.source_vertices, fitted.source_faces, fitted.changed_faces, fitted.found,
          fitted.rounded_count, fitted.separated_edges, fitted.warnings, fitted.rest_positions);
}

template <class Archive>
void fields(Archive& archive, PythonMesh& mesh) {
  archive(mesh.mesh);
}

template <class Archive>
void fields(Archive& archive, PythonSurface& surface) {
  archive(surface.surface);
}

template <class Archive>
void fields(Archive& archive, PythonFit& fit) {
  archive(fit.fitted, fit.name, fit.threads, fit.precision, fit.seconds);
}

class Writer {
 public:
  explicit Writer(std::string& bytes) : bytes_(bytes) {}
  template <class... Values>
  void operator()(Values&... values) {
    (put(values), ...);
  }

 private:
  void put_plain(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }
  void put_count(std::size_t count) {
    const auto wide = static_cast<std::uint64_t>(count);
    put_plain(&wide, sizeof wide);
  }
  void put(std::string& text) {
    put_count(text.size());
    bytes_ += text;
  }
  template <class Value, class Allocator>
  void put(std::vector<Value, Allocator>& values) {
    put_count(values.size());
    if constexpr (is_plain<Value>) {
      put_plain(values.data(), sizeof(Value) * values.size());
    } else {
      for (Value& value : values) put(value);
    }
  }
  template <class Value>
  void put(RawVector<Value>& values) {
    put<Value>(static_cast<std::vector<Value, RawAllocator<Value>>&>(values));
  }
  template <class First, class Second>
  void put(std::pair<First, Second>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <class Value>
  void put(std::optional<Value>& value) {
    put_count(value ? 1 : 0);
    if (value) put(*value);
  }
  template <class Value>
  void put(Value& value) {
    if constexpr (is_plain<Value>) {
      put_plain(&value, sizeof value);
    } else {
      fields(*this, value);
    }
  }

  std::string& bytes_;
};

class Reader {
 public:
  explicit Reader(std::string_view bytes) : left_(bytes) {}
  template <class... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }
  [[nodiscard]] bool is_at_end() const { return left_.empty(); }
  [[noreturn]] static void fail(const std::string& what) {
    throw Error(ErrorCode::UnreadableInput, "pickle: " + what);
  }

 private:
  void get_plain(void* data, std::size_t size) {
    if (size > left_.size()) fail("its bytes end early");
    if (size > 0) std::memcpy(data, left_.data(), size);
    left_.remove_prefix(size);
  }
  // Of elements of at least so many bytes each, so that no more room is made than bytes follow.
  std::size_t get_count(std::size_t least_bytes) {
    std::uint64_t wide = 0;
    get_plain(&wide, sizeof wide);
    if (wide > left_.size() / least_bytes) fail("its bytes end early");
    return static_cast<std::size_t>(wide);
  }
  void get(std::string& text) {
    text.resize(get_count(1));
    get_plain(text.data(), text.size());
  }
  template <class Value, class Allocator>
  void get(std::vector<Value, Allocator>& values) {
    values.resize(get_count(is_plain<Value> ? sizeof(Value) : 1));
    if constexpr (is_plain<Value>) {
      get_plain(values.data(), sizeof(Value) * values.size());
    } else {
      for (Value& value : values) get(value);
    }
  }
  template <class Value>
  void get(RawVector<Value>& values) {
    get<Value>(static_cast<std::vector<Value, RawAllocator<Value>>&>(values));
  }
  template <class First, class Second>
  void get(std::pair<First, Second>& pair) {
    (*this)(pair.first, pair.second);
  }
  template <class Value>
  void get(std::optional<Value>& value) {
    value.reset();
    if (get_count(1) > 0) get(value.emplace());
  }
  template <class Value>
  void get(Value& value) {
    if constexpr (is_plain<Value>) {
      get_plain(&value, sizeof value);
    } else {
      fields(*this, value);
    }
  }

  std::string_view left_;
};

constexpr std::string_view kVersion = "planish " PLANISH_VERSION "\n";

template <class Held>
std::string all_of(char kind, const Held& held) {
  std::string bytes(kVersion);
  bytes += kind;
  Writer writer(bytes);
  fields(writer, const_cast<Held&>(held));  // which a Writer only reads
  return bytes;
}

template <class Held>
void read_all(std::string_view bytes, char kind, Held& held) {
  if (!bytes.starts_with(kVersion) || bytes.size() == kVersion.size())
    Reader::fail("it was made by another version than planish " PLANISH_VERSION
                 "; make the object again, or keep meshes in files");
  if (bytes[kVersion.size()] != kind) Reader::fail("it holds another kind of object");
  Reader reader(bytes.substr(kVersion.size() + 1));
  fields(reader, held);
  if (!reader.is_at_end()) Reader::fail("more bytes follow");
}

}  // namespace

std::string packed(const PythonMesh& mesh) { return all_of('M', mesh); }
std::string packed(const PythonSurface& surface) { return all_of('S', surface); }
std::string packed(const PythonFit& fit) { return all_of('F', fit); }

void unpack(std::string_view bytes, PythonMesh& mesh) { read_all(bytes, 'M', mesh); }
void unpack(std::string_view bytes, PythonSurface& surface) { read_all(bytes, 'S', surface); }
void unpack(std::string_view bytes, PythonFit& fit) {
  read_all(bytes, 'F', fit);
  FittedMesh& fitted = fit.fitted;
  fitted.fit.prepared = prepare_mesh(fitted.mesh, fit.name);
  fitted.prepared = fitted.fit.prepared;
}

}  // namespace planish::python

PYBIND11_MODULE(_planish, module) {
  namespace python = planish::python;
  module.doc() = "The compiled part of planish.";
  module.attr("__version__") = PLANISH_VERSION;
  python::register_errors();
  python::add_mesh(module);
  python::add_fit(module);
  python::add_limit(module);
  python::add_editor(module);
}
