// SPDX-License-Identifier: LGPL-2.1-or-later
// The one table of all actions: their keys, the window that F1 shows, and the text of --help are
// made of it.
#pragma once

#include <array>
#include <gtk/gtk.h>
#include <string>

namespace program {

enum class KeyGroup { film, playback, force, window };

struct Key {
  KeyGroup group;
  const char *action;       ///< of the window
  const char *accelerators; ///< as gtk_accelerator_parse() reads them, separated by spaces
  const char *what;         ///< what it does
};

inline constexpr std::array kKeys = {
    Key{KeyGroup::film, "open", "<Control>o", "Open a film"},
    Key{KeyGroup::film, "open-url", "<Control>l", "Open a URL (http, https, rtsp)"},
    Key{KeyGroup::film, "show-cameras", "<Control>k", "Choose a camera"},
    Key{KeyGroup::film, "record", "<Control>r", "Record film and track, end the recording"},
    Key{KeyGroup::playback, "play", "space", "Pause, play"},
    Key{KeyGroup::playback, "back", "Left", "5 s back"},
    Key{KeyGroup::playback, "forward", "Right", "5 s forward"},
    Key{KeyGroup::playback, "begin", "Home", "To the beginning"},
    Key{KeyGroup::playback, "slower", "minus KP_Subtract", "Slower"},
    Key{KeyGroup::playback, "faster", "plus equal KP_Add", "Faster"},
    Key{KeyGroup::playback, "reverse", "r", "Reverse the direction"},
    Key{KeyGroup::playback, "rotate", "o", "Turn the film by 90°"},
    Key{KeyGroup::playback, "deinterlace", "d", "Deinterlace: automatic, always, never"},
    Key{KeyGroup::playback, "mute", "m", "Sound off and on"},
    Key{KeyGroup::playback, "quieter", "Down", "Quieter"},
    Key{KeyGroup::playback, "louder", "Up", "Louder"},
    Key{KeyGroup::force, "arm", "s", "Force off and on"},
    Key{KeyGroup::force, "release", "Escape", "Force off; leave full screen"},
    Key{KeyGroup::force, "hold", "h", "Hold what is under the pointer, let go"},
    Key{KeyGroup::force, "weaker", "less comma", "Weaker"},
    Key{KeyGroup::force, "stronger", "greater period", "Stronger"},
    Key{KeyGroup::force, "smaller-region", "bracketleft", "Smaller region"},
    Key{KeyGroup::force, "larger-region", "bracketright", "Larger region"},
    Key{KeyGroup::force, "default-region", "0 KP_0", "Region of the default size"},
    Key{KeyGroup::force, "next-law", "l", "Next force law"},
    Key{KeyGroup::force, "show-devices", "<Control>d", "Choose a device"},
    Key{KeyGroup::force, "calibrate", "<Control>c", "Calibrate: the grip is in the centre now"},
    Key{KeyGroup::window, "fullscreen", "F11 f", "Full screen"},
    Key{KeyGroup::window, "drawing", "v", "Motion and force drawn over the film"},
    Key{KeyGroup::window, "curves", "c", "Curves"},
    Key{KeyGroup::window, "menu", "F10", "Menu"},
    Key{KeyGroup::window, "keys", "F1 <Control>question", "Keys"},
    Key{KeyGroup::window, "quit", "q <Control>q <Control>w", "Quit"},
};

/// Sets the accelerators of all actions.
void set_accelerators(GtkApplication *application);

/// Returns the window that F1 shows, on a page where the screen has room for it.
GtkWidget *make_shortcuts_window(int screen_height);

/// Returns the keys of an action for a person, "space" or "F11, f". Empty if there is none.
std::string keys_of(const std::string &action);

/// Returns all keys, one line each, for --help.
std::string keys_as_text();

} // namespace program
