// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure: library, tools, emulator.
// docs/troubleshooting.md is made from it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
#define SPIDAR_MESSAGES(MESSAGE)                                                                   \
  /* Geometry files: file, section, key */                                                         \
  MESSAGE(kNoGeometry, "No geometry '%s'. Known are %s, and the files in %s.",                     \
          "Give one of these names, the path of a file, or put a file NAME.ini into a directory "  \
          "of SPIDAR_GEOMETRY_PATH.")                                                              \
  MESSAGE(kGeometryUnreadable, "Cannot read the geometry file %s: %s.",                            \
          "Give the path of a geometry file. docs/formats/geometry.md explains the format.")       \
  MESSAGE(kGeometryUnwritable, "The geometry file %s cannot be written: %s.",                      \
          "Choose another place with --output.")                                                   \
  MESSAGE(kGeometryBroken, "Built-in geometry %s: %s.",                                            \
          "This is a mistake in libspidar: report it.")                                            \
  MESSAGE(kGeometryKeyMissing, "%s: [%s] %s is missing.",                                          \
          "Add the key. docs/formats/geometry.md explains every key.")                             \
  MESSAGE(kGeometryKeyUnknown, "%s: [%s] %s is not a key of a geometry file.",                     \
          "Remove the key, or correct its spelling.")                                              \
  MESSAGE(kGeometryNumber, "%s: [%s] %s has '%s' where a number is expected.",                     \
          "Write one number, with a decimal point.")                                               \
  MESSAGE(kGeometryVector,                                                                         \
          "%s: [%s] %s must be three numbers with ';' between them, but is '%s'.",                 \
          "Write the numbers in metres, such as 0.1;0;-0.1.")                                      \
  MESSAGE(kGeometryWhole, "%s: [%s] %s must be a whole number from %d to %d.",                     \
          "Correct the number. docs/formats/geometry.md explains every key.")                      \
  MESSAGE(kGeometryValue, "Geometry %s: %s %s.",                                                   \
          "Correct the value. docs/formats/geometry.md explains every key.")                       \
  MESSAGE(kGeometryClosure,                                                                        \
          "Geometry %s: the strings cannot pull in every direction; missing: %s.",                 \
          "Check the signs and the order of motor and attachment.")                                \
  /* Measuring a device */                                                                         \
  MESSAGE(kMoveTooSmall, "The grip has moved too little along %s.",                                \
          "Move the grip by at least 5 mm, and say by how many metres. A tenth of the frame is a " \
          "good distance.")                                                                        \
  MESSAGE(kCountersStill, "The counters have not moved.",                                          \
          "Take the grip in your hand, and switch the device on.")                                 \
  MESSAGE(kMovedOtherwise,                                                                         \
          "The strings did not move as expected for a grip that moves along %s without turning.",  \
          "Keep the grip upright, and move it along one axis in the right direction. If that "     \
          "does not help, the geometry does not belong to this device.")                           \
  MESSAGE(kScaleTooFar, "%s would be %s times the value in the present geometry.",                 \
          "Check the unit of your answer, and that the geometry belongs to this device.")          \
  MESSAGE(kForceNotPositive, "The force must be a number of newtons greater than zero.",           \
          "Give the number that the balance shows.")                                               \
  /* Programs that use the library */                                                              \
  MESSAGE(kNoController, "A device needs a controller.",                                           \
          "Give the one that open_usb() returns, or a Simulator.")                                 \
  MESSAGE(kPeriod, "The %s's period must be from 0.00001 to 0.1 s.", "Give 0.001 for 1 kHz.")      \
  MESSAGE(kNoHand, "The simulator needs a hand script.",                                           \
          "Give the one that parse_hand_script() returns.")                                        \
  /* C API: what a code means */                                                                   \
  MESSAGE(kCodeNotFound, "There is no such device, geometry or file.",                             \
          "Plug the device in and switch it on, or check the name.")                               \
  MESSAGE(kCodePermission, "The device may not be opened by this user.",                           \
          "Read spidar_open_error(): it has the line for udev.")                                   \
  MESSAGE(kCodeBusy, "Another program uses the device.", "Close that program first.")              \
  MESSAGE(kCodeGeometry, "The geometry cannot be used.",                                           \
          "Read spidar_open_error(): it names the key to correct.")                                \
  MESSAGE(                                                                                         \
      kCodeArgument, "A value makes no sense.",                                                    \
      "After spidar_open(), read spidar_open_error(): it names the value. spidar/spidar.h has "    \
      "the ranges of spidar_limits.")                                                              \
  MESSAGE(                                                                                         \
      kCodeIo, "The device does not answer.",                                                      \
      "Check its cable and power; if spidar_state.connected is 0, close it and open it again.")    \
  MESSAGE(kCodeNull, "A pointer is null.",                                                         \
          "Give the address of an object; a device is what spidar_open() stored.")                 \
  MESSAGE(kCodeVersion, "A struct has another size than in this libspidar.",                       \
          "Begin with SPIDAR_OPTIONS_INIT or the like, and compile the program again with the "    \
          "headers of the installed library.")                                                     \
  MESSAGE(kCodeMemory, "The system has no memory or threads left.", "Close other programs.")       \
  MESSAGE(kCodeUnknown, "This is not a code of libspidar.",                                        \
          "Give a value that one of its functions returned.")                                      \
  /* Programs that use the library: why there is no force */                                       \
  MESSAGE(kForceLimits, "A limit of the force is out of its range.",                               \
          "The header spidar/limited-device.hpp names the ranges.")                                \
  MESSAGE(kHoldReleased, "The program has released the force.",                                    \
          "Take the grip, and call spidar_arm().")                                                 \
  MESSAGE(kHoldLetGo,                                                                              \
          "The grip moved faster than 1 m/s or turned faster than 3 rad/s, as if it had been let " \
          "go. The force is off.",                                                                 \
          "Take the grip, and call spidar_arm().")                                                 \
  MESSAGE(kHoldFaulted, "The device does not answer. The force is off.",                           \
          "Check its cable and power. Call spidar_arm(); if spidar_state.connected is 0, close "   \
          "the device and open it again.")                                                         \
  MESSAGE(kHoldSlipped, "A string slips or has slipped. The force is off.",                        \
          "Check the strings, hold the grip in the centre, and call spidar_calibrate().")          \
  MESSAGE(kHoldNoPose, "The pose of the grip is not known. The force is off.",                     \
          "Hold the grip still. If that does not help, hold it in the centre and call "            \
          "spidar_calibrate().")                                                                   \
  MESSAGE(kHoldLate, "An exchange came more than 10 ms after the one before. The force is off.",   \
          "Call spidar_exchange() once a period, from a thread with real-time priority.")          \
  MESSAGE(kHoldNotFinite, "The command is not a finite number, so it counts as zero.",             \
          "Check what the program computes from a pose that is not valid.")                        \
  /* Hand scripts */                                                                               \
  MESSAGE(kHandScript, "Hand script '%s': %s.",                                                    \
          "Use hold:X,Y,Z, circle:RADIUS,PERIOD, file:PATH or free. X, Y, Z and RADIUS are from "  \
          "-1 to 1 (of the half workspace), and PERIOD is in seconds.")                            \
  MESSAGE(kHandScriptMissing, "Cannot open the hand script '%s'.",                                 \
          "Give the path of a text file with lines t,x,y,z.")                                      \
  MESSAGE(kHandScriptLine, "Hand script '%s', line %zu: %s.",                                      \
          "A line is t,x,y,z: t in s, x, y and z from -1 to 1 (of the half workspace).")           \
  MESSAGE(kHandScriptEmpty, "Hand script '%s' has no readable line.", "It needs lines t,x,y,z.")   \
  /* USB */                                                                                        \
  MESSAGE(kNotOnUsb, "No SPIDAR-G%s found on USB.%s",                                              \
          "Plug it in and switch it on; 'lsusb' should list 0cec:0203 or 0cec:0205.")              \
  MESSAGE(kUsbUnusable, "USB cannot be used (%s).",                                                \
          "Make sure that /dev/bus/usb is there and readable.")                                    \
  MESSAGE(kUsbForbidden, "This user may not open the SPIDAR-G on USB %s.",                         \
          "Put the line\n  SUBSYSTEM==\"usb\", ATTR{idVendor}==\"0cec\", "                         \
          "ATTR{idProduct}==\"0201|0203|0205\", TAG+=\"uaccess\"\ninto "                           \
          "/etc/udev/rules.d/70-spidar.rules, then run 'sudo udevadm control --reload' and plug "  \
          "the device in again.")                                                                  \
  MESSAGE(kUsbBusy, "The SPIDAR-G on USB %s is in use by %s.", "Close that program first.")        \
  MESSAGE(kUsbUnplugged, "The SPIDAR-G on USB %s has been unplugged.",                             \
          "Plug it in and try again.")                                                             \
  MESSAGE(kUsbNotOpened, "The SPIDAR-G on USB %s cannot be opened (%s).",                          \
          "Unplug it, switch it off and on, and plug it in again.")                                \
  MESSAGE(kUsbEndpoints,                                                                           \
          "The device on USB %s calls itself a SPIDAR-G but has no bulk endpoints 0x02 and 0x86.", \
          "Switch it off and on, and plug it in again.")                                           \
  MESSAGE(kUsbMemory, "There is no memory left for USB transfers.", "Close other programs.")       \
  MESSAGE(                                                                                         \
      kUsbSilent, "The %s does not answer.",                                                       \
      "Switch it off and on, and plug it in again. If that does not help, use another USB port.")  \
  MESSAGE(kUsbRefuses, "The %s does not take commands.",                                           \
          "Switch it off and on, and plug it in again.")                                           \
  MESSAGE(kUsbOld, "A USB 1 controller (0cec:0201) cannot be driven.",                             \
          "Use one for USB 2.0, a Simple or an SH4.")                                              \
  MESSAGE(kUsbSwitch, "'%s' is not a position of a rotary switch.",                                \
          "Give a number from 0 to 15 (A on the switch is 10, F is 15).")                          \
  MESSAGE(kUsbSameSwitch, "Two SPIDAR-Gs have their rotary switch at %d: the %s, and the %s.",     \
          "Turn the switch of one of them, and plug it in again.")                                 \
  MESSAGE(kUsbId, "SPIDAR_USB_ID is '%s'.",                                                        \
          "Give vendor, product and model, such as 04b4:8613=simple or 04b4:8613=sh4.")            \
  MESSAGE(kUsbTimeout, "SPIDAR_USB_TIMEOUT is '%s'.",                                              \
          "Give the time that an exchange may take, 1 to 1000 ms.")                                \
  MESSAGE(kGuardian,                                                                               \
          "The guardian %s cannot be started (%s). Without a guardian the motors would keep "      \
          "their force if this program died.",                                                     \
          "Install the guardian, or name it in SPIDAR_GUARDIAN.")                                  \
  MESSAGE(kGuardianVersion, "The guardian %s has another version than libspidar.",                 \
          "Install both from the same package. Set SPIDAR_GUARDIAN only to the guardian that was " \
          "built with this library.")                                                              \
  MESSAGE(kGuardianEnded, "The guardian %s ended while it started.",                               \
          "Start the program again. If that does not help, make sure that SPIDAR_GUARDIAN names "  \
          "spidar-guardian, and that the machine has memory left ('journalctl -k').")              \
  MESSAGE(kGuardianSilent, "The guardian %s does not answer.",                                     \
          "Make sure that SPIDAR_GUARDIAN names spidar-guardian, and that no debugger stops it.")  \
  MESSAGE(kGuardianService,                                                                        \
          "The guardian service of this user does not start (%s), so this program starts the "     \
          "guardian as a helper. The helper may be killed together with this program's container " \
          "or control group.",                                                                     \
          "'systemctl --user status spidar-guardian.socket' shows the reason. If the service is "  \
          "masked, run 'systemctl --user unmask spidar-guardian.socket spidar-guardian@.service' " \
          "and 'systemctl --user restart spidar-guardian.socket'. If it has another version, "     \
          "install it and libspidar from the same package.")                                       \
  /* spidar-info, spidar-calibrate, spidar-check */                                                \
  MESSAGE(kToolOption, "%s.", "--help names the options.")                                         \
  MESSAGE(kToolArgument, "'%s' is not understood.", "--help names the options.")                   \
  MESSAGE(kToolDevice, "The device '%s' is not known.",                                            \
          "Use usb, usb:ID (its rotary switch) or sim.")                                           \
  MESSAGE(kToolSilent, "The device does not answer any more.", "Check its cable and power.")       \
  MESSAGE(kToolSameSwitch, "Another device has its switch at the same position.",                  \
          "Turn the switch of one of them, and plug it in again.")                                 \
  MESSAGE(kToolNoAnswer, "No answer: nothing has been written.",                                   \
          "Start again, and answer every question.")                                               \
  MESSAGE(kToolNumber, "'%s' is not a number.",                                                    \
          "Write a number with a decimal point, such as 20.5.")                                    \
  MESSAGE(kToolDirection, "'%s' is not one of the answers.",                                       \
          "Write one of the words in brackets.")                                                   \
  MESSAGE(kToolPullEnded,                                                                          \
          "The pull ended before the answer: the grip moved fast, its pose was unknown, or the "   \
          "guardian intervened.",                                                                  \
          "Hold the grip still, and answer again.")                                                \
  MESSAGE(kToolSlipped, "A string has slipped, so the force is off. Nothing has been written.",    \
          "Check the strings, then begin again.")                                                  \
  MESSAGE(kToolNoPull, "The motors do not pull. Nothing has been written.",                        \
          "Switch their power on, and release the emergency stop.")                                \
  MESSAGE(kToolOtherPull, "It should pull %s or %s. Nothing has been written.",                    \
          "The device stands turned, or --geometry names the geometry of another device. See "     \
          "'spidar-info --help'.")                                                                 \
  MESSAGE(kToolNoOutput, "No option says where to write the geometry.",                            \
          "Give a file, such as --output my-spidar.ini.")                                          \
  MESSAGE(kToolExists, "%s exists already.", "Choose another name, or overwrite it with --force.") \
  /* spidar-check */                                                                               \
  MESSAGE(kCheckForce, "--force must be from 0.05 to 1 N.", "0.2 N is felt and harmless.")         \
  MESSAGE(kCheckSeconds, "--seconds must be from 0.1 to 3600 s.",                                  \
          "10 s show what happens every few seconds.")                                             \
  MESSAGE(kCheckReport, "The report %s cannot be written: %s.",                                    \
          "Choose another place with --report.")                                                   \
  MESSAGE(kCheckPose, "The string lengths fit no pose.",                                           \
          "Hold the grip in the centre at the start, check that no string hangs loose, and run "   \
          "spidar-calibrate.")                                                                     \
  MESSAGE(kCheckOtherWay, "That is the opposite direction.",                                       \
          "Do not arm the device. Check that it stands upright, and run spidar-calibrate.")        \
  MESSAGE(                                                                                         \
      kCheckForceOff, "The strings cannot give that force here.",                                  \
      "Hold the grip in the centre at the start. If that does not help, run spidar-calibrate.")    \
  MESSAGE(                                                                                         \
      kCheckGuardian, "The guardian has not taken the force off.",                                 \
      "Do not use this device with a force. Report it with the output of spidar-check --report.")  \
  MESSAGE(kCheckLate, "That is too late.",                                                         \
          "Close other programs, let the user have real-time priority, and run the check again. "  \
          "If that does not help, report it with the output of spidar-check --report.")            \
  MESSAGE(                                                                                         \
      kCheckDefect, "This breaks a promise of libspidar.",                                         \
      "Do not use this device with a force. Report it with the output of spidar-check --report.")  \
  /* The machine: a verdict, when, and what follows */                                             \
  MESSAGE(kMachineNoPriority, "%s: %s without real-time priority came %.1f ms late, %s.",          \
          "Install rtkit, or allow real-time priority with the line \"@plugdev - rtprio 60\" in "  \
          "/etc/security/limits.d/spidar.conf, and log in again.")                                 \
  MESSAGE(kMachineLate, "%s: %s with real-time priority came %.1f ms late, %s.",                   \
          "Switch power saving off, choose a kernel with PREEMPT, and do not use a virtual "       \
          "machine.")                                                                              \
  MESSAGE(kMachineSlowUsb, "%s: an exchange with the device takes %.1f ms, %s.",                   \
          "Plug the device into a port of the machine itself, without a hub or a network.")        \
  /* spidar-emulator */                                                                            \
  MESSAGE(kEmulatorOption, "%s.", "See --help.")                                                   \
  MESSAGE(kEmulatorArgument, "'%s' is not an option.", "See --help.")                              \
  MESSAGE(kEmulatorPort, "--port must be from 0 to 65535.", "Give a number in this range.")        \
  MESSAGE(kEmulatorUnits, "There may be at most 8 units.", "Give fewer --controller options.")     \
  MESSAGE(kEmulatorModel, "--controller %s is not known. Known controllers are simple and sh4.",   \
          "Give one of these.")                                                                    \
  MESSAGE(kEmulatorSwitch, "--controller %s: the rotary switch has the positions 0 to 15.",        \
          "Give such a number after the colon.")                                                   \
  MESSAGE(kEmulatorLog, "The log '%s' cannot be written (%s).", "Give another --log.")             \
  MESSAGE(kEmulatorAddress, "'%s' is not an address to listen on.",                                \
          "Give a number like 127.0.0.1 or 0.0.0.0 or ::1.")                                       \
  MESSAGE(kEmulatorListen, "Cannot listen on %s port %d (%s).",                                    \
          "Give another --port or --listen.")                                                      \
  MESSAGE(kEmulatorControl, "Cannot make the control socket '%s' (%s).",                           \
          "Remove it if nobody uses it, or give another --control.")                               \
  MESSAGE(kEmulatorCommand, "'%s': %s. Known commands are:\n%s", "Write one of these lines.")

namespace spidar::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
SPIDAR_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace spidar::messages
