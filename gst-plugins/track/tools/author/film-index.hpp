// SPDX-License-Identifier: LGPL-2.1-or-later
// What must be known of a film before it is authored: where it can be divided, which container its
// copy gets, and what of it has no place there.
#pragma once

#include "film/copied-stream.hpp"
#include "film/film-streams.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace haptic {

/// A span begins at a key frame. What is measured in it depends on no frame further back than
/// kFramesBefore (span-measure.hpp), so that any process can measure it.
struct Span {
  std::uint64_t begin = 0;       ///< ns, running time
  std::uint64_t decode_from = 0; ///< ns, of the key frame at which the decoder has to begin

  template <typename Self, typename Call>
  static void members(Self &self, const Call &call) {
    call("begin", self.begin);
    call("decode-from", self.decode_from);
  }
};

/// A span ends at the first key frame that is so much later than its begin (ns).
inline constexpr std::uint64_t kSpanLength = 10'000'000'000;

struct FilmIndex {
  std::vector<Span> spans;
  std::string ending;                ///< of the copy: kTransportStream or kMatroska
  std::string rotation;              ///< rotate-90, -180 or -270; "": the frames are upright
  std::uint64_t duration = 0;        ///< ns
  std::uint64_t lead = 0;            ///< ns before the first shown frame that it depends on
  std::vector<std::string> warnings; ///< what of the film is not in the copy
};

/// Reads the whole film without decoding it. Throws TrackFileError if it cannot be authored.
FilmIndex index_film(const std::string &path);

/// Ends the pipeline of the pad with an error if its caps change the size of the frames.
void refuse_other_size(GstPad *pad);

} // namespace haptic
