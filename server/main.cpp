#include <csignal>
#include <cstdlib>
#include <iostream>

#include "core/base/free_memory.h"
#include "server/client/commands.h"
#include "server/operation/cli.h"
#include "server/operation/small_commands.h"
#include "server/serve.h"

namespace sightline {
namespace {

int run(const ServeCommand& command) {
  limit_heaps();
  // A file that reaches the process's limit is an error like a full disk.
  std::signal(SIGXFSZ, SIG_IGN);
  const auto end_now = [](int code) { std::_Exit(code); };
  return run_serve(command, end_now, std::cout, std::cerr);
}
int run(const CastCommand& command) { return run_cast(command, std::cin, std::cout, std::cerr); }
int run(const QueryCommand& command) { return run_query(command, std::cin, std::cout, std::cerr); }
int run(const McpCommand& command) { return run_mcp(command, std::cin, std::cout, std::cerr); }
int run(const DemoCommand& command) { return run_demo(command, std::cerr); }
int run(const KeyCommand& command) { return run_key(command, std::cout, std::cerr); }
int run(const ConvertCommand& command) { return run_convert(command, std::cerr); }
int run(const CheckCommand& command) { return run_check(command, std::cout, std::cerr); }
int run(const ShowText& shown) {
  (shown.exit_code == 0 ? std::cout : std::cerr) << shown.text;
  return shown.exit_code;
}

}  // namespace
}  // namespace sightline

int main(int argc, char** argv) {
  try {
    return std::visit([](const auto& command) { return sightline::run(command); },
                      sightline::parse_command_line({argv, argv + argc}));
  } catch (const std::exception& error) {
    std::cerr << "sightline: " << error.what() << "\n";
    return 2;
  }
}
