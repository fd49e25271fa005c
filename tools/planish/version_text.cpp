#include "version_text.h"

#include <oneapi/tbb/version.h>
#include <opensubdiv/version.h>

#include "planish/core/version.h"
#include "planish/job/build_info.h"
#include "planish/reconstruct/mesher_process.h"

namespace planish::command {
namespace {

std::string library_text(int number) { return std::to_string(number); }

}  // namespace

std::string version_text() {
  std::string text = std::string("planish ") + PLANISH_VERSION + " (" + git_revision() + ")\n";
  constexpr int kOsd = OPENSUBDIV_VERSION_NUMBER;
  text += "  OpenSubdiv " + library_text(kOsd / 10000) + "." + library_text(kOsd / 100 % 100) +
          "." + library_text(kOsd % 100) + ", oneTBB " + library_text(TBB_VERSION_MAJOR) + "." +
          library_text(TBB_VERSION_MINOR) + "\n";
#if PLANISH_HAS_VULKAN
  text += "  Vulkan: built in (planish devices lists devices)\n";
#else
  text += "  Vulkan: not built in\n";
#endif
  text += find_mesher_program() ? "  points: planish-reconstruct (CGAL) is installed\n"
                                : "  points: planish-reconstruct (CGAL) is not installed\n";
  return text;
}

}  // namespace planish::command
