#include <gmock/gmock.h>

#include "cli/planish_process.h"
#include "cli/test_files.h"

namespace planish::test {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

class VerifyCommand : public FolderTest {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_planish({"fit", input_, "--cage", path("c.obj"), "--preset", "paper"}).exit_code,
              0);
  }

  std::string input_ = write("plate.obj", bumpy_plate_obj(8));
};

TEST_F(VerifyCommand, ConfirmsWhatFitWrote) {
  const ProcessResult result = run_planish({"verify", path("c.obj"), input_});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, StartsWith("confirmed"));
  EXPECT_THAT(result.out, HasSubstr("averaged"));  // from the header
}

TEST_F(VerifyCommand, ConfirmsCagesOfEveryFormat) {
  for (const char* name : {"d.ply", "d.off", "d.obj"}) {
    ASSERT_EQ(run_planish({"fit", input_, "--cage", path(name)}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), input_}).exit_code, 0) << name;
  }
}

TEST_F(VerifyCommand, RejectsAPerturbedCage) {
  std::string cage = read("c.obj");
  // The first vertex moves across half the plate.
  const std::size_t first = cage.find("\nv ") + 3;
  cage.replace(first, cage.find(' ', first) - first, "0.5");
  write("moved.obj", cage);
  const ProcessResult result = run_planish({"verify", path("moved.obj"), input_, "--json"});
  EXPECT_EQ(result.exit_code, 5);
  const nlohmann::json json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["confirmed"], false);
  EXPECT_EQ(json["error"]["worst_vertex"], 0);
  EXPECT_GT(json["error"]["max"], 0.01);
}

TEST_F(VerifyCommand, RejectsTheInputAsItsOwnCage) {
  EXPECT_EQ(run_planish({"verify", input_, input_}).exit_code, 5);
}

TEST_F(VerifyCommand, FlagsOverrideTheHeader) {
  EXPECT_EQ(run_planish({"verify", path("c.obj"), input_, "--tolerance", "1e-15"}).exit_code, 5);
  EXPECT_EQ(
      run_planish({"verify", path("c.obj"), input_, "--boundary", "edge-and-corner"}).exit_code, 5);
}

TEST_F(VerifyCommand, AgreesWithTheReport) {
  ASSERT_EQ(
      run_planish({"fit", input_, "--cage", path("d.obj"), "--report", path("r.json")}).exit_code,
      0);
  const nlohmann::json verified =
      nlohmann::json::parse(run_planish({"verify", path("d.obj"), input_, "--json"}).out);
  const nlohmann::json report = read_json("r.json");
  EXPECT_EQ(verified["error"]["max"], report["outputs"][0]["as_written_error"]);
  EXPECT_NEAR(verified["error"]["max"].get<double>(), report["solve"]["error"]["max"].get<double>(),
              1e-14);
  EXPECT_EQ(verified["error"]["worst_vertex"], report["solve"]["error"]["worst_vertex"]);
}

TEST_F(VerifyCommand, ACageOfAnotherMeshIsRefused) {
  const std::string cube = write("cube.obj", cube_obj());
  const ProcessResult result = run_planish({"verify", path("c.obj"), cube});
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_THAT(result.err, HasSubstr("is no cage of"));
  const std::string torus =
      write("torus.obj", torus_obj(8));  // 64 faces as the plate, fewer vertices
  EXPECT_THAT(run_planish({"verify", path("c.obj"), torus}).err,
              HasSubstr("face 0 has other corners"));
}

TEST_F(VerifyCommand, ABrokenHeaderIsNamed) {
  std::string cage = read("c.obj");
  cage.replace(cage.find("=averaged"), 9, "=avaraged");
  const ProcessResult result = run_planish({"verify", write("b.obj", cage), input_});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.err, HasSubstr("header weights: \"avaraged\" is not one of"));
}

TEST_F(VerifyCommand, CreasesAreTakenFromTheInputWhereTheFormatHasNone) {
  const std::string creased =
      write("creased.obj", torus_obj(8) + "t crease 2/1/0 0 1 10\n" + "t crease 2/1/0 1 2 10\n");
  for (const char* name : {"k.obj", "k.ply"}) {
    ASSERT_EQ(run_planish({"fit", creased, "--cage", path(name)}).exit_code, 0);
    EXPECT_EQ(run_planish({"verify", path(name), creased}).exit_code, 0) << name;
    EXPECT_EQ(run_planish({"verify", path(name), creased, "--creases", "ignore"}).exit_code, 5);
  }
}

}  // namespace
}  // namespace planish::test
