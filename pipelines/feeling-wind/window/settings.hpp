// SPDX-License-Identifier: LGPL-2.1-or-later
// What the program remembers, in feeling-wind/settings.ini of the user's configuration folder.
#pragma once

#include <string>

namespace program {

/// The device is not remembered: a real one is chosen each time by a person.
struct Settings {
  double alpha = 0; ///< s/px, strength; 0: not chosen yet
  int region = 0;   ///< px, 0: the default
  std::string law = "arctan";
  bool drawing = true;
  bool curves = true;
  double volume = 1; ///< 0..1
  bool muted = false;
  std::string appearance = "system"; ///< system, light or dark
  std::string folder;                ///< of the last film

  /// Values that are missing or cannot be read keep their defaults.
  static Settings load();
  /// Returns false if the file cannot be written.
  bool save() const;
};

} // namespace program
