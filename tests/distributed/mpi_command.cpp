#include "distributed/mpi_command.h"

#include <cstdlib>

namespace planish::test {

ProcessResult MpiCommand::on(int ranks, std::vector<std::string> arguments,
                             const std::string& fault, const std::vector<std::string>& before) {
  std::vector<std::string> all{"--oversubscribe", "-n", std::to_string(ranks)};
  if (!fault.empty()) all.insert(all.end(), {"-x", "PLANISH_MPI_FAULT"});
  all.insert(all.end(), before.begin(), before.end());
  all.emplace_back(PLANISH_MPI_PROGRAM);
  all.insert(all.end(), arguments.begin(), arguments.end());
  PlanishProcess::Options options;
  // All ranks are here: no other network is looked at, which may be none, or none that is allowed.
  options.environment = {"OMPI_ALLOW_RUN_AS_ROOT=1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1",
                         "OMPI_MCA_btl_tcp_if_include=lo", "HOME=/tmp"};
  if (!fault.empty()) options.environment.push_back("PLANISH_MPI_FAULT=" + fault);
  return run_planish(all, options);
}

int MpiCommand::planish(const std::string& arguments) const {
  const std::string line =
      std::string(PLANISH_PROGRAM) + " " + arguments + " > " + path("planish.txt") + " 2>&1";
  const int status = std::system(line.c_str());
  return WEXITSTATUS(status);
}

}  // namespace planish::test
