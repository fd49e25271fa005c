// In the place of draco_stream.cpp where libdraco is not built in.
#include "planish/files/gltf/gltf_source.h"

namespace planish {

bool reads_draco() { return false; }

DracoMesh decode_draco(const JsonPlace& extension, std::span<const std::byte>, const DracoCounts&) {
  extension.fail("this program was built without libdraco; save the file without Draco");
}

}  // namespace planish
