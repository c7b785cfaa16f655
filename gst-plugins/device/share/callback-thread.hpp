// SPDX-License-Identifier: LGPL-2.1-or-later
// A thread that also runs code of the application. That code may end the thread, or wait for the
// one that does.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <stop_token>
#include <thread>
#include <utility>

namespace haptic {

/// end() waits for the thread, except while it runs foreign code: then the thread is left behind
/// and ends when that code returns.
class CallbackThread {
  enum class Place { inside, outside, ending };
  struct Shared {
    std::atomic<Place> place = Place::inside;
  };

public:
  /// Returns what must live while foreign code runs, at least until it has returned. May be empty.
  using Keeper = std::function<std::shared_ptr<void>()>;

  /// The thread as its body sees it.
  class Self {
  public:
    Self(std::shared_ptr<Shared> shared, Keeper keeper, std::stop_token stop)
        : shared_(std::move(shared)), keeper_(std::move(keeper)), stop_(std::move(stop)) {}

    const std::stop_token &stop_token() const noexcept { return stop_; }
    bool stop_requested() const noexcept { return stop_.stop_requested(); }

    /// Runs foreign code, or nothing if the thread is about to end. Returns false if the thread was
    /// left behind meanwhile: it then must return without touching anything.
    template <typename Code>
    bool call_out(Code &&code) {
      std::shared_ptr<void> kept = keeper_ ? keeper_() : nullptr;
      Place place = Place::inside;
      if (!shared_->place.compare_exchange_strong(place, Place::outside))
        return true;
      std::forward<Code>(code)();
      kept.reset(); // may destroy the owner, which leaves this thread behind
      place = Place::outside;
      return shared_->place.compare_exchange_strong(place, Place::inside);
    }

  private:
    std::shared_ptr<Shared> shared_;
    Keeper keeper_;
    std::stop_token stop_;
  };

  CallbackThread() = default;
  /// Throws std::system_error.
  CallbackThread(Keeper keeper, std::function<void(Self &)> body)
      : shared_(std::make_shared<Shared>()),
        thread_([shared = shared_, keeper = std::move(keeper),
                 body = std::move(body)](std::stop_token stop) {
          Self self(shared, keeper, std::move(stop));
          body(self);
        }) {}
  ~CallbackThread() { end(); }
  CallbackThread(CallbackThread &&) = default;
  CallbackThread &operator=(CallbackThread &&other) noexcept {
    end();
    shared_ = std::move(other.shared_);
    thread_ = std::move(other.thread_);
    return *this;
  }

  /// Requests the stop, and waits for the thread unless it runs foreign code. Any thread, also from
  /// that code.
  void end() noexcept {
    if (!thread_.joinable())
      return;
    thread_.request_stop();
    if (shared_->place.exchange(Place::ending) == Place::outside)
      thread_.detach();
    else
      thread_.join();
  }

private:
  std::shared_ptr<Shared> shared_;
  std::jthread thread_;
};

} // namespace haptic
