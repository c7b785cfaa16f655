// SPDX-License-Identifier: LGPL-2.1-or-later
// Which of several senders to one port is received.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace haptic {

/// A receiver follows a new sender when the one before has been silent for so long, ns.
inline constexpr std::uint64_t kSenderSilence = 2'000'000'000;

/// Chooses the sender of one RTP session: the first one, until it leaves or falls silent.
class OneSender {
public:
  enum class Verdict {
    pass,     ///< of the chosen sender
    chosen,   ///< the first packet of a sender that is chosen from now on
    drop,     ///< of another sender
    intruder, ///< the same; both are sending, which is to be reported once
  };

  /// A packet of the sender `ssrc` came at `now`, ns of a steady clock. Each sender has a thread: a
  /// time may be a little before that of the last call.
  Verdict packet(std::uint32_t ssrc, std::uint64_t now) {
    if (!chosen_ || (*chosen_ != ssrc && now >= last_ + kSenderSilence)) {
      chosen_ = ssrc;
      last_ = now;
      others_.clear();
      return Verdict::chosen;
    }
    if (*chosen_ == ssrc) {
      last_ = now;
      return Verdict::pass;
    }
    const auto [other, is_new] = others_.try_emplace(ssrc, Other{now, false});
    // A sender that was restarted is no second one: nothing more comes from the first.
    if (is_new || other->second.reported || last_ <= other->second.since)
      return Verdict::drop;
    other->second.reported = true;
    return Verdict::intruder;
  }

  /// Whether this sender is received.
  bool is_chosen(std::uint32_t ssrc) const { return chosen_ == ssrc; }

  /// The sender left.
  void leave(std::uint32_t ssrc) {
    if (chosen_ == ssrc)
      chosen_.reset();
    others_.erase(ssrc);
  }

private:
  struct Other {
    std::uint64_t since; // its first packet
    bool reported;
  };

  std::optional<std::uint32_t> chosen_;
  std::uint64_t last_ = 0;
  std::map<std::uint32_t, Other> others_; // rtpbin bounds their number by its timeouts
};

} // namespace haptic
