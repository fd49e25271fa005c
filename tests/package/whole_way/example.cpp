// The whole way from a file to a file, as src/planish/job/README.md shows it.
// README begins
#include <planish/planish.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "use: %s MESH.obj SURFACE.glb\n", argv[0]);
    return 2;
  }
  try {
    // Reads, repairs, fits, evaluates and writes, as `planish fit --levels 3` does.
    const planish::FileFit done =
        planish::fit_file(argv[1], argv[2], {.settings = planish::settings_of({{"levels", "3"}})});
    const planish::Interpolation& result = done.fitted.fit.interpolation;
    std::printf("%s: %lld faces; the vertices are off by at most %g of the diagonal\n", argv[2],
                static_cast<long long>(done.face_count), result.error.max);
    return result.converged ? 0 : 5;
  } catch (const planish::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());  // what, where, value and remedy
    return 1;
  }
}
// README ends
