#include "tests/bench/http_servers.h"

#include <httplib.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <ctime>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "tests/bench/load_client.h"

namespace sightline::bench {
namespace {

/// Runs `work` in a child that ends with this process.
template <class Work>
pid_t in_child(const Work& work) {
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    work();
    ::_exit(1);
  }
  return pid;
}

void execute(std::vector<std::string> words) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
}

}  // namespace

ServerProcess::ServerProcess(pid_t pid, int port) : pid_(pid), port_(port) {
  for (int i = 0; i < 1000 && !is_listening(port); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!is_listening(port)) throw std::runtime_error("a server did not come up");
}

ServerProcess::ServerProcess(ServerProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), port_(other.port_) {}

ServerProcess::~ServerProcess() {
  if (pid_ < 0) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

ServerProcess ServerProcess::sightline(const std::string& binary, int workers,
                                       const std::vector<std::string>& flags) {
  return own([&](int port) {
    std::vector<std::string> words{binary,        "serve",
                                   "--listen",    "127.0.0.1:" + std::to_string(port),
                                   "--workers",   std::to_string(workers),
                                   "--log-level", "warn"};
    words.insert(words.end(), flags.begin(), flags.end());
    execute(std::move(words));
  });
}

ServerProcess ServerProcess::own(const std::function<void(int port)>& serve) {
  const int port = free_port();
  return {in_child([&] { serve(port); }), port};
}

ServerProcess ServerProcess::plain(int workers) {
  return own([&](int port) {
    httplib::Server server;
    server.new_task_queue = [&] {
      return new httplib::ThreadPool(static_cast<std::size_t>(workers));
    };
    server.set_tcp_nodelay(true);
    server.set_keep_alive_max_count(1'000'000'000);
    server.Get("/healthz", [](const httplib::Request&, httplib::Response& response) {
      response.set_content(kHealthBody, "application/json");
    });
    server.listen("127.0.0.1", port);
  });
}

ServerProcess ServerProcess::nginx(const std::string& folder) {
  const int port = free_port();
  const std::string file = folder + "/http_nginx.conf";
  std::string body = kHealthBody;
  body.pop_back();
  std::ofstream(file)
      << "daemon off; master_process off; pid " << folder
      << "/http_nginx.pid;\nerror_log stderr;\nevents { worker_connections 1024; }\n"
         "http { access_log off; keepalive_requests 1000000000;\n"
         "  server { listen 127.0.0.1:"
      << port << "; location / { default_type application/json; return 200 '" << body
      << "\n'; } } }\n";
  return {in_child([&] { execute({"nginx", "-c", file, "-p", folder}); }), port};
}

double ServerProcess::cpu_us() const {
  clockid_t clock = 0;
  timespec used{};
  if (::clock_getcpuclockid(pid_, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return 0;
  return static_cast<double>(used.tv_sec) * 1e6 + static_cast<double>(used.tv_nsec) * 1e-3;
}

}  // namespace sightline::bench
