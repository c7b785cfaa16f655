// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure. docs/troubleshooting.md is made from
// it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
#define DEVICE_MESSAGES(MESSAGE)                                                                   \
  MESSAGE(kSimulatedInstead, "No SPIDAR-G found on USB; a simulated one takes its place.",         \
          "Plug one in and switch it on, or set device=sim to avoid this message.")                \
  MESSAGE(kUnknownDevice, "The device \"%s\" is not known.",                                       \
          "Use auto, sim, usb, usb:ID, evdev, evdev:PATH or none.")                                \
  MESSAGE(kLogNotWritable, "The log \"%s\" cannot be written: %s.",                                \
          "Choose another log-location.")                                                          \
  MESSAGE(kLogStopped, "The log cannot be written any more: %s. The force goes on.",               \
          "The log is incomplete. Make room on the disk before the next start.")                   \
  MESSAGE(kFaultRecorded,                                                                          \
          "The force stopped (%s). The file %s has the last ticks, and %d ticks of the last "      \
          "second were late.",                                                                     \
          "Add the file to a report. docs/formats/csv-log.md explains its columns.")               \
  MESSAGE(kFaultNotRecorded,                                                                       \
          "The last ticks before the force stopped cannot be written to %s: %s.",                  \
          "Set fault-location to a folder that you may write to, or to none.")                     \
  MESSAGE(kDeviceIsAway, "The device that was lost is not there yet: %s.", "Plug it in again.")    \
  MESSAGE(kDeviceIsBack, "The device is back: %s.",                                                \
          "Hold the grip in the centre, calibrate (signal calibrate), and re-arm (signal arm).")   \
  MESSAGE(kDeviceSilent, "The device does not answer. The force is off and the video goes on.",    \
          "Check its cable and power, then re-arm (signal arm).")                                  \
  MESSAGE(kBeyondDevice, "The device (%s) cannot do all that is set. It does at most: %s.",        \
          "To avoid this message, set these properties to at most these values.")                  \
  MESSAGE(kGripLetGo,                                                                              \
          "The grip moved faster than %g m/s or turned faster than %g rad/s, as if it had been "   \
          "let go. The force is off and the video goes on.",                                       \
          "Take the grip and re-arm (signal arm).")                                                \
  MESSAGE(                                                                                         \
      kForceShook,                                                                                 \
      "The force followed the hand so strongly that both shook. The force is off and the "         \
      "video goes on.",                                                                            \
      "Hold the grip firmly, lower alpha or choose force-law=arctan, and re-arm (signal arm).")    \
  MESSAGE(kMachineSlept, "The machine slept. The force is off and the video goes on.",             \
          "Take the grip and re-arm (signal arm).")                                                \
  MESSAGE(kSampleDamaged,                                                                          \
          "A motion sample is damaged, so it gave no force. Further damaged samples are only "     \
          "counted (stats).",                                                                      \
          "Check the element before hapticsink: it makes wrong samples.")                          \
  MESSAGE(kReliefDamaged,                                                                          \
          "A relief is damaged, so it gave no force. Further damaged reliefs are only counted "    \
          "(stats).",                                                                              \
          "Check the element before hapticsink: heights are metres, up to 1 m.")                   \
  MESSAGE(kAboutToSleep, "The machine is about to sleep. The force is off.",                       \
          "When the machine is awake again, take the grip and re-arm (signal arm).")               \
  MESSAGE(kSamplesLost,                                                                            \
          "The loop stood still for seconds and lost motion samples. Further ones are only "       \
          "counted (stats).",                                                                      \
          "End programs that keep the processors busy.")                                           \
  MESSAGE(kNoButton, "dead-man=button needs a button, but no button of %s is known.",              \
          "Set dead-man=none, name the button in the geometry (button-bit and button-pressed), "   \
          "or choose a joystick or the simulated device.")                                         \
  MESSAGE(kNoRealTime,                                                                             \
          "A busy machine may delay the force: real-time priority %s, loop object and stack "      \
          "locked: %s.",                                                                           \
          "Install rtkit, or allow both with the lines \"@plugdev - rtprio 60\" and \"@plugdev - " \
          "memlock 8192\" in "                                                                     \
          "/etc/security/limits.d/spidar.conf, and log in again.")                                 \
  MESSAGE(kPriorityOnLoan,                                                                         \
          "The real-time priority comes from rtkit or the portal, which demand the limit "         \
          "RLIMIT_RTTIME. It holds for the whole process and cannot be raised again: if any "      \
          "real-time thread runs longer without a sleep, the kernel ends the process.",            \
          "If the program has such threads, allow the priority without a service by the line "     \
          "\"@plugdev - rtprio 60\" in /etc/security/limits.d/spidar.conf, and log in again.")     \
  MESSAGE(kLayoutUnknown, "There is no layout \"%s\".",                                            \
          "Use back-3x4, ring-8, shakers-2, coils-2, or the path of a file that ends in .ini.")    \
  MESSAGE(kLayoutUnreadable, "The layout %s cannot be read: %s.",                                  \
          "The page docs/formats/array-layout.md explains the format.")                            \
  MESSAGE(kLayoutUnit, "%s: [array] has no unit of length.",                                       \
          "Add a line such as unit=cm (m, cm or mm).")                                             \
  MESSAGE(kLayoutKeyMissing, "%s: [%s] has no %s.",                                                \
          "Each actuator needs x and y. It also needs a carrier, unless [array] has one.")         \
  MESSAGE(kLayoutKeyUnknown, "%s: [%s] has an unknown key, %s.",                                   \
          "Correct the key, or number the actuators from 1 on without a gap.")                     \
  MESSAGE(kLayoutNumber, "%s: [%s] %s=%s is not a number from %g to %g.", "Correct the number.")   \
  MESSAGE(kLayoutCount, "%s has %zu actuators.", "An array has 2 to 64 actuators.")                \
  MESSAGE(kLayoutSamePlace, "%s: actuators %zu and %zu are at the same place.",                    \
          "Place any two actuators at least 1 mm apart.")                                          \
  MESSAGE(kArrayChannels, "The output does not take the %d channels of the layout.",               \
          "Choose a layout with at most as many actuators as the device has channels. Put "        \
          "audioconvert before the device for the sample format.")                                 \
  MESSAGE(kArrayNeedsField,                                                                        \
          "map=field needs a motion field, but this input has one motion for each frame.",         \
          "Put motionfield before hapticarray instead of velocityavg, or set map=stroke.")         \
  MESSAGE(kArraySampleDamaged, "A motion is damaged, so no actuator vibrated for it.",             \
          "Check the element before hapticarray: it makes wrong samples.")                         \
  MESSAGE(kNoJoysticksBuilt, "This build cannot use joysticks.",                                   \
          "Install libevdev-dev and build it again.")                                              \
  MESSAGE(kNoJoystick, "No joystick or wheel with force feedback found.%s",                        \
          "Plug one in and switch it on.")                                                         \
  MESSAGE(                                                                                         \
      kJoystickForbidden, "This user may not open the input device %s.",                           \
      "Run 'usermod -aG input USER' as root and log in again. Or put the "                         \
      "line\nKERNEL==\"event*\", SUBSYSTEM==\"input\", ENV{ID_INPUT_JOYSTICK}==\"1\", "            \
      "TAG+=\"uaccess\"\ninto /etc/udev/rules.d/70-joystick.rules, and plug the device in again.") \
  MESSAGE(kNoInputDevice, "There is no input device %s.",                                          \
          "Plug it in, or set device=evdev to use the first device found. Its link in "            \
          "/dev/input/by-id stays the same when you plug it in again.")                            \
  MESSAGE(kInputNotOpened, "The input device %s cannot be opened: %s.", "Plug it in again.")       \
  MESSAGE(kNotAnInput, "%s is not an input device.",                                               \
          "Input devices are /dev/input/event0 and so on, and the links in /dev/input/by-id.")     \
  MESSAGE(kNoForceFeedback, "%s has no force feedback.",                                           \
          "Choose another device. gst-device-monitor-1.0 Sink/Haptics lists the devices with "     \
          "force feedback.")                                                                       \
  MESSAGE(kNoStick, "%s has no stick or wheel to point with.", "Choose another device.")           \
  MESSAGE(kJoystickBusy, "Another program uses %s.", "End that program first.")                    \
  MESSAGE(kNoRoomForEffect,                                                                        \
          "%s has no room for another effect: another program plays effects on it.",               \
          "End that program first.")                                                               \
  MESSAGE(kForceRefused, "%s does not take a force: %s.", "Plug it in again.")

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
DEVICE_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
