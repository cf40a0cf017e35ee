#include "server/check_config.h"

namespace sightline {

int run_check(const CheckCommand& command, std::ostream& out, std::ostream& complaints) {
  const auto mistakes = mistakes_of_config(command.file);
  for (const std::string& mistake : mistakes) complaints << mistake << "\n";
  if (!mistakes.empty()) return 2;
  out << command.file << ": good" << std::endl;
  return 0;
}

}  // namespace sightline
