#include "planish/files/gltf/asset/write_asset.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "planish/core/host_scope.h"
#include "planish/files/gltf/asset/asset_document.h"
#include "planish/files/gltf/asset/json_guard.h"
#include "planish/files/gltf/gltf_container.h"
#include "planish/files/gltf/gltf_layout.h"
#include "planish/files/gltf/gltf_payload.h"

namespace planish {
namespace {

using nlohmann::json;

// `uri`: of the buffer of a .gltf; empty: a GLB.
GltfWhole assembled(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                    const GltfOptions& common, const std::string& uri, bool keeps_files) {
  std::set<std::int64_t> replaced;
  for (const AssetSurface& surface : surfaces) replaced.insert(surface.mesh);
  AssetDocument document(asset, replaced, keeps_files);
  auto payloads = std::make_shared<std::vector<GltfPayload>>();
  GltfWhole whole;
  GltfOptions extras = common;
  for (const AssetSurface& one : surfaces) {
    const GltfPayload& payload =
        payloads->emplace_back(payload_of(*one.surface, one.options, uri.empty()));
    // One after another, each in the only mesh of a document of its own.
    const json made = json::parse(payload_json(payload, extras, {}));
    document.replace(one.mesh, *one.vertices, payload.document, made);
    if (made["asset"].contains("extras")) document.add_extras(made["asset"]["extras"]);
    whole.vertex_count += payload.vertex_count;
    whole.triangle_count += payload.triangle_count;
  }
  whole.json = document.text(uri);
  whole.buffer_bytes = document.buffer_bytes();
  whole.write_buffer = [payloads, kept = document.kept()](std::span<const ByteSink> sinks) {
    for (const std::span<const std::byte> bytes : kept) write_padded(bytes, sinks);
    for (const GltfPayload& payload : *payloads) payload.write_buffer(sinks);
  };
  return whole;
}

GltfWhole whole_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                      const GltfOptions& common, const std::string& uri, bool keeps_files) {
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
  const bool is_glb = info_of(*format_of(path)).format == FileFormat::Glb;
  const bool keeps_files = !is_glb && !asset.file().path.empty() &&
                           is_same_folder(asset.file().path.parent_path(), folder);
  const std::string uri = is_glb ? "" : encode_uri(gltf_buffer_path(path, 0).filename().string());
  const GltfWhole whole = whole_asset(asset, surfaces, common, uri, keeps_files);
  GltfFile written{is_glb ? write_glb(path, whole, common) : write_pair(path, whole, common),
                   whole.vertex_count, whole.triangle_count, std::size_t{is_glb ? 0U : 1U}};
  common.callbacks.report("write", 1);
  return written;
}

std::vector<std::byte> encode_asset(const GltfAsset& asset, std::span<const AssetSurface> surfaces,
                                    const GltfOptions& common) {
  const HostScope host(common.callbacks);
  std::vector<std::byte> bytes = glb_bytes(whole_asset(asset, surfaces, common, {}, false), common);
  common.callbacks.report("write", 1);
  return bytes;
}

}  // namespace planish
