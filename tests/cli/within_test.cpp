#include <gmock/gmock.h>

#include <cmath>
#include <sstream>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::HasSubstr;

// A bumpy sheet.
std::string sheet() {
  std::ostringstream obj;
  for (int y = 0; y < 12; ++y)
    for (int x = 0; x < 12; ++x)
      obj << "v " << x << ' ' << y << ' ' << 0.1 * std::sin(12.9898 * x + 78.233 * y) << '\n';
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 11; ++x)
      obj << "f " << 12 * y + x + 1 << ' ' << 12 * y + x + 2 << ' ' << 12 * y + x + 14 << ' '
          << 12 * y + x + 13 << '\n';
  return obj.str();
}

class Within : public FolderTest {};

TEST_F(Within, IsSaidReportedAndVerified) {
  const std::string input = write("sheet.obj", sheet());
  for (const std::string method : {"progressive", "fair"}) {
    const ProcessResult fit =
        run_planish({"fit", input, "--within", "0.003", "--interpolation", method, "--cage",
                     path("cage.obj"), "-o", path("s.glb"), "--report", path("r.json"), "-f"});
    ASSERT_EQ(fit.exit_code, 0) << fit.err;
    EXPECT_THAT(fit.err, HasSubstr("within      0.003 of the diagonal: vertices are left by"));
    EXPECT_EQ(fit.err.find("rounding"), std::string::npos) << fit.err;
    const nlohmann::json within = read_json("r.json")["solve"]["within"];
    EXPECT_EQ(within["allowed"], 0.003);
    EXPECT_EQ(within["noise"], nullptr);
    EXPECT_LT(within["bending_after"], 0.9 * within["bending_before"].get<double>());

    EXPECT_EQ(run_planish({"verify", path("cage.obj"), input}).exit_code, 0);
    const ProcessResult verified =
        run_planish({"verify", path("cage.obj"), input, "--within", "0.0029", "--json"});
    EXPECT_EQ(verified.exit_code, 5) << verified.out;
    const nlohmann::json found = nlohmann::json::parse(verified.out);
    EXPECT_NEAR(found["error"]["max"].get<double>(), within["distance"]["max"].get<double>(), 2e-6);
  }
}

// The header says what was allowed where the noise decided.
TEST_F(Within, MeasuredIsVerifiedToo) {
  const std::string input = write("sheet.obj", sheet());
  const ProcessResult fit = run_planish(
      {"fit", input, "--within", "auto", "--cage", path("cage.obj"), "--report", path("r.json")});
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  EXPECT_THAT(fit.err, HasSubstr("(the noise is "));
  EXPECT_GT(read_json("r.json")["solve"]["within"]["noise"], 1e-3);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input}).exit_code, 0);
  EXPECT_EQ(run_planish({"verify", path("cage.obj"), input, "--within", "auto"}).exit_code, 2);
}

TEST_F(Within, RefusesWhatMeansNothing) {
  const std::string input = write("sheet.obj", sheet());
  const auto error = [&](const std::string& value) {
    const ProcessResult result =
        run_planish({"fit", input, "-o", path("s.glb"), "--within", value});
    EXPECT_EQ(result.exit_code, 2) << value;
    return result.err;
  };
  EXPECT_THAT(error("1e-7"), HasSubstr("--within: 1e-07 is not above --tolerance 1e-06"));
  for (const char* value : {"0.1", "-0.001", "nan", "Auto", "0.01x", "inf"})
    EXPECT_THAT(error(value), HasSubstr("is neither; auto, 0, or a fraction")) << value;
}

}  // namespace
}  // namespace planish::test
