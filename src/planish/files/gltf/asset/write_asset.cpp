#include "planish/files/gltf/asset/write_asset.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/core/json.h"
#include "planish/files/gltf/asset/asset_document.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/gltf_buffer.h"
#include "planish/files/gltf/gltf_container.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_payload.h"
#include "planish/files/gltf/gltf_survey.h"
#include "planish/files/input_files.h"

namespace planish {
namespace {

using nlohmann::json;

// By group, whether its triangles are to encode polygons; packing by Meshopt brings triangles into
// another order.
std::vector<std::uint8_t> ngon_groups(const GltfAsset& asset, const AssetSurface& one) {
  std::vector<std::uint8_t> flags;
  if (one.options.compression == GltfCompression::Meshopt) return flags;
  const json& primitives = asset.root().value()["meshes"][one.mesh]["primitives"];
  for (const AssetGroup& group : one.vertices->groups) {
    const json& given = primitives[group.primitive];
    flags.push_back(given.contains("extensions") && given["extensions"].contains(kNgonExtension));
  }
  return flags;
}

// Options of each surface that tell how far all of them are: first one after another is surveyed,
// or packed, then one after another is written.
std::vector<GltfOptions> options_of_all(const GltfAsset& asset,
                                        std::span<const AssetSurface> surfaces,
                                        const Callbacks& common,
                                        const std::shared_ptr<const bool>& is_writing) {
  double all = 0, done = 0;
  for (const AssetSurface& one : surfaces)
    all += static_cast<double>(one.surface->info().corner_count);
  std::vector<GltfOptions> options;
  const auto farthest = std::make_shared<double>(0);
  for (const AssetSurface& one : surfaces) {
    GltfOptions& own = options.emplace_back(one.options);
    own.ngon_groups = ngon_groups(asset, one);
    const double begin = done / all;
    done += static_cast<double>(one.surface->info().corner_count);
    const double end = done / all;
    const double first = own.compression == GltfCompression::None ? kGltfSurveyed : 1;
    // Where a survey ends and where writing begins are the same fraction, and not the same place.
    const auto place = [=](double fraction) {
      if (fraction < first || first == 1 || !*is_writing)
        return std::lerp(first * begin, first * end, fraction / first);
      return std::lerp(std::lerp(first, 1, begin), std::lerp(first, 1, end),
                       (fraction - first) / (1 - first));
    };
    own.callbacks.progress = {};
    if (common.progress)
      own.callbacks.progress = [report = common.progress, place, farthest](std::string_view step,
                                                                           double fraction) {
        *farthest = std::max(*farthest, place(fraction));
        report(step, *farthest);
      };
  }
  return options;
}

// `uri`: of the buffer of a .gltf; empty: a GLB.
GltfWhole assembled(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                    const Callbacks& common, const std::string& uri, bool keeps_files) {
  std::set<std::int64_t> replaced;
  for (const AssetSurface& surface : surfaces) replaced.insert(surface.mesh);
  AssetDocument document(asset, replaced, keeps_files);
  // Images come before surfaces.
  std::vector<std::vector<std::int64_t>> images;
  for (const AssetSurface& surface : surfaces) {
    std::vector<std::int64_t>& of_maps = images.emplace_back();
    for (const AssetNormalMap& map : surface.normal_maps)
      of_maps.push_back(map.png.empty() ? -1 : document.add_image(map.png, "image/png"));
  }
  const auto is_writing = std::make_shared<bool>(false);
  const auto options = std::make_shared<const std::vector<GltfOptions>>(
      options_of_all(asset, surfaces, common, is_writing));
  auto payloads = std::make_shared<std::vector<GltfPayload>>();
  GltfWhole whole;
  std::set<std::int64_t> replaced_now;
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const AssetSurface& one = surfaces[i];
    const GltfPayload& payload =
        payloads->emplace_back(payload_of(*one.surface, (*options)[i], uri.empty()));
    GltfOptions described = one.options;
    if (surfaces.size() > 1) described.extras.clear();
    // One after another, each in the only mesh of a document of its own.
    const json made = json::parse(payload_json(payload, described, {}));
    if (replaced_now.insert(one.mesh).second) {
      document.replace(one.mesh, *one.vertices, payload.document, made, one.least_coverage);
    } else {
      document.add_level(one.mesh, *one.vertices, payload.document, made, one.least_coverage);
    }
    if (!one.normal_maps.empty())
      document.set_normal_maps(one.mesh, payload.document, one, images[i]);
    if (made["asset"].contains("extras")) document.add_extras(made["asset"]["extras"]);
    whole.vertex_count += payload.vertex_count;
    whole.triangle_count += payload.triangle_count;
  }
  whole.json = document.text(uri);
  for (const Warning& warning : document.warnings()) common.warn(warning);
  whole.buffer_bytes = document.buffer_bytes();
  // Payloads read their options.
  whole.write_buffer = [options, payloads, is_writing,
                        kept = document.kept()](std::span<const ByteSink> sinks) {
    *is_writing = true;
    for (const std::span<const std::byte> bytes : kept) write_padded(bytes, sinks);
    for (const GltfPayload& payload : *payloads) payload.write_buffer(sinks);
  };
  return whole;
}

GltfWhole whole_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                      const Callbacks& common, const std::string& uri, bool keeps_files) {
  return guard_json(asset.file().name,
                    [&] { return assembled(asset, surfaces, common, uri, keeps_files); });
}

bool is_same_folder(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code error;
  const auto named = [](const std::filesystem::path& folder) {
    return folder.empty() ? std::filesystem::path(".") : folder;
  };
  return std::filesystem::equivalent(named(a), named(b), error);
}

}  // namespace

GltfFile write_asset(const std::filesystem::path& path, const std::filesystem::path& folder,
                     const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                     const GltfOptions& common) {
  const HostScope host(common.callbacks);
  require_apart(asset.file().path, path, *format_of(path));
  const bool is_glb = info_of(*format_of(path)).format == FileFormat::Glb;
  const bool keeps_files = !is_glb && !asset.file().path.empty() &&
                           is_same_folder(asset.file().path.parent_path(), folder);
  const std::string uri = is_glb ? "" : encode_uri(gltf_buffer_path(path, 0).filename().string());
  const GltfWhole whole = whole_asset(asset, surfaces, common.callbacks, uri, keeps_files);
  GltfFile written{is_glb ? write_glb(path, whole, common) : write_pair(path, whole, common),
                   whole.vertex_count, whole.triangle_count, std::size_t{is_glb ? 0U : 1U}};
  common.callbacks.report("write", 1);
  return written;
}

std::vector<std::byte> encode_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                                    const GltfOptions& common) {
  const HostScope host(common.callbacks);
  std::vector<std::byte> bytes =
      glb_bytes(whole_asset(asset, surfaces, common.callbacks, {}, false), common);
  common.callbacks.report("write", 1);
  return bytes;
}

}  // namespace planish
