#include "server/operation/version.h"

#include "core/run/engine.h"

namespace sightline {

std::string version() { return SIGHTLINE_VERSION; }

std::string version_text() {
  std::string text = "sightline " + version() + "\nkernels:";
  for (const std::string& kernel : Engine::kernels()) text += " " + kernel;
  return text;
}

}  // namespace sightline
