// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracks/track-remark.hpp"

#include "track-error.hpp"

#include <array>
#include <cstdarg>
#include <cstddef>

namespace haptic {
namespace {

// In the order of FileRemark.
constexpr std::array kSentences = {
    "line %zu: %s",
    "damaged: %s",
    "%zu further ones were left out",
    "%zu sets of other origin, version or kind were passed over",
    "unit at byte %zu: %s",
    "byte %zu: the last unit is cut off; the rest was left out",
    "byte %zu: this is no unit; the rest was left out",
    "left out: %s",
    "the file ends early: %s",
    messages::kTrackIsLonger,
    messages::kTrackHasOtherFrame,
    "%zu samples of one point beside the fields were left out",
    "%zu reliefs beside the motion were left out",
    "further haptic tracks were left out",
    "a further stream was left out: %s",
    "%zu frames before the first IDR frame were left out",
    messages::kSegmentsAreLong,
    messages::kRatesAreNotAligned,
};
static_assert(kSentences.size() == static_cast<std::size_t>(FileRemark::rates_not_aligned) + 1);

} // namespace

Remark remark(FileRemark kind, ...) {
  std::va_list values;
  va_start(values, kind);
  Remark made{kind, format_list(kSentences.at(static_cast<std::size_t>(kind)), values)};
  va_end(values);
  return made;
}

void print_remark(const std::string &path, const Remark &remark) {
  print_error('"' + path + "\": " + remark.text);
}

void print_remarks(const std::string &path, const std::vector<Remark> &remarks) {
  for (const Remark &one : remarks)
    print_remark(path, one);
}

} // namespace haptic
