#include "server/http/http_server.h"

#include <gtest/gtest.h>
#include <httplib.h>
#include <netinet/in.h>
#include <spdlog/sinks/null_sink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <future>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>
#include <vector>

#include "server/routes/routes.h"

namespace sightline {
namespace {

/// A server on a free port, ended with the object.
class Running {
 public:
  explicit Running(HttpServer::Dispatch dispatch, EventLoopCallbacks rules = {},
                   const HttpLimits& limits = {.workers = 8})
      : server_(
            limits, std::move(dispatch),
            [this](const std::string&, const std::string& what) {
              const std::lock_guard hold(mutex_);
              thrown_ = what;
            },
            std::move(rules)) {
    const auto port = server_.bind({"127.0.0.1", 0});
    EXPECT_TRUE(port.ok());
    port_ = port.ok() ? *port : 0;
    thread_ = std::thread([this] { server_.serve(); });
  }
  ~Running() {
    server_.stop();
    thread_.join();
  }
  httplib::Client client() const { return httplib::Client("127.0.0.1", port_); }
  int port() const { return port_; }
  const EventLoopCounts& counts() const { return server_.counts(); }
  std::string thrown() const {
    const std::lock_guard hold(mutex_);
    return thrown_;
  }

 private:
  HttpServer server_;
  mutable std::mutex mutex_;
  std::string thrown_;
  int port_ = 0;
  std::thread thread_;
};

TEST(HttpServer, lets_two_servers_live_in_one_process) {
  Running first([](Exchange& exchange) { exchange.reply_json(200, "1"); });
  Running second([](Exchange& exchange) { exchange.reply_json(200, "2"); });
  EXPECT_EQ(first.client().Get("/")->body, "1");
  EXPECT_EQ(second.client().Get("/")->body, "2");
}

TEST(HttpServer, tells_nobody_what_an_exception_said) {
  Running server([](Exchange&) { throw std::runtime_error("the secret"); });
  const auto answer = server.client().Get("/");
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->status, 500);
  EXPECT_EQ(answer->get_header_value("Content-Type"), "application/problem+json");
  EXPECT_EQ(nlohmann::json::parse(answer->body)["code"], "INTERNAL");
  EXPECT_EQ(answer->body.find("secret"), std::string::npos);
  for (const auto& [name, value] : answer->headers) {
    EXPECT_EQ(value.find("secret"), std::string::npos) << name;
  }
  EXPECT_EQ(server.thrown(), "std::runtime_error");
}

TEST(HttpServer, says_507_when_memory_is_full) {
  Running server([](Exchange&) { throw std::bad_alloc(); });
  EXPECT_EQ(server.client().Get("/")->status, 507);
}

TEST(HttpServer, stops_before_it_has_begun_to_serve) {
  HttpServer server(
      HttpLimits{.workers = 8}, [](Exchange&) {}, [](const auto&, const auto&) {});
  ASSERT_TRUE(server.bind({"127.0.0.1", 0}).ok());
  server.stop();
  server.serve();  // returns
}

TEST(HttpServer, answers_in_the_event_loop_while_every_worker_is_busy) {
  std::promise<void> go_on;
  const std::shared_future<void> gone_on = go_on.get_future().share();
  std::atomic<int> begun{0};
  EventLoopCallbacks rules;
  rules.weigh = [](const RequestHead& head, std::string_view) {
    return head.target == "/at-once" ? Weight::kInline : Weight::kShort;
  };
  Running server(
      [&](Exchange& exchange) {
        if (exchange.head.target == "/slow") {
          ++begun;
          gone_on.wait();
        }
        exchange.reply_json(200, "1");
      },
      rules);
  std::vector<std::future<int>> slow;
  slow.reserve(8);
  for (int i = 0; i < 8; ++i) {
    slow.push_back(
        std::async(std::launch::async, [&] { return server.client().Get("/slow")->status; }));
  }
  while (begun < 8) std::this_thread::yield();
  httplib::Client client = server.client();
  client.set_keep_alive(true);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(client.Get("/at-once")->body, "1");
  go_on.set_value();
  for (auto& answer : slow) EXPECT_EQ(answer.get(), 200);
}

TEST(HttpServer, sends_large_answers_whole) {
  const std::string large(20 << 20, 'x');
  Running server([&](Exchange& exchange) { exchange.reply_json(200, large); });
  EXPECT_TRUE(server.client().Get("/")->body == large);
}

/// SO_SNDBUF of the socket of this process whose peer has that port; 0: there is none.
int send_buffer_towards(int port) {
  for (int socket = 0; socket < 1024; ++socket) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    if (::getpeername(socket, reinterpret_cast<sockaddr*>(&peer), &size) != 0) continue;
    if (peer.sin_family != AF_INET || ntohs(peer.sin_port) != port) continue;
    int bytes = 0;
    size = sizeof bytes;
    ::getsockopt(socket, SOL_SOCKET, SO_SNDBUF, &bytes, &size);
    return bytes;
  }
  return 0;
}

TEST(HttpServer, counts_and_limits_what_the_kernel_holds_for_clients_that_do_not_read) {
  const std::string large(20 << 20, 'x');
  Running server([&](Exchange& exchange) { exchange.reply_json(200, large); }, {},
                 {.workers = 8, .memory = 1 << 20});
  std::vector<int> clients;
  for (int i = 0; i < 8; ++i) {
    const int client = ::socket(AF_INET, SOCK_STREAM, 0);
    clients.push_back(client);
    const int little = 4096;
    ::setsockopt(client, SOL_SOCKET, SO_RCVBUF, &little, sizeof little);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(server.port()));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    ASSERT_EQ(::connect(client, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
    ASSERT_EQ(::send(client, kRequest.data(), kRequest.size(), 0), std::ssize(kRequest));
  }
  // A quarter of the memory is exceeded, so the buffers stop growing.
  while (server.counts().send_buffers < (256u << 10)) std::this_thread::yield();
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(clients[0], reinterpret_cast<sockaddr*>(&address), &size);
  while (send_buffer_towards(ntohs(address.sin_port)) > (256 << 10)) std::this_thread::yield();
  for (const int client : clients) ::close(client);
  while (server.counts().send_buffers > 0) std::this_thread::yield();
}

/// The routes over a store whose loader waits until it is told to go on.
class SlowStore : public testing::Test {
 protected:
  SlowStore() : log_(LogFormat::kText, "off", std::make_shared<spdlog::sinks::null_sink_mt>()) {
    engine_ = std::move(*Engine::create({.threads = 1, .kernel = {}}));
    store_ = std::move(*SceneStore::open({},
                                         [this](const LoadInput&) {
                                           begun_.set_value();
                                           go_on_.get_future().wait();
                                           return Scene::build({});
                                         },
                                         {}));
    service_.reset(new Service{*engine_, *store_});
    add_health_routes(router_, *service_, {metrics_, http_, *sources_});
    add_scene_routes(router_, *service_, sources_);
    add_ray_routes(router_, *service_, {log_, metrics_});
  }

  std::promise<void> begun_, go_on_;
  Log log_;
  Metrics metrics_;
  const HttpLimits http_;
  const std::shared_ptr<const SourceRules> sources_ = std::make_shared<const SourceRules>();
  std::unique_ptr<Engine> engine_;
  std::unique_ptr<SceneStore> store_;
  std::unique_ptr<Service> service_;
  Router router_;
};

TEST_F(SlowStore, answers_409_with_retry_after_while_a_scene_is_loading) {
  Running server([&](Exchange& exchange) { router_.dispatch(exchange); });
  auto put = std::async(std::launch::async, [&] {
    return server.client().Put("/v1/scenes/slow", "bytes", "model/gltf-binary")->status;
  });
  begun_.get_future().wait();
  auto client = server.client();
  const auto scene = client.Get("/v1/scenes/slow");
  EXPECT_EQ(scene->status, 200);
  EXPECT_EQ(nlohmann::json::parse(scene->body)["state"], "loading");
  for (const char* kind : {"closest", "any"}) {
    const auto asked = client.Post(std::string("/v1/scenes/slow/rays:") + kind, R"({"rays":[]})",
                                   "application/json");
    EXPECT_EQ(asked->status, 409);
    EXPECT_EQ(nlohmann::json::parse(asked->body)["code"], "SCENE_LOADING");
    EXPECT_EQ(asked->get_header_value("Retry-After"), "1");
  }
  go_on_.set_value();
  EXPECT_EQ(put.get(), 201);
  EXPECT_EQ(client.Post("/v1/scenes/slow/rays:any", R"({"rays":[]})", "application/json")->status,
            200);
}

TEST_F(SlowStore, answers_503_when_a_request_was_cancelled_and_504_when_it_took_too_long) {
  Running server([&](Exchange& exchange) { router_.dispatch(exchange); });
  go_on_.set_value();
  ASSERT_EQ(server.client().Put("/v1/scenes/s", "bytes", "model/gltf-binary")->status, 201);
  const auto ask = [&] {
    return server.client().Post("/v1/scenes/s/rays:closest",
                                R"({"rays":[{"origin":[0,0,0],"direction":[0,0,1]}]})",
                                "application/json");
  };
  service_->limits.request = std::chrono::milliseconds(-1);
  EXPECT_EQ(ask()->status, 504);
  EXPECT_EQ(nlohmann::json::parse(ask()->body)["code"], "DEADLINE");
  service_->cancelled.cancel();
  EXPECT_EQ(ask()->status, 503);
  EXPECT_EQ(nlohmann::json::parse(ask()->body)["code"], "CANCELLED");
}

}  // namespace
}  // namespace sightline
