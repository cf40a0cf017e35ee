#include "server/operation/small_commands.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <system_error>

#include "core/store/posix_file.h"
#include "server/service/scene_source.h"

namespace sightline {
namespace {

Status write_demo(const DemoCommand& command) {
  constexpr const char* kDoing = "write the file";
  auto glb = demo_glb(command.name);
  if (!glb) return std::move(glb).error();
  auto file = open_file(command.file, O_WRONLY | O_CREAT | O_TRUNC, kDoing);
  if (!file) return std::move(file).error();
  return write_all(*file, *glb, kDoing);
}

}  // namespace

int run_demo(const DemoCommand& command, std::ostream& complaints) {
  const Status status = write_demo(command);
  if (status) return 0;
  complaints << "sightline: " << status.error().code << ": " << status.error().message << "\n";
  return 2;
}

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

int run_convert(const ConvertCommand& command, std::ostream& complaints) {
  std::error_code none;
  const auto here = std::filesystem::read_symlink("/proc/self/exe", none).parent_path();
  std::array<std::string, 5> arguments{(here / "sightline-convert").string(), command.from,
                                       command.to, std::to_string(command.memory_mib),
                                       std::to_string(command.seconds)};
  std::array<char*, 6> pointers{};
  for (std::size_t i = 0; i < arguments.size(); ++i) pointers[i] = arguments[i].data();
  ::execv(arguments[0].c_str(), pointers.data());
  complaints << "sightline: there is no " << arguments[0]
             << ": it is built where libassimp-dev is installed (docs/guides/convert.md)\n";
  return 2;
}

int run_check(const CheckCommand& command, std::ostream& out, std::ostream& complaints) {
  const ConfigReport report = report_of_config(command.file);
  for (const std::string& mistake : report.mistakes) complaints << mistake << "\n";
  for (const std::string& warning : report.warnings) complaints << warning << " (a warning)\n";
  if (!report.mistakes.empty()) return 2;
  out << command.file << ": good" << std::endl;
  return 0;
}

}  // namespace sightline
