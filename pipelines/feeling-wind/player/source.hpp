// SPDX-License-Identifier: LGPL-2.1-or-later
// What the user named: a file, a URL, a camera or the test film, and the elements that read it.
#pragma once

#include <gst/gst.h>
#include <string>

namespace program {

enum class SourceKind { none, file, url, camera, test };

struct Source {
  SourceKind kind = SourceKind::none;
  std::string name;  ///< path, URL or device file
  std::string title; ///< for the window

  bool is_live() const { return kind == SourceKind::camera || kind == SourceKind::test; }
  bool is_remote() const { return kind == SourceKind::url; }
};

/// Reads FILE, URL, "camera", "/dev/videoN" or "test". A relative file is one of `folder`.
Source source_named(const std::string &argument, const std::string &folder);

/// Returns why the source cannot be opened and the cure, in a sentence. Empty if nothing is known.
std::string problem_of(const Source &source);

/// Adds the elements to the pipeline. Returns the one, owned by the pipeline, that has pad-added,
/// no-more-pads and autoplug-continue; or nothing if an element is missing. `with_sound`: also
/// pads of sound.
GstElement *add_source(GstBin *pipeline, const Source &source, bool with_sound);

} // namespace program
