// SPDX-License-Identifier: LGPL-2.1-or-later
// Makes a folder of static files that a browser plays and feels (docs/web.md).
#pragma once

#include "author/author-plan.hpp"

#include <string>
#include <vector>

namespace haptic {

enum class Carriage { transport_stream, fragments };

struct PackageOptions {
  Carriage carriage = Carriage::fragments;
  AuthorOptions author; ///< `folder` is that of the package
};

/// Writes a page for one MP4, which stays as it is, and its track as one file beside it. Throws
/// TrackFileError. Returns the exit status.
int package_single(const std::vector<std::string> &videos, const AuthorOptions &options);

/// Writes the videos, bit rates of one film, with one field track, the playlists, a poster and the
/// player. What is there stays; the main playlist appears last. Throws TrackFileError. Returns the
/// exit status.
int package(const std::vector<std::string> &videos, const PackageOptions &options);

} // namespace haptic
