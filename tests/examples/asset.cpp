// A whole glTF by one call of C++, as src/planish/job/README.md shows it.
#include "planish/planish.h"

#include <cstdio>

namespace {

// README begins
void smooth_asset(const char* from, const char* to) {
  planish::FitFileOptions options;
  options.settings = planish::settings_of({{"compress", "meshopt"}});
  options.page = "smooth.html";
  options.report = "smooth.json";
  planish::fit_file(from, to, options);
}
// README ends

}  // namespace

int main() {
  try {
    smooth_asset("chair.gltf", "smooth.glb");
  } catch (const planish::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
