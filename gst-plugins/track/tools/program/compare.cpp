// SPDX-License-Identifier: LGPL-2.1-or-later
#include "program/compare.hpp"

#include "felt/perception.hpp"
#include "json.hpp"
#include "plot/compare-plot.hpp"
#include "track-error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace haptic {
namespace {

constexpr unsigned kColumns = 5;
constexpr unsigned kRows = 3;

std::vector<PointerPosition> grid(unsigned columns, unsigned rows) {
  std::vector<PointerPosition> places;
  for (unsigned row = 0; row < rows; ++row)
    for (unsigned column = 0; column < columns; ++column)
      places.push_back({.x = (column + 0.5) / columns, .y = (row + 0.5) / rows});
  return places;
}

// The hands that feel the fields or reliefs of either file: those of the options, else the one for
// which the other file was made, else a grid.
Hands hands_for(const FeltFile &a, const FeltFile &b, const CompareOptions &options) {
  if (!a.has_places() && !b.has_places()) {
    if (options.columns > 0 || !options.hand.empty())
      throw_error(messages::kPlacesNeedFields);
    return {grid(1, 1), {}};
  }
  const bool both = a.has_places() && b.has_places();
  if (options.columns > 0 && (!both || !options.hand.empty()))
    throw_error(messages::kPlacesAreGiven);
  if (!options.hand.empty() || !both) {
    const FeltFile &other = a.has_places() ? b : a;
    const FeltFile &places = a.has_places() ? a : b;
    auto path = options.hand.empty() ? other.hand()
                                     : read_hand(options.hand, places.film_begin().value_or(0));
    if (path.empty())
      throw_error(messages::kHandIsMissing, other.path().c_str());
    return {{}, std::move(path)};
  }
  return {options.columns > 0 ? grid(options.columns, options.rows) : grid(kColumns, kRows), {}};
}

void check_kinds(const FeltFile &a, const FeltFile &b) {
  if (a.has_reliefs() && b.has_motion())
    throw_error(messages::kKindsDiffer, a.path().c_str(), b.path().c_str());
  if (b.has_reliefs() && a.has_motion())
    throw_error(messages::kKindsDiffer, b.path().c_str(), a.path().c_str());
}

void check_times(const FeltFile &a, const FeltFile &b) {
  if (std::max(a.begin(), b.begin()) > std::min(a.end(), b.end()))
    throw_error(messages::kTimesDoNotMeet, a.path().c_str(), a.begin(), a.end(), b.path().c_str(),
                b.begin(), b.end());
}

std::size_t worst_place(const Comparison &result) {
  const auto worst = std::ranges::max_element(result.places, {}, &PlaceComparison::distinguishable);
  return static_cast<std::size_t>(worst - result.places.begin());
}

// Returns the s by which the times of the second file are later because of its container: a copy of
// film and track may begin at any time, so both count from the first frame of the video. A log has
// running time, and two tracks without a video the times of their senders. Nothing if one track has
// a video and the other does not say when it starts.
std::optional<double> later_start(const FeltFile &a, const FeltFile &b) {
  if (a.is_log() || b.is_log())
    return 0;
  if (a.film_begin().has_value() != b.film_begin().has_value())
    return std::nullopt;
  return b.film_begin().value_or(0) - a.film_begin().value_or(0);
}

std::string shift_text(const Comparison &result) {
  const double ms = 1e3 * result.shift;
  if (!result.is_start_known)
    return "unknown, since nothing ties one of them to a video: compared where they fit best";
  if (ms == 0)
    return "none";
  return format_text("B is %.0f ms %s than A%s", std::abs(ms), ms > 0 ? "later" : "earlier",
                     result.is_late() ? ", which is felt" : "");
}

// Returns what stands above the picture.
std::string caption_of(const Hands &hands, const Comparison &result) {
  std::string all = format_text("told apart: %.1f %% of the time; shift: %s",
                                100 * result.all.distinguishable, shift_text(result).c_str());
  if (result.places.size() < 2)
    return all;
  const PointerPosition &worst = hands.resting[worst_place(result)];
  return all + format_text("; drawn: (%.2f, %.2f)", worst.x, worst.y);
}

void print_text(const FeltFile &a, const FeltFile &b, const Hands &hands,
                const Comparison &result) {
  std::printf("A                %.3f to %.3f s  %s\n", a.begin(), a.end(), a.path().c_str());
  std::printf("B                %.3f to %.3f s  %s\n", b.begin(), b.end(), b.path().c_str());
  std::printf("shift            %s\n", shift_text(result).c_str());
  std::printf("felt             %.1f %% of the time\n", 100 * result.all.felt);
  std::printf("difference       %.1f mN (rms), while something is felt\n",
              1e3 * result.all.force_rms);
  std::printf("distinguishable  %.1f %% of the time", 100 * result.all.distinguishable);
  if (result.places.size() > 1) {
    const std::size_t worst = worst_place(result);
    std::printf(" at %zu places, %.1f %% at the worst one (%.2f, %.2f)", result.places.size(),
                100 * result.places[worst].distinguishable, hands.resting[worst].x,
                hands.resting[worst].y);
  }
  std::printf("\n");
}

Json json_of(const PlaceComparison &numbers) {
  return {{"distinguishable", rounded(numbers.distinguishable, 1e6)},
          {"felt", rounded(numbers.felt, 1e6)},
          {"force_rms_n", rounded(numbers.force_rms, 1e6)}};
}

// `fitted`: s, by which the times of an unknown start are apart before the shift.
void print_json(const Hands &hands, const Comparison &result, double fitted) {
  Json json = json_of(result.all);
  json["start_known"] = result.is_start_known;
  json["shift_ms"] = std::llround(1e3 * (result.shift + fitted));
  json["seconds"] = rounded(static_cast<double>(result.end - result.first) * kForceStep, 1e3);
  json["places"] = Json::array();
  for (std::size_t i = 0; i < hands.resting.size() && result.places.size() > 1; ++i) {
    Json place = {{"x", rounded(hands.resting[i].x, 1e4)}, {"y", rounded(hands.resting[i].y, 1e4)}};
    place.update(json_of(result.places[i]));
    json["places"].push_back(std::move(place));
  }
  std::puts(json.dump().c_str());
}

} // namespace

int compare(const std::string &path_a, const std::string &path_b, const CompareOptions &options,
            bool json) {
  FeltFile a(path_a, options.stream);
  FeltFile b(path_b, options.stream);
  check_kinds(a, b);
  std::optional<double> start = later_start(a, b);
  if (!start && options.offset != 0)
    start = 0; // the user knows it
  const double fitted = start ? 0 : b.track_begin() - a.track_begin();
  b.delay(options.offset - start.value_or(fitted));
  const Hands hands = hands_for(a, b, options);
  a.feel(hands, options.law, options.range);
  b.feel(hands, options.law, options.range);
  check_times(a, b);
  const bool touched = a.has_reliefs() || b.has_reliefs();
  SignalsAt signals = [&](std::size_t hand) { return SignalPair(a.signal(hand), b.signal(hand)); };
  double shift = options.shift.value_or(0);
  if (touched && hands.path.empty()) {
    // A hand at rest follows both surfaces, so that its forces do not say how they are shifted.
    if (!options.shift)
      shift = best_shift(hands.count(), [&](std::size_t hand) {
        return SignalPair(height_signal(a.surface(hand)), height_signal(b.surface(hand)));
      });
    signals = [&](std::size_t hand) {
      return touch_signals(a.surface(hand), b.surface(hand), options.law.max_force, shift);
    };
  } else if (!options.shift) {
    shift = best_shift(hands.count(), signals);
  }
  const Comparison result = compare_at(shift, hands.count(), signals, start.has_value());
  if (!options.plot.empty())
    plot_comparison(result, signals, worst_place(result), caption_of(hands, result), touched,
                    options.plot);
  if (json)
    print_json(hands, result, fitted);
  else
    print_text(a, b, hands, result);
  const double percent = 100 * result.all.distinguishable;
  if (!options.at_most || percent <= *options.at_most)
    return EXIT_SUCCESS;
  print_error(format_text(messages::kShareIsAbove, percent, *options.at_most));
  return EXIT_FAILURE;
}

} // namespace haptic
