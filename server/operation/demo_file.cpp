#include "server/operation/demo_file.h"

#include <fcntl.h>

#include "core/store/posix_file.h"
#include "server/service/scene_source.h"

namespace sightline {

int run_demo(const DemoCommand& command, std::ostream& complaints) {
  const auto write = [&]() -> Status {
    constexpr const char* kDoing = "write the file";
    auto glb = demo_glb(command.name);
    if (!glb) return std::move(glb).error();
    auto file = open_file(command.file, O_WRONLY | O_CREAT | O_TRUNC, kDoing);
    if (!file) return std::move(file).error();
    return write_all(*file, *glb, kDoing);
  };
  const Status status = write();
  if (status) return 0;
  complaints << "sightline: " << status.error().code << ": " << status.error().message << "\n";
  return 2;
}

}  // namespace sightline
