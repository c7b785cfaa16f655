// SPDX-License-Identifier: LGPL-2.1-or-later
#include "usb/usb-controllers.hpp"

#include "fail.hpp"
#include "guard/guardian.hpp"
#include "spidar/haptic-device.hpp"
#include "spidar/usb.hpp"
#include "usb/usb-protocol.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace spidar {

namespace {

constexpr int kExchangeTimeout = 2; // ms
// The guardian hears nothing during an exchange; this long between two it waits.
constexpr auto kBetweenExchanges = std::chrono::milliseconds(8);
static_assert(Guardian::kPatience == kLongestSilence);
static_assert(Guardian::kPatience ==
              kBetweenExchanges + std::chrono::milliseconds(kExchangeTimeout));
// Per attempt: a silent controller is refused within 0.1 s.
constexpr auto kOpenTimeout = std::chrono::milliseconds(25);
constexpr int kOpenAttempts = 3;

class Simple {
public:
  static constexpr int kCounterBits = simple::kCounterBits;
  static constexpr UsbModel kModel = UsbModel::simple;

  static constexpr int kRepliesToMotors = 0;

  static simple::Packet set_motors(const DacWords &words) noexcept {
    return simple::set_dac(words);
  }

  /// Reads the rotary switch. The motors stay as they are.
  static std::optional<Reply> identify(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    simple::Packet bytes;
    if (!link.exchange({}, {simple::latch_counters(), 1}, bytes, deadline))
      return std::nullopt;
    return simple::parse(bytes);
  }

  static bool reset(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    return link.exchange({simple::count_direction()}, {simple::clear_counters()}, {}, deadline);
  }

  static std::optional<Reply> exchange(UsbLink &link, const DacWords &words,
                                       UsbLink::Deadline deadline) noexcept {
    simple::Packet bytes;
    if (!link.exchange({set_motors(words)}, {simple::latch_counters(), 1}, bytes, deadline))
      return std::nullopt;
    return simple::parse(bytes);
  }
};

class Sh4 {
public:
  static constexpr int kCounterBits = sh4::kCounterBits;
  static constexpr UsbModel kModel = UsbModel::sh4;

  static constexpr int kRepliesToMotors = 1;

  static sh4::Packet set_motors(const DacWords &words) noexcept { return sh4::update(words); }

  /// Reads the rotary switch. The only known packet sets the motors too: no tension.
  static std::optional<Reply> identify(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    return exchange(link, {}, deadline);
  }

  static bool reset(UsbLink &, UsbLink::Deadline) noexcept { return true; }

  static std::optional<Reply> exchange(UsbLink &link, const DacWords &words,
                                       UsbLink::Deadline deadline) noexcept {
    sh4::Packet bytes;
    if (!link.exchange({set_motors(words), kRepliesToMotors}, {}, bytes, deadline))
      return std::nullopt;
    return sh4::parse(bytes);
  }
};

template <class Protocol>
class ControllerOf final : public UsbController {
public:
  explicit ControllerOf(std::unique_ptr<UsbLink> link)
      : link_(std::move(link)), exchange_timeout_(usb_exchange_timeout()),
        open_timeout_(std::max(kOpenTimeout, exchange_timeout_)) {
    for (int attempt = 0; attempt < kOpenAttempts; ++attempt) {
      link_->drain();
      if (const auto reply = Protocol::identify(*link_, Clock::now() + open_timeout_)) {
        rotary_switch_ = reply->rotary_switch;
        return;
      }
    }
    fail(Cause::io, messages::kUsbSilent, description().c_str());
  }

  ~ControllerOf() override {
    // To release the interface ends every transfer, those of the guardian, too.
    if (guardian_ && !guardian_->end())
      link_->leave_claim();
  }

  int rotary_switch() const noexcept override { return rotary_switch_; }

  bool reset() noexcept override { return Protocol::reset(*link_, Clock::now() + open_timeout_); }

  void guard(const DacWords &rest) override {
    rest_ = rest;
    const auto packet = Protocol::set_motors(rest);
    link_->set_rest({packet, Protocol::kRepliesToMotors});
    guardian_.reset();
    guardian_.emplace(link_->file_descriptor(), kEndpointOut, packet,
                      exchange_timeout_ + kBetweenExchanges, guardian_service_wanted(),
                      Protocol::kRepliesToMotors > 0 ? kEndpointIn : 0);
  }

  bool exchange(const DacWords &words, Counts &counts) noexcept override {
    const Clock::time_point now = Clock::now();
    // A force is told before it is sent, its end when the rest words were delivered.
    force_ = force_ || is_force(words, rest_);
    // Words of before the guardian put the motors at rest are too old.
    const DacWords &sent = ask_guardian(now) ? words : rest_;
    const bool shared = guardian_ && guardian_->intervenes();
    const auto reply = Protocol::exchange(*link_, sent, now + exchange_timeout_);
    note_delivery(sent);
    ask_guardian(Clock::now());
    if (unguarded_ && force_) { // it died meanwhile: nobody else ends this force in time
      Protocol::exchange(*link_, rest_, Clock::now() + exchange_timeout_);
      note_delivery(rest_);
    }
    // Else the reply may be to a packet of the guardian.
    const bool ours = !shared && !guardian_wrote_;
    if (!reply || !ours || unguarded_ || reply->rotary_switch != rotary_switch_)
      return false;
    for (std::size_t i = 0; i < kStrings; ++i)
      counts_[i] = extended(counts_[i], reply->counters[i], Protocol::kCounterBits);
    counts = counts_;
    inputs_ = reply->inputs;
    return true;
  }

  bool connected() const noexcept override { return !link_->gone() && !unguarded_; }

  bool interrupted() noexcept override { return std::exchange(interrupted_, false); }

  std::string description() const override {
    std::string text = std::string("SPIDAR-G, controller ") + name_of(Protocol::kModel);
    if (rotary_switch_ >= 0)
      text += ", switch " + std::to_string(rotary_switch_);
    return text + ", USB " + link_->place().text();
  }

  std::string remark() const override { return guardian_ ? guardian_->remark() : ""; }

  std::string identity() const override {
    return std::string(name_of(Protocol::kModel)) + ":" + std::to_string(rotary_switch_);
  }

  std::uint16_t inputs() const noexcept override { return inputs_; }

private:
  using Clock = Guardian::Clock;

  /// Exchanges messages with the guardian. Whether a force may be sent: it watches, and has not put
  /// the motors at rest since the call before. Nor on the call after it prevented one: the words
  /// were made before interrupted() reported that, so they do not begin from zero.
  bool ask_guardian(Clock::time_point now) noexcept {
    if (!guardian_)
      return true;
    const Guardian::Watch watch = guardian_->watch(force_, now);
    unguarded_ = watch == Guardian::Watch::dead;
    const bool let_go = guardian_->let_go();
    const bool prevents = watch == Guardian::Watch::silent || guardian_->intervenes();
    const bool changed = prevents != std::exchange(prevents_, prevents);
    interrupted_ = interrupted_ || let_go || changed || prevents;
    link_->expect_replies(guardian_->delivered() * Protocol::kRepliesToMotors -
                          guardian_->replies_read());
    link_->set_shared(guardian_->intervenes());
    guardian_wrote_ = let_go || guardian_->intervenes();
    return watch == Guardian::Watch::kept && !guardian_wrote_ && !changed;
  }

  void note_delivery(const DacWords &sent) noexcept {
    const bool rested = link_->rested();
    interrupted_ = interrupted_ || rested;
    if (link_->first_went_out())
      force_ = is_force(sent, rest_);
    else if (rested)
      force_ = false;
  }

  std::unique_ptr<UsbLink> link_;
  std::chrono::milliseconds exchange_timeout_;
  std::chrono::milliseconds open_timeout_;
  std::optional<Guardian> guardian_;
  DacWords rest_{};
  int rotary_switch_ = -1;
  Counts counts_{};
  std::uint16_t inputs_ = 0;
  bool force_ = false; ///< the motors have, or may have, more than rest_
  bool guardian_wrote_ = false;
  bool prevents_ = false; ///< the guardian is silent or writes: no force is sent
  bool unguarded_ = false;
  bool interrupted_ = false;
};

} // namespace

bool is_force(const DacWords &words, const DacWords &rest) noexcept {
  for (std::size_t i = 0; i < kStrings; ++i)
    if (std::abs(words[i]) > std::abs(rest[i]) + 1)
      return true;
  return false;
}

std::chrono::milliseconds usb_exchange_timeout() {
  const char *value = std::getenv("SPIDAR_USB_TIMEOUT");
  if (!value)
    return std::chrono::milliseconds(kExchangeTimeout);
  int time = 0;
  const char *end = value + std::strlen(value);
  if (const auto [rest, error] = std::from_chars(value, end, time);
      error != std::errc() || rest != end || time < 1 || time > 1000)
    fail(Cause::argument, messages::kUsbTimeout, value);
  return std::chrono::milliseconds(time);
}

const char *name_of(UsbModel model) noexcept {
  return model == UsbModel::sh4 ? "USB2.0 SH4" : "USB2.0 Simple";
}

std::unique_ptr<UsbController> make_usb_controller(UsbModel model, std::unique_ptr<UsbLink> link) {
  if (model == UsbModel::sh4)
    return std::make_unique<ControllerOf<Sh4>>(std::move(link));
  return std::make_unique<ControllerOf<Simple>>(std::move(link));
}

} // namespace spidar
