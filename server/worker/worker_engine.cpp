#include "worker/worker_engine.h"

#include <algorithm>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <future>
#include <mutex>
#include <thread>

#include "worker/death_cause.h"
#include "worker/death_history.h"
#include "worker/request_ledger.h"
#include "worker/watchdog.h"
#include "worker/worker_device.h"
#include "worker/worker_process.h"
#include "worker/worker_queue.h"

namespace isostrata {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto kLook = milliseconds(100);
constexpr auto kAnnounceEvery = milliseconds(500);
constexpr auto kGoodbye = milliseconds(1000);  // for a worker to end by itself
constexpr int kMostNeverReady = 3;             // deaths in a row with nothing drawn between: then whoever waits is told
constexpr auto kBusyRetry = std::chrono::seconds(30);  // for a moment in which nobody waits for a picture

}  // namespace

class WorkerEngine::Impl {
 public:
  Impl(EngineOptions engine, WorkerOptions worker, Sink sink)
      : options_(std::move(engine)),
        worker_(std::move(worker)),
        sink_(std::move(sink)),
        catalogue_(options_.catalogue),
        drawing_(options_.renderer_choice, worker_.retry_pause) {
    auto first = first_.get_future();
    keeper_ = std::thread([this] { keep(); });
    try {
      first.get();
    } catch (...) {
      end();
      throw;
    }
  }
  ~Impl() { end(); }

  void post(EngineRequest request) {
    std::optional<EngineEvent> event;
    {
      std::lock_guard lock(mutex_);
      if (stopping_) return;
      if (const auto* update = std::get_if<CatalogueUpdate>(&request))
        for (const CatalogueEntry& entry : update->entries) catalogue_.put(entry);  // the next worker is told at once
      RequestLedger::Outcome outcome = ledger_.ask(std::move(request));
      event = std::move(outcome.event);
      given_up_ = given_up_ || (outcome.give_up_worker && living_);
      if (const RequestId number = outcome.request ? answered_request_of(*outcome.request) : 0; number != 0 && !trouble_.empty())
        event = ledger_.hear(RequestFailed{session_of(*outcome.request), number, 0, ErrorCode::unavailable, trouble_});
      else if (outcome.request && living_)
        event = enqueue(std::move(*outcome.request));
      else if (const auto* cancel = outcome.request ? std::get_if<CancelRequest>(&*outcome.request) : nullptr;
               cancel && cancel->request != 0)
        event = ledger_.hear(cancelled(*cancel));
      if (given_up_) changed_.notify_all();
    }
    queued_.notify_one();
    if (event) sink_(std::move(*event));
  }

  const Catalogue& catalogue() const { return options_.catalogue; }
  std::string device() const {
    std::lock_guard lock(mutex_);
    return drawing_.name() + drawing_.instead();
  }
  EngineFacts facts() const {
    std::lock_guard lock(mutex_);
    EngineFacts facts = facts_;
    facts.trouble = trouble_;
    facts.device = drawing_.name() + drawing_.instead();
    facts.device_is_software = is_software_device(drawing_.name());
    if (!drawing_.instead().empty()) facts.fallback = drawing_.instead().substr(1);
    return facts;
  }

 private:
  struct Life {
    explicit Life(WorkerProcess& process) : process(process) {}
    WorkerProcess& process;
    bool ready = false;        // it can draw
    bool closed = false;       // nothing more comes
    std::string refused;       // what it said instead of WorkerReady
    std::exception_ptr error;  // the same
  };

  void end() {
    {
      std::lock_guard lock(mutex_);
      stopping_ = true;
    }
    changed_.notify_all();
    if (keeper_.joinable()) keeper_.join();
  }

  void log(std::string_view event, const std::string& text) const {
    if (worker_.log) worker_.log(event, text);
  }
  void send(std::vector<EngineEvent> events) {
    for (EngineEvent& event : events) sink_(std::move(event));
  }

  // ---- to the worker ----

  /// With mutex_ held.
  std::optional<EngineEvent> enqueue(EngineRequest request) {
    auto answer = queue_.put(std::move(request));
    return answer ? ledger_.hear(std::move(*answer)) : std::nullopt;
  }

  void write(Life& life) {
    for (;;) {
      std::optional<ToWorker> message;
      {
        std::unique_lock lock(mutex_);
        queued_.wait(lock, [&] { return life.closed || !queue_.empty(); });
        if (life.closed) return;
        message = queue_.take();
      }
      try {
        life.process.channel().send(to_bytes(*message));
      } catch (const Error& error) {
        if (error.code() == ErrorCode::unavailable) return;  // it is gone, which the reader sees
        const auto* request = std::get_if<EngineRequest>(&*message);
        if (!request) continue;
        std::optional<EngineEvent> event;
        {
          std::lock_guard lock(mutex_);
          event = ledger_.hear(RequestFailed{session_of(*request), answered_request_of(*request), 0, error.code(), error.what()});
        }
        if (event) sink_(std::move(*event));
      }
    }
  }

  // ---- from the worker ----

  void read(Life& life) {
    try {
      while (const auto bytes = life.process.channel().receive()) {
        FromWorker message = from_worker(*bytes);
        if (auto* event = std::get_if<EngineEvent>(&message)) {
          hear(std::move(*event));
        } else if (const auto* ready = std::get_if<WorkerReady>(&message)) {
          be_ready(life, *ready);
        } else if (const auto* refused = std::get_if<WorkerRefused>(&message)) {
          std::lock_guard lock(mutex_);
          life.refused = refused->message;
          life.error = std::make_exception_ptr(Error(refused->code, refused->message));
        }
      }
    } catch (const std::exception& error) {
      std::lock_guard lock(mutex_);
      life.refused = error.what();
    }
    {
      std::lock_guard lock(mutex_);
      life.closed = true;
    }
    changed_.notify_all();
    queued_.notify_all();
  }

  void hear(EngineEvent event) {
    std::optional<EngineEvent> heard;
    {
      std::lock_guard lock(mutex_);
      heard = ledger_.hear(std::move(event));
      if (heard)
        if (auto* frame = std::get_if<FrameReady>(&*heard)) frame->device += drawing_.instead();
    }
    if (heard) sink_(std::move(*heard));
  }

  void be_ready(Life& life, const WorkerReady& ready) {
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      life.ready = true;
      trouble_.clear();
      never_ready_ = 0;
      drawing_.draws(ready.device, Clock::now());
      facts_.process = life.process.id();
      facts_.renderer_trial = ready.renderer_trial;
      facts_.shut_in = ready.shut_in;
      events = ledger_.unannounce();
      for (EngineRequest& request : ledger_.begin_life()) queue_.push(std::move(request));
      living_ = true;
    }
    queued_.notify_all();
    send(std::move(events));
    if (!started_once_) {
      started_once_ = true;
      first_.set_value();
    } else {
      log("worker_replaced", "process " + std::to_string(life.process.id()) + " draws on " + device());
    }
  }

  // ---- keeping one alive ----

  void keep() {
    try {
      if (!worker_.launcher) worker_.launcher = make_launcher(worker_.plan);
      keep_one_alive();
    } catch (const std::exception& error) {
      if (!started_once_) return first_.set_exception(std::current_exception());
      // Nothing is left to try: no memory. Whoever waits is told, and whoever will ask.
      despair(std::string("the renderer's process cannot be replaced: ") + error.what());
    }
  }

  void despair(const std::string& what) {
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      trouble_ = what;
      events = ledger_.give_up(what);
    }
    log("worker_gone", what);
    send(std::move(events));
  }

  void keep_one_alive() {
    for (;;) {
      if (!rest()) return;
      std::string cause;
      std::vector<ActivityFacts> at;
      std::exception_ptr error;
      bool ran = false;
      try {
        WorkerProcess process(*worker_.launcher);
        ran = true;
        keep_ = process.keep();
        cause = live(process, at, error);
      } catch (const std::exception& failure) {
        cause = std::string("not started: ") + failure.what();
        error = std::current_exception();
      }
      {
        std::lock_guard lock(mutex_);
        if (stopping_) return;
      }
      if (std::exchange(retires_, false))
        try_device();
      else if (!bury(cause, at, error, ran))
        return;
    }
  }

  /// The worker of the other renderer has been ended so that the device can be tried again.
  void try_device() {
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      drawing_.try_again();
      events = ledger_.unannounce();
      for (EngineEvent& event : ledger_.end_life({}, "", false)) events.push_back(std::move(event));
    }
    log("worker_retry", "the device that was given up is tried again");
    send(std::move(events));
  }

  /// The pause before the next worker, where there has been one that could draw; false if none is wanted any more.
  bool rest() {
    std::unique_lock lock(mutex_);
    auto pause = started_once_ ? history_.pause() : milliseconds(0);
    if (never_ready_ > 1) pause = std::max(pause, milliseconds(250) * (1 << std::min(never_ready_ - 2, 5)));
    return !changed_.wait_for(lock, pause, [&] { return stopping_; });
  }

  /// Returns why the worker ended.
  std::string live(WorkerProcess& process, std::vector<ActivityFacts>& at, std::exception_ptr& error) {
    Life life(process);
    {
      std::lock_guard lock(mutex_);
      queue_.begin(setup());
      given_up_ = false;
      facts_.own_process = true;
      ++facts_.processes;
    }
    std::thread reader([this, &life] { read(life); });
    std::thread writer([this, &life] { write(life); });
    const long killed_before = killed_for_memory();
    std::string cause = watch(life);
    at = isostrata::read(process.board());
    process.kill();
    process.channel().shut_down();
    reader.join();
    writer.join();
    const std::optional<ProcessEnd> end = wait_for_end(process);
    std::lock_guard lock(mutex_);
    living_ = false;
    facts_.process = 0;
    error = life.error;
    if (!life.refused.empty()) return "not able to go on: " + life.refused;
    if (cause.empty() && end)
      cause = to_string(*end) + (life.ready ? " while " : " before it could draw, while ") + stages_of(at);
    if (end && end->signal == SIGKILL && killed_for_memory() > killed_before) cause += ": the kernel was out of memory";
    return cause;
  }

  static std::optional<ProcessEnd> wait_for_end(WorkerProcess& process) {
    for (int i = 0; i < 2000; ++i) {
      if (const auto end = process.ended()) return end;
      std::this_thread::sleep_for(milliseconds(1));
    }
    return std::nullopt;  // the kernel holds it, for a device
  }

  /// Until the worker is gone, or has to go: then why.
  std::string watch(Life& life) {
    Watchdog watchdog(worker_.soft_limit, worker_.hard_limit);
    Clock::time_point looked = Clock::now(), announced{};
    bool hanging = false;
    for (;;) {
      bool ready = false;
      {
        std::unique_lock lock(mutex_);
        changed_.wait_for(lock, kLook, [&] { return stopping_ || life.closed || given_up_; });
        if (stopping_) {
          if (life.ready) say_goodbye(life, lock);
          return "the server ends";
        }
        if (life.closed) {
          // Its own end says more than that its line is closed.
          lock.unlock();
          for (int i = 0; i < 200 && !life.process.ended(); ++i) std::this_thread::sleep_for(milliseconds(1));
          return {};
        }
        ready = life.ready;
        const auto due_at = ledger_.idle() ? Clock::now() : Clock::now() - kBusyRetry;
        if (ready && drawing_.retry_is_due(due_at)) {
          retires_ = true;
          return "ended for another one";
        }
      }
      const auto now = Clock::now();
      const auto at = isostrata::read(life.process.board());
      const auto verdict = watchdog.look(at, std::chrono::duration_cast<milliseconds>(now - looked), ready);
      looked = now;
      if (given_up_now())
        return "given up by a viewer after " + seconds_of(verdict.silent) + " without a sign of life while " + stages_of(at);
      if (verdict.hung)
        return "ended by the watchdog: no sign of life for " + seconds_of(verdict.silent) + " while " + stages_of(at);
      for (const ActivityFacts& stuck : verdict.stuck) {
        std::lock_guard lock(mutex_);
        if (living_) enqueue(CancelRequest{stuck.session, stuck.operation, stuck.request});
      }
      if (!verdict.stuck.empty()) queued_.notify_all();
      if (!ready) continue;
      if (verdict.hanging && now - announced >= kAnnounceEvery) {
        announced = now;
        const std::string text = "the renderer has given no sign of life for " +
                                 seconds_of(std::chrono::duration_cast<std::chrono::seconds>(verdict.silent));
        if (!hanging) log("worker_hangs", text + " while " + to_string(verdict.stage));
        announce(text, verdict.fraction);
      }
      if (hanging && !verdict.hanging) unannounce();
      hanging = verdict.hanging;
    }
  }

  bool given_up_now() {
    std::lock_guard lock(mutex_);
    return std::exchange(given_up_, false);
  }
  void say_goodbye(Life& life, std::unique_lock<std::mutex>& lock) {
    life.process.channel().shut_down();
    lock.unlock();
    const auto until = Clock::now() + kGoodbye;
    while (!life.process.ended() && Clock::now() < until) std::this_thread::sleep_for(milliseconds(1));
  }
  void announce(const std::string& text, double fraction) {
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      events = ledger_.announce(text, fraction);
    }
    send(std::move(events));
  }
  void unannounce() {
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      events = ledger_.unannounce();
    }
    send(std::move(events));
  }

  /// Settles what the dead one leaves; false if there is to be no other.
  bool bury(const std::string& cause, const std::vector<ActivityFacts>& at, const std::exception_ptr& error, bool ran) {
    const std::string what = "the renderer's process was " + cause;
    bool fall_back = false, nobody_draws = false;
    std::vector<EngineEvent> events;
    {
      std::lock_guard lock(mutex_);
      const auto now = Clock::now();
      if (ran) {
        history_.died(now);
        ++facts_.deaths;
      }
      facts_.last_death = cause;
      const bool native_already = drawing_.is_native();
      fall_back = ran && drawing_.died(cause, history_.too_many(), now);
      nobody_draws = ++never_ready_ >= kMostNeverReady && !fall_back;
      events = ledger_.unannounce();
      for (EngineEvent& event : ledger_.end_life(at, what, native_already)) events.push_back(std::move(event));
    }
    log("worker_died", what);
    // A worker that says why it cannot begin would say so again: the caller's error, where there has been none that could.
    if (!started_once_ && error) {
      started_once_ = true;
      first_.set_exception(error);
      return false;
    }
    if (fall_back) {
      std::lock_guard lock(mutex_);
      history_.forgive();
      ledger_.forgive();
    } else if (!started_once_ && history_.too_many()) {
      started_once_ = true;
      first_.set_exception(std::make_exception_ptr(Error(ErrorCode::unavailable, "no worker process lives: " + what)));
      return false;
    }
    if (nobody_draws && started_once_) {
      send(std::move(events));
      despair(what);
      return true;
    }
    if (fall_back) log("worker_fallback", "native draws from now on" + drawing_.instead());
    {
      std::lock_guard lock(mutex_);
      for (EngineEvent& event : ledger_.announce(what + "; another one takes over", 0)) events.push_back(std::move(event));
    }
    send(std::move(events));
    return true;
  }

  WorkerSetup setup() const {
    WorkerSetup setup;
    setup.catalogue = catalogue_.entries();
    setup.renderer = drawing_.choice().renderer;
    setup.device = drawing_.choice().device;
    setup.max_bytes = options_.store.max_bytes;
    setup.importer = options_.store.importer.string();
    setup.import_timeout_s = options_.store.timeout_s;
    setup.keep = keep_.string();
    setup.threads = worker_.threads;
    setup.part = options_.store.part;
    return setup;
  }

  const EngineOptions options_;
  WorkerOptions worker_;
  const Sink sink_;
  std::filesystem::path keep_;  // of keeper_
  std::promise<void> first_;    // kept by keeper_ and the readers, one after the other
  bool started_once_ = false;   // as first_

  mutable std::mutex mutex_;         // guards what follows
  std::condition_variable changed_;  // what the keeper waits for
  std::condition_variable queued_;   // what the writer waits for
  bool stopping_ = false;
  bool given_up_ = false;  // by a viewer
  bool living_ = false;    // the worker of today is told what is asked
  WorkerQueue queue_;
  RequestLedger ledger_;
  DeathHistory history_;
  Catalogue catalogue_;  // with what was told since
  WorkerDevice drawing_;
  std::string trouble_;   // why no worker can draw
  int never_ready_ = 0;   // deaths since a worker could draw
  bool retires_ = false;  // the worker ends so that the device that was given up is tried again; of keeper_
  EngineFacts facts_;

  std::thread keeper_;
};

WorkerEngine::WorkerEngine(EngineOptions engine, WorkerOptions worker, Sink sink)
    : impl_(std::make_unique<Impl>(std::move(engine), std::move(worker), std::move(sink))) {}
WorkerEngine::~WorkerEngine() = default;
void WorkerEngine::post(EngineRequest request) { impl_->post(std::move(request)); }
const Catalogue& WorkerEngine::catalogue() const { return impl_->catalogue(); }
std::string WorkerEngine::device() const { return impl_->device(); }
EngineFacts WorkerEngine::facts() const { return impl_->facts(); }

}  // namespace isostrata
