#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Compress : public FolderTest {
 protected:
  ProcessResult fit(std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"fit", plate_, "--device", "cpu", "-f"});
    return run_planish(flags);
  }

  std::string plate_ = write("plate.obj", bumpy_plate_obj(6));
};

TEST_F(Compress, WrittenErrorsStayWithinTheTolerance) {
  double last = 0;
  for (const std::string mode : {"none", "quantize", "meshopt"}) {
    for (const std::string tolerance : {"1e-4", "1e-6"}) {
      SCOPED_TRACE(mode + " " + tolerance);
      ASSERT_EQ(fit({"-o", path("p.glb"), "--report", path("r.json"), "--compress", mode,
                     "--tolerance", tolerance})
                    .exit_code,
                0);
      const auto output = read_json("r.json")["outputs"][0];
      EXPECT_LE(output["as_written_error"].get<double>(), std::stod(tolerance));
      EXPECT_EQ(output["bytes"], read("p.glb").size());
      if (tolerance == "1e-6") {
        const double bytes = output["bytes"].get<double>();
        if (mode != "none") {
          EXPECT_LT(bytes, last);
        }
        last = bytes;
      }
    }
  }
}

// 16 bits move positions by some 1e-5 of the diagonal, of which the default tolerance leaves less.
TEST_F(Compress, QuantizeSaysWherePositionsStayFloat) {
  const auto said = [&](const std::string& mode, const std::string& tolerance) {
    return fit({"-o", path("p.glb"), "--compress", mode, "--tolerance", tolerance}).err;
  };
  EXPECT_THAT(said("quantize", "1e-6"),
              AllOf(HasSubstr("p.glb: positions stay 32 bits: 16 would move them by up to 9"),
                    HasSubstr("e-06 of the diagonal, and --tolerance leaves ")));
  EXPECT_THAT(said("quantize", "1e-3"), Not(HasSubstr("positions stay")));
  EXPECT_THAT(said("meshopt", "1e-6"), Not(HasSubstr("positions stay")));
}

TEST_F(Compress, OtherFormatsAreRefused) {
  const ProcessResult result = fit({"-o", path("p.obj"), "--compress", "meshopt"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.err, HasSubstr("p.obj is not compressed; .glb, .gltf and 3D Tiles are"));
}

TEST_F(Compress, StdoutIsCompressedToo) {
  const ProcessResult file = fit({"-o", path("p.glb"), "--compress", "meshopt"});
  const ProcessResult piped = fit({"-o", "-", "--compress", "meshopt"});
  EXPECT_EQ(file.exit_code, 0);
  EXPECT_EQ(piped.out.size(), read("p.glb").size());
  EXPECT_THAT(piped.out, HasSubstr("EXT_meshopt_compression"));
}

}  // namespace
}  // namespace planish::test
