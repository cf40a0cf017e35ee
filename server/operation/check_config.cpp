#include "server/operation/check_config.h"

namespace sightline {

int run_check(const CheckCommand& command, std::ostream& out, std::ostream& complaints) {
  const ConfigReport report = report_of_config(command.file);
  for (const std::string& mistake : report.mistakes) complaints << mistake << "\n";
  for (const std::string& warning : report.warnings) complaints << warning << " (a warning)\n";
  if (!report.mistakes.empty()) return 2;
  out << command.file << ": good" << std::endl;
  return 0;
}

}  // namespace sightline
