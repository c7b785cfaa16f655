// SPDX-License-Identifier: LGPL-2.1-or-later
// Every message that this room shows a user, with its cure. docs/troubleshooting.md is made from
// it.
#pragma once

// MESSAGE(name, text, cure): printf formats; the cure takes no arguments.
// clang-format off
#define TRACK_ELEMENT_MESSAGES(MESSAGE) \
  MESSAGE(kTrackIsDamaged, \
          "A part of the haptic track is damaged and was left out. Further parts are only counted (stats).", \
          "The rest is felt. On a network, give the receiver a larger latency.") \
  MESSAGE(kTrackHasForeignKlv, \
          "The stream has KLV that is not a haptic track and was left out.", \
          "If nothing is felt, choose another stream of the file.") \
  MESSAGE(kTrackHasForeignText, \
          "The stream has text that is not a haptic track and was left out.", \
          "If nothing is felt, choose another stream of the file.") \
  MESSAGE(kTrackIsOfLaterVersion, \
          "A later version wrote the haptic track. The parts that this version does not know are " \
          "left out.", \
          "Update this machine.") \
  MESSAGE(kTrackIsOfOtherKind, \
          "The haptic track has samples of a kind that this version does not know. They were left " \
          "out.", \
          "Update this machine.") \
  MESSAGE(kTrackHasNoTimes, \
          "Some samples of the haptic track have no time stamp. The times inside the samples are " \
          "used.", \
          "Nothing needs to be done.") \
  MESSAGE(kTrackIsUntied, \
          "The haptic track has lost its time stamps, so nothing ties it to the picture. Samples " \
          "without a time are not felt.", \
          "Copy the original again. Put hapticmark behind its muxer first, or use another program " \
          "than ffmpeg.") \
  MESSAGE(kTrackLostFields, \
          "Motion fields were lost. The fields around them are felt.", \
          "On a network, give the receiver a larger latency.") \
  MESSAGE(kTrackLayoutIsRefused, \
          "The haptic track holds motion %s, but the element behind hapticconvert does not accept " \
          "them.", \
          "Link an element that accepts both, such as hapticsink.") \
  MESSAGE(kTrackFieldsInHmpg, \
          "The haptic track holds motion fields of the whole frame, but MPEG haptics can hold the motion of one " \
          "point only.", \
          "Convert to KLV or text.") \
  MESSAGE(kHmpgIsDamaged, \
          "A part of the MPEG haptics stream is damaged and was left out: %s.", \
          "The rest is felt. Get the file or the stream again.") \
  MESSAGE(kHmpgIsUnsupported, \
          "The MPEG haptics stream has parts that give no force here, or another force than their " \
          "curve.", \
          "The rest is felt. haptic-track info names these parts. Write them as Force with linear, " \
          "cubic or Akima curves.") \
  MESSAGE(kHmpgIsNoUnit, \
          "A buffer does not hold one unit of MPEG haptics.", \
          "Put hmpgparse before rtphmpgpay.") \
  MESSAGE(kRtpSecondSender, \
          "A second sender, %s (SSRC %08x), sends to the same port. It is left out.", \
          "End one of the two senders, or give each sender its own port.") \
  MESSAGE(kRtpOtherPayload, \
          "The sender sends payload type %d, but this receiver takes type %d. Nothing is received.", \
          "Give receive.sh the file that send.sh --sdp writes, or start send.sh without --track hmpg.") \
  MESSAGE(kRtpbinIsMissing, \
          "GStreamer does not find the element rtpbin.", \
          "As root run: apt-get install gstreamer1.0-plugins-good.") \
  MESSAGE(kPointerIsDamaged, \
          "A buffer at the pad pointer is not a pointer, or is damaged. It was left out.", \
          "Link the stream of pointerextract to the pad, or its KLV from the network.")
// clang-format on

// Those of haptic-track.
// clang-format off
#define TRACK_TOOL_MESSAGES(MESSAGE) \
  MESSAGE(kTrackFileIsTooLarge, \
          "\"%s\": the file is too large to be a track of this form (64 MiB).", \
          "Cut it while it is a recording.") \
  MESSAGE(kTrackIsTooLong, \
          "\"%s\": there are more than %zu samples in this track.", \
          "Cut the recording first. If the recording is short, take the original: this file may be damaged.") \
  MESSAGE(kFileIsMissing, \
          "\"%s\": there is no such file.", \
          "Check the name. The path is relative to the present folder.") \
  MESSAGE(kFileIsNone, \
          "\"%s\": this is not a file.", \
          "Name a file, not a folder or a device.") \
  MESSAGE(kFileIsForbidden, \
          "\"%s\": this user may not read the file.", \
          "Change its permissions with chmod, or copy it.") \
  MESSAGE(kTrackFileIsDamaged, \
          "\"%s\": most of this file is damaged.", \
          "Take the original. This file is of another kind, or was cut.") \
  MESSAGE(kHjifIsWrong, \
          "\"%s\": byte %zu: %s.", \
          "Take the original. This file is of another kind, or was cut.") \
  MESSAGE(kContainerIsEmpty, \
          "\"%s\": there is nothing in this file.", \
          "Record or copy it again.") \
  MESSAGE(kContainerHasNoTrack, \
          "\"%s\": there is no haptic track in this file, only %s.", \
          "Take a file that record.sh or haptic-track author wrote. ffmpeg and mkvmerge drop KLV " \
          "in other containers.") \
  MESSAGE(kStreamIsNoTrack, \
          "\"%s\": the stream %s is not a haptic track, but %s is.", \
          "Choose one of the streams that haptic-track info names.") \
  MESSAGE(kTrackIsLonger, \
          "the track goes on for %.1f s after the film beside it.", \
          "Check whether it was made of this film.") \
  MESSAGE(kTrackHasOtherFrame, \
          "the track was measured in frames of %d x %d px, and the film beside it has %d x %d.", \
          "Check whether it was made of this film. If it was, its motion is felt at the right " \
          "places.") \
  MESSAGE(kTrackFormIsUnknown, \
          "\"%s\": this is no haptic track.", \
          "Known forms are .ts, .mkv, .mp4, .mov, .klv, .txt, .hmpg and .hjif.") \
  MESSAGE(kOutputFormIsUnknown, \
          "\"%s\": the form of the output is not known.", \
          "The name must end in .ts, .mkv, .klv, .txt, .hmpg, .hjif, .wav or .ahap.") \
  MESSAGE(kFilmFormIsUnknown, \
          "\"%s\": a film is cut into MPEG-TS or Matroska.", \
          "The name must end in .ts or .mkv.") \
  MESSAGE(kOutputFails, \
          "\"%s\": the file cannot be written: %s.", \
          "Choose another place, or make room on the disk.") \
  MESSAGE(kOutputHoldsPoints, \
          "\"%s\": MPEG haptics can hold the motion of one point only, and this track holds fields of the whole frame.", \
          "Write .ts, .mkv, .klv or .txt.") \
  MESSAGE(kOutputHoldsMotion, \
          "\"%s\": this form holds motion, and this track is a surface to touch.", \
          "Write .ts, .mkv, .klv or .txt.") \
  MESSAGE(kHandTouches, \
          "\"%s\": a track of points cannot hold the force that a hand feels on this surface.", \
          "Let hapticsink feel it (touch=surface, sim-hand=file:PATH) and log it " \
          "(log-location=LOG.csv).") \
  MESSAGE(kMapIsUnknown, \
          "--map knows %s, not '%s'.", \
          "Give one of these words.") \
  MESSAGE(kMapNeedsFields, \
          "--map field needs motion fields, and this track holds the motion of one point.", \
          "Leave out --map and --hand, or take a track that haptic-track author made.") \
  MESSAGE(kFileIsBeingWritten, \
          "\"%s\": another process is writing this file.", \
          "Wait until it has ended, or name another folder with --output.") \
  MESSAGE(kStreamDoesNotFit, \
          "the stream does not fit from %s to %s.", \
          "Re-encode the video as H.264.") \
  MESSAGE(kMuxerHasNoPlace, \
          "the muxer cannot hold %s.", \
          "Re-encode the video as H.264.") \
  MESSAGE(kCutNeedsMatroska, \
          "the frames of this Matroska file have no decoding times, which MPEG-TS needs.", \
          "Name an output that ends in .mkv.") \
  MESSAGE(kNoContainer, \
          "neither MPEG-TS nor Matroska can hold %s.", \
          "Re-encode the video as H.264.") \
  MESSAGE(kFrameSizeChanges, \
          "the frame's size changes from %d x %d to %d x %d after %.1f s.", \
          "Cut the video there, and author both parts.") \
  MESSAGE(kVideoIsMissing, \
          "there is no video in this file%s.", \
          "Check whether gst-play-1.0 plays it. gstreamer1.0-libav has most decoders.") \
  MESSAGE(kDecoderIsMissing, \
          "there is no %s.", \
          "Install gstreamer1.0-libav, which has most decoders.") \
  MESSAGE(kStreamsAreUnclear, \
          "its streams cannot be told apart.", \
          "Check whether gst-play-1.0 plays it.") \
  MESSAGE(kNoFrameIsDecoded, \
          "not one frame of this video can be decoded.", \
          "Check whether gst-play-1.0 plays it. gstreamer1.0-libav has most decoders.") \
  MESSAGE(kFileNamesOthers, \
          "this is a list of other files or addresses, which are not opened.", \
          "Name the video itself.") \
  MESSAGE(kOutputIsTooLong, \
          "\"%s\": the track goes on for %.1f h, and at most %.0f h are written.", \
          "Cut the track first (haptic-track cut --from --to). If it is not that long, a time in it is wrong.") \
  MESSAGE(kSoundIsTooLarge, \
          "\"%s\": %u channels of sound have room for %.0f minutes in a .wav, and the track lasts %.0f.", \
          "Cut the track first (haptic-track cut --from --to).") \
  MESSAGE(kHiddenFrames, \
          "%llu frames before the cut are shown in the copy, because the first frame after it depends on them.", \
          "Nothing needs to be done. To leave them out, re-encode the video before you cut it.") \
  MESSAGE(kFilmIsEdited, \
          "the file joins several parts of its video, or plays it at another speed (edit list).", \
          "Re-encode it: ffmpeg -i VIDEO -c:v libx264 -pix_fmt yuv420p -c:a aac NEW.mp4, and take that.") \
  MESSAGE(kFileEndsEarly, \
          "the file ends after %.1f s of %.1f s. It was not copied or recorded to its end.", \
          "Copy it again. Or repair it by a remux, and author the result.") \
  MESSAGE(kCopyIsForeign, \
          "\"%s\": this file exists and is no copy that author made.", \
          "Move it away, or name another folder with --output.") \
  MESSAGE(kCopyIsOfAnother, \
          "\"%s\": this file may be the copy of another video of the same name.", \
          "Remove the copy, rename one of the videos, or name another folder with --output.") \
  MESSAGE(kVideoHasTrack, \
          "there is a haptic track in this file already.", \
          "Play it as it is, or author the video that it was made from.") \
  MESSAGE(kElementIsMissing, \
          "GStreamer has no element %s.", \
          "Elements of this project come with its plugins (GST_PLUGIN_PATH). Other elements come " \
          "with gstreamer1.0-plugins-base, -good and -bad.") \
  MESSAGE(kGnuplotIsMissing, \
          "gnuplot is not installed.", \
          "Install the package gnuplot-nox.") \
  MESSAGE(kGnuplotRefusesName, \
          "\"%s\": gnuplot cannot write to such a name.", \
          "Give another output, without quotes.") \
  MESSAGE(kGnuplotFails, \
          "gnuplot cannot be started.", \
          "Check whether the command gnuplot works.") \
  MESSAGE(kPlotFails, \
          "\"%s\": gnuplot could not draw it.", \
          "Give another output, or make room on the disk.") \
  MESSAGE(kNoFieldIsDecoded, \
          "not one field of this track can be decoded.", \
          "Take the original: its key fields are missing.") \
  MESSAGE(kPointsDoNotMove, \
          "\"%s\": only motion fields are shown as moving pictures.", \
          "Give an output that ends in .png.") \
  MESSAGE(kPictureIsUnknown, \
          "\"%s\": the form of the picture is not known.", \
          "The name must end in .png or .gif.") \
  MESSAGE(kProcessFails, \
          "no further process can be started: %s.", \
          "Give fewer --jobs, or end other programs.") \
  MESSAGE(kCopyNamesCollide, \
          "\"%s\": its copy would have the same name as the copy of \"%s\". Nothing was written.", \
          "Rename one of them, or author them one by one into two folders (--output).") \
  MESSAGE(kProcessCrashed, \
          "\"%s\": its process ended by the signal: %s.", \
          "Run it again with fewer --jobs. If it ends again, report it to the makers of the " \
          "decoder.") \
  MESSAGE(kWorkIsInterrupted, \
          "the work was interrupted.", \
          "Run the command again to go on.") \
  MESSAGE(kFilmHasChanged, \
          "\"%s\": the video has changed since the plan was made.", \
          "Make a new plan with haptic-track author --plan.") \
  MESSAGE(kKeysAreSparse, \
          "there are up to %.0f s between two of its key frames. A chunk begins with a key frame, " \
          "so there are few chunks.", \
          "Encode it with a key frame every few seconds (ffmpeg -g 250) if more machines are to " \
          "share it.") \
  MESSAGE(kFileStandsStill, \
          "nothing was read from this file for %d s.", \
          "It is damaged or lies on a disk that does not answer. Check whether gst-play-1.0 plays it.") \
  MESSAGE(kFilmStandsStill, \
          "the film stood still for %d s, because too many frames have no sound beside them.", \
          "Let the sound begin and end with the frames, or leave the sound out (ffmpeg -i IN " \
          "-map 0:v -c copy OUT).") \
  MESSAGE(kNameIsNotUtf8, \
          "\"%s\": this name is not in UTF-8, so no plan can hold it.", \
          "Rename the file or folder (convmv -t UTF-8).") \
  MESSAGE(kPlanIsWrong, \
          "\"%s\": this is not a plan, or it was changed.", \
          "Make one with haptic-track author --plan VIDEO... > plan.json.") \
  MESSAGE(kPlanIsOfOtherVersion, \
          "\"%s\": version %s made this plan, and this is version %s.", \
          "Use one version on all machines, and make a new plan with it.") \
  MESSAGE(kChunkIsUnknown, \
          "\"%s\": there is no chunk %u in this plan, which has %zu.", \
          "The first chunk is 0.") \
  MESSAGE(kChunkIsMissing, \
          "\"%s\": this chunk is missing, number %zu of the plan.", \
          "Run haptic-track author --chunk with this number, then merge again.") \
  MESSAGE(kChunkIsDamaged, \
          "\"%s\": this chunk is damaged, number %zu of the plan.", \
          "Run haptic-track author --chunk with this number, then merge again.") \
  MESSAGE(kChunkIsForeign, \
          "\"%s\": this chunk belongs to another video or version, or has other settings than " \
          "number %zu of the plan.", \
          "Run haptic-track author --chunk with this number, then merge again.") \
  MESSAGE(kOptionNeedsNumbers, \
          "%s needs %s from %.10g to %.10g, not '%s'.", \
          "Write one such as 2, or two such as 0.5,0.25 or 5x3.") \
  MESSAGE(kOptionIsWrong, \
          "%s: %s.", \
          "--help after the verb lists its options.") \
  MESSAGE(kCommandNeedsFiles, \
          "%s needs %s.", \
          "--help after the verb explains it.") \
  MESSAGE(kOutputExists, \
          "\"%s\" exists.", \
          "Use --force to overwrite it, or give another name.") \
  MESSAGE(kTrackIsEmpty, \
          "\"%s\": there is no sample in this track.", \
          "Take another file.") \
  MESSAGE(kCutIsEmpty, \
          "\"%s\": there is no sample between these times.", \
          "Choose other times. haptic-track info shows the times of the file.") \
  MESSAGE(kLogIsWrong, \
          "\"%s\": line %zu: %s.", \
          "Take a log of hapticsink, or a table with the columns time, fx and fy (docs/formats/csv-log.md).") \
  MESSAGE(kNothingToCompare, \
          "\"%s\": there is no force between these times.", \
          "Take another file, or other --from and --to.") \
  MESSAGE(kTooLongToCompare, \
          "\"%s\": this file lasts longer than 4 hours.", \
          "Compare a part of it with --from and --to.") \
  MESSAGE(kTimesDoNotMeet, \
          "\"%s\" lasts from %.3f to %.3f s, \"%s\" from %.3f to %.3f s: they have no time in common.", \
          "Cut one of them with haptic-track cut, which lets its times begin at 0.") \
  MESSAGE(kPlacesNeedFields, \
          "neither file has fields or reliefs, so there is no place to choose.", \
          "Leave out --places and --hand.") \
  MESSAGE(kPlacesAreGiven, \
          "the place of the hand is given twice.", \
          "Use --places only with two tracks of fields or reliefs, and without --hand.") \
  MESSAGE(kKindsDiffer, \
          "\"%s\" is a surface to touch, and \"%s\" is motion, so they cannot be compared.", \
          "Compare two files of one kind. If a file holds both, choose with --stream.") \
  MESSAGE(kNoSurface, \
          "\"%s\": no relief of this track has a surface.", \
          "See haptic-track info. Then check the depth or the colours that the track was made from.") \
  MESSAGE(kNoSurfaceHere, \
          "\"%s\": there is never a surface at this place.", \
          "Name another place with --place X,Y. haptic-track info shows how much of the frame has " \
          "a surface.") \
  MESSAGE(kHandIsMissing, \
          "\"%s\": there is no hand in this file.", \
          "Name a log with the columns time, fx, fy, x and y with --hand.") \
  MESSAGE(kHoldIsWrong, \
          "--hold cannot be '%s': it needs auto, or X,Y or X,Y@SECONDS, at most %zu times.", \
          "X and Y are from 0 to 1, from the top left of the frame, as in --hold 0.4,0.6@2.5.") \
  MESSAGE(kShareIsAbove, \
          "a hand could tell the files apart in %.1f %% of the time. %.1f %% were allowed.", \
          "Use --plot FILE.png to see when.") \
  MESSAGE(kBrowserLacksVideo, \
          "\"%s\": a browser does not play %s.", \
          "Re-encode it: ffmpeg -i VIDEO -vf yadif=deint=interlaced -c:v libx264 -pix_fmt yuv420p " \
          "-force_key_frames 'expr:gte(t,n_forced*4)' -c:a aac NEW.mp4, and package the result.") \
  MESSAGE(kBrowserLacksSound, \
          "\"%s\": a browser does not play its sound, %s.", \
          "Re-encode the sound: ffmpeg -i VIDEO -c:v copy -c:a aac NEW.mp4, and package the result.") \
  MESSAGE(kFilmChanges, \
          "\"%s\": the frames change their size or format on the way.", \
          "Re-encode it: ffmpeg -i VIDEO -c:v libx264 -pix_fmt yuv420p -c:a aac NEW.mp4, and " \
          "package the result.") \
  MESSAGE(kFilmHasNoTimes, \
          "\"%s\": a frame has no time.", \
          "Give it times: ffmpeg -fflags +genpts -i VIDEO -c copy NEW.mp4, and package the result.") \
  MESSAGE(kFilmRunsBackwards, \
          "\"%s\": the frames' times do not increase after %.3f s.", \
          "Re-encode it: ffmpeg -i VIDEO -c:v libx264 -pix_fmt yuv420p -c:a aac NEW.mp4, and " \
          "package the result.") \
  MESSAGE(kFilmHasNoStart, \
          "\"%s\": a browser cannot begin to play this video, because it has no IDR frame.", \
          "Re-encode it: ffmpeg -i VIDEO -c:v libx264 -pix_fmt yuv420p -c:a copy NEW.mp4, and " \
          "package the result.") \
  MESSAGE(kFilmIsNotCut, \
          "\"%s\": it has no IDR frame for %.0f s, and segments begin with one.", \
          "Re-encode it: ffmpeg -i VIDEO -c:v libx264 -force_key_frames 'expr:gte(t,n_forced*4)' " \
          "-c:a copy NEW.mp4, and package the result.") \
  MESSAGE(kSegmentsAreLong, \
          "segments of up to %.1f s, from one IDR frame to the next, make seeking slow.", \
          "Make shorter segments: ffmpeg -i VIDEO -c:v libx264 -force_key_frames " \
          "'expr:gte(t,n_forced*4)' -c:a copy NEW.mp4, and package the result.") \
  MESSAGE(kFilmHasPoints, \
          "\"%s\": its haptic track has the motion of one point, but each viewer points elsewhere.", \
          "Package the video that it was made from.") \
  MESSAGE(kRatesDiffer, \
          "\"%s\" and \"%s\" are not one film: %s.", \
          "Name bit rates of one film that were encoded from the same frames.") \
  MESSAGE(kRatesAreNotAligned, \
          "its IDR frames are at other times than those of the first bit rate, so changing the bit " \
          "rate takes longer.", \
          "Encode all with -force_key_frames 'expr:gte(t,n_forced*4)'.") \
  MESSAGE(kFolderHoldsOther, \
          "\"%s\": this folder has another %s.", \
          "Name a new folder with --output.") \
  MESSAGE(kPlayerIsMissing, \
          "\"%s\": the web player is not there.", \
          "Install it with meson install, or name its folder in FEELING_WIND_WEB.") \
  MESSAGE(kPosterFails, \
          "no poster can be made: %s.", \
          "Check whether gst-play-1.0 plays the video. gstreamer1.0-libav has the decoder.") \
  MESSAGE(kSingleNeedsMp4, \
          "--single takes one MP4.", \
          "Make one of another video: ffmpeg -i VIDEO -c copy -movflags +faststart NEW.mp4.") \
  MESSAGE(kBundleIsMissing, \
          "\"%s\" is not there, and --single needs it.", \
          "Install esbuild and build again: apt-get install esbuild; meson setup --reconfigure build; meson compile -C build.") \
  MESSAGE(kTrackIsLarge, \
          "\"%s\": its track has %.1f MB, and a page takes 8 MB at once.", \
          "Package it without --single.") \
  MESSAGE(kPackageNeedsFolder, \
          "package needs a folder.", \
          "Name it with --output.") \
  MESSAGE(kCarriageIsUnknown, \
          "--carriage is mp4 or ts, not '%s'.", \
          "--help after the verb lists its options.") \
  MESSAGE(kCommandIsMissing, \
          "no command was given.", \
          "See --help.") \
  MESSAGE(kCommandIsUnknown, \
          "unknown command '%s'.", \
          "See --help.")
// clang-format on

#define TRACK_MESSAGES(MESSAGE) TRACK_ELEMENT_MESSAGES(MESSAGE) TRACK_TOOL_MESSAGES(MESSAGE)

namespace haptic::messages {
#define DEFINE_MESSAGE(name, text, cure) inline constexpr char name[] = text " " cure;
TRACK_MESSAGES(DEFINE_MESSAGE)
#undef DEFINE_MESSAGE
} // namespace haptic::messages
