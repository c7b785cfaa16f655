// SPDX-License-Identifier: LGPL-2.1-or-later
#include "commands.hpp"

#include "fail.hpp"

#include <charconv>
#include <functional>
#include <sstream>

namespace emulator {

const char *const kCommandHelp =
    "  unplug               the unit is pulled out\n"
    "  replug               the unit is plugged in again, as after power-on\n"
    "  stall in|out         the endpoint halts until the host clears the halt\n"
    "  short [N]            the next N replies are cut to 7 bytes (default: 1)\n"
    "  refuse               the OUT endpoint takes nothing: each packet waits (NAK)\n"
    "  accept               the OUT endpoint takes packets again, those that wait first\n"
    "  late MS              replies come MS milliseconds late; late 0 ends this\n"
    "  freeze STRING        the counter of string 0..7 stands still\n"
    "  thaw                 all counters count again\n"
    "  jump STRING COUNTS   the counter of string 0..7 jumps by COUNTS\n"
    "  id N                 the rotary switch is set to N, 0 to 15\n"
    "  input PIN 0|1        input pin 0..3 reads 0 or 1 from now on\n"
    "  wrap                 every counter stands just below an end of its range\n"
    "  garbage              counters anywhere and replies nobody asked for, as after power-on\n";

namespace {

using Act = std::function<void(Unit &, Time, std::vector<Completion> &)>;

[[noreturn]] void refuse(const std::string &line, const std::string &reason) {
  spidar::fail(spidar::Cause::argument, spidar::messages::kEmulatorCommand, line.c_str(),
               reason.c_str(), kCommandHelp);
}

class Words {
public:
  explicit Words(const std::string &line) : line_(line) {
    std::istringstream stream(line);
    for (std::string word; stream >> word;)
      words_.push_back(word);
  }

  bool empty() const { return next_ == words_.size(); }

  std::string next() {
    if (empty())
      refuse(line_, "a value is missing");
    return words_[next_++];
  }

  int number(int least, int most) {
    const std::string word = next();
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < least || value > most)
      refuse(line_, "'" + word + "' is no number from " + std::to_string(least) + " to " +
                        std::to_string(most));
    return value;
  }

  /// Removes a last word @UNIT and returns its number, or 0 if there is none.
  int remove_unit(int units) {
    if (words_.empty() || words_.back().front() != '@')
      return 0;
    const std::string word = words_.back().substr(1);
    words_.pop_back();
    for (int unit = 1; unit <= units; ++unit)
      if (word == std::to_string(unit))
        return unit;
    refuse(line_, "there is no unit '" + word + "', they go from 1 to " + std::to_string(units));
  }

private:
  const std::string &line_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

Act parse(const std::string &line, Words &words) {
  constexpr int kMostReplies = 1'000'000;
  constexpr int kMostMilliseconds = 60'000;
  constexpr int kMostCounts = 1 << 24;
  const std::string command = words.next();
  if (command == "unplug")
    return [](Unit &unit, Time, auto &) { unit.unplug(); };
  if (command == "replug")
    return [](Unit &unit, Time now, auto &) { unit.plug(now); };
  if (command == "stall") {
    const std::string endpoint = words.next();
    if (endpoint != "in" && endpoint != "out")
      refuse(line, "stall in or stall out");
    return [in = endpoint == "in"](Unit &unit, Time, auto &done) { unit.stall(in, done); };
  }
  if (command == "short") {
    const int replies = words.empty() ? 1 : words.number(1, kMostReplies);
    return
        [replies](Unit &unit, Time, auto &) { unit.firmware().faults().short_replies = replies; };
  }
  if (command == "refuse" || command == "accept")
    return [refuse_out = command == "refuse"](Unit &unit, Time, auto &) {
      unit.firmware().faults().refuse_out = refuse_out;
    };
  if (command == "late") {
    const std::chrono::milliseconds time(words.number(0, kMostMilliseconds));
    return [time](Unit &unit, Time, auto &) { unit.firmware().faults().late_by = time; };
  }
  if (command == "freeze") {
    const auto string = static_cast<std::size_t>(words.number(0, spidar::kStrings - 1));
    return [string](Unit &unit, Time now, auto &) { unit.firmware().freeze(string, now); };
  }
  if (command == "thaw")
    return [](Unit &unit, Time, auto &) { unit.firmware().thaw(); };
  if (command == "jump") {
    const auto string = static_cast<std::size_t>(words.number(0, spidar::kStrings - 1));
    const int counts = words.number(-kMostCounts, kMostCounts);
    return [string, counts](Unit &unit, Time, auto &) { unit.firmware().jump(string, counts); };
  }
  if (command == "id") {
    const int number = words.number(0, 15);
    return [number](Unit &unit, Time, auto &) { unit.firmware().set_rotary_switch(number); };
  }
  if (command == "input") {
    const int pin = words.number(0, 3);
    const bool level = words.number(0, 1) == 1;
    return [pin, level](Unit &unit, Time, auto &) { unit.firmware().set_input(pin, level); };
  }
  if (command == "wrap")
    return [](Unit &unit, Time now, auto &) { unit.firmware().near_wrap(now); };
  if (command == "garbage")
    return [](Unit &unit, Time now, auto &) { unit.firmware().garbage(now); };
  refuse(line, "nothing known by this name");
}

} // namespace

void obey(const std::string &line, const std::vector<std::unique_ptr<Unit>> &units, Time now,
          std::vector<std::vector<Completion>> &done) {
  Words words(line);
  if (words.empty())
    return;
  const int wanted = words.remove_unit(static_cast<int>(units.size()));
  const Act act = parse(line, words);
  if (!words.empty())
    refuse(line, "too many values");
  done.resize(units.size());
  for (std::size_t i = 0; i < units.size(); ++i) {
    if (wanted != 0 && units[i]->number() != wanted)
      continue;
    act(*units[i], now, done[i]);
    units[i]->firmware().report(line, now);
    // The session sends a reply that waits for time or for the end of a halt.
  }
}

} // namespace emulator
