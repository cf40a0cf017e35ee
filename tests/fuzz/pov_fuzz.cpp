// Text of POV-Ray: boxes or an error.
// Run:  scripts/stress.sh fuzz --target pov_fuzz

#include <cstdint>
#include <string_view>

#include "core/import/pov/pov_scene.h"
#include "tests/fuzz/scene_check.h"

using namespace sightline;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  static_cast<void>(pov::looks_like_pov(text));
  fuzz::check(pov::import_boxes(text, fuzz::small_limits().limits));
  return 0;
}
