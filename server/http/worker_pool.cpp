#include "server/http/worker_pool.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/base/priority.h"
#include "server/http/connection.h"

namespace sightline {
namespace {

/// A request that is expected to take a second longer than others lets them go first until they
/// have had so many seconds, for each request that waits.
constexpr double kFavour = 8;

bool is_slow(const Connection& connection) { return connection.expected > Connection::kUnknown; }

/// Of so many threads, those that may have a slow request.
std::size_t slow_threads(std::size_t threads) { return std::max<std::size_t>(1, threads / 2); }

}  // namespace

WorkerPool::WorkerPool(const Options& options, Work answer, Work give_back)
    : options_(options), answer_(std::move(answer)), give_back_(std::move(give_back)) {
  for (Heap* heap : {&ordinary_, &slow_}) heap->reserve(options.queue + options.threads);
  threads_.reserve(options.threads);
  try {
    for (std::size_t i = 0; i < options.threads; ++i) threads_.emplace_back([this] { run(); });
  } catch (...) {
    end();
    throw;
  }
}

WorkerPool::~WorkerPool() { end(); }

double WorkerPool::seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void WorkerPool::end() {
  {
    const std::lock_guard hold(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

double& WorkerPool::finish_of(Connection& connection) {
  const std::string& key = connection.head.key_name;
  return key.empty() ? connection.flows[options_.number] : finish_of_key_[key];
}

bool WorkerPool::submit(Connection& connection) {
  bool wakes = false;
  {
    const std::lock_guard hold(mutex_);
    // A request that finds an idle worker does not wait, and so does not count.
    if (queue_size() + working_ >= options_.queue + options_.threads) return false;
    const bool slow = is_slow(connection);
    const std::size_t most_slow = options_.queue + slow_threads(options_.threads);
    if (slow && slow_.size() + slow_working_ >= most_slow) return false;
    const double start = std::max(now_, finish_of(connection));
    Heap& heap = slow ? slow_ : ordinary_;
    heap.push_back({start, start + connection.expected, ++arrivals_, &connection});
    std::push_heap(heap.begin(), heap.end());
    wakes = should_wake();
  }
  if (wakes) wake_.notify_one();
  return true;
}

bool WorkerPool::may_begin_slow() const {
  return !slow_.empty() && slow_working_ < slow_threads(options_.threads);
}

bool WorkerPool::has_next() const { return !ordinary_.empty() || may_begin_slow(); }

void WorkerPool::update_front(Heap& heap) {
  for (;;) {
    // Other requests of the flow may have been served since this one came.
    const Waiting& next = heap.front();
    const double finish = finish_of(*next.connection);
    if (next.start >= finish) return;
    std::pop_heap(heap.begin(), heap.end());
    heap.back().end += finish - heap.back().start;
    heap.back().start = finish;
    std::push_heap(heap.begin(), heap.end());
  }
}

WorkerPool::Waiting WorkerPool::take_next() {
  Heap* heap = &ordinary_;
  if (!ordinary_.empty()) update_front(ordinary_);
  if (may_begin_slow()) {
    update_front(slow_);
    if (ordinary_.empty() || ordinary_.front() < slow_.front()) heap = &slow_;
  }
  std::pop_heap(heap->begin(), heap->end());
  const Waiting next = heap->back();
  heap->pop_back();
  return next;
}

bool WorkerPool::should_wake() {
  if (!has_next() || sleeping_ == 0 || waking_) return false;
  waking_ = true;
  return true;
}

std::size_t WorkerPool::queued() const {
  const std::lock_guard hold(mutex_);
  return queue_size();
}

bool WorkerPool::has_idle() const {
  const std::lock_guard hold(mutex_);
  return queue_size() < sleeping_;
}

void WorkerPool::run() {
  if (options_.priority == Priority::kLower) lower_priority();
  // The first allocation of a thread may take the addresses of a whole heap (64 MiB in glibc):
  // better now than when memory is short. Volatile, because it would be left out else.
  char* volatile first = new char[64];
  delete[] first;
  std::unique_lock hold(mutex_);
  for (;;) {
    while (!has_next() && !ending_) {
      ++sleeping_;
      wake_.wait(hold);
      --sleeping_;
      waking_ = false;
    }
    if (!has_next()) return;
    const auto [start, end, arrival, connection] = take_next();
    now_ = std::max(now_, start);
    ++working_;
    const bool slow = is_slow(*connection);
    if (slow) ++slow_working_;
    const bool wakes = should_wake();
    hold.unlock();
    if (wakes) wake_.notify_one();
    const double begin = options_.clock();
    answer_(*connection);
    const double cost = options_.clock() - begin;
    hold.lock();
    double& finish = finish_of(*connection);
    finish = std::max(finish, start) + cost;
    // Else new connections, which always start now, could go first for ever.
    now_ += cost / (kFavour * static_cast<double>(queue_size() + working_));
    --working_;
    if (slow) --slow_working_;
    hold.unlock();
    give_back_(*connection);
    hold.lock();
  }
}

}  // namespace sightline
