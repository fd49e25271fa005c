// tinygltf's implementation, and what it writes as a document: its public functions write to
// streams of C++, which take 30 kB of the packed library, and the function behind them is seen in
// this source only.
#include <nlohmann/json.hpp>
#define TINYGLTF_IMPLEMENTATION
#include <tiny_gltf.h>

nlohmann::json tinygltf_document(const tinygltf::Model& model) {
  nlohmann::json document;
  tinygltf::SerializeGltfModel(&model, document);
  return document;
}
