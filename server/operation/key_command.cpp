#include "server/operation/key_command.h"

namespace sightline {

int run_key(const KeyCommand& command, std::ostream& out, std::ostream& complaints) {
  const auto key = make_key();
  if (!key) {
    complaints << "sightline: " << key.error().message << "\n";
    return 2;
  }
  out << "key: " << *key << "\nline: " << key_line({command.name, command.access, key_sha256(*key)})
      << std::endl;
  return out ? 0 : 2;
}

}  // namespace sightline
