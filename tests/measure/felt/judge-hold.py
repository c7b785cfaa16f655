#!/usr/bin/python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Judges how well trackers hold points whose true way is known. Prints tables in Markdown.

The input is one of:
  films with points    NAME.mkv beside NAME.csv (docs/formats/film-points.md)
  --tap-vid FILE       a pickle of TAP-Vid (DAVIS, RGB-stacking)
  --round-trip CLIP    any video: 60 frames there, a new press, 60 frames back
"""
import argparse
import sys

import numpy

import films_with_points
import hold_metric


def read_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--run", required=True, metavar="PROGRAM", help="hold-run of the build")
    parser.add_argument("--tracker", default="hold", help="hold (default), lk, csrt, kcf, medianflow or mosse")
    parser.add_argument("--author", metavar="PROGRAM", help="haptic-track: its copies are held; --run is hold-track")
    parser.add_argument("--choose", action="store_true", help="the copies have things of the program's choice")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="follows each N-th point only (1)")
    parser.add_argument("--all-only", action="store_true", help="one row for all kinds, without the head of the table")
    parser.add_argument("--tap-vid", action="store_true", help="the files are pickles of TAP-Vid")
    parser.add_argument("--round-trip", action="store_true", help="the files are any videos")
    parser.add_argument("files", nargs="+", metavar="FILE")
    options = parser.parse_args()
    if options.every < 1:
        parser.error("--every is 1 or more")
    return options


def judge_films(options):
    tracks = []
    for film in options.files:
        if options.author:
            tracks += films_with_points.follow_authored(
                options.run, options.author, options.choose, film, options.every
            )
        else:
            tracks += films_with_points.follow_film(options.run, options.tracker, film, options.every)
    if options.all_only:
        lines = list(hold_metric.table([(options.tracker, hold_metric.summary(tracks))]))
        print(lines[-1])
        return
    print("\n".join(hold_metric.table(hold_metric.by_kind(tracks))))


def judge_tap_vid(options):
    summaries = []
    for path in options.files:
        for tracks in films_with_points.follow_tap_vid(options.run, options.tracker, path):
            summaries.append((tracks[0].kind, hold_metric.summary(tracks)))
    # As TAP-Vid does: each video counts the same.
    mean = {}
    for key in summaries[0][1]:
        known = [of[key] for _, of in summaries if not numpy.isnan(of[key])]
        mean[key] = numpy.mean(known) if known else numpy.nan
    print("\n".join(hold_metric.table([*summaries, ("**mean of the videos**", mean)])))


def judge_round_trips(options):
    print("| clip | pressed | taken, % | of these held at both ends, % | of these within 4 px, % | median, px |")
    print("|---|---|---|---|---|---|")
    for clip in options.files:
        pressed, taken, held, distances = films_with_points.round_trips(options.run, options.tracker, clip)
        percent = lambda part, whole: f"{100 * part / whole:.0f}" if whole else "–"
        median = f"{numpy.median(distances):.2f}" if held else "–"
        name = clip.rsplit("/", 1)[-1]
        within = percent((distances <= 4).sum(), held)
        print(f"| {name} | {pressed} | {percent(taken, pressed)} | {percent(held, taken)} | {within} | {median} |")


def main():
    options = read_arguments()
    try:
        if options.tap_vid:
            judge_tap_vid(options)
        elif options.round_trip:
            judge_round_trips(options)
        else:
            judge_films(options)
    except (films_with_points.Refused, OSError) as wrong:
        sys.exit(f"judge-hold.py: {wrong}")


main()
