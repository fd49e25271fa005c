// Writes OpenSubdiv's own GLSL of its patch bases to a file, for shaders/evaluate/elements.comp,
// with all arithmetic marked precise: so a device yields what Osd::CpuEvaluator does, whose code is
// the same. planish_patch_basis FILE
#include <opensubdiv/osd/glslPatchShaderSource.h>

#include <cstdio>
#include <fstream>
#include <regex>
#include <string>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: planish_patch_basis FILE\n");
    return 2;
  }
  std::string text = OpenSubdiv::Osd::GLSLPatchShaderSource::GetPatchBasisShaderSource();
  const std::regex number("#define OSD_REAL float");
  if (!std::regex_search(text, number)) {
    std::fprintf(stderr, "this OpenSubdiv's patch basis does not define OSD_REAL\n");
    return 1;
  }
  text = std::regex_replace(text, number, "#define OSD_REAL precise float");
  // Array constructors take no qualifier.
  text = std::regex_replace(text, std::regex("(OSD_ARRAY_[0-9]+)\\(OSD_REAL"), "$1(float");
  std::ofstream file(argv[1]);
  file << text;
  file.close();
  if (file) return 0;
  std::fprintf(stderr, "%s cannot be written\n", argv[1]);
  return 1;
}
