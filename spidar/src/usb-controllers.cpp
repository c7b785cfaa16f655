#include "usb-controllers.hpp"

#include "spidar/error.hpp"
#include "usb-protocol.hpp"

namespace spidar {

namespace {

constexpr auto kExchangeTimeout = std::chrono::milliseconds(2);
constexpr auto kOpenTimeout = std::chrono::milliseconds(200);
constexpr int kOpenAttempts = 3;

class Simple {
public:
  static constexpr int kCounterBits = simple::kCounterBits;
  static constexpr const char *kName = "USB2.0 Simple";

  /// Without touching the motors.
  static std::optional<Reply> identify(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    simple::Packet bytes;
    if (!link.send(simple::latch_counters(), deadline) || !link.receive(bytes, deadline))
      return std::nullopt;
    return simple::parse(bytes);
  }

  static bool reset(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    return link.send(simple::count_direction(), deadline) &&
           link.send(simple::clear_counters(), deadline);
  }

  static std::optional<Reply> exchange(UsbLink &link, const DacWords &words,
                                       UsbLink::Deadline deadline) noexcept {
    if (!link.send(simple::set_dac(words), deadline))
      return std::nullopt;
    return identify(link, deadline);
  }
};

class Sh4 {
public:
  static constexpr int kCounterBits = sh4::kCounterBits;
  static constexpr const char *kName = "USB2.0 SH4";

  /// The only known packet sets the motors too: to no tension, as after power-on.
  static std::optional<Reply> identify(UsbLink &link, UsbLink::Deadline deadline) noexcept {
    return exchange(link, {}, deadline);
  }

  static bool reset(UsbLink &, UsbLink::Deadline) noexcept { return true; }

  static std::optional<Reply> exchange(UsbLink &link, const DacWords &words,
                                       UsbLink::Deadline deadline) noexcept {
    sh4::Packet bytes;
    if (!link.send(sh4::update(words), deadline) || !link.receive(bytes, deadline))
      return std::nullopt;
    return sh4::parse(bytes);
  }
};

template <class Protocol>
class ControllerOf final : public UsbController {
public:
  explicit ControllerOf(std::unique_ptr<UsbLink> link) : link_(std::move(link)) {
    for (int attempt = 0; attempt < kOpenAttempts; ++attempt) {
      link_->drain();
      if (const auto reply = Protocol::identify(*link_, in(kOpenTimeout))) {
        rotary_switch_ = reply->rotary_switch;
        return;
      }
    }
    throw Error(Cause::io, "The " + description() +
                               " does not answer. Switch it off and on, and plug it in again.");
  }

  int rotary_switch() const noexcept override { return rotary_switch_; }

  bool reset() noexcept override { return Protocol::reset(*link_, in(kOpenTimeout)); }

  bool exchange(const DacWords &words, Counts &counts) noexcept override {
    if (behind_)
      link_->drain();
    const auto reply = Protocol::exchange(*link_, words, in(kExchangeTimeout));
    // A reply may still come after its time; it must not be taken for the next one's.
    behind_ = !reply || reply->rotary_switch != rotary_switch_;
    if (behind_)
      return false;
    for (std::size_t i = 0; i < kStrings; ++i)
      counts_[i] = extended(counts_[i], reply->counters[i], Protocol::kCounterBits);
    counts = counts_;
    return true;
  }

  std::string description() const override {
    std::string text = std::string("SPIDAR-G, controller ") + Protocol::kName;
    if (rotary_switch_ >= 0)
      text += ", switch " + std::to_string(rotary_switch_);
    return text + ", USB " + link_->place();
  }

private:
  static UsbLink::Deadline in(std::chrono::milliseconds time) noexcept {
    return std::chrono::steady_clock::now() + time;
  }

  std::unique_ptr<UsbLink> link_;
  int rotary_switch_ = -1;
  Counts counts_{};
  bool behind_ = false; ///< the last exchange failed, its reply may be on the way
};

} // namespace

std::unique_ptr<UsbController> make_usb_controller(std::uint16_t product,
                                                   std::unique_ptr<UsbLink> link) {
  if (product == kSh4Product)
    return std::make_unique<ControllerOf<Sh4>>(std::move(link));
  return std::make_unique<ControllerOf<Simple>>(std::move(link));
}

} // namespace spidar
