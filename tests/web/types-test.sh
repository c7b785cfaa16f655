#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# The player's types compile, a program that uses all of them too, and they name what the player has.

source "$(dirname "$0")/../support/promise.sh"

cd "$(dirname "$0")" || exit 1
web=../../pipelines/web/player
command -v tsc >/dev/null || skip "tsc is not installed (package node-typescript)"
promise "the types and what uses them compile" tsc --noEmit --strict --lib es2020 --target es2020 --module es2020 types.ts

# The members of the interface Player are those of the class in player.js that have a name without #, be they fields.
declared() {
  sed -n '/^export interface Player /,/^}/s/^  \(readonly \)\?\([a-zA-Z]*\)[(:].*/\2/p' $web/player.d.ts | sort
}
defined() {
  sed -n '/^class Player/,/^}/s/^  \(async \|get \|set \)\?\([a-zA-Z]*\)\((.*{\| = \).*/\2/p' $web/player.js | grep -v constructor | sort -u
}
promise "they name each member of the player" diff <(declared | grep .) <(defined)
