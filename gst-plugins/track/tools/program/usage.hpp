// SPDX-License-Identifier: LGPL-2.1-or-later
/// What `haptic-track --help` and `haptic-track VERB --help` print.
#pragma once

#include <string_view>
#include <utility>

namespace haptic {

inline constexpr char kUsage[] =
    R"(Shows, converts, cuts, draws, compares and makes haptic tracks: files that say how a video moves.

Usage: haptic-track VERB [OPTION...] FILE...
  info     prints what a file contains
  convert  writes a track in another format, also as sound
  cut      writes a part of a track, or of a recording
  plot     draws a track
  compare  prints how much of the time a hand could tell two files apart
  author   measures videos, and writes copies with a haptic track
  package  makes a folder for a web server: a page where a video is seen and felt

haptic-track VERB --help explains a verb and its options. --version prints the version.
A file is a recording (.ts, .mkv, .mp4), a track (.klv, .txt) or MPEG haptics (.hmpg, .hjif).

Example: haptic-track author in.mp4
)";

inline constexpr std::pair<std::string_view, const char *> kUsageOfVerbs[] = {
    {"info",
     R"(Prints what files contain: the kind of each track, its times, its size and what it measured.

Usage: haptic-track info [--stream NAME] FILE...
  --stream NAME  only the track with this name (default: all tracks)

The exit status is 0 if all files were read.

Example: haptic-track info recorded.ts
)"},
    {"convert", R"(Writes a track in another format. A video beside the track is left out.

Usage: haptic-track convert [OPTION...] FILE OUTPUT
  OUTPUT         its ending chooses the format: .klv, .txt, .ts, .mkv, .hmpg, .hjif, or
                 vibration: .wav (a channel for each actuator of an array), .ahap (a telephone)
  --hand LOG     for motion fields: writes the motion under the hand of this log of hapticsink (.csv)
  --layout NAME  for .wav: a layout of hapticarray, by name or path (default: back-3x4)
  --map MAP      for .wav: stroke, field or point (default: stroke)
  --alpha S/PX   for .wav and .ahap: steepness of the force law, 0.0001 to 10 s/px (default: 0.01)
  --stream NAME  the track with this name, if info shows several
  --force        overwrites OUTPUT

Example: haptic-track convert recorded.ts track.klv
)"},
    {"cut", R"(Writes a part of a track or of a recording. The part begins at 0 s.

Usage: haptic-track cut [OPTION...] FILE OUTPUT
  --from S       where the part begins, in seconds of FILE (default: at its beginning)
  --to S         where the part ends, in seconds of FILE (default: at its end)
  --with-video   also cuts video and sound (.ts, .mkv), at the key frames around the part
  --stream NAME  the track with this name, if info shows several
  --force        overwrites OUTPUT

Example: haptic-track cut --from 10 --to 20 recorded.ts part.klv
)"},
    {"plot",
     R"(Draws a track: velocity and force over time, or motion fields over frames of the video.

Usage: haptic-track plot [OPTION...] FILE OUTPUT.png
       haptic-track plot [OPTION...] FILE OUTPUT.gif    a moving picture; for motion fields only
  --place X,Y    for reliefs: where the height is drawn, 0 to 1 from the top left (default: 0.5,0.5)
  --hand LOG     for reliefs: draws the height under the hand of this log of hapticsink (.csv)
  --stream NAME  the track with this name, if info shows several
  --force        overwrites OUTPUT

Example: haptic-track plot in.haptic.ts fields.png
)"},
    {"compare",
     R"(Prints how much of the time a hand could tell two files apart. Each is a track, or a log of
hapticsink (.csv). The result comes from a model of perception, not from people.

Usage: haptic-track compare [OPTION...] A B
  --at-most PERCENT  the exit status is 1 above this share of the time, 0 to 100 % (default: never)
  --json             prints JSON
  --plot FILE.png    draws both forces
  --from S           begins here, in seconds of A (default: at the beginning)
  --to S             ends here, in seconds of A (default: at the end)
  --offset S         seconds that are added to the times of B (default: 0)
  --shift S          how late B is, -2 to 2 s (default: what fits best)
  --places CxR       for fields and reliefs: columns and rows of the compared places, 1 to 32
                     (default: 5x3)
  --hand LOG         for fields and reliefs: compares under the hand of this log of hapticsink
  --alpha S/PX       for tracks: steepness of the force law, 0.0001 to 10 s/px (default: 0.01)
  --max-force N      for tracks: force of the fastest motion, 0.01 to 5 N (default: 1 N)
  --stream NAME      in both files, the track with this name
  --force            overwrites the picture

Example: haptic-track compare before.klv after.klv
)"},
    {"author",
     R"(Measures the motion of the whole frame of videos. It writes a copy of each video with this motion as
a haptic track: NAME.haptic.ts or NAME.haptic.mkv. Video and sound are copied without re-encoding. A
copy that exists is kept, so a second run continues where the first was stopped.

Usage: haptic-track author [OPTION...] VIDEO...
       haptic-track author --plan [OPTION...] VIDEO... > PLAN    the same on many machines: a plan,
       haptic-track author --chunk K PLAN                        its chunks in any order,
       haptic-track author --merge PLAN                          and the copies of all chunks
  --output FOLDER  where the copies go; the folder is made (default: beside each video)
  --columns N      columns of the motion field, 4 to 96 (default: 32)
  --hold PLACE     follows a thing, so that a hand can hold it. PLACE is X,Y or X,Y@SECONDS, with X and
                   Y from 0 to 1 from the top left (default time: 0 s), or auto: the program chooses
                   the things. May be given up to 32 times
  --jobs N         videos at a time, 1 to 1024 (default: one for each processor core)
  --chunks N       with --plan: about so many chunks (default: one for each minute)
  --chunk K        the chunk to measure, counted from 0

The exit status is 0 if all copies exist.

Example: haptic-track author --output authored in.mp4
)"},
    {"package",
     R"(Makes a folder of files for any web server: a page where a video is seen and felt, and the segments
of the video with its haptic track (HLS). The video is measured first if it has no track.

Usage: haptic-track package [OPTION...] --output FOLDER VIDEO...
       haptic-track package --single [OPTION...] --output FOLDER VIDEO.mp4
  VIDEO              further videos are other bitrates of the same film
  --output FOLDER    where the files go; the folder is made
  --single           for a short video: the MP4 as it is, its track as one file, and a page
  --carriage FORMAT  format of the segments: mp4 or ts (MPEG-TS) (default: mp4)
  --columns N        columns of the motion field, 4 to 96 (default: 32)
  --hold PLACE       follows a thing that can be held, as in haptic-track author

Example: haptic-track package --output film in.mp4
)"}};

} // namespace haptic
