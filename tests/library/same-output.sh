#!/usr/bin/env bash
# SPDX-License-Identifier: LGPL-2.1-or-later
# Both programs succeed and print the same.
# Usage: same-output.sh PROGRAM PROGRAM
set -euo pipefail
diff <("$1") <("$2") || {
  echo "The two programs differ: the layout of a public struct depends on the user's compiler options."
  exit 1
}
"$2" >/dev/null
