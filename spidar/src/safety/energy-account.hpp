// SPDX-License-Identifier: LGPL-2.1-or-later
// The energy that the force has given to the hand, and what it may still give (Stramigioli and
// others 2005). docs/force.md#energy gives the reasons.
#pragma once

#include <spidar/types.hpp>

namespace haptic {

/// Two purses. The film's fills by itself; all work on the hand is paid from it. The hand's is for
/// the force that follows the hand, and fills by nothing but the work that the hand has put into
/// it, or a surface or a held thing by its own way. One thread; real-time safe. SI units.
class EnergyAccount {
public:
  /// Work that the force may do on the hand: kWorkAtOnce in a moment and kWorkRate for ever. That
  /// is at most 2.4 J, or 0.48 W, over any 5 s, and what two ticks add; it is a debt.
  static constexpr double kWorkAtOnce = 0.9; // J
  static constexpr double kWorkRate = 0.3;   // W

  /// What happened between the last two exchanges.
  struct Charge {
    spidar::Wrench acted;                             ///< on the grip
    spidar::Wrench film;                              ///< the film's part of it
    bool by_hand = false;                             ///< the hand had a part in it
    spidar::Vector3 moved = spidar::Vector3::Zero();  ///< m, the grip
    spidar::Vector3 turned = spidar::Vector3::Zero(); ///< rad
    double trickle = 0;      ///< W, to the hand's purse while a force follows the hand
    double surface_work = 0; ///< J, that a surface has put into the touch
    double hidden_work = 0;  ///< J, of a thing, that the measured way hides; pays only a debt
    spidar::Vector3 carried = spidar::Vector3::Zero(); ///< m, a thing that pulls at the hand
    double most = 0; ///< J, that the hand may have back; what is above it is lost, a debt is not
    bool limits_film = true; ///< else the film's work is no debt
    double time = 0;         ///< s
  };
  void charge(const Charge &charge) noexcept;
  /// The pose is measured anew.
  void calibrate() noexcept;

  /// 0..1 of the force; it goes down over the last of the film's work.
  double share_of_film() const noexcept;
  /// J; negative: a debt, paid by a hand that presses in.
  double of_hand() const noexcept { return hand_; }
  struct Motion {
    spidar::Vector3 velocity = spidar::Vector3::Zero(); ///< m/s, low-passed
    spidar::Vector3 moved = spidar::Vector3::Zero();    ///< m, in the last `time` s
    double time = 0;                                    ///< s
    double flicker = 0;                                 ///< m of `moved` that is no speed
    double delay = 0;                                   ///< s, until a command has acted
    double credit = 0; ///< J, with which a force begins that nothing was put in yet
    double lent = 0;   ///< J, that a push may take beyond what the purse holds
    /// N, the command before this one: it acts first, for `takes` s
    spidar::Vector3 on_its_way = spidar::Vector3::Zero();
    double takes = 0;
  };
  /// Returns the part of the hand's force that the purse can pay, whatever the hand does until the
  /// command has acted.
  spidar::Vector3 affordable(const spidar::Vector3 &force, const Motion &hand) const noexcept;

private:
  double film_ = kWorkAtOnce; // J; negative: a debt
  double hand_ = 0;           // J; negative: a debt
};

} // namespace haptic
